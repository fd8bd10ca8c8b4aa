"""Disk cache of function results, invalidated when the source changes.

For functions whose result depends on their arguments alone. A file is named after its code and
arguments, so it is never outdated; a damaged one is computed again.
"""

import hashlib
import io
import os
import pickle
import sys
import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
import platformdirs

from subsea.core.atomic_io import replacing
from subsea.core.errors import UserError
from subsea.core.source_stamp import source_stamp

P = ParamSpec("P")
T = TypeVar("T")

MAX_BYTES = 512 << 20  # of all files; twice the need of the shipped scenarios
SUM_BYTES, SIZE_BYTES = 4, 4  # of the checksum at the start of a file, and of the size after it
ALIGNED = 64  # bytes: alignment of each part, as kernels need it for arrays


def cache_folder() -> Path:
    """The folder of the files, in the platform's cache folder."""
    return platformdirs.user_cache_path("subsea", appauthor=False) / "kept"


def cached(make: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
    """Return ``make(*given, **named)``, from the disk if it was computed before.

    Arguments and result must be picklable. Without a writable folder, compute it each time.
    """
    path = cache_folder() / f"{cache_name(make, *given, **named)}.pickle"
    with suppress(Exception):  # a damaged pickle may raise anything
        made: T = _unpacked(np.fromfile(path, np.uint8).data)
        with suppress(OSError):  # a file of another user, or a read-only disk
            os.utime(path)
        return made
    made = make(*given, **named)
    data = _packed(made)
    with suppress(UserError), replacing(path) as temporary:
        temporary.write_bytes(data)
        _make_room(path.parent)
    return made


def _packed(made: object) -> bytearray:
    """Pack as a checksum, the sizes of the parts, and the parts: a pickle and its arrays."""
    arrays: list[memoryview] = []
    head = pickle.dumps(made, 5, buffer_callback=lambda array: arrays.append(array.raw()))
    sizes = pickle.dumps([len(head), *(array.nbytes for array in arrays)])
    data = bytearray()
    first = bytes(SUM_BYTES) + len(sizes).to_bytes(SIZE_BYTES) + sizes
    for part in (memoryview(first), memoryview(head), *arrays):
        data += part
        data += bytes(-len(data) % ALIGNED)
    data[:SUM_BYTES] = zlib.crc32(memoryview(data)[SUM_BYTES:]).to_bytes(SUM_BYTES)
    return data


def _unpacked(data: memoryview) -> Any:
    """Undo `_packed`; damaged data may raise any exception."""
    if zlib.crc32(data[SUM_BYTES:]) != int.from_bytes(data[:SUM_BYTES]):
        raise ValueError("damaged")
    start = SUM_BYTES + SIZE_BYTES
    place = start + int.from_bytes(data[SUM_BYTES:start])
    parts = []
    for size in pickle.loads(data[start:place]):
        place += -place % ALIGNED
        parts.append(data[place : place + size])
        place += size
    return pickle.loads(parts[0], buffers=parts[1:])


def cache_name(make: Callable[P, object], *given: P.args, **named: P.kwargs) -> str:
    """The name of a result, unique for its code and arguments."""
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
