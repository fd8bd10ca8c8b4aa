"""The surfaces that projectors light, for rays of a camera that stands anywhere in the room.

Points and directions are right, up, ahead of the eye at the best seat, in real centimetres. Places
are shares (s, t) of the screen of a channel from its lower left corner, as a warp mesh has them.
"""

from dataclasses import dataclass

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.stage.theatre.channels import ProjectorChannel
from subsea.stage.theatre.lenses import on_cylinder, on_sphere
from subsea.stage.theatre.measured_mesh import dome_shares
from subsea.stage.theatre.screens import Curved, Flat, Screen, places_on, points_on
from subsea.stage.theatre.theatre_file import Dome, Theatre
from subsea.view.rig import Projection

NEAR_CM = 1.0  # two flat screens this close are one surface


@dataclass(frozen=True)
class LitSurface:
    """The surface that a channel lights, and the screen whose shares are its places."""

    screen: Screen | None  # None: the square of a dome
    radius: float | None = None  # of the sphere about the eye; None: the screen itself is lit
    tilt_deg: float = 0.0  # of a dome
    angle: float = 1.0  # of a dome, in half turns

    def places(self, rays: Array) -> Array:
        """The places (n, 2) in the directions of rays (n, 3); NaN where none is."""
        if self.screen is not None:
            return places_on(self.screen, rays)
        return np.asarray((dome_shares(rays, self.tilt_deg) - 0.5) / self.angle + 0.5)

    def points(self, places: Array) -> Array:
        """The points (n, 3) at places (n, 2)."""
        if self.screen is None:
            return self._dome_points(places)
        points = points_on(self.screen, places)
        if self.radius is not None:
            points *= self.radius / np.linalg.norm(points, axis=1, keepdims=True)
        return points

    def meet(self, start: Array, ways: Array) -> Array:
        """The points (n, 3) where rays from `start` (3,) along unit `ways` (n, 3) arrive."""
        if self.radius is not None:
            if start @ start >= self.radius**2:
                return np.full(ways.shape, np.nan)
            return on_sphere(start, ways, self.radius)
        if isinstance(self.screen, Curved):
            axis = np.array([self.screen.axis[0], 0.0, self.screen.axis[1]])
            return axis + on_cylinder(start - axis, ways, self.screen.radius)
        assert isinstance(self.screen, Flat)
        normal = np.cross(self.screen.along, self.screen.up)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = ((self.screen.corner - start) @ normal) / (ways @ normal)
            return np.asarray(start + np.where(reach > 0.0, reach, np.nan)[:, None] * ways)

    def same(self, other: "LitSurface") -> bool:
        """True if both channels light the same surface."""
        if self.radius is not None or other.radius is not None:
            return self.radius == other.radius
        one, two = self.screen, other.screen
        if isinstance(one, Curved) and isinstance(two, Curved):
            return one.axis == two.axis and one.radius == two.radius
        if not isinstance(one, Flat) or not isinstance(two, Flat):
            return False
        normal = np.cross(one.along, one.up)
        corners = points_on(two, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])) - one.corner
        return bool(np.abs(corners @ normal).max() < NEAR_CM * np.linalg.norm(normal))

    def _dome_points(self, places: Array) -> Array:
        assert self.radius is not None
        aside = (np.asarray(places, np.float64) - 0.5) * 2.0
        length = np.linalg.norm(aside, axis=1)
        away = length * self.angle * np.pi / 2.0
        tilt = np.radians(self.tilt_deg)
        middle = np.array([0.0, np.cos(tilt), np.sin(tilt)])
        behind = np.array([0.0, np.sin(tilt), -np.cos(tilt)])
        unit = aside / np.maximum(length, 1e-12)[:, None]
        across = unit[:, :1] * [1.0, 0.0, 0.0] + unit[:, 1:] * behind
        rays = np.cos(away)[:, None] * middle + np.sin(away)[:, None] * across
        return np.asarray(self.radius * rays)


def surface_of(theatre: Theatre, channel: ProjectorChannel) -> LitSurface | None:
    """The surface of a channel of a theatre of scale 1; None where it is not known.

    Screens by angles lie on the dome of the room, if it has one.
    """
    if channel.shape == Projection.DOME:
        dome = theatre.channel[int(channel.key[8:-1])].dome
        assert isinstance(dome, Dome)
        return LitSurface(None, dome.distance_cm, dome.tilt_deg, dome.angle_deg / 180.0)
    if channel.screen is None:
        return None
    table = theatre.channel[int(channel.key[8:-1])]
    room = theatre.room
    if table.angles is not None and room is not None and room.dome is not None:
        return LitSurface(channel.screen, room.dome.distance_cm)
    return LitSurface(channel.screen)


def within(places: Array, beyond: float = 0.0) -> Bools:
    """True (n,) for places (n, 2) on the screen, or not farther than a share beyond its edges."""
    with np.errstate(invalid="ignore"):
        return np.asarray(((places >= -beyond) & (places <= 1.0 + beyond)).all(axis=1))
