"""Experiments with the physics of simulated fishes (Tu §9.2): effective and safe."""

import msgspec
import numpy as np
import pytest

from subsea.geometry.solids import height_at
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Shoal
from subsea.state import Physics
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from tests.support.daily import only

LITTLE = "water.plankton=300", "seaweed=[]"  # fewer drifting specks, no seaweed


def bay(**options):
    """Eight fusiliers near the submarine, four simulated, and little else, to save time.

    They do not fear the submarine, or a flight would take them away from it.
    """
    scenario = load_scenario("peaceful", LITTLE).scenario
    shoal = Shoal(
        species="fusilier", number=8, position_cm=scenario.submarine.position_cm, spread_cm=150.0,
        hunger=0.0, libido=0.0,
    )  # fmt: skip
    nature = msgspec.structs.replace(scenario.nature, submarine_cm=0.0)
    changed = {"fish": [shoal], "tour": [], "simulated": 4, "nature": nature, **options}
    return create_world(msgspec.structs.replace(scenario, **changed))


def went_on(world, ticks, seen=lambda world: None):
    for _ in range(ticks):
        step(world, NEUTRAL)
        seen(world)
    return world


def finite(world):
    for name, array in snapshot.changing(world).items():
        if array.dtype.kind == "f":
            good = np.isfinite(array) | (np.isinf(array) & (snapshot.may_be_infinite(name)))
            assert good.all(), name


@pytest.fixture(scope="module")
def usual():
    """Snapshot of the bay after two seconds with some simulated fishes, and the bay."""
    world = went_on(bay(), 60)
    assert world.state.fishes.live.sum() == 4
    return world, snapshot.take(world)


def tried(usual, physics, ticks):
    world, start = usual
    snapshot.restore(world, start)
    world.physics, world.notices = physics, []
    world.reported_bursts.clear()
    simulated = world.state.fishes.live.copy()
    went_on(world, ticks)
    return world, simulated


def way(usual, physics, ticks=45):
    """Distances, cm, of the fishes that are simulated at first, and their actions."""
    world, simulated = tried(usual, physics, 1)
    begin = world.state.fishes.position.copy()
    went_on(world, ticks)
    return np.linalg.norm(world.state.fishes.position - begin, axis=1)[simulated].mean(), world


def test_each_constant_changes_the_way_of_simulated_fishes_alone(usual):
    tried(usual, Physics(), 8)
    world = usual[0]
    as_usual = world.state.fishes.position.copy()
    simulated = world.state.fishes.live.copy()
    for change in (
        {"unit_mass": 1.5}, {"viscosity": 3.0}, {"stiffness": 1.3}, {"water_viscosity": 0.5},
        {"hydrodynamics": False}, {"time_step": 0.5}, {"iterations": 9},
    ):  # fmt: skip
        tried(usual, Physics(**change), 8)
        moved = np.linalg.norm(world.state.fishes.position - as_usual, axis=1)
        assert (moved[simulated] > 1e-3).all(), change
        # Others follow and leave them, a little.
        assert moved[~simulated].max() < moved[simulated].max() + 1.0, change


def test_the_wave_of_a_passing_hull_turns_simulated_fishes_alone(usual, monkeypatch):
    early, headings = [], []
    for patched in (False, True):
        world, live = tried(usual, Physics(), 0)
        if patched:
            monkeypatch.setattr(
                "subsea.world.step.shear_at", lambda who, *_: np.zeros((len(who), 2, 3))
            )
        for _ in range(2):
            step(world, Helm(surge=1.0))
        early.append(world.state.fishes.orientation[~live].copy())
        for _ in range(33):
            step(world, Helm(surge=1.0))
        headings.append(world.state.fishes.orientation.astype(float))
    turned = 2.0 * np.arccos(np.clip(np.abs((headings[0] * headings[1]).sum(axis=1)), 0.0, 1.0))
    assert np.degrees(turned[live]).max() > 0.3
    np.testing.assert_array_equal(*early)  # others only follow and leave them, later


def test_without_water_the_tail_beats_and_no_beat_drives_the_fish(usual):
    world, _ = tried(usual, Physics(hydrodynamics=False), 1)
    live, mass = world.state.live, world.dynamics.bodies.mass[0]
    before, begun = mass @ live.v, live.phase.copy()
    went_on(world, 45)
    assert world.state.fishes.live.sum() == 4
    assert (live.phase != begun).all()
    np.testing.assert_allclose(mass @ live.v, before, atol=1e-6 * np.abs(before).max())


