"""What the program tells on the terminal while it works."""

import sys


def say(message: str) -> None:
    """Tell on standard error what is going on."""
    print(f"subsea: {message}", file=sys.stderr, flush=True)
