"""Listeners in a world, layouts of loudspeakers, and how a source reaches them."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import unknown
from subsea.geometry.rotation import rotate
from subsea.geometry.vector import Vector, minus, norm
from subsea.kernels import kernel
from subsea.view.display_rigs import cockpit
from subsea.view.rig import CameraPose
from subsea.world.world import TICK_S, World

RATE = 48_000  # samples a second
BLOCK = round(TICK_S * RATE)  # of a tick
SOUND_CM_S = 150_000.0  # in sea water

NEAREST_CM = 50.0  # nearer sources are as loud
METRE = 100.0  # levels of sources are given at 1 m
CLEAR_HZ, DULL_CM = 20_000.0, 3000.0  # low-pass of water (designed): half the band in this way
OPEN_HZ, SHADOWED_HZ = 20_000.0, 3500.0  # low-pass of the head: at the near ear, and the far one
# Width of the picture of sound, and the longest delay between two ears, s. Under water people
# hardly hear directions: in loudspeakers the true delay across a head, for headphones that in air.
STEREO_WIDTH, STEREO_S = 0.8, 0.2 / 1500.0
BINAURAL_WIDTH, BINAURAL_S = 0.6, 0.2 / 343.0
FOCUS = 5.0  # how narrow a source is among several loudspeakers
SPHERE = -1.0  # in place of a width: the channels are those of a sphere (`AMBISONIC`)


class Listener(NamedTuple):
    """Ears in the sea."""

    place: Array  # (3,) cm
    axes: Array  # (3, 3) rows: right, ahead, up
    velocity: Array  # (3,) cm/s
    aboard: bool  # in the submarine, whose own sounds are heard


def listener_at(pose: CameraPose, velocity: Array, aboard: bool) -> Listener:
    """A listener with the eyes of a pose, which moves at `velocity` (3,) cm/s."""
    axes = np.stack([np.cross(pose.forward, pose.up), pose.forward, pose.up])
    return Listener(np.asarray(pose.eye, np.float64), axes, np.asarray(velocity), aboard)


class Layout(NamedTuple):
    """Channels, in the order of WAV and AAC files."""

    name: str
    directions: Array  # (c, 3) unit, right, ahead, up; zero for the low-frequency channel
    width: float = 0.0  # of two ears; 0 for loudspeakers around, SPHERE for none
    delay_s: float = 0.0  # the longest between two ears

    @property
    def container_name(self) -> str:
        """Its name in films."""
        return {"binaural": "stereo", AMBISONIC: "4.0"}.get(self.name, self.name)

    @property
    def channels(self) -> int:
        """The number of channels."""
        return len(self.directions)


def _around(*azimuths_deg: float | None) -> Array:
    """Directions of level loudspeakers, degrees to the right of ahead; None: low frequencies."""
    return np.array(
        [
            (0.0, 0.0, 0.0)
            if angle is None
            else (math.sin(math.radians(angle)), math.cos(math.radians(angle)), 0.0)
            for angle in azimuths_deg
        ]
    )


AMBISONIC = "ambisonic"
LAYOUTS = {
    layout.name: layout
    for layout in (
        Layout("mono", _around(0.0)),
        Layout("stereo", _around(-90.0, 90.0), STEREO_WIDTH, STEREO_S),
        Layout("binaural", _around(-90.0, 90.0), BINAURAL_WIDTH, BINAURAL_S),
        Layout("quad", _around(-45.0, 45.0, -135.0, 135.0)),
        Layout("5.1", _around(-30.0, 30.0, 0.0, None, -110.0, 110.0)),
        Layout("7.1", _around(-30.0, 30.0, 0.0, None, -150.0, 150.0, -90.0, 90.0)),
        # First order, in the order of ACN: all round, left, up, ahead. The echo has no direction.
        Layout(AMBISONIC, _around(0.0, None, None, None), SPHERE),
    )
}


def layout_of(name: str) -> Layout:
    """The layout of this name; a UserError for an unknown one."""
    if name not in LAYOUTS:
        raise unknown("layout", name, list(LAYOUTS))
    return LAYOUTS[name]


def loudspeakers(directions_deg: Sequence[tuple[float, float]]) -> Layout:
    """A layout of loudspeakers at azimuths, right of ahead, and elevations, degrees."""
    angles = np.radians(np.asarray(directions_deg, np.float64).reshape(-1, 2))
    level = np.cos(angles[:, 1])
    places = [level * np.sin(angles[:, 0]), level * np.cos(angles[:, 0]), np.sin(angles[:, 1])]
    return Layout("loudspeakers", np.stack(places, axis=1))


@kernel
def toward(axes: Array, place: Array, source: Vector) -> tuple[Vector, float]:
    """Direction to a source in the axes of a listener, right, ahead, up, and distance, cm."""
    gap = minus(source, (place[0], place[1], place[2]))
    away = norm(gap)
    if away < 1e-6:
        return (0.0, 0.0, 0.0), away
    x, y, z = gap[0] / away, gap[1] / away, gap[2] / away
    return (
        axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z,
        axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z,
        axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z,
    ), away


@kernel
def fading(away: float) -> float:
    """Factor on the level at 1 m of a source `away` cm off: spherical spreading."""
    return METRE / max(away, NEAREST_CM)


@kernel
def muffling(away: float) -> float:
    """Corner frequency, Hz, of the low-pass of `away` cm of water."""
    return CLEAR_HZ / (1.0 + away / DULL_CM)


@kernel
def doppler(way: Vector, velocity: Vector, own: Vector) -> float:
    """Factor on the pitch of a source at `velocity`, heard from the unit direction `way` at `own`.

    All in the same axes, cm/s.
    """
    leaves = way[0] * velocity[0] + way[1] * velocity[1] + way[2] * velocity[2]
    follows = way[0] * own[0] + way[1] * own[1] + way[2] * own[2]
    return (SOUND_CM_S + follows) / (SOUND_CM_S + leaves)


@kernel
def pan(directions: Array, width: float, way: Vector, gains: Array) -> None:
    """Write the gains (c,) of a source in direction `way`, of power 1; zero is all round.

    For the channels of a sphere they are its harmonics, normalised as SN3D.
    """
    number = len(gains)
    if width < 0.0:
        gains[0], gains[1], gains[2], gains[3] = 1.0, -way[0], way[2], way[1]
        return
    if width > 0.0:
        side = (1.0 + width * way[0]) * 0.25 * math.pi
        gains[0], gains[1] = math.cos(side), math.sin(side)
        return
    power = 0.0
    for c in range(number):
        x, y, z = directions[c, 0], directions[c, 1], directions[c, 2]
        gains[c] = 0.0
        if x != 0.0 or y != 0.0 or z != 0.0:
            near = 0.5 + 0.5 * (x * way[0] + y * way[1] + z * way[2])
            gains[c] = max(near, 0.01) ** FOCUS
        power += gains[c] ** 2
    for c in range(number):
        gains[c] /= math.sqrt(power)


@kernel
def reach_ears(width: float, delay_s: float, way: Vector, delays: Array, corners: Array) -> None:
    """Write delay, samples, and low-pass of the head, Hz, of each channel (c,) for a direction."""
    delays[:] = 0.0
    corners[:] = OPEN_HZ
    if width > 0.0:
        far = 0 if way[0] > 0.0 else 1
        aside = abs(way[0])
        delays[far] = aside * delay_s * RATE
        corners[far] = OPEN_HZ * (SHADOWED_HZ / OPEN_HZ) ** aside


Head = Callable[[CameraPose], CameraPose]


def at_rest(seat: CameraPose) -> CameraPose:
    """The pose of a head that looks straight ahead."""
    return seat


def listener_of(world: World, fish: int | None = None, head: Head = at_rest) -> Listener:
    """The pilot's ears at the end of the last tick, or those of a living fish.

    `head` gives the pose of the pilot's head on the pilot's seat.
    """
    fishes, submarine = world.state.fishes, world.state.submarine
    if fish is None or not fishes.alive[fish]:
        return listener_at(head(cockpit(submarine, 1.0)), submarine.velocity, aboard=True)
    turn = tuple(float(q) for q in fishes.orientation[fish])
    forward, up = (np.array(rotate(turn, axis)) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    place = fishes.position[fish].astype(np.float64)
    velocity = fishes.velocity[fish].astype(np.float64)
    return listener_at(CameraPose(place, forward, up), velocity, aboard=False)
