"""Check output paths before the work, and write files atomically.

Folders and files that nobody but the user can have written, for caches.

Check and read input files: regular files of limited size.
"""

import hashlib
import os
import re
import shutil
import stat
import tempfile
import time
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import file_digest
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO

from subsea.base.errors import TransientError, UserError, is_full_disk, unreadable

OWN_MODE = 0o600  # of a file that only the user may read and write


def make_own_folder(path: Path) -> None:
    """Make a folder for the user alone, if it is missing; PermissionError if others may write."""
    for folder in (*reversed(path.parents), path):
        if not folder.is_dir():
            folder.mkdir(mode=0o700, exist_ok=True)
    if not _is_own(path.stat()):
        raise PermissionError("others may write to the folder or own it")


def open_own(path: Path) -> BinaryIO:
    """Open a regular file of the user to read it; OSError for anything else.

    Does not wait for the other end of a pipe.
    """
    nonblocking = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    file = os.fdopen(os.open(path, os.O_RDONLY | nonblocking), "rb")
    status = os.fstat(file.fileno())
    if not stat.S_ISREG(status.st_mode) or not _is_own(status):
        file.close()
        raise PermissionError("others may write to the file or own it, or it is not a regular file")
    return file


def _is_own(status: os.stat_result) -> bool:
    """True if the user owns it and nobody else may write; always true on Windows."""
    if not hasattr(os, "geteuid"):
        return True
    writable = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return status.st_uid == os.geteuid() and (
        not writable or (writable == stat.S_IWGRP and _is_private(status.st_gid))
    )


@cache
def _is_private(group: int) -> bool:
    """True for the group of the user alone, to which new folders belong on many systems."""
    from grp import getgrgid  # missing on Windows
    from pwd import getpwuid

    with suppress(KeyError):  # an unknown number
        user, about = getpwuid(os.geteuid()), getgrgid(group)
        return about.gr_name == user.pw_name and set(about.gr_mem) <= {user.pw_name}
    return False


def refuse_shared(path: Path) -> None:
    """Raise a UserError if others than the owner may read a secret."""
    mode = stat.S_IMODE(path.stat().st_mode)
    if os.name == "posix" and mode & 0o077:
        raise UserError(f"others may read it (mode {mode:o}); `chmod 600 {path}`", file=path)


MIB = 1 << 20
# Do not wait for the writer of a pipe; on Windows, do not change line ends.
FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def check_input(path: Path) -> int:
    """The size in bytes of a regular file; a UserError for anything else.

    For libraries that open files themselves: a pipe has no end, and opening one waits for a writer.
    """
    with open_input(path) as file:
        return os.fstat(file.fileno()).st_size


def open_input(path: Path) -> BufferedReader:
    """Open a regular file for reading; a UserError for anything else, also for files of /proc."""
    try:
        _check_kind(path, path.stat())  # opening a device could have an effect
        file = os.fdopen(os.open(path, FLAGS), "rb")
        try:
            # By now the name may mean another file.
            _check_kind(path, status := os.fstat(file.fileno()))
            if status.st_size == 0 and not _is_empty(file.fileno()):
                raise UserError("not a regular file", file=path)
        except BaseException:
            file.close()
            raise
    except (OSError, ValueError) as fault:  # ValueError: a name with a zero byte
        raise unreadable(path, fault) from fault
    return file


def refuse_locked(file: BufferedReader, path: Path) -> None:
    """Raise a TransientError if another program has locked the file to write to it.

    A file system without locks, as some networks and containers have, passes.
    """
    with suppress(ImportError):  # Windows, where opening a locked file fails
        from fcntl import LOCK_NB, LOCK_SH, LOCK_UN, flock

        try:
            flock(file, LOCK_SH | LOCK_NB)
            flock(file, LOCK_UN)
        except BlockingIOError as fault:
            raise TransientError(
                "another program has locked it to write to it; close it there", file=path
            ) from fault
        except OSError:
            pass


def _check_kind(path: Path, status: os.stat_result) -> None:
    if stat.S_ISDIR(status.st_mode):
        raise unreadable(path, IsADirectoryError())
    if not stat.S_ISREG(status.st_mode):
        raise UserError("not a regular file", file=path)


def _is_empty(number: int) -> bool:
    """False for a file of the kernel, such as /proc/kmsg, which claims to be empty and may wait."""
    try:
        return not os.read(number, 1)
    except BlockingIOError:
        return False


def read_input(path: Path, most: int = 16 * MIB) -> bytes:
    """The content of a regular file of at most `most` bytes; a UserError for anything else."""
    with open_input(path) as file:
        try:
            data = file.read(most + 1)
        except OSError as fault:
            raise unreadable(path, fault) from fault
    if len(data) > most:
        raise UserError(f"larger than {most // MIB} MiB, expected a smaller file", file=path)
    return data


