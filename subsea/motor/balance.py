"""Balancing: a fish rolls slowly back to an upright posture (SMC §5.2, appendix B)."""

import math

import numpy as np

from subsea.core.kernels import kernel
from subsea.geometry.rotation import Quaternion, about, multiply, rotate, x_axis
from subsea.state import Fishes

ROLL_TIME_S = 0.25  # time constant of the smoothed roll: a steady beat wobbles by ±3°
ROLL_GAIN = 0.9  # 1/s: share of the roll that is undone in a second
ROLL_RATE = np.radians(50.0)  # rad/s: the fastest that a fish rights itself
VERTICAL = 0.98  # a fish whose nose points up or down more than this has no roll to mend


@kernel
def roll_of(q: Quaternion) -> float:
    """The roll in radians about x, positive when the back leans to the right (SMC app. B).

    The signed angle from the upright y' = z' × x with z' = x × up. SMC takes the arccos, which
    does not tell left from right. Nearly vertical fishes have none.
    """
    x = x_axis(q)
    y = rotate(q, (0.0, 1.0, 0.0))
    if abs(x[2]) > VERTICAL:
        return 0.0
    # Both are longer than the unit by the same factor, which the angle does not see.
    return math.atan2(y[0] * x[1] - y[1] * x[0], y[2])


@kernel
def balanced(fishes: Fishes, i: int, q: Quaternion, dt: float) -> Quaternion:
    """Roll toward upright at a bounded rate, on the smoothed roll."""
    roll = roll_of(q)
    smooth = float(fishes.roll[i])
    if roll - smooth > np.pi:
        smooth += 2.0 * np.pi
    elif smooth - roll > np.pi:
        smooth -= 2.0 * np.pi
    smooth += (roll - smooth) * dt / ROLL_TIME_S
    rate = min(max(ROLL_GAIN * smooth, -ROLL_RATE), ROLL_RATE)
    fishes.roll[i] = smooth - rate * dt
    return multiply(q, about(1.0, 0.0, 0.0, -rate * dt))
