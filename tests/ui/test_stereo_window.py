"""Stereo in a real window: pictures for both eyes, and text at the depth of the screen."""

from contextlib import closing

import numpy as np
import pytest
from imgui_bundle import imgui

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.ui.dive import Dive
from subsea.view.display_rigs import DISPLAYS
from subsea.view.front_screen import TextViewport
from subsea.view.stereo import PAGED
from tests.support.windows import QUIET

SIZE = (640, 400)
SHOWN = [name for name in DISPLAYS if name not in ("mono", PAGED)]


class Bold(TextViewport):
    """A full-width window with the bold text of squeezed viewports."""

    squeezed = True


@pytest.fixture(scope="module")
def windows(display, user, quiet, coarse):
    """The window of each mode, with its help and without any text."""
    pictures = {}

    def shown(running):
        running.frame(0.0)
        running.frame(0.0)
        running.picture.finish()
        return user.screen(running)

    options = DisplayOptions("mono", SIZE, quality=coarse)
    with closing(Dive(DiveOptions(quiet, seed=1, display=options, settings=QUIET))) as running:
        running.overlay.show_help()
        running.frame(0.1)
        draw = running.overlay.draw
        for mode in ("mono", *SHOWN):
            running.picture.show_as(mode)
            running.overlay.draw = draw
            with_text = shown(running)
            if mode == "mono":
                running.picture.viewports = (Bold(),)
                bold = shown(running)
            running.overlay.draw = lambda *rest: None
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


@pytest.mark.nightly
def test_the_pointer_is_drawn_for_each_eye_while_panels_take_it(display, user, quiet, coarse):
    options = DisplayOptions("side-by-side", SIZE, quality=coarse)
    with closing(Dive(DiveOptions(quiet, seed=1, display=options, settings=QUIET))) as running:
        running.overlay.draw = lambda *rest: None
        running.inspector.toggle()
        running.tick_source.advance = lambda elapsed_s: 1.0  # paused time

        def pictures(*place):
            user.do(
                "mousemove", *(a + b for a, b in zip(running.window.position, place, strict=True))
            )
            user.glide(running, 0.3)
            return np.split(running.window_set.picture().astype(int), 2, axis=1)

        away, here = pictures(60, 350), pictures(160, 200)
        for before, after in zip(away, here, strict=True):
            changed = np.abs(after - before).max(axis=2)[180:240, 150:200] > 100
            assert changed.sum() > 20
        running.inspector.toggle()
        running.frame(0.0)
        assert not imgui.get_io().mouse_draw_cursor
