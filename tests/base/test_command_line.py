"""Exit codes and the one line of every fault, whatever program asks."""

import errno
import signal
from pathlib import Path

import pytest

from subsea.base.command_line import (
    run_command,
)
from subsea.base.errors import TransientError, UserError


@pytest.mark.parametrize(
    ("fault", "code", "line"),
    [
        (UserError("reef.toml: `seed` is -1"), 2, "diver: reef.toml: `seed` is -1"),
        (TransientError("no display"), 75, "diver: no display"),
        (KeyboardInterrupt(), 130, "diver: interrupted"),
        (KeyboardInterrupt("7 of 9 are kept"), 130, "diver: interrupted: 7 of 9 are kept"),
        (
            ModuleNotFoundError("No module named 'av'", name="av"),
            2,
            "diver: No module named 'av'; run `make run`",
        ),
        (
            OSError(errno.ENOSPC, "No space left on device", "/cache/x.nbi"),
            75,
            "diver: /cache/x.nbi: No space left on device",
        ),
    ],
)
def test_errors_that_a_user_can_fix_are_one_line(fault, code, line, capsys):
    def run():
        raise fault

    assert run_command("diver", run) == code
    assert capsys.readouterr() == ("", line + "\n")


@pytest.mark.parametrize(
    "fault",
    [
        ZeroDivisionError(),
        ModuleNotFoundError("No module named 'subsea.x'", name="subsea.x"),
        OSError(errno.EBADF, "Bad file descriptor"),
    ],
)
def test_a_fault_of_the_program_keeps_its_traceback(fault):
    def run():
        raise fault

    with pytest.raises(type(fault)):
        run_command("diver", run)


def test_a_deleted_folder_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    tmp_path.rmdir()
    assert run_command("diver", lambda: len(str(Path("a").absolute()))) == 2
    assert capsys.readouterr().err == (
        "diver: the current folder was deleted; change to another one\n"
    )
    tmp_path.mkdir()


def test_sigterm_is_an_interruption(capsys):
    before = signal.getsignal(signal.SIGTERM)
    try:
        assert run_command("diver", lambda: signal.raise_signal(signal.SIGTERM)) == 130
    finally:
        signal.signal(signal.SIGTERM, before)


def test_the_code_of_the_command_is_passed_on():
    assert run_command("diver", lambda: 1) == 1
