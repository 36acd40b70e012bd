"""What a run was told: its configuration, and the command that goes on with it."""

import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from mimeline.atomic import whole

NAME = "run.json"
DEFAULT = "config/config.yaml"


@dataclass(frozen=True)
class Run:
    """A run's configuration, complete, and how it was given.

    files: of --configfile, over config/config.yaml. given: of --config, over both.
    """

    config: dict[str, Any]
    files: tuple[str, ...] = ()
    given: tuple[str, ...] = ()

    @property
    def file(self) -> str:
        """The file to change a key in."""
        return self.files[-1] if self.files else DEFAULT

    def command(self, *options: str, **changed: Mapping[str, Any]) -> str:
        """The command that goes on with the run.

        options: such as --forcerun fetch. changed: keys by section, such as
        select={"exclusions": "mine.csv"}; they join those that were given before.
        """
        given = []
        for text in self.given:
            section, _, told = text.partition("=")
            keys = changed.pop(section, None)
            given.append(f"{section}={_flow(yaml.safe_load(told) | keys)}" if keys else text)
        given += [f"{section}={_flow(keys)}" for section, keys in changed.items()]
        words = ["snakemake", "--cores", "2", *options]
        words += ["--configfile", *self.files] if self.files else []
        words += ["--config", *given] if given else []
        return shlex.join(words)


def remember(
    results: Path, config: dict[str, Any], files: Sequence[Path], given: Sequence[str]
) -> None:
    """Write what the run was told into its results. config: the complete one."""
    here = Path.cwd()
    told = [str(f.relative_to(here) if f.is_relative_to(here) else f) for f in map(Path, files)]
    content = {"config": config, "files": told, "given": list(given)}
    with whole(Path(results) / NAME) as path:
        path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _flow(keys: Mapping[str, Any]) -> str:
    return yaml.safe_dump(dict(keys), default_flow_style=True, sort_keys=False, width=10**6).strip()


def recall(results: Path) -> Run:
    """What the run was told that made the results; nothing where that is not known."""
    try:
        content = json.loads((Path(results) / NAME).read_text(encoding="utf-8"))
        files, given = map(str, content["files"]), map(str, content["given"])
        return Run(dict(content["config"]), tuple(files), tuple(given))
    except (OSError, ValueError, KeyError, TypeError):
        return Run({})
