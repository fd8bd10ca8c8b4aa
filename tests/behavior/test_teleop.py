"""Teleoperation: a fish follows commands within its repertoire and avoids obstacles."""

import numpy as np
import pytest

from subsea.behavior.chasing import mouth_of
from subsea.behavior.teleop import TeleopCommand, TeleopCommands
from subsea.geometry.rotation import rotate
from subsea.geometry.solids import height_at
from subsea.habitat.contact import clearances
from subsea.repertoire import SEGMENTS
from subsea.scenario.load import load_scenario
from subsea.state import EAT, ESCAPE, FEAR, MATE, NOBODY, PREDATOR, PREY, WANDER
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S
from tests.support.daily import only

FISH = 4


@pytest.fixture(scope="module")
def begun():
    """Snapshot of the peaceful bay after two seconds, the start of every test."""
    world = create_world(load_scenario("peaceful", ["seaweed=[]"])[0], fish=60)
    for _ in range(60):
        step(world, NEUTRAL)
    return world, snapshot.take(world), world.state.minds.kind.copy()


@pytest.fixture
def world(begun):
    world, whole, kind = begun
    world.state.minds.kind[:] = kind  # constant in a dive, so snapshots leave it out
    snapshot.restore(world, whole)
    return world


def steered(world, seconds, fish=FISH, **asked):
    """Steer for some seconds; returns degrees turned left, and the segments used."""
    fishes, turned, segments = world.state.fishes, 0.0, set()
    before = heading(fishes, fish)
    for _ in range(round(seconds / TICK_S)):
        step(world, TeleopCommand(fish, **asked))
        now = heading(fishes, fish)
        turned += (now - before + np.pi) % (2 * np.pi) - np.pi
        before = now
        segments.add(SEGMENTS[fishes.segment[fish]])
    return np.degrees(turned), segments


def ahead(fishes, fish):
    return np.array(rotate(fishes.orientation[fish], (1.0, 0.0, 0.0)))


def heading(fishes, fish):
    x, y, _ = ahead(fishes, fish)
    return np.arctan2(y, x)


def speed(world, fish=FISH):
    """Velocity along the body through the water, body lengths per second."""
    fishes = world.state.fishes
    own = fishes.velocity[fish] - fishes.drift[fish]
    return own @ ahead(fishes, fish) / fishes.length[fish]


@pytest.mark.nightly
def test_it_turns_and_rises_as_asked_by_its_own_strokes(world):
    steered(world, 2.0, speed=0.6)
    straight, _ = steered(world, 2.0, speed=0.6)
    assert abs(straight) < 8.0
    for side, name in ((1.0, "turn_left_gradual"), (-1.0, "turn_right_gradual")):
        little, _ = steered(world, 2.0, speed=0.6, turn=0.3 * side)
        much, segments = steered(world, 2.0, speed=0.6, turn=side)
        assert 10.0 < side * little < side * much
        assert side * much > 45.0
        assert name in segments
        steered(world, 1.0, speed=0.6)
    fishes = world.state.fishes
    for way in (1.0, -1.0):
        steered(world, 2.0, speed=0.6)
        before = fishes.position[FISH, 2]
        steered(world, 2.5, speed=0.6, rise=way)
        assert way * (fishes.position[FISH, 2] - before) > 5.0
        assert 15.0 < way * np.degrees(np.arcsin(ahead(fishes, FISH)[2])) < 25.0
    steered(world, 2.0, speed=0.6)
    assert abs(ahead(fishes, FISH)[2]) < 0.1  # without a command it swims level


def test_it_speeds_up_stops_and_backs_off(world):
    _, segments = steered(world, 2.5, speed=0.3)
    slow = speed(world)
    assert segments and not segments & {"swim_fast", "swim_burst"}
    _, segments = steered(world, 2.5, speed=1.0)
    assert "swim_fast" in segments
    assert speed(world) > 1.5 * slow > 0.3
    steered(world, 3.0)
    assert abs(speed(world)) < 0.1
    steered(world, 2.0, speed=-1.0)
    backing = []
    for _ in range(30):
        steered(world, TICK_S, speed=-1.0)
        backing.append(speed(world))
    assert max(backing) < 0.0
    assert np.mean(backing) < -0.1


