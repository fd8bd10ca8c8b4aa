"""Geometry of screens: points, rays from an eye, and frusta.

Points are (right, up, ahead) of the middle of the eyes, in centimetres; places on a screen are
shares (s, t) of its width and height from the lower left corner.
"""

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.stage.theatre.theatre_file import Angles, Cylinder, Plane
from subsea.view.camera import axes_of

STEEPEST = math.tan(math.radians(82.0))  # of rays to the edge of a frustum, against its axis
SQUARE = 0.01  # largest cosine between edges that count as perpendicular


class Flat(NamedTuple):
    """A rectangle."""

    corner: Array  # (3,) lower left
    along: Array  # (3,) to the lower right corner
    up: Array  # (3,) to the upper left corner


class Curved(NamedTuple):
    """A part of an upright cylinder, seen from within."""

    axis: tuple[float, float]  # right, ahead
    radius: float
    left: float  # rad from straight ahead, right positive
    right: float
    bottom: float
    top: float


Screen: TypeAlias = Flat | Curved


class Frustum(NamedTuple):
    """A planar view that takes in a screen."""

    axes: Array  # (3, 3) rows: its own right, up, ahead
    edges: tuple[float, float, float, float]  # left, right, bottom, top at unit distance


def screen_of(table: Plane | Cylinder | Angles, eye: Array, scale: float) -> Screen:
    """The screen of a table, seen from `eye` (3,), in cm of the sea; else a UserError."""
    if isinstance(table, Cylinder):
        if not 0.0 < table.right_deg - table.left_deg <= 360.0:
            raise UserError("`cylinder`: expected `left_deg` less than `right_deg`, within a turn")
        if table.bottom_cm >= table.top_cm:
            raise UserError("`cylinder`: expected `bottom_cm` less than `top_cm`")
        axis = np.array(table.axis_cm) - eye[[0, 2]]
        if math.hypot(*axis) >= table.radius_cm:
            raise UserError("`cylinder`: the eye is outside of it, expected inside")
        return Curved(
            (float(scale * axis[0]), float(scale * axis[1])),
            scale * table.radius_cm,
            math.radians(table.left_deg),
            math.radians(table.right_deg),
            scale * (table.bottom_cm - float(eye[1])),
            scale * (table.top_cm - float(eye[1])),
        )
    if isinstance(table, Angles):
        return _under_angles(table, scale)
    corner, right, upper = (
        scale * (np.array(point) - eye)
        for point in (table.lower_left, table.lower_right, table.upper_left)
    )
    along, up = right - corner, upper - corner
    width, height = np.linalg.norm(along), np.linalg.norm(up)
    if min(width, height) < 1e-3:
        raise UserError("`plane`: two corners are one point, expected three apart")
    if abs(along @ up) > SQUARE * width * height:
        raise UserError("`plane`: the corners make no right angle at `lower_left`")
    # Make it exactly perpendicular; this changes it by a hundredth at most.
    return Flat(corner, along, up - (up @ along) / width**2 * along)


def _under_angles(table: Angles, scale: float) -> Flat:
    """The flat screen seen under these angles, turned by heading, pitch and roll."""
    if table.left_deg >= table.right_deg or table.down_deg >= table.up_deg:
        raise UserError(
            "`angles`: expected `left_deg` less than `right_deg`, `down_deg` less than `up_deg`"
        )
    turn = np.radians([table.heading_deg, table.pitch_deg, table.roll_deg])
    right, up, ahead = axes_of(*turn)
    far = scale * table.distance_cm
    left_edge, right_edge, down, top = far * np.tan(
        np.radians([table.left_deg, table.right_deg, table.down_deg, table.up_deg])
    )
    corner = far * ahead + left_edge * right + down * up
    return Flat(corner, (right_edge - left_edge) * right, (top - down) * up)


def part_of(screen: Screen, place: tuple[float, float, float, float]) -> Screen:
    """The part of a screen at x, y, width, height in shares of it."""
    x, y, width, height = place
    if isinstance(screen, Flat):
        corner = screen.corner + x * screen.along + y * screen.up
        return Flat(corner, width * screen.along, height * screen.up)
    turn, rise = screen.right - screen.left, screen.top - screen.bottom
    left, bottom = screen.left + x * turn, screen.bottom + y * rise
    return screen._replace(
        left=left, right=left + width * turn, bottom=bottom, top=bottom + height * rise
    )


