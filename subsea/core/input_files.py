"""Check and read input files: regular files of limited size."""

import stat
from hashlib import file_digest
from pathlib import Path

from subsea.core.errors import UserError, unreadable

MIB = 1 << 20


def check_input(path: Path) -> int:
    """The size in bytes of a regular file; a UserError for anything else.

    Called before a file is opened: a pipe has no end, and opening one waits for a writer.
    """
    try:
        status = path.stat()
    except (OSError, ValueError) as fault:  # ValueError: a name with a zero byte
        raise unreadable(path, fault) from fault
    if stat.S_ISDIR(status.st_mode):
        raise unreadable(path, IsADirectoryError())
    if not stat.S_ISREG(status.st_mode):
        raise UserError("not a regular file", file=path)
    return status.st_size


def read_input(path: Path, most: int = 16 * MIB) -> bytes:
    """The content of a regular file of at most `most` bytes; a UserError for anything else."""
    check_input(path)
    try:
        with path.open("rb") as file:
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
    check_input(path)
    try:
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    except OSError as fault:
        raise unreadable(path, fault) from fault
