"""Change values in a TOML text and leave all other bytes unchanged."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from subsea.base.errors import UserError
from subsea.base.toml_positions import Place
from subsea.base.validation import MISSING

Content = Mapping[str, Any]  # of a table, as tomllib reads it; lists may be tuples

MAX_LINE = 100  # characters; a longer list of tables or lists has one of them per line
_HEADER = re.compile(r"\s*(\[\[?)\s*([A-Za-z0-9_-]+)(\s*\.[^\]]*)?\]\]?\s*(#.*)?")


class TomlPiece(NamedTuple):
    """Lines of a file: a header, its keys, and the comments just above."""

    key: str  # of the table, or of that around it
    begins: bool  # True if its header starts a table at the top, not a nested one
    text: str


def toml_pieces(text: str) -> tuple[str, list[TomlPiece]]:
    """Split a text into the part before the first header, and one piece per table."""
    lines = text.splitlines(keepends=True)
    cuts = []
    for k, line in enumerate(lines):
        if header := _HEADER.fullmatch(line.rstrip("\n")):
            begin = k
            while begin > 0 and lines[begin - 1].lstrip().startswith("#"):
                begin -= 1
            cuts.append((begin, header[2], header[3] is None))
    starts = [begin for begin, _, _ in cuts]
    pieces: list[TomlPiece] = []
    for (begin, key, begins), end in zip(cuts, [*starts[1:], len(lines)], strict=True):
        piece = TomlPiece(key, begins, "".join(lines[begin:end]))
        if not begins and pieces and pieces[-1].key == key:
            pieces[-1] = pieces[-1]._replace(text=pieces[-1].text + piece.text)
        else:
            pieces.append(piece)
    return "".join(lines[: starts[0] if starts else len(lines)]), pieces


def edit_toml(
    text: str, old: Content, new: Content, table: Place = (), file: Path | None = None
) -> str:
    """Change the table at the key `table` of a TOML text from `old` to `new`.

    Only keys that differ between `old` and `new` are changed, so both may omit the others. A text
    that cannot be edited is a UserError about `file`.
    """
    import tomlkit  # slow to import, and few commands need it
    from tomlkit.exceptions import TOMLKitError

    # Blank lines and comments at the end are set aside: new keys go before them.
    lines = text.splitlines(keepends=True)
    end = len(lines)
    while end > 0 and (not lines[end - 1].strip() or lines[end - 1].lstrip().startswith("#")):
        end -= 1
    if end and not lines[end - 1].endswith("\n"):
        lines[end - 1] += "\n"
    try:
        document: Any = tomlkit.parse("".join(lines[:end]))
        here = document
        for step in table:
            here = here[step]
        _change(here, _plain(old), _plain(new))
        return tomlkit.dumps(document) + "".join(lines[end:])
    except TOMLKitError as error:
        raise UserError(f"its tables cannot be edited ({error})", file=file) from error


def toml_value(value: Any) -> str:
    """Write a value in TOML, tables inline."""
    import tomlkit

    if isinstance(value, list | tuple):
        parts = [toml_value(one) for one in value]
        line = f"[{', '.join(parts)}]"
        if len(line) > MAX_LINE and isinstance(value[0], dict | list | tuple):
            return "[\n" + "".join(f"    {part},\n" for part in parts) + "]"
        return line
    if isinstance(value, dict):
        keys = [tomlkit.key(key).as_string() for key in value]  # quoted where they must be
        values = [toml_value(one) for one in value.values()]
        pairs = [f"{key} = {text}" for key, text in zip(keys, values, strict=True)]
        return f"{{ {', '.join(pairs)} }}"
    text: str = tomlkit.item(value).as_string()
    return text


def _plain(value: Any) -> Any:
    """Tuples as lists, so that they equal parsed values."""
    if isinstance(value, Mapping):
        return {key: _plain(one) for key, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, list | tuple) else value


def _change(table: Any, old: Content, new: Content) -> None:
    """Set the values of a tomlkit table that differ."""
    for key in {**old, **new}:
        before, after = old.get(key, MISSING), new.get(key, MISSING)
        if before == after:
            continue
        if after is MISSING:
            table.pop(key, None)
        else:
            _set(table, key, before, after)


def _set(container: Any, key: Any, old: Any, new: Any) -> None:
    """Set one value of a tomlkit table or array; in lists and tables, only the differences."""
    import tomlkit
    from tomlkit.items import AoT, InlineTable

    present = isinstance(key, int) or key in container
    there = container[key] if present else None
    lists = present and isinstance(old, list) and isinstance(new, list) and len(old) == len(new)
    tables = present and isinstance(old, dict) and isinstance(new, dict)
    if lists:
        for k, (one, other) in enumerate(zip(old, new, strict=True)):
            if one != other:
                _set(there, k, one, other)
    elif tables and (old.keys() == new.keys() or not isinstance(there, InlineTable)):
        _change(there, old, new)
    elif isinstance(there, AoT) or (isinstance(new, dict) and _has_headers(container)):
        container[key] = tomlkit.item(new)
    else:
        container[key] = tomlkit.parse(f"value = {toml_value(new)}\n")["value"]


def _has_headers(container: Any) -> bool:
    """True if the tables in a tomlkit table have their own headers; new ones follow suit."""
    from tomlkit.items import Table

    if not isinstance(container, Table):
        return False
    body = container.value.body
    return any(isinstance(one, Table) and not (key and key.is_dotted()) for key, one in body)
