"""Rowing against closed forms: plates, scaling, the balance of forces, a coasting hull."""

import numpy as np
import pytest

from subsea.biomechanics.body import MUSCLES, build_body
from subsea.biomechanics.rowing import (
    MIDDLE,
    Oars,
    balanced_speed,
    hull_drag,
    row_ticks,
    steady_stroke,
    thrust,
)
from subsea.biomechanics.simulation import at_rest, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK, TICK_S
from subsea.fish.species import load_species, shipped_species

OARS = Oars(3.4, 1.7, 0.8, 4.0, 120.0, 1.5)
ROWERS = [name for name in shipped_species() if load_species(name).row]


def test_a_fin_that_is_held_is_a_plate_in_the_flow():
    """Tu eq. 4.16: area · speed² · sin² of the angle to the flow, on both sides."""
    area = np.pi / 4 * OARS.length * OARS.width
    expected = -2 * area * 5.0**2 * np.sin(MIDDLE) ** 2
    held = OARS._replace(amplitude=0.0)
    assert thrust(held, np.pi / 2, 5.0) == pytest.approx(expected, rel=0.03)
    assert thrust(OARS, 1.5 * np.pi, 5.0) == 0.0  # edge-on


def test_a_fin_that_flaps_pushes_up_and_down_alike():
    """A plate halfway into the flow: at rest half of area · (tip speed)² · mean of share²."""
    flapping = OARS._replace(flaps=True)
    assert thrust(flapping, 0.5 * np.pi, 2.0) == pytest.approx(thrust(flapping, 1.5 * np.pi, 2.0))
    tip = OARS.amplitude * 2 * np.pi / OARS.period * OARS.length
    # The mean of share² over an ellipse along its length is 5/16.
    expected = np.pi / 4 * OARS.length * OARS.width * tip**2 * 5 / 16
    assert thrust(flapping, 0.5 * np.pi, 0.0) == pytest.approx(expected, rel=0.03)
    assert thrust(OARS._replace(amplitude=0.0, flaps=True), 1.0, 5.0) == 0.0


@pytest.mark.parametrize("flaps", [False, True])
def test_speed_is_proportional_to_the_frequency_of_strokes(flaps):
    """All forces are quadratic: the stride is constant."""
    slow, quick = (
        steady_stroke(OARS._replace(period=period, flaps=flaps), 240) for period in (4.0, 2.0)
    )
    np.testing.assert_allclose(quick, 2 * slow, rtol=1e-6)


def test_a_heavy_fish_rows_at_the_speed_of_the_balance():
    speeds = steady_stroke(OARS._replace(mass=1e4), 240)
    assert speeds.mean() == pytest.approx(balanced_speed(OARS), rel=2e-3)
    assert np.ptp(steady_stroke(OARS._replace(mass=30.0), 240)) > 20 * np.ptp(speeds)


@pytest.mark.parametrize("name", ROWERS)
def test_a_hull_coasts_with_its_drag_and_rows_within_measured_speeds(name):
    """1/U grows in proportion to time; labriform swimmers do 0.3 to 1.5 L/s at 2 to 5 Hz."""
    species = load_species(name)
    body, length = build_body(species.body), species.length_cm
    state, ticks = at_rest(body), 30
    state.v[:, 0] = 0.05 * length
    simulate(body, state, np.zeros((ticks * STEPS_PER_TICK, MUSCLES)))
    mass, speed = body.mass.sum(), body.mass @ state.v[:, 0] / body.mass.sum()
    grown = hull_drag(body) / mass * ticks * 10 * TICK_S
    assert 1 / speed == pytest.approx(20 / length + grown, rel=0.05)
    fin = species.surface.pectoral
    steps = row_ticks(body, species.row, (fin.length * length, fin.width * length))
    assert 0.3 < steps.mean() / TICK_S / length < 1.5
    assert 2 < 1 / (TICK_S * len(steps)) < 5
    assert np.ptp(steps) > 0.01 * steps.mean()  # it is pushed once a stroke
