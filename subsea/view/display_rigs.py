"""Camera rigs of the display modes: mono, stereo and surround."""

from typing import TYPE_CHECKING, Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError, unknown
from subsea.base.registry import VIEWS, load_named
from subsea.view.camera import NEAR_CM, View, off_axis
from subsea.view.rig import (
    CameraPose,
    CameraRig,
    DisplayPatch,
    Eye,
    Projection,
    Rect,
    pose_from_angles,
    views,
)
from subsea.view.stereo import EYES, LAYOUTS, Stereo, canvas_of, halves, patches_of
from subsea.view.surround import (
    ALL_ROUND,
    COLUMNS,
    FACES,
    MARGIN_PX,
    ROWS,
    Surround,
    face_size,
    half_tangent,
    visible_parts,
)

if TYPE_CHECKING:  # display modes are needed before any world is loaded
    from subsea.state import Submarine


SURROUNDS = {
    "panorama": Projection.PANORAMA,
    "dome": Projection.DOME,
    "equirectangular": Projection.EQUIRECTANGULAR,
}
LEVEL = ("equirectangular", "dome")  # displays with a level horizon
DISPLAYS = ("mono", *LAYOUTS, *SURROUNDS)
HEADSET = "headset"  # only in a dive: its rig is that of the headset (`stage.headset.head`)

AHEAD = np.eye(3)  # axes of an eye that looks as the observer does
VERTICAL_FOV = np.radians(55.0)
WINDOW_AHEAD_CM = 20.0  # from the hull's centre to the eye


def check_display(name: str) -> str:
    """Return the name of a display mode; raise UserError for any other."""
    if name not in (*DISPLAYS, HEADSET):
        raise unknown("display", name, [*DISPLAYS, HEADSET])
    return name


def cockpit(submarine: "Submarine", alpha: float) -> CameraPose:
    """The pilot's pose, `alpha` of the way from the last tick to the current one."""
    position = submarine.previous_position + alpha * (
        submarine.position - submarine.previous_position
    )
    turn = submarine.angles - submarine.previous_angles
    turn[0] = (turn[0] + np.pi) % (2 * np.pi) - np.pi
    heading, pitch = submarine.previous_angles + alpha * turn
    looking = pose_from_angles(position, float(heading), float(pitch))
    return looking._replace(eye=position + WINDOW_AHEAD_CM * looking.forward)


def display_rig(
    display: str, size: tuple[int, int], stereo: Stereo = EYES, surround: Surround = ALL_ROUND
) -> CameraRig:
    """The rig of a display for a picture of `size` (width, height) pixels, the left eye first."""
    place: Rect = (0, 0, *size)
    if display in SURROUNDS:
        face = face_size(display, size, surround)
        canvas = COLUMNS * face, ROWS * face
        patch = DisplayPatch(
            place, (0, 0, *canvas), (0, 0, *canvas), shape=SURROUNDS[display], wide=surround.wide
        )
        eyes = cube((0, 0), face, visible_parts(display, size, surround))
        return CameraRig(canvas, (size,), eyes, (patch,), level=display in LEVEL)
    # Each eye is stretched over the whole picture, so the picture's aspect counts.
    aspect = size[0] / size[1]
    if display == "mono":
        eye = _eye(place, aspect, 0.0, stereo)
        return CameraRig(size, (size,), (eye,), (DisplayPatch(place, place, place),))
    layout = LAYOUTS[display]
    canvas = canvas_of(layout, size)
    whole: Rect = (0, 0, *canvas)
    window = 2.0 * stereo.screen_cm * aspect * np.tan(VERTICAL_FOV / 2)
    half = stereo.eyes(float(window)) / 2 * (-1 if stereo.swapped else 1)
    left, right = halves(whole, layout.beside)
    return CameraRig(
        canvas,
        (size,),
        (_eye(left, aspect, -half, stereo), _eye(right, aspect, half, stereo)),
        patches_of(layout, DisplayPatch(place, left, right)),
    )


def chosen_rig(
    display: str, size: tuple[int, int], stereo: Stereo = EYES, surround: Surround = ALL_ROUND,
    theatre: str | None = None, shrink: int = 1,
) -> tuple[CameraRig, tuple[str, ...]]:  # fmt: skip
    """The rig of a theatre, or of a display mode if none is named; and names of its outputs.

    `size` is that of the one picture of a display mode; width and height of a theatre's windows are
    divided by `shrink`. A single output is called "".
    """
    if theatre is not None:
        rig: CameraRig
        rig, names = _theatres().named_rig(theatre, display, stereo, shrink)
        return rig, names
    if shrink != 1:
        raise UserError("--shrink needs --theatre; give a smaller --size instead")
    return display_rig(display, size, stereo, surround), ("",)


def theatre_digest(theatre: str | None) -> str | None:
    """A digest of all files of a theatre; None without one."""
    digest: str | None = None if theatre is None else _theatres().theatre_digest(theatre)
    return digest


def _theatres() -> Any:
    return load_named(VIEWS, "theatre", "kind of view")


def views_for(
    display: str, size: tuple[int, int], observer: CameraPose, stereo: Stereo = EYES
) -> tuple[View, ...]:
    """The views of the `display_rig` of an observer."""
    return views(display_rig(display, size, stereo), observer)


def cube(
    corner: tuple[int, int], face: int, shown: list[Array | None], offset: Array | None = None
) -> tuple[Eye, ...]:
    """Eyes through the `shown` parts (and a margin) of the faces of a cube on the canvas."""
    eyes, half = [], half_tangent(face)
    for number, (part, (forward, up)) in enumerate(zip(shown, FACES.values(), strict=True)):
        if part is None:
            continue
        pixels = face / 2 * (1.0 + part / half)  # from the face's lower left corner
        low, high = np.floor(pixels[::2]) - MARGIN_PX, np.ceil(pixels[1::2]) + MARGIN_PX
        low, high = np.maximum(low, 0).astype(int), np.minimum(high, face).astype(int)
        left, bottom = NEAR_CM * half * (2.0 * low / face - 1.0)
        right, top = NEAR_CM * half * (2.0 * high / face - 1.0)
        x = corner[0] + number % COLUMNS * face + int(low[0])
        y = corner[1] + number // COLUMNS * face + int(low[1])
        axes = np.array([np.cross(up, forward), up, forward])
        eyes.append(
            Eye(
                (x, y, int(high[0] - low[0]), int(high[1] - low[1])),
                np.zeros(3) if offset is None else offset,
                axes,
                off_axis(float(left), float(right), float(bottom), float(top)),
            )
        )
    return tuple(eyes)


def _eye(viewport: Rect, aspect: float, offset: float, stereo: Stereo) -> Eye:
    """An eye `offset` cm right of the observer, with an off-axis frustum to the common screen."""
    top = NEAR_CM * np.tan(VERTICAL_FOV / 2)
    lean = -offset * NEAR_CM / stereo.screen_cm
    projection = off_axis(lean - aspect * top, lean + aspect * top, -top, top)
    return Eye(viewport, np.array([offset, 0.0, 0.0]), AHEAD, projection)
