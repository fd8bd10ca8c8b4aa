"""Where shaders, assets and repertoires lie, and how settings files are read.

In a checkout they are beside the package, in an installed wheel inside it.
"""

import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from subsea.errors import UserError, nearest, unknown

T = TypeVar("T")

_PACKAGE = Path(__file__).parent
_INSTALLED = _PACKAGE / "_data"
ROOT = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent


def resource_path(relative: str) -> Path:
    """The path of a file or folder such as ``shaders/fish.vert``."""
    return ROOT / relative


def resource_names(folder: str, suffix: str) -> list[str]:
    """Sorted stems of the files in `folder` that end in `suffix`."""
    return sorted(path.stem for path in resource_path(folder).glob(f"*{suffix}"))


def named_or_file(name: str, folder: str, suffix: str, kind: str) -> Path:
    """The resource `name` in `folder`, or the file at the path `name`.

    A word without a slash or the suffix is a name; an unknown one is an error that says which
    are known.
    """
    if "/" in name or "\\" in name or name.endswith(suffix):
        return Path(name)
    known = resource_names(folder, suffix)
    if name not in known:
        raise unknown(kind, name, known)
    return resource_path(folder) / f"{name}{suffix}"


def load_toml(path: Path, kind: type[T]) -> T:
    """Read a TOML file as the msgspec struct `kind`; every fault is one line with file and key."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else "not UTF-8 text"
        raise UserError(f"{path}: cannot read ({reason})") from fault
    try:
        return msgspec.convert(tomllib.loads(text), kind)
    except tomllib.TOMLDecodeError as fault:
        raise UserError(f"{path}: not valid TOML ({fault})") from fault
    except msgspec.ValidationError as fault:
        message = str(fault).replace(" - at `$.", ", at `").replace(" - at `$`", "")
        key = re.search(r"unknown field `([^`]*)`", message)
        hint = nearest(key[1], sorted(_field_names(kind))) if key else ""
        message = message.replace("Object contains unknown field", "unknown key")
        message = message.replace("Object missing required field", "missing key")
        raise UserError(f"{path}: {message}{hint}") from fault


def _field_names(kind: Any) -> set[str]:
    """The names of all keys in a struct and the structs inside it."""
    names: set[str] = set()
    for field in msgspec.structs.fields(kind):
        names.add(field.encode_name)
        for inner in (field.type, *getattr(field.type, "__args__", ())):
            if isinstance(inner, type) and issubclass(inner, msgspec.Struct):
                names |= _field_names(inner)
    return names
