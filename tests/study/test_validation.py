"""The runs of a validation, their measures and their findings."""

import json

import numpy as np
import pytest

from subsea.cli.main import main
from subsea.core import workers
from subsea.core.errors import UserError
from subsea.core.findings import FAIL, MISSING, PASS
from subsea.core.workers import serial
from subsea.fish.measured import load_measured
from subsea.scenario.load import load_scenario
from subsea.study.bounds import Outside
from subsea.study.predation import Predation
from subsea.study.schooling import BEARINGS, Schooling
from subsea.study.swimming import Swimming
from subsea.study.validation import (
    GROUP_SIZES,
    SCHOOL_SIZES,
    SeaMeasures,
    SeaTrial,
    Validation,
    default_scenarios,
    one_group,
    run_trials,
    trials,
)
from subsea.study.validation_files import ValidationFiles, seed_words, validate
from subsea.study.validation_report import findings, summarise
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
    chosen, _ = load_scenario("preying", one_group("preying", size))
    assert sorted(shoal.number for shoal in chosen.fish if shoal.number) == sorted([1, size])


def some(**changed):
    """Samples of a fish that swims as a fusilier should."""
    values = {
        "strouhal": 0.3, "frequency": 5.0, "amplitude": 0.2, "stride": 0.7, "speed": 2.0,
        "hasty": 9.0, "radius": 0.2,
    } | changed  # fmt: skip
    return Swimming(
        **{name: np.full(10, value) for name, value in values.items()},
        pitched=(1.0, 100.0), straight=(0.5, 100.0), idle=(0.0, 10.0), hovering=(0.0, 10.0),
        longest_hover_s=0.0,
    )  # fmt: skip


def a_school(**changed):
    values = {
        "leader": 0, "fishes": 10, "polarisation": 0.95, "nearest_bl": 0.8, "height_bl": 0.1,
        "room_bl3": 1.0, "ahead_bl": 0.3, "bearing": np.full(BEARINGS, 1 / BEARINGS),
        "split_s": np.array([3.0]),
    }  # fmt: skip
    return Schooling(**values | changed)


def done(swims=None, school=None, beyond=0, catches=(2.0,)):
    trial = SeaTrial("sea", "preying", 1, 100)
    outside = [Outside("Fish", 1000, beyond, 4.0, "seabed", 1.0)]
    measures = SeaMeasures(
        {"fusilier": swims or some()}, [school or a_school()], outside,
        Predation(3, 2, list(catches)),
    )  # fmt: skip
    hunts = [
        (trial._replace(label=f"on {size}", hunt=True, size=size),
         SeaMeasures({}, [], [], Predation(attacks, captures, [])))
        for size, attacks, captures in ((1, 4, 4), (20, 10, 2))
    ]  # fmt: skip
    return [(trial, measures), *hunts]


def failures(rows):
    return {one.quantity for one in rows if one.verdict not in (PASS, "–")}


def test_a_sea_like_nature_passes():
    assert failures(findings(done(), load_measured())) == set()


@pytest.mark.parametrize(
    ("given", "failed"),
    [
        ({"swims": some(strouhal=0.6)}, {"Strouhal number"}),
        ({"swims": some()._replace(straight=(5.0, 10.0))},
         {"change of heading in straight segments"}),
        ({"swims": some(radius=1.5)}, {"turning radius at low speed, tightest tenth"}),
        ({"school": a_school(polarisation=0.7)}, {"polarisation"}),
        ({"school": a_school(split_s=np.array([3.0, 20.0]))}, {"longest split"}),
        ({"school": a_school(height_bl=0.7)}, {"elevation of the nearest"}),
        ({"beyond": 3}, {"fish-ticks out of bounds or in solids"}),
        ({"catches": (0.0, 1.0)}, {"catches of a predator in 3 min, mean"}),
        ({"catches": (0.0, 5.0)}, {"catches of a predator in 3 min, most"}),
    ],
)  # fmt: skip
def test_each_measure_can_fail(given, failed):
    assert failures(findings(done(**given), load_measured())) == failed


def test_confusion_is_the_ratio_of_capture_rates():
    rows = {one.quantity: one for one in findings(done(), load_measured())}
    assert rows["captures per attack on 20 over 1"].value == pytest.approx(0.2)
    assert summarise(done()).hunts == {1: (4, 4), 20: (10, 2)}


def test_measures_without_samples_are_not_recorded():
    rows = findings(done(swims=some()._replace(hasty=np.zeros(0))), load_measured())
    (row,) = [one for one in rows if one.verdict == MISSING]
    assert row.quantity == "speed in flights and hunts, 99%"


def test_crashed_runs_are_an_error_after_the_files_are_written(tmp_path, capsys):
    jobs = [SeaTrial("sea", "preying", seed, 100) for seed in (1, 2)]
    (_, measures), *_ = done(beyond=1)

    def pool(work, given, check):
        yield from ((k, measures if k else None) for k in given)

    files = ValidationFiles(tmp_path / "a.json", tmp_path / "a.md", tmp_path / "plots")
    files.check("me", force=False)
    with pytest.raises(UserError, match="without 1 run whose process crashed \\(sea, seed 1\\)"):
        validate(jobs, files, "me", pool, lambda: None)
    report = json.loads(files.json.read_text())
    assert report["seeds"] == [2]
    assert sum(row["verdict"] == FAIL for row in report["findings"]) == 1
    assert "Seeds 2, 3 s each." in files.page.read_text()
    assert len([*files.plots.iterdir()]) == 3
    assert "FAILS" in capsys.readouterr().out


def test_seeds_in_words():
    assert [seed_words(one) for one in ([1, 2, 3], [1, 3], [])] == ["1 to 3", "1, 3", "none"]


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
