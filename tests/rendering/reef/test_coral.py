"""Corals as meshes and as drawn."""

from collections import Counter
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from subsea.habitat.reef import KINDS, MOUND, grow_reefs
from subsea.habitat.sea import make_sea
from subsea.habitat.terrain import VARIANTS
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.reef.coral import COLUMNS, LOOKS, bake, contact, grain
from subsea.rendering.reef.coral_kinds import LEVELS, LUMPS, SHAPES, WELDED, growth_levels, shape
from subsea.rendering.reef.coral_mesh import welded
from subsea.rendering.sea.seabed import drawn_height
from subsea.scenario.load import load_scenario
from subsea.state import Reef

MOST = (9500, 2100, 800, 300, 120, 15)  # triangles at each level


def reef_of(*growths, on_rock=False):
    """Growths of (kind, place, radius), upright."""
    k = len(growths)
    return Reef(
        kind=np.array([list(KINDS).index(name) for name, _, _ in growths], np.uint8),
        place=np.array([place for _, place, _ in growths], np.float32),
        axis=np.tile(np.float32([0.0, 0.0, 1.0]), (k, 1)),
        turn=np.linspace(0.3, 2.0, k, dtype=np.float32),
        radius=np.array([radius for _, _, radius in growths], np.float32),
        own=np.linspace(0.05, 0.95, k, dtype=np.float32),
        light=np.ones(k, np.float32),
        hue=np.linspace(0.95, 0.05, k, dtype=np.float32),
        on_rock=np.full(k, on_rock),
    )


def levels_of(kind):
    """The numbers of the levels of a kind."""
    return range(LEVELS if kind in LUMPS else LEVELS - 1)


def filled(mesh, size=48):
    """Cells of a side view that the mesh covers."""
    place = mesh.place[mesh.triangles]
    share = np.random.default_rng(0).dirichlet((1, 1, 1), 60)
    points = np.einsum("sk,mkc->smc", share, place).reshape(-1, 3)
    seen = np.zeros((size, size), bool)
    x, z = ((points[:, axis] * size / 3.0 + shift).astype(int) for axis, shift in ((0, 24), (2, 4)))
    inside = (x >= 0) & (x < size) & (z >= 0) & (z < size)
    seen[z[inside], x[inside]] = True
    return seen


def test_every_kind_has_a_shape_and_a_look():
    assert list(SHAPES) == list(KINDS) == list(LOOKS)


@pytest.mark.parametrize("kind", SHAPES)
def test_meshes_are_sound(kind):
    """At size 1, with unit normals that face as the triangles do, few triangles, seamless.

    Coarser levels have no more triangles.
    """
    for variant, level in product(range(VARIANTS), levels_of(kind)):
        mesh = shape(kind, variant, level)
        assert len(mesh.triangles) <= MOST[level]
        assert np.isfinite(mesh.place).all()
        # The edge of a mound has lobes, which coarse levels cut.
        cut = 0.12 if kind == "mound" else 1e-9
        assert 1.0 - cut <= np.hypot(*mesh.place[:, :2].T).max() <= 1.0 + 1e-9
        assert mesh.place[:, 2].max() == pytest.approx(KINDS[kind].height)
        np.testing.assert_allclose(np.linalg.norm(mesh.normal, axis=1), 1.0, atol=1e-9)
        a, b, c = (mesh.place[mesh.triangles[:, k]] for k in range(3))
        face = np.cross(b - a, c - a)
        area = np.linalg.norm(face, axis=1)
        facing = (face * mesh.normal[mesh.triangles].mean(axis=1)).sum(axis=1) / area
        assert area[facing > 0].sum() > (0.97 if level < 2 else 0.8) * area.sum()
        for part in (mesh.tip, mesh.light, mesh.sway):
            assert part.min() >= 0.0
            assert part.max() <= 1.0 + 1e-9
    for variant in range(VARIANTS):
        counts = [len(shape(kind, variant, level).triangles) for level in levels_of(kind)]
        assert (np.diff(counts) <= 0).all()
        assert counts[-1] < 0.3 * counts[0]


