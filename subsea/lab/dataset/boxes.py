"""Boxes of whole bodies in a picture."""

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.media.flow import NEAR_CM, SEEN
from subsea.view.optics import Optics


def whole_boxes(optics: Optics, points: Array, opacity: Array, triangles: Ints) -> Array:
    """Boxes (n, 4) of whole bodies: left, upper, right, lower edge in pixels; NaN out of sight.

    `points` (n, m, 3) are the vertices in the axes of the camera, `opacity` (n, m) is NaN for those
    that are not there. Boxes end at the picture's edge.
    """
    near = NEAR_CM + (0.0 if optics.port is None else optics.port.front_cm)
    edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
    a, b = edges.T
    shown: Bools = np.greater_equal(opacity, SEEN)
    # The ends of edges along which the skin fades, at the place where it no longer shows.
    fades = shown[:, a] != shown[:, b]
    who, edge = np.nonzero(fades & ~np.isnan(opacity[:, a] + opacity[:, b]))
    from_, to = (opacity[who, side[edge]] for side in (a, b))
    share = ((SEEN - from_) / (to - from_))[:, None]
    ends = (1.0 - share) * points[who, a[edge]] + share * points[who, b[edge]]
    low, high = np.full((len(points), 2), np.inf), np.full((len(points), 2), -np.inf)

    def enter(who: Ints, places: Array) -> None:
        pixels = optics.project(places)
        np.minimum.at(low, who, pixels)
        np.maximum.at(high, who, pixels)

    ahead = points[..., 2] > near
    for rows, places in ((np.nonzero(shown & ahead)[0], points[shown & ahead]), (who, ends)):
        front = places[:, 2] > near
        enter(rows[front], places[front])
    # Where a body reaches behind the camera, it ends at the nearest plane that is drawn.
    cut = np.flatnonzero((shown & ahead).any(axis=1) & (shown & ~ahead).any(axis=1))
    for i in cut:
        both = shown[i, a] & shown[i, b] & (ahead[i, a] != ahead[i, b])
        p, q = points[i, a[both]], points[i, b[both]]
        share = (near * (1.0 + 1e-9) - p[:, 2]) / (q[:, 2] - p[:, 2])
        enter(np.full(len(p), i), p + share[:, None] * (q - p))
    limit = np.array(optics.size) - 0.5
    inside = np.all([*(low < limit).T, *(high > -0.5).T], axis=0)
    boxes = np.concatenate([np.clip(low, -0.5, limit), np.clip(high, -0.5, limit)], axis=1)
    return np.where(inside.reshape(-1, 1), boxes, np.nan)
