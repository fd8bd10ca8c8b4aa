from subsea.scenario.load import load_scenario
from subsea.world.populate import shoal_sizes, with_total


def test_a_scenario_is_scaled_to_a_total_number():
    scenario, _ = load_scenario("peaceful")
    assert with_total(scenario, None) is scenario
    small = with_total(scenario, 9)
    assert [shoal.number for shoal in small.fish] == shoal_sizes(scenario, 9)
    assert sum(shoal.number for shoal in small.fish) == 9
