"""Rules of schools in scenario files: which table wins, bad input, saving, and rows of a world."""

import math

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.scenario.load import load_scenario
from subsea.scenario.save import save_scenario
from subsea.scenario.school_rules import MAX_RULES, NAMES, USUAL, SchoolRules, merged
from subsea.state import school_rules as columns
from subsea.state.school_rules import RULE_COLUMNS, rule_row
from subsea.world.build import create_world

LIKE = resource_path("assets/scenarios") / "peaceful.toml"


def _scenario(*changes, name="peaceful"):
    return load_scenario(name, changes).scenario


def test_the_usual_rules_have_every_key():
    assert all(getattr(USUAL, name) is not None for name in NAMES)
    assert merged([]) == USUAL


def test_later_tables_win_key_by_key():
    scenario = _scenario(
        "school.noise_deg=11", "school.alignment=2", "school.informed=0.5",
        "school.species.fusilier.alignment=3", "school.species.fusilier.informed=0.6",
        "fish.0.rules.informed=0.7",
    )  # fmt: skip
    fusilier, silverside = (scenario.rules_of(shoal) for shoal in scenario.fish[:2])
    assert (fusilier.noise_deg, fusilier.alignment, fusilier.informed) == (11, 3, 0.7)
    assert (silverside.noise_deg, silverside.alignment, silverside.informed) == (11, 2, 0.5)
    assert fusilier.neighbours == USUAL.neighbours


def test_each_fish_has_the_row_of_its_shoal():
    world = create_world(_scenario("fish.1.rules.noise_deg=90", "school.blind_deg=180"))
    minds = world.state.minds
    noise = minds.rules[minds.school_rule, columns.NOISE_RAD]
    np.testing.assert_allclose(noise[:33], math.radians(USUAL.noise_deg))
    np.testing.assert_allclose(noise[33:51], math.pi / 2)
    np.testing.assert_allclose(minds.rules[:2, columns.BLIND_COS], 0.0, atol=1e-12)
    assert np.unique(minds.school_rule).tolist() == [0, 1]


def test_goals_are_columns_of_the_row():
    goals = [{"share": 0.1, "heading_deg": 90.0}, {"share": 0.2, "position_cm": [1.0, 2.0, -3.0]}]
    row = rule_row(merged([msgspec.convert({"goals": goals}, SchoolRules)]))
    assert len(row) == RULE_COLUMNS
    np.testing.assert_allclose(
        row[columns.GOALS :], [0.1, columns.HEADING, 0, 1, 0, 0.2, columns.PLACE, 1, 2, -3],
        atol=1e-12,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("school.noise_deg=-1", ["`school.noise_deg`", "at least 0", "-1"]),
        ("school.noise_s=0", ["`school.noise_s`", "at least 0.05"]),
        ("school.neighbours=8", ["`school.neighbours`", "at most 7", "8"]),
        ("school.neighbours=2.5", ["`school.neighbours`", "a whole number"]),
        ("school.informed=1.5", ["`school.informed`", "at most 1"]),
        ("school.blind_deg=400", ["`school.blind_deg`", "at most 360"]),
        ("school.noise=1", ["unknown key", "noise_s"]),
        ("school.species.fusilir.noise_deg=1", ["`school.species.fusilir`", "fusilier"]),
        ("school.species.fusilier.alignment=11", ["at most 10", "11"]),
        (
            "fish.0.rules={separation_bl=1.2,attraction_bl=1.0}",
            ["`fish[0].rules.separation_bl`", "at most 1"],
        ),
        ("school.full_attraction_bl=0.9", ["`school.full_attraction_bl`", "more than 1"]),
        ("school.goals=[{share=0.1}]", ["`school.goals[0]`", "position_cm", "heading_deg"]),
        (
            "school.goals=[{share=0.6,heading_deg=1},{share=0.6,heading_deg=2}]",
            ["`school.goals`", "1.2", "at most 1"],
        ),
        (
            "school.goals=[{share=0.6,position_cm=[9000.0,0.0,-100.0]}]",
            ["`school.goals[0].position_cm`", "outside the sea"],
        ),
    ],
)
def test_bad_rules_are_refused_in_one_line(change, told):
    with pytest.raises(UserError) as fault:
        _scenario(change)
    message = str(fault.value)
    assert "\n" not in message
    assert all(part in message for part in told), message


def test_fishes_that_keep_far_apart_attract_from_there_on():
    """Unless the scenario says from where."""
    assert merged([SchoolRules()]).attraction_bl == USUAL.attraction_bl
    assert merged([SchoolRules(separation_bl=1.2)]).attraction_bl == 1.2
    assert merged([SchoolRules(separation_bl=0.5)]).attraction_bl == USUAL.attraction_bl
    assert merged([SchoolRules(separation_bl=1.2, attraction_bl=1.5)]).attraction_bl == 1.5


def test_too_many_different_rules_are_refused(tmp_path):
    text = LIKE.read_text(encoding="utf-8")
    for k in range(MAX_RULES + 1):
        text += (
            f'\n[[fish]]\nspecies = "fusilier"\nnumber = 1\nrules = {{ noise_deg = {k + 30} }}\n'
        )
    file = tmp_path / "many.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match=f"at most {MAX_RULES}"):
        load_scenario(str(file))


@pytest.mark.parametrize("like", [None, LIKE])
def test_rules_are_saved(tmp_path, like):
    scenario = _scenario(
        "school.noise_deg=11", "school.species.fusilier.alignment=3", "fish.1.rules.neighbours=4",
        "school.goals=[{share=0.1,heading_deg=40.0}]",
    )  # fmt: skip
    file = tmp_path / "saved.toml"
    save_scenario(scenario, file, like)
    assert load_scenario(str(file)).scenario == scenario
    # A second change is made in place.
    again = _scenario("school.noise_deg=12", "school.species.hardyhead_silverside.alignment=2")
    save_scenario(again, file, file)
    assert load_scenario(str(file)).scenario == again
