"""Rigs of theatres: every eye, mesh and patch puts a point of the sea where the screen has it."""

from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.base.system import resource_names
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from subsea.stage.theatre.theatre_file import FOLDER, Channel, Cylinder, Plane, Theatre, Window
from subsea.stage.theatre.theatre_rig import MODES, shelves, theatre_rig, visible_channels
from subsea.view.camera import axes_of
from subsea.view.rig import CUBES, Projection, pose_from_angles, sources_at, views
from subsea.view.stereo import EYES, Stereo
from subsea.view.surround import MARGIN_PX, directions

EYE = np.array([10.0, 20.0, -300.0])
OBSERVER = pose_from_angles(EYE, 0.7, -0.2)
AXES = np.stack([np.cross(OBSERVER.forward, OBSERVER.up), OBSERVER.up, OBSERVER.forward])
NAMES = resource_names(FOLDER, ".toml")
WALLS = ["three-projectors", "cave", "wide"]


@cache
def opened(name):
    """A theatre and its channels, whose meshes and masks take long; nobody changes them."""
    theatre, path = load_theatre(name)
    return theatre, usable_channels(theatre, path)[0]


def rig_of(name, display="mono", stereo=EYES):
    theatre, found = opened(name)
    return theatre_rig(theatre, found, range(len(theatre.window)), display, stereo)


@pytest.mark.parametrize("display", MODES)
@pytest.mark.parametrize("name", NAMES)
def test_pictures_lie_apart_on_the_canvas_and_patches_in_their_windows(name, display):
    rig = rig_of(name, display)
    covered = np.zeros(rig.canvas, int)
    for x, y, w, h in (eye.viewport for eye in rig.eyes):
        assert w > 0
        assert h > 0
        covered[x : x + w, y : y + h] += 1
    assert covered.max() == 1
    lit = {}
    for patch in rig.patches:
        x, y, w, h = patch.place
        width, height = rig.outputs[patch.output]
        picture = lit.setdefault((patch.output, patch.page), np.zeros((width, height), int))
        picture[x : x + w, y : y + h] += 1
        for u, v, across, up in (patch.left, patch.right):
            assert u + across <= rig.canvas[0]
            assert v + up <= rig.canvas[1]
    assert len(lit) == len(rig.outputs) * rig.pages
    assert all((picture == 1).all() for picture in lit.values())


def missed(theatre, found, display, places, away):
    """By how many of its pixels each patch misses points behind places (k, 2) of its screen.

    Those lie `away` (k,) as far as the screen. One number (2,) for both eyes of a patch: canvas,
    mesh and place against the screen's geometry.
    """
    rig = theatre_rig(theatre, found, range(len(theatre.window)), display)
    seen = dict(zip([eye.viewport for eye in rig.eyes], views(rig, OBSERVER), strict=True))
    for patch in rig.patches:
        one, most = found[patch.channel], []
        for side, (x, y, w, h) in enumerate((patch.left, patch.right)):
            view = seen[x - MARGIN_PX, y - MARGIN_PX, w + 2 * MARGIN_PX, h + 2 * MARGIN_PX]
            offset = AXES @ (view.eye - EYE)
            on_screen = points_on(one.screen, places)
            points = EYE + (offset + away[:, None] * (on_screen - offset)) @ AXES
            clip = np.column_stack([points, np.ones(len(points))]) @ (view.projection @ view.view).T
            pixels = (0.5 + 0.5 * clip[:, :2] / clip[:, 3:]) * view.viewport[2:]
            uv = (pixels - MARGIN_PX) / [w, h]
            expected = places if patch.warp is None else sources_at(patch.warp, places, side)
            most.append(np.abs((uv - expected) * patch.place[2:]).max())
        yield patch, most


# A fiftieth of a pixel for the matrices' rounding, a third for the mesh's pieces.
FLAT_PX, CURVED_PX = 0.02, 0.34


@pytest.mark.parametrize("display", ["mono", "anaglyph", "side-by-side"])
@pytest.mark.parametrize("name", WALLS)
def test_a_point_of_the_sea_lands_where_its_ray_meets_the_screen(name, display):
    theatre, found = opened(name)
    rng = np.random.default_rng(4)
    places, away = rng.uniform(0.05, 0.95, (40, 2)), rng.uniform(0.5, 8.0, 40)
    tried = 0
    for patch, most in missed(theatre, found, display, places, away):
        assert max(most) < (FLAT_PX if patch.warp is None else CURVED_PX)
        tried += 1
    assert tried == len(found) * (2 if display == "side-by-side" else 1)


def a_plane(heading, pitch, far, wide, high, aside, above):
    """A rectangle in any direction, whose middle need not be ahead in it."""
    right, up, ahead = axes_of(heading, pitch)
    corner = far * ahead + (aside - wide / 2) * right + (above - high / 2) * up
    corners = corner, corner + wide * right, corner + high * up
    return Plane(
        **dict(zip(("lower_left", "lower_right", "upper_left"), map(tuple, corners), strict=True))
    )


