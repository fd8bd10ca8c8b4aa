"""The tool that sends random input to a dive finds its failures."""

import random
import subprocess
import sys
from itertools import islice, takewhile

import pytest

from tools import monkey

BEAT = "import os, signal, sys, time\nfrom pathlib import Path\n"
BEAT += "signal.signal(signal.SIGINT, lambda *unused: os._exit(130))\n"
BEAT += "pulse = Path(sys.argv[1])\nshown = 0\n"
BEAT += "def beat(seconds=0.05):\n    global shown\n    shown += 1\n"
BEAT += "    pulse.write_text(str(shown + 20)); time.sleep(seconds)\n"
FOR_EVER = "while True: beat()\n"


@pytest.fixture
def play(monkeypatch, tmp_path):
    """Play for a while with a program that takes a dive's place."""
    monkeypatch.setattr(monkey, "LOOK_S", 0.05)
    pulse, told = tmp_path / "pulse", tmp_path / "told"
    opened = []

    def open_dive():
        pulse.write_text("0")
        opened.append(pulse)
        with told.open("wb") as file:
            command = [sys.executable, "-c", BEAT + program, pulse]
            process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)
        return monkey.Dive(process, pulse, told)

    def play(text, number, dives=10**6):
        """Findings of that many events, or until that many dives were opened."""
        nonlocal program
        program = text
        events = [monkey.Event(0.02, ("key", "a"))] * number
        stream = takewhile(lambda event: len(opened) < dives, events)
        sent = []
        found, _ = monkey.play(stream, 600.0, open_dive, sent, lambda words: None)
        assert sent
        return found, len(opened)

    program = ""
    return play


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("program", "told"),
    [
        (FOR_EVER, None),
        ("for _ in range(8): beat()\nsys.exit(3)", "it ended with 3"),
        ("for _ in range(8): beat()\nint('x')", "Traceback (most recent call last):"),
        (
            "beat()\nprint('subsea: Habits failed: KeyError: 3', flush=True)\n" + FOR_EVER,
            "Habits f",
        ),
        ("import warnings\nbeat()\nwarnings.warn('odd')\n" + FOR_EVER, "UserWarning: odd"),
        ("beat()\ntime.sleep(60)", "no picture for 1 s"),
        ("signal.signal(signal.SIGINT, signal.SIG_IGN)\n" + FOR_EVER, "Ctrl-C does not end it"),
    ],
    ids=["sound", "code", "traceback", "panel", "warning", "hang", "stays"],
)
def test_each_kind_of_failure_is_found(play, monkeypatch, program, told):
    to_the_end = told is None or told.startswith("Ctrl-C")
    # Only who waits in vain is impatient: a sound dive may take its time.
    if told == "no picture for 1 s":
        monkeypatch.setattr(monkey, "STILL_S", 0.6)
    elif told == "Ctrl-C does not end it":
        monkeypatch.setattr(monkey, "LEAVE_S", 1.0)
    found, _ = play(program, 20 if to_the_end else 10**4)
    if told is None:
        assert found == []
    else:
        assert any(told in line for line in found), found


def test_a_dive_that_is_left_is_opened_again(play):
    found, opened = play("for _ in range(8): beat()\nos._exit(0)", 10**4, dives=2)
    assert found == []
    assert opened == 2


def test_memory_that_grows_is_found():
    assert monkey.growth([5.0] * 3) == monkey.growth([100.0] * 40) == []
    assert monkey.growth([100.0 + k for k in range(40)]) == ["memory grew by 17%"]


def test_the_same_seed_gives_the_same_events():
    first, again = (list(islice(monkey.events(random.Random(3)), 3000)) for _ in range(2))
    assert first == again
    assert first != list(islice(monkey.events(random.Random(4)), 3000))
    assert {event.words[0] for event in first} == {
        "key", "keydown", "keyup", "mousemove", "mousedown", "mouseup", "click", "type", "search",
    }  # fmt: skip
