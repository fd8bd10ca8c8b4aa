"""Check content against a msgspec type, and find the faulty key.

msgspec gives no data on a failure, only a sentence. No other module parses it.
"""

import re
from contextlib import suppress
from typing import Any, NamedTuple, TypeVar

import msgspec
from msgspec import inspect

from subsea.base.errors import UserError, nearest
from subsea.base.toml_positions import Place, place_of, words_of

T = TypeVar("T")
MISSING = object()
NOUNS = {
    "int": "a whole number",
    "float": "a number",
    "str": "text",
    "bool": "true or false",
    "object": "a table",
    "array": "a list",
    "date": "a date",
    "datetime": "a date and time",
    "time": "a time",
}
PHRASES = {
    "Object contains unknown field": "unknown key",
    "Object missing required field": "missing key",
    "Invalid enum value": "unknown value",
    "Invalid value": "unknown value",
    "Integer value out of range": "number out of range",
    "Number out of range": "number out of range",
}
LIMITS = {
    r"^ >= (\S+?)(\.0)?$": r" of at least \1",
    r"^ <= (\S+?)(\.0)?$": r" of at most \1",
    r"^ > (\S+?)(\.0)?$": r" above \1",
    r"^ < (\S+?)(\.0)?$": r" below \1",
    r"^ of (?:at least length|length >=) (\d+)$": r" of at least \1 UNIT",
    r"^ of (?:at most length|length <=) (\d+)$": r" of at most \1 UNIT",
    r"^ of length (\d+)( to \d+)?$": r" of \1\2 UNIT",
    r"^ matching regex ": " that matches ",
}
_OF_KEY = " - at `key` in `$"  # msgspec's mark for a faulty key rather than its value


class Violation(NamedTuple):
    """The reason why content does not fit its type."""

    message: str  # with the location and a hint at the right name
    table: Place  # the location that msgspec reports
    culprit: Place  # the faulty key, or `table` if unknown


def convert(content: Any, kind: type[T]) -> T:
    """Build the msgspec struct `kind` from tables and lists; a UserError has the faulty key."""
    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as error:
        found = violation(error, content, kind)
        raise UserError(found.message, key=words_of(found.culprit)) from error


def violation(error: msgspec.ValidationError, content: Any, kind: Any) -> Violation:
    """The violation that msgspec found in `content`, in our words."""
    told = str(error)
    message, _, where = told.replace(_OF_KEY, " - at `$").partition(" - at `$")
    table, *inside = where.removesuffix("`").split("[...]")
    place = place_of(table)
    for rest in inside:  # in a table with arbitrary keys
        place = (*place, _faulty_key(content, kind, place), *place_of(rest))
    types, hint = _types_at(kind, place), ""
    if key := re.search(r"unknown field `([^`]*)`", message):
        fields = (field.encode_name for one in types for field in getattr(one, "fields", ()))
        hint = nearest(key[1], sorted(fields))
    for one in [] if key else types:
        if isinstance(one, inspect.DictType) and isinstance(one.key_type, inspect.LiteralType):
            hint = f"; its keys are: {', '.join(map(repr, one.key_type.values))}"
        elif isinstance(one, inspect.LiteralType):
            hint = f"; there are: {', '.join(map(repr, one.values))}"
    culprit = place
    if _OF_KEY in told:
        culprit = *place, _faulty_key(content, kind, place)
    else:
        named = ((*place, *place_of(word)) for word in re.findall(r"[\w.\[\]]+", message))
        culprit = next((one for one in named if value_at(content, one) is not MISSING), place)
    where = f", at `{words_of(place)}`" if place else ""
    value = MISSING if culprit != place else value_at(content, place)
    return Violation(f"{plain_words(message, value)}{where}{hint}", place, culprit)


def plain_words(message: str, value: Any = MISSING) -> str:
    """A message of msgspec without names of types; with the faulty scalar `value`, if given."""
    for theirs, ours in PHRASES.items():
        message = message.replace(theirs, ours)
    expected = re.fullmatch(r"Expected `([^`]+)`(.*?)(?:, got (.*))?", message)
    if expected is None:
        return message
    kinds, limit, got = expected.groups()
    nouns = [NOUNS.get(kind, kind) for kind in kinds.split(" | ") if kind != "null"]
    unit = {"array": "values", "str": "characters"}.get(kinds.partition(" | ")[0], "entries")
    for pattern, words in LIMITS.items():
        limit = re.sub(pattern, words.replace("UNIT", unit), limit)
    found = NOUNS.get((got or "").strip("`"), got)
    if isinstance(value, bool):
        found = str(value).lower()
    elif isinstance(value, int | float | str):
        found = repr(value)
    return f"expected {' or '.join(nouns)}{limit}" + (f", got {found}" if found else "")


def value_at(content: Any, place: Place) -> Any:
    """The value of a key in tables, lists and structs; `MISSING` if it does not exist."""
    for step in place:
        if isinstance(step, int):
            fits = isinstance(content, list | tuple) and step < len(content)
            content = content[step] if fits else MISSING
        elif isinstance(content, dict):
            content = content.get(step, MISSING)
        else:
            content = (
                getattr(content, step, MISSING) if isinstance(content, msgspec.Struct) else MISSING
            )
    return content


def same_at(one: Any, other: Any, place: Place) -> bool:
    """True if two contents have the same value of a key."""
    mine, theirs = value_at(one, place), value_at(other, place)
    return bool(mine == theirs) or repr(mine) == repr(theirs)  # nan does not equal itself


def _faulty_key(content: Any, kind: Any, place: Place) -> str:
    """The first key of a table in `content` that is faulty even on its own."""
    table = value_at(content, place)
    entries = dict(table)
    try:
        for key, value in entries.items():
            table.clear()
            table[key] = value
            with suppress(msgspec.ValidationError):
                msgspec.convert(content, kind)
                continue
            return key
    finally:
        table.clear()
        table.update(entries)
    return next(iter(entries))


def _types_at(kind: Any, place: Place) -> list[inspect.Type]:
    """The types allowed for a key of a struct; empty if unknown."""
    here = _alternatives(inspect.type_info(kind))
    for step in place:
        within = [field.type for one in here for field in getattr(one, "fields", ())
                  if field.encode_name == step]  # fmt: skip
        within += [one.item_type for one in here if hasattr(one, "item_type")]  # lists
        here = [alternative for one in within for alternative in _alternatives(one)]
    return here


def _alternatives(kind: Any) -> list[Any]:
    """The members of a union without None, without their limits."""
    if isinstance(kind, inspect.Metadata):
        return _alternatives(kind.type)
    if isinstance(kind, inspect.UnionType):
        return [one for part in kind.types for one in _alternatives(part)]
    return [] if isinstance(kind, inspect.NoneType) else [kind]
