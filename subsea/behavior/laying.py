"""Clownfishes lay their eggs on bare stone beside their anemone, in many slow passes.

She creeps over the nest with her belly on the stone, and he follows close behind her to fertilise
the eggs (Allen 1972, *The Anemonefishes*; Fautin and Allen 1992). An hour or two on a reef is some
seconds here.
"""

import numpy as np

from subsea.behavior.chasing import chase
from subsea.behavior.manoeuvring import careful, scull, steer
from subsea.geometry.vector import ZERO, Vector, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import BATHES, MATE, RUBBLE, TURF, Clock, Fishes, Minds, Sea

LAYS_S = 20.0  # how long she is on her nest
NEST_CM = 120.0  # farthest nest from the anemone
UPRIGHT = 0.5  # least upward component of the normal of stone that bears a nest
NEAR_CM, ON_BL = 60.0, 1.0  # distances from it at which they come down to it, and are on it
SLACK_CM = 3.0  # depth below the nest that a body may reach
LOOP_BL, LOOP_HZ = 0.35, 0.11  # radius of the loop of her passes; loops per second
BEHIND_RAD = 1.9  # how far he is behind her on this loop
OVER = 0.6  # height of her middle over the nest, over that of her body
CREEPS, HURRIES = 0.12, 0.4  # shares of their fastest speed: over the nest and to it
HOLDS_BL_S = 0.5  # how fast fins hold them on the loop


@kernel
def nest_of(minds: Minds, i: int, sea: Sea) -> int:
    """The place of rock or rubble nearest to the anemone of fish i, or -1 for none."""
    anemone = np.int64(minds.cover[i])
    best, least = -1, NEST_CM
    if not minds.ways[i] & BATHES or anemone < 0:
        return best
    middle = vector(sea.site_place[anemone])
    for s in range(len(sea.site_kind)):
        if sea.site_kind[s] != TURF and sea.site_kind[s] != RUBBLE:
            continue
        away = norm(minus(vector(sea.site_place[s]), middle))
        if away < least and sea.site_normal[s, 2] > UPRIGHT:
            best, least = s, away
    return best


@kernel
def lay(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock, i: int, nest: int) -> None:
    """Bring fish i to the nest, then round over it: she ahead, he behind her.

    `minds.courtship_count` is the time, s, that it has been there.
    """
    length = float(fishes.length[i])
    spot = _on_loop(fishes, minds, sea, clock, i, nest)
    toward = minus(spot, vector(fishes.position[i]))
    far = norm(toward)
    if far > NEAR_CM:
        chase(fishes, minds, i, spot, ZERO)
        return
    fishes.close[i], fishes.shell[i] = True, sea.site_depth[nest] + SLACK_CM
    if far < ON_BL * length:
        minds.courtship_count[i] += minds.pause[i]
        minds.fatigue[MATE, i] = 0.0
    quick = min(CREEPS + 0.5 * max(far / length - ON_BL, 0.0), HURRIES)
    fishes.goal_speed[i] = quick * careful(steer(fishes, minds, i, toward))
    scull(fishes, i, toward, HOLDS_BL_S)


@kernel
def _on_loop(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock, i: int, nest: int) -> Vector:
    """The place of fish i on the loop over the nest, cm, which lies in the plane of the stone."""
    her = np.int64(minds.partner[i]) if minds.male[i] else i
    turn = 2.0 * np.pi * LOOP_HZ * clock.tick * clock.dt - (BEHIND_RAD if minds.male[i] else 0.0)
    reach = LOOP_BL * float(fishes.length[her])
    x, y = reach * np.cos(turn), reach * np.sin(turn)
    normal = vector(sea.site_normal[nest])
    level = (x, y, -(x * normal[0] + y * normal[1]) / normal[2])
    over = OVER * float(fishes.girth[i, 0])
    return plus(vector(sea.site_place[nest]), plus(level, times(over, normal)))
