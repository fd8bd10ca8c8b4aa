"""A closed or full standard stream ends no command, and the exit code is right."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import pathlib, sys
from subsea.base.command_line import make_parser, run_command
from subsea.base.errors import UserError

def run():
    word = sys.argv[1]
    if word == "--help":
        make_parser("diver", "d").parse_args([word])
    print("table \\u2013 \\udcff" * 5000)
    print("subsea: a message", file=sys.stderr, flush=True)
    pathlib.Path("result").write_text("whole")
    if word == "fault":
        raise UserError("no such fish")
    return int(word)

sys.exit(run_command("diver", run))
"""
FULL = "diver: standard output: No space left on device"


@pytest.mark.parametrize(
    ("word", "redirection", "code", "err"),
    [
        ("0", ">/dev/full", 75, ["subsea: a message", FULL]),
        ("1", ">&-", 1, ["subsea: a message"]),
        ("1", "| head -1 >/dev/null", 1, ["subsea: a message"]),
        ("0", "2>/dev/full >/dev/null", 0, []),
        ("0", ">&- 2>&- <&-", 0, []),
        ("fault", ">/dev/full 2>/dev/full", 2, []),
        ("fault", ">/dev/full", 2, ["subsea: a message", "diver: no such fish"]),
        ("--help", ">/dev/full", 75, [FULL]),
    ],
)
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_streams_that_cannot_be_written(tmp_path, word, redirection, code, err):
    shell = f'set -o pipefail; "$0" -c "$1" {word} {redirection}'
    environment = os.environ | {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}
    done = subprocess.run(
        ["bash", "-c", shell, sys.executable, PROGRAM],
        cwd=tmp_path, capture_output=True, text=True, env=environment, check=False,
    )  # fmt: skip
    assert done.returncode == code, done.stderr
    assert done.stderr.splitlines() == err
    assert (tmp_path / "result").exists() == (word != "--help")


def test_letters_that_a_terminal_lacks_are_escapes(tmp_path):
    environment = os.environ | {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, "0"],
        cwd=tmp_path, capture_output=True, text=True, env=environment, check=True,
    )  # fmt: skip
    assert done.stdout.startswith("table \\u2013 \\udcfftable")
