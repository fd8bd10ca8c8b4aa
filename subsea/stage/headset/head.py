"""The eyes of a head in a headset: from the runtime's space to cameras on an observer.

The runtime's space is right-handed, in metres: x right, y up, z back. The observer's axes are
right, up and ahead, in centimetres, at true scale.

The window beside a headset shows a steadied, level part of what one eye sees: the eye's picture is
turned to where a camera would look that follows the head smoothly. Both are at one place, so the
picture is exact for all distances.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.rotation import matrix
from subsea.view.camera import NEAR_CM, View, edge_tangents, look, off_axis
from subsea.view.meshes import grid_triangles
from subsea.view.rig import CameraPose, CameraRig, DisplayPatch, Eye, Projection, Rect, Warp

CM_PER_M = 100.0
TO_OBSERVER = np.array([1.0, 1.0, -1.0])  # z back becomes ahead


class Pose(NamedTuple):
    """A place and an orientation in the runtime's space."""

    position: Array  # (3,) m
    orientation: Array  # (4,) unit quaternion x, y, z, w


class HeadEye(NamedTuple):
    """An eye as the runtime describes it."""

    pose: Pose
    # Angles of the picture's edges from straight ahead, rad: left and down are negative.
    left: float
    right: float
    up: float
    down: float


class Home(NamedTuple):
    """The head's place in the runtime's space when it sits at the observer's place."""

    position: Array  # (3,) m
    yaw: float  # rad, to the left


AT_ORIGIN = Home(np.zeros(3), 0.0)

# Before the runtime has found the head: eyes 64 mm apart that look ahead, with a square picture.
AT_REST = tuple(
    HeadEye(
        Pose(np.array([x, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 1.0])),
        *(np.pi / 4 * np.array([-1.0, 1.0, 1.0, -1.0])).tolist(),
    )
    for x in (-0.032, 0.032)
)


def rotation_of(orientation: Array) -> Array:
    """The matrix (3, 3) of a quaternion x, y, z, w; its columns are the turned axes."""
    unit = np.asarray(orientation, np.float64) / np.linalg.norm(orientation)
    return matrix(np.roll(unit, 1))


def home_of(eyes: Sequence[HeadEye]) -> Home:
    """The home of a head that is where it should be, looking straight ahead."""
    middle = np.mean([eye.pose.position for eye in eyes], axis=0)
    ahead = -np.mean([rotation_of(eye.pose.orientation)[:, 2] for eye in eyes], axis=0)
    if np.hypot(ahead[0], ahead[2]) < 1e-3:  # straight up or down
        return Home(middle, 0.0)
    return Home(middle, float(np.arctan2(-ahead[0], -ahead[2])))


def on_observer(pose: Pose, home: Home) -> tuple[Array, Array]:
    """Offset (3,), cm, and axes (3, 3), rows right, up, ahead, of a pose on the observer."""
    c, s = np.cos(home.yaw), np.sin(home.yaw)
    back = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])  # undoes the yaw
    offset = CM_PER_M * TO_OBSERVER * (back @ (np.asarray(pose.position) - home.position))
    turned = back @ rotation_of(pose.orientation)
    turned[:, 2] *= -1.0  # the third axis is back in the runtime's space
    return offset, (TO_OBSERVER[:, None] * turned).T


def snapped(heading: float, shown: float, step: float) -> float:
    """The heading to show, rad, if the view turns in steps: `shown`, or a multiple of `step`.

    It changes when the heading is more than .6 of a step from the one that is shown.
    """
    off = (heading - shown + np.pi) % (2.0 * np.pi) - np.pi
    return shown if abs(off) < 0.6 * step else step * float(np.round(heading / step))


def head_eyes(
    eyes: Sequence[HeadEye], viewports: Sequence[Rect], home: Home = AT_ORIGIN
) -> tuple[Eye, ...]:
    """The cameras of a head, drawn into these viewports of the canvas."""
    found = []
    for eye, viewport in zip(eyes, viewports, strict=True):
        offset, axes = on_observer(eye.pose, home)
        edges = NEAR_CM * np.tan([eye.left, eye.right, eye.down, eye.up])
        found.append(Eye(viewport, offset, axes, off_axis(*edges.tolist())))
    return tuple(found)


def headset_rig(
    sizes: Sequence[tuple[int, int]], eyes: Sequence[HeadEye], mirror: tuple[int, int]
) -> CameraRig:
    """The rig of a headset with pictures of these `sizes` and a window that mirrors one eye.

    Output 0 is the window of `mirror` pixels, which shows as much of the left picture as fits its
    shape. The other outputs are the pictures of the eyes. The observer is level: only the head
    tilts the picture.
    """
    viewports: list[Rect] = []
    left = 0
    for width, height in sizes:
        viewports.append((left, 0, width, height))
        left += width
    shown = _cropped(viewports[0], mirror)
    patches = [DisplayPatch((0, 0, *mirror), shown, shown)]
    for number, viewport in enumerate(viewports):
        place = (0, 0, *viewport[2:])
        patches.append(DisplayPatch(place, viewport, viewport, output=1 + number))
    canvas = left, max(height for _, height in sizes)
    return CameraRig(
        canvas, (mirror, *sizes), head_eyes(eyes, viewports), tuple(patches), True, main=0
    )


def _cropped(viewport: Rect, shape: tuple[int, int]) -> Rect:
    """The largest part of a viewport with the aspect of `shape`, in its middle."""
    x, y, width, height = viewport
    across = min(width, max(round(height * shape[0] / shape[1]), 1))
    up = min(height, max(round(width * shape[1] / shape[0]), 1))
    return x + (width - across) // 2, y + (height - up) // 2, across, up


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
    vertices = np.concatenate([shares, source, source], axis=1)
    warp = Warp(vertices, grid_triangles(COLUMNS + 1, ROWS + 1))
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
