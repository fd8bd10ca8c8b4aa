"""Measures of a program: of the arrays of a record, checked, and in the table of a sweep."""

from functools import partial

import numpy as np
import pytest

import subsea
from subsea.lab.own_measures import own_measures
from tests.support.scenes import BARE


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    path = tmp_path_factory.mktemp("own") / "run.h5"
    return subsea.open_record(subsea.simulate(str(BARE), path, seconds=0.2, seed=3, fish=4))


def deepest_cm(position, deeper=0.0):
    return deeper - position[..., 2].min()


def spans(record):
    return {"Ticks": len(record.time), "seconds": np.float32(record.tick_s), "none": None}


def test_they_see_the_arrays_of_a_record(record):
    found = subsea.measure(record, [deepest_cm, spans])
    assert found["own"]["deepest_cm"] == pytest.approx(-record.position[..., 2].min())
    assert found["own"]["spans"] == {"Ticks": 6.0, "seconds": pytest.approx(0.033), "none": None}
    assert subsea.measure(record, [partial(deepest_cm, deeper=1e6)])["own"]["deepest_cm"] > 1e5
    assert "own" not in subsea.measure(record)


def test_no_number_is_nothing_to_measure(record):
    def nothing(tick_s):
        return float("nan")

    assert subsea.measure(record, [nothing])["own"] == {"nothing": None}


def raises(position):
    raise ValueError("two\nlines")


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda positon: 1.0, "unknown parameter 'positon'; did you mean 'position'"),
        (lambda position: position, "expected a finite number"),
        (lambda tick_s: np.inf, "returned inf, expected a finite number"),
        (lambda tick_s: "5", "returned 5, expected a finite number"),
        (raises, r"measure raises: raised ValueError: two lines \(line \d+ of raises\)"),
    ],
)
def test_a_faulty_measure_is_one_line(record, function, words):
    with pytest.raises(subsea.UserError, match=words) as fault:
        subsea.measure(record, [function])
    assert "\n" not in str(fault.value)


def test_two_of_one_name_and_what_is_none_are_refused():
    with pytest.raises(subsea.UserError, match="two functions are named deepest_cm"):
        own_measures([deepest_cm, partial(deepest_cm, deeper=1.0)])
    with pytest.raises(TypeError, match="expected functions"):
        own_measures([3.0])
