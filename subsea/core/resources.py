"""Where shaders, assets and repertoires lie, and how settings files are read.

In a checkout they are beside the package, in an installed wheel inside it. What a visitor makes
lies in a folder of theirs.
"""

import re
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import platformdirs
from msgspec import inspect

from subsea.core.errors import UserError, nearest, unknown
from subsea.core.toml_positions import Place, is_count, key_lines, line_of, place_of, words_of

T = TypeVar("T")

MOST_BYTES = 1 << 20  # of a TOML file
# A key of so many tables within tables, or a comment that reads as one. The reader's time grows
# with the square of that.
_FAR_DOWN = re.compile(
    r"""(?<![\w-])(?:(?:[\w-]++|"(?:\\.|[^"\\\n]){0,200}+"|'[^'\n]{0,200}+')[ \t]*+\.[ \t]*+){32}"""
)

_PACKAGE = Path(__file__).parents[1]
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

    It begins with file and line, as ``reef.toml:12: ``. Each of `changes` sets one value: a key
    with its tables, by dots, entries of lists by number from 0, then = and a TOML value or a word,
    such as ``fish.0.species=fusilier``; what these are to blame for has no line.
    """
    text = _text(path)
    if far := _FAR_DOWN.search(text):
        line = text.count("\n", 0, far.start()) + 1
        raise UserError(f"{path}:{line}: not valid TOML (tables within tables, too deep)")
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as fault:
        where, what = _no_toml(str(fault), text)
        raise UserError(f"{path}:{where}: not valid TOML ({what})") from fault
    except ValueError as fault:
        raise UserError(f"{path}: not valid TOML (a number of too many digits)") from fault
    except RecursionError as fault:
        raise UserError(f"{path}: not valid TOML (tables within tables, too deep)") from fault
    for setting in changes:
        _set(content, setting)
    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as fault:
        raise _fault(str(fault), path, text, content, kind, changes) from fault


def at_key(path: Path, key: str) -> str:
    """A file and the line at which a key stands there, as ``reef.toml:12``.

    Of a key that is not there, such as ``fish[0].kind``, that of its table, if this is.
    """
    with suppress(UserError):  # it was there a moment ago
        if line := line_of(key_lines(_text(path)), place_of(key)):
            return f"{path}:{line}"
    return f"{path}"


@contextmanager
def telling_lines(content: msgspec.Struct, path: Path) -> Iterator[None]:
    """Faults found in `content` that begin with its file tell the line of their key, too.

    The key is the first one in backticks. Of what is not as the file says there is no line.
    """
    try:
        yield
    except UserError as fault:
        source, _, message = str(fault).partition(": ")
        with suppress(UserError, StopIteration):
            said = load_toml(path, type(content))
            keys = (key for key in re.findall("`([^`]+)`", message))
            key = next(key for key in keys if _at(content, place_of(key)) is not _NOTHING)
            if source.startswith(f"{path}") and _same(said, content, place_of(key)):
                source = at_key(path, key)
        raise UserError(f"{source}: {message}") from fault


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise UserError(f"{path}: larger than {MOST_BYTES >> 20} MiB, expected a smaller file")
        return data.decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")
    except (OSError, UnicodeDecodeError) as fault:
        reason = fault.strerror if isinstance(fault, OSError) else "not UTF-8 text"
        raise UserError(f"{path}: cannot read ({reason})") from fault


def _no_toml(told: str, text: str) -> tuple[int, str]:
    """The line at which a text is no TOML, and what is wrong there, as tomllib has `told`."""
    if found := re.fullmatch(r"(.*) \(at line (\d+), (column \d+)\)", told):
        return int(found[2]), f"{found[1]}, {found[3]}"
    return text.rstrip().count("\n") + 1, told


def _fault(
    told: str, path: Path, text: str, content: Any, kind: Any, changes: Sequence[str]
) -> UserError:
    """What msgspec has `told` of the content of a file after `changes`, in our words."""
    of_key = " - at `key` in `$"
    message, _, where = told.replace(of_key, " - at `$").partition(" - at `$")
    table, *inside = where.removesuffix("`").split("[...]")
    place = place_of(table)
    for rest in inside:  # within a table that may have any keys
        place = (*place, _culprit(content, kind, place), *place_of(rest))
    where = words_of(place)
    here, hint = _types_at(kind, place), ""
    if key := re.search(r"unknown field `([^`]*)`", message):
        fields = (one.encode_name for kind in here for one in getattr(kind, "fields", ()))
        hint = nearest(key[1], sorted(fields))
    for one in [] if key else here:
        if isinstance(one, inspect.DictType) and isinstance(one.key_type, inspect.LiteralType):
            hint = f"; its keys are: {', '.join(map(repr, one.key_type.values))}"
        elif isinstance(one, inspect.LiteralType):
            hint = f"; there are: {', '.join(map(repr, one.values))}"
    message = message.replace("Object contains unknown field", "unknown key")
    message = message.replace("Object missing required field", "missing key")
    before, lines = tomllib.loads(text), key_lines(text)
    blamed = place
    if of_key in told:
        blamed = *place, _culprit(content, kind, place)
    elif inner := [(*place, *place_of(word)) for word in re.findall(r"[\w.\[\]]+", message)]:
        blamed = next((one for one in inner if one in lines), place)
    source = f"{path}"
    if (line := line_of(lines, blamed)) and _same(before, content, blamed):
        source += f":{line}"
    if not _same(before, content, place):
        source = " --set ".join([source, *changes])
    return UserError(f"{source}: {message}{f', at `{where}`' if where else ''}{hint}")


def _culprit(content: Any, kind: Any, place: Place) -> str:
    """The first key of a table in `content` that alone is a fault, too."""
    table = _at(content, place)
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


_NOTHING = object()


def _at(content: Any, place: Place) -> Any:
    """What is at a place in tables and lists, or in a struct; `_NOTHING` if that is not there."""
    for step in place:
        if isinstance(step, int):
            fits = isinstance(content, list | tuple) and step < len(content)
            content = content[step] if fits else _NOTHING
        elif isinstance(content, dict):
            content = content.get(step, _NOTHING)
        else:
            content = getattr(content, step, _NOTHING)
    return content


def _same(one: Any, other: Any, place: Place) -> bool:
    """Whether both have the same at a place."""
    mine, theirs = _at(one, place), _at(other, place)
    return bool(mine == theirs) or repr(mine) == repr(theirs)  # nan does not equal itself


def _set(content: dict[str, Any], setting: str) -> None:
    """Change one value in the content of a TOML file; an entry behind a list's last is new."""
    keys, equals, text = setting.partition("=")
    steps = [step.strip() for step in keys.split(".")]
    if not equals or not all(steps):
        raise UserError(f"--set {setting}: expected KEY=VALUE such as fish.0.number=20")
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


def _types_at(kind: Any, place: Place) -> list[inspect.Type]:
    """What may be at a place of a struct; nothing where that is unknown."""
    here = _each(inspect.type_info(kind))
    for step in place:
        within = [one.type for kind in here for one in getattr(kind, "fields", ())
                  if one.encode_name == step]  # fmt: skip
        # Of lists and their like, the numbers of which are steps too.
        within += [kind.item_type for kind in here if hasattr(kind, "item_type")]
        here = [one for kind in within for one in _each(kind)]
    return here


def _each(kind: Any) -> list[Any]:
    """The types of which one is meant, without their limits, and without that of nothing."""
    if isinstance(kind, inspect.Metadata):
        return _each(kind.type)
    if isinstance(kind, inspect.UnionType):
        return [one for part in kind.types for one in _each(part)]
    return [] if isinstance(kind, inspect.NoneType) else [kind]
