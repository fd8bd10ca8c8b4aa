"""Continuing a dive in another world preserves changes by panels."""

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.behavior.mental_state import apply_individual
from subsea.geometry.solids import height_at
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import IndividualTable, Pillar, Shoal
from subsea.state import TRAITS
from subsea.submarine.vessel import NEUTRAL
from subsea.world import placement
from subsea.world.build import create_world
from subsea.world.migrate import migrate
from subsea.world.step import step

PILLAR = Pillar(position_cm=(0.0, 0.0), radius_cm=9.0, height_cm=9.0)


@pytest.fixture(scope="module")
def few():
    scenario = load_scenario("peaceful").scenario
    shoals = [Shoal(species=name, number=3) for name in ("fusilier", "blue_tang", "clownfish")]
    return replace(scenario, fish=shoals, reef=[], seaweed=[], individual=[], pillar=[])


@pytest.fixture
def changed(few):
    """A world with parameters changed by panels, and traits of two fishes of a shoal."""
    world = create_world(few)
    world.nature = world.nature._replace(keen=0.77)
    world.physics = world.physics._replace(viscosity=3.0)
    world.current_cm_s = (5.0, -6.0)
    for fish, appetite in ((3, 31.0), (5, 37.0)):
        male = not world.state.minds.male[fish]
        one = IndividualTable(fish=fish, male=male, likes=["cold"], appetite=appetite, dread_cm=9.0)
        apply_individual(world.state.fishes, world.state.minds, one, 0.0)
    return world


@pytest.mark.parametrize(
    ("edit", "there"),
    [
        (lambda s: placement.with_shoal_size(s, 0, 4), {3: 4, 5: 6}),  # one more before them
        (lambda s: placement.with_shoal_size(s, 1, 2), {3: 3}),  # the last of them is gone
        (lambda s: replace(s, fish=s.fish[1:]), {3: 0, 5: 2}),
        (lambda s: replace(s, fish=[*s.fish, s.fish[0]]), {3: 3, 5: 5}),
        (lambda s: replace(s, fish=[s.fish[0], s.fish[2]]), {}),
        (
            lambda s: replace(s, fish=[replace(s.fish[0], spread_cm=99.0), *s.fish[1:]]),
            {3: 3, 5: 5},
        ),
        (lambda s: replace(s, pillar=[PILLAR]), {3: 3, 5: 5}),
    ],
)
def test_changes_by_panels_persist(few, changed, edit, there):
    world, plain = create_world(edit(few)), create_world(edit(few))
    migrate(changed, world)
    assert world.nature.keen == 0.77
    assert world.physics.viscosity == 3.0
    assert world.current_cm_s == (5.0, -6.0)
    ours, theirs, usual = world.state.minds, changed.state.minds, plain.state.minds
    for old, new in there.items():
        for name in ("male", "likes", "appetite", "dread"):
            now, then = getattr(ours, name)[new], getattr(theirs, name)[old]
            np.testing.assert_array_equal(now, then, err_msg=name)
            assert np.any(now != getattr(usual, name)[new]), name
    others = np.setdiff1d(np.arange(len(ours.male)), list(there.values()))
    for name in TRAITS:
        np.testing.assert_array_equal(getattr(ours, name)[others], getattr(usual, name)[others])
    assert (ours.eaten <= ours.appetite).all()
    if len(ours.male) != len(theirs.male):  # they start again, with the usual hunger
        np.testing.assert_allclose(ours.eaten / ours.appetite, usual.eaten / usual.appetite, 1e-5)


@pytest.fixture
def placed(few):
    """A scenario whose first school has a place, and its world after some steps."""
    there = replace(few.fish[0], position_cm=(-500.0, 0.0, -250.0), spread_cm=60.0)
    scenario = replace(few, fish=[there, *few.fish[1:]])
    world = create_world(scenario)
    for _ in range(60):
        step(world, NEUTRAL)
    return scenario, world


def with_place(scenario, place):
    return replace(
        scenario, fish=[replace(scenario.fish[0], position_cm=place), *scenario.fish[1:]]
    )


def test_a_moved_school_goes_on_at_its_new_place(placed):
    scenario, before = placed
    world = create_world(with_place(scenario, (-600.0, 250.0, -260.0)))
    migrate(before, world)
    ours, theirs = world.state.fishes, before.state.fishes
    np.testing.assert_allclose(ours.position[:3].mean(axis=0), (-600.0, 250.0, -260.0), atol=0.01)
    shapes = [one.position[:3] - one.position[:3].mean(axis=0) for one in (ours, theirs)]
    np.testing.assert_allclose(*shapes, atol=1e-3)
    np.testing.assert_array_equal(ours.previous_position[:3], ours.position[:3])
    np.testing.assert_array_equal(ours.position[3:], theirs.position[3:])
    np.testing.assert_array_equal(ours.orientation, theirs.orientation)
    np.testing.assert_array_equal(world.state.minds.mental, before.state.minds.mental)
    assert world.state.tick == before.state.tick
    step(world, NEUTRAL)  # it swims on from there
    assert np.linalg.norm(ours.position[:3] - ours.previous_position[:3], axis=1).max() < 15.0


@pytest.mark.parametrize("place", [(1290.0, 0.0, -250.0), (0.0, 0.0, -2.0), (300.0, 0.0, -590.0)])
def test_a_school_that_is_moved_to_the_edge_stays_in_the_sea(placed, place):
    scenario, before = placed
    world = create_world(with_place(scenario, place))
    migrate(before, world)
    sea = world.state.sea
    for x, y, z in world.state.fishes.position[:3]:
        assert np.hypot(x, y) < sea.radius
        assert height_at(sea.floor, sea.half_width, float(x), float(y)) < z < 0.0


def test_a_clownfish_that_is_moved_has_its_home_there(few):
    scenario = replace(few, fish=[
        replace(one, position_cm=(0.0, 0.0, -300.0), spread_cm=50.0) for one in few.fish
    ])  # fmt: skip
    before = create_world(scenario)
    shoals = [*scenario.fish[:2], replace(scenario.fish[2], position_cm=(300.0, 200.0, -400.0))]
    world = create_world(replace(scenario, fish=shoals))
    homes = world.state.minds.home.copy()
    migrate(before, world)
    np.testing.assert_array_equal(world.state.minds.home[6:], homes[6:])
    np.testing.assert_array_equal(world.state.minds.home[:6], before.state.minds.home[:6])
