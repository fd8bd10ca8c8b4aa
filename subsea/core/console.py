"""What the program tells on the terminal while it works."""

import sys


def say(message: str) -> None:
    """Tell on standard error what is going on."""
    print(f"subsea: {message}", file=sys.stderr, flush=True)


def counted(number: int, one: str, many: str) -> str:
    """A number with its noun: 1 fish, 1,200 fishes."""
    return f"{number:,} {one if number == 1 else many}"
