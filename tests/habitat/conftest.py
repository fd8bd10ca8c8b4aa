"""A sea with a flat floor, in which a test puts what it is about."""

import numpy as np
import pytest

from subsea.state import Sea, empty

RADIUS, WIDTH, DEPTH = 500.0, 800.0, 300.0


@pytest.fixture(scope="session")
def make_sea():
    """Specks (p, 3), pillars (k, 4), rocks (k, 7), radius -> a sea 300 cm deep."""

    def make(plankton=(), pillars=(), rocks=(), radius=RADIUS):
        specks = np.array(plankton, np.float32).reshape(-1, 3)
        given = {
            "heights": np.full((5, 5), -DEPTH, np.float32),
            "floor": np.full((5, 5), -DEPTH, np.float32),
            "half_width": WIDTH,
            "radius": radius,
            "pillars": np.array(pillars, np.float64).reshape(-1, 4),
            "rocks": np.array(rocks, np.float64).reshape(-1, 7),
            "climate": np.array([27.0, 21.0, DEPTH, 700.0]),
            "plankton": specks,
        }
        return empty(Sea, given=given, p=len(specks), c=0, s=0, q=0)

    return make