def points_on(screen: Screen, places: Array) -> Array:
    """The points (n, 3) at shares (n, 2) of a screen."""
    s, t = np.asarray(places, np.float64).T
    if isinstance(screen, Flat):
        return np.asarray(screen.corner + s[:, None] * screen.along + t[:, None] * screen.up)
    angle = screen.left + s * (screen.right - screen.left)
    x = screen.axis[0] + screen.radius * np.sin(angle)
    y = screen.bottom + t * (screen.top - screen.bottom)
    return np.column_stack([x, y, screen.axis[1] + screen.radius * np.cos(angle)])


def places_on(screen: Screen, rays: Array) -> Array:
    """Places (n, 2) where rays (n, 3) from the eyes meet a screen or its extension; else NaN."""
    rays = np.asarray(rays, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        if isinstance(screen, Flat):
            corner, along, up = screen
            normal = np.cross(along, up)
            reach = (corner @ normal) / (rays @ normal)
            met = np.where(reach > 0.0, reach, np.nan)[:, None] * rays - corner
            return np.column_stack([met @ along / (along @ along), met @ up / (up @ up)])
        x, z = rays[:, 0], rays[:, 2]
        a, b = x**2 + z**2, x * screen.axis[0] + z * screen.axis[1]
        c = screen.axis[0] ** 2 + screen.axis[1] ** 2 - screen.radius**2
        reach = (b + np.sqrt(b**2 - a * c)) / a  # the eye is within: one root is ahead
        met = reach[:, None] * rays
        angle = np.arctan2(met[:, 0] - screen.axis[0], met[:, 2] - screen.axis[1])
        middle = (screen.left + screen.right) / 2.0
        angle = middle + np.remainder(angle - middle + np.pi, 2.0 * np.pi) - np.pi
        s = (angle - screen.left) / (screen.right - screen.left)
        return np.column_stack([s, (met[:, 1] - screen.bottom) / (screen.top - screen.bottom)])


def distance_to(screen: Screen) -> float:
    """Distance of a flat screen's plane, or of a curved screen's middle, in centimetres."""
    if isinstance(screen, Flat):
        normal = np.cross(screen.along, screen.up)
        return float(abs(screen.corner @ normal) / np.linalg.norm(normal))
    return float(np.linalg.norm(points_on(screen, np.array([[0.5, 0.5]]))[0]))


def frustum_of(screen: Screen, eye: Array, points: Array) -> Frustum:
    """The off-axis frustum of an eye at `eye` (3,) that takes in `points` (n, 3) of a screen.

    It is parallel to a flat screen, or to the chord of a curved one. A UserError if there is none.
    """
    if isinstance(screen, Flat):
        along, up = screen.along, screen.up
    else:
        left, right = points_on(screen, np.array([[0.0, 0.5], [1.0, 0.5]]))
        along, up = right - left, np.array([0.0, 1.0, 0.0])
        if np.linalg.norm(along) < 1e-9 or screen.right - screen.left >= np.pi:
            raise UserError("a curved screen spans half a turn or more, expected several channels")
    axes = np.stack([along, up, np.cross(along, up)])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    seen = (points - eye) @ axes.T
    if seen[:, 2].min() <= 0.0:
        raise UserError("the eye is behind the screen, or in it; expected before it")
    slopes = seen[:, :2] / seen[:, 2:]
    if np.abs(slopes).max() > STEEPEST:
        raise UserError(
            "the screen is seen too much from the side for one view (more than 82 degrees from "
            "the middle); expected several channels"
        )
    (left, bottom), (right, top) = slopes.min(axis=0), slopes.max(axis=0)
    edges = float(left), float(right), float(bottom), float(top)
    return Frustum(axes, edges)


def seen_at(frustum: Frustum, eye: Array, points: Array) -> Array:
    """Positions (n, 2) of points (n, 3) in the picture of a frustum, in shares of it."""
    seen = (points - eye) @ frustum.axes.T
    slopes = seen[:, :2] / seen[:, 2:]
    left, right, bottom, top = frustum.edges
    return np.asarray((slopes - [left, bottom]) / [right - left, top - bottom])