def a_cylinder(radius, left, turn, bottom, high, aside, ahead):
    return Cylinder(
        radius_cm=radius,
        left_deg=left,
        right_deg=left + turn,
        bottom_cm=bottom,
        top_cm=bottom + high,
        axis_cm=(aside * radius, ahead * radius),
    )


def between(low, high):
    return st.floats(low, high)


PLANES = st.builds(
    a_plane, between(-3, 3), between(-1.5, 1.5), between(80, 900), between(60, 400),
    between(60, 300), between(-100, 100), between(-100, 100),
)  # fmt: skip
CYLINDERS = st.builds(
    a_cylinder, between(150, 900), between(-170, 50), between(10, 100), between(-200, -20),
    between(60, 300), between(-0.15, 0.15), between(-0.15, 0.15),
)  # fmt: skip
HERE = st.tuples(between(-15, 15), between(-15, 15), between(-15, 15))


@given(
    screens=st.lists(st.one_of(PLANES, CYLINDERS), min_size=1, max_size=3),
    eye=HERE,
    scale=between(0.2, 5.0),
    display=st.sampled_from(["mono", "anaglyph", "side-by-side", "top-bottom"]),
    places=st.lists(st.tuples(between(0.05, 0.95), between(0.05, 0.95)), min_size=1, max_size=9),
    away=between(0.5, 8.0),
)
def test_so_it_does_on_any_screen_from_any_place(screens, eye, scale, display, places, away):
    names = [str(k) for k in range(len(screens))]
    theatre = Theatre(
        eye_cm=eye,
        scale=scale,
        window=[Window(name=name, size=(640, 480)) for name in names],
        channel=[
            Channel(name=name, window=name, **{type(screen).__name__.lower(): screen})
            for name, screen in zip(names, screens, strict=True)
        ],
    )
    try:
        found, _ = usable_channels(
            theatre, Path("any.toml")
        )  # those too much from the side left out
    except UserError:
        found = ()
    found, _ = visible_channels(theatre, found, display) if found else ((), ())
    assume(found)
    whole = np.array(places)
    for patch, most in missed(theatre, found, display, whole, np.full(len(whole), away)):
        assert max(most) < (FLAT_PX if patch.warp is None else CURVED_PX)


@pytest.mark.parametrize("name", NAMES)
def test_swapped_eyes_and_their_distance(name):
    eyes = {
        swapped: rig_of(name, "anaglyph", Stereo(separation_cm=10.0, swapped=swapped)).eyes
        for swapped in (False, True)
    }
    offsets = {swapped: [eye.offset[0] for eye in found] for swapped, found in eyes.items()}
    assert set(offsets[False]) == {-5.0, 5.0}
    assert offsets[True] == [-x for x in offsets[False]]
    limited = rig_of(name, "anaglyph", Stereo(separation_cm=10.0, comfort_deg=0.5)).eyes
    assert 0 < limited[0].offset[0] * -1 < 5.0


def test_a_theatre_of_half_the_scale_has_half_the_distance_between_the_eyes():
    theatre, found = opened("cave")
    small = msgspec.structs.replace(theatre, scale=0.5)
    path = load_theatre("cave")[1]
    rig = theatre_rig(small, usable_channels(small, path)[0], [0, 1, 2], "anaglyph")
    whole = theatre_rig(theatre, found, [0, 1, 2], "anaglyph")
    assert rig.eyes[0].offset[0] == pytest.approx(0.5 * whole.eyes[0].offset[0])
    for one, other in zip(rig.eyes, whole.eyes, strict=True):
        np.testing.assert_allclose(one.projection, other.projection, atol=1e-6)


def test_a_node_shows_its_own_windows_with_the_masks_of_all():
    theatre, found = opened("three-computers")
    alone = theatre_rig(theatre, found, [1])
    assert alone.outputs == (theatre.window[1].size,)
    assert {patch.output for patch in alone.patches} == {0}
    together = theatre_rig(theatre, found, [0, 1, 2])
    np.testing.assert_array_equal(alone.patches[0].mask, together.patches[1].mask)
    assert alone.patches[0].mask.min() < 0.1


@pytest.mark.parametrize("name", ["dome", "equirectangular"])
def test_a_surround_channel_has_a_cube_for_each_eye(name):
    mono, stereo = rig_of(name), rig_of(name, "side-by-side")
    assert mono.patches[0].shape in CUBES
    assert len(stereo.eyes) == 2 * len(mono.eyes)
    left, right = stereo.patches
    assert left.apart == -right.apart > 0
    assert left.left[2:] == mono.patches[0].left[2:]
    assert left.left != right.left


