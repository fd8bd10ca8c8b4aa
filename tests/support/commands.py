"""Commands that are refused, and a disk that is full."""

import resource
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import pytest


def refusal(
    main: Callable[[Sequence[str]], int],
    words: Sequence[str],
    capsys: pytest.CaptureFixture[str],
    code: int = 2,
) -> str:
    """Run a command that fails with this exit code, and return its only line."""
    assert main(words) == code
    out, err = capsys.readouterr()
    assert not out and err.count("\n") == 1, (out, err)
    return err


@contextmanager
def full_disk(free: int) -> Iterator[None]:
    """Let no file grow beyond a number of bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (free, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
