"""Each of several views of a packet looks and costs the same as if drawn alone."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.frame.packet import make_scene, pack
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.rendering.sea import water
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import Helm
from subsea.view.camera import NEAR_CM, axes_of, off_axis
from subsea.view.display_rigs import DISPLAYS, SURROUNDS, display_rig
from subsea.view.levels import LodState, empty_lod_state
from subsea.view.rig import CameraRig, DisplayPatch, Eye, pose_from_angles, views
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import examples, only

SIZE = (96, 64)
# Shadows of fishes lie in all views: a fish outside a view may darken sand in it.
QUALITY = replace(PRESETS["low"], shadows=False)


class Sea:
    """A world and a renderer."""

    def __init__(self, context):
        self.world = create_world(load_scenario("peaceful")[0])
        for _ in range(30):
            step(self.world, Helm(surge=0.5))
        rig = display_rig("mono", SIZE)
        self.renderer = Renderer(context, make_scene(self.world), rig, QUALITY)
        # The first picture has calls of its own: each program draws once.
        self.draw(views(rig, self.observer(0.0, 0.0)), self.nothing())

    def nothing(self):
        return empty_lod_state(len(self.world.state.fishes.species))

    def observer(self, heading, pitch):
        return pose_from_angles(self.world.state.submarine.position, heading, pitch)

    def draw(self, seen, memory, lod=True):
        """The picture of some views, its triangles and its drawing calls."""
        return self.drawn(self.pack(seen, memory, lod))

    def pack(self, seen, memory, lod=True):
        return pack(
            self.world, seen, 1.0, replace(QUALITY.packing, lod=lod), memory=memory
        )  # fmt: skip

    def drawn(self, packet):
        self.renderer.draw(packet)
        picture = self.renderer.read_pixels().astype(int)
        return picture, self.renderer.triangles, self.renderer.draw_calls


@pytest.fixture(scope="module")
def sea(context):
    sea = Sea(context)
    yield sea
    sea.renderer.release()


def plain(canvas, eyes, level=False):
    """A rig that shows its canvas unchanged."""
    whole = (0, 0, *canvas)
    return CameraRig(canvas, (canvas,), eyes, (DisplayPatch(whole, whole, whole),), level)


def channels(turns, half_tangent, size):
    """Flat channels side by side, turned to the right by angles in radians."""
    width, height = size
    near = NEAR_CM * half_tangent
    up = near * height / width
    eyes = []
    for k, turn in enumerate(turns):
        cos, sin = np.cos(turn), np.sin(turn)
        axes = np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
        frustum = off_axis(-near, near, -up, up)
        eyes.append(Eye((k * width, 0, width, height), np.zeros(3), axes, frustum))
    return plain((len(turns) * width, height), tuple(eyes))


@pytest.mark.parametrize("display", only(("mono", "anaglyph", "dome"), DISPLAYS))
@given(heading=st.floats(-3.0, 3.0), pitch=st.floats(-0.5, 0.3))
@settings(max_examples=examples(1))
def test_a_view_shows_and_costs_what_it_does_alone(sea, display, heading, pitch):
    rig = display_rig(display, SIZE)
    rig = plain(rig.canvas, rig.eyes, rig.level)
    sea.renderer.arrange(rig)
    seen = views(rig, sea.observer(heading, pitch))
    memory = sea.nothing()
    # One of two eyes may see a leaf just too small for the level that both share.
    lod = display in ("mono", *SURROUNDS)
    # Forget the levels of detail of earlier pictures: an item out of sight has none.
    for one in (seen, *((view,) for view in seen)):
        sea.draw(one, sea.nothing(), lod)
    triangles, calls = [], []
    for view in seen:
        # Each after all of them, as all share the levels of detail.
        picture, every, all_calls = sea.draw(seen, memory, lod)
        kept = LodState(*(part.copy() for part in memory))
        alone, *cost = sea.draw((view,), kept, lod)
        triangles.append(cost[0])
        calls.append(cost[1])
        x, y, width, height = view.viewport
        part = np.s_[rig.canvas[1] - y - height : rig.canvas[1] - y, x : x + width]
        np.testing.assert_array_equal(picture[part], alone[part])
        assert alone[part].std() > 5.0
    assert every == sum(triangles)
    assert all_calls <= sum(calls) <= len(seen) * max(calls)


@pytest.mark.parametrize("display", ["mono", "dome"])
def test_specks_and_surface_that_a_view_does_not_see_leave_no_gap(sea, display, monkeypatch):
    """Leaving them out changes no picture."""
    rig = display_rig(display, (320, 180))
    sea.renderer.arrange(rig)
    every = np.flatnonzero(sea.world.state.sea.absent <= 0.0)
    assert len(every) > 1000
    for pitch in (-0.9, -0.3, 0.4):
        seen = views(rig, sea.observer(0.4, pitch))
        packet = sea.pack(seen, sea.nothing())
        assert 0 < len(packet.plankton_seen[0]) < 0.5 * len(every)
        chosen, few, _ = sea.drawn(packet)
        with monkeypatch.context() as patch:
            patch.setattr(water, "highest", lambda view: 1.0)
            full, many, _ = sea.drawn(replace(packet, plankton_seen=(every,) * len(seen)))
        np.testing.assert_array_equal(chosen, full)
        assert (few < many) == any(water.highest(view) < 0.0 for view in seen)
    assert water.highest(views(display_rig("mono", SIZE), sea.observer(0.4, -0.9))[0]) < 0.0


def test_a_view_that_shows_less_has_fewer_cells_of_water():
    observer = pose_from_angles(np.array([0.0, 0.0, -300.0]), 0.0, 0.0)
    (plain,) = views(display_rig("mono", (1280, 720)), observer)
    for cells in (water.COARSE, water.FINE):
        assert water.cells_for(plain, cells) == cells
        for view in views(channels((-0.8, 0.0, 0.8), np.tan(0.4), SIZE), observer):
            across, down = water.cells_for(view, cells)
            tangents = 1.0 / np.diag(view.projection)[:2]
            whole = 1.0 / np.diag(plain.projection)[:2]
            assert across / cells[0] == pytest.approx(tangents[0] / whole[0], abs=0.07)
            assert down / cells[1] == pytest.approx(tangents[1] / whole[1], abs=0.06)


def test_channels_side_by_side_cost_about_what_one_wide_view_does(sea):
    """Three views, each half a right angle wide, as fine as one view of the same angle."""
    half = np.pi / 8
    turns = (-2 * half, 0.0, 2 * half)
    three = channels(turns, np.tan(half), SIZE)
    # As many pixels per radian straight ahead, and as wide and high as the three.
    wide_size = (round(SIZE[0] * np.tan(3 * half) / np.tan(half)), SIZE[1] * 2)
    wide = channels((0.0,), np.tan(3 * half), wide_size)
    found = []
    for rig in (three, wide):
        sea.renderer.arrange(rig)
        _, triangles, calls = sea.draw(views(rig, sea.observer(0.4, -0.1)), sea.nothing())
        found.append((triangles, calls))
    (triangles, calls), (wide_triangles, wide_calls) = found
    assert triangles < 1.5 * wide_triangles
    assert calls <= 3 * wide_calls


@pytest.mark.nightly
@pytest.mark.parametrize("quality", ["low", "high"])
def test_a_tilted_head_sees_the_same_sea(sea, quality):
    """A quarter turn of the head turns the picture: nothing in it stays with the screen."""
    part, pictures = (0, 0, 96, 96), []
    sea.renderer.adapt(PRESETS[quality])
    for roll in (0.0, np.pi / 2.0):
        axes = axes_of(0.0, 0.2, roll)
        eye = Eye(part, np.zeros(3), axes, off_axis(-4.0, 4.0, -4.0, 4.0))
        rig = plain((96, 96), (eye,))
        sea.renderer.arrange(rig)
        pictures.append(sea.draw(views(rig, sea.observer(0.3, 0.0)), sea.nothing())[0])
    sea.renderer.adapt(QUALITY)
    level, tilted = pictures
    off = np.abs(np.rot90(tilted, -1) - level)
    assert level.std() > 10.0 and off.mean() < 0.8
    assert (off.max(axis=2) > 12).mean() < 0.01
