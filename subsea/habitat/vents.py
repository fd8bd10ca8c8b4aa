"""When bubbles leave the vents in the seabed (Tu §8.2)."""

import numpy as np

from subsea.base.arrays import Array

SLOWEST = 0.22  # least diameter over a vent's largest, as in `bubbles.vert`
BURST = 9.0  # bubbles that leave together
STAGGER_S = 0.37  # from vent to vent


def terminal_speed(diameter: Array | float) -> Array:
    """Terminal speed in cm/s of bubbles with a diameter in cm (Mendelson 1967)."""
    wave = np.sqrt(154.0 / np.asarray(diameter) + 495.0 * np.asarray(diameter))
    return np.asarray(np.minimum(wave, 280.0 * np.asarray(diameter)))


def departures(depth_cm: float, rate: float, size: float, number: int) -> tuple[Array, float]:
    """First moments (n,), s, at which bubbles leave vent `number`, and the time until they repeat.

    The vent emits `rate` bubbles a second, of at most `size` cm, in bursts. There are as many
    moments as bubbles that rise at one time: all have gone when the moments repeat.
    """
    diameters = size * np.linspace(SLOWEST, 1.0, 50)
    slowest_s = depth_cm / float(terminal_speed(diameters).min()) + 1.0
    count = int(np.ceil(rate * slowest_s))
    k = np.arange(count)
    moments = (k + 0.85 * BURST / (2 * np.pi) * np.sin(2 * np.pi * k / BURST)) / rate
    return moments + STAGGER_S * number, count / rate
