import math
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from subsea.biomechanics.body_plan import BodyPlan, SwimPlan, TurnPlan
from subsea.fish.species import load_species, muscular_names

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("tail_half_height", 0.0, "> 0.0"),
        ("tail_half_height", 15.0, "tail_half_height = 15; expected"),
        ("half_widths", [0.4, 0.9, 1e-3, 0.8, 0.7], r"half_widths\[2\] = 0.001; expected"),
        ("half_heights", [0.5, 1.1, 30.0, 1.4, 1.2], r"half_heights\[2\] = 30; expected"),
        ("half_heights", [0.5, 1.1, math.inf, 1.4, 1.2], "= inf; expected"),
        ("half_heights", [0.5, 1.1, math.nan, 1.4, 1.2], "> 0.0"),
        ("stations", [0, 2.1, 2.2, 10.6, 14.4, 17.5, 20.5], r"stations\[2\] is 0.1 cm behind"),
        ("stations", [0, 10, 20, 30, 40, 50, 200], r"stations\[6\] = 200; expected 10 to 40 cm"),
        ("masses", [1.0] * 6, "length 7"),
        ("masses", [1.1, 6.6, 250_000.0, 6.6, 1.1, 1.1, 0.2], "sum of masses = 1.00006e"),
        ("masses", [1e-3] * 7, "sum of masses = 0.023; expected"),
        ("viscosity", -1.0, "> 0.0"),
        ("muscle_stiffness", math.inf, "<= 100000"),
        ("stations", [0, 2.1, math.nan, 10.6, 14.4, 17.5, 20.5], "increase"),
        ("colour", 1, "unknown field"),
        ("stations", [1, 2, 3, 4, 5, 6, 7], "increase from nose to tail"),
        ("stations", [0, 2, 2, 4, 5, 6, 7], "increase from nose to tail"),
        ("stations", [0, 2, 3, 4, 6, 5, 7], "increase from nose to tail"),
    ],
)
def test_impossible_bodies_are_refused(fusilier, key, value, words):
    with pytest.raises(msgspec.ValidationError, match=words):
        msgspec.convert(msgspec.to_builtins(fusilier.body) | {key: value}, BodyPlan)


def test_impossible_controllers_are_refused(fusilier):
    swim, turn = msgspec.to_builtins(fusilier.swim), msgspec.to_builtins(fusilier.turn)
    steering = turn["steering"]
    changes: list[tuple[type, dict[str, Any], str]] = [
        (SwimPlan, swim | {"contraction": [0.7, 0.4]}, "contraction"),
        (SwimPlan, swim | {"slow": 1.2}, "slow"),
        (SwimPlan, swim | {"slow": 0.6}, "less than medium"),
        (SwimPlan, swim | {"ticks_per_beat": 2}, "ticks_per_beat"),
        (SwimPlan, swim | {"burst": 1.2}, "over 0.6"),
        (SwimPlan, swim | {"burst_ticks": 12}, "needs burst"),
        (SwimPlan, swim | {"burst_lag": 1.2}, "burst_lag needs burst"),
        (SwimPlan, swim | {"burst": 1.0, "burst_contraction": [0.1, 0.7]}, "contraction"),
        (SwimPlan, swim | {"slow_lag": 4.0}, "slow_lag"),
        (TurnPlan, turn | {"steering": steering[::-1]}, "must increase"),
        (TurnPlan, turn | {"sharp": 80.0, "steering": steering[:3]}, "ends at 60 degrees"),
    ]
    for kind, table, words in changes:
        with pytest.raises(msgspec.ValidationError, match=words):
            msgspec.convert(table, kind)


def test_mass_and_volume_of_a_box_with_pyramids_at_its_ends(fusilier):
    box = msgspec.structs.replace(
        fusilier.body,
        stations=(0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0),
        half_widths=(1.0,) * 5,
        half_heights=(2.0,) * 5,
        masses=(1.0,) + (4.0,) * 5 + (2.0,),
    )
    assert box.length == 18.0
    assert box.hull_volume == pytest.approx(8 * (12 + 1.5 + 1.5))
    assert box.mass == 1 + 20 * 4 + 4


def test_each_grade_has_its_own_beat(fusilier):
    old = fusilier.swim
    assert old.grades == ("slow", "medium", "fast")
    assert all(old.at(grade) is old for grade in old.grades)
    graded = msgspec.structs.replace(old, slow=0.9, medium=0.8, slow_ticks=30, burst=1.1)
    assert [graded.at(grade).ticks_per_beat for grade in graded.grades] == [30, 14, 14, 14]
    assert [graded.amplitude(grade) for grade in graded.grades] == [0.9, 0.8, 1.0, 1.1]
    own = msgspec.structs.replace(
        graded, slow_contraction=(0.1, 0.5), slow_lag=2.0, burst_contraction=(0.2, 0.3)
    )
    slow, burst = own.at("slow"), own.at("burst")
    assert (slow.contraction, slow.lag, slow.ticks_per_beat) == ((0.1, 0.5), 2.0, 30)
    assert (burst.contraction, burst.lag) == ((0.2, 0.3), old.lag)
    assert own.at("fast") is own and own.at("medium").contraction == old.contraction
    # Old files have no new keys, and written plans are read again.
    assert not {"burst", "slow_ticks"} & msgspec.to_builtins(old).keys()
    assert msgspec.convert(msgspec.to_builtins(graded), SwimPlan) == graded


def test_the_page_tells_how_shipped_bodies_depart_from_tu():
    """Stiffness order and masses (Tu tables 4.1 and 4.2), and lags (Tu §4.6.1)."""
    plans = [load_species(name).muscles for name in muscular_names()]
    bodies = [plan.body for plan in plans]
    stiff = np.array([(b.muscle_stiffness, b.cross_stiffness, b.other_stiffness) for b in bodies])
    lags = [plan.swim.at(grade).lag for plan in plans for grade in plan.swim.grades]
    masses = np.array([body.masses for body in bodies])
    heaviest, count = masses[:, 1:6].argmax(axis=1), len(plans)
    page = (ROOT / "docs/concepts/biomechanics.md").read_text(encoding="utf-8")
    for line in (
        f"muscles are the softest in {(stiff.argmin(axis=1) == 0).sum()} of {count} species, "
        f"cross units the stiffest in {(stiff.argmax(axis=1) == 1).sum()}",
        f"{min(lags):.2f} to {max(lags):.2f} by species and grade",
        f"the second or third ring in {np.isin(heaviest, (1, 2)).sum()} of {count} species",
        f"the nose is lighter than the heaviest ring in "
        f"{(masses[:, 0] < masses[:, 1:6].max(axis=1)).sum()} of {count} species, "
        f"the tail in {(masses[:, 6] < masses[:, 1:6].max(axis=1)).sum()}",
    ):
        assert line in page, line
