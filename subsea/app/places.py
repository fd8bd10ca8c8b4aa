"""Whether a result can be written, asked before the work rather than after it."""

import os
from pathlib import Path

from subsea.errors import UserError


def check_folder(folder: Path) -> None:
    """Make the folder if it is not there; one that cannot be written to is a UserError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise UserError(f"{folder}: cannot make the folder ({fault.strerror})") from fault
    if not os.access(folder, os.W_OK):
        raise UserError(f"{folder}: no permission to write there")


def check_file(path: Path) -> None:
    """Whether the file `path` can be made or replaced; else a UserError."""
    if path.is_dir():
        raise UserError(f"{path}: is a folder, expected the name of a file")
    check_folder(path.parent)
