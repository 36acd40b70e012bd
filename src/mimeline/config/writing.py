"""The default configuration with its comments, and the schema that editors check it by."""

import json
import textwrap
from typing import Any

import yaml

from mimeline.config.section import Section
from mimeline.config.sections import Config


def default_yaml() -> str:
    """The commented default configuration."""
    lines = [
        "# yaml-language-server: $schema=config.schema.json",
        "# Written from the models in src/mimeline/config by `mimeline config`.",
    ]
    for name, field in Config.model_fields.items():
        value = field.get_default()
        if isinstance(value, Section):
            lines += ["", *_section(name, value, depth=0)]
        else:
            lines += ["", *_entry(name, value, field.description, depth=0)]
    return "\n".join(lines) + "\n"


def _section(name: str, section: Section, depth: int) -> list[str]:
    indent = "  " * depth
    about = (type(section).__doc__ or "").strip().splitlines()
    lines = [f"{indent}# {about[0]}"] if about else []
    lines.append(f"{indent}{name}:")
    for key, field in type(section).model_fields.items():
        value = getattr(section, key)
        if isinstance(value, Section):
            lines += _section(key, value, depth + 1)
        else:
            lines += _entry(key, value, field.description, depth + 1)
    return lines


def _entry(key: str, value: Any, about: str, depth: int) -> list[str]:
    indent = "  " * depth
    comment = [f"{indent}# {line}" for line in textwrap.wrap(about, 96 - len(indent))]
    dumped = yaml.safe_dump(value, default_flow_style=True, width=10_000).strip()
    return [*comment, f"{indent}{key}: {dumped.removesuffix('...').strip()}"]


def json_schema() -> str:
    """The configuration's JSON schema, for editors."""
    return json.dumps(Config.model_json_schema(), indent=2, ensure_ascii=False) + "\n"
