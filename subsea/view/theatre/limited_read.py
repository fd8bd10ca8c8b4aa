"""Files of calibration data as bytes, of a size that they may have."""

from collections.abc import Iterator
from pathlib import Path

from subsea.core.errors import UserError


def whole(path: Path, most: int) -> bytes:
    """All bytes of a file of at most `most` bytes; else a UserError that names it."""
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
    except (OSError, ValueError) as fault:  # a ValueError: a name with a zero byte
        reason = fault.strerror if isinstance(fault, OSError) else str(fault)
        raise UserError(f"cannot read ({reason})", file=path) from fault
    if len(data) > most:
        raise UserError(f"larger than {most // 2**20} MB, expected a smaller file", file=path)
    return data


def numbered_lines(data: bytes, where: str) -> Iterator[tuple[int, list[str]]]:
    """The words of each line that has any, with its number; text after ``#`` is left out."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise UserError("not text, expected lines of words and numbers", file=where) from fault
    for number, line in enumerate(text.split("\n"), 1):
        if words := line.partition("#")[0].split():
            yield number, words
