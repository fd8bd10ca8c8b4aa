"""The body-centred coordinate system B of a fish (SMC eqs. 1-5)."""

import numpy as np

from subsea.base.arrays import Array


def body_frame(nodes: Array) -> tuple[Array, Array]:
    """Origin (…, 3) and rotation (…, 3, 3) of B for world nodes (…, 23, 3).

    Columns of the rotation are x anterior, y dorsal, z right lateral. The y axis is normalised,
    which SMC eq. 3 as printed omits: else the frame shrinks when x and n5 - n6 are not
    perpendicular.
    """
    n0, n5, n6, n7 = (nodes[..., i, :] for i in (0, 5, 6, 7))
    origin = 0.5 * (n5 + n7)
    x = _unit(n0 - origin)
    y = _unit(np.cross(x, n5 - n6))
    z = np.cross(x, y)
    return origin, np.stack([x, y, z], axis=-1)


def to_body(points: Array, origin: Array, rotation: Array) -> Array:
    """World points (…, n, 3) in body axes (SMC eqs. 8 and 9)."""
    return np.asarray((points - origin[..., None, :]) @ rotation)


def to_world(points: Array, origin: Array, rotation: Array) -> Array:
    """Body points (…, n, 3) in world axes (SMC eqs. 12 and 13 without the scale)."""
    return np.asarray(origin[..., None, :] + points @ np.swapaxes(rotation, -1, -2))


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))
