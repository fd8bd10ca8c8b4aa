"""A calm camera behind and above a fish, which enters neither stone nor sand nor air."""

from typing import NamedTuple

import numpy as np

from subsea.core.arrays import Array
from subsea.core.kernels import kernel
from subsea.geometry.height_field import height_at
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, minus, plus, times, vector
from subsea.habitat.clearance import clearance, out_of_solids
from subsea.state import Sea
from subsea.view.retina import body_at
from subsea.view.rig import CameraPose
from subsea.world.world import TICK_S, World

BACK_CM, BACK_BL = 15.0, 1.9  # how far behind the middle of the fish: so much, and so many lengths
ABOVE = 0.35  # and how far above, as a share of that
BEYOND_BL = 1.5  # so far ahead of the fish lies what it looks at
SLANT = 0.5  # how much of the fish's climb it goes along with
ROOM_CM = 12.0  # from all that is solid and from the surface: more than the near plane's corners
PLACE_S, WAY_S = 0.25, 0.9  # in which it follows where the fish is, and the way that it heads
RECEDES = 0.6  # 1/s: share of its way back to its place, from where something made it come nearer
STEPS = 24  # places on its way to the fish at which is looked whether they are free


class FollowCamera(NamedTuple):
    """Where it was, in the terms in which it follows."""

    at_s: float  # time of the world
    aim: Array  # (3,) cm, the fish
    way: Array  # (3,) that the fish heads, not unit
    share: float  # of its distance: less than 1 where something is in its way


def follow_fish(
    world: World, fish: int, alpha: float, before: FollowCamera | None
) -> tuple[FollowCamera, CameraPose]:
    """The camera now, `alpha` of the way from the last tick to the present one, and its view.

    `before` is what it was in the last picture. Without that, or if time has leapt, it is at once
    where it belongs.
    """
    now = (world.state.tick - 1 + alpha) * TICK_S
    aim, turn = body_at(world, fish, alpha)
    way = np.array(x_axis(turn))
    share = 1.0
    if before is not None and 0.0 <= now - before.at_s < 1.0:
        spent = now - before.at_s
        aim = before.aim + (1.0 - np.exp(-spent / PLACE_S)) * (aim - before.aim)
        way = before.way + (1.0 - np.exp(-spent / WAY_S)) * (way - before.way)
        share = before.share + RECEDES * spent
    length = float(world.state.fishes.length[fish])
    level = np.array([way[0], way[1], SLANT * way[2]])
    level /= max(float(np.linalg.norm(level)), 1e-6)
    back = BACK_CM + BACK_BL * length
    wanted = aim - back * level + np.array([0.0, 0.0, ABOVE * back])
    eye, share = _free(world.state.sea, vector(aim), vector(wanted), min(share, 1.0))
    forward = aim + BEYOND_BL * length * level - eye
    forward /= max(float(np.linalg.norm(forward)), 1e-6)
    up = np.array([0.0, 0.0, 1.0]) - forward[2] * forward
    if float(np.linalg.norm(up)) < 1e-3:  # straight above it
        up = level - (forward @ level) * forward
    up /= np.linalg.norm(up)
    return FollowCamera(now, aim, way, share), CameraPose(np.array(eye), forward, up)


@kernel
def _free(sea: Sea, fish: Vector, wanted: Vector, most: float) -> tuple[Vector, float]:
    """The place nearest to the wanted one, on the way there from the fish, that has room about it.

    And its share of that way, of which it is at most `most`. Nothing solid is between it and the
    fish.
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
