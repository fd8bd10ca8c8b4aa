"""The placement of text."""

import numpy as np
import pytest

from subsea.view.display_rigs import DISPLAYS, display_rig
from subsea.view.front_screen import text_viewports
from subsea.view.stereo import LAYOUTS, patches_of

SIZE = (800, 600)


def page(number):
    """Draw nothing."""


def corners(viewport):
    """The corners (4, 2) of a viewport, in pixels from the middle of the window."""
    x, y = (viewport.x, viewport.x + viewport.width), (viewport.y, viewport.y + viewport.height)
    return (np.array([(a, b) for a in x for b in y]) - 0.5) * SIZE


def check_dome(off, radius):
    """Text lies in front, which is below, with its lower corners on the rim."""
    far, below = np.linalg.norm(off, axis=1), off[:, 1]
    np.testing.assert_allclose(far[below > 1.0 + below.min()], radius, atol=2.5)
    assert far.max() < radius + 2.5
    assert below.max() > 0.75 * radius and below.min() > -0.2 * radius


@pytest.mark.parametrize("display", [name for name in DISPLAYS if name != "dome"])
def test_text_has_all_of_the_window_in_the_part_of_each_eye(display):
    found = text_viewports(display_rig(display, SIZE), page)
    assert all(viewport.screen == (1.0, 1.0) for viewport in found)
    area = sum(viewport.width * viewport.height for viewport in found)
    assert area == pytest.approx(2.0 if display == "stereo" else 1.0)


def test_on_a_dome_text_stands_within_the_circle():
    (viewport,) = text_viewports(display_rig("dome", SIZE), page)
    assert viewport.screen == pytest.approx((viewport.width, viewport.height))
    check_dome(corners(viewport), min(SIZE) / 2)


@pytest.mark.parametrize("layout", ["side-by-side", "top-bottom"])
def test_both_eyes_of_a_dome_have_the_same_text_within_their_circles(layout):
    rig = display_rig("dome", SIZE)
    rig = rig._replace(patches=patches_of(LAYOUTS[layout], rig.patches[0]))
    left, right = text_viewports(rig, page)
    assert left.screen == right.screen
    squeezed = rig.patches[0].squeezed
    for viewport, patch in zip((left, right), rig.patches, strict=True):
        assert viewport.screen[0] / viewport.width == pytest.approx(squeezed[0], abs=0.02)
        assert viewport.screen[1] / viewport.height == pytest.approx(squeezed[1], abs=0.02)
        x, y, width, height = patch.place
        middle = np.array([x + width / 2, SIZE[1] - y - height / 2]) - np.array(SIZE) / 2
        off = (corners(viewport) - middle) * squeezed
        check_dome(off, min(SIZE) / 2)
