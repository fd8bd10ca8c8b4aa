"""Named tuples that kernels take by pointer."""

import copy
import gc
import os
import pickle
import subprocess
import sys
import weakref
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit, typeof
from numba._dispatcher import compute_fingerprint

from subsea.kernels import struct_ref
from subsea.kernels.struct_ref import Kind, by_pointer
from subsea.state import Fishes, empty


class PairKind(Kind):
    """The compiler's type of a pair."""


@by_pointer(PairKind)
class Pair(NamedTuple):
    """An array and a number."""

    values: np.ndarray
    factor: float


@njit
def _scale(pair):
    for i in range(len(pair.values)):
        pair.values[i] *= pair.factor


def test_a_kernel_writes_into_the_arrays_of_the_tuple():
    pair = Pair(np.arange(3.0), 2.0)
    for _ in range(2):
        _scale(pair)
    np.testing.assert_array_equal(pair.values, [0, 4, 8])


def test_for_python_it_stays_a_named_tuple():
    pair = Pair(np.arange(3.0), 2.0)
    values, factor = pair
    assert values is pair.values
    assert pair._fields == ("values", "factor")
    other = pair._replace(values=np.ones(2), factor=5.0)
    assert isinstance(other, Pair)
    assert factor == 2.0
    # The other one has a pointer of its own.
    _scale(pair)
    _scale(other)
    np.testing.assert_array_equal(other.values, [5, 5])
    np.testing.assert_array_equal(pair.values, [0, 2, 4])


def test_a_call_asks_for_the_type_of_the_group_and_not_of_its_fields():
    pair = Pair(np.arange(3.0), 2.0)
    with pytest.raises(NotImplementedError, match="fingerprint"):
        compute_fingerprint(pair)


def test_its_arrays_outlive_other_groups():
    for n in (1, 50, 3):
        fishes = empty(Fishes, n=n)
        assert len(fishes.species) == n


def test_their_types_have_short_names_that_tell_them_apart():
    pairs = Pair(np.ones(2), 1.0), Pair(np.ones(3), 2.0), Pair(np.ones(2, np.float32), 1.0)
    same, too, other = (typeof(pair) for pair in pairs)
    assert same is too
    assert same != other
    assert len({same.name, other.name}) == 2
    assert max(map(len, (same.name, other.name))) < 40


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda pair: pickle.loads(pickle.dumps(pair))])
def test_a_copy_points_to_its_own_arrays(copied):
    pair = Pair(np.arange(3.0), 2.0)
    _scale(pair)
    other = copied(pair)
    assert isinstance(other, Pair)
    _scale(other)
    np.testing.assert_array_equal(pair.values, [0, 2, 4])
    np.testing.assert_array_equal(other.values, [0, 4, 8])


def test_an_interrupt_while_a_pointer_is_made_is_raised(monkeypatch):
    """Not a crash: Ctrl-C may come in the middle of a call."""
    pair = Pair(np.arange(3.0), 2.0)
    _scale(pair)
    other = pair._replace(factor=3.0)

    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(struct_ref, "_memory", interrupted)
    with pytest.raises(KeyboardInterrupt):
        _scale(other)
    monkeypatch.undo()
    _scale(other)
    np.testing.assert_array_equal(pair.values, [0, 6, 12])


@njit
def _nested(group):
    first, second = group.both
    return first[0] + second[1] * group.both[0][1]


class NestedKind(Kind):
    """The compiler's type of nested arrays."""


@by_pointer(NestedKind)
class Nested(NamedTuple):
    """A tuple of arrays."""

    both: tuple


def test_a_field_may_be_a_tuple_of_arrays():
    group = Nested((np.array([1.0, 2.0]), np.array([3.0, 5.0], np.float32)))
    before = [sys.getrefcount(part) for part in group.both]
    assert _nested(group) == 11.0
    assert _nested(group) == 11.0
    assert [sys.getrefcount(part) for part in group.both] == before


def test_kernels_do_not_count_references_to_the_arrays():
    """And the named tuple keeps them alive."""
    pair = Pair(np.arange(3.0), 2.0)
    _scale(pair)
    before = sys.getrefcount(pair.values)
    for _ in range(5):
        _scale(pair)
    after = sys.getrefcount(pair.values)
    assert after == before
    values = weakref.ref(pair.values)
    gc.collect()
    assert values() is not None
    del pair
    gc.collect()
    assert values() is None


PROGRAM = """
import numpy as np
from subsea.behavior.steering import ease_goals
from subsea.state import Clock, Fishes, Minds, empty
ease_goals(np.arange(2), empty(Fishes, n=2), empty(Minds, n=2, b=1, d=1), Clock(1, 1, 0.033))
print(sum(ease_goals.stats.cache_hits.values()), sum(ease_goals.stats.cache_misses.values()))
"""


@pytest.mark.nightly
def test_compiled_code_that_takes_pointers_is_kept(tmp_path):
    """A second process finds what the first has compiled."""
    found = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True,
            env=dict(os.environ, NUMBA_CACHE_DIR=str(tmp_path)),
        )  # fmt: skip
        found.append(done.stdout.split())
    assert found == [["0", "1"], ["1", "0"]]
