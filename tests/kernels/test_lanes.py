"""Each lane computes as a float does."""

import math

import numpy as np
import pytest

from subsea.kernels import kernel
from subsea.kernels.lanes import (
    LANES,
    any_positive,
    as_lanes,
    first,
    gather,
    room,
    take_lane,
    uncounted,
    where_positive,
    zero_of,
)

VALUES = np.array([1.5, -2.25, 0.0, -0.0, np.inf, -np.inf, np.nan, 1e-310])


@kernel
def compute(a, b, out):
    """Every operation on elements a, b (1,), into out (n,)."""
    x, y = a[0], b[0]
    total = zero_of(a)
    scratch = room((2, 2), a)
    scratch[1, 0] = 3
    for term in (x, y):
        total += term
    total -= 0.1
    out[0], out[1], out[2], out[3] = x + y, x - y, x * y, x / y
    out[4], out[5], out[6], out[7] = min(x, y), max(x, y), min(0.5, y), max(0.0, x)
    out[8], out[9], out[10], out[11] = math.sqrt(x), abs(x), -x, float(y)
    out[12], out[13] = math.cos(x), math.sin(y)
    out[14], out[15] = where_positive(x, y), total
    out[16], out[17], out[18] = 2 / x, x / 3, scratch[1, 0]
    out[19] = 1.0 if any_positive(x) else 0.0
    out[20] = first(y)


@kernel
def compute_in_lanes(a, b, out):
    compute(as_lanes(a), as_lanes(b), as_lanes(out))


@pytest.mark.filterwarnings("ignore:invalid value")
def test_operations_on_lanes_are_those_on_floats():
    common = (19, 20)  # of all lanes
    for shift in range(LANES):
        a, b = VALUES.copy(), np.roll(VALUES, shift)
        out = np.empty((21, LANES))
        compute_in_lanes(a[None], b[None], out)
        for k in range(LANES):
            expected = np.empty(21)
            compute(a[k : k + 1], b[k : k + 1], expected)
            for row in set(range(21)).difference(common):
                assert_same(out[row, k], expected[row])
        assert (out[19] == 1.0).all()
        assert_same(out[20, 3], b[0])


def assert_same(found, expected):
    """Assert the same bits, but for the payload of what is not a number."""
    assert (np.isnan(found) and np.isnan(expected)) or found.tobytes() == expected.tobytes()


def test_rows_are_gathered_into_lanes_and_taken_out():
    rows = np.random.default_rng(1).normal(size=(9, 2, 3)).astype(np.float32)
    who = np.array([8, 0, 5])
    lanes = gather(rows, who)
    assert lanes.shape == (2, 3, LANES) and lanes.dtype == np.float64
    row = np.empty((2, 3))
    for k in range(LANES):
        take_lane(lanes, k, row)
        np.testing.assert_array_equal(row, rows[who[min(k, 2)]])


@kernel
def write_uncounted(array):
    view = uncounted(array)
    view[1, 0] = 5.0


def test_an_uncounted_view_is_of_the_same_memory():
    array = np.zeros((2, 3))
    write_uncounted(array)
    assert array.sum() == array[1, 0] == 5.0


def test_outside_of_kernels_the_helpers_are_those_of_floats():
    like = np.zeros(2)
    assert where_positive(1.0, 3.0) == 3.0 and where_positive(0.0, 3.0) == 0.0
    assert any_positive(1.0) and not any_positive(-1.0)
    assert first(2.0) == 2.0 and zero_of(like) == 0.0 and room((2, 3), like).shape == (2, 3)
