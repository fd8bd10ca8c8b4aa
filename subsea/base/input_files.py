"""Check and read input files: regular files of limited size."""

import os
import stat
from hashlib import file_digest
from io import BufferedReader
from pathlib import Path

from subsea.base.errors import UserError, unreadable

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
    """The text of a regular file in UTF-8, with line ends as they are; else a UserError."""
    try:
        return read_input(path, most).decode("utf-8")
    except UnicodeDecodeError as fault:
        raise unreadable(path, fault) from fault


def file_hash(path: Path) -> str:
    """The SHA-256 of a regular file, as `sha256sum` prints it; a UserError for anything else."""
    with open_input(path) as file:
        try:
            return file_digest(file, "sha256").hexdigest()
        except OSError as fault:
            raise unreadable(path, fault) from fault
