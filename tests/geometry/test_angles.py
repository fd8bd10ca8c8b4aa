"""Sine, cosine and arc tangent of kernels."""

import math

import numpy as np
import pytest

from subsea.geometry.angles import arc_sine, arc_tangent, sine, sine_cosine, within_turn

ROUNDING = 4.0e-16  # of a number up to π
RANDOM = np.random.default_rng(3)


@pytest.mark.parametrize("most", [0.8, 7.0, 6000.0])
def test_sine_and_cosine_are_those_of_the_library(most):
    for angle in (0.0, -0.0, *(math.pi / 4 * np.arange(-9, 10)), *RANDOM.uniform(-most, most, 500)):
        assert sine_cosine(angle) == pytest.approx(
            (math.sin(angle), math.cos(angle)), rel=0, abs=ROUNDING
        )
        assert sine(angle) == pytest.approx(math.sin(angle), rel=0, abs=ROUNDING)


def test_arc_tangents_are_those_of_the_library():
    axes = [(y, x) for y in (-1.0, 0.0, 1e-300, 2.0) for x in (-1.0, 0.0, 1e-300, 2.0)]
    for y, x in (*axes, *RANDOM.normal(size=(500, 2)), *RANDOM.uniform(0.6, 0.7, (500, 2))):
        assert arc_tangent(y, x) == pytest.approx(math.atan2(y, x), rel=ROUNDING, abs=0)
    assert arc_tangent(np.float32(0.1), np.float32(0.3)) == math.atan2(
        np.float32(0.1), np.float32(0.3)
    )


def test_arc_sines_are_those_of_the_library_and_end_at_a_right_angle():
    for height in (-1.0, 0.0, 1.0, *RANDOM.uniform(-1.0, 1.0, 500)):
        assert arc_sine(height) == pytest.approx(math.asin(height), rel=2 * ROUNDING, abs=0)
    assert arc_sine(1.0 + 1e-9) == math.pi / 2


def test_an_angle_within_a_turn_is_its_remainder():
    turn = 2.0 * math.pi
    for angle in (0.0, -1e-20, turn, *RANDOM.uniform(-turn, 2.0 * turn, 500)):
        assert within_turn(angle) == angle % turn
    assert within_turn(9.5 * turn) == pytest.approx(0.5 * turn)
