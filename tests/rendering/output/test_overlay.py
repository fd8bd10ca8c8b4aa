"""A fisheye picture over the sea: its place in a dome and on a flat screen, and how it fades."""

import numpy as np
import pytest

from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.view.display_rigs import display_rig
from subsea.view.fisheye import FAR_CM, Fisheye, fisheye_mesh
from subsea.view.rig import pose_from_angles, views
from subsea.view.stereo import EYES
from subsea.view.surround import Surround

OBSERVER = pose_from_angles(np.array([0.0, -120.0, -200.0]), 0.3, 0.2)
TILT, ANGLE = np.radians(30.0), np.pi


def dotted(x, y):
    """A picture with an opaque yellow disc at a place in shares of it from its upper left."""
    rows, columns = np.mgrid[:256, :256]
    disc = np.hypot(columns + 0.5 - 256 * x, rows + 0.5 - 256 * y) < 12.0
    return Fisheye((disc[..., None] * [255, 230, 0, 255]).astype(np.uint8), TILT, ANGLE)


@pytest.fixture
def drawn(context, scene, make_packet):
    """Draw with an overlay, for a display mode of a size."""

    def draw(mode, size, overlay, opacity=1.0):
        rig = display_rig(mode, size, EYES, Surround(tilt_deg=30.0, dome_deg=180.0))
        renderer = Renderer(context, scene, rig, PRESETS["low"])
        renderer.overlay.shown, renderer.overlay.opacity = overlay, opacity
        renderer.draw(make_packet([], views=views(rig, OBSERVER)))
        picture = renderer.read_pixels(0).astype(float)
        renderer.release()
        return picture

    return draw


def middle_of(change):
    """The middle of what has changed, in shares of a picture from its upper left."""
    rows, columns = np.nonzero(change.sum(axis=-1) > 60.0)
    assert len(rows)
    return (columns.mean() + 0.5) / change.shape[1], (rows.mean() + 0.5) / change.shape[0]


def test_corners_lie_where_a_fisheye_has_them():
    corners = fisheye_mesh(TILT, ANGLE)
    places, shares = corners[:, :3] / FAR_CM, corners[:, 3:5]
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), 1.0, atol=1e-9)
    zenith = places[np.abs(shares - 0.5).max(axis=1) < 1e-9][0]
    np.testing.assert_allclose(zenith, [0.0, np.cos(TILT), np.sin(TILT)], atol=1e-9)
    foot = places[np.abs(shares - [0.5, 0.0]).max(axis=1) < 1e-9][0]
    np.testing.assert_allclose(foot, [0.0, -np.sin(TILT), np.cos(TILT)], atol=1e-9)


@pytest.mark.nightly
@pytest.mark.parametrize("place", [(0.5, 0.5), (0.5, 0.8), (0.25, 0.6), (0.8, 0.35)])
def test_a_dome_shows_it_where_it_is_in_the_picture(drawn, place):
    bare, shown = (drawn("dome", (256, 256), one) for one in (None, dotted(*place)))
    assert middle_of(np.abs(shown - bare)) == pytest.approx(place, abs=0.006)
    row, column = (int(256 * share) for share in place[::-1])
    assert np.abs(shown[row, column] - [255, 230, 0]).max() < 26  # as a final colour


def test_a_flat_screen_shows_it_in_its_direction(drawn):
    """15 degrees above the foot of a dome tilted by 30 is 15 degrees below ahead."""
    bare, shown = (
        drawn("mono", (320, 240), one) for one in (None, dotted(0.5, 1.0 - 15.0 / 180.0))
    )
    rig = display_rig("mono", (320, 240), EYES, Surround())
    high = rig.eyes[0].projection[1, 1] * np.tan(np.radians(-15.0))
    assert middle_of(np.abs(shown - bare)) == pytest.approx((0.5, 0.5 - 0.5 * high), abs=0.01)


def test_it_fades_and_goes(drawn):
    place = dotted(0.5, 0.6)
    bare = drawn("dome", (128, 128), None)
    whole, half, gone = (drawn("dome", (128, 128), place, one) for one in (1.0, 0.5, 0.0))
    change = [np.abs(one - bare).sum() for one in (whole, half, gone)]
    assert change[2] == 0.0 and 0.2 * change[0] < change[1] < 0.9 * change[0]
