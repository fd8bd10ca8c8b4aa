"""Work for other processes, in a module that they can import."""

import os
import signal
import time
from pathlib import Path

from subsea.base.errors import UserError


def square(number):
    """The square of a number."""
    return number * number


def crash(given):
    """Crash until a file has as many letters as wanted; then return the letters."""
    file, wanted = given
    count = len(Path(file).read_text()) if Path(file).exists() else 0
    if count < wanted:
        Path(file).write_text("x" * (count + 1))
        os.kill(os.getpid(), signal.SIGKILL)
    return count


def refuse(number):
    """Raise a UserError."""
    raise UserError("refused", file=f"{number}")


def sleep(seconds):
    """Sleep."""
    time.sleep(seconds)
