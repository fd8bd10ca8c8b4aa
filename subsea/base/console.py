"""Messages on the terminal."""

import sys

from subsea.base.errors import printable


def say(message: str) -> None:
    """Print a message to standard error, as one line; file names may have line breaks."""
    print(f"subsea: {printable(message)}", file=sys.stderr, flush=True)


def count_noun(number: int, one: str, many: str) -> str:
    """A number with its noun: 1 fish, 1,200 fishes."""
    return f"{number:,} {one if number == 1 else many}"
