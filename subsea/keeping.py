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
from typing import ParamSpec, TypeVar

import numpy as np
import platformdirs

from subsea.caching import stamp
from subsea.errors import UserError
from subsea.places import replacing

P = ParamSpec("P")
T = TypeVar("T")

MOST_BYTES = 256 << 20  # of all files; those that were not used for longest go first
SUM_BYTES = 4  # of the checksum that a file begins with


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
        data = path.read_bytes()
        if zlib.crc32(memoryview(data)[SUM_BYTES:]) == int.from_bytes(data[:SUM_BYTES], "big"):
            made: T = pickle.loads(memoryview(data)[SUM_BYTES:])
            with suppress(OSError):  # another's file, or a disk that is only read
                os.utime(path)
            return made
    made = make(*given, **named)
    data = pickle.dumps(made, pickle.HIGHEST_PROTOCOL)
    with suppress(UserError), replacing(path) as temporary:
        with temporary.open("wb") as file:
            file.write(zlib.crc32(data).to_bytes(SUM_BYTES, "big"))
            file.write(data)
        _make_room(path.parent)
    return made


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
