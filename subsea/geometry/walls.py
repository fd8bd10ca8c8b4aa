"""A tank in the sea: four walls of glass, as pillars so wide that they are flat.

Whatever keeps off pillars, or is stopped by them, so does by walls. They are not drawn, and nothing
grows on them.
"""

import numpy as np

from subsea.base.arrays import Array, Bools

WALL_CM = 1e7  # radius of a wall: over 20 m it bends by 0.05 cm
TOP_CM = 1e4  # above the surface


def wall_rows(tank_cm: tuple[float, float] | None) -> Array:
    """Make the walls (4, 4) of a tank as rows of `Sea.pillars`; none (0, 4) without a tank.

    `tank_cm` are its inner length along x and width along y.
    """
    if tank_cm is None:
        return np.zeros((0, 4))
    long, wide = 0.5 * tank_cm[0] + WALL_CM, 0.5 * tank_cm[1] + WALL_CM
    middles = ((long, 0.0), (-long, 0.0), (0.0, wide), (0.0, -wide))
    return np.array([(x, y, WALL_CM, TOP_CM) for x, y in middles])


def is_wall(pillars: Array) -> Bools:
    """Find the walls among rows (k, 4) of `Sea.pillars` (k,)."""
    return np.asarray(pillars[:, 2] >= WALL_CM)


def tank_of(pillars: Array) -> tuple[float, float] | None:
    """Find the inner length along x and width along y, cm, of the tank in rows of `Sea.pillars`."""
    walls = pillars[is_wall(pillars)]
    if not len(walls):
        return None
    long, wide = 2.0 * (np.abs(walls[:, :2]).max(axis=0) - WALL_CM)
    return float(long), float(wide)
