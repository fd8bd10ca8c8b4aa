"""Measures of short records of scenarios; behavior-figures.md has figures at full length."""

from statistics import median

import pytest

from subsea.cli.main import main
from subsea.fish.measured import load_measured
from subsea.lab.report import measure
from subsea.media.record import read_record

MINUTE, FIFTY_SECONDS = 1900, 1515  # ticks
pytestmark = pytest.mark.nightly


def _measured(folder, scenario, ticks, seed=None):
    out = folder / f"{scenario}-{seed}.h5"
    options = ["--scenario", scenario, "--ticks", str(ticks), "--out", str(out)]
    options += [] if seed is None else ["--seed", str(seed)]
    assert main(["simulate", *options]) == 0
    return measure(read_record(out))


@pytest.fixture(scope="module")
def channel(tmp_path_factory):
    """Measures of a school among pillars, by seed."""
    folder = tmp_path_factory.mktemp("channel")
    return {seed: _measured(folder, "schooling", FIFTY_SECONDS, seed) for seed in range(3, 7)}


@pytest.fixture(scope="module")
def studied(tmp_path_factory, channel):
    """Measures of the first minute of the peaceful bay, and among pillars."""
    peaceful = _measured(tmp_path_factory.mktemp("bay"), "peaceful", MINUTE)
    return {"peaceful": peaceful, "schooling": channel[3]}


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
    assert budgets["fusilier"]["school"] > 0.3
    assert sum(budget["eat"] for budget in budgets.values()) > 0.05
    assert studied["peaceful"]["food"]["meals"] > 0


def test_a_school_is_polarised_and_evenly_spaced_while_it_cruises(studied, channel):
    """A school of the channel feeds in disorder for half a minute with one seed, not with all."""
    schools = [found["schools"][0] for found in channel.values()]
    assert all(school["cruising_share"] > 0.9 for school in schools)
    orders = [school["polarisation_median"] for school in schools]
    for order in (*_each(studied["peaceful"]["schools"], "polarisation_median"), median(orders)):
        assert 0.6 <= order <= 0.97  # free schools, not parades
    for nearest in _each([*studied["peaceful"]["schools"], *schools], "nearest_bl"):
        assert 0.6 <= nearest["p50"] <= 1.6


def _each(schools, name):
    return [school[name] for school in schools]


def test_a_school_passes_pillars_and_is_together_again(channel):
    """Without a leader it passes on one side or on both: in some bays it splits, in others not."""
    _, longest = load_measured().schools.split.range
    parted = 0
    for found in channel.values():
        sea, (school,) = found["sea"], found["schools"]
        assert sea["least_clearance_from"] == "pillar"
        assert 0.0 < sea["least_clearance_cm"] < 60.0  # it meets one, and no fish touches it
        assert sea["out_of_bounds_or_inside"] == 0
        for split in school["each_split"]:
            assert split["rejoined"] and split["lasted_s"] <= longest
        parted += any(split["apart_share"] >= 0.1 for split in school["each_split"])
    assert 0 < parted < 4
