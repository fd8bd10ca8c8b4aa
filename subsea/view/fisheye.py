"""A picture over the sea in the directions of an equidistant fisheye, as planetariums make them."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bytes

FAR_CM = 500.0  # from the observer, which only matters for two eyes
RINGS, SECTORS = 48, 96  # of the mesh: the picture is bent between them by less than a pixel


class Fisheye(NamedTuple):
    """A fisheye with the front at its foot."""

    pixels: Bytes  # (h, h, 4) in sRGB with opacity, top row first
    tilt: float  # rad, of its middle from the zenith to the front
    angle: float  # rad, from edge to edge


def fisheye_mesh(tilt: float, angle: float) -> Array:
    """Corners (n, 7) of triangles: right, up, ahead, cm; place in the picture from its lower left.

    As in `direction` of `shaders/resolve.frag`. The last two numbers of a corner are 0.
    """
    radius = np.linspace(0.0, 1.0, RINGS + 1)[:, None]
    turn = np.linspace(0.0, 2.0 * np.pi, SECTORS + 1)[None, :]
    x, y = np.cos(turn), np.sin(turn)
    away = 0.5 * angle * radius
    along, aside = np.cos(away), np.sin(away)
    c, s = np.cos(tilt), np.sin(tilt)
    places = np.stack([aside * x, along * c + aside * y * s, along * s - aside * y * c], axis=-1)
    shares = np.stack([0.5 + 0.5 * radius * x, 0.5 + 0.5 * radius * y], axis=-1)
    corners = np.concatenate([FAR_CM * places, shares, np.zeros_like(shares)], axis=-1)
    a, b = corners[:-1, :-1], corners[1:, :-1]
    d, e = corners[:-1, 1:], corners[1:, 1:]
    return np.stack([a, b, e, a, e, d], axis=2).reshape(-1, 7)
