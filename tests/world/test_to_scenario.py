"""A world exported as a scenario and built again has the same parameters."""

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.behavior.mental_state import apply_individual
from subsea.scenario.load import load_scenario
from subsea.scenario.save import save_scenario
from subsea.scenario.schema import IndividualTable
from subsea.world.build import create_world
from subsea.world.to_scenario import equal_tunables, get_tunables, to_scenario


@pytest.fixture(scope="module")
def few():
    scenario = load_scenario("peaceful").scenario
    shoals = [replace(shoal, number=3) for shoal in scenario.fish]
    return replace(scenario, fish=shoals, individual=[IndividualTable(fish=2, hunger=0.5)])


@pytest.fixture
def world(few):
    return create_world(few)


def set_of(world, **own):
    one = IndividualTable(**own)
    apply_individual(world.state.fishes, world.state.minds, one, 0.0)


def test_without_changes_the_scenario_is_the_same(world, few):
    assert to_scenario(world) == few


@pytest.mark.nightly
def test_a_world_built_from_the_export_has_the_same_parameters(world, few, tmp_path):
    set_of(world, fish=1, male=True, likes=["cold", "warmth"], dread_cm=70.0)
    set_of(world, fish=4, kind="predator", digestion=0.0123, appetite=7.0, schooling=True)
    for fish in (6, 7, 8):
        set_of(world, fish=fish, kind="prey", male=False, libido_rate=0.04)
    world.nature = world.nature._replace(keen=0.4, timidity=1.5)
    world.current_cm_s = (3.0, -2.0)
    world.physics = world.physics._replace(viscosity=2.0)
    saved = to_scenario(world)
    save_scenario(saved, tmp_path / "saved.toml")
    again = create_world(load_scenario(str(tmp_path / "saved.toml"))[0])
    assert equal_tunables(get_tunables(again), get_tunables(world))
    # Traits that a shoal shares are in its table.
    assert [one.fish for one in saved.individual] == [1, 2, 4]
    assert (saved.fish[2].kind, saved.fish[2].male_share) == ("prey", 0.0)
    assert saved.individual[1] == few.individual[0]
    assert to_scenario(again) == saved


def test_an_undone_change_leaves_no_trace(world, few):
    male = bool(world.state.minds.male[5])
    set_of(world, fish=5, male=not male)
    assert to_scenario(world).individual[1] == IndividualTable(fish=5, male=not male)
    set_of(world, fish=5, male=male)
    assert to_scenario(world) == few
    np.testing.assert_array_equal(world.state.minds.male[5], male)
