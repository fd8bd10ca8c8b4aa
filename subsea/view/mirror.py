"""The picture of a headset for those beside: a steadied, level part of what one eye sees.

The eye's picture is turned to where a camera would look that follows the head smoothly. Both are
at the same place, so it is exact for all distances.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.view.camera import NEAR_CM, View, edge_tangents, look, off_axis
from subsea.view.rig import CameraPose, DisplayPatch, Eye, Projection, Warp

STEADY_S = 0.3  # in which the camera follows the head
SHOWN = 0.62  # tangent of the picture's longer half over that of the eye's narrowest edge
COLUMNS, ROWS = 24, 14  # of the mesh


class Mirror(NamedTuple):
    """A camera at the eye of a headset."""

    axes: Array  # (3, 3) rows: right, up, ahead, on the observer
    across: float  # tangents of half of its width and height
    up: float


def mirror_of(eye: Eye, size: tuple[int, int], before: Mirror | None, dt: float) -> Mirror:
    """The camera for a window of `size` pixels, `dt` seconds after the one before."""
    ahead = eye.axes[2]
    if before is not None:
        share = 1.0 - np.exp(-dt / STEADY_S)
        ahead = before.axes[2] + share * (ahead - before.axes[2])
    right = np.array([ahead[2], 0.0, -ahead[0]])  # level
    if np.linalg.norm(right) < 1e-3 or np.linalg.norm(ahead) < 1e-3:  # straight up or down
        right, ahead = eye.axes[0], eye.axes[2]
    ahead, right = ahead / np.linalg.norm(ahead), right / np.linalg.norm(right)
    narrow = SHOWN * min(abs(t) for t in edge_tangents(eye.projection))
    larger = max(size)
    return Mirror(
        np.stack([right, np.cross(ahead, right), ahead]),
        narrow * size[0] / larger,
        narrow * size[1] / larger,
    )


def mirror_patch(mirror: Mirror, eye: Eye, size: tuple[int, int]) -> DisplayPatch:
    """The patch that shows the camera's picture in a window of `size` pixels."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, COLUMNS + 1), np.linspace(0.0, 1.0, ROWS + 1))
    shares = np.stack([x.ravel(), y.ravel()], axis=1)
    ends = (2.0 * shares - 1.0) * (mirror.across, mirror.up)
    ways = np.concatenate([ends, np.ones((len(ends), 1))], axis=1) @ mirror.axes
    seen = ways @ eye.axes.T
    p = eye.projection.astype(np.float64)
    tangents = seen[:, :2] / np.maximum(seen[:, 2:], 1e-3)
    source = 0.5 + 0.5 * (tangents * (p[0, 0], p[1, 1]) - (p[0, 2], p[1, 2]))
    source = np.clip(source, 0.0, 1.0)
    corner = (np.arange(ROWS)[:, None] * (COLUMNS + 1) + np.arange(COLUMNS)).ravel()
    a, b, c, d = corner, corner + 1, corner + COLUMNS + 2, corner + COLUMNS + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    warp = Warp(np.concatenate([shares, source, source], axis=1), triangles)
    place, source_rect = (0, 0, *size), eye.viewport
    return DisplayPatch(place, source_rect, source_rect, shape=Projection.WARPED, warp=warp)


def mirror_view(mirror: Mirror, eye: Eye, observer: CameraPose, size: tuple[int, int]) -> View:
    """The view of the camera on an observer."""
    axes = observer.axes
    place = observer.eye + eye.offset @ axes
    forward, up = mirror.axes[2] @ axes, mirror.axes[1] @ axes
    across, high = NEAR_CM * mirror.across, NEAR_CM * mirror.up
    projection = off_axis(-across, across, -high, high)
    return View((0, 0, *size), look(place, forward, up), projection, place)
