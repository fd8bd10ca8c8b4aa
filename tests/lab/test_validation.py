"""The runs of a validation, their measures and their findings."""

import pytest

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.jobs import workers
from subsea.jobs.workers import serial
from subsea.lab.validation import (
    GROUP_SIZES,
    SCHOOL_SIZES,
    SeaTrial,
    Validation,
    default_scenarios,
    one_group,
    run_trials,
    trials,
)
from subsea.scenario.load import load_scenario
from tests.support.scenes import BARE


def test_trials_are_scenarios_schools_and_groups():
    found = [*trials(Validation(["schooling", "preying", "open-ocean"], (1, 2), 10))]
    labels = [one.label for one in found]
    assert len(found) == 2 * (3 + len(SCHOOL_SIZES) + len(GROUP_SIZES))
    assert "open-ocean of 3000 fishes" in labels and "schooling of 144" in labels
    assert {one.size for one in found if one.hunt} == set(GROUP_SIZES)
    assert len(default_scenarios()) >= 8
    with pytest.raises(UserError, match="'preying'"):
        [*trials(Validation(["preyin"], (1,), 10))]


@pytest.mark.parametrize("size", GROUP_SIZES)
def test_a_group_leaves_the_predators_and_one_shoal_of_prey(size):
    chosen = load_scenario("preying", one_group("preying", size)).scenario
    assert sorted(shoal.number for shoal in chosen.fish if shoal.number) == sorted([1, size])


def test_a_small_sea_is_measured(tmp_path, capsys, monkeypatch):
    trial = SeaTrial("bare", str(BARE), 1, 90)
    ((_, found),), crashed = run_trials([trial], serial)
    assert not crashed and found.swims
    fishes = sum(shoal.number for shoal in load_scenario(str(BARE))[0].fish)
    assert sum(one.fish_ticks for one in found.outside) == 90 * fishes
    page = tmp_path / "page.md"
    monkeypatch.setattr(workers, "process_pool", lambda number: serial)
    words = ["study", "--validate", str(BARE), "--seeds", "1", "--seconds", "1", "--jobs", "1"]
    assert main([*words, "--report", str(page)]) == 0
    assert "bare_sea" in page.read_text() and "out of bounds" in capsys.readouterr().out
