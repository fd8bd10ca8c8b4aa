"""Continuing a dive in another world preserves changes by panels."""

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.behavior.temperament import apply_individual
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import IndividualTable, Pillar, Shoal
from subsea.state import TRAITS
from subsea.world import placement
from subsea.world.build import create_world
from subsea.world.migrate import migrate

PILLAR = Pillar(position_cm=(0.0, 0.0), radius_cm=9.0, height_cm=9.0)


@pytest.fixture(scope="module")
def few():
    scenario, _ = load_scenario("peaceful")
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
