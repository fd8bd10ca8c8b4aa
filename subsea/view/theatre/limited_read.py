"""Read calibration files of limited size."""

from collections.abc import Iterator
from pathlib import Path

from subsea.core.errors import UserError


def whole(path: Path, most: int) -> bytes:
    """Read a file of at most `most` bytes; else a UserError."""
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
    except (OSError, ValueError) as fault:  # ValueError: a name with a zero byte
        reason = fault.strerror if isinstance(fault, OSError) else str(fault)
        raise UserError(f"cannot read ({reason})", file=path) from fault
    if len(data) > most:
        raise UserError(f"larger than {most // 2**20} MB, expected a smaller file", file=path)
    return data


def numbered_lines(data: bytes, where: str) -> Iterator[tuple[int, list[str]]]:
    """Number and words of each line that is not empty, without comments after ``#``."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise UserError("not text, expected lines of words and numbers", file=where) from fault
    for number, line in enumerate(text.split("\n"), 1):
        if words := line.partition("#")[0].split():
            yield number, words
