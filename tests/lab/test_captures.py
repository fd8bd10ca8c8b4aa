"""Captures in company and alone."""

import numpy as np
import pytest

from subsea.lab.measures import captures
from subsea.state import PREDATOR, PREY
from tests.support.records import a_record, row, still


def test_captures_by_company_and_exposure():
    """Four prey abreast, one alone that is caught at 6 s; one of the four is caught at 8 s."""
    places = np.vstack([row(4, 0.8), [[300.0, 0, 0], [0, 300.0, 0]]])
    alive = np.ones((100, 6), bool)
    alive[60:, 4] = False
    alive[80:, 1] = False
    kind = np.array([PREY] * 5 + [PREDATOR])
    record = a_record(still(100, *places - (0, 0, 100)), alive=alive, kind=kind)
    found = captures(record)
    assert found.lost == 2
    assert found.caught == (1, 1)
    assert found.exposed_s == pytest.approx((3 * 10 + 8, 6), abs=0.2)
