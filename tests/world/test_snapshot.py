"""Snapshots: saving and restoring everything that changes in a world."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.repertoire import SEGMENTS
from subsea.scenario.load import load_scenario
from subsea.submarine.vessel import Helm
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import only

AHEAD = Helm(surge=0.6, yaw=0.2, heave=-0.1)
# Schools, courtship, hunting, a hook; the last with some fishes that are simulated.
SCENARIOS = [
    ("peaceful", 40, 0), ("mating", None, 0), ("preying", None, 0), ("go-fish", None, 0),
    ("peaceful", 12, 3),
]  # fmt: skip


def made(name, fish, live):
    return create_world(load_scenario(name)[0], fish=fish, live=live, live_reach_cm=np.inf)


def stepped(world, ticks):
    for _ in range(ticks):
        step(world, AHEAD)
    return world


@pytest.mark.parametrize(("name", "fish", "live"), only(SCENARIOS[-1:], SCENARIOS))
def test_a_world_restored_from_a_snapshot_continues_equally(name, fish, live):
    world, other = made(name, fish, live), made(name, fish, live)
    first = {key: array.copy() for key, array in snapshot.constant(world).items()}
    for _ in range(3):
        stepped(world, 190)
        snapshot.restore(other, snapshot.take(world))
        for _ in range(12):
            assert snapshot.checksum(other) == snapshot.checksum(world)
            step(world, AHEAD)
            step(other, AHEAD)
    assert world.state.fishes.live.any() == (live > 0)
    # Constant arrays are constant.
    for key, array in snapshot.constant(world).items():
        np.testing.assert_array_equal(array, first[key], err_msg=key)


@pytest.fixture(scope="module")
def small():
    """A world, a second one in another state, and a snapshot of the first."""
    world, other = stepped(made("peaceful", 3, 1), 30), stepped(made("peaceful", 3, 1), 7)
    return world, other, snapshot.take(world)


def refused(world, data, words="not a snapshot of this dive"):
    before = snapshot.checksum(world)
    with pytest.raises(UserError, match=words):
        snapshot.restore(world, data)
    assert snapshot.checksum(world) == before


@given(st.data())
def test_damaged_snapshots_are_refused_and_change_nothing(small, data):
    _, other, whole = small
    at = data.draw(st.integers(0, len(whole) - 1))
    kind = data.draw(st.sampled_from(["flip", "cut", "insert", "head"]))
    if kind == "flip":
        bit = 1 << data.draw(st.integers(0, 7))
        damaged = whole[:at] + bytes([whole[at] ^ bit]) + whole[at + 1 :]
    elif kind == "cut":
        damaged = whole[:at]
    elif kind == "insert":
        damaged = whole[:at] + data.draw(st.binary(min_size=1, max_size=20)) + whole[at:]
    else:
        damaged = data.draw(st.binary(max_size=200)) + whole[at:]
    assume(damaged != whole)
    refused(other, damaged)


@pytest.mark.nightly
def test_a_damaged_header_is_refused_and_the_size_is_limited(small):
    world, other, whole = small
    assert len(whole) <= snapshot.size_limit(world)
    end = whole.index(b"}]}") + 3
    for at in range(0, end, 7):
        refused(other, whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])


def test_another_world_refuses_it(small):
    *_, whole = small
    refused(made("peaceful", 4, 1), whole, "fishes.position")
    refused(made("peaceful", 3, 2), whole, r"live\.fish .*where.*was expected")
    refused(made("mating", None, 0), whole)
    other_seed = create_world(load_scenario("peaceful")[0], seed=99, fish=3, live=1)
    refused(other_seed, whole, r"seed \d+, expected 99")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("fishes.row_a", 10**6),
        ("fishes.row_b", -1),
        ("fishes.segment", len(SEGMENTS)),
        ("minds.neighbour", 3),
        ("minds.target", 10**6),
        ("minds.food", -2),
        ("live.fish", 3),
        ("sea.catch", 5),
        ("fishes.position", np.nan),
        ("fishes.position", np.inf),
        ("sea.plankton", 1e20),
        ("minds.food_distance", np.nan),
    ],
)
def test_invalid_values_are_refused(small, name, value):
    """The checksum is right, but compiled code would read outside its arrays."""
    world, other, whole = small
    array = snapshot.changing(world)[name]
    array.reshape(-1)[0] = value
    try:
        refused(other, snapshot.take(world), name.replace(".", r"\.") + r"\[0.*no tick writes")
    finally:
        snapshot.restore(world, whole)


def test_invalid_poses_and_booleans_are_refused(small):
    world, other, whole = small
    world.state.fishes.live[:] = False
    world.state.fishes.row_b[:] = len(world.library.entry)
    refused(other, snapshot.take(world), "not among the rows of its motor")
    snapshot.restore(world, whole)
    world.state.fishes.alive.view(np.uint8)[0] = 2
    refused(other, snapshot.take(world), "fishes.alive")
    snapshot.restore(world, whole)


def test_a_snapshot_holds_the_lights_of_the_submarine(small):
    world, other, whole = small
    lights = world.state.submarine.lights
    lights[:] = True
    assert not other.state.submarine.lights[0]
    snapshot.restore(other, snapshot.take(world))
    assert other.state.submarine.lights[0]
    assert snapshot.checksum(other) == snapshot.checksum(world)
    lights[:] = False
    assert snapshot.checksum(other) != snapshot.checksum(world)
    snapshot.restore(other, whole)


def test_a_snapshot_holds_the_brightness_of_eye_views(small):
    world, other, whole = small
    before = snapshot.checksum(world)
    world.seen_light[1] = np.float32(0.3)
    assert snapshot.checksum(world) != before
    seen = snapshot.take(world)
    snapshot.restore(other, seen)
    assert other.seen_light == {1: float(np.float32(0.3))}
    assert snapshot.checksum(other) == snapshot.checksum(world)
    world.seen_light[3] = 0.5
    refused(other, snapshot.take(world), "a fish that does not exist")
    for one in (world, other):
        snapshot.restore(one, whole)
        assert not one.seen_light