def test_more_iterations_and_longer_steps_are_a_faster_life(usual):
    far, _ = way(usual, Physics())
    pace = beat(usual, Physics())
    for physics, times in ((Physics(iterations=9), 1.5), (Physics(time_step=0.5), 0.5)):
        assert beat(usual, physics) == pytest.approx(times * pace, rel=1e-6)
        other, world = way(usual, physics)
        assert (other > far) == (times > 1.0)
        assert not world.notices


def beat(usual, physics):
    """Displacement of the tails of simulated fishes per tick, in radians of their beat."""
    world, _ = tried(usual, physics, 0)
    before = world.state.live.phase.copy()
    step(world, NEUTRAL)
    return (world.state.live.phase - before) % (2.0 * np.pi)


EXPLOSIVE = [
    # This fish is fast and never turns: it would leave the sea within ten seconds.
    (Physics(1.15, 1.8, 0.32, 0.13, hydrodynamics=False, time_step=2.3, iterations=54),),
    (Physics(time_step=50.0, hydrodynamics=False),),
    (Physics(time_step=20.0, iterations=60),),
    (Physics(stiffness=0.01, viscosity=0.0, time_step=8.0),),
    (Physics(unit_mass=0.1, water_viscosity=100.0, time_step=10.0),),
    (Physics(stiffness=100.0, unit_mass=10.0, viscosity=100.0),),
    (Physics(viscosity=0.0, hydrodynamics=False, stiffness=100.0),),
    (Physics(time_step=0.05, iterations=1),),
]


@pytest.mark.parametrize("physics", only(EXPLOSIVE[:2], EXPLOSIVE))
def test_a_fish_that_explodes_is_contained(usual, physics, monkeypatch):
    world, simulated = tried(usual, physics, 0)
    bounds, others = world.scenario.bounds, ~simulated
    last = world.state.fishes.position.copy()
    for _ in range(400):
        was = world.state.fishes.live.copy()
        step(world, NEUTRAL)
        fishes = world.state.fishes
        leap = np.linalg.norm(fishes.position - last, axis=1) / fishes.length
        assert (leap / fishes.rate).max() < 1.2  # a recorded frame
        assert leap[others & ~was & ~fishes.live].max(initial=0.0) < 0.5
        last = fishes.position.copy()
        finite(world)
    snapshot.restore(world, snapshot.take(world))  # refuses values that no tick may write
    assert np.hypot(*last[:, :2].T).max() < bounds.radius_cm
    assert (last[:, 2] < 0.0).all()
    for x, y, z in last:
        assert z > height_at(world.state.sea.heights, world.state.sea.half_width, x, y)
    # One notice for each fish, with the reason.
    assert len(world.notices) == len(set(world.notices)) <= 8
    for line in world.notices:
        assert "Yellowback fusilier) exploded, " in line
    # The usual physics restores normal motion, wherever the fishes are by now.
    world.physics = Physics()
    monkeypatch.setattr(world, "dynamics", world.dynamics._replace(reach_cm=np.inf))
    for _ in range(300):
        went_on(world, 1, finite)
        if world.state.fishes.live.any():
            break
    else:
        raise AssertionError("no fish is simulated again")


def test_an_explosion_is_reported_with_its_reason(usual):
    world, simulated = tried(usual, Physics(time_step=50.0, hydrodynamics=False), 2)
    assert not world.state.fishes.live.any()
    slots = [int(fish) for fish in world.state.live.fish]
    assert sorted(slots) == np.flatnonzero(simulated).tolist()
    who = " and ".join(f"{fish} (Yellowback fusilier)" for fish in slots)
    assert world.notices == [
        f"fishes {who} exploded, time step 50, hydrodynamics off: they are played back instead "
        "of simulated"
    ]
    world.physics = world.physics._replace(fish=slots[0])  # the same but for the first fish
    world.report_bursts(slots)
    assert len(world.notices) == 1


def test_a_scenario_says_the_physics_that_a_panel_would(usual):
    physics = Physics(stiffness=1.3, iterations=9)
    table = msgspec.convert({"stiffness": 1.3, "iterations": 9}, type(bay().scenario.physics))
    assert bay(physics=table).physics == physics
    assert bay().physics == Physics()
