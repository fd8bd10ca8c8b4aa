"""The sign at the edge of the sea: when it shows, and the way back."""

import math

import numpy as np
import pytest

from subsea.scenario.schema import Bounds
from subsea.state import Submarine
from subsea.submarine.vessel import Helm, step_hull
from subsea.ui.hud import edge_reading
from tests.support.seas import bare_sea

BOUNDS = Bounds(radius_cm=900.0, depth_cm=500.0)


def at(x, y, heading_deg=0.0):
    boat = Submarine(position=np.array([x, y, -250.0]))
    boat.angles[0] = math.radians(heading_deg)
    return boat


def test_it_shows_where_the_submarine_comes_to_rest_and_not_inside():
    boat = at(500.0, 100.0)
    assert edge_reading(boat, BOUNDS).opacity == 0.0
    shown = []
    around = bare_sea(-500.0, BOUNDS.radius_cm, 1000.0)
    for _ in range(400):
        step_hull(boat, Helm(surge=1.0), 0.033, around)
        shown.append(edge_reading(boat, BOUNDS).opacity)
    assert math.hypot(*boat.position[:2]) < 900.0
    assert shown[0] == 0.0 and shown[-1] == 1.0 and sorted(shown) == shown


@pytest.mark.parametrize(
    ("heading_deg", "turn_deg"), [(0.0, 180.0), (90.0, 90.0), (270.0, -90.0), (180.0, 0.0)]
)
def test_it_points_to_the_middle_of_the_sea(heading_deg, turn_deg):
    edge = edge_reading(at(850.0, 0.0, heading_deg), BOUNDS)
    assert abs(math.degrees(edge.turn)) == pytest.approx(abs(turn_deg), abs=1e-6)
    assert turn_deg % 180.0 == 0.0 or math.degrees(edge.turn) == pytest.approx(turn_deg)
    assert edge.compass_deg == pytest.approx(180.0)
    assert edge_reading(at(0.0, 850.0), BOUNDS).compass_deg == pytest.approx(90.0)
