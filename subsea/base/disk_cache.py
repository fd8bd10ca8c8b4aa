"""Caches of function results, on the disk and in memory, outdated by changes of the source.

For functions whose result depends on their arguments alone. A file is named after its code and
arguments, so it is never outdated; a damaged one is computed again. Files are data only: reading
one executes nothing. A wheel ships the results that its scenarios need.
"""

import hashlib
import io
import lzma
import os
import pickle
import sys
from collections import OrderedDict
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any, ParamSpec, TypeVar, get_type_hints

import numpy as np
import platformdirs

from subsea.base.arrays import pack, unpack
from subsea.base.errors import UserError
from subsea.base.files import OWN_MODE, make_own_folder, open_own, replacing
from subsea.base.progress import say
from subsea.base.source_stamp import ROOT, source_stamp

P = ParamSpec("P")
T = TypeVar("T")

SHIPPED = ROOT / "subsea" / "_data" / "kept"
MAX_BYTES = 512 << 20  # of all files; twice the need of the shipped scenarios
MOST_REMEMBERED = 160  # results in memory, each of about 1 MiB

_remembered: OrderedDict[str, Any] = OrderedDict()  # the last used at the end
_remembering = Lock()


def cache_folder() -> Path:
    """The folder of the files, in the platform's cache folder."""
    return platformdirs.user_cache_path("subsea", appauthor=False) / "kept"


def cached(make: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
    """Return ``make(*given, **named)``, from the disk if it was computed before.

    Arguments must be picklable, and the result what `subsea.base.arrays` accepts, of the
    annotated type. Without a folder that only the user may write, compute it each time.
    """
    name = cache_name(make, *given, **named)
    with suppress(LookupError):
        there: T = recall(name, get_type_hints(make).get("return", Any))
        return there
    made = make(*given, **named)
    keep(name, made)
    return made


def remembered(name: str, make: Callable[[], T]) -> T:
    """Return ``make()``, from memory if a result of this name was made a short while ago.

    `cache_name` makes the name, of all that the result depends on. Nobody may write into it.
    """
    with _remembering:
        if name in _remembered:
            _remembered.move_to_end(name)
            there: T = _remembered[name]
            return there
    made = make()
    with _remembering:
        _remembered[name] = made
        while len(_remembered) > MOST_REMEMBERED:
            _remembered.popitem(last=False)
    return made


def forget() -> None:
    """Drop all results in memory: they are of a scenario that is left."""
    with _remembering:
        _remembered.clear()


def recall(name: str, kind: Any) -> Any:
    """Read a value of a type that is shipped or was kept; LookupError if missing or damaged."""
    with suppress(Exception):  # anything unexpected counts as missing
        packed = (SHIPPED / f"{name}.xz").read_bytes()
        return unpack(memoryview(bytearray(lzma.decompress(packed))), name, kind)
    path = cache_folder() / f"{name}.data"
    if not _may_use(path.parent):
        raise LookupError(name)
    try:
        made = unpack(_content(path), name, kind)
    except Exception as fault:
        raise LookupError(name) from fault
    with suppress(OSError):  # a read-only disk
        os.utime(path)
    return made


def keep(name: str, made: Any) -> None:
    """Keep a value that `subsea.base.arrays` accepts under a name, if the disk permits."""
    path = cache_folder() / f"{name}.data"
    if not _may_use(path.parent):
        return
    data = pack(name, made)
    with suppress(UserError), replacing(path, OWN_MODE) as temporary:
        temporary.write_bytes(data)
        _make_room(path.parent)


def _content(path: Path) -> memoryview:
    """The content of a file, writable; OSError if somebody else may have written it."""
    with open_own(path) as file:
        if os.fstat(file.fileno()).st_size > MAX_BYTES:
            raise OSError(f"larger than {MAX_BYTES} bytes")
        return np.fromfile(file, np.uint8).data


def _may_use(folder: Path) -> bool:
    """True if a folder is there or can be made, and only the user may write to it."""
    try:
        make_own_folder(folder)
    except PermissionError:
        _report(folder)
        return False
    except OSError:
        return False
    return True


@cache
def _report(folder: Path) -> None:
    """Report once why nothing is cached."""
    say(f"no cache, so starts take longer: {folder} must be yours, and nobody else may write there")


def cache_name(make: Callable[..., object], *given: object, **named: object) -> str:
    """The name of a result, unique for its code and all that it depends on."""
    code = source_stamp(Path(make.__code__.co_filename).resolve())
    about = io.BytesIO()
    pickler = pickle.Pickler(about)
    pickler.fast = True  # equal arguments pickle equally, also if they share parts
    pickler.dump((sys.version_info[:2], np.__version__, given, named))
    name = hashlib.sha256(code.encode() + about.getvalue()).hexdigest()
    return f"{make.__name__}-{name[:32]}"


def _make_room(place: Path) -> None:
    """Delete the least recently used files until the others fit."""
    there = []
    for path in place.iterdir():  # partial files, too
        with suppress(OSError):  # another process may have deleted it
            about = path.stat()
            there.append((about.st_mtime, about.st_size, path))
    total = sum(one for _, one, _ in there)
    for _, one, path in sorted(there):
        if total <= MAX_BYTES:
            return
        with suppress(OSError):
            path.unlink()
        total -= one