@pytest.mark.nightly
@pytest.mark.parametrize("name", only(["peaceful"], ["peaceful", "visitors"]))
def test_it_keeps_clear_of_stone_sand_and_the_sea_s_bounds_however_it_is_steered(name):
    # Remove plankton and seaweed: slow, and irrelevant here.
    scenario = load_scenario(name, ["water.plankton=0", "seaweed=[]"]).scenario
    world = create_world(scenario, fish=40)
    fishes, sea = world.state.fishes, world.state.sea
    rng = np.random.default_rng(3)
    for fish in (0, 17, 39):
        # Toward the ground, the surface, a random direction, astern.
        for asked in ({"rise": -1.0}, {"rise": 1.0}, {}, {"speed": -1.0}):
            for _ in range(4):
                asked = {"speed": 1.0, "turn": rng.uniform(-0.4, 0.4)} | asked
                for _ in range(40):
                    step(world, TeleopCommand(fish, **asked))
                    place = fishes.position[fish].astype(np.float64)
                    assert clearances(sea.pillars, sea.rocks, place[None])[0] > 0.0
                    floor = height_at(sea.heights, sea.half_width, place[0], place[1])
                    assert floor + 1.0 < place[2] < -1.0
                    assert np.hypot(*place[:2]) < sea.radius


def test_its_intention_yields_and_comes_back(world):
    minds, fishes = world.state.minds, world.state.fishes
    minds.kind[FISH], minds.dread[FISH] = PREY, 400.0
    enemy = FISH + 1
    for name in ("target", "food", "foods", "memory", "memory_target"):
        getattr(minds, name)[enemy] = NOBODY  # they were plankton
    minds.food_distance[enemy] = np.inf
    minds.kind[enemy], minds.intention[FISH] = PREDATOR, MATE
    minds.partner[FISH] = FISH + 2
    for _ in range(40):
        fishes.position[enemy] = fishes.position[FISH] + 40.0 * ahead(fishes, FISH)
        minds.eaten[FISH] = 0.0
        step(world, TeleopCommand(FISH, speed=0.4))
        assert minds.intention[FISH] == WANDER
        assert minds.target[FISH] == NOBODY
    assert minds.mental[FISH, FEAR] > 0.3  # feelings are unaffected
    assert (fishes.goal_speed[FISH], fishes.gape[FISH]) == (pytest.approx(0.4), 0.0)
    snapshot.restore(world, snapshot.take(world))  # refuses values that no tick may write
    for _ in range(10):
        step(world, NEUTRAL)
    assert minds.intention[FISH] != WANDER
    assert minds.intention[FISH] != EAT


def test_others_do_not_notice_commands_and_the_submarine_keeps_station(world, begun):
    others = np.arange(60) != FISH
    step(world, NEUTRAL)
    free = {name: array.copy() for name, array in snapshot.changing(world).items()}
    snapshot.restore(world, begun[1])
    step(world, TeleopCommand(FISH, turn=1.0, speed=1.0))
    for name, array in snapshot.changing(world).items():
        if name.startswith(("fishes.", "minds.")) and len(array) == 60:
            np.testing.assert_array_equal(array[others], free[name][others], err_msg=name)
    assert not np.array_equal(world.state.minds.urge[FISH], free["minds.urge"][FISH])
    submarine = world.state.submarine
    submarine.velocity[:] = 60.0, 0.0, 0.0
    steered(world, 4.0, speed=1.0)
    assert np.linalg.norm(submarine.velocity) < 1.0


def test_the_same_commands_from_a_snapshot_give_the_same_world(world):
    def ridden(ticks):
        for k in range(ticks):
            step(world, TeleopCommand(FISH, np.sin(0.1 * k), 0.3, 0.8))
        return snapshot.checksum(world)

    ridden(20)
    whole = snapshot.take(world)
    first = ridden(40)
    snapshot.restore(world, whole)
    assert ridden(40) == first


def test_a_dead_fish_is_not_steered_and_an_unknown_one_is_a_fault(world):
    world.state.fishes.alive[FISH] = False
    before = world.state.minds.urge[FISH].copy()
    step(world, TeleopCommand(FISH, 1.0, 1.0, 1.0))
    np.testing.assert_array_equal(world.state.minds.urge[FISH], before)
    with pytest.raises(IndexError):
        step(world, TeleopCommand(60))


