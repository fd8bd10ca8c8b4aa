"""Lasting differences between fishes of a species, and what they change."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.base.errors import UserError
from subsea.behavior import curious, wandering
from subsea.behavior.mental_state import TRAITS_OF_CHARACTER, apply_individual
from subsea.fish.character import SYNDROME, CharacterPlan, draw_character
from subsea.perception.collision import sensitivity
from subsea.perception.focusser import set_targets
from subsea.scenario.load import load_scenario
from subsea.scenario.save import save_scenario
from subsea.scenario.schema import IndividualTable, Shoal
from subsea.state import EAT
from subsea.world.build import create_world
from subsea.world.to_scenario import equal_tunables, get_tunables, to_scenario

ROOT = Path(__file__).parents[2]
PLAN = CharacterPlan(timidity=(1.4, 0.3), activity=(0.8, 0.1))


@pytest.mark.parametrize("seed", [1, 77])
def test_traits_are_about_the_species_and_go_together(seed):
    traits = draw_character(PLAN, seed, 0, 4000)
    assert set(traits) == {*TRAITS_OF_CHARACTER, "appetite"}
    for name, (mean, spread) in (("timidity", PLAN.timidity), ("activity", PLAN.activity)):
        logs = np.log(traits[name])
        assert np.exp(np.median(logs)) == pytest.approx(mean, rel=0.03)
        assert logs.std() == pytest.approx(spread, rel=0.1)
        assert np.abs(logs - np.log(mean)).max() < 2.01 * spread
    together = np.corrcoef([np.log(traits[name]) for name in SYNDROME])
    assert together[0, 1] < -0.25 and together[0, 2] > 0.25  # bold ones are active and unsociable
    assert abs(np.corrcoef(traits["timidity"], traits["appetite"])[0, 1]) < 0.06


def test_the_same_seed_is_the_same_fish():
    traits = draw_character(PLAN, 5, 0, 30)
    part, other = draw_character(PLAN, 5, 10, 20), draw_character(PLAN, 6, 0, 30)
    for name, values in traits.items():
        np.testing.assert_array_equal(part[name], values[10:], err_msg=name)
        assert (other[name] != values).all()


def test_a_species_without_spread_has_one_character():
    uniform = CharacterPlan(timidity=(1.25, 0.0))
    assert (draw_character(uniform, 1, 0, 9)["timidity"] == np.float32(1.25)).all()


def few(**keys):
    """A bay with two shoals, the second with these keys."""
    scenario = load_scenario("peaceful").scenario
    shoals = [
        Shoal(species="blue_tang", number=5),
        Shoal(species="blue_tang", number=6, **keys),
    ]
    return replace(scenario, fish=shoals, tour=[], individual=[IndividualTable(fish=1, timidity=3)])


def test_shoals_and_individuals_override_the_species_and_are_saved(tmp_path):
    scenario = few(sociability=(2.0, 0.0), appetite=(3.0, 0.0), dusk=0.25)
    world = create_world(scenario)
    minds = world.state.minds
    assert (minds.sociability[5:] == 2.0).all() and minds.sociability[:5].std() > 0.0
    assert minds.timidity[1] == 3.0
    assert (minds.appetite[5:] > 1.8 * minds.appetite[:5].mean()).all()
    assert (minds.dusk[5:] == 0.25).all() and (minds.dusk[:5] < 0.0).all()
    assert to_scenario(world) == scenario
    for fish in range(5):
        shy = IndividualTable(fish=fish, activity=0.5, mild=0.75)
        apply_individual(world.state.fishes, minds, shy, 0.0)
    apply_individual(world.state.fishes, minds, IndividualTable(fish=8, devotion=9.0), 0.0)
    saved = to_scenario(world)
    assert saved.fish[0].activity == (0.5, 0.0) and saved.fish[0].mild == 0.75
    save_scenario(saved, tmp_path / "saved.toml")
    again = create_world(load_scenario(str(tmp_path / "saved.toml")).scenario)
    assert equal_tunables(get_tunables(again), get_tunables(world))


def test_a_change_of_kind_keeps_the_appetite_of_the_character():
    world = create_world(few())
    minds = world.state.minds
    before = minds.appetite.copy()
    for kind in ("predator", "pacifist"):
        apply_individual(world.state.fishes, minds, IndividualTable(fish=7, kind=kind), 0.0)
    np.testing.assert_array_equal(minds.appetite, before)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("timidity = 1.5", ["timidity", "list"]),
        ("timidity = [9.0, 0.2]", ["timidity", "5"]),
        ("activity = [1.0, 1.5]", ["activity", "1"]),
        ("dusk = 1.5", ["dusk", "1"]),
    ],
)
def test_bad_traits_are_refused_in_a_line(tmp_path, keys, words):
    text = (ROOT / "assets/scenarios/peaceful.toml").read_text()
    file = tmp_path / "mine.toml"
    file.write_text(text.replace('species = "blue_tang"\n', f'species = "blue_tang"\n{keys}\n', 1))
    with pytest.raises(UserError) as caught:
        load_scenario(str(file))
    message = str(caught.value)
    assert "\n" not in message and all(word in message for word in words), message


def test_timid_fishes_keep_farther_from_others_and_the_submarine(tank):
    t = tank(2)
    t.minds.timidity[:] = 0.5, 2.0
    bold, timid = (sensitivity(t.minds, i, t.nature) for i in range(2))
    assert timid.margin == pytest.approx(4.0 * bold.margin)
    assert timid.foresight == pytest.approx(4.0 * bold.foresight)
    t.sea.submarine[:3] = 0.9 * t.nature.curiosity_cm, 0.0, -300.0
    bold_comes, timid_comes = t.desire(curious.desire) > 0.0
    assert bold_comes and not timid_comes


def test_active_fishes_cruise_faster_and_pause_less(tank):
    t = tank(300)
    t.minds.activity[:] = np.repeat((0.8, 1.0, 1.25), 100)
    t.minds.waypoint[:] = 600.0, 0.0, -300.0
    t.minds.patience[:] = 1e3
    speeds = []
    for tick in range(60):
        t.fishes.recommended[:] = tick // 10 % 2 if tick % 10 == 0 else -1  # hover, cruise in turn
        t.at(tick).run(wandering.act)
        speeds.append(t.fishes.goal_speed.reshape(3, 100).copy())
    speeds = np.array(speeds)
    lazy, usual, active = speeds.mean(axis=(0, 2))
    assert lazy < 0.8 * usual and active > 1.2 * usual
    lazy, usual, active = (speeds < 0.2).mean(axis=(0, 2))
    assert lazy > usual + 0.1 and active < usual - 0.1


@pytest.mark.parametrize(("devotion", "kept"), [(0.2, False), (3.0, True)])
def test_devoted_fishes_keep_their_target(tank, devotion, kept):
    t = tank(1, specks=2)
    t.minds.devotion[0] = devotion
    t.minds.intention[0] = EAT
    t.sea.plankton[:] = (57.0, 0.0, -300.0), (30.0, 0.0, -300.0)  # the second is 27 cm nearer
    t.minds.foods[0, :2] = 1, 0
    t.minds.target[0] = 0
    set_targets(np.arange(1), t.fishes, t.minds, t.sea, t.nature)
    assert (t.minds.target[0] == 0) == kept


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [2, 6])
def test_active_fishes_lead_and_sociable_ones_are_in_the_middle(seed):
    """Stable differences explain who swims where in a school (Jolles et al. 2017)."""
    spec = spec_from_file_location("figures", ROOT / "docs/character_figures.py")
    figures = module_from_spec(spec)
    spec.loader.exec_module(figures)
    found = figures.schooling(seed)
    assert found["front repeats"] > 0.4
    assert found["activity: front"] > 0.3
    assert found["sociability: from the middle"] < -0.3
    assert found["sociability: next neighbour"] < -0.3
