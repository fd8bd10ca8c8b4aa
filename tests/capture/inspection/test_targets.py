"""Targets of a measure: what they hold, and how they read."""

import math

import pytest

from capture.inspection.targets import Measure, Range, at_least, at_most, compare, within


@pytest.mark.parametrize(
    ("target", "inside", "outside", "text"),
    [
        (at_least(0.35), [0.35, 9.0, math.inf], [0.349], "≥ 0.35 L"),
        (at_most(1e-3), [-1.0, 0.0, 1e-3], [1.1e-3], "≤ 1e-3 L"),
        (at_most(0.01), [0.01], [0.011], "≤ 0.01 L"),
        (at_most(2.5), [2.5], [2.6], "≤ 2.5 L"),
        (within(3), [-3.0, 0.0, 3.0], [-3.1, 3.1], "± 3 L"),
        (Range(0.15, 0.25), [0.15, 0.25], [0.14, 0.26], "0.15-0.25 L"),
    ],
)
def test_a_target_holds_its_ends_and_never_nan(target, inside, outside, text):
    assert target.holds(*inside)
    assert not any(target.holds(value) for value in [*outside, math.nan])
    assert not target.holds(*inside, outside[0])
    assert target.text(" L") == text


def test_a_line_judges_both_targets_by_all_its_values():
    assert compare("roll, pitch", (0.02, 0.3), ".3f", "°", at_most(1), at_most(0.1)) == Measure(
        "roll, pitch", "0.020°, 0.300°", "≤ 1°", True, "≤ 0.1°", False
    )
    assert compare("speed", 0.3, ".2f", " L", at_least(0.35)) == Measure(
        "speed", "0.30 L", "≥ 0.35 L", False, "", True
    )
