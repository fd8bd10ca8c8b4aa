"""Portable float maps: what is written is read, and all else is refused in one line."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from subsea.base.errors import UserError
from subsea.stage.theatre.pixel_files import parse_pfm

GRIDS = st.tuples(st.integers(1, 6), st.integers(1, 6), st.sampled_from([1, 3])).flatmap(
    lambda shape: arrays(np.float32, shape, elements=st.floats(width=32))
)


@given(GRIDS, st.booleans())
def test_a_round_trip_keeps_every_bit_in_both_orders_of_bytes(making, numbers, little_endian):
    found = parse_pfm(making.compose_pfm(numbers, little_endian), "x")
    np.testing.assert_array_equal(found, numbers)


def test_the_lowest_row_is_the_first_in_a_file():
    data = b"Pf\n1 2\n-1.0\n" + np.array([1.0, 2.0], "<f4").tobytes()
    np.testing.assert_array_equal(parse_pfm(data, "x")[:, 0, 0], [2.0, 1.0])


def test_lines_may_end_in_crlf(making):
    numbers = np.ones((2, 2, 3), np.float32)
    data = making.compose_pfm(numbers).replace(b"\n", b"\r\n", 3)
    np.testing.assert_array_equal(parse_pfm(data, "x"), numbers)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "not a PFM file"),
        (b"P6\n2 2\n255\n", "not a PFM file"),
        (b"PF\n2\n-1.0\n" + bytes(48), "not a PFM file"),
        (b"PF\n0 2\n-1.0\n", "0×2 points in 0 bytes"),
        (b"PF\n99999 99999\n-1.0\n", "99999×99999 points in 0 bytes"),
        (b"PF\n2 2\n0.0\n" + bytes(48), "scale '0.0'"),
        (b"PF\n2 2\n1e999\n" + bytes(48), "scale '1e999'"),
        (b"PF\n2 2\n1.0.0\n" + bytes(48), "scale '1.0.0'"),
        (b"PF\n2 2\n-1.0\n" + bytes(47), "47 bytes of numbers, expected 48"),
        (b"PF\n2 2\n-1.0\n" + bytes(49), "49 bytes of numbers, expected 48"),
    ],
)
def test_errors_are_one_line(data, said):
    with pytest.raises(UserError, match=said) as caught:
        parse_pfm(data, "left.pfm")
    assert str(caught.value).startswith("left.pfm: ")


@given(st.binary(max_size=80), st.integers(0, 60))
def test_mangled_bytes_are_numbers_or_one_line(making, junk, at):
    whole = making.compose_pfm(np.zeros((2, 2, 3), np.float32))
    for data in (junk, whole[:at], whole[:at] + junk + whole[at + len(junk) :]):
        with suppress(UserError):
            assert parse_pfm(data, "x").ndim == 3
