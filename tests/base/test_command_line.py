"""Exit codes and the one line of every fault, whatever program asks."""

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from subsea.base.command_line import (
    add_command,
    make_parser,
    number_reader,
    parse_arguments,
    run_command,
)
from subsea.base.errors import TransientError, UserError

MEMORY = "diver: not enough memory; close other programs, or raise the limit (`ulimit -v`)"


def caused(error, fault):
    """An error that another one caused."""
    error.__cause__ = fault
    return error


def refused(fault):
    """An error of the user that another one caused."""
    return caused(UserError("cannot write", file="out.mp4"), fault)


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
        (MemoryError(), 2, MEMORY),
        (RuntimeError("can't start new thread"), 2, MEMORY),
        (OSError(errno.ENOMEM, os.strerror(errno.ENOMEM)), 2, MEMORY),
        (ImportError("x.so: failed to map segment from shared object"), 2, MEMORY),
        (caused(OSError("no x.so"), OSError("x.so: failed to map segment")), 2, MEMORY),
        (refused(refused(OSError(errno.EDQUOT, "quota"))), 75, "diver: out.mp4: cannot write"),
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


@pytest.mark.parametrize(
    "setting",
    [
        *("NUMBA_NUM_THREADS=0", "NUMBA_OPT=junk", "NUMBA_COLOR_SCHEME=junk"),
        *("NUMBA_CPU_FEATURES=junk", "NUMBA_CPU_FEATURES=+avx, -avx", "TQDM_MININTERVAL=junk"),
    ],
)
def test_a_setting_that_a_package_refuses_is_named(setting):
    program = (
        "import sys; from subsea.base.command_line import run_command\n"
        "sys.exit(run_command('diver', lambda: __import__('subsea.geometry.vector') and "
        "__import__('tqdm') and 0))"
    )
    name, _, value = setting.partition("=")
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, text=True, env=os.environ | {name: value}, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    package = name.partition("_")[0].lower()
    assert done.stderr.startswith(f"diver: {package} does not start with {setting} (")


def test_sigterm_is_an_interruption(capsys):
    before = signal.getsignal(signal.SIGTERM)
    try:
        assert run_command("diver", lambda: signal.raise_signal(signal.SIGTERM)) == 130
    finally:
        signal.signal(signal.SIGTERM, before)


def test_the_code_of_the_command_is_passed_on():
    assert run_command("diver", lambda: 1) == 1


def parsed(*arguments):
    """The options of a command with options of several kinds."""
    parser = make_parser("diver", "A diver.")
    commands = parser.add_subparsers(dest="command")
    command = add_command(commands, "film", "film", "", [])
    command.add_argument("files", nargs="*")
    command.add_argument("--scenario")
    command.add_argument("--seconds", type=number_reader(float, 0, 9))
    command.add_argument("--look", choices=("colours", "range"))
    command.add_argument("--set", action="append")
    return parse_arguments(parser, commands, arguments)
