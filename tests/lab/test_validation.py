"""Validation: its runs, findings and files."""

import json

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.base.findings import FAIL, MISSING, NO_RANGE, PASS
from subsea.base.report_files import ReportFiles
from subsea.cli.main import main
from subsea.fish.measured import load_measured
from subsea.jobs import workers
from subsea.jobs.workers import serial
from subsea.lab.measures import PERIOD_S, Outside, Predation
from subsea.lab.mind_findings import budget_lines, budgets, mind_findings
from subsea.lab.minds import Bouts, Fear, MindMeasures
from subsea.lab.rhythm import Rhythm
from subsea.lab.schooling import ABREAST, BEARINGS, SECTORS, Schooling
from subsea.lab.swimming import Swimming
from subsea.lab.validation import (
    GROUP_SIZES,
    SCHOOL_SIZES,
    VALIDATION_PLOTS,
    SeaMeasures,
    SeaTrial,
    default_scenarios,
    findings,
    imposed_courtship,
    one_group,
    run_trials,
    seed_words,
    summarise,
    trials,
    validate,
)
from subsea.lab.whereabouts import Whereabouts
from subsea.scenario.load import load_scenario
from subsea.world.build import create_world
from subsea.world.world import TICK_S
from tests.support.scenes import BARE


def test_trials_are_scenarios_schools_and_groups():
    found = [*trials(["schooling", "preying", "open-ocean"], (1, 2), 10)]
    labels = [one.label for one in found]
    assert len(found) == 2 * (3 + len(SCHOOL_SIZES) + len(GROUP_SIZES))
    assert "open-ocean of 3000 fishes" in labels and "schooling of 144" in labels
    assert {one.size for one in found if one.hunt} == set(GROUP_SIZES)
    longer = [one.label for one in trials(["schooling", "preying"], (1,), 10, 30) if one.ticks > 10]
    assert longer == ["preying"]
    assert len(default_scenarios()) >= 8
    with pytest.raises(UserError, match="'preying'"):
        [*trials(["preyin"], (1,), 10)]


@pytest.mark.parametrize("size", GROUP_SIZES)
def test_a_group_leaves_the_predators_and_one_shoal_of_prey(size):
    chosen = load_scenario("preying", one_group("preying", size)).scenario
    assert sorted(shoal.number for shoal in chosen.fish if shoal.number) == sorted([1, size])


def test_a_small_sea_is_measured(tmp_path, capsys, monkeypatch):
    trial = SeaTrial("bare", str(BARE), 1, 90)
    ((_, found),), crashed = run_trials([trial], serial)
    assert not crashed and found.swims and found.places
    spent = sum(sum(one.values()) for one in found.minds.budget.values())
    fishes = sum(shoal.number for shoal in load_scenario(str(BARE))[0].fish)
    assert sum(one.fish_ticks for one in found.outside) == 90 * fishes
    assert spent == pytest.approx(90 * fishes * TICK_S)
    page = tmp_path / "page.md"
    monkeypatch.setattr(workers, "process_pool", lambda number: serial)
    words = ["study", "--validate", str(BARE), "--seeds", "1", "--seconds", "1", "--jobs", "1"]
    assert main([*words, "--report", str(page)]) == 0
    assert "bare_sea" in page.read_text() and "out of bounds" in capsys.readouterr().out
    assert "Time budgets" in page.read_text()


def some(into=(97.0, 100.0), **changed):
    """Samples of a fish that swims as a fusilier should."""
    values = {
        "strouhal": 0.3, "frequency": 5.0, "amplitude": 0.2, "stride": 0.7, "speed": 2.0,
        "hasty": 9.0, "radius": 0.2, "snout_over_tail": 0.15, "yaw": 4.0, "roll": 0.5,
        "acceleration": 8.0,
    } | changed  # fmt: skip
    return Swimming(
        **{name: np.full(10, value) for name, value in values.items()},
        pitched=(1.0, 100.0), straight=(0.5, 100.0), idle=(0.0, 10.0), hovering=(0.0, 10.0),
        longest_hover_s=0.0, into=into,
    )  # fmt: skip


EVEN = np.full(SECTORS, 1 / SECTORS)


def a_school(**changed):
    values = {
        "leader": 0, "fishes": 10, "polarisation": 0.85, "disorder": 0.1, "rotation": 0.2,
        "states": np.array([0.8, 0.0, 0.1]), "nearest_bl": 0.8, "near_bl": 0.6, "height_bl": 0.1,
        "room_bl3": 1.0, "ahead_bl": 0.3, "longer": 1.5, "flatter": 3.0,
        "bearing": np.full(BEARINGS, 1 / BEARINGS), "sector": EVEN,
        "rhythm": Rhythm(0.4, 0.1, 0.2),
    }  # fmt: skip
    return Schooling(**values | in_parts(3.0) | changed)