@pytest.mark.parametrize("kind", SHAPES)
def test_skins_have_no_holes(kind):
    """Every edge between two triangles; open ones lie at the foot or inside other parts."""
    mesh = shape(kind, 0, 0)
    # Rings meet themselves, and poles are many points in one place.
    key = np.unique(np.round(mesh.place, 7), axis=0, return_inverse=True)[1].ravel()
    triangles = key[mesh.triangles]
    edges = Counter()
    for i, j in ((0, 1), (1, 2), (2, 0)):
        edges.update(map(tuple, np.sort(triangles[:, [i, j]], axis=1).tolist()))
    odd = np.array([edge for edge, count in edges.items() if count == 1])
    assert len(odd) < (0.55 if kind == "fan" else 0.25) * len(edges)  # a fan is all twigs


@pytest.mark.parametrize("kind", sorted(set(SHAPES) - {"rubble"}))
def test_levels_have_one_silhouette(kind):
    """At the sizes of coarse levels a growth covers a few dozen pixels."""
    finest = filled(shape(kind, 1, 0), 24)
    for level, least in ((1, 0.6), (2, 0.45), (3, 0.35), (4, 0.35)):
        coarse = filled(shape(kind, 1, level), 24)
        assert (finest & coarse).sum() / (finest | coarse).sum() > least


@pytest.mark.parametrize("kind", SHAPES)
def test_each_level_costs_clearly_less_than_the_one_before(kind):
    """Fewer triangles, and no vertex that equals another from afar."""
    levels = growth_levels(kind, 0)
    assert len(levels) == len(levels_of(kind))
    counts = np.array([len(mesh.triangles) for mesh in levels])
    assert (counts[1:] <= 0.9 * counts[:-1]).all()
    for mesh in levels[WELDED:]:
        corners = np.round(np.column_stack([mesh.place, mesh.normal, mesh.along]), 4)
        assert len(np.unique(corners, axis=0)) == len(corners)


def test_welding_keeps_the_surface():
    mesh = shape("staghorn", 0, 1)
    fewer = [welded(mesh, seams) for seams in (False, True)]
    for other in fewer:
        corners = other.place[other.triangles]
        np.testing.assert_allclose(corners, mesh.place[mesh.triangles], atol=2e-5)
    # A tube of five sides and three rings, the last a point, has 18 vertices; 11 of them differ.
    tubes = len(mesh.place) // 18
    assert [len(other.place) for other in fewer] == [18 * tubes, 11 * tubes]
    assert len(np.unique(fewer[1].triangles)) == 11 * tubes


def test_variants_differ_and_each_is_the_same_again():
    for kind in SHAPES:
        one, other = shape(kind, 0, 0), shape(kind, 1, 0)
        assert one.place.shape != other.place.shape or not np.allclose(one.place, other.place)
        np.testing.assert_array_equal(one.place, shape(kind, 0, 0).place)


def test_baked_growths_stay_in_their_room():
    growths = [(kind, (40.0 * k, 0.0, -300.0), 15.0) for k, kind in enumerate(SHAPES)]
    for (kind, place, radius), levels in zip(growths, bake(reef_of(*growths)), strict=True):
        assert len(levels) == len(levels_of(kind))
        for level in levels:
            assert level.vertices.dtype == np.float32
            assert level.vertices.shape[1] == COLUMNS
            off = level.vertices[:, :3] - place
            assert np.hypot(off[:, 0], off[:, 1]).max() <= radius + 0.01
            assert off[:, 2].max() <= radius * KINDS[kind].height + 0.01


def heights_over(triangles, places):
    """Height of the highest of triangles (t, 3, 3) over each place (n, 2), or -inf."""
    across = triangles[:, :, :2]
    near = (across.min(axis=1) <= places.max(axis=0)) & (across.max(axis=1) >= places.min(axis=0))
    triangles = triangles[near.all(axis=1)]
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    over = np.full(len(places), -np.inf)
    for k, (x, y) in enumerate(places):
        with np.errstate(divide="ignore", invalid="ignore"):
            v = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])) / area
            w = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])) / area
        within = (v >= 0) & (w >= 0) & (v + w <= 1)
        z = a[:, 2] + v * (b[:, 2] - a[:, 2]) + w * (c[:, 2] - a[:, 2])
        over[k] = z[within].max(initial=-np.inf)
    return over


