"""The seabed: a height field of dunes from a seed (SMC §6.2)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.scenario import Scenario

Array = NDArray[np.floating[Any]]

SAMPLES = 193  # per side
MARGIN = 1.6  # the grid reaches beyond the world's radius, into the fog
WAVES = 28
RIM_CM = 120.0  # the seabed rises toward the rim, as in a bay


def half_width(scenario: Scenario) -> float:
    """Half the side of the terrain's square, cm."""
    return MARGIN * scenario.bounds.radius_cm


def make_terrain(scenario: Scenario) -> Array:
    """Heights (n, n) float32, cm, row along y and column along x; mean near -depth_cm.

    A sum of sines of random directions whose amplitude falls with the wave number, bent by
    a slower one: long dunes with small ones on them. No part is higher than half the depth.
    """
    rng = np.random.default_rng([scenario.terrain.seed, 0x7E44A1])
    w = half_width(scenario)
    axis = np.linspace(-w, w, SAMPLES)
    x, y = np.meshgrid(axis, axis)
    base = 2 * np.pi / scenario.terrain.dune_length_cm
    bend = 60.0 * np.sin(0.37 * base * y + rng.uniform(0, 2 * np.pi))
    heights = np.zeros_like(x)
    for octave in rng.uniform(-1.2, 1.3, WAVES):
        wave = base * 2.0**octave
        angle = rng.normal(0.5, 0.7)
        phase = rng.uniform(0, 2 * np.pi)
        along = (x + bend) * np.cos(angle) + y * np.sin(angle)
        heights += 2.0 ** (-1.7 * octave) * np.sin(wave * along + phase)
    # From crest to trough a sine of this deviation is as high as asked.
    heights *= scenario.terrain.dune_height_cm / (8**0.5 * max(float(heights.std()), 1e-9))
    rim = np.clip(np.hypot(x, y) / scenario.bounds.radius_cm - 0.75, 0.0, 1.0)
    heights = heights + RIM_CM * rim**2 - scenario.bounds.depth_cm
    return np.minimum(heights, -0.5 * scenario.bounds.depth_cm).astype(np.float32)


def crest(heights: Array, half_width: float, radius: float) -> float:
    """The height (cm) that no part of the seabed within `radius` exceeds."""
    axis = np.linspace(-half_width, half_width, len(heights))
    x, y = np.meshgrid(axis, axis)
    # A sample beyond the radius still shapes what is inside of it, a cell away.
    inside = np.hypot(x, y) <= radius + 2.0 * (axis[1] - axis[0])
    return float(heights[inside].max())


def heights_at(heights: Array, half_width: float, places: Array) -> Array:
    """Heights (n,) at places (n, 2), bilinear as `kinematics.heightfield.height_at`."""
    last = len(heights) - 1
    at = np.clip((places + half_width) / (2 * half_width) * last, 0, last)
    (j, i) = cell = np.minimum(at.astype(int), last - 1).T
    u, v = at.T - cell
    south = (1 - u) * heights[i, j] + u * heights[i, j + 1]
    north = (1 - u) * heights[i + 1, j] + u * heights[i + 1, j + 1]
    return np.asarray((1 - v) * south + v * north, np.float64)
