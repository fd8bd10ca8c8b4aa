"""A reef that one can compose: what is not moved stays as it is."""

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.habitat.growth_sites import SUNK
from subsea.habitat.reef import KINDS
from subsea.habitat.terrain import heights_at
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import CoralTable, ReefTable, SeaweedTable
from subsea.world.build import create_world

replace = msgspec.structs.replace
AWAY_CM = 450.0  # beyond what a pebble and its moat reach, before and after


@pytest.fixture(scope="module")
def bay():
    return create_world(load_scenario("peaceful")[0])


def with_pebble(scenario, x, y, number=0):
    """The scenario with one of its rocks moved."""
    rocks = list(scenario.rock)
    rocks[number] = replace(rocks[number], position_cm=(x, y))
    return replace(scenario, rock=rocks)


def away_from(place, *points):
    return np.all([np.hypot(*(place[:, :2] - p).T) > AWAY_CM for p in points], axis=0)


@pytest.mark.nightly
@pytest.mark.parametrize("number", [0, 1])
def test_a_pebble_that_moves_leaves_the_bay_as_it_is(bay, number):
    x, y = bay.scenario.rock[number].position_cm
    world = create_world(with_pebble(bay.scenario, x + 30.0, y, number))
    here = np.array([x, y])
    old, new = bay.state.reef, world.state.reef
    far = [away_from(reef.place, here) for reef in (old, new)]
    assert far[0].sum() > 500
    for one, other in zip(old.taken(far[0]), new.taken(far[1]), strict=True):
        np.testing.assert_array_equal(one, other)
    weeds = [state.seaweed for state in (bay.state, world.state)]
    roots = [away_from(weed.node[:, 0], here) for weed in weeds]
    assert roots[0].sum() > 40
    np.testing.assert_array_equal(weeds[0].node[roots[0]], weeds[1].node[roots[1]])
    np.testing.assert_array_equal(weeds[0].look[roots[0]], weeds[1].look[roots[1]])
    # Near it most stays too, but for the stones that it touches.
    grown = [{*map(tuple, reef.place[:, :2].round(1).tolist())} for reef in (old, new)]
    assert len(grown[0] & grown[1]) > 0.93 * len(old.place)
    ours, theirs = (state.fishes for state in (bay.state, world.state))
    moved = (ours.position != theirs.position).any(axis=1)
    assert moved.sum() <= 3  # those that begin over its moat, or a coral beside it
    assert np.abs(ours.position - theirs.position).max() < 5.0
    for name in ("orientation", "length", "identity", "row_a"):
        np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name), err_msg=name)


@pytest.mark.nightly
def test_one_more_table_leaves_the_others_as_they_are(bay):
    reef = ReefTable(position_cm=(-600.0, -700.0), spread_cm=60.0, number=20, seed=77)
    weed = SeaweedTable(position_cm=(-600.0, -700.0), spread_cm=60.0, clusters=3)
    scenario = bay.scenario
    more = replace(scenario, reef=[*scenario.reef, reef], seaweed=[*scenario.seaweed, weed])
    world = create_world(more)
    before = {row.tobytes() for row in bay.state.reef.place}
    after = {row.tobytes() for row in world.state.reef.place}
    assert before < after
    old = bay.state.seaweed
    np.testing.assert_array_equal(world.state.seaweed.node[: len(old.node), 0], old.node[:, 0])


@pytest.mark.nightly
def test_a_single_coral_stands_where_it_is_put_on_sand_and_on_stone(bay):
    corals = [
        CoralTable(kind="table", position_cm=(-420.0, 260.0), size_cm=40.0, yaw_deg=90.0),
        CoralTable(kind="fan", position_cm=(640.0, -60.0), size_cm=30.0, seed=4),
    ]
    world = create_world(replace(bay.scenario, coral=corals))
    sea, reef = world.state.sea, world.state.reef
    for one, on_rock in zip(corals, (False, True), strict=True):
        (k,) = np.flatnonzero((reef.place[:, :2] == np.float32(one.position_cm)).all(axis=1))
        assert list(KINDS)[reef.kind[k]] == one.kind
        assert reef.radius[k] == one.size_cm
        assert reef.turn[k] == np.float32(np.radians(one.yaw_deg))
        assert reef.on_rock[k] == on_rock
        sand = heights_at(sea.heights, sea.half_width, reef.place[k : k + 1, :2].astype(float))[0]
        gap = reef.place[k, 2] + SUNK * one.size_cm - sand
        assert gap > 100.0 if on_rock else abs(gap) < 0.1
        # Others grow around it, not in it.
        away = np.linalg.norm(reef.place - reef.place[k], axis=1)
        others = (away > 0.0) & (reef.kind != list(KINDS).index("mound"))
        assert (away[others] > 0.5 * one.size_cm).all()
    # It lifts the floor that fishes keep off.
    at = np.array([corals[0].position_cm])
    assert (
        heights_at(sea.floor, sea.half_width, at)[0]
        > heights_at(sea.heights, sea.half_width, at)[0]
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[coral]]\nkind = "tree"\nposition_cm = [0.0, 0.0]', "coral"),
        ('[[coral]]\nkind = "fan"\nposition_cm = [9000.0, 0.0]', r"coral\[0\].position_cm"),
        ('[[coral]]\nkind = "fan"\nposition_cm = [0.0, 0.0]\nsize_cm = 500.0', "size_cm"),
        ("[[ridge]]\nposition_cm = [0.0, 0.0]\nlength_cm = 20.0\nwidth_cm = 60.0\n"
         "height_cm = 50.0", "length_cm"),
        ("[[ridge]]\nposition_cm = [9000.0, 0.0]\nlength_cm = 200.0\nwidth_cm = 60.0\n"
         "height_cm = 50.0", r"ridge\[0\].position_cm"),
        ("[[wreck]]\nposition_cm = [0.0, 0.0]\nlength_cm = 50.0", "length_cm"),
        ("[[wreck]]\nposition_cm = [9000.0, 0.0]", r"wreck\[0\].position_cm"),
    ],
)  # fmt: skip
def test_errors_are_one_line(tmp_path, text, words):
    bare = load_scenario("mating")[1].read_text()
    bare = bare.split("# A meadow of seagrass")[0]
    (tmp_path / "own.toml").write_text(f"{bare}\n{text}\n")
    with pytest.raises(UserError, match=words) as fault:
        load_scenario(str(tmp_path / "own.toml"))
    assert "\n" not in str(fault.value)


def test_a_shelf_rises_on_its_side_and_nowhere_else():
    flat = load_scenario("go-fish")[0]
    sea = create_world(flat, fish=1).state.sea
    shelf, deep = heights_at(sea.heights, sea.half_width, np.array([[-500.0, 0.0], [750.0, 0.0]]))
    assert shelf - deep > 0.8 * flat.terrain.shelf_cm
    assert deep < -0.9 * flat.bounds.depth_cm
