"""Work beside the windows: its lines, its result, its faults, and leaving before its end."""

import atexit
import subprocess
import sys
import threading

import pytest

from subsea.base.errors import UserError
from subsea.jobs.background import CancelledByUserError, run_in_background


def test_lines_arrive_in_order_before_the_result():
    heard = []

    def work(tell):
        tell("one")
        tell("two")
        return threading.current_thread()

    worker = run_in_background(work, heard.append)
    assert [line for line in heard if line is not None] == ["one", "two"]
    assert worker is not threading.current_thread()


def test_windows_are_updated_during_the_work():
    go = threading.Event()
    looks = []

    def look(line):
        looks.append(line)
        if len(looks) == 3:
            go.set()

    assert run_in_background(lambda tell: go.wait(20.0), look)


def test_errors_reach_the_caller():
    def work(tell):
        raise UserError("no such reef")

    with pytest.raises(UserError, match="no such reef"):
        run_in_background(work, lambda line: None)


def test_cancelling_does_not_wait(monkeypatch):
    ends, go = [], threading.Event()
    monkeypatch.setattr(atexit, "register", lambda *call: ends.append(call))

    def look(line):
        raise CancelledByUserError

    with pytest.raises(CancelledByUserError):
        run_in_background(lambda tell: go.wait(20.0), look)
    ((_, worker, code),) = ends
    assert (worker.is_alive(), code) == (True, 0)
    go.set()
    worker.join()


LEAVE = """
import time
from subsea.jobs.background import CancelledByUserError, run_in_background
def look(line):
    raise {0}
try:
    run_in_background(lambda tell: time.sleep(60.0), look)
except {0}:
    print("left")
"""


@pytest.mark.parametrize(("why", "code"), [("CancelledByUserError", 0), ("KeyboardInterrupt", 130)])
def test_the_process_ends_during_the_work(why, code):
    done = subprocess.run(
        [sys.executable, "-c", LEAVE.format(why)], capture_output=True, text=True, timeout=30
    )
    assert (done.returncode, done.stdout, done.stderr) == (code, "left\n", "")
