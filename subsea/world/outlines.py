"""Outlines of things: lines (n, 2, 3) to draw, cm."""

import numpy as np

from subsea.base.arrays import Array

SIDES = 32  # segments of a circle


def circle(middle: tuple[float, float, float], radius: float) -> Array:
    """Lines (SIDES, 2, 3) of a horizontal circle."""
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    flat = np.stack([np.cos(turn), np.sin(turn), np.zeros(SIDES + 1)], axis=1)
    points = np.array(middle) + radius * flat
    return np.stack([points[:-1], points[1:]], axis=1)


def ellipses(rows: Array) -> Array:
    """Lines (3 k SIDES, 2, 3): three principal ellipses of each ellipsoid."""
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    c, s, o = np.cos(turn), np.sin(turn), np.zeros(SIDES + 1)
    unit = np.stack([np.stack(axes, axis=1) for axes in ((c, s, o), (c, o, s), (o, c, s))])
    out = []
    for x, y, z, *half, yaw in rows:
        across = np.array([[np.cos(yaw), np.sin(yaw), 0.0], [-np.sin(yaw), np.cos(yaw), 0.0],
                           [0.0, 0.0, 1.0]])  # fmt: skip
        points = (unit * half) @ across + (x, y, z)
        out.append(np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3))
    return np.concatenate(out) if out else np.zeros((0, 2, 3))
