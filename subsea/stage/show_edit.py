"""Edit the file of a show while it runs: keys of items, and special days.

Comments and all that is not edited stay. A file is replaced only by one that can be played.
"""

import tomllib
from pathlib import Path
from typing import Any

import msgspec

from subsea.base.errors import UserError
from subsea.base.files import read_text, replacing
from subsea.base.system import resource_path
from subsea.base.toml_edit import edit_toml, toml_value
from subsea.base.validation import convert
from subsea.stage.opening_hours import SpecialDay
from subsea.stage.show_file import SHIPPED, Show, faults, load_show

EDITED = ("start", "for_s", "caption", "caption_s", "fade_s", "tour", "days")  # keys of items
TEXTS = ("start", "caption", "tour")


def edit_item(path: Path, number: int, key: str, text: str) -> Show:
    """Set a key of an item to a text, number, list or table; an empty text removes the key."""
    if key not in EDITED:
        raise UserError(f"`{key}` cannot be edited here, expected {', '.join(EDITED)}")
    content = _content(path)
    if not 0 <= number < len(content["item"]):
        raise UserError(f"item {number + 1}: expected 1 to {len(content['item'])}")
    old = content["item"][number]
    new = {name: value for name, value in old.items() if name != key}
    if text:
        new[key] = text if key in TEXTS and not text.startswith("{") else _value(text)
    return _replaced(path, edit_toml(read_text(path), old, new, ("item", number), path))


def add_special_day(path: Path, day: SpecialDay) -> Show:
    """Add a special day at the end of the file."""
    _content(path)
    lines = ["", "[[special_day]]"]
    for key, value in msgspec.structs.asdict(day).items():
        if value not in (None, "") and (key, value) != ("days", 1):
            lines.append(f"{key} = {toml_value(value)}")
    return _replaced(path, read_text(path).rstrip("\n") + "\n" + "\n".join(lines) + "\n")


def special_day(when: str, title: str, hours: str, days: int) -> SpecialDay:
    """Make a special day of texts: a date such as 2026-12-24, or 12-24 for each year."""
    spans = [one.strip() for one in hours.split(",") if one.strip()]
    content: dict[str, Any] = {
        "title": title, "days": days, "hours": spans[0] if len(spans) == 1 else spans,
        "yearly" if len(when) <= 5 else "date": when,
    }  # fmt: skip
    return convert(content, SpecialDay)


def remove_special_day(path: Path, number: int) -> Show:
    """Remove a special day, counted from 0."""
    import tomlkit

    days = _content(path).get("special_day", [])
    if not 0 <= number < len(days):
        raise UserError(f"special day {number + 1}: expected 1 to {len(days)}")
    document: Any = tomlkit.parse(read_text(path))
    del document["special_day"][number]
    return _replaced(path, tomlkit.dumps(document))


def _content(path: Path) -> dict[str, Any]:
    """The content of the file of a show that may be edited."""
    if path.resolve().is_relative_to(resource_path(SHIPPED).resolve()):
        raise UserError("a shipped show cannot be edited: copy it to a file of your own", file=path)
    load_show(path)  # somebody may have broken it meanwhile
    return tomllib.loads(read_text(path))


def _value(text: str) -> Any:
    """Read a TOML value; anything else is a text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except ValueError:
        return text


def _replaced(path: Path, text: str) -> Show:
    """Write the file and read it; a UserError, and the old file, for what cannot be played."""
    before = dict(faults(load_show(path), path))
    try:
        with replacing(path) as part:
            part.write_text(text, encoding="utf-8")
            show = load_show(part)
            for number, fault in faults(show, path):
                if number not in before:
                    raise UserError(fault.message)
    except UserError as fault:
        raise UserError(fault.message) from fault
    return show
