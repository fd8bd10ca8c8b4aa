"""Measures of short records of scenarios; behavior-figures.md has figures at full length."""

import pytest

from subsea.cli.main import main
from subsea.fish.measured import load_measured
from subsea.lab.report import measure
from subsea.media.record import read_record

MINUTE, FIFTY_SECONDS = 1900, 1515  # ticks
pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def studied(tmp_path_factory):
    """Measures of the first minute of the peaceful bay, and among pillars."""
    folder = tmp_path_factory.mktemp("scenarios")
    found = {}
    for scenario, ticks in (("peaceful", MINUTE), ("schooling", FIFTY_SECONDS)):
        out = folder / f"{scenario}.h5"
        options = ["--scenario", scenario, "--ticks", str(ticks), "--out", str(out)]
        assert main(["simulate", *options]) == 0
        found[scenario] = measure(read_record(out))
    return found


@pytest.mark.parametrize("scenario", ["peaceful", "schooling"])
def test_fishes_stay_in_free_water_and_intentions_are_stable(studied, scenario):
    sea, minds = studied[scenario]["sea"], studied[scenario]["minds"]
    assert sea["out_of_bounds_or_inside"] == 0
    assert sea["overlap_share"] < 0.005
    assert 0.0 < minds["changes_per_second"] <= 1.0


def test_hunger_is_not_saturated_with_plankton(studied):
    assert studied["peaceful"]["minds"]["hunger_saturated_share"] == 0.0


def test_a_minute_has_several_activities(studied):
    budgets = studied["peaceful"]["minds"]["time_budget"]
    assert budgets["Yellowback fusilier"]["school"] > 0.3
    assert sum(budget["eat"] for budget in budgets.values()) > 0.05
    assert studied["peaceful"]["food"]["meals"] > 0


def test_a_school_is_polarised_and_evenly_spaced_while_it_cruises(studied):
    (school,) = studied["schooling"]["schools"]
    assert school["cruising_share"] > 0.9
    for one in (*studied["peaceful"]["schools"], school):
        assert 0.6 <= one["polarisation_median"] <= 0.97  # free schools, not parades
        assert 0.6 <= one["nearest_bl"]["p50"] <= 1.6


def test_a_school_passes_pillars_and_is_together_again(tmp_path):
    """Without a leader it passes on one side or on both: in some bays it splits, in others not."""
    _, longest = load_measured().schools.split.range
    parted = 0
    for seed in range(3, 7):
        out = tmp_path / f"{seed}.h5"
        options = ["--ticks", str(FIFTY_SECONDS), "--seed", str(seed), "--out", str(out)]
        assert main(["simulate", "--scenario", "schooling", *options]) == 0
        found = measure(read_record(out))
        sea, (school,) = found["sea"], found["schools"]
        assert sea["least_clearance_from"] == "pillar"
        assert 0.0 < sea["least_clearance_cm"] < 60.0  # it meets one, and no fish touches it
        assert sea["out_of_bounds_or_inside"] == 0
        for split in school["each_split"]:
            assert split["rejoined"] and split["lasted_s"] <= longest
        parted += any(split["apart_share"] >= 0.1 for split in school["each_split"])
    assert 0 < parted < 4
