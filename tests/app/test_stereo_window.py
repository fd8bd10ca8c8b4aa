"""Stereo in a real window: pictures for both eyes, and text at the depth of the screen."""

import os
import re
from contextlib import closing

import numpy as np
import pytest
from PIL import ImageGrab

from subsea.app.dive import Dive
from subsea.resources import resource_path
from subsea.view.rigs import DISPLAYS
from subsea.view.stereo import PAGED

SIZE = (320, 200)
SHOWN = [name for name in DISPLAYS if name not in ("mono", PAGED)]


@pytest.fixture(scope="module")
def empty_sea(tmp_path_factory):
    """Water and one fish of each shoal, so that what is bright is text."""
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    path = tmp_path_factory.mktemp("sea") / "empty.toml"
    path.write_text(re.sub(r"^number = \d+", "number = 1", text, flags=re.MULTILINE))
    return path


def shown(running):
    import glfw

    running._context.finish()
    left, top = glfw.get_window_pos(running.window.handle)
    picture = ImageGrab.grab(xdisplay=os.environ["DISPLAY"])
    width, height = running.window.size
    return np.asarray(picture)[top : top + height, left : left + width, :3].astype(int)


@pytest.fixture(scope="module")
def windows(display, empty_sea):
    """The window of each mode with its help, and without any text."""
    pictures = {}
    for mode in ("mono", *SHOWN):
        with closing(Dive(str(empty_sea), mode, SIZE, seed=1)) as running:
            running.frame(0.1)
            running.frame(0.0)
            with_text = shown(running)
            running.overlay.draw = lambda *rest: None
            running.frame(0.0)
            running.frame(0.0)
            pictures[mode] = with_text, shown(running)
    return pictures


def text_in(pair):
    """Where letters are: bright with the panels, and not without."""
    return (pair[0].min(axis=2) > 130) & (pair[1].min(axis=2) < 110)


@pytest.mark.parametrize("mode", ["anaglyph", "anaglyph-comfort", "interlaced", "checkerboard"])
def test_text_lies_at_the_depth_of_the_screen(windows, mode):
    """Both eyes see it in the same place, which is where it is without stereo."""
    plain, stereo = text_in(windows["mono"]), text_in(windows[mode])
    assert plain.sum() > 500
    assert (plain & stereo).sum() > 0.8 * plain.sum()
    assert (stereo & ~plain).sum() < 0.2 * plain.sum()


@pytest.mark.parametrize(("mode", "axis"), [("side-by-side", 1), ("top-bottom", 0)])
def test_each_half_has_the_whole_text_squeezed(windows, mode, axis):
    one, other = np.split(text_in(windows[mode]), 2, axis=axis)
    assert one.sum() > 250
    assert (one == other).mean() > 0.98
    # The mono text, squeezed by leaving out every second line, is about there.
    plain = text_in(windows["mono"])
    squeezed = plain[:, ::2] if axis else plain[::2]
    assert (one == squeezed).mean() > 0.9


@pytest.mark.parametrize("mode", SHOWN)
def test_the_window_shows_what_the_mode_is_for(windows, mode):
    assert np.abs(windows[mode][1] - windows["mono"][1]).max() > 10