@pytest.mark.nightly
def test_a_school_follows_its_leader_that_is_steered_and_prey_flees_its_predator():
    world = create_world(load_scenario("schooling", ["seaweed=[]", 'fish.0.school="leader"'])[0])
    fishes, minds = world.state.fishes, world.state.minds
    for _ in range(60):
        step(world, NEUTRAL)
    leader = int(np.bincount(minds.leader[minds.leader >= 0]).argmax())
    school = np.flatnonzero(minds.leader == leader)
    before = fishes.velocity[school].mean(axis=0)
    turned = 0.0
    while turned < 110.0:
        turned += steered(world, 0.5, leader, speed=0.6, turn=1.0)[0]
    steered(world, 6.0, leader, speed=0.6)
    after = fishes.velocity[school].mean(axis=0)
    way = ahead(fishes, leader)
    assert before @ way < 0.3 * np.linalg.norm(before)  # it turned far from the school's way ...
    assert after @ way > 0.6 * np.linalg.norm(after)  # ... and the school followed
    assert len(school) > 10

    world = create_world(load_scenario("preying")[0])
    fishes, minds = world.state.fishes, world.state.minds
    predator = int(np.flatnonzero(minds.kind == PREDATOR)[0])
    prey = int(np.flatnonzero(minds.kind == PREY)[0])
    fishes.position[predator] = 500.0, 0.0, -250.0
    aside = np.cross(ahead(fishes, predator), (0.0, 0.0, 1.0))
    fishes.position[prey] = fishes.position[predator] + 90.0 * aside
    world.state.submarine.position[:] = -700.0, 0.0, -250.0  # prey fears the submarine too
    fleeing = 0
    for _ in range(40):
        step(world, TeleopCommand(predator, speed=0.6))
        fleeing += minds.predator[prey] == predator and minds.intention[prey] == ESCAPE
    gap = fishes.position[predator] - fishes.position[prey]
    apart = np.linalg.norm(gap)
    assert fleeing > 10  # until the predator is behind it, out of sight
    assert gap @ ahead(fishes, prey) < -0.6 * apart
    assert apart > 140.0  # from prey that stays the predator would come 120 cm away


def commands(fish, turn=0.0, speed=0.0, feeds=False):
    fish = np.asarray(fish)
    turn, rise, speed = (np.full(len(fish), share, np.float64) for share in (turn, 0.0, speed))
    return TeleopCommands(fish, turn, rise, speed, np.full(len(fish), feeds))


def test_several_fishes_follow_their_own_commands_in_one_tick(world, begun):
    fish = np.array([FISH, 7, 20])
    given = TeleopCommands(
        fish, np.array([1.0, -1.0, 0.0]), np.array([0.0, 0.5, 0.0]), np.array([0.7, 0.7, -1.0]),
        np.zeros(3, bool),
    )  # fmt: skip
    step(world, given)
    together = {
        name: array.copy() for name, array in snapshot.changing(world).items() if len(array) == 60
    }
    for k, one in enumerate(fish):
        snapshot.restore(world, begun[1])
        step(world, TeleopCommand(one, *(float(part[k]) for part in given[1:4])))
        for name, array in snapshot.changing(world).items():
            if name.startswith(("fishes.", "minds.")) and len(array) == 60:
                np.testing.assert_array_equal(array[one], together[name][one], err_msg=name)
    with pytest.raises(IndexError):
        step(world, commands([FISH, 60]))
    world.state.fishes.alive[FISH] = False
    step(world, commands([FISH, 7], turn=1.0))  # a dead fish is not steered


def test_a_steered_fish_that_may_feed_eats_what_is_before_its_mouth(world):
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    for feeds in (False, True):
        minds.eaten[FISH] = 0.0
        sea.absent[:] = 1e3
        sea.absent[4] = 0.0
        sea.plankton[4] = mouth_of(fishes, FISH) + 0.3 * fishes.length[FISH] * ahead(fishes, FISH)
        for _ in range(30):
            step(world, commands([FISH], speed=0.2, feeds=feeds))
        assert minds.eaten[FISH] == feeds
    assert minds.intention[FISH] == WANDER  # nothing is left to eat
    assert fishes.gape[FISH] == 0.0


def test_a_steered_predator_that_may_feed_catches_prey_and_chews_it():
    world = create_world(load_scenario("preying")[0])
    fishes, minds = world.state.fishes, world.state.minds
    shark = int(np.flatnonzero(minds.kind == PREDATOR)[0])
    prey = np.flatnonzero(minds.kind == PREY)
    step(world, NEUTRAL)
    for feeds, caught in ((False, 0), (True, 1), (True, 1)):  # the third is offered too early
        living = prey[fishes.alive[prey]]
        gap = 0.05 * fishes.length[shark]
        fishes.position[living[0]] = mouth_of(fishes, shark) + gap * ahead(fishes, shark)
        for _ in range(8):
            step(world, commands([shark], feeds=feeds))
        assert np.count_nonzero(~fishes.alive[prey]) == caught
