"""Read TOML files into msgspec structs; every error is one line with file, line and key."""

import re
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from subsea.base.errors import UserError
from subsea.base.files import read_text
from subsea.base.toml_positions import is_count, key_lines, line_of, place_of, words_of
from subsea.base.validation import same_at, violation

T = TypeVar("T")

MAX_BYTES = 1 << 20  # of a TOML file
MAX_PARTS = 32  # of a key
# A key of more nested tables, or a comment that looks like one. Parsing time grows with
# the square of their number.
_TOO_DEEP = re.compile(
    r"""(?<![\w-])(?:(?:[\w-]++|"(?:\\.|[^"\\\n]){0,200}+"|'[^'\n]{0,200}+')[ \t]*+\.[ \t]*+){32}"""
)
_TOO_DEEP_MESSAGE = "not valid TOML (tables within tables, too deep)"


def load_toml(path: Path, kind: type[T], changes: Sequence[str] = ()) -> T:
    """Read a TOML file as the msgspec struct `kind`; any error is a UserError with its location.

    Each of `changes` sets one value, such as ``fish.0.species=fusilier``: the key with its tables,
    joined by dots, with list indices from 0, then = and a TOML value or a word. An error caused by
    a change shows the changes instead of a line.
    """
    text = _read_text(path)
    if deep := _TOO_DEEP.search(text):
        raise UserError(_TOO_DEEP_MESSAGE, file=path, line=text.count("\n", 0, deep.start()) + 1)
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line, what = _syntax_error(str(error), text)
        raise UserError(f"not valid TOML ({what})", file=path, line=line) from error
    except ValueError as error:
        raise UserError("not valid TOML (a number of too many digits)", file=path) from error
    except RecursionError as error:
        raise UserError(_TOO_DEEP_MESSAGE, file=path) from error
    for setting in changes:
        _set(content, setting)
    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as error:
        found = violation(error, content, kind)
        before = tomllib.loads(text)
        place = line_of(key_lines(text), found.culprit)
        raise UserError(
            found.message,
            file=path,
            line=place if same_at(before, content, found.culprit) else None,
            key=words_of(found.culprit),
            changes=() if same_at(before, content, found.table) else changes,
        ) from error


def error_at(path: Path, key: str, message: str) -> UserError:
    """The error of a key in a TOML file, with the line of the key or of its table."""
    return UserError(message, file=path, line=_line(path, key), key=key)


@contextmanager
def locate_errors(
    content: msgspec.Struct, source: Path | str, changes: Sequence[str] = ()
) -> Iterator[None]:
    """Add `source` and the line of the key to errors about `content` that name no file.

    The line is omitted if `content` no longer matches the file `source` at that key; the error then
    shows the applied `changes` instead.
    """
    try:
        yield
    except UserError as error:
        if error.file is not None:
            raise
        line = None
        if error.key is not None:
            with suppress(UserError):
                said = load_toml(Path(source), type(content))
                if same_at(said, content, place_of(error.key)):
                    line, changes = _line(Path(source), error.key), ()
        raise UserError(
            error.message, file=source, line=line, key=error.key, changes=changes
        ) from error


def _line(path: Path, key: str) -> int | None:
    """The line of a key or of its table; None if the file has neither, or is not TOML."""
    # The file may have been deleted since, or may be another program's.
    with suppress(UserError, ValueError, RecursionError):
        text = _read_text(path)
        if not _TOO_DEEP.search(text) and tomllib.loads(text):
            return line_of(key_lines(text), place_of(key))
    return None


def _read_text(path: Path) -> str:
    return read_text(path, MAX_BYTES).replace("\r\n", "\n").replace("\r", "\n")


def _syntax_error(told: str, text: str) -> tuple[int, str]:
    """Line and reason from the message of tomllib, which has no fields before Python 3.14."""
    if found := re.fullmatch(r"(.*) \(at line (\d+), (column \d+)\)", told):
        return int(found[2]), f"{found[1]}, {found[3]}"
    return text.rstrip().count("\n") + 1, told


def _is_text(argument: str) -> bool:
    """False if an argument of a command has bytes that Python could not decode."""
    try:
        argument.encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def _set(content: dict[str, Any], setting: str) -> None:
    """Change one value in the content of a TOML file; an index just past the end appends."""
    keys, equals, text = setting.partition("=")
    steps = [step.strip() for step in keys.split(".")]
    option = f"--set {setting}"
    if not equals or not all(steps):
        raise UserError("expected KEY=VALUE such as fish.0.number=20", file=option)
    if len(steps) > MAX_PARTS:
        message = f"a key of {len(steps)} parts, expected {MAX_PARTS} at most"
        raise UserError(message, file=f"--set {'.'.join(steps[:3])}…")
    if not _is_text(setting):
        raise UserError("not text in the encoding of this terminal, expected UTF-8", file=option)
    value: Any = text.strip()
    with suppress(ValueError, RecursionError):
        value = tomllib.loads(f"value = {value}")["value"]
    here: Any = content
    for k, step in enumerate(steps):
        last = k == len(steps) - 1
        new = value if last else [] if is_count(steps[k + 1]) else {}
        above = ".".join(steps[:k])
        if isinstance(here, list):
            if not is_count(step) or int(step) > len(here):
                expected = f"a number from 0 to {len(here)}" if here else "0"
                raise UserError(f"`{above}` is a list, expected {expected} in it", file=option)
            if int(step) == len(here):
                here.append(new)
            key: Any = int(step)
        elif isinstance(here, dict):
            here.setdefault(step, new)
            key = step
        else:
            raise UserError(f"`{above}` is not a table, expected `{above}=VALUE`", file=option)
        if last:
            here[key] = value
        here = here[key]