@pytest.mark.nightly
def test_no_growth_floats_above_the_ground():
    """The lowest drawn part of a growth touches the sand or mounds as drawn."""
    scenario = load_scenario("peaceful")[0]
    sea, reef = grow_reefs(scenario, make_sea(scenario, np.random.default_rng(0))[0])
    baked = bake(reef)
    mounds = np.concatenate(
        [
            baked[k][0].vertices[:, :3][baked[k][0].triangles]
            for k in np.flatnonzero(reef.kind == MOUND)
        ]
    ).astype(np.float64)
    gaps = []
    for k in np.flatnonzero(~reef.on_rock)[::2]:
        place = baked[k][0].vertices[:, :3].astype(np.float64)
        lowest = place[:, 2].argsort()[: max(len(place) // 20, 3)]
        low = place[lowest[:: max(len(lowest) // 16, 1)]]  # some of them, with the very lowest
        sand = drawn_height(sea.heights, sea.half_width, low[:, 0], low[:, 1])
        over = heights_over(mounds, low[:, :2]) if reef.kind[k] != MOUND else -np.inf
        gaps.append((low[:, 2] - np.maximum(sand, over)).min())
    gaps = np.array(gaps)
    assert len(gaps) > 75
    assert (gaps > 2.0).mean() < 0.01
    assert gaps.max() < 6.0


def test_two_growths_of_one_kind_differ():
    twins = [("brain", (0.0, 0.0, -300.0), 15.0), ("brain", (100.0, 0.0, -300.0), 15.0)]
    reef = reef_of(*twins)._replace(own=np.array([0.10, 0.5], np.float32))
    one, other = (levels[0].vertices for levels in bake(reef))
    assert not np.array_equal(one[:, 4:6].view(np.uint8), other[:, 4:6].view(np.uint8))


def test_the_ground_darkens_the_foot_of_a_growth():
    dark = contact(np.array([-0.1, 0.0, 0.1, 0.3, 1.0]))
    assert (np.diff(dark) >= 0.0).all()
    assert dark[0] == dark[1] < 0.5 < 0.9 < dark[3]
    assert dark[4] == pytest.approx(1.0, abs=0.01)


def test_the_grain_repeats_without_a_seam():
    for layer in grain(6)[:3]:
        within = np.abs(np.diff(layer, axis=0)).mean()
        assert np.abs(layer[0] - layer[-1]).mean() < 1.5 * within
        assert abs(layer.mean()) < 1e-9


@pytest.fixture
def sight(make_packet):
    """An empty packet with an eye before the growths."""
    eye = {"eye": (0, -60, -230), "heading": 1.57, "pitch": -0.2}
    return lambda **options: make_packet([], **(eye | options))


@pytest.fixture(scope="module")
def garden(scene):
    kinds = ("staghorn", "brain", "anemone", "fan", "pipes", "soft", "table", "bush")
    places = [(90.0 * (k % 4) - 135.0, 170.0 + 80.0 * (k // 4)) for k in range(8)]
    heights = scene.terrain
    width = scene.terrain_half_width_cm

    def ground(x, y):
        at = [round((v + width) / (2 * width) * (len(heights) - 1)) for v in (y, x)]
        return float(heights[at[0], at[1]])

    growths = [
        (kind, (x, y, ground(x, y)), 30.0) for kind, (x, y) in zip(kinds, places, strict=True)
    ]
    return replace(scene, reef=reef_of(*growths))


def test_they_are_seen_and_cost_nothing_out_of_sight(counted, scene, garden, sight):
    bare, before = counted(sight())
    full, after = counted(sight(), scene=garden)
    assert (np.abs(bare - full).max(axis=2) > 12).mean() > 0.04
    assert after > before + 500
    behind = sight(heading=-1.57)
    assert counted(behind, scene=garden)[1] == counted(behind)[1]


def test_detail_and_growth_save_triangles(counted, garden, sight):
    medium = PRESETS["medium"]
    choices = medium, replace(medium, detail=0.3), replace(medium, growth=0.5)
    full, *fewer = (counted(sight(), scene=garden, quality=quality)[1] for quality in choices)
    assert max(fewer) < full


def test_soft_ones_sway(drawn, garden, sight):
    """Pictures seconds apart differ by more than caustics."""
    first, second = (drawn(sight(time_s=t), scene=garden) for t in (1.0, 2.7))
    assert (np.abs(first - second).max(axis=2) > 40).mean() > 0.002


def test_mounds_are_never_left_out(counted, scene, sight):
    """Growths on mounds would otherwise float."""
    scene = replace(scene, reef=reef_of(("mound", (0.0, 150.0, -300.0), 60.0)))
    scene.reef.own[:] = 0.99
    full, few = (
        counted(sight(), scene=scene, quality=replace(PRESETS["medium"], growth=growth))[1]
        for growth in (1.0, 0.1)
    )
    assert full == few
