"""Seaweed: chains against their closed form at rest, and what pushes them."""

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subsea.habitat import seaweed as module
from subsea.habitat.current import REACH_CM
from subsea.habitat.formations import drawn_distance, formations
from subsea.habitat.reef import KINDS, RUBBLE
from subsea.habitat.rocks import rock_cells
from subsea.habitat.seaweed import (
    BODY_BL,
    BUOYANCY_CM_S2,
    BURIED_CM,
    MARGIN_CM,
    MASS,
    NODES,
    SPRING,
    TUFT_CM,
    VISCOSITY,
    plant_seaweed,
    step_seaweed,
)
from subsea.kernels.lanes import LANES
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import SeaweedTable
from subsea.state import HULL_CM, Clock, Fishes, Reef, empty
from tests.support.daily import examples

DT = 0.033
STILL = np.zeros(3)
NO_REEF = empty(Reef, k=0)
ROCK = (150.0, 0.0, -290.0, 60.0, 50.0, 45.0, 0.3)


@pytest.fixture(scope="session")
def make_bed(make_sea):
    """Groups of seaweed -> the sea they grow in, and they."""
    scenario = load_scenario("peaceful")[0]

    def make(*groups, seed=3, reef=NO_REEF, **sea):
        grown = msgspec.structs.replace(
            scenario, seaweed=[SeaweedTable(**group) for group in groups]
        )
        return plant_seaweed(grown, make_sea(**sea), reef, seed)

    return make


NOBODY = empty(Fishes, n=0)


def _pass(bed, fishes=NOBODY, flow=STILL, ticks=1, visibility=1e9):
    sea, weed = bed
    cells = rock_cells(sea.rocks, REACH_CM)
    for tick in range(ticks):
        clock = Clock(0, tick, DT)
        step_seaweed(
            np.arange(len(weed.first) - 1),
            weed,
            fishes,
            sea,
            cells,
            np.array(flow),
            visibility,
            clock,
        )


def _swing(weed, leaves, flow):
    stream = module._still_stream(0.0)
    stream.flow[:] = flow[:, None]
    module._swing_leaves(weed, np.array(leaves), stream, module._response(DT), DT)


def test_a_leaf_swings_alone_as_among_others(make_bed):
    _, together = make_bed({"leaves": LANES, "height_cm": 80.0})
    _, alone = make_bed({"leaves": LANES, "height_cm": 80.0})
    flow = np.array([30.0, -9.0, -5.0])
    for _ in range(20):
        _swing(together, range(LANES), flow)
        for leaf in range(LANES):
            _swing(alone, [leaf], flow)
    assert (together.node == alone.node).all() and (together.velocity == alone.velocity).all()
    assert len(np.unique(together.node[:, -1], axis=0)) == LANES


def test_a_leaf_in_a_steady_flow_hangs_as_its_forces_add_up(make_bed):
    """Each spring carries the buoyancy and the drag of all nodes beyond it."""
    _, weed = make_bed({"leaves": 1, "height_cm": 80.0, "position_cm": (0.0, 0.0)})
    weed.lean[:] = (0.0, 0.0, 1.0)
    flow = np.array([4.0, -2.0, 0.0])
    for _ in range(3000):
        _swing(weed, [0], flow)
    each = BUOYANCY_CM_S2 * MASS[1:, None] * [0.0, 0.0, 1.0] + VISCOSITY * flow
    tension = np.cumsum(each[::-1], axis=0)[::-1]
    strength = np.linalg.norm(tension, axis=1, keepdims=True)
    links = (weed.rest[0][:, None] + strength / SPRING) * tension / strength
    np.testing.assert_allclose(np.diff(weed.node[0], axis=0), links, rtol=0.01, atol=0.01)
    bent = np.degrees(np.arctan2(np.hypot(links[:, 0], links[:, 1]), links[:, 2]))
    assert (np.diff(bent) > 0.0).all()  # ever more flexible toward the tip


