"""Folders and files that nobody but the user can have written, for caches."""

import os
import stat
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import BinaryIO


def make_own_folder(path: Path) -> None:
    """Make a folder for the user alone, if it is missing; PermissionError if others may write."""
    path.mkdir(mode=0o700, parents=True, exist_ok=True)
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
