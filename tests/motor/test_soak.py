"""An hour of random commands: no failure, no drift, no fish upside down for long."""

import numpy as np
import pytest

from subsea.geometry.rotation import about
from subsea.motor.containment import roll_of
from subsea.motor.controller import command
from subsea.motor.playback import play
from subsea.state import Clock, Fishes, empty
from tests.support.scenes import everyone

TICK = 0.033
HOUR = int(3600 / TICK)
FISHES = 24
UPSIDE_DOWN_S = 6.0  # longest time that a fish may lie on its back


@pytest.mark.nightly
def test_an_hour_at_random_commands(shipped_library):
    _, _, library = shipped_library("fusilier")
    rng = np.random.default_rng(4)
    fishes = empty(Fishes, n=FISHES)
    fishes.length[:] = rng.uniform(8, 60, FISHES)
    fishes.scale[:] = fishes.length / library.recorded_length[0]
    fishes.rate[:] = 1 / np.sqrt(fishes.scale)
    fishes.identity[:] = rng.uniform(0, 1, FISHES)
    fishes.row_b[:] = 1
    # Half of them begin on their backs.
    fishes.orientation[:] = about(1.0, 0.0, 0.0, np.pi / 2)
    fishes.orientation[::2] = about(1.0, 0.0, 0.0, -np.pi / 2 + 0.1)
    overturned = np.zeros(FISHES)
    for tick in range(HOUR):
        if tick % 60 == 0:
            change = rng.uniform(size=FISHES) < 0.5
            wish = rng.normal(size=(FISHES, 3))
            wish /= np.linalg.norm(wish, axis=1, keepdims=True)
            fishes.goal_direction[change] = wish[change]
            fishes.goal_speed[change] = rng.uniform(-0.5, 1.0, FISHES)[change]
        command(everyone(fishes), fishes, library, Clock(1, tick, TICK))
        play(everyone(fishes), fishes, library, TICK)
        if tick % 30 == 0:
            rolls = np.array([abs(roll_of(q)) for q in fishes.orientation.astype(float)])
            overturned = np.where(rolls > np.pi / 2, overturned + 30 * TICK, 0.0)
            assert overturned.max() < UPSIDE_DOWN_S
            assert np.abs(np.linalg.norm(fishes.orientation, axis=1) - 1).max() < 1e-5
            assert np.isfinite(fishes.position).all()
            speed = np.linalg.norm(fishes.velocity, axis=1) / fishes.length
            assert speed.max() < 3.0
