"""Adjustments of a patch on its output: moved corners and points, turns, an edge mask, colours.

A place is a point of the patch's picture, in shares of it from the lower left corner. Places are
moved by the homography of the corners, then by a smooth field over a grid of points, then turned
onto the rectangle of the patch.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array

UNMOVED = np.eye(3)
MOST_EDGES = 32  # corners of an edge mask, as in `shaders/resolve.frag`


class PatchAdjustment(NamedTuple):
    """Shifts, turn, mask and colours of the picture of a patch on its output."""

    corners: Array = UNMOVED  # (3, 3) homography from places to moved places
    # (rows, columns, 2), the lowest row first: further shifts of the points of a regular grid over
    # the picture, in shares of it
    points: Array | None = None
    turn: Array = UNMOVED  # (3, 3) affine map from moved places to shares of the patch's rectangle
    # (k, 2) polygon in shares of the patch's rectangle; it is dark outside. None: no mask
    edge: Array | None = None
    edge_soft_px: float = 1.0  # width of the fade across the polygon's edge
    gain: tuple[float, float, float] = (1.0, 1.0, 1.0)  # factors on red, green and blue light

    @property
    def moves(self) -> bool:
        """True if the picture does not lie straight on its rectangle."""
        still = np.array_equal(self.corners, UNMOVED) and np.array_equal(self.turn, UNMOVED)
        return not still or self.points is not None

    @property
    def on_its_side(self) -> bool:
        """True if the width of the picture lies along the height of the rectangle."""
        return bool(abs(self.turn[0, 1]) > abs(self.turn[0, 0]))


def moved(adjustment: PatchAdjustment, places: Array) -> Array:
    """Find where places (n, 2) are lit: (n, 3), shares of the rectangle times w, and w."""
    places = np.asarray(places, np.float64)
    lit = np.column_stack([places, np.ones(len(places))]) @ adjustment.corners.T
    if adjustment.points is not None:
        lit[:, :2] += field_at(adjustment.points, places) * lit[:, 2:]
    return np.asarray(lit @ adjustment.turn.T)


def field_at(points: Array, places: Array) -> Array:
    """Interpolate shifts (n, 2) at places (n, 2) from those of a grid (rows, columns, 2).

    The interpolation is by Catmull-Rom splines: it has no creases, a point changes only the cells
    up to two from it, and shifts that grow linearly stay so.
    """
    across, up = (_weights(points.shape[1 - k], np.clip(places[:, k], 0.0, 1.0)) for k in (0, 1))
    rows = np.tensordot(up, points, 1)  # (n, columns, 2)
    return np.asarray((across[..., None] * rows).sum(axis=1))


def resampled(points: Array, rows: int, columns: int) -> Array:
    """Take the shifts of a grid (r, c, 2) at the points of another one (rows, columns, 2)."""
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    return field_at(points, np.stack([x, y], axis=-1).reshape(-1, 2)).reshape(rows, columns, 2)


def homography(corners: Array) -> Array:
    """Find the homography (3, 3) that moves the corners of the unit square to `corners` (4, 2).

    Their order is lower left, lower right, upper right, upper left. It is exact where nothing
    moves. Source: Heckbert, *Fundamentals of Texture Mapping and Image Warping* (1989), §2.2.3.
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = np.asarray(corners, np.float64)
    sx, sy = x0 - x1 + x2 - x3, y0 - y1 + y2 - y3
    dx1, dx2, dy1, dy2 = x1 - x2, x3 - x2, y1 - y2, y3 - y2
    area = dx1 * dy2 - dx2 * dy1
    g, h = (sx * dy2 - dx2 * sy) / area, (dx1 * sy - sx * dy1) / area
    rows = [x1 - x0 + g * x1, x3 - x0 + h * x3, x0], [y1 - y0 + g * y1, y3 - y0 + h * y3, y0]
    return np.array([*rows, [g, h, 1.0]])


def is_convex(corners: Array) -> bool:
    """True if corners (4, 2) are those of a convex quadrilateral, anticlockwise."""
    ahead = np.roll(corners, -1, axis=0) - corners
    after = np.roll(ahead, -1, axis=0)
    return bool((ahead[:, 0] * after[:, 1] - ahead[:, 1] * after[:, 0] > 1e-6).all())


def folds(adjustment: PatchAdjustment) -> bool:
    """True if a moved picture overlaps itself or is mirrored beyond its turn."""
    if adjustment.points is None:
        return False
    rows, columns = (4 * (count - 1) + 1 for count in adjustment.points.shape[:2])
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    straight = adjustment._replace(turn=UNMOVED)
    lit = moved(straight, np.stack([x, y], axis=-1).reshape(-1, 2)).reshape(rows, columns, 3)
    places = lit[..., :2] / lit[..., 2:]
    across, up = np.diff(places, axis=1)[:-1], np.diff(places, axis=0)[:, :-1]
    return bool((across[..., 0] * up[..., 1] - across[..., 1] * up[..., 0] <= 0.0).any())


def _weights(count: int, shares: Array) -> Array:
    """Weights (n, count) of points in a row, at shares (n,) of the way from first to last."""
    at = shares * (count - 1)
    first = np.clip(np.floor(at), 0, count - 2).astype(int)
    t = at - first
    basis = (
        (-t + 2 * t**2 - t**3) / 2,
        (2 - 5 * t**2 + 3 * t**3) / 2,
        (t + 4 * t**2 - 3 * t**3) / 2,
        (t**3 - t**2) / 2,
    )
    weights, rows = np.zeros((len(at), count + 2)), np.arange(len(at))
    for k, weight in enumerate(basis):
        weights[rows, first + k] += weight
    # Points beyond the ends go on straight.
    weights[:, 1] += 2 * weights[:, 0]
    weights[:, 2] -= weights[:, 0]
    weights[:, -2] += 2 * weights[:, -1]
    weights[:, -3] -= weights[:, -1]
    return weights[:, 1:-1]
