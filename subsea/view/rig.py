"""Camera rigs: the eyes of a display or theatre, and the mapping of their pictures to outputs.

Each eye draws into its viewport on one *canvas*. *Patches* copy parts of the canvas to *outputs*,
one for each window or projector. A rig is constant for a display at a size; only the observer that
carries its eyes moves.
"""

import math
from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.view.adjustment import PatchAdjustment
from subsea.view.camera import View, cross, look
from subsea.view.theatre_vessel import TheatreVessel

Rect = tuple[int, int, int, int]  # x, y, width, height in pixels, origin lower left

BRIGHT = 0.995  # share of a mask's largest factor below which another projector blends in
FINE = 100  # least number of mask values sampled per side


class CameraPose(NamedTuple):
    """Position and orientation of an observer."""

    eye: Array  # (3,) cm
    forward: Array  # (3,) unit
    up: Array  # (3,) unit

    @property
    def axes(self) -> Array:
        """Rows right, up, ahead (3, 3)."""
        ahead, above = (np.asarray(way, np.float64).tolist() for way in (self.forward, self.up))
        return np.array([cross(ahead, above), above, ahead])


class Eye(NamedTuple):
    """A camera mounted on an observer with the axes right, up, ahead."""

    viewport: Rect  # on the canvas
    offset: Array  # (3,) cm
    axes: Array  # (3, 3) rows: right, up, ahead of the camera
    projection: Array  # (4, 4)


class Weave(IntEnum):
    """Arrangement of two eyes in the pixels of a patch; values as in `shaders/resolve.frag`."""

    PLAIN = 0  # left eye only
    ROWS = 1  # alternating rows, the topmost row of the output is left
    CHECKERS = 2  # checkerboard, the upper left pixel is left
    RED_CYAN = 3  # red from the left eye, green and blue from the right
    DUBOIS = 4  # likewise, with colours mixed for equal brightness


class Projection(IntEnum):
    """Mapping from pixels of a patch to its source; values as in `shaders/resolve.frag`."""

    FLAT = 0  # linearly
    WARPED = 1  # by a mesh
    EQUIRECTANGULAR = 2  # from the faces of a cube, as the next two
    DOME = 3
    PANORAMA = 4


CUBES = (Projection.EQUIRECTANGULAR, Projection.DOME, Projection.PANORAMA)


class Warp(NamedTuple):
    """A mesh over a patch with texture coordinates in its sources."""

    # (n, 6): x, y as shares of the place from its lower left corner; u, v as shares of the left
    # source; u, v as shares of the right source
    vertices: Array
    triangles: Ints  # (m, 3)


class DisplayPatch(NamedTuple):
    """A part of an output, and its source on the canvas."""

    place: Rect  # on the output
    left: Rect  # on the canvas: source of the left or only eye, or all faces of a cube
    right: Rect  # the same for the right eye
    weave: Weave = Weave.PLAIN
    shape: Projection = Projection.FLAT
    # rad: angle of a panorama, tilt and angle of a dome
    wide: tuple[float, float, float] = (0.0, 0.0, math.pi)
    squeezed: tuple[float, float] = (1.0, 1.0)  # factors by which it is shown narrower and lower
    apart: float = 0.0  # of cubes: half the eye separation over the screen distance
    output: int = 0
    page: int = 0  # 1: the right buffer of an output that has two
    # For Projection.WARPED; or for surround projections, with u, v as shares of the wide picture,
    # or of the square of a dome.
    warp: Warp | None = None
    # (h, w, 4), top row first, stretched over the place: factors on the values of red, green and
    # blue that are sent to the projector, and light that is added to theirs; None: no mask.
    mask: Array | None = None
    gamma: float = 2.2  # of the projector: light is the value to this power
    channel: int = 0  # index of the projector or screen, the same for both eyes
    adjustment: PatchAdjustment | None = None  # how it lies on the output; None: straight


