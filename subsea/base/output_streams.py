"""Standard output and error that outlive a closed pipe or a full disk."""

import io
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from subsea.base.errors import UserError


class _TolerantFile(io.FileIO):
    """A file that accepts everything, and stores its first fault."""

    fault: OSError | None = None

    def write(self, data: Any) -> int:
        """Write data; after a fault, nothing."""
        if self.fault is None:
            try:
                return super().write(data)
            except OSError as fault:
                self.fault = fault
        return len(data)


@contextmanager
def tolerant_output() -> Iterator[Callable[[], None]]:
    """Let a command finish its work when its output cannot be written.

    Letters that the terminal's encoding lacks become escapes. Yields a function that raises a
    UserError if standard output has lost text to anything but a closed pipe, as in ``| head``.
    Streams that another program has replaced, such as a notebook's, stay as they are.
    """
    for number in range(3):
        _open_closed(number)
    before = sys.stdout, sys.stderr
    files: dict[str, _TolerantFile] = {}
    for number, name in ((1, "stdout"), (2, "stderr")):
        old = getattr(sys, name)
        if old is getattr(sys, f"__{name}__"):
            _flush(old)
            files[name] = _TolerantFile(number, "wb", closefd=False)
            setattr(sys, name, _text_stream(files[name], old))

    def check() -> None:
        _flush(sys.stdout)
        fault = files["stdout"].fault if "stdout" in files else None
        if fault and not isinstance(fault, BrokenPipeError):
            raise UserError(f"{fault.strerror}", file="standard output")

    try:
        yield check
    finally:
        _flush(sys.stdout)
        _flush(sys.stderr)
        sys.stdout, sys.stderr = before


def _open_closed(number: int) -> None:
    """Open the null device in place of a closed stream, whose number a result would get."""
    try:
        os.fstat(number)
    except OSError:
        os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)


def _text_stream(file: _TolerantFile, old: Any) -> io.TextIOWrapper:
    """A stream to a file with the settings of an old one; it escapes unknown letters."""
    return io.TextIOWrapper(
        io.BufferedWriter(file),
        encoding=old.encoding if old else "utf-8",
        errors="backslashreplace",
        line_buffering=old.line_buffering if old else False,
        write_through=old.write_through if old else False,
    )


def _flush(stream: Any) -> None:
    """Flush a stream; None is a closed one."""
    if stream is not None:
        stream.flush()
