"""Write scenarios as readable files; change only the parts that differ.

A file is split at headers such as ``[[rock]]``. Unchanged tables keep their bytes and comments. In
changed tables single values are edited. Tables are added and removed whole.
"""

import tomllib
from contextlib import suppress
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

import msgspec

from subsea.base.errors import UserError
from subsea.base.files import read_text, replacing
from subsea.base.toml_edit import TomlPiece, edit_toml, toml_pieces, toml_value
from subsea.base.toml_files import load_toml, locate_errors
from subsea.base.toml_positions import Place
from subsea.base.validation import MISSING, convert
from subsea.scenario.checks import check_scenario
from subsea.scenario.schema import Scenario

Content = dict[str, Any]  # of a table: values that differ from the defaults

KEYS = [field.encode_name for field in msgspec.structs.fields(Scenario)]


def save_scenario(scenario: Scenario, path: Path, like: Path | None = None) -> None:
    """Write a scenario to a file from which `load_scenario` reads the same.

    `like` is the original file; its comments, order and unchanged values are preserved. The file is
    written atomically. An invalid scenario or path is a UserError.
    """
    text = scenario_text(scenario, like)
    with replacing(path) as temporary:
        temporary.write_bytes(text.encode("utf-8"))


def scenario_text(scenario: Scenario, like: Path | None = None) -> str:
    """The text that `save_scenario` writes."""
    with locate_errors(scenario, "the scenario"):
        check_scenario(scenario)
    if like is not None:
        # Write a new one if the old file is missing or cannot be edited.
        with suppress(UserError, OSError, ValueError):
            old = load_toml(like, Scenario)
            text = _edited(read_text(like), _short(old), _short(scenario))
            if _read(text) == scenario:
                return text
    text = _fresh(_short(scenario))
    try:
        _read(text)
    except UserError as fault:
        raise UserError(f"the scenario cannot be saved: {fault}") from fault
    return text


def _read(text: str) -> Scenario:
    return convert(tomllib.loads(text), Scenario)


def _short(struct: msgspec.Struct) -> Content:
    """The content of a struct without default values."""
    content: Content = {}
    for field in msgspec.structs.fields(struct):
        value = getattr(struct, field.name)
        default = field.default
        if default is msgspec.NODEFAULT and field.default_factory is not msgspec.NODEFAULT:
            default = field.default_factory()
        if field.required or value != default:
            content[field.encode_name] = _plain(value)
    return content


def _plain(value: Any) -> Any:
    if isinstance(value, msgspec.Struct):
        return _short(value)
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, list | tuple) else value


def _tables(value: Any) -> list[Content]:
    """The tables of a key, as a list."""
    return value if isinstance(value, list) else [value]


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and isinstance(value[0], dict))


def _fresh(content: Content) -> str:
    """A file without comments, its tables in the order of `Scenario`."""
    head = {key: value for key, value in content.items() if not _is_table(value)}
    parts = [_lines(head)]
    for key, value in content.items():
        if key not in head:
            parts += [_block(key, value, table) for table in _tables(value)]
    return "\n".join(parts)


def _block(key: str, value: Any, table: Content) -> str:
    """A table of the scenario with its header."""
    header = f"[[{key}]]" if isinstance(value, list) else f"[{key}]"
    return f"{header}\n{_lines(table)}"


def _lines(content: Content) -> str:
    return "".join(f"{key} = {toml_value(value)}\n" for key, value in content.items())


def _edited(text: str, old: Content, new: Content) -> str:
    """The text of the scenario `old`, changed to `new`."""
    ends = "\r\n" if text.count("\r\n") == text.count("\n") > 0 else "\n"
    head, pieces = toml_pieces(text.replace(ends, "\n"))
    in_head = tomllib.loads(head)
    for key in KEYS:
        was, now = old.get(key, MISSING), new.get(key, MISSING)
        if was == now:
            continue
        present = was if now is MISSING else now
        if key in in_head or not _is_table(present):
            before, after = ({} if one is MISSING else {key: one} for one in (was, now))
            head = edit_toml(head, before, after)
        else:
            tables = [[] if one is MISSING else _tables(one) for one in (was, now)]
            _exchange(pieces, key, tables[0], tables[1], isinstance(present, list))
    return (head + "".join(piece.text for piece in pieces)).replace("\n", ends)


def _exchange(
    pieces: list[TomlPiece], key: str, was: list[Content], now: list[Content], listed: bool
) -> None:
    """Change, remove and insert tables of a key; unchanged ones stay in place."""
    old, new = ([repr(sorted(table.items())) for table in tables] for tables in (was, now))
    places = [k for k, piece in enumerate(pieces) if piece.key == key and piece.begins]
    if len(places) != len(was):  # in an unknown notation
        places = []
    # From the last to the first, so that indices stay valid.
    for what, i, j, m, n in reversed(SequenceMatcher(None, old, new, autojunk=False).get_opcodes()):
        if what == "equal":
            continue
        both = min(j - i, n - m)
        for table in reversed(now[m + both : n]):
            before = places[i + both - 1] + 1 if i + both else _room(pieces, places, key)
            _put_in(pieces, before, TomlPiece(key, True, _block(key, [] if listed else {}, table)))
        for place in reversed(places[i + both : j]):
            _take_out(pieces, place)
        for k in reversed(range(both)):
            place = places[i + k]
            path: Place = (key, 0) if listed else (key,)
            text = edit_toml(pieces[place].text, was[i + k], now[m + k], path)
            pieces[place] = pieces[place]._replace(text=text)


def _room(pieces: list[TomlPiece], places: list[int], key: str) -> int:
    """Index for the first table of a key: before its others, or after the preceding keys."""
    if places:
        return places[0]
    order = {name: k for k, name in enumerate(KEYS)}
    earlier = [k for k, piece in enumerate(pieces) if order.get(piece.key, 0) < order[key]]
    return earlier[-1] + 1 if earlier else 0


def _put_in(pieces: list[TomlPiece], place: int, piece: TomlPiece) -> None:
    """Insert a piece with blank lines around it."""
    if place > 0:
        above = pieces[place - 1]
        text = above.text if above.text.endswith("\n") else f"{above.text}\n"
        pieces[place - 1] = above._replace(text=text)
        blank = text.endswith("\n\n")
    else:
        blank = True
    text = f"{piece.text}\n" if blank else f"\n{piece.text}"
    pieces.insert(place, piece._replace(text=text))


def _take_out(pieces: list[TomlPiece], place: int) -> None:
    """Remove a piece; for the last one also the blank line above it."""
    last = place == len(pieces) - 1
    del pieces[place]
    if last and pieces:
        pieces[-1] = pieces[-1]._replace(text=pieces[-1].text.rstrip("\n") + "\n")
