"""Places, numbers and homes of the fishes of a scenario."""

import numpy as np
from msgspec import structs

from subsea.geometry.rotation import quaternion, rotate
from subsea.geometry.vector import vector
from subsea.habitat.reef import KINDS as GROWTHS
from subsea.motor.containment import deepest
from subsea.motor.pose import ends
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Rock, Shoal
from subsea.scenario.shoals import shoal_sizes, with_total
from subsea.state import Fishes, Minds, Reef, empty
from subsea.world.build import create_world
from subsea.world.populate import ABOVE_HOME_CM, settle
from subsea.world.repertoires import species_of
from tests.support.scenes import BARE


def test_a_scenario_is_scaled_to_a_total_number():
    scenario = load_scenario("peaceful").scenario
    assert with_total(scenario, None) is scenario
    small = with_total(scenario, 9)
    assert [shoal.number for shoal in small.fish] == shoal_sizes(scenario, 9)
    assert sum(shoal.number for shoal in small.fish) == 9


def test_clownfish_live_at_the_nearest_anemone():
    """Those without one near live where they start; other species have no home."""
    species = [species_of(name) for name in ("clownfish", "fusilier")]
    fishes, minds = empty(Fishes, n=4), empty(Minds, n=4, b=1, d=1)
    fishes.species[3] = 1
    fishes.position[:, 0] = 0.0, 300.0, 2000.0, 0.0
    reef = empty(Reef, k=3)
    names = list(GROWTHS)
    reef.kind[:] = names.index("brain"), names.index("anemone"), names.index("brain")
    reef.place[:, 0], reef.axis[:, 2], reef.radius[:] = (0.0, 250.0, 900.0), 1.0, 5.0
    settle(species, fishes, minds, reef)
    up = 5.0 + ABOVE_HOME_CM
    assert minds.home[:3].tolist() == [[250.0, 0, up], [250.0, 0, up], [2000.0, 0, 0]]
    assert minds.home_range.tolist() == [100.0, 100.0, 100.0, np.inf]


def test_rays_keep_to_the_ground_by_their_length_and_others_do_not():
    scenario = load_scenario(str(BARE)).scenario
    shoals = [Shoal(species=name, number=2) for name in ("spotted_eagle_ray", "fusilier")]
    world = create_world(structs.replace(scenario, fish=shoals, tour=[]), 1)
    length, heights = world.state.fishes.length, world.state.minds.cruise_height
    np.testing.assert_allclose(heights[:2], length[:2, None] * np.array([0.45, 1.0]), rtol=1e-6)
    assert np.isinf(heights[2:]).all()


def test_no_body_begins_in_a_solid():
    """Sharks whose places lie deep in a rock, whose nearest surface is hard to tell from there."""
    scenario = load_scenario(str(BARE)).scenario
    rock = Rock(position_cm=(0.0, 0.0), size_cm=(400.0, 200.0, 250.0), height_cm=200.0)
    sharks = Shoal(
        species="blacktip_reef_shark", number=12, position_cm=(0.0, 230.0, -350.0), spread_cm=300.0
    )
    for seed in range(3):
        world = create_world(structs.replace(scenario, rock=[rock], fish=[sharks], tour=[]), seed)
        fishes, nodes = world.state.fishes, world.library.nodes
        for i in range(12):
            turn = quaternion(fishes.orientation[i])
            parts = [rotate(turn, end) for end in ends(fishes, nodes, i)]
            gap, _ = deepest(vector(fishes.position[i]), *parts, world.state.sea, np.float32(0.0))
            assert gap > -0.01
        assert (fishes.velocity == 0.0).all()
        assert (fishes.previous_position == fishes.position).all()
