"""The command line: `mimeline config` writes the default configuration and its schema."""

import argparse
from pathlib import Path

from mimeline import __version__
from mimeline.config import default_yaml, json_schema


def main() -> None:
    """Entry point of the `mimeline` command."""
    parser = argparse.ArgumentParser(prog="mimeline", description=__doc__)
    parser.add_argument("--version", action="version", version=f"mimeline {__version__}")
    commands = parser.add_subparsers(dest="command", required=True)
    config = commands.add_parser(
        "config", help="write config.yaml and config.schema.json from the models"
    )
    config.add_argument("folder", nargs="?", type=Path, default=Path("config"))
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    (arguments.folder / "config.yaml").write_text(default_yaml(), encoding="utf-8")
    (arguments.folder / "config.schema.json").write_text(json_schema(), encoding="utf-8")
