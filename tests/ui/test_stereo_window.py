"""Stereo in a real window: pictures for both eyes, and text at the depth of the screen."""

import os
import re
from contextlib import closing

import numpy as np
import pytest
from PIL import ImageGrab

from subsea.core.resources import resource_path
from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.ui.dive import Dive
from subsea.view.display_rigs import DISPLAYS
from subsea.view.stereo import PAGED
from subsea.view.text_viewports import TextViewport

SIZE = (640, 400)
SHOWN = [name for name in DISPLAYS if name not in ("mono", PAGED)]


@pytest.fixture(scope="module")
def empty_sea(tmp_path_factory):
    """Water and one fish of each shoal, so that only text is bright."""
    text = (resource_path("assets/scenarios") / "peaceful.toml").read_text()
    path = tmp_path_factory.mktemp("sea") / "empty.toml"
    path.write_text(re.sub(r"^number = \d+", "number = 1", text, flags=re.MULTILINE))
    return path


class Bold(TextViewport):
    """A full-width window with the bold text of squeezed viewports."""

    squeezed = True


def shown(running):
    import glfw

    running.picture.finish()
    left, top = glfw.get_window_pos(running.window.handle)
    picture = ImageGrab.grab(xdisplay=os.environ["DISPLAY"])
    width, height = running.window.size
    return np.asarray(picture)[top : top + height, left : left + width, :3].astype(int)


@pytest.fixture(scope="module")
def windows(display, empty_sea):
    """The window of each mode, with its help and without any text."""
    pictures = {}
    for mode in ("mono", *SHOWN):
        with closing(
            Dive(DiveOptions(str(empty_sea), seed=1, display=DisplayOptions(mode, SIZE)))
        ) as running:
            running.frame(0.1)
            running.frame(0.0)
            with_text = shown(running)
            if mode == "mono":
                running.picture.viewports = (Bold(),)
                running.frame(0.0)
                running.frame(0.0)
                bold = shown(running)
            running.overlay.draw = lambda *rest: None
            running.frame(0.0)
            running.frame(0.0)
            pictures[mode] = with_text, shown(running)
            if mode == "mono":
                pictures["bold"] = bold, pictures["mono"][1]
    return pictures


def text_in(pair):
    """A mask of letters: pixels that are bright only with the panels."""
    return (pair[0].min(axis=2) > 130) & (pair[1].min(axis=2) < 110)


def light_in(pair):
    """The increase in brightness of each pixel by the panels."""
    return (pair[0] - pair[1]).mean(axis=2).clip(0)


@pytest.mark.parametrize("mode", ["anaglyph", "anaglyph-comfort", "interlaced", "checkerboard"])
def test_text_lies_at_the_depth_of_the_screen(windows, mode):
    """Both eyes see text in the same place as without stereo."""
    plain, stereo = text_in(windows["mono"]), text_in(windows[mode])
    assert plain.sum() > 500
    assert (plain & stereo).sum() > 0.8 * plain.sum()
    assert (stereo & ~plain).sum() < 0.2 * plain.sum()


@pytest.mark.parametrize(("mode", "axis"), [("side-by-side", 1), ("top-bottom", 0)])
def test_each_half_has_the_whole_text_squeezed(windows, mode, axis):
    one, other = np.split(text_in(windows[mode]), 2, axis=axis)
    assert one.sum() > 250
    assert (one == other).mean() > 0.98


@pytest.mark.parametrize(("mode", "axis"), [("side-by-side", 1), ("top-bottom", 0)])
def test_no_stroke_is_lost_where_text_is_squeezed(windows, mode, axis):
    """Every letter is about as bright as the mean of its pixels at full width."""
    half = np.split(light_in(windows[mode]), 2, axis=axis)[0]
    height, width = half.shape
    whole = light_in(windows["bold"])
    even = whole.reshape(height, 1, width, 2) if axis else whole.reshape(height, 2, width, 1)
    averages = even.mean(axis=(1, 3))
    letters = averages > 60
    assert letters.sum() > 400
    assert np.corrcoef(half[letters], averages[letters])[0, 1] > 0.86
    assert (half[letters] > 20).mean() > 0.85


@pytest.mark.parametrize("mode", SHOWN)
def test_the_window_shows_what_the_mode_is_for(windows, mode):
    assert np.abs(windows[mode][1] - windows["mono"][1]).max() > 10
