"""The end of a dive: by itself, by a key, or before its start."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from subsea.cli.main import main
from subsea.ui.dive import Dive
from tests.support.scenes import BARE
from tests.support.windows import User, press_close_button

WORDS = ["dive", "--size", "320x240", "--scenario", str(BARE)]
DIVE = [sys.executable, "-m", "subsea", *WORDS]


@pytest.mark.parametrize("words", [WORDS, pytest.param(WORDS[:3], marks=pytest.mark.nightly)])
def test_it_ends_by_itself(display, words):
    command = [*DIVE[:3], *words, "--seconds", "0.5"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.nightly
def test_the_last_picture_says_that_it_closes(display, monkeypatch, tmp_path):
    settings, shown, drawn = tmp_path / "settings.toml", [], []
    settings.write_text('[controls]\nleave = ["X"]\n')
    close, frame = Dive.close, Dive.frame

    def closed(running):
        time.sleep(0.2)
        shown.append(User.screen(running))
        close(running)

    def framed(running, elapsed_s):
        drawn.append(frame(running, elapsed_s))
        User.do("key", "x")
        time.sleep(0.3)

    monkeypatch.setattr(Dive, "close", closed)
    monkeypatch.setattr(Dive, "frame", framed)
    assert main([*WORDS, "--seconds", "100", "--settings", str(settings)]) == 0
    [screen] = shown
    assert len(drawn) <= 2  # the key ends it before another picture
    ground = np.abs(screen - screen[5, 5]).max(axis=2) < 3
    assert 0.95 < ground.mean() < 1.0  # a line of text, without the sea


def refused(environment, code=2):
    """The one line on the terminal with which a dive ends at once."""
    base = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    environment = base | environment
    done = subprocess.run(DIVE, capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == code
    [line] = done.stderr.splitlines()
    return line


@pytest.mark.nightly
def test_no_display_or_too_old_an_opengl_is_one_line_with_what_to_do(display):
    assert "subsea film" in refused({}, 75)
    assert "subsea film" in refused({"DISPLAY": ":4711"}, 75)
    assert "apt-get install" in refused({"DISPLAY": display, "MESA_GL_VERSION_OVERRIDE": "2.1"})


@pytest.mark.nightly
def test_another_display_opens_too(display):  # `test_stereo_window` opens all
    assert main([*WORDS, "--seconds", "0.3", "--display", "equirectangular"]) == 0


def test_a_window_without_a_buffer_for_each_eye_is_one_line_with_other_modes(display, capfd):
    assert main([*WORDS, "--display", "stereo"]) == 2
    told = capfd.readouterr().err
    assert len(told.splitlines()) == 1
    assert "quad-buffered" in told
    assert "anaglyph" in told


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("way", "line"),
    [
        ("close button", "reading repertoires"),
        pytest.param("Ctrl-C", "waking the fishes", marks=pytest.mark.nightly),
        pytest.param("Ctrl-C", "starting OpenGL", marks=pytest.mark.nightly),
        ("Escape", "starting OpenGL"),
    ],
)
def test_leaving_while_it_loads_ends_at_once_without_an_error(display, user, way, line):
    running = subprocess.Popen([*DIVE, "--seconds", "100"], stderr=subprocess.PIPE, text=True)
    with running:
        try:
            told = next(text for text in running.stderr if line in text)
            if way == "Escape":
                user.do("key", "Escape")
            elif way == "close button":
                press_close_button(*map(int, user.do("search", "--name", "subsea").split()))
            else:
                running.send_signal(signal.SIGINT)
            _, rest = running.communicate(timeout=60)
        finally:
            running.kill()
    assert told
    # Lines on progress and the interruption, but no error.
    assert all(text.startswith("subsea: ") for text in rest.splitlines())
    assert running.returncode == (130 if way == "Ctrl-C" else 0)
