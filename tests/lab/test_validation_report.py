"""Findings of seas: each measure passes in nature's range and fails outside."""

import numpy as np
import pytest

from subsea.base.findings import MISSING, PASS
from subsea.fish.measured import load_measured
from subsea.lab.measures import PERIOD_S, Outside, Predation
from subsea.lab.schooling import BEARINGS, Schooling
from subsea.lab.swimming import Swimming
from subsea.lab.validation import SeaMeasures, SeaTrial
from subsea.lab.validation_report import findings, summarise


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
    }  # fmt: skip
    return Schooling(**values | in_parts(3.0) | changed)


def in_parts(*seconds):
    """Samples of a school that was split for the given times, with 10 s between them."""
    time = np.arange(0.0, 100.0, 0.5)
    together, start = np.ones(len(time)), 10.0
    for duration in seconds:
        together[(time >= start) & (time < start + duration)] = 0.5
        start += duration + 10.0
    return {"time": time, "together": together, "calm": time < 15.0, "end": 100.0}


def done(swims=None, school=None, beyond=0, catches=(2.0,)):
    trial = SeaTrial("sea", "preying", 1, 100)
    outside = [Outside("Fish", 1000, beyond, 4.0, "seabed", 1.0)]
    measures = SeaMeasures(
        {"fusilier": swims or some()}, [school or a_school()], outside,
        Predation(3, 2, list(catches), PERIOD_S),
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
        ({"swims": some()._replace(straight=(5.0, 10.0))},
         {"change of heading in straight segments"}),
        ({"swims": some(radius=1.5)}, {"turning radius at low speed, tightest hundredth"}),
        ({"school": a_school(polarisation=0.7)}, {"polarisation"}),
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


def test_confusion_is_the_ratio_of_capture_rates():
    rows = {one.quantity: one for one in findings(done(), load_measured())}
    assert rows["captures per attack on 20 over 1"].value == pytest.approx(0.2)
    assert summarise(done()).hunts == {1: (4, 4), 20: (10, 2)}


def test_measures_without_samples_are_not_recorded():
    rows = findings(done(swims=some()._replace(hasty=np.zeros(0))), load_measured())
    (row,) = [one for one in rows if one.verdict == MISSING]
    assert row.quantity == "speed in flights and hunts, 99%"
