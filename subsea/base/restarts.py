"""Start the command of this process again, as a technician asks from afar."""

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from subsea.base.command_line import TRANSIENT
from subsea.base.progress import say

RESTART = 76  # returned by a command that is to start again; no process ends with it
SERVICE = "NOTIFY_SOCKET"  # a variable that a service manager sets


_awaited: list[Callable[[], object]] = []


def wait_first(wait: Callable[[], object]) -> None:
    """Let a restart of this process first call `wait`, which returns when it may begin."""
    _awaited.append(wait)


def restart() -> int:
    """Replace this process by a new one with the same arguments; returns only if it cannot.

    A service ends with the exit code after which its manager starts it again, and has all the time
    of a start. Call this after everything is closed.
    """
    if SERVICE in os.environ:
        return TRANSIENT
    for wait in _awaited:
        wait()
    command = restart_command(sys.argv, sys.orig_argv, sys.executable)
    try:
        os.execv(command[0], command)
    except OSError as fault:
        say(f"cannot start again: {command[0]} ({fault.strerror})")
    return TRANSIENT


def restart_command(arguments: Sequence[str], original: Sequence[str], python: str) -> list[str]:
    """The command of a process, from its arguments with and without those of Python.

    A program such as ``bin/subsea`` is started by its own path, not by the Python that its first
    line names: the path may lead through a link to another version by now.
    """
    program = Path(arguments[0])
    if program.is_file() and os.access(program, os.X_OK):
        return [str(program.absolute()), *arguments[1:]]
    return [python, *original[1:]]
