"""Identity and range maps, compared with exact geometry."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from subsea.dive.ride import pictured
from subsea.fish.mesh import DETAILS, fish_mesh, species_vertices, surface_points
from subsea.frame.packet import KIND, ORIENTATION, POSITION, ROW_A, ROW_B, SCALE, WEIGHT
from subsea.geometry.rotation import matrix
from subsea.geometry.solids import ray_meets_seabed
from subsea.rendering.gl.id_buffer import FISH, HOOK, PILLAR, ROCK, SEABED, SURFACE, WATER
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.reef.rocks import object_ids
from subsea.rendering.renderer import Renderer
from subsea.view.camera import View, look
from subsea.view.retina import retina_rig
from subsea.view.rig import DisplayPatch, pose_from_angles, views

SIZE = (320, 180)
EXACT = replace(PRESETS["low"], detail=50.0)  # neither smoothed nor coarse


@pytest.fixture
def maps(make_renderer, make_packet, scene):
    """(fishes, options of the packet) -> picture, maps and view."""

    def maps(fishes, views=None, scene=scene, **options):
        renderer = make_renderer(SIZE, quality=EXACT, scene=scene)
        own = {key: options.pop(key) for key in ("hook", "bait", "without") if key in options}
        packet = make_packet(fishes, size=SIZE, **options)
        views = packet.views if views is None else views
        if "without" in own:
            views = tuple(replace(view, without=own.pop("without")) for view in views)
        packet = replace(packet, views=views, **own)
        renderer.draw(packet)
        picture = renderer.read_pixels().astype(int)
        seen = renderer.id_maps(packet)
        return SimpleNamespace(picture=picture, view=packet.views[0], **seen._asdict())

    return maps


def places(depth, view):
    """World positions (h, w, 3) of the pixels of a view of SIZE, by their depth."""
    width, height = SIZE
    x = (2 * np.arange(width) + 1) / width - 1
    y = 1 - (2 * np.arange(height) + 1) / height
    p = view.projection.astype(float)
    x, y = np.meshgrid((x + p[0, 2]) / p[0, 0], (y + p[1, 2]) / p[1, 1])
    depth = np.where(np.isfinite(depth), depth, 0.0)
    eye = depth[..., None] * np.stack([x, y, -np.ones_like(x)], axis=2)
    return (eye - view.view[:3, 3]) @ view.view[:3, :3].astype(float)


def skin(scene, record):
    """Points (n, 3) all over the body, the tail and the upright fins of a fish, cm, world."""
    before, after = scene.control_points[record[[ROW_A, ROW_B]].astype(int)]
    control = (1 - record[WEIGHT]) * before + record[WEIGHT] * after
    mesh = fish_mesh(DETAILS[0])
    own = species_vertices(scene.species[int(record[KIND])].surface, mesh, DETAILS[0])
    flat = mesh.vertices[:, 12] < 1.5
    points = surface_points(control, mesh.vertices[flat], own[flat, 2].astype(int))
    corners = points[mesh.triangles[flat[mesh.triangles].all(axis=1)]]
    mix = np.array([(a, b, 12 - a - b) for a in range(13) for b in range(13 - a)]) / 12
    points = np.einsum("ka,tax->tkx", mix, corners).reshape(-1, 3)
    turn = matrix(record[ORIENTATION].astype(float))
    return record[POSITION] + record[SCALE] * points @ turn.T


@pytest.mark.parametrize("level", range(3))
def test_a_fish_has_its_number_where_its_surface_is(maps, scene, make_packet, fish, level):
    one = fish(1, (4, 50, -198), heading=2.6, level=level, number=12345)
    seen = maps([one])
    mine = seen.kind == FISH
    assert mine.sum() > 800
    assert (seen.number[mine] == 12345).all()
    surface = skin(scene, make_packet([one]).instances[0])
    away = cKDTree(surface).query(places(seen.depth, seen.view)[mine])[0]
    # Paired fins are not among the points: they stand off.
    assert np.quantile(away, 0.9) < (0.1, 0.2, 0.4)[level]
    assert away.max() < 5.0


def test_the_identity_map_has_the_silhouette_of_the_picture(maps, fish):
    one, other = fish(1, (-6, 50, -198), number=3), fish(0, (14, 70, -205), heading=1.0, number=9)
    nobody, seen = maps([]), maps([one, other])
    assert set(np.unique(seen.number[seen.kind == FISH])) == {3, 9}
    mine, differs = seen.kind == FISH, np.abs(seen.picture - nobody.picture).max(axis=2)
    assert mine.sum() > 1000
    assert (differs[mine] > 1).mean() > 0.99
    # Other differences are transparent parts of fins, and shadows on the sand.
    around = (differs > 8) & ~mine & (seen.kind != SEABED)
    assert around.sum() < 0.1 * mine.sum()
    # Pixels without fishes are the same.
    np.testing.assert_array_equal(seen.kind[~mine], nobody.kind[~mine])


def test_a_hidden_fish_has_no_pixels(maps, fish):
    small = fish(0, (0, 60, -200), number=1, scale=0.3)
    assert (maps([small]).number == 1).sum() > 20
    seen = maps([small, fish(1, (2, 40, -200), number=2, scale=1.5)])
    assert (seen.number == 2).sum() > 1000
    assert not (seen.number == 1).any()


def test_specks_and_fading_fishes_have_numbers_too(maps, fish):
    fishes = [
        fish(0, (30, 200, -200), level=4, number=1),
        fish(1, (-30, 100, -200), level=2, number=2, fade=0.5),
        fish(1, (-30, 100, -200), level=3, number=2, fade=-0.5),
    ]
    seen = maps(fishes)
    assert set(np.unique(seen.number[seen.kind == FISH])) == {1, 2}
    whole = maps([fish(1, (-30, 100, -200), level=2, number=2)])
    assert (seen.number == 2).sum() == pytest.approx((whole.number == 2).sum(), rel=0.15)


def test_a_map_lacks_the_fish_whose_eye_it_is(maps, fish):
    fishes = [fish(1, (0, 40, -200), number=5), fish(0, (4, 80, -200), number=6)]
    assert 6 not in maps(fishes).number[60:120, 140:180]
    seen = maps(fishes, without=5)
    assert 5 not in seen.number
    assert (seen.number == 6).sum() > 50


def test_the_seabed_lies_where_a_ray_meets_it(maps, scene):
    seen = maps([], eye=(30.0, -200.0, -180.0), pitch=-0.5)
    rows, columns = np.nonzero(seen.kind == SEABED)
    assert len(rows) > 20000
    found = places(seen.depth, seen.view)
    eye = seen.view.eye
    # Triangles and the bilinear field between the same heights are not quite the same.
    for k in range(0, len(rows), 97):
        place = found[rows[k], columns[k]]
        beyond = eye + 3.0 * (place - eye)
        share = ray_meets_seabed(
            scene.terrain, scene.terrain_half_width_cm, 0.0, tuple(eye), tuple(beyond)
        )
        assert 3.0 * share == pytest.approx(1.0, abs=0.03)


def test_the_surface_lies_level_and_open_water_nowhere(maps):
    seen = maps([], pitch=0.9, eye=(0.0, 0.0, -150.0))
    above = seen.kind == SURFACE
    assert above.sum() > 10000
    assert np.abs(places(seen.depth, seen.view)[above][:, 2]).max() < 0.5
    level = maps([], eye=(0.0, 0.0, -150.0))
    assert (level.kind == WATER).any()
    assert np.isinf(level.depth[level.kind == WATER]).all()
    assert np.isfinite(level.depth[level.kind != WATER]).all()


def test_stone_is_one_pillar_or_the_first_rock_of_those_that_overlap(maps, scene):
    pillars = np.array([[0.0, 250.0, 30.0, -150.0]])
    rocks = np.array(
        [
            [300.0, 350.0, -280.0, 60.0, 60.0, 60.0, 0.3],
            [-150.0, 250.0, -300.0, 60.0, 50.0, 60.0, 0.3],
            [-180.0, 250.0, -290.0, 60.0, 50.0, 60.0, 0.0],
        ]
    )
    seen = maps([], scene=replace(scene, pillars=pillars, rocks=rocks), pitch=-0.2)
    assert set(np.unique(seen.number[seen.kind == PILLAR])) == {0}
    assert set(np.unique(seen.number[seen.kind == ROCK])) == {0, 1}
    at = places(seen.depth, seen.view)
    stone = seen.kind == PILLAR
    off = np.hypot(at[stone][:, 0], at[stone][:, 1] - 250.0)
    assert stone.sum() > 500
    assert off.max() < 31.0  # no stone is drawn outside of what the fishes avoid
    assert off.min() > 10.0 or at[stone][:, 2].max() > -165.0


def test_marks_of_stone_go_by_the_nearest_solid():
    pillars, rocks = np.array([[0.0, 0.0, 10.0, 0.0]]), np.array([[100.0, 0, 0, 20, 10, 10, 0.5]])
    kind, number = np.divmod(
        object_ids(pillars, rocks, np.array([(9.0, 0, -5), (85.0, 0, 0)])), 2**20
    )
    assert kind.tolist() == [PILLAR, ROCK]
    assert number.tolist() == [0, 0]


def test_the_hook_is_marked_and_specks_are_not(maps):
    place = np.array([0.0, 30.0, -200.0])
    seen = maps([], hook=place, bait=True)
    mine = seen.kind == HOOK
    assert mine.sum() > 50
    assert seen.depth[mine] == pytest.approx(30.0, abs=3.0)
    nothing, specks = maps([]), maps([], plankton=np.array([[5.0, 40.0, -200.0]], np.float32))
    assert (nothing.picture != specks.picture).any()
    np.testing.assert_array_equal(nothing.kind, specks.kind)


def test_both_eyes_agree_on_what_is_where(maps, fish):
    """A pixel of the left map, moved by its depth, meets the same thing in the right map."""
    left = maps([]).view
    shift = np.array([6.0, 0.0, 0.0])
    right = View(
        left.viewport,
        look(left.eye + shift, (0, 1, 0), (0, 0, 1)),
        left.projection,
        left.eye + shift,
    )
    fishes = [
        fish(k % 2, (25 * np.cos(k), 70 + 15 * k, -200 + 12 * np.sin(2 * k)), heading=k, number=k)
        for k in range(8)
    ]
    one, other = maps(fishes, (left,)), maps(fishes, (right,))
    assert_agree(one, other, right)


def test_a_part_is_cut_out_and_views_that_are_not_asked_for_are_left_out(
    make_renderer, make_packet, fish
):
    renderer = make_renderer(SIZE, quality=EXACT)
    packet = make_packet([fish(1, (-6, 50, -198), number=3)], size=SIZE)
    renderer.draw(packet)
    whole, part = renderer.id_maps(packet), renderer.id_maps(packet, part=(100, 40, 90, 60))
    nothing = renderer.id_maps(packet, numbers=())
    for all_of, cut in zip(whole, part, strict=True):
        np.testing.assert_array_equal(cut, all_of[180 - 100 : 180 - 40, 100:190])
    assert (part.kind == FISH).any()
    assert (nothing.kind == WATER).all()


def test_a_picture_is_pasted_as_it_is_where_patches_say(make_renderer, make_packet):
    renderer = make_renderer(SIZE, quality=EXACT)
    renderer.draw(make_packet([], size=SIZE))
    before = renderer.read_pixels().copy()
    picture = np.random.default_rng(1).integers(0, 256, (20, 60, 3)).astype(np.uint8)
    right = DisplayPatch((200, 100, 30, 20), (30, 0, 30, 20), (30, 0, 30, 20))
    renderer.paste(picture, (right,))
    after = renderer.read_pixels()
    np.testing.assert_array_equal(after[60:80, 200:230], picture[:, 30:])
    before[60:80, 200:230] = picture[:, 30:]
    np.testing.assert_array_equal(after, before)


def assert_agree(one, other, right):
    """Things in the left map that are missing in the right map are hidden there."""
    solid = one.kind != WATER
    clip = np.c_[places(one.depth, one.view)[solid], np.ones(solid.sum())]
    clip = clip @ (right.projection.astype(float) @ right.view.astype(float)).T
    width, height = SIZE
    column = np.floor((clip[:, 0] / clip[:, 3] + 1) * width / 2).astype(int)
    row = np.floor((1 - clip[:, 1] / clip[:, 3]) * height / 2).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    row, column = row[inside], column[inside]
    expected = clip[inside, 3]
    same = other.kind[row, column] == one.kind[solid][inside]
    same &= other.number[row, column] == one.number[solid][inside]
    hidden = other.depth[row, column] < expected - 1.0
    assert inside.sum() > 10000
    assert (same & ~hidden).mean() > 0.9
    # At an edge the neighbouring pixel may be hit instead.
    assert (~same & ~hidden).mean() < 0.01
    near = other.depth[row, column][same & ~hidden] - expected[same & ~hidden]
    assert np.quantile(np.abs(near), 0.9) < 0.02 * expected.max()


def test_what_both_eyes_of_a_fish_see(context, scene, make_packet, fish, same_picture):
    """Picture, identities and ranges, as in a film of labelled frames."""
    rig = retina_rig((160, 120), 1.2)
    renderer = Renderer(context, scene, rig)
    seen = views(rig, pose_from_angles(np.array([0.0, 0.0, -230.0]), np.pi / 2, -0.25))
    seen = tuple(replace(view, without=0) for view in seen)
    fishes = [
        fish(0, (0, 3, -230), number=0),  # the fish whose eyes these are
        fish(1, (-16, 45, -238), heading=2.6, number=1),
        fish(0, (14, 60, -236), heading=0.4, number=2),
        fish(0, (30, 110, -250), number=3),
    ]
    packet = make_packet(fishes, views=seen)
    renderer.draw(packet)
    same_picture("retina", np.hstack([renderer.read_pixels(side) for side in range(2)]))
    maps = renderer.id_maps(packet)
    assert set(np.unique(maps.number[maps.kind == FISH])) == {1, 2, 3}
    for name in ("identity", "range"):
        same_picture(f"retina-{name}", pictured(maps, name))
    renderer.release()