def test_eddies_add_to_the_flow_and_to_what_bodies_push():
    rng = np.random.default_rng(4)
    node, push = rng.normal(0.0, 50.0, (2, NODES, 3))
    push[-1] *= 10.0
    flow, phase, water = np.array([5.0, -7.0, 1.0]), 40.0, np.zeros((NODES, 3))
    module._stir(node, flow, push, np.array([phase]), module.EDDY_CM_S, water)
    along = phase - 2.0 * np.pi / module.EDDY_CM * (node[:, 0] + 0.5 * node[:, 2])
    eddy = np.stack([np.sin(along), np.sin(0.83 * along + 1.0), np.zeros(NODES)], axis=1)
    expected = flow + module.EDDY_CM_S * eddy + push
    speed = np.linalg.norm(expected, axis=1)
    assert speed[-1] > module.TORRENT_CM_S > speed[1:-1].min()
    expected *= np.minimum(module.TORRENT_CM_S / speed, 1.0)[:, None]
    np.testing.assert_allclose(water[1:], expected[1:], atol=1e-3)


def test_seaweed_begins_at_rest_rooted_in_the_ground(make_bed):
    group = {"clusters": 20, "leaves": 6, "height_cm": 90.0}
    sea, weed = make_bed(group)
    assert weed.node.shape == (120, NODES, 3)
    np.testing.assert_allclose(weed.node[:, 0, 2], -300.0 - BURIED_CM)
    length = np.linalg.norm(np.diff(weed.node, axis=1), axis=2)
    np.testing.assert_allclose(length, weed.rest, rtol=0.05)
    assert (np.diff(weed.rest, axis=1) < 0.0).all()
    assert np.linalg.norm(weed.velocity, axis=2).max() < 2.0
    height = weed.node[:, -1, 2] - weed.node[:, 0, 2]
    assert 0.3 * 90.0 < height.min() < height.max() < 1.15 * 90.0
    assert (np.hypot(weed.node[:, 0, 0], weed.node[:, 0, 1]) < sea.radius).all()


def test_it_grows_on_a_rock_too_and_never_through_the_surface(make_bed):
    group = {"clusters": 6, "position_cm": (150.0, 0.0), "spread_cm": 30.0, "height_cm": 900.0}
    _, weed = make_bed(group, rocks=[ROCK])
    roots = weed.node[:, 0].astype(float)
    (stone,) = formations(np.zeros((0, 4)), np.array([ROCK]))
    gaps = np.array([drawn_distance(stone, tuple(root + (0, 0, BURIED_CM))) for root in roots])
    on_stone = roots[:, 2] > -299.0 - BURIED_CM
    assert on_stone.sum() > 0.8 * len(roots)
    assert np.abs(gaps[on_stone]).max() < 1.0
    assert gaps.min() > -0.5  # on the sand beside it, not in it
    assert weed.node[..., 2].max() < -15.0


def test_boxes_hold_the_leaves_and_follow_them(make_bed):
    bed = sea, weed = make_bed({"clusters": 5, "leaves": 3})
    before = sea.seaweed.copy()
    _pass(bed, flow=(6.0, 0.0, 0.0), ticks=40)
    assert np.abs(sea.seaweed - before).max() > 5.0
    for box, leaves in zip(sea.seaweed, weed.node.reshape(5, -1, 3), strict=True):
        np.testing.assert_array_equal(box, [*leaves.min(axis=0), *leaves.max(axis=0)])


def test_it_sways_with_the_current_to_both_sides(make_bed):
    bed = _, weed = make_bed({"clusters": 8, "leaves": 6})
    tips = []
    for flow in (6.0, -6.0):
        _pass(bed, flow=(flow, 0.0, 0.0), ticks=400)
        tips.append((weed.node[:, -1] - weed.node[:, 0]).mean(axis=0))
    assert tips[0][0] > 15.0
    assert tips[1][0] < -15.0
    assert abs(tips[0][1]) < 8.0