class CameraRig(NamedTuple):
    """The canvas, its eyes, and the patches on the outputs."""

    canvas: tuple[int, int]  # width, height in pixels
    outputs: tuple[tuple[int, int], ...]
    eyes: tuple[Eye, ...]
    patches: tuple[DisplayPatch, ...]
    level: bool = False  # keep the horizon level
    main: int | None = None  # index of the patch with text; None: the one ahead
    vessel: TheatreVessel | None = None  # drawn around the observer in every view

    @property
    def exact(self) -> bool:
        """True if pixels of the canvas must match pixels of the outputs."""
        return any(
            patch.weave in (Weave.ROWS, Weave.CHECKERS) or patch.shape in CUBES
            for patch in self.patches
        )

    @property
    def pixels(self) -> tuple[object, ...]:
        """Sizes of canvas and outputs: rigs with equal ones can share their pictures."""
        return self.canvas, self.outputs, self.pages, self.exact

    @property
    def pages(self) -> int:
        """The number of buffers of an output."""
        return 1 + max(patch.page for patch in self.patches)


def front(rig: CameraRig) -> DisplayPatch:
    """The patch with text: the main one, else the first whose centre is closest to ahead."""
    if rig.main is not None:
        return rig.patches[rig.main]
    return max(rig.patches, key=lambda patch: max(map(_ahead, seen_by(rig, patch)), default=-1.0))


def seen_part(patch: DisplayPatch) -> Rect:
    """The rectangle of a patch that is fully visible, in pixels of the output.

    The largest in the circle of a dome, otherwise the part that no other projector blends into.
    Warps are ignored.
    """
    x, y, width, height = patch.place
    if patch.shape != Projection.DOME or patch.warp is not None:
        return patch.place if patch.mask is None else _unblended(patch, patch.mask)
    sides = width * patch.squeezed[0], height * patch.squeezed[1]
    square = min(sides) / np.sqrt(2.0)
    across, up = (max(int(square / by), 1) for by in patch.squeezed)
    return x + (width - across) // 2, y + (height - up) // 2, across, up


def seen_by(rig: CameraRig, patch: DisplayPatch) -> list[Eye]:
    """The eyes that a patch shows, left ones first."""
    return [
        eye for part in (patch.left, patch.right) for eye in rig.eyes if overlap(eye.viewport, part)
    ]


def limit_separation(rig: CameraRig, half_cm: float) -> CameraRig:
    """Scale the eye offsets of a rig to at most `half_cm` from the middle of the eyes.

    Projections depend only on angles, so the screens scale too: something at a tenth of the
    distance looks the same to eyes a tenth as far apart.
    """
    middle = np.mean([eye.offset for eye in rig.eyes], axis=0)  # a head may have moved
    widest = max(float(np.linalg.norm(eye.offset - middle)) for eye in rig.eyes)
    if widest <= half_cm:
        return rig
    share = half_cm / widest
    return rig._replace(eyes=tuple(eye._replace(offset=share * eye.offset) for eye in rig.eyes))


def select_outputs(rig: CameraRig, outputs: Sequence[int]) -> CameraRig:
    """The rig with only these outputs, in this order, and the eyes that they need."""
    patches = tuple(
        patch._replace(output=outputs.index(patch.output))
        for patch in rig.patches
        if patch.output in outputs
    )
    needed = {id(eye) for patch in patches for eye in seen_by(rig, patch)}
    return rig._replace(
        outputs=tuple(rig.outputs[number] for number in outputs),
        eyes=tuple(eye for eye in rig.eyes if id(eye) in needed),
        patches=patches,
    )


def pose_from_angles(eye: Array, heading: float, pitch: float) -> CameraPose:
    """A pose from angles in radians: heading from +x to the left, pitch upward."""
    ch, sh, cp, sp = np.cos(heading), np.sin(heading), np.cos(pitch), np.sin(pitch)
    return CameraPose(
        np.asarray(eye, np.float64),
        np.array([ch * cp, sh * cp, sp]),
        np.array([-ch * sp, -sh * sp, cp]),
    )


