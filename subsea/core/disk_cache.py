"""What takes long to make is kept on the disk, until the code that makes it changes.

For functions whose result follows from their arguments alone. A file is never wrong, at worst it
is missing: its name tells the code and the arguments, and one that is damaged is made anew.
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
from subsea.core.source_stamp import stamp

P = ParamSpec("P")
T = TypeVar("T")

MOST_BYTES = 512 << 20  # of all files, twice what the shipped scenarios need; the longest unused go
SUM_BYTES, SIZE_BYTES = 4, 4  # of the checksum that a file begins with, and of the size after it
ALIGNED = 64  # each part begins at a multiple of so many bytes: kernels want their arrays so


def folder() -> Path:
    """Where the files lie: the platform's place for what may be deleted at any time."""
    return platformdirs.user_cache_path("subsea", appauthor=False) / "kept"


def kept(make: Callable[P, T], *given: P.args, **named: P.kwargs) -> T:
    """What ``make(*given, **named)`` returns, read from the disk if it was made before.

    Arguments and result are anything that pickles. Where nothing can be written it is made each
    time.
    """
    path = folder() / f"{name_of(make, *given, **named)}.pickle"
    with suppress(Exception):  # a pickle that is damaged may raise anything
        made: T = _unpacked(np.fromfile(path, np.uint8).data)
        with suppress(OSError):  # another's file, or a disk that is only read
            os.utime(path)
        return made
    made = make(*given, **named)
    data = _packed(made)
    with suppress(UserError), replacing(path) as temporary:
        temporary.write_bytes(data)
        _make_room(path.parent)
    return made


def _packed(made: object) -> bytearray:
    """A checksum, the sizes of what follows, then that: a pickle, and the arrays in it."""
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
    """What was packed; what is damaged is an exception of any kind."""
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


def name_of(make: Callable[P, object], *given: P.args, **named: P.kwargs) -> str:
    """The name that is for this code and these arguments, and for nothing else."""
    code = stamp(Path(make.__code__.co_filename).resolve())
    about = io.BytesIO()
    pickler = pickle.Pickler(about)
    pickler.fast = True  # equal arguments are pickled equally, whatever parts they have in common
    pickler.dump((sys.version_info[:2], np.__version__, given, named))
    name = hashlib.sha256(code.encode() + about.getvalue()).hexdigest()
    return f"{make.__name__}-{name[:32]}"


def _make_room(place: Path) -> None:
    """Delete the files that were not used for longest until all have room."""
    there = []
    for path in place.iterdir():  # also what was cut off while it was written
        with suppress(OSError):  # another process may delete it just now
            about = path.stat()
            there.append((about.st_mtime, about.st_size, path))
    total = sum(one for _, one, _ in there)
    for _, one, path in sorted(there):
        if total <= MOST_BYTES:
            return
        with suppress(OSError):
            path.unlink()
        total -= one