def a_mind(short=1, lasted=10.0, flips=6, hour=12, spent=None):
    """Minds of a species with a hunter: 100 bouts, half of them ended by a danger."""
    counts = [np.array([0, number]) for number in (100, 50, 50, short)]
    budget = {
        ("Fish", hour): spent or {"wander": 60.0, "eat": 30.0, "avoid": 5.0, "mate": 3.0},
        ("Shark", hour): {"wander": 100.0},
    }
    fear = Fear(flips, 2.0, np.full(5, lasted), np.ones(5, bool))
    return MindMeasures(("avoid", "wander"), Bouts(*counts), fear, budget, frozenset({"Shark"}))


def in_parts(*seconds):
    """Samples of a school that was split for the given times, with 10 s between them."""
    time = np.arange(0.0, 100.0, 0.5)
    together, start = np.ones(len(time)), 10.0
    for duration in seconds:
        together[(time >= start) & (time < start + duration)] = 0.5
        start += duration + 10.0
    return {"time": time, "together": together, "calm": time < 15.0, "end": 100.0}


def a_place(height=0.7, shallow=0.0):
    return Whereabouts(np.full(10, height), (shallow, 10.0))


def done(swims=None, school=None, beyond=0, catches=(2.0,), mind=None, ray=None):
    trial = SeaTrial("sea", "preying", 1, 100)
    outside = [Outside("Fish", 1000, beyond, 4.0, "seabed", 1.0)]
    measures = SeaMeasures(
        {"fusilier": swims or some()}, [school or a_school()], outside,
        Predation(3, 2, list(catches), PERIOD_S), mind or a_mind(),
        {"spotted_eagle_ray": ray or a_place(), "fusilier": a_place(20.0, 5.0)},
    )  # fmt: skip
    hunts = [
        (trial._replace(label=f"on {size}", hunt=True, size=size),
         SeaMeasures({}, [], [], Predation(attacks, captures, [], PERIOD_S)))
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
        ({"swims": some(snout_over_tail=0.7)}, {"snout over tail"}),
        ({"swims": some(yaw=30.0, roll=7.0)}, {"yaw of the head", "roll, 90%"}),
        ({"swims": some(into=(45.0, 100.0))}, {"bent into the turn"}),
        ({"swims": some(acceleration=72.0)}, {"acceleration, 99%"}),
        ({"swims": some()._replace(straight=(5.0, 10.0))},
         {"change of heading in straight segments"}),
        ({"swims": some(radius=1.5)}, {"turning radius at low speed, tightest hundredth"}),
        ({"school": a_school(polarisation=0.5)}, {"polarisation"}),
        ({"school": a_school(polarisation=0.99)}, {"polarisation"}),
        ({"school": a_school(disorder=0.5)}, {"time with a polarisation below 0.5"}),
        ({"school": a_school(near_bl=0.4)}, {"nearest neighbour, 5%"}),
        ({"school": a_school(sector=np.where(np.isin(np.arange(SECTORS), ABREAST), 0.5, 0.01))},
         {"nearest at 45° and 135° over that at 90°"}),
        ({"school": a_school(longer=0.8)}, {"length over width"}),
        ({"school": a_school(flatter=0.9)}, {"length over height"}),
        ({"school": a_school(rhythm=Rhythm(0.1, 0.0, 0.01))},
         {"variation of a fish's speed", "time below half of the own median speed",
          "time gliding"}),
        ({"mind": a_mind(short=5)}, {"bouts below 0.5 s that no danger ends"}),
        ({"mind": a_mind(lasted=1.0)}, {"alarm after the last sight of a predator"}),
        ({"mind": a_mind(flips=60)}, {"passages through alarm of a prey in a minute"}),
        ({"mind": a_mind(spent={"mate": 50.0, "wander": 50.0})},
         {"time feeding", "time courting by day"}),
        ({"mind": a_mind(spent={"avoid": 30.0, "graze": 30.0, "pick": 5.0, "wander": 35.0})},
         {"time avoiding"}),
        ({"mind": a_mind(spent={"eat": 90.0, "wander": 10.0})}, {"time feeding"}),
        ({"ray": a_place(height=3.0)}, {"height over the ground"}),
        ({"ray": a_place(shallow=2.0)}, {"time near the surface"}),
        ({"school": a_school(**in_parts(3.0, 20.0))}, {"longest split"}),
        ({"school": a_school(**in_parts(3.0, 20.0) | {"calm": np.full(200, True)})},
         {"longest split", "longest split without alarm"}),
        ({"school": a_school(height_bl=0.7)}, {"elevation of the nearest"}),
        ({"beyond": 3}, {"fish-ticks out of bounds or in solids"}),
        ({"catches": (0.0, 1.0)}, {"catches of a predator in 3 min, mean"}),
        ({"catches": (0.0, 5.0)}, {"catches of a predator in 3 min, most"}),
    ],
)  # fmt: skip
def test_each_measure_can_fail(given, failed):
    assert failures(findings(done(**given), load_measured())) == failed


