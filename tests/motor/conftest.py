"""Fishes that play the closed-form repertoire."""

import numpy as np
import pytest

from subsea.repertoire.library import Library, pack
from subsea.repertoire.schema import SEGMENTS
from subsea.state import Fishes, empty_fishes


@pytest.fixture(scope="session")
def library(known_repertoire) -> Library:
    return pack([known_repertoire], [np.zeros((426, 3))])


@pytest.fixture
def make_fishes(library):
    """A function that makes n fishes at the start of a segment."""

    def make(n: int, name: str = "swim_medium") -> Fishes:
        fishes = empty_fishes(n)
        code = SEGMENTS.index(name)
        first, length = library.first[0, code], library.length[0, code]
        fishes.segment[:] = code
        fishes.wanted_segment[:] = code
        fishes.row_a[:] = first + length - 1  # state 0 is the last frame's
        fishes.row_b[:] = first
        fishes.length[:] = library.recorded_length[0]
        fishes.goal_direction[:, 0] = 1.0
        return fishes

    return make
