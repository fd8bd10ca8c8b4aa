"""Let `subsea fleet` take the address of the master from its dive, and give it back.

The command holds a lock for as long as it needs the address. The dive looks for the lock, ends,
waits until it is free, and starts again. The system frees the lock of a process that has ended.
Without file locks (Windows) the dive must be closed by hand.
"""

import hashlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from subsea.base.errors import UserError
from subsea.base.files import make_own_folder
from subsea.base.system import state_folder

TRIES, TRY_S = 20, 0.05  # to take the lock: a dive may be looking
LOOK_S = 0.5  # between two looks of a dive that waits


@contextmanager
def address_wanted(address: str) -> Iterator[None]:
    """Want the address of a master within the block; a UserError if another command does."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    path = _lock_path(address)
    try:
        make_own_folder(path.parent)
        file = path.open("ab")
    except OSError as fault:
        raise UserError(f"cannot be written ({fault.strerror or fault})", file=path) from fault
    with file:
        for left in reversed(range(TRIES)):
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError as fault:
                if left == 0:
                    raise UserError(f"another `subsea fleet` works at {address}") from fault
                time.sleep(TRY_S)
        yield


def is_wanted(address: str) -> bool:
    """True if a command on this computer wants the address."""
    try:
        with _lock_path(address).open("rb") as file:
            return not _is_free(file)
    except OSError:  # nobody has wanted it yet
        return False


def wait_until_free(address: str, tell: Callable[[str], object]) -> None:
    """Wait until no command wants the address."""
    if is_wanted(address):
        tell("waits for `subsea fleet`, then starts again")
    while is_wanted(address):
        time.sleep(LOOK_S)


def _lock_path(address: str) -> Path:
    return state_folder() / f"fleet-{hashlib.sha256(address.encode()).hexdigest()[:16]}.lock"


def _is_free(file: BinaryIO) -> bool:
    """True if nobody holds the lock of a file, which is left as it is."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
