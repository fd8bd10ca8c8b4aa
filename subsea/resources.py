"""Where shaders, assets and repertoires lie, and how settings files are read.

In a checkout they are beside the package, in an installed wheel inside it. What a visitor makes
lies in a folder of theirs.
"""

import re
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import platformdirs
from msgspec import inspect

from subsea.errors import UserError, nearest, unknown

T = TypeVar("T")

_PACKAGE = Path(__file__).parent
_INSTALLED = _PACKAGE / "_data"
ROOT = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent


def resource_path(relative: str) -> Path:
    """The path of a file or folder such as ``shaders/fish.vert``."""
    return ROOT / relative


def own_path(relative: str) -> Path:
    """The path of a folder of the visitor's own, such as ``scenarios``; it need not be there."""
    return platformdirs.user_data_path("subsea", appauthor=False) / relative


def resource_names(folder: str, suffix: str) -> list[str]:
    """Sorted stems of the files in `folder` that end in `suffix`."""
    return stems(resource_path(folder), suffix)


def stems(folder: Path, suffix: str) -> list[str]:
    """Sorted stems of the files in any folder that end in `suffix`; none where it is missing."""
    return sorted(path.stem for path in folder.glob(f"[!.]*{suffix}"))


def is_path(name: str, suffix: str) -> bool:
    """Whether `name` is that of a file: a word without a slash or the suffix is not."""
    return "/" in name or "\\" in name or name.endswith(suffix)


def named_or_file(name: str, folder: str, suffix: str, kind: str) -> Path:
    """The resource `name` in `folder`, or the file at the path `name`.

    An unknown name is an error that says which are known.
    """
    if is_path(name, suffix):
        return Path(name)
    known = resource_names(folder, suffix)
    if name not in known:
        raise unknown(kind, name, known)
    return resource_path(folder) / f"{name}{suffix}"


def load_toml(path: Path, kind: type[T], changes: Sequence[str] = ()) -> T:
    """Read a TOML file as the msgspec struct `kind`; every fault is one line with file and key.

    Each of `changes` sets one value of it: a key with its tables, by dots, entries of lists
    by number from 0, then = and a TOML value or a word, such as ``fish.0.species=fusilier``.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else "not UTF-8 text"
        raise UserError(f"{path}: cannot read ({reason})") from fault
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        raise UserError(f"{path}: not valid TOML ({fault})") from fault
    for setting in changes:
        _set(content, setting)
    source = " --set ".join([str(path), *changes])
    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as fault:
        message, _, place = (
            str(fault).replace(" - at `key` in `$", " - at `$").partition(" - at `$")
        )
        place = place.removeprefix(".").removesuffix("`")
        here = _type_at(kind, place)
        hint = ""
        if key := re.search(r"unknown field `([^`]*)`", message):
            hint = nearest(key[1], sorted(one.encode_name for one in getattr(here, "fields", ())))
        elif isinstance(here, inspect.DictType) and isinstance(here.key_type, inspect.LiteralType):
            hint = f"; its keys are: {', '.join(map(repr, here.key_type.values))}"
        elif isinstance(here, inspect.LiteralType):
            hint = f"; there are: {', '.join(map(repr, here.values))}"
        message = message.replace("Object contains unknown field", "unknown key")
        message = message.replace("Object missing required field", "missing key")
        where = f", at `{place}`" if place else ""
        raise UserError(f"{source}: {message}{where}{hint}") from fault


def _set(content: dict[str, Any], setting: str) -> None:
    """Change one value in the content of a TOML file; an entry behind a list's last is new."""
    keys, equals, text = setting.partition("=")
    steps = [step.strip() for step in keys.split(".")]
    if not equals or not all(steps):
        raise UserError(f"--set {setting}: expected KEY=VALUE such as fish.0.number=20")
    value: Any = text.strip()
    with suppress(tomllib.TOMLDecodeError):
        value = tomllib.loads(f"value = {value}")["value"]
    here: Any = content
    for k, step in enumerate(steps):
        last = k == len(steps) - 1
        new = value if last else [] if steps[k + 1].isdecimal() else {}
        above = ".".join(steps[:k])
        if isinstance(here, list):
            if not step.isdecimal() or int(step) > len(here):
                expected = f"a number from 0 to {len(here)}" if here else "0"
                raise UserError(f"--set {setting}: `{above}` is a list, expected {expected} in it")
            if int(step) == len(here):
                here.append(new)
            key: Any = int(step)
        elif isinstance(here, dict):
            here.setdefault(step, new)
            key = step
        else:
            raise UserError(f"--set {setting}: `{above}` is no table, expected `{above}=VALUE`")
        if last:
            here[key] = value
        here = here[key]


def _type_at(kind: Any, place: str) -> inspect.Type | None:
    """What is expected at a place such as ``fish[0].kind`` of a struct; None where unknown."""
    here = _without_none(inspect.type_info(kind))
    for step in re.findall(r"[^.\[\]]+", place):
        if isinstance(here, inspect.StructType):
            here = next((one.type for one in here.fields if one.encode_name == step), None)
        else:  # of lists and their like, the numbers of which are steps too
            here = getattr(here, "item_type", None)
        here = _without_none(here)
    return here


def _without_none(kind: Any) -> Any:
    """The type itself of one with limits, or that may be left out."""
    if isinstance(kind, inspect.Metadata):
        return _without_none(kind.type)
    if isinstance(kind, inspect.UnionType):
        return _without_none(
            next(one for one in kind.types if not isinstance(one, inspect.NoneType))
        )
    return kind
