"""The vessel of a theatre, drawn by every channel in its own perspective."""

import numpy as np
import pytest

from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import places_on
from subsea.stage.theatre.theatre_rig import theatre_rig
from subsea.view.rig import pose_from_angles, views
from subsea.view.surround import Surround, directions
from subsea.view.theatre_vessel import PANEL_SIZE, TheatreVessel

OBSERVER = pose_from_angles(np.array([0.0, -120.0, -200.0]), 0.3, 0.2)
WALLS = """
[[window]]
name = "left"
size = [240, 160]
[[window]]
name = "right"
size = [240, 160]
[[channel]]
name = "left"
window = "left"
angles = { left_deg = -40, right_deg = 25, down_deg = -30, up_deg = 30, heading_deg = -20 }
[[channel]]
name = "right"
window = "right"
angles = { left_deg = -25, right_deg = 40, down_deg = -30, up_deg = 30, heading_deg = 20 }
"""
DOME = """
[[window]]
name = "dome"
size = [320, 320]
[[channel]]
name = "dome"
window = "dome"
dome = { tilt_deg = 30 }
"""


@pytest.fixture
def drawn(context, scene, make_packet, tmp_path):
    """The channels of a theatre and the pictures of its windows, with a panel of one colour."""

    def draw(text, panel=None):
        path = tmp_path / "theatre.toml"
        path.write_text(text)
        theatre, _ = load_theatre(str(path))
        found, _ = usable_channels(theatre, path)
        rig = theatre_rig(theatre, found, range(len(theatre.window)))
        renderer = Renderer(context, scene, rig, PRESETS["low"])
        if panel is not None:
            renderer.vessel.panel(rig).clear(*panel)
        renderer.draw(make_packet([], views=views(rig, OBSERVER)))
        pictures = [renderer.read_pixels(k).astype(float) for k in range(len(rig.outputs))]
        renderer.release()
        return found, pictures

    return draw


def ways_at(azimuth_deg, elevation_deg):
    """Directions (n, 3) right, up, ahead."""
    turn, rise = np.radians(np.broadcast_arrays(azimuth_deg, elevation_deg))
    return np.stack(
        [np.sin(turn) * np.cos(rise), np.sin(rise), np.cos(turn) * np.cos(rise)], axis=-1
    )


def colours(one, picture, ways):
    """Colours (n, 3) of a flat channel's picture in directions (n, 3)."""
    height, width = picture.shape[:2]
    x, y = (places_on(one.screen, ways) * [width, height]).T
    return picture[(height - 1 - y).round().astype(int), (x - 0.5).round().astype(int)]


VESSEL = "[vessel]\nspring_deg = -14\nrim_deg = 6\ninstruments = false\n"


def test_neighbours_show_the_same_rim(drawn):
    """Each direction in the overlap has one colour, in the hull, on the plates and on the tube."""
    (left, right), (one, other) = drawn(WALLS + VESSEL)
    _, (bare, _) = drawn(WALLS)
    azimuth, elevation = np.meshgrid(np.linspace(-4.0, 4.0, 8), [-24.0, -18.0, -12.3, -10.0])
    ways = ways_at(azimuth.ravel(), elevation.ravel())
    first, second = colours(left, one, ways), colours(right, other, ways)
    assert np.abs(first - second).max() <= 3.0
    assert np.abs(first - colours(left, bare, ways)).mean() > 10.0
    # The upper edge lies at the same height in both.
    up = ways_at(-2.0, np.linspace(-12.0, -4.0, 120))
    edges = [
        np.argmax(np.abs(np.diff(colours(a, b, up).mean(axis=1)))) for a, b in
        ((left, one), (right, other))
    ]  # fmt: skip
    assert abs(edges[0] - edges[1]) <= 6  # of a fifteenth of a degree: a pixel


def test_plates_differ_along_the_rim_and_the_sea_above_is_untouched(drawn):
    (left, _), (one, _) = drawn(WALLS + VESSEL)
    _, (bare, _) = drawn(WALLS)
    along = colours(left, one, ways_at(np.linspace(-50.0, -6.0, 60), -11.0)).mean(axis=1)
    assert along.max() > 1.15 * along.min() > 10.0
    sea = ways_at(np.linspace(-50.0, -6.0, 60), 5.0)
    np.testing.assert_allclose(colours(left, one, sea), colours(left, bare, sea), atol=1.5)


def test_without_a_table_nothing_is_drawn(drawn):
    _, pictures = drawn(WALLS)
    _, again = drawn(WALLS + "[room]\n")
    for one, other in zip(pictures, again, strict=True):
        np.testing.assert_array_equal(one, other)


def test_on_a_dome_the_rim_follows_its_edge_and_the_panel_is_in_front_and_level(drawn):
    """The lower edge of a tilted dome is its rim; text stands upright over it, ahead."""
    table = "[vessel]\nrim_deg = 8\ntilt_deg = 30\npanel_deg = 40\n"
    _, (bare,) = drawn(DOME)
    _, (shown,) = drawn(DOME + table, panel=(1.0, 0.0, 0.0, 1.0))
    x, y = np.meshgrid(np.arange(320) + 0.5, 319.5 - np.arange(320))
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    ways = directions("dome", (320, 320), Surround(tilt_deg=30.0), pixels).reshape(320, 320, 3)
    away = np.hypot(x - 160, y - 160) / 160 * 90.0  # degrees from the middle of the dome
    changed = np.abs(shown - bare).max(axis=2) > 6.0
    red = (shown[..., 0] > 120) & (shown[..., 1] < 90)
    assert changed[(away > 83.5) & (away < 89)].mean() > 0.97
    assert changed[(away < 80.0) & ~red & (away > 0)].mean() < 0.05
    azimuth = np.degrees(np.arctan2(ways[..., 0], ways[..., 2]))[red]
    assert len(azimuth) > 500
    assert abs(azimuth.mean()) < 0.5
    assert np.ptp(azimuth) == pytest.approx(40.0, abs=6.0)
    # Its foot is one straight level line: the intersection of rays with the panel's plane.
    vessel = TheatreVessel(500.0, 0.0, np.radians(8), np.radians(30), np.radians(40))
    panel = vessel.panel
    assert panel.right[1] == panel.right[2] == panel.up[0] == 0.0
    assert panel.up[1] > 0.0
    assert np.linalg.norm(panel.right) / np.linalg.norm(panel.up) == pytest.approx(
        PANEL_SIZE[0] / PANEL_SIZE[1]
    )
    hits = [panel.hit(np.zeros(3), way) for way in ways[red]]
    assert np.mean([hit is not None for hit in hits]) > 0.97


def test_only_the_channel_that_faces_it_shows_the_panel(drawn):
    cave = load_theatre("cave")[1].read_text().replace("1024", "128").replace("2048", "256")
    table = "\n[vessel]\nspring_deg = -25\npanel_deg = 60\n"
    _, pictures = drawn(cave + table, panel=(1.0, 0.0, 0.0, 1.0))
    red = [((p[..., 0] > 120) & (p[..., 1] < 90)).mean() for p in pictures]
    assert red[1] > 0.1
    assert red[0] == red[2] == 0.0
    rows = [np.flatnonzero(r) for r in (pictures[1][..., 0] > 120) & (pictures[1][..., 1] < 90)]
    ends = np.array([(row[0], row[-1]) for row in rows if len(row) > 20])
    assert np.abs(ends.sum(axis=1) - 127).max() <= 2  # level: the same to the left and the right
