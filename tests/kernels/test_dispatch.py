"""Calls of kernels from Python."""

import pickle
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.kernels import kernel
from subsea.kernels.dispatch import MOST_KEPT, traits
from subsea.state import Fishes, empty


@kernel
def _halved(value):
    """A sum divided by two, whatever holds the numbers."""
    total = value[0] * 0
    for k in range(len(value)):
        total += value[k]
    return total // 2


@kernel
def _next(value):
    return value + 1


@kernel
def _powers(base, exponent=2):
    return base**exponent


class _Two(NamedTuple):
    first: int
    second: int


class _Pair(NamedTuple):
    first: int
    second: int


WIDE = np.arange(8)
LOCKED = np.arange(5, 9)
LOCKED.flags.writeable = False
VALUES = (
    WIDE, WIDE[::2], WIDE.astype(np.int32), WIDE.astype(np.float32), 0.5 * WIDE, LOCKED,
    (1, 2), (1.0, 2.5), _Two(3, 4), _Pair(3, 4), (np.float32(1.5), np.float32(2.0)), (7,),
)  # fmt: skip


@given(st.lists(st.sampled_from(range(len(VALUES))), min_size=1, max_size=20))
def test_each_call_has_the_code_of_its_types(numbers):
    for number in numbers:
        found, expected = _halved(VALUES[number]), _halved.py_func(VALUES[number])
        assert found == expected
        assert isinstance(found, int) == isinstance(expected, int | np.integer)


def test_plain_numbers_of_other_types_have_other_code():
    kinds = {type(value): type(_next(value)) for value in (1, 1.5, np.float32(1.5), True)}
    assert kinds == {int: int, float: float, np.float32: float, bool: int}
    assert [_next(value) for value in (1, 1.5, True, 2)] == [2, 2.5, 2, 3]


def test_a_second_call_does_not_ask_numba(monkeypatch):
    fishes = empty(Fishes, n=3)

    @kernel
    def living(fishes, factor):
        return factor * len(fishes.alive)

    assert living(fishes, 2) == 6
    monkeypatch.setattr(living, "_first", None)
    assert living(fishes, 2) == 6
    assert living(empty(Fishes, n=4), 5) == 20  # another group with arrays of the same types
    with pytest.raises(TypeError):
        living(fishes, 2.0)


def test_tuples_at_the_address_of_a_former_one_are_told_apart():
    for k in range(3 * MOST_KEPT):
        value = (k, k + 2) if k % 2 else (k + 0.5, k + 2.5)
        assert _halved(value) == k + 1
    others = (1, 2), (1.0, 2), (1, 2, 3), _Two(1, 2), _Pair(1, 2), (1, (2,)), ((1, 2),)
    assert len({traits((one,)) for one in others}) == len(others)


def test_numba_finds_the_types_of_what_has_no_traits():
    with pytest.raises(TypeError, match="str"):
        traits(("word",))

    @kernel
    def length(word):
        return len(word)

    assert [length(word) for word in ("sea", "reef", "sea")] == [3, 4, 3]


def test_arguments_may_be_left_out_or_named():
    assert [_powers(3), _powers(3, 3), _powers(base=2, exponent=5), _powers(4)] == [9, 27, 32, 16]
    for _ in range(2):
        with pytest.raises(TypeError):
            _powers()
        with pytest.raises(TypeError):
            _powers(1, 2, 3)


def test_errors_of_a_kernel_reach_its_caller():
    @kernel
    def refuse(value):
        if value > 1:
            raise ValueError("too much")
        return value

    assert refuse(1) == 1
    for _ in range(2):
        with pytest.raises(ValueError, match="too much"):
            refuse(2)


def test_a_kernel_can_be_pickled():
    assert pickle.loads(pickle.dumps(_next))(1) == 2
