"""The vessel around a theatre's audience, at rest on the hull, and the panel of a headset."""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.view.camera import axes_of


class Panel(NamedTuple):
    """A flat rectangle on the observer, with the axes right, up, ahead, in cm."""

    middle: Array  # (3,)
    right: Array  # (3,) from its middle to its right edge
    up: Array  # (3,) from its middle to its upper edge

    def places(self, x: Array, y: Array) -> Array:
        """Places (n, 3) of points in shares (n,) of the panel from its upper left corner."""
        across, high = 2.0 * np.asarray(x) - 1.0, 1.0 - 2.0 * np.asarray(y)
        return self.middle + across[:, None] * self.right + high[:, None] * self.up

    def hit(self, start: Array, way: Array) -> tuple[float, float] | None:
        """Shares of the panel from its upper left corner where a ray meets it; None beside it."""
        normal = np.cross(self.right, self.up)
        toward = float(way @ normal)
        if abs(toward) < 1e-9 * np.linalg.norm(normal):
            return None
        distance = float((self.middle - start) @ normal) / toward
        if distance <= 0.0:
            return None
        at = start + distance * way - self.middle
        across, high = float(at @ self.right), float(at @ self.up)
        x = 0.5 + 0.5 * across / float(self.right @ self.right)
        y = 0.5 - 0.5 * high / float(self.up @ self.up)
        return (x, y) if 0.0 <= x <= 1.0 and 0.0 <= y <= 1.0 else None


# As large as a screen of 70 inches, a little below the eyes, tilted to face them.
PANEL = Panel(np.array([0.0, -14.0, 150.0]), np.array([78.0, 0.0, 0.0]), np.array([0.0, 43.7, 4.2]))


AROUND, ACROSS = 144, 8  # corners of the rim, and of the tube along it
TUBE = 0.012  # thickness of the tube, in radii
PLATES = 36  # of the rim, alternately darker
HULL, DARKER, BRIGHTER, PIPE = 0.3, 1.0, 1.35, 1.2  # brightness
PANEL_SIZE = 1280, 720  # pixels of the panel


class TheatreVessel(NamedTuple):
    """A rim that follows the edge of a dome or the foot of a screen; angles in rad."""

    radius_cm: float  # of the rim: the nearest screen, so that it has no depth in stereo
    spring: float  # elevation of the spring line, the rim's lower edge
    rim: float  # height of the rim
    tilt: float = 0.0  # of all that to the front
    panel_angle: float | None = None  # width of the panel with text; None: no panel

    @property
    def panel(self) -> Panel | None:
        """The panel: level, ahead, upright to the eye, its foot on the rim."""
        if self.panel_angle is None:
            return None
        half = math.tan(self.panel_angle / 2.0)
        high = half * PANEL_SIZE[1] / PANEL_SIZE[0]
        middle = self.spring + self.rim - self.tilt + math.atan(high)
        _, up, ahead = axes_of(0.0, middle)
        far = self.radius_cm
        return Panel(far * ahead, np.array([far * half, 0.0, 0.0]), far * high * up)


def vessel_plates(vessel: TheatreVessel) -> Array:
    """Corners (n, 7) of triangles of hull and rim: place, cm; normal; brightness."""
    turn = np.linspace(0.0, 2.0 * math.pi, AROUND + 1)
    low, high = (_ring(vessel, turn, at) for at in (vessel.spring, vessel.spring + vessel.rim))
    nadir = np.broadcast_to([0.0, -vessel.radius_cm, 0.0], low[1:].shape)
    hull = np.stack([nadir, low[:-1], low[1:]], axis=1).reshape(-1, 3)
    hull = _with_look(hull, np.broadcast_to([0.0, 1.0, 0.0], hull.shape), HULL)
    a, b, c, d = low[:-1], low[1:], high[1:], high[:-1]
    rim = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    inward = -rim / np.linalg.norm(rim, axis=1, keepdims=True)
    plate = np.repeat(np.arange(AROUND) * PLATES // AROUND % 2, 6)
    rim = _with_look(rim, inward, np.where(plate == 1, BRIGHTER, DARKER))
    return _tilted(vessel, np.concatenate([hull, rim]))


def vessel_tube(vessel: TheatreVessel) -> Array:
    """Corners (n, 7) of triangles of the tube along the rim's upper edge."""
    radius, at = vessel.radius_cm, vessel.spring + vessel.rim
    middle = radius * math.sin(at) * np.array([0.0, 1.0, 0.0])
    right, _, ahead = np.eye(3)
    flat, thick = radius * math.cos(at), TUBE * radius
    turns = 0.0, 2.0 * math.pi
    return _tilted(vessel, PIPE_LOOK * torus(middle, (right, ahead), turns, (flat, thick), AROUND))


PIPE_LOOK = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, PIPE])


def torus(
    middle: Array,
    plane: tuple[Array, Array],
    turns: tuple[float, float],
    sizes: tuple[float, float],
    around: int,
) -> Array:
    """Corners (n, 7) of an arc of a torus of brightness 1.

    It lies in a plane of two unit vectors, between two angles, rad, in `around` pieces; `sizes` are
    the radius and that of the tube, cm.
    """
    along, up = plane
    turn = np.linspace(*turns, around + 1)[:, None, None]
    tube = np.linspace(0.0, 2.0 * np.pi, ACROSS + 1)[None, :, None]
    outward = np.cos(turn) * along + np.sin(turn) * up
    normal = np.cos(tube) * outward + np.sin(tube) * np.cross(along, up)
    place = middle + sizes[0] * outward + sizes[1] * normal
    corners = np.concatenate([place, normal, np.ones((*normal.shape[:2], 1))], axis=2)
    a, b = corners[:-1, :-1], corners[1:, :-1]
    c, d = corners[1:, 1:], corners[:-1, 1:]
    return np.stack([a, c, b, a, d, c], axis=2).reshape(-1, 7)


def panel_quad(panel: Panel) -> Array:
    """Corners (6, 7) of the two triangles of a panel, with texture coordinates."""
    shares = np.array([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1.0]])
    places = panel.places(shares[:, 0], 1.0 - shares[:, 1])
    return np.concatenate([places, shares, np.zeros((6, 2))], axis=1)


def _ring(vessel: TheatreVessel, turn: Array, elevation: float) -> Array:
    """Points (n, 3) around, at an elevation."""
    level = math.cos(elevation)
    rise = np.full_like(turn, math.sin(elevation))
    return vessel.radius_cm * np.stack([level * np.sin(turn), rise, level * np.cos(turn)], axis=1)


def _with_look(places: Array, normals: Array, brightness: float | Array) -> Array:
    shade = np.broadcast_to(brightness, len(places))[:, None]
    return np.concatenate([places, normals, shade], axis=1)


def _tilted(vessel: TheatreVessel, corners: Array) -> Array:
    """Corners (n, 7), leaned to the front; their light stays that of the upright vessel."""
    leaned = corners.copy()
    leaned[:, :3] = corners[:, :3] @ axes_of(0.0, -vessel.tilt)
    return leaned
