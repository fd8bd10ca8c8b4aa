"""A smooth camera behind and above a fish that stays clear of stone, sand, air and fishes."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.rotation import matrix, x_axis
from subsea.geometry.solids import height_at
from subsea.geometry.vector import Vector, minus, plus, times, vector
from subsea.habitat.contact import clearance, out_of_solids
from subsea.kernels import kernel
from subsea.state import Sea
from subsea.view.retina import bodies_at
from subsea.view.rig import CameraPose
from subsea.world.world import TICK_S, World

BACK_CM, BACK_BL = 15.0, 1.9  # distance behind the fish: constant, and per body length
ABOVE = 0.35  # height above the fish, as a share of that distance
BEYOND_BL = 1.5  # the camera looks at a point this far ahead of the fish
SLANT = 0.5  # share of the fish's climb that the camera follows
ROOM_CM = 12.0  # clearance from solids and the surface, beyond the near plane's corners
PLACE_S, WAY_S = 0.25, 0.9  # time constants of position and heading
RECEDES = 0.6  # 1/s: speed at which the camera moves back after an obstacle
STEPS = 24  # points tested between the fish and the camera
# Room about other fishes, each a capsule along its body.
HALF_BL, WIDE_BL, MATE_CM = 0.45, 0.14, 7.0  # half its axis and its radius, L, and more radius
DODGE_S = 0.5  # time constant of the way back once a fish has passed
DODGES = 16  # fishes that may push the camera in one picture


class FollowCamera(NamedTuple):
    """State of the camera in the last picture."""

    at_s: float  # time of the world
    aim: Array  # (3,) cm, smoothed position of the fish
    way: Array  # (3,) smoothed heading of the fish, not unit
    share: float  # of the full distance, less than 1 near obstacles
    among: float  # smoothed depth of the fish among growths, which make room: 0 to 1
    dodge: Array  # (3,) cm, way from its place to clear water between other fishes


def follow_fish(
    world: World, fish: int, alpha: float, before: FollowCamera | None, aside: float = 0.0
) -> tuple[FollowCamera, CameraPose]:
    """Move the camera; returns its state and pose.

    `alpha` is the share of the way from the last tick to the current one. `before` is the state in
    the last picture; None, or a jump in time, puts the camera at its place at once. `aside` turns
    the camera round the fish, rad: with π/2 it looks to the right, from the left of the fish.
    """
    now = (world.state.tick - 1 + alpha) * TICK_S
    aim, turn = bodies_at(world, fish, alpha)
    way = np.array(x_axis(tuple(turn)))
    share, among = 1.0, _among(world.state.sea, vector(aim))
    dodge = np.zeros(3)
    if before is not None and 0.0 <= now - before.at_s < 1.0:
        spent = now - before.at_s
        aim = before.aim + (1.0 - np.exp(-spent / PLACE_S)) * (aim - before.aim)
        way = before.way + (1.0 - np.exp(-spent / WAY_S)) * (way - before.way)
        share = before.share + RECEDES * spent
        among = before.among + (1.0 - np.exp(-spent / WAY_S)) * (among - before.among)
        dodge = np.exp(-spent / DODGE_S) * before.dodge
    length = float(world.state.fishes.length[fish])
    level = np.array([way[0], way[1], SLANT * way[2]])
    level /= max(float(np.linalg.norm(level)), 1e-6)
    back = BACK_CM + BACK_BL * length
    cosine, sine = np.cos(aside), np.sin(aside)
    x, y, z = level
    view = np.array([cosine * x + sine * y, cosine * y - sine * x, cosine * z])
    wanted = aim - back * view + np.array([0.0, 0.0, ABOVE * back * cosine**2])
    sea = _opened(world.state.sea, float(aim[2]), among)
    eye, share = _free(sea, vector(aim), vector(wanted), min(share, 1.0))
    forward = aim + BEYOND_BL * length * cosine**2 * view - eye
    forward /= max(float(np.linalg.norm(forward)), 1e-6)
    up = np.array([0.0, 0.0, 1.0]) - forward[2] * forward
    if float(np.linalg.norm(up)) < 1e-3:  # straight above it
        up = level - (forward @ level) * forward
    up /= np.linalg.norm(up)
    place = np.array(eye)
    dodged = _between_fishes(world, fish, alpha, place + dodge)
    dodged = np.array(out_of_solids(sea, vector(dodged), ROOM_CM, ROOM_CM, ROOM_CM))
    after = FollowCamera(now, aim, way, share, among, dodged - place)
    return after, CameraPose(dodged, forward, up)


def _between_fishes(world: World, fish: int, alpha: float, eye: Array) -> Array:
    """Push the eye (3,) out of the room about all fishes but `fish`."""
    fishes = world.state.fishes
    reach = 2.0 * MATE_CM + (HALF_BL + 2.0 * WIDE_BL) * fishes.length
    near = fishes.alive & (((fishes.position - eye) ** 2).sum(axis=1) < (reach + BACK_CM) ** 2)
    near[fish] = False
    who = np.flatnonzero(near)
    if not len(who):
        return eye
    place, turn = bodies_at(world, who, alpha)
    axis, length = matrix(turn)[..., 0], fishes.length[who].astype(np.float64)
    for _ in range(DODGES):
        along = ((eye - place) * axis).sum(axis=1)
        along = np.clip(along, -HALF_BL * length, HALF_BL * length)
        away = eye - place - along[:, None] * axis
        gap = np.linalg.norm(away, axis=1)
        inside = WIDE_BL * length + MATE_CM - gap
        k = int(inside.argmax())
        if inside[k] <= 0.0:
            break
        way = away[k] / gap[k] if gap[k] > 1e-3 else np.array([0.0, 0.0, 1.0])
        eye = eye + (inside[k] + 0.1) * way
    return eye


def _among(sea: Sea, fish: Vector) -> float:
    """How deep a fish is among growths: 0 above their tops, 1 from ROOM_CM below them."""
    under = height_at(sea.floor, sea.half_width, fish[0], fish[1]) - fish[2]
    return float(np.clip(under / ROOM_CM, 0.0, 1.0))


def _opened(sea: Sea, height: float, share: float) -> Sea:
    """The sea whose floor is lowered by a share of the way to a camera at the `height` of a fish.

    It is never lower than the sand: only growths make room.
    """
    if share < 0.01:
        return sea
    low = np.minimum(sea.floor, np.maximum(sea.heights, height - ROOM_CM))
    return sea._replace(floor=(sea.floor + share * (low - sea.floor)).astype(np.float32))


@kernel
def _free(sea: Sea, fish: Vector, wanted: Vector, most: float) -> tuple[Vector, float]:
    """The farthest point with clearance between the fish and the wanted point, and its share.

    The share of the way is at most `most`. Nothing solid lies between the point and the fish.
    """
    floor = height_at(sea.floor, sea.half_width, wanted[0], wanted[1])
    wanted = wanted[0], wanted[1], min(max(wanted[2], floor + ROOM_CM), -ROOM_CM)
    best = 0.0
    for step in range(1, STEPS + 1):
        share = min(step / STEPS, most)
        place = plus(fish, times(share, minus(wanted, fish)))
        gap = min(
            clearance(sea.pillars, sea.rocks, place),
            place[2] - height_at(sea.floor, sea.half_width, place[0], place[1]),
            -place[2],
        )
        if gap < 0.0:
            break
        if gap >= ROOM_CM:
            best = share
        if share >= most:
            break
    place = plus(fish, times(best, minus(wanted, fish)))
    return out_of_solids(sea, place, ROOM_CM, ROOM_CM, ROOM_CM), best