def read_text(path: Path, most: int = 16 * MIB) -> str:
    """The text of a regular file, with line ends as they are; else a UserError."""
    return text_of(read_input(path, most), path)


MARKS = {BOM_UTF8: "utf-8", BOM_UTF16_LE: "utf-16-le", BOM_UTF16_BE: "utf-16-be"}


def text_of(data: bytes, file: Path | str, foreign: bool = False) -> str:
    """Decode UTF-8, or what a byte-order mark names, and leave the mark out; else a UserError.

    Other programs write names and comments in Latin-1, too, so `foreign` text may be Latin-1.
    """
    mark = next((mark for mark in MARKS if data.startswith(mark)), b"")
    try:
        return data[len(mark) :].decode(MARKS.get(mark, "utf-8"))
    except UnicodeDecodeError as fault:
        if foreign and not mark:
            return data.decode("latin-1")
        line = data.count(b"\n", 0, fault.start) + 1
        raise UserError(
            "cannot read (not UTF-8 text); save it as UTF-8", file=file, line=line
        ) from fault


def logical_lines(text: str) -> Iterator[tuple[int, str]]:
    """Number the lines of a text from 1, and join those that end in a backslash with the next.

    The backslash ends a comment after ``#`` like any other character, as in a path of Windows.
    """
    begin, joined = 0, ""
    for number, line in enumerate(re.split(r"\r\n|\r|\n", text), 1):
        begin = begin or number
        joined += line
        if line.endswith("\\") and "#" not in joined:
            joined = f"{joined[:-1]} "
        else:
            yield begin, joined
            begin, joined = 0, ""
    if begin:
        yield begin, joined


def file_hash(path: Path) -> str:
    """The SHA-256 of a regular file, as `sha256sum` prints it; a UserError for anything else."""
    with open_input(path) as file:
        try:
            return file_digest(file, "sha256").hexdigest()
        except OSError as fault:
            raise unreadable(path, fault) from fault


STALE_S = 86400.0  # age of a partial file whose process has certainly ended
MAX_NAME = 200  # bytes; file systems allow 255 with what is added for a partial file
ANY_MODE = 0o666  # less what the umask takes
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
def replacing(path: Path, mode: int = ANY_MODE) -> Iterator[Path]:
    """Yield a new, empty, hidden file beside `path` to write to; rename it to `path` at the end.

    The file has a given `mode` from its beginning, whatever the umask. Creates missing folders and
    replaces the target of a link. On an error, removes the partial file and new folders and turns
    an OSError into a UserError. Also removes partial files of killed processes that are at least a
    day old.
    """
    _check_replaceable(path)
    real = Path(os.path.realpath(path))
    temporary = _part_of(real)
    _remove_stale(real.parent)
    new: list[Path] = []
    try:
        new += [folder for folder in real.parents if not folder.exists()]
        real.parent.mkdir(parents=True, exist_ok=True)
        create_part(temporary, mode)
        yield temporary
        temporary.replace(real)
    except OSError as fault:
        # HDF5 adds lines of its own to the text of an error.
        reason = os.strerror(fault.errno) if fault.errno else str(fault).partition("\n")[0]
        kind = TransientError if is_full_disk(fault) else UserError
        raise kind(f"cannot write ({reason})", file=path) from fault
    finally:
        with suppress(OSError):
            temporary.unlink()
        with suppress(OSError):  # not empty
            for folder in new:
                folder.rmdir()


def create_part(path: Path, mode: int = ANY_MODE) -> None:
    """Create an empty file in place of a leftover, never through a link that others planted."""
    path.unlink(missing_ok=True)
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))
    if mode != ANY_MODE:
        path.chmod(mode)


@contextmanager
def partial_folder(path: Path) -> Iterator[Path]:
    """Make a hidden folder beside `path` for files that are not whole; remove it at the end."""
    folder = _part_of(path)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _part_of(path: Path) -> Path:
    return path.with_name(f".{_short(path.name)}.{os.getpid()}.part")


def remove_abandoned(folder: Path, name: str = "") -> None:
    """Remove partial files and folders whose processes, of this computer, have ended.

    Those of the file `name`, or of all files. Only for folders that no other computer writes.
    """
    named = re.escape(_short(name)) if name else ".+"
    with suppress(OSError):
        for part in folder.iterdir():
            match = re.fullmatch(rf"\.{named}\.(\d{{1,9}})\.part", part.name)
            if match and not _is_running(int(match[1])):
                _remove(part)


def _remove(part: Path) -> None:
    if part.is_dir() and not part.is_symlink():
        shutil.rmtree(part)
    else:
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
                if time.time() - part.lstat().st_mtime > STALE_S:
                    _remove(part)