def levelled(observer: CameraPose) -> CameraPose:
    """The pose without pitch and roll."""
    heading = float(np.arctan2(observer.forward[1], observer.forward[0]))
    return pose_from_angles(observer.eye, heading, 0.0)


def views(rig: CameraRig, observer: CameraPose) -> tuple[View, ...]:
    """The views of a rig's eyes for an observer."""
    if rig.level:
        observer = levelled(observer)
    axes = observer.axes
    seen = []
    for eye in rig.eyes:
        place = observer.eye + eye.offset @ axes
        forward, up = eye.axes[2] @ axes, eye.axes[1] @ axes
        seen.append(View(eye.viewport, look(place, forward, up), eye.projection, place))
    return tuple(seen)


def _unblended(patch: DisplayPatch, mask: Array) -> Rect:
    """The part of a patch without blending, or all if that is less than a third of a side."""
    x, y, width, height = patch.place
    factor = mask[..., :3].min(axis=2)
    factor = factor[:: max(factor.shape[0] // FINE, 1), :: max(factor.shape[1] // FINE, 1)]
    shared = factor < BRIGHT * factor.max()
    rows, columns = shared.shape
    top, bottom, left, right = 0, rows, 0, columns
    while (rest := shared[top:bottom, left:right]).any():
        worst = np.argmax([edge.mean() for edge in (rest[0], rest[-1], rest[:, 0], rest[:, -1])])
        top, bottom = top + (worst == 0), bottom - (worst == 1)
        left, right = left + (worst == 2), right - (worst == 3)
    if right - left < columns / 3 or bottom - top < rows / 3:
        return patch.place
    near, far = -(-left * width // columns), right * width // columns
    low, high = -(-(rows - bottom) * height // rows), (rows - top) * height // rows
    return int(x + near), int(y + low), int(far - near), int(high - low)


def _ahead(eye: Eye) -> float:
    """Cosine of the angle between the centre of an eye's picture and straight ahead."""
    p = eye.projection
    middle = np.array([p[0, 2] / p[0, 0], p[1, 2] / p[1, 1], 1.0]) @ eye.axes
    return float(middle[2] / np.linalg.norm(middle))


def overlap(a: Rect, b: Rect) -> bool:
    """True if two rectangles share a pixel."""
    return all(a[k] < b[k] + b[k + 2] and b[k] < a[k] + a[k + 2] for k in (0, 1))


LEAST_AREA = 1e-12  # of a triangle that lights nothing


def sources_at(warp: Warp, places: Array, eye: int = 0) -> Array:
    """Sources (k, 2) at places (k, 2) for the left or right eye; NaN where dark."""
    shown = warp.vertices[:, 2 + 2 * eye : 4 + 2 * eye]
    return carried(warp.vertices[:, :2], shown, warp.triangles, places)


def carried(start: Array, end: Array, triangles: Ints, points: Array) -> Array:
    """Carry points (k, 2) by the triangles from their corners in `start` to those in `end`."""
    points = np.asarray(points, np.float64)
    from_, to = (side.astype(np.float64)[triangles] for side in (start, end))  # (m, 3, 2)
    a, across, up = from_[:, 0], from_[:, 1] - from_[:, 0], from_[:, 2] - from_[:, 0]
    area = across[:, 0] * up[:, 1] - across[:, 1] * up[:, 0]
    real = np.abs(area) > 2 * LEAST_AREA
    a, across, up, area, to = a[real], across[real], up[real], area[real], to[real]
    found = np.full(points.shape, np.nan)
    for number, point in enumerate(points):
        x, y = (point - a).T
        s = (x * up[:, 1] - y * up[:, 0]) / area
        t = (across[:, 0] * y - across[:, 1] * x) / area
        worst = np.minimum(np.minimum(s, t), 1 - s - t)
        if len(worst) and worst[best := int(np.argmax(worst))] > -1e-6:
            weights = np.array([1 - s[best] - t[best], s[best], t[best]])
            found[number] = weights @ to[best]
    return found
