"""Intentions and fear last in the sea: measures of docs/fear_figures.py on an attack."""

from importlib.util import module_from_spec, spec_from_file_location

import numpy as np
import pytest

from subsea.base.system import ROOT
from subsea.state import AVOID, ESCAPE, SCHOOL, WANDER


@pytest.fixture(scope="module")
def figures():
    spec = spec_from_file_location("fear_figures", ROOT / "docs/fear_figures.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_measures_against_a_record_made_by_hand(figures):
    """One fish that is afraid from the 10th to the 70th tick and sees the threat until the 40th."""
    ticks = 100
    intention = np.full((ticks, 1), WANDER)
    intention[5:8], intention[10:50], intention[50:55], intention[55:60] = (
        SCHOOL, ESCAPE, SCHOOL, AVOID,
    )  # fmt: skip
    fear = np.zeros((ticks, 1))
    fear[10:70] = 0.9
    sees = np.zeros((ticks, 1), bool)
    sees[10:40] = True
    alive, still = np.ones((ticks, 1), bool), np.zeros((ticks, 1, 3))
    seen = figures.Watched(
        intention, fear, sees, alive, still, still, np.full((ticks, 1), np.inf), np.ones(1),
        np.ones(1, bool), -1, np.ones(1, bool), 0.5,
    )  # fmt: skip
    found = figures.figures(seen)
    # School for 3 ticks, wander for 2 until danger, escape for 40, school for 5 until a collision,
    # avoid for 5.
    assert found["bouts"] == 5
    assert found["short"] == pytest.approx(2 / 3, abs=1e-3)
    assert found["short_all"] == pytest.approx(4 / 5)
    assert found["flips"] == pytest.approx(2 / (99 * figures.TICK_S / 60), abs=0.01)
    assert found["lasts_s"] == [pytest.approx(30 * figures.TICK_S, abs=0.05)] * 3


def test_prey_see_their_flight_through_and_stay_afraid(figures):
    found = figures.figures(figures.watch("strike", 6, 20.0))
    assert found["bouts"] > 40
    assert found["short"] < 0.05
    # One alarm in these 20 s is 6 a minute, its beginning and its end; without memory it was 55.
    assert found["flips"] < 6.0
    assert found["starts"] > 5  # a hunter rushes once and rests
    assert found["flight_bl_s"] > 6.0