def test_a_curved_screen_is_nowhere_coarser_than_its_projector():
    rig = rig_of("three-projectors")
    for patch in rig.patches:
        assert patch.shape == Projection.WARPED
        grid = patch.warp.vertices.reshape(9, -1, 6)
        across = np.diff(grid[..., 0], axis=1) * patch.place[2]
        drawn = np.diff(grid[..., 2], axis=1) * patch.left[2]
        assert (drawn / across).min() > 0.995
        assert (drawn / across).max() < 1.3


def test_shelves_hold_everything_once_and_are_no_wider_than_they_must():
    corners, size = shelves([(5000, 100), (4000, 300), (4000, 50), (9000, 10)])
    assert corners == [(0, 0), (5000, 0), (0, 300), (0, 350)]
    assert size == (9000, 360)
    covered = np.zeros((size[0] // 10, size[1] // 10), int)
    for (x, y), (w, h) in zip(
        corners, [(5000, 100), (4000, 300), (4000, 50), (9000, 10)], strict=True
    ):
        covered[x // 10 : (x + w) // 10, y // 10 : (y + h) // 10] += 1
    assert covered.max() == 1


UNEQUAL = "".join(
    f'[[window]]\nname = "{name}"\nsize = [64, 64]\n[[channel]]\nname = "{name}"\n'
    f'window = "{name}"\nangles = {{ left_deg = -40, right_deg = 40, down_deg = -40, '
    f"up_deg = 40, heading_deg = {heading}, distance_cm = {far} }}\n"
    for name, heading, far in (("left", -80, 90), ("front", 0, 400), ("right", 80, 250))
)


def unequal(tmp_path):
    (tmp_path / "unequal.toml").write_text(UNEQUAL)  # each test has another folder
    return opened(str(tmp_path / "unequal.toml"))


def test_all_computers_have_the_same_eyes_whatever_their_screens(tmp_path):
    theatre, found = unequal(tmp_path)
    limit = Stereo(comfort_deg=2.0)
    offsets = {
        eye.offset[0]
        for windows in ([0], [1], [2], [0, 1, 2])
        for eye in theatre_rig(theatre, found, windows, "anaglyph", limit).eyes
    }
    half = np.radians(2.0) * 90 / 2  # as the nearest of all screens bears it
    assert sorted(offsets) == pytest.approx([-half, half])


def test_a_screen_behind_an_eye_is_reported_and_the_others_stay(tmp_path):
    theatre, found = unequal(tmp_path)
    apart = Stereo(separation_cm=200.0)
    with pytest.raises(UserError, match="channel 'left': the eye is behind"):
        theatre_rig(theatre, found, [0, 1, 2], "anaglyph", apart)
    kept, faults = visible_channels(theatre, found, "anaglyph", apart)
    assert [one.name for one in kept] == ["front", "right"]
    assert len(faults) == 1
    assert "channel 'left': the eye is behind the screen" in str(faults[0])
    assert len(theatre_rig(theatre, kept, [1, 2], "anaglyph", apart).eyes) == 4
    assert visible_channels(theatre, found, "mono", apart) == (found, ())
    dome, found = opened("dome")
    kept, faults = visible_channels(dome, found, "anaglyph", Stereo(separation_cm=1100.0))
    assert kept == ()
    assert "the eye is outside of its screen" in str(faults[0])


@pytest.mark.parametrize("name", ["dome", "equirectangular"])
@pytest.mark.parametrize("far", [8.0, 20.0, 300.0])
def test_all_visible_parts_of_a_surround_channel_are_drawn(name, far):
    theatre, found = opened(name)
    one = found[0].__class__(**{**vars(found[0]), "distance_cm": far})
    rig = theatre_rig(theatre, [one], [0], "side-by-side")
    pixels = np.random.default_rng(3).uniform(0, 1, (4000, 2)) * one.place[2:]
    d = directions(name, one.place[2:], one.surround, pixels)
    d = far * d[~np.isnan(d[:, 0])]
    for side in (-1, 1):
        drawn = np.zeros(len(d), bool)
        for eye in rig.eyes:
            if np.sign(eye.offset[0]) == side:
                seen = (d - eye.offset) @ eye.axes.T * [1, 1, -1]
                clip = np.column_stack([seen, np.ones(len(d))]) @ eye.projection.T
                drawn |= (np.abs(clip[:, :2]) < clip[:, 3:]).all(axis=1)
        assert drawn.all()


def test_displays_all_round_are_not_for_theatres():
    theatre, found = opened("cave")
    with pytest.raises(UserError, match="--display dome: the displays of a theatre are mono, "):
        theatre_rig(theatre, found, [0], "dome")
    with pytest.raises(UserError, match="no channel of this theatre is left"):
        theatre_rig(theatre, [], [0])
