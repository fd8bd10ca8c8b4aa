"""Where results go: asked before the work, written whole or not at all."""

import os
import re
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from subsea.core.errors import UserError

FORGOTTEN_S = 86400.0  # so old a part is nobody's any more
PART = re.compile(r"\.\d+\.part(\.\w+)?$")  # the number of a process; and what a library adds


def is_folder(path: Path) -> bool:
    """Whether a folder called `path` is there; a name that no file can have is a UserError."""
    try:
        return path.is_dir()
    except OSError as fault:
        raise UserError(f"{fault.strerror}", file=path) from fault


def check_folder(folder: Path) -> None:
    """Whether files can be made in `folder`, which need not be there yet; else a UserError.

    Nothing is left behind: a command that fails later has made no folder.
    """
    there = folder = folder.absolute()
    try:
        while not there.exists():
            there = there.parent
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as fault:
        what = "write there" if there == folder else "make the folder"
        raise UserError(f"cannot {what} ({fault.strerror})", file=folder) from fault


def check_file(path: Path) -> None:
    """Whether the file `path` can be made or replaced; else a UserError."""
    if is_folder(path):
        raise UserError("is a folder, expected the name of a file", file=path)
    check_folder(path.parent)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A hidden name beside `path` to write to, renamed to `path` in the end.

    Folders on the way are made, and a link stays one: what it points to is replaced. On any fault
    nothing is left: neither a part of the file nor a new folder. An OSError becomes a UserError.
    Parts of any file in the folder that processes have left, killed a day ago or longer, go.
    """
    real = Path(os.path.realpath(path))
    temporary = real.with_name(f".{real.name}.{os.getpid()}.part")
    _forget(real.parent)
    new: list[Path] = []
    try:
        new += [folder for folder in real.parents if not folder.exists()]
        real.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        temporary.replace(real)
    except OSError as fault:
        # The HDF5 library puts lines of its own into the text of an error.
        reason = os.strerror(fault.errno) if fault.errno else str(fault).partition("\n")[0]
        raise UserError(f"cannot write ({reason})", file=path) from fault
    finally:
        with suppress(OSError):
            temporary.unlink()
        with suppress(OSError):  # a folder that holds something stays
            for folder in new:
                folder.rmdir()


@cache
def _forget(folder: Path) -> None:
    """Remove what processes have left in a folder long ago; once, for listing it takes time."""
    with suppress(OSError):
        for part in folder.glob(".*.*.part*"):
            if not PART.search(part.name):
                continue
            with suppress(OSError):  # another process may be first
                if time.time() - part.stat().st_mtime > FORGOTTEN_S:
                    part.unlink()
