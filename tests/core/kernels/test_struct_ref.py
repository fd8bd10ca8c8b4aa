"""Named tuples that kernels take by pointer."""

import os
import subprocess
import sys
from typing import NamedTuple

import numpy as np
from numba import njit, typeof

from subsea.core.kernels.struct_ref import Kind, by_pointer
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


PROGRAM = """
import numpy as np
from subsea.behavior.steering import ease_goals
from subsea.state import Clock, Fishes, Minds, empty
ease_goals(empty(Fishes, n=2), empty(Minds, n=2, b=1, d=1), Clock(1, 1, 0.033))
print(sum(ease_goals.stats.cache_hits.values()), sum(ease_goals.stats.cache_misses.values()))
"""


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
