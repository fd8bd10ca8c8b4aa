"""Bodies stay out of stone and within the bounds of the sea."""

import numpy as np
import pytest

from subsea.geometry.vector import vector
from subsea.habitat.contact import OUT_PER_S, TOUCH_BL, TOUCH_CM, clearance, keep_in_free_water
from tests.support.scenes import everyone

DT = 0.033
ROCKS = np.array([[0.0, 60, -300, 70, 50, 80, 0.3], [0.0, -60, -300, 70, 50, 80, -0.3]])
PILLARS = np.array([[300.0, 0.0, 50.0, -100.0]])
TOUCH = TOUCH_CM + TOUCH_BL * 20.0
PARTS = np.array([7.0, -3.0, -13.0])  # snout, middle and tail along x


def swim(t, sea, way, speed, ticks):
    """Yield the places of snout, middle and tail of a fish that swims along `way` at `speed`."""
    own = speed * np.array([way], np.float32)
    for _ in range(ticks):
        t.fishes.drift[:] = 0.0
        keep_in_free_water(everyone(t.fishes), t.fishes, sea, own, DT)
        t.fishes.position[0] += DT * (t.fishes.drift[0] + own[0])
        yield t.fishes.position[0] + PARTS[:, None] * np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize("way", [(-1.0, 0.0, 0.0), (-0.8, 0.6, 0.0), (-0.6, 0.0, -0.8)])
@pytest.mark.parametrize("speed", [25.0, 400.0])
def test_nobody_swims_into_stone_not_even_into_a_cleft(tank, way, speed):
    t = tank(1)
    sea = t.sea._replace(rocks=ROCKS, pillars=PILLARS)
    t.fishes.position[0] = np.array([20.0, 0.0, -300.0]) - 110.0 * np.array(way)
    for parts in swim(t, sea, way, speed, 300):
        assert min(clearance(PILLARS, ROCKS, vector(part)) for part in parts) > 0.0


@pytest.mark.parametrize("way", [(1, 0, 0), (-0.6, 0.8, 0), (0.6, 0, 0.8), (0, -0.6, -0.8)])
def test_nobody_gets_out_of_bounds(tank, way):
    """However fast one flees toward wall, surface or seabed; it slides along them."""
    t = tank(1)
    for parts in swim(t, t.sea, way, 300.0, 400):
        assert np.hypot(parts[:, 0], parts[:, 1]).max() < t.sea.radius
        assert parts[:, 2].max() < 0.0
        assert parts[:, 2].min() > -600.0


def test_a_barrier_is_felt_only_near_by_and_only_by_its_part(tank):
    """The push takes away the approach, a part of it while the body brakes, and none before."""
    t = tank(1)
    wall = t.sea.radius
    brakes = 61.0 / OUT_PER_S
    for gap, kept in ((TOUCH + brakes + 3.0, 60.0), (TOUCH + 5.0, 5.0 * OUT_PER_S), (TOUCH, 0.0)):
        t.fishes.position[0] = wall - gap - 7.0, 0.0, -300.0
        t.fishes.drift[:] = 0.0
        keep_in_free_water(
            everyone(t.fishes), t.fishes, t.sea, np.array([[60.0, 5.0, 0.0]], np.float32), DT
        )
        assert 60.0 + t.fishes.drift[0, 0] == pytest.approx(kept, abs=0.2)
        assert t.fishes.drift[0, 1] == pytest.approx(0.0, abs=0.1)


def test_a_fish_inside_is_let_out_gently(tank):
    t = tank(1)
    t.fishes.position[0, 2] = -620.0
    keep_in_free_water(everyone(t.fishes), t.fishes, t.sea, np.zeros((1, 3), np.float32), DT)
    assert 20.0 < t.fishes.drift[0, 2] < 100.0
