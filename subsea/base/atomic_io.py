"""Check output paths before the work, and write files atomically."""

import glob
import hashlib
import os
import re
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from subsea.base.errors import UserError

STALE_S = 86400.0  # age of a partial file whose process has certainly ended
MAX_NAME = 200  # bytes; file systems allow 255 with what is added for a partial file
PART = re.compile(r"\.\d+\.part(\.\w+)?$")  # process ID; libraries may add a suffix


def is_folder(path: Path) -> bool:
    """True if `path` is an existing folder; an impossible name is a UserError."""
    try:
        return path.is_dir()
    except OSError as fault:
        raise UserError(f"{fault.strerror}", file=path) from fault


def check_folder(folder: Path) -> None:
    """Raise a UserError unless files can be written to `folder`, which may be missing.

    The folder is not created, so that a command that fails later leaves nothing behind.
    """
    there = wanted = Path(os.path.realpath(folder))
    try:
        while not os.path.lexists(there):
            there = there.parent
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as fault:
        what = "write there" if there == wanted else "make the folder"
        raise UserError(f"cannot {what} ({fault.strerror})", file=folder) from fault


def check_file(path: Path) -> None:
    """Raise a UserError unless the file `path` can be created or replaced."""
    _check_replaceable(path)
    check_folder(path.parent)


def _check_replaceable(path: Path) -> None:
    """Raise a UserError unless `path` is a regular file or missing.

    A device such as /dev/null or a pipe would become a file.
    """
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return
    except (OSError, ValueError) as fault:  # ValueError: a name with a zero byte
        raise UserError(getattr(fault, "strerror", None) or str(fault), file=path) from fault
    if stat.S_ISDIR(mode):
        raise UserError("is a folder, expected the name of a file", file=path)
    if not stat.S_ISREG(mode):
        raise UserError("not a regular file, choose another name", file=path)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a hidden path beside `path` to write to; rename it to `path` at the end.

    Creates missing folders and replaces the target of a link. On an error, removes the partial file
    and new folders and turns an OSError into a UserError. Also removes partial files of killed
    processes that are at least a day old.
    """
    _check_replaceable(path)
    real = Path(os.path.realpath(path))
    temporary = real.with_name(f".{_short(real.name)}.{os.getpid()}.part")
    _remove_stale(real.parent)
    new: list[Path] = []
    try:
        new += [folder for folder in real.parents if not folder.exists()]
        real.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        temporary.replace(real)
    except OSError as fault:
        # HDF5 adds lines of its own to the text of an error.
        reason = os.strerror(fault.errno) if fault.errno else str(fault).partition("\n")[0]
        raise UserError(f"cannot write ({reason})", file=path) from fault
    finally:
        with suppress(OSError):
            temporary.unlink()
        with suppress(OSError):  # not empty
            for folder in new:
                folder.rmdir()


def remove_abandoned(path: Path) -> None:
    """Remove partial files of `path` whose processes, of this computer, have ended.

    Only for files that no other computer writes.
    """
    begin = f".{_short(path.name)}."
    with suppress(OSError):
        for part in path.parent.glob(f"{glob.escape(begin)}*.part"):
            number = part.name[len(begin) :].removesuffix(".part")
            if number.isdecimal() and len(number) < 10 and not _is_running(int(number)):
                part.unlink(missing_ok=True)


def _is_running(process: int) -> bool:
    if os.name != "posix":  # elsewhere a signal of 0 is not a question
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _short(name: str) -> str:
    """The name, or a digest of one that is too long for a partial file."""
    data = os.fsencode(name)
    return name if len(data) <= MAX_NAME else hashlib.sha256(data).hexdigest()


@cache
def _remove_stale(folder: Path) -> None:
    """Remove old partial files from a folder; once per process, as listing takes time."""
    with suppress(OSError):
        for part in folder.glob(".*.*.part*"):
            if not PART.search(part.name):
                continue
            with suppress(OSError):  # another process may have removed it
                if time.time() - part.stat().st_mtime > STALE_S:
                    part.unlink()
