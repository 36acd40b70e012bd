"""What commands say, and whether in colours."""

import logging
import os
import sys


def say(text: str) -> None:
    """Print text as it is; a terminal may not have every character."""
    sys.stdout.reconfigure(errors="replace")
    print(text, end="", flush=True)


def tell(what: object) -> None:
    """Say what was done, to the person rather than to a program that reads the output."""
    print(what, file=sys.stderr, flush=True)


def formats_of(text: str) -> list[str]:
    """The formats of --to: csv,glb."""
    return [name.strip() for name in text.split(",") if name.strip()]


def show_progress() -> None:
    """Let the package's log say how far long work is, and its warnings."""
    logging.basicConfig(format="mimeline: %(message)s")
    logging.getLogger("mimeline").setLevel(logging.INFO)


def colour() -> bool:
    """Whether the terminal shows colours, and wants them."""
    return sys.stdout.isatty() and not os.environ.get("NO_COLOR")
