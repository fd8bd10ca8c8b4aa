"""The tool starts every command, and finds commands that end badly."""

import random
import signal
from pathlib import Path

import pytest

from capture.cli.main import parsers as capture_parsers
from subsea.cli.main import parsers
from tools import fuzz_commands as fuzz


def test_every_command_gets_odd_values_and_files():
    known = {("subsea", name) for name in parsers()[1].choices}
    known |= {("capture", name) for name in capture_parsers()[1].choices}
    for kind in ("value", "file"):
        cases = [fuzz.KINDS[kind](random.Random(k)) for k in range(400)]
        assert {tuple(case.words[:2]) for case in cases} == known
    for kind in ("stream", "locale", "environment", "folder", "python", "umask"):
        cases = [fuzz.KINDS[kind](random.Random(k)) for k in range(200)]
        assert len({tuple(case.words[:2]) for case in cases}) > 10


def test_settings_have_keys_of_scenarios():
    keys = {fuzz.odd_setting(random.Random(k)).partition("=")[0] for k in range(3000)}
    assert {"seed", "fish.0.number", "water.current_cm_s.0", "hook.depth_cm"} <= keys


@pytest.mark.parametrize(
    ("program", "redirection", "found"),
    [
        ("pass", "", None),
        ("sys.exit('subsea: no such file')", "| true", None),
        ("print('subsea: no such file', file=sys.stderr); sys.exit(2)", "", None),
        ("1 / 0", "", "ZeroDivisionError: division by zero"),
        ("print('x' * 9999)", ">/dev/full", "OSError: [Errno 28] No space left on device"),
        ("sys.exit(7)", "", "exit code 7: "),
        ("import os; os.kill(os.getpid(), 9)", "", "exit code 137: "),
        ("sys.exit(2)", "", "exit code 2 without a line"),
        ("print('two\\nlines', file=sys.stderr)", "", "not a message: two | lines"),
        ("open('pipe')", "", "not done after 3 s"),
        ("print('50%|###', file=sys.stderr, flush=True); open('pipe')", "", None),
    ],
)
def test_a_command_that_ends_badly_is_found(monkeypatch, tmp_path, program, redirection, found):
    monkeypatch.setattr(fuzz, "SECONDS", 3 if "pipe" in program else 60)
    monkeypatch.setattr(fuzz, "PATIENCE_S", 1)
    fuzz.make_folder(tmp_path, Path(__file__))
    (tmp_path / "stub.py").write_text(f"import sys\n{program}\n")
    case = fuzz.Case(["stub", "test"], redirection)
    what = fuzz.finding(case, fuzz.end_of(case, tmp_path))
    if what and what.startswith("exit code 137: "):  # bash reports it, in its own words
        what = "exit code 137: "
    assert what == found


def test_an_interrupted_command_gets_its_signals(tmp_path):
    wait = "signal.signal(signal.SIGTERM, lambda *unused: sys.exit(75))\ntime.sleep(60)\n"
    (tmp_path / "stub.py").write_text(f"import signal, sys, time\n{wait}")
    for number, code in ((signal.SIGTERM, 75), (signal.SIGINT, -signal.SIGINT)):
        case = fuzz.Case(["stub", "test"], signals=((0.01, number),))
        assert fuzz.end_of(case, tmp_path).code == code
    case = fuzz.KINDS["signal"](random.Random(1))
    assert case.environment["DISPLAY"].startswith(":") and 1 <= len(case.signals) <= 2


def test_executed_traps_are_found(monkeypatch, tmp_path):
    program = tmp_path / "subsea"
    program.write_text("#!/bin/sh\nPYTHONPATH= exec $PYTHON -c 'import socket'\n")
    program.chmod(0o755)
    monkeypatch.setenv("PYTHON", fuzz.sys.executable)
    monkeypatch.setattr(fuzz.sys, "executable", str(tmp_path / "python"))
    for switch, found in (("1", False), ("", True)):
        case = fuzz.Case(["subsea", "x"], environment={"PYTHONSAFEPATH": switch}, trapped=True)
        folder = tmp_path / f"folder{switch}"
        folder.mkdir()
        what = fuzz.finding(case, fuzz.end_of(case, folder))
        assert bool(what and "executed" in what) == found
