"""What commands say, and whether in colours."""

import os
import sys


def say(text: str) -> None:
    """Print text as it is; a terminal may not have every character."""
    sys.stdout.reconfigure(errors="replace")
    print(text, end="", flush=True)


def colour() -> bool:
    """Whether the terminal shows colours, and wants them."""
    return sys.stdout.isatty() and not os.environ.get("NO_COLOR")
