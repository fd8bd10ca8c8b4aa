"""Rigs: from where the submarine is to the list of views that a display needs."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.state import Submarine
from subsea.view.camera import NEAR_CM, View, look, off_axis
from subsea.view.stereo import EYES, LAYOUTS, Stereo, canvas_size
from subsea.view.surround import ALL_ROUND, COLUMNS, FACES, Surround, half_tangent

Array = NDArray[np.floating[Any]]

LEVEL = ("equirectangular", "dome")  # displays whose horizon stays level

VERTICAL_FOV = np.radians(55.0)
WINDOW_AHEAD_CM = 20.0  # the eye sits this far before the hull's centre


class Pose(NamedTuple):
    """Where an observer is and how it looks."""

    eye: Array  # (3,) cm
    forward: Array  # (3,) unit
    up: Array  # (3,) unit


def pose(eye: Array, heading: float, pitch: float) -> Pose:
    """A pose from the angles in radians: heading left positive from +x, pitch up positive."""
    ch, sh, cp, sp = np.cos(heading), np.sin(heading), np.cos(pitch), np.sin(pitch)
    return Pose(
        np.asarray(eye, np.float64),
        np.array([ch * cp, sh * cp, sp]),
        np.array([-ch * sp, -sh * sp, cp]),
    )


def cockpit(submarine: Submarine, alpha: float) -> Pose:
    """The pilot's eye, `alpha` of the way from the last tick to the present one."""
    position = submarine.previous_position + alpha * (
        submarine.position - submarine.previous_position
    )
    turn = submarine.angles - submarine.previous_angles
    turn[0] = (turn[0] + np.pi) % (2 * np.pi) - np.pi
    heading, pitch = submarine.previous_angles + alpha * turn
    looking = pose(position, float(heading), float(pitch))
    return looking._replace(eye=position + WINDOW_AHEAD_CM * looking.forward)


def views_for(
    display: str,
    size: tuple[int, int],
    observer: Pose,
    stereo: Stereo = EYES,
    surround: Surround = ALL_ROUND,
) -> tuple[View, ...]:
    """The views of a display mode for a picture of `size` pixels (width, height).

    Their viewports lie on the mode's canvas (`stereo.canvas_size`), the left eye's comes first.
    A picture of all directions keeps its horizon level, whatever the submarine's pitch.
    """
    width, height = canvas_size(display, size, surround)
    if LAYOUTS[display].eyes == "cube":
        return _cube(width // COLUMNS, levelled(observer) if display in LEVEL else observer)
    # Where both eyes share the picture each is stretched over it, so the picture's aspect counts.
    aspect = size[0] / size[1]
    eyes = LAYOUTS[display].eyes
    if eyes == "one":
        return (_eye_view((0, 0, width, height), aspect, observer, 0.0, stereo),)
    if eyes == "beside":
        left, right = (0, 0, width // 2, height), (width // 2, 0, width - width // 2, height)
    else:
        left, right = (0, height // 2, width, height - height // 2), (0, 0, width, height // 2)
    window = 2.0 * stereo.screen_cm * aspect * np.tan(VERTICAL_FOV / 2)
    half = stereo.eyes(float(window)) / 2 * (-1 if stereo.swapped else 1)
    return (
        _eye_view(left, aspect, observer, -half, stereo),
        _eye_view(right, aspect, observer, half, stereo),
    )


def levelled(observer: Pose) -> Pose:
    """The same observer with the head upright, looking level."""
    heading = float(np.arctan2(observer.forward[1], observer.forward[0]))
    return pose(observer.eye, heading, 0.0)


def _cube(face: int, observer: Pose) -> tuple[View, ...]:
    """A view through each face of a cube about the observer."""
    axes = np.stack([np.cross(observer.forward, observer.up), observer.up, observer.forward])
    edge = NEAR_CM * half_tangent(face)
    projection = off_axis(-edge, edge, -edge, edge)
    return tuple(
        View(
            (number % COLUMNS * face, number // COLUMNS * face, face, face),
            look(observer.eye, np.array(forward) @ axes, np.array(up) @ axes),
            projection,
            observer.eye,
        )
        for number, (forward, up) in enumerate(FACES)
    )


def _eye_view(
    viewport: tuple[int, int, int, int],
    aspect: float,
    observer: Pose,
    offset: float,
    stereo: Stereo,
) -> View:
    """An eye `offset` cm right of the observer; its frustum leans back to the common screen."""
    side = np.cross(observer.forward, observer.up)
    eye = observer.eye + offset * side
    top = NEAR_CM * np.tan(VERTICAL_FOV / 2)
    lean = -offset * NEAR_CM / stereo.screen_cm
    projection = off_axis(lean - aspect * top, lean + aspect * top, -top, top)
    return View(viewport, look(eye, observer.forward, observer.up), projection, eye)