def test_a_passing_fish_pushes_the_near_leaves_along_and_leaves_the_others_alone(make_bed):
    near, far = ({"position_cm": (x, 0.0), "spread_cm": 1.0} for x in (0.0, 250.0))
    beds = [make_bed(near, far) for _ in range(2)]
    fishes = empty(Fishes, n=1)
    fishes.length[:] = 30.0
    x, y, z = beds[0][1].node[0, 4]  # it swims into a leaf
    fishes.velocity[0] = 40.0, 0.0, 0.0
    for tick in range(30):
        fishes.position[0] = x - 40.0 + 40.0 * DT * tick, y, z
        _pass(beds[0], fishes)
        _pass(beds[1])
    pushed = beds[0][1].node - beds[1][1].node
    assert np.linalg.norm(pushed[:6], axis=2).max() > 5.0
    np.testing.assert_array_equal(pushed[6:], 0.0)
    # A body takes its room: leaves part before it.
    gap = np.linalg.norm(beds[0][1].node[:6] - fishes.position[0], axis=2).min()
    free = np.linalg.norm(beds[1][1].node[:6] - fishes.position[0], axis=2).min()
    assert gap > max(free, 0.5 * BODY_BL * 30.0)


def test_dead_fishes_push_nothing(make_bed):
    beds = [make_bed({"position_cm": (0.0, 0.0)}) for _ in range(2)]
    fishes = empty(Fishes, n=1)
    fishes.length[:], fishes.velocity[:], fishes.alive[:] = 30.0, 50.0, False
    fishes.position[0] = beds[0][1].node[0, 4]
    for bed, company in zip(beds, (fishes, NOBODY), strict=True):
        _pass(bed, company, ticks=5)
    np.testing.assert_array_equal(beds[0][1].node, beds[1][1].node)


def test_the_submarine_pushes_them_aside(make_bed):
    bed = sea, weed = make_bed({"position_cm": (0.0, 0.0), "spread_cm": 1.0})
    middle = weed.node.mean(axis=(0, 1))
    sea.submarine[:3] = middle + (0.0, -0.8 * HULL_CM, 0.0)
    before = weed.node[..., 1].mean()
    _pass(bed, ticks=30)
    assert weed.node[..., 1].mean() > before + 3.0


def test_clusters_beyond_visibility_stand_still(make_bed):
    bed = sea, weed = make_bed({"clusters": 12})
    sea.submarine[:3] = -400.0, 0.0, -250.0
    before = weed.node.copy()
    _pass(bed, flow=(8.0, 0.0, 0.0), ticks=20, visibility=400.0)
    centre = before.reshape(12, -1, 3).mean(axis=1)
    away = np.linalg.norm(centre - sea.submarine[:3], axis=1)
    moved = np.abs(weed.node - before).reshape(12, -1).max(axis=1)
    assert (moved[away < 350.0] > 1.0).all()
    assert (moved[away > 450.0] == 0.0).all()
    assert (away < 350.0).any()
    assert (away > 450.0).any()


@given(st.integers(0, 1000), st.floats(0, 400), st.floats(-200, 200), st.floats(-200, 200))
@settings(max_examples=examples(6))
def test_fast_bodies_leave_leaves_whole_and_above_the_ground(make_bed, seed, speed, fx, fy):
    bed = _, weed = make_bed({"clusters": 3, "position_cm": (0.0, 0.0), "spread_cm": 20.0})
    rng = np.random.default_rng(seed)
    fishes = empty(Fishes, n=30)
    fishes.length[:] = rng.uniform(5, 150, 30)
    for _ in range(12):
        fishes.position[:] = weed.node[:, 4].mean(axis=0) + rng.normal(0, 30, (30, 3))
        fishes.velocity[:] = speed * rng.normal(0, 1, (30, 3))
        _pass(bed, fishes, flow=(fx, fy, 0.0), ticks=3)
        length = np.linalg.norm(np.diff(weed.node, axis=1), axis=2)
        assert np.isfinite(weed.node).all()
        assert (length < 1.8 * weed.rest).all()
        assert (weed.node[..., 2] >= -300.0 - BURIED_CM).all()
    _pass(bed, ticks=400)
    length = np.linalg.norm(np.diff(weed.node, axis=1), axis=2)
    np.testing.assert_allclose(length, weed.rest, rtol=0.06)