def test_courting_counts_by_day_only():
    spent = {"mate": 70.0, "eat": 30.0}
    quantities = [{one.quantity for one in findings(done(mind=a_mind(hour=hour, spent=spent)),
                                                    load_measured())}
                  for hour in (6, 7, 15, 16, 17)]  # fmt: skip
    name = "time courting by day"
    assert [name in found for found in quantities] == [False, True, True, False, False]


def test_imposed_courtship_is_only_listed():
    """The pair of the rendezvous courts in the morning because the scene says so."""
    mind = a_mind(spent={"mate": 70.0, "eat": 30.0})
    for courts, verdict in ((frozenset(), FAIL), (frozenset({"Fish"}), NO_RANGE)):
        rows = findings(done(mind=mind._replace(courts=courts)), load_measured())
        (row,) = [one for one in rows if one.quantity.startswith("time courting")]
        assert row.verdict == verdict


def test_hunters_and_moments_have_no_time_to_feed():
    for mind in (a_mind(), a_mind(spent={"wander": 59.0})):
        rows = findings(done(mind=mind), load_measured())
        fed = [one.subject for one in rows if one.quantity == "time feeding"]
        assert fed == (["sea: Fish"] if mind.budget["Fish", 12].get("eat") else [])


def test_budgets_have_a_row_for_each_scenario_species_and_hour():
    found = {"sea": a_mind(hour=7, spent={"eat": 30.0, "dance": 70.0}), "bay": a_mind()}
    rows = budgets(found)
    where = [(one["scenario"], one["species"], one["hour"]) for one in rows]
    assert where == [("sea", "Fish", 7), ("sea", "Shark", 7), ("bay", "Fish", 12),
                     ("bay", "Shark", 12)]  # fmt: skip
    assert (rows[0]["feeding"], rows[0]["dance"]) == (0.3, 0.7)
    lines = budget_lines(found)
    assert lines[2].startswith("| scenario | species | hour | fish-minutes | feeding |")
    assert len({line.count("|") for line in lines[2:]}) == 1
    assert "| sea | Fish | 7 | 2 | 30% |" in lines[4]
    assert budget_lines({}) == []


def test_confusion_is_the_ratio_of_capture_rates():
    rows = {one.quantity: one for one in findings(done(), load_measured())}
    assert rows["captures per attack on 20 over 1"].value == pytest.approx(0.2)
    assert summarise(done()).hunts == {1: (4, 4), 20: (10, 2)}


def test_measures_without_samples_are_not_recorded():
    rows = findings(done(swims=some()._replace(hasty=np.zeros(0))), load_measured())
    (row,) = [one for one in rows if one.verdict == MISSING]
    assert row.quantity == "speed in flights and hunts, 99%"


SCHOOL = a_school(time=np.zeros(0), together=np.zeros(0), calm=np.zeros(0, bool), end=0.0)
MEASURES = SeaMeasures(
    {}, [SCHOOL], [Outside("Fish", 1000, 1, 4.0, "seabed", 1.0)], Predation(3, 2, [2], 180.0)
)


def test_crashed_runs_are_an_error_after_the_files_are_written(tmp_path, capsys):
    jobs = [SeaTrial("sea", "preying", seed, 100) for seed in (1, 2)]

    def pool(work, given, check):
        yield from ((k, MEASURES if k else None) for k in given)

    files = ReportFiles("subsea me", tmp_path / "a.json", tmp_path / "a.md", tmp_path / "plots")
    files.check(VALIDATION_PLOTS, force=False)
    with pytest.raises(UserError, match="without 1 run whose process crashed \\(sea, seed 1\\)"):
        validate(jobs, files, pool, lambda: None)
    report = json.loads(files.json.read_text())
    assert report["seeds"] == [2]
    assert sum(row["verdict"] == FAIL for row in report["findings"]) == 1
    assert report["time_budgets"] == []
    assert "Seeds 2, 3 s each." in files.page.read_text()
    assert {path.name for path in files.plots.iterdir()} == set(VALIDATION_PLOTS)
    assert "FAILS" in capsys.readouterr().out


def test_seeds_in_words():
    assert [seed_words(one) for one in ([1, 2, 3], [1, 3], [])] == ["1 to 3", "1, 3", "none"]


def test_imposed_courtship_has_no_range():
    spent = {"wander": 30.0, "eat": 1.0, "mate": 60.0}

    def verdicts(**changed):
        mind = a_mind(spent=spent)._replace(**changed)
        rows = mind_findings("sea", mind, load_measured())
        return {row.quantity: row.verdict for row in rows if row.subject == "sea: Fish"}

    free = verdicts()
    assert (free["time feeding"], free["time courting by day"]) == (FAIL, FAIL)
    imposed = verdicts(courts=frozenset({"Fish"}))
    assert (imposed["time feeding"], imposed["time courting"]) == (NO_RANGE, NO_RANGE)
    assert "time courting by day" not in imposed


def test_a_key_of_the_scenario_imposes_courtship():
    world = create_world(load_scenario("rendezvous")[0])
    assert imposed_courtship(world) == {"Emperor angelfish"}
