"""Habits of light, warmth and ground of a fish, and the ranges of a sea (Tu §7.3)."""

import numpy as np

from subsea.base.arrays import Array
from subsea.kernels import kernel
from subsea.state.groups import Minds, Nature, Sea

MOONLIGHT = 0.003  # brightness of the surface by night, over that of noon, to an adapted eye


@kernel
def wish(minds: Minds, i: int, more: int, less: int) -> float:
    """Return 1 if fish i likes `more` of something, -1 if it likes `less`, 0 for neither or both.

    A direction may have set its habits.
    """
    return (1.0 if _likes(minds, i, more) else 0.0) - (1.0 if _likes(minds, i, less) else 0.0)


@kernel
def _likes(minds: Minds, i: int, habit: int) -> bool:
    """True if fish i has a habit, its own or one set by a direction."""
    fancy = int(minds.fancy[i])
    return bool(minds.likes[i, habit]) if fancy < 0 else (fancy >> habit) & 1 == 1


@kernel
def dusk_of(minds: Minds, i: int, nature: Nature) -> float:
    """Return the share of the sea's range of light below which it is dark for fish i."""
    return float(minds.dusk[i]) if minds.dusk[i] >= 0.0 else nature.dusk


@kernel
def mild_of(minds: Minds, i: int, nature: Nature) -> float:
    """Return the share of the sea's range of temperature below which it is cold for fish i."""
    return float(minds.mild[i]) if minds.mild[i] >= 0.0 else nature.mild


@kernel
def brightness_above(sea: Sea) -> float:
    """Return the brightness at the surface, over that of noon: of daylight, or of the moon."""
    return max(float(sea.sky[1]), MOONLIGHT)


@kernel
def share_of_light(light: float, climate: Array) -> float:
    """Return where a brightness lies between those at the bottom, 0, and at the surface, 1."""
    darkest = np.exp(-climate[2] / climate[3])
    return (light - darkest) / max(1.0 - darkest, 1e-9)


@kernel
def share_of_warmth(temperature: float, climate: Array) -> float:
    """Return where a temperature lies between the lowest of the sea, 0, and the highest, 1."""
    low, high = min(climate[0], climate[1]), max(climate[0], climate[1])
    return (temperature - low) / max(high - low, 1e-9)


@kernel
def depth_of_light(share: float, climate: Array) -> float:
    """Return the depth, cm, at which the light has fallen to a share of its range."""
    darkest = np.exp(-climate[2] / climate[3])
    return -climate[3] * np.log(darkest + share * (1.0 - darkest))


@kernel
def is_pleasant(minds: Minds, i: int, z: float) -> bool:
    """True if fish i likes light and warmth at the height z, cm; see `perception/comfort.py`."""
    return bool(minds.comfort[i, 0] <= -z <= minds.comfort[i, 1])


@kernel
def keeps_low(minds: Minds, i: int) -> bool:
    """True if fish i keeps to the ground or lives on stone: it has them about it all the time."""
    return bool(minds.cruise_height[i, 0] < np.inf or minds.ways[i] != 0)
