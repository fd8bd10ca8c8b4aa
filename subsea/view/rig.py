"""What a rig is: the eyes that a display or a theatre needs, and how their pictures are shown.

Every eye draws its view into its part of one *canvas*. *Patches* take parts of the canvas to the
pictures that are shown, the outputs: one for each window or projector. A rig is constant for a
display at a size; only the observer from whom its eyes hang moves.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.view.camera import View, look

Rect = tuple[int, int, int, int]  # x, y, width, height in pixels, origin lower left

BRIGHT = 0.995  # of a mask's largest factor: less is where another projector shines too
FINE = 100  # values a side of a mask that are asked at least, if there are so many


class CameraPose(NamedTuple):
    """Where an observer is and how it looks."""

    eye: Array  # (3,) cm
    forward: Array  # (3,) unit
    up: Array  # (3,) unit


class Eye(NamedTuple):
    """A view as it hangs on the observer, whose axes are right, up, ahead."""

    viewport: Rect  # on the canvas
    offset: Array  # (3,) cm
    axes: Array  # (3, 3) rows: the view's own right, up, ahead
    projection: Array  # (4, 4)


class Weave(IntEnum):
    """How two eyes share the pixels of a patch; the numbers are those of `shaders/resolve.frag`."""

    PLAIN = 0  # the left one has them all
    ROWS = 1  # left and right in turn, the topmost row of the output is left
    CHECKERS = 2  # the same within each row, the upper left pixel is left
    RED_CYAN = 3  # red from the left eye, green and blue from the right
    DUBOIS = 4  # the same with colours mixed so that both eyes see about the same brightness


class Projection(IntEnum):
    """What a pixel of a patch shows; the numbers are those of `shaders/resolve.frag`."""

    FLAT = 0  # the same place of the source
    WARPED = 1  # what a mesh says
    EQUIRECTANGULAR = 2  # a direction, from the faces of a cube, as the next two
    DOME = 3
    PANORAMA = 4


CUBES = (Projection.EQUIRECTANGULAR, Projection.DOME, Projection.PANORAMA)


class Warp(NamedTuple):
    """A mesh that lies over a patch and says where on the canvas each of its points is seen."""

    # (n, 6): x, y in shares of the place from its lower left corner; u, v in shares of the left
    # eye's source, u, v in shares of the right one's
    vertices: Array
    triangles: Ints  # (m, 3)


class DisplayPatch(NamedTuple):
    """A part of an output, and how it is taken from the canvas."""

    place: Rect  # on the output
    left: Rect  # on the canvas: what the left eye, or the only one, drew; of a cube all its faces
    right: Rect  # the same for the right eye
    weave: Weave = Weave.PLAIN
    shape: Projection = Projection.FLAT
    wide: tuple[float, float] = (0.0, 0.0)  # rad: angle of a panorama, tilt of a dome
    squeezed: tuple[float, float] = (1.0, 1.0)  # how many times narrower and lower it is shown
    apart: float = 0.0  # of cubes: half the eyes' separation over the distance of the screen
    output: int = 0
    page: int = 0  # 1: the right buffer of an output that has two
    # Of Shape.WARPED; or of those that show all round: u, v are shares of the wide picture then,
    # of a dome of its square.
    warp: Warp | None = None
    # (h, w, 4), stretched over the place, top row first: factors of red, green and blue, and what
    # is added then, on the values that go to the projector; None: left as they are.
    mask: Array | None = None
    channel: int = 0  # the projector, or screen: both eyes' patches of one have the same


class CameraRig(NamedTuple):
    """What is drawn, and what is shown of it."""

    canvas: tuple[int, int]  # width, height in pixels
    outputs: tuple[tuple[int, int], ...]
    eyes: tuple[Eye, ...]
    patches: tuple[DisplayPatch, ...]
    level: bool = False  # the horizon stays level, whatever the submarine's pitch

    @property
    def exact(self) -> bool:
        """Whether pixels of the canvas and of outputs must meet one by one."""
        return any(
            patch.weave in (Weave.ROWS, Weave.CHECKERS) or patch.shape in CUBES
            for patch in self.patches
        )

    @property
    def pages(self) -> int:
        """How many buffers an output has."""
        return 1 + max(patch.page for patch in self.patches)


def front(rig: CameraRig) -> DisplayPatch:
    """The patch whose middle is most straight ahead; of several the first."""
    return max(rig.patches, key=lambda patch: max(map(_ahead, seen_by(rig, patch)), default=-1.0))


def seen_part(patch: DisplayPatch) -> Rect:
    """The rectangle of a patch's place in which all is seen as it is, in pixels of the output.

    Of a dome the largest within its circle, else what no other projector blends into. What a mesh
    makes of a place is not known: that is left as it is.
    """
    x, y, width, height = patch.place
    if patch.shape != Projection.DOME or patch.warp is not None:
        return patch.place if patch.mask is None else _unblended(patch, patch.mask)
    sides = width * patch.squeezed[0], height * patch.squeezed[1]
    square = min(sides) / np.sqrt(2.0)
    across, up = (max(int(square / by), 1) for by in patch.squeezed)
    return x + (width - across) // 2, y + (height - up) // 2, across, up


def seen_by(rig: CameraRig, patch: DisplayPatch) -> list[Eye]:
    """The eyes that draw what a patch shows, of a stereo one those of the left eye first."""
    return [
        eye for part in (patch.left, patch.right) for eye in rig.eyes if _meet(eye.viewport, part)
    ]


def limit_separation(rig: CameraRig, half_cm: float) -> CameraRig:
    """The same rig with eyes at most `half_cm` from the observer, as if that had shrunk.

    Its screens, which the projections know by their angles alone, have shrunk with it: what is a
    tenth as far for eyes a tenth as far apart is seen as before.
    """
    widest = max(float(np.linalg.norm(eye.offset)) for eye in rig.eyes)
    if widest <= half_cm:
        return rig
    share = half_cm / widest
    return rig._replace(eyes=tuple(eye._replace(offset=share * eye.offset) for eye in rig.eyes))


def select_outputs(rig: CameraRig, outputs: Sequence[int]) -> CameraRig:
    """The same rig with only these outputs, in this order, and the eyes that they need."""
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
    """A pose from the angles in radians: heading left positive from +x, pitch up positive."""
    ch, sh, cp, sp = np.cos(heading), np.sin(heading), np.cos(pitch), np.sin(pitch)
    return CameraPose(
        np.asarray(eye, np.float64),
        np.array([ch * cp, sh * cp, sp]),
        np.array([-ch * sp, -sh * sp, cp]),
    )


def levelled(observer: CameraPose) -> CameraPose:
    """The same observer with the head upright, looking level."""
    heading = float(np.arctan2(observer.forward[1], observer.forward[0]))
    return pose_from_angles(observer.eye, heading, 0.0)


def views(rig: CameraRig, observer: CameraPose) -> tuple[View, ...]:
    """The views of a rig's eyes from where the observer is now, in their order."""
    if rig.level:
        observer = levelled(observer)
    axes = np.stack([np.cross(observer.forward, observer.up), observer.up, observer.forward])
    found = []
    for eye in rig.eyes:
        place = observer.eye + eye.offset @ axes
        forward, up = eye.axes[2] @ axes, eye.axes[1] @ axes
        found.append(View(eye.viewport, look(place, forward, up), eye.projection, place))
    return tuple(found)


def _unblended(patch: DisplayPatch, mask: Array) -> Rect:
    """The part of a patch's place that it has to itself: nothing blends in there, or is masked.

    Where that is less than a third a side no part is better than another: the whole place.
    """
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
    """Cosine of the angle between the middle of an eye's picture and straight ahead."""
    p = eye.projection
    middle = np.array([p[0, 2] / p[0, 0], p[1, 2] / p[1, 1], 1.0]) @ eye.axes
    return float(middle[2] / np.linalg.norm(middle))


def _meet(a: Rect, b: Rect) -> bool:
    """Whether two rectangles have pixels in common."""
    return all(
        low < other + long and other < low + size
        for low, size, other, long in zip(a[:2], a[2:], b[:2], b[2:], strict=True)
    )
