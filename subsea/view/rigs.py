"""Rigs: from where the submarine is to the list of views that a display needs."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.state import Submarine
from subsea.view.camera import NEAR_CM, View, look, off_axis

Array = NDArray[np.floating[Any]]

DISPLAYS = ("mono", "side-by-side", "top-bottom")

VERTICAL_FOV = np.radians(55.0)
EYE_SEPARATION_CM = 6.4
SCREEN_DISTANCE_CM = 120.0  # where both eyes' pictures coincide
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


def views_for(display: str, size: tuple[int, int], observer: Pose) -> tuple[View, ...]:
    """The views of a display mode for a picture of `size` pixels (width, height)."""
    width, height = size
    if display == "mono":
        return (_eye_view((0, 0, width, height), width / height, observer, 0.0),)
    half = EYE_SEPARATION_CM / 2
    if display == "side-by-side":
        left, right = (0, 0, width // 2, height), (width // 2, 0, width - width // 2, height)
    elif display == "top-bottom":
        left, right = (0, height // 2, width, height - height // 2), (0, 0, width, height // 2)
    else:
        raise ValueError(f"no rig for display {display!r}")
    # Each eye's half is stretched over the whole screen, so the screen's aspect counts.
    aspect = width / height
    return (
        _eye_view(left, aspect, observer, -half),
        _eye_view(right, aspect, observer, half),
    )


def _eye_view(
    viewport: tuple[int, int, int, int], aspect: float, observer: Pose, offset: float
) -> View:
    """An eye `offset` cm right of the observer; its frustum leans back to the common screen."""
    side = np.cross(observer.forward, observer.up)
    eye = observer.eye + offset * side
    top = NEAR_CM * np.tan(VERTICAL_FOV / 2)
    lean = -offset * NEAR_CM / SCREEN_DISTANCE_CM
    projection = off_axis(lean - aspect * top, lean + aspect * top, -top, top)
    return View(viewport, look(eye, observer.forward, observer.up), projection, eye)