def test_passing_fishes_are_those_of_all_pairs(make_bed):
    sea, weed = make_bed({"clusters": 25, "leaves": 2})
    rng = np.random.default_rng(4)
    fishes = empty(Fishes, n=800)
    fishes.position[:] = rng.uniform((-520, -520, -300), (520, 520, 0), (800, 3))
    fishes.alive[::7] = False
    count, near = module._passers(weed, fishes, sea)
    low, high = sea.seaweed[:, None, :3] - MARGIN_CM, sea.seaweed[:, None, 3:] + MARGIN_CM
    inside = ((fishes.position > low) & (fishes.position < high)).all(axis=2) & fishes.alive
    inside &= (np.abs(fishes.position[:, :2]) < 500.0).all(axis=1)
    assert count.sum() > 30
    for k in range(25):
        assert list(near[k, : count[k]]) == list(np.flatnonzero(inside[k])[: module.TOUCHING])


def test_equal_seeds_grow_and_sway_equally(make_bed):
    ends = []
    for seed in (5, 5, 6):
        bed = make_bed({"clusters": 4}, seed=seed)
        _pass(bed, flow=(5.0, 1.0, 0.0), ticks=30)
        ends.append(bed[1].node.tobytes())
    assert ends[0] == ends[1] != ends[2]


@pytest.mark.parametrize("kind", module.KINDS)
def test_all_kinds_are_chains_with_a_look_of_their_own(make_bed, kind):
    group = {"clusters": 3, "leaves": 2, "height_cm": 200.0}
    _, weed = make_bed(group | {"kind": kind})
    assert (weed.kind == module.KINDS.index(kind)).all()
    _, other = make_bed(group)
    assert weed.rest.shape == other.rest.shape == (6, module.NODES - 1)
    assert (np.diff(weed.rest, axis=1) < 0.0).all()  # finer toward the tip
    if kind != "ribbon":
        assert not np.allclose(weed.look[:, 4:7], other.look[:, 4:7])
        assert weed.look[:, 0].max() < other.look[:, 0].max()


def test_a_sea_without_seaweed(make_bed):
    bed = sea, weed = make_bed()
    _pass(bed, empty(Fishes, n=3), ticks=2)
    assert len(weed.node) == len(sea.seaweed) == 0


def test_it_grows_beside_corals(make_bed):
    """Not through them; rubble and mounds are not a hindrance."""
    group = {"clusters": 40, "leaves": 1, "height_cm": 60.0, "position_cm": (0.0, 0.0)}
    group["spread_cm"] = 150.0
    bare = make_bed(group)[1]
    roots = bare.node[:, 0].astype(np.float64)
    near = roots[np.hypot(*roots[:, :2].T).argmin()]
    reef = Reef(
        kind=np.array([list(KINDS).index("brain")], np.uint8),
        place=near[None].astype(np.float32), axis=np.float32([[0.0, 0.0, 1.0]]),
        turn=np.zeros(1, np.float32), radius=np.array([40.0], np.float32),
        own=np.zeros(1, np.float32), light=np.ones(1, np.float32), hue=np.zeros(1, np.float32),
        on_rock=np.zeros(1, np.bool_),
    )  # fmt: skip
    kept = make_bed(group, reef=reef)[1]
    away = np.hypot(*(kept.node[:, 0, :2] - near[:2]).T)
    assert away.min() > 40.0 - 0.5 * TUFT_CM - 1.0
    rubble = reef._replace(kind=np.array([RUBBLE], np.uint8))
    np.testing.assert_array_equal(make_bed(group, reef=rubble)[1].node, bare.node)
