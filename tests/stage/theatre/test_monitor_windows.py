"""Theatres on the connected monitors: a window that fills one, and missing ones."""

import subprocess
import sys
import time
from contextlib import closing

import glfw
import numpy as np
import pytest

from subsea.cli.main import main
from subsea.dive.pilot import Pilot
from subsea.dive.settings import USUAL
from subsea.dive.tick_source import LocalTicks
from subsea.ui.dive import Dive
from subsea.ui.help_overlay import NOT_SHARED, help_content
from subsea.ui.monitors import Installation, Screen, monitors, on_display
from subsea.ui.window_set import WindowSet
from subsea.view.display_rigs import display_rig
from subsea.view.test_pattern import lineup
from tests.support.scenes import BARE
from tests.support.windows import ShownOn, display_pixels, dive_options

THEATRE = """
[[window]]
name = "left"
size = [200, 150]
monitor = {left}

[[window]]
name = "ahead"
size = [200, 150]
{ahead}

[[channel]]
name = "left"
window = "left"
angles = {{ left_deg = -30, right_deg = 30, down_deg = -20, up_deg = 20, heading_deg = -60 }}

[[channel]]
name = "ahead"
window = "ahead"
angles = {{ left_deg = -30, right_deg = 30, down_deg = -20, up_deg = 20 }}
"""


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("left", "ahead", "options", "code", "said"),
    [
        ('"DP-3"', "position = [10, 10]", ["--seconds", "0.3"], 0,
         "window 'left': no monitor 'DP-3'; there are: 1 'screen' 800x600"),
        # Without a window, as the monitor may be switched on later:
        (2, "monitor = 3", [], 75, "window 'left': no monitor 2; there are: 1 'screen'"),
        (1, "position = [0, 0]", ["--display", "stereo"], 2, "quad-buffered"),
    ],
)  # fmt: skip
def test_a_dive_begins_with_the_windows_that_can_be_opened(
    display, tmp_path, capfd, left, ahead, options, code, said
):
    path = tmp_path / "hall.toml"
    path.write_text(THEATRE.format(left=left, ahead=ahead))
    assert main(["dive", "--theatre", str(path), "--scenario", str(BARE), *options]) == code
    assert sum(said in line for line in capfd.readouterr().err.splitlines()) == 1


class Together(LocalTicks):
    """A tick source that claims to be shared with other computers."""

    shared = True


@pytest.mark.nightly
def test_a_window_fills_its_monitor_and_stays_when_that_is_lost(display, quiet):
    size = (400, 300)
    installation = Installation(display_rig("mono", size), [Screen("all", size, monitor=1)])
    shown = ShownOn(installation, Together)
    with closing(Dive(dive_options(quiet, size, parts=[shown]))) as running:
        # Neither works in a shared dive or on a fixed window.
        assert running.overlay.help == help_content(USUAL, without=NOT_SHARED)
        assert running.window.fixed
        running.run_command("pattern")
        running.overlay.draw = lambda *rest: None
        for _ in range(5):
            running.frame(0.1)
            time.sleep(0.05)
        assert running.window.size == (800, 600)
        assert running.window.position == (0, 0)
        picture = display_pixels()
        means = picture.reshape(300, 2, 400, 2, 3).mean(axis=(1, 3))
        assert np.abs(means - lineup(installation.rig)).mean() < 8.0
        # Imitate the library when a monitor is unplugged:
        windowed = None
        glfw.set_window_monitor(running.window.handle, windowed, 20, 10, 200, 150, 0)
        for _ in range(5):
            running.frame(0.1)
            time.sleep(0.05)
        assert running.window_set.open
        assert running.window.size == (200, 150)
        picture = display_pixels()
        small = lineup(installation.rig).reshape(150, 2, 200, 2, 3).mean(axis=(1, 3))
        assert np.abs(picture[10:160, 20:220] - small).mean() < 3.0
        told = []
        running.overlay.note = told.append
        (monitor,) = monitors()
        running.window_set.on_monitor(monitor.handle, glfw.DISCONNECTED)
        running.frame(0.1)  # the monitor is still connected: the window fills it again
        assert told == [f"the monitor {monitor.name!r} is gone"]
        assert running.window.filled == (0, 0)


def test_a_full_screen_that_is_unplugged_is_a_window_again(display, tmp_path, monkeypatch):
    with on_display(), closing(WindowSet([(Screen("sea", (200, 150)), None)], Pilot())) as windows:
        window = windows.front
        window.toggle_fullscreen()
        assert window.filled == (0, 0)
        (monitor,) = monitors()
        nowhere = None
        glfw.set_window_monitor(window.handle, nowhere, 0, 0, 800, 600, 0)  # as the library does
        monkeypatch.setattr("subsea.ui.window_set.monitors", lambda: [])
        monkeypatch.setattr("subsea.ui.window.monitors", lambda: [])
        windows.on_monitor(monitor.handle, glfw.DISCONNECTED)
        windows.poll()
        until = time.monotonic() + 60.0
        while window.points != (200, 150) and time.monotonic() < until:
            windows.poll()
        assert window.points == (200, 150)
        window.toggle_fullscreen()  # without any monitor: nothing happens
        assert window.filled is None
        assert windows.open
        monkeypatch.undo()
        window.toggle_fullscreen()
        assert window.filled == (0, 0)


@pytest.mark.nightly  # test_window_set.py and test_dive_ends.py leave by keys every day
def test_a_key_ends_the_dive_in_the_three_windows_of_a_theatre(display, user, tmp_path):
    settings = tmp_path / "settings.toml"
    settings.write_text('[controls]\nleave = ["X"]\n')
    command = [sys.executable, "-m", "subsea", "dive", "--theatre", "cave", "--shrink", "8"]
    command += ["--settings", str(settings)]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        windows = []
        while len(windows) < 3 and running.poll() is None:
            found = subprocess.run(
                ["xdotool", "search", "--name", "^(left|front|right)$"],
                capture_output=True, text=True, timeout=60,
            )  # fmt: skip
            windows = found.stdout.split()
            time.sleep(0.2)
        time.sleep(1.0)  # the pilot's window first takes the keyboard
        user.do("windowfocus", windows[1])
        while running.poll() is None:
            user.do("key", "x")
            time.sleep(0.3)
        assert running.returncode == 0
    finally:
        running.kill()
        _, err = running.communicate()
    assert "Traceback" not in err
