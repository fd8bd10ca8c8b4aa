"""Balance: roll slowly back to an upright posture (SMC §5.2, appendix B)."""

import math

import numpy as np

from subsea.geometry.rotation import Quaternion, about, multiply, rotate, x_axis
from subsea.kernels import kernel
from subsea.state import Fishes

ROLL_TIME_S = 0.25  # time constant of the smoothed roll: a steady beat wobbles by ±3°
ROLL_GAIN = 0.9  # 1/s: share of the roll corrected per second
ROLL_RATE = np.radians(50.0)  # rad/s: the fastest correction
VERTICAL = 0.98  # sine of the pitch beyond which roll is undefined


@kernel
def roll_of(q: Quaternion) -> float:
    """The roll in radians about x, positive when the back leans to the right (SMC app. B).

    The signed angle from the upright y' = z' × x with z' = x × up; the arccos of SMC has no sign.
    0 for nearly vertical fishes.
    """
    x = x_axis(q)
    y = rotate(q, (0.0, 1.0, 0.0))
    if abs(x[2]) > VERTICAL:
        return 0.0
    # Both arguments carry the same factor, which cancels.
    return math.atan2(y[0] * x[1] - y[1] * x[0], y[2])


@kernel
def balanced(fishes: Fishes, i: int, q: Quaternion, bank: float, dt: float) -> Quaternion:
    """Roll toward the `bank` of the recorded fish, rad, at a bounded rate, on the smoothed gap."""
    roll = roll_of(q) - bank
    smooth = float(fishes.roll[i])
    if roll - smooth > np.pi:
        smooth += 2.0 * np.pi
    elif smooth - roll > np.pi:
        smooth -= 2.0 * np.pi
    smooth += (roll - smooth) * dt / ROLL_TIME_S
    rate = min(max(ROLL_GAIN * smooth, -ROLL_RATE), ROLL_RATE)
    fishes.roll[i] = smooth - rate * dt
    return multiply(q, about(1.0, 0.0, 0.0, -rate * dt))
