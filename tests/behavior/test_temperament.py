"""Settings of individual fishes, at the start and during a dive."""

import msgspec
import numpy as np
import pytest

from subsea.behavior.mental_state import apply_individual
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import IndividualTable, Shoal
from subsea.state import NOBODY
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S
from tests.support.daily import only


def bay(**options):
    scenario = load_scenario("peaceful")[0]
    shoal = Shoal(species="fusilier", number=8, position_cm=scenario.submarine.position_cm)
    changed = {"fish": [shoal], "tour": [], **options}
    return create_world(msgspec.structs.replace(scenario, **changed))


def test_individual_settings_draw_no_random_number():
    plain = bay()
    own = IndividualTable(
        fish=2, kind="predator", male=True, likes=["cold"], schooling=False, hunger=0.9,
        digestion=0.5, libido_rate=0.4, dread_cm=7.0,
    )  # fmt: skip
    other = IndividualTable(fish=5, kind="pacifist", libido=0.75, hunger=0.25)
    world = bay(individual=[own, other])
    minds, was = world.state.minds, plain.state.minds
    for name, array in snapshot.changing(plain).items():
        if not name.startswith(("minds.", "odour.")):  # fishes smell of what they are
            np.testing.assert_array_equal(snapshot.changing(world)[name], array, err_msg=name)
    others = np.array([0, 1, 3, 4, 6, 7])
    for name in ("kind", "male", "likes", "schools", "appetite", "eaten", "dread", "last_mating"):
        np.testing.assert_array_equal(getattr(minds, name)[others], getattr(was, name)[others])
    assert (minds.kind[2], bool(minds.male[2]), bool(minds.schools[2])) == (2, True, False)
    assert minds.likes[2].tolist() == [False, False, True, False]
    assert (minds.digestion[2], minds.dread[2]) == (0.5, 7.0)
    world.state.minds.digestion[:] = 0.0
    step(world, NEUTRAL)
    assert minds.mental[2, 0] == pytest.approx(0.9, abs=0.01)
    assert minds.mental[5, :2] == pytest.approx([0.25, 0.75], abs=0.03)


@pytest.mark.nightly
@pytest.mark.parametrize("name", only(["mating"], ["peaceful", "mating", "preying"]))
def test_fishes_may_become_others_while_diving(name):
    """A change of kind or sex during any behavior leaves no index with the wrong meaning."""
    world = create_world(load_scenario(name)[0], fish=12, live=0)
    state = world.state
    for tick in range(360):
        step(world, NEUTRAL)
        i, now = tick % 12, state.tick * TICK_S
        kind = ("pacifist", "prey", "predator")[(tick // 12) % 3]
        own = IndividualTable(
            fish=i, kind=kind, male=bool(tick % 2), schooling=bool(tick % 5), hunger=1.0
        )
        if tick % 4 == 0:
            apply_individual(state.fishes, state.minds, own, now)
            assert state.minds.partner[i] == NOBODY
            assert not (state.minds.partner == i).any()
    snapshot.restore(world, snapshot.take(world))  # refuses values that no tick may write


def test_hunger_and_libido_are_those_of_now():
    world = bay()
    state = world.state
    for _ in range(60):
        step(world, NEUTRAL)
    lone = IndividualTable(fish=1, kind="pacifist", hunger=0.125, libido=0.5)
    apply_individual(state.fishes, state.minds, lone, state.tick * TICK_S)
    step(world, NEUTRAL)
    assert state.minds.mental[1, :2] == pytest.approx([0.125, 0.5], abs=0.02)
    # Unnamed settings stay the same.
    fearful = IndividualTable(fish=1, dread_cm=3.0)
    apply_individual(state.fishes, state.minds, fearful, state.tick * TICK_S)
    step(world, NEUTRAL)
    assert state.minds.mental[1, :2] == pytest.approx([0.125, 0.5], abs=0.03)
    assert state.minds.dread[1] == 3.0
