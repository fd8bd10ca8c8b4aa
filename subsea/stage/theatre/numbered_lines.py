"""Split calibration files into numbered lines of words."""

from collections.abc import Iterator

from subsea.base.errors import UserError


def numbered_lines(data: bytes, where: str) -> Iterator[tuple[int, list[str]]]:
    """Number and words of each line that is not empty, without comments after ``#``."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise UserError("not text, expected lines of words and numbers", file=where) from fault
    for number, line in enumerate(text.split("\n"), 1):
        if words := line.partition("#")[0].split():
            yield number, words
