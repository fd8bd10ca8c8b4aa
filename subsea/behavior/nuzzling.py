"""Nuzzling: nudging the abdomen of a hovering female from below (Tu §7.9.3)."""

import numpy as np

from subsea.base.arrays import Bools, Ints
from subsea.behavior.chasing import mouth_of
from subsea.behavior.manoeuvring import abdomen_of, careful, heading_of, hover, scull, steer
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times
from subsea.kernels import kernel
from subsea.state import MATE, Clock, Fishes, Minds, Sea

BELOW_BL = 0.5  # depth under her abdomen to which he goes first ...
GATHER_BL = 0.9  # ... from farther away than this
RAISED = np.radians(35.0)  # slope at which he points at her abdomen
LEVEL_BL = 0.15  # level distance below which he keeps his heading
OFF_BL, IN_BL = 0.3, 0.02  # distance of his mouth between nudges, and to which he nudges
TOUCH_BL = 0.1  # mouth to abdomen
PAUSE_S = 1.0  # between nudges
NUDGE_BL_S, STROKE, STROKE_MOST = 0.7, 0.5, 0.4  # speed by fins; by swimming: gain, most, shares
HEAD_UP = 0.35  # slope of her body
NUDGES = 3


@kernel
def nuzzle(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """She hovers, head up; he nudges her abdomen from below, backs off a little and comes again."""
    for i in who:
        if not minds.male[i]:
            hover(fishes, minds, i, HEAD_UP)
            continue
        length = float(fishes.length[i])
        toward = minus(abdomen_of(fishes, minds.partner[i]), mouth_of(fishes, i))
        distance = norm(toward)
        minds.courtship_mark[i] -= minds.pause[i] * fishes.size_rate[i]
        if distance > GATHER_BL * length:
            toward = plus(toward, (0.0, 0.0, -BELOW_BL * length))
            pace = min(0.6 * distance / length, 1.0)
            fishes.goal_speed[i] = pace * careful(steer(fishes, minds, i, toward))
            continue
        waits = minds.courtship_mark[i] > 0.0
        if not waits and distance < TOUCH_BL * length:
            minds.courtship_count[i] += 1.0
            minds.courtship_mark[i] = PAUSE_S
            minds.fatigue[MATE, i] = 0.0
        _point(fishes, minds, i, toward, (OFF_BL if waits else IN_BL) * length)


@kernel
def _point(fishes: Fishes, minds: Minds, i: int, toward: Vector, away: float) -> None:
    """Point at her abdomen from below, and bring the mouth to `away` cm from it."""
    length = float(fishes.length[i])
    level = np.sqrt(toward[0] * toward[0] + toward[1] * toward[1])
    bearing = np.arctan2(toward[1], toward[0])
    if level < LEVEL_BL * length:
        bearing = heading_of(fishes, i)
    flat = np.cos(RAISED)
    way = (flat * np.cos(bearing), flat * np.sin(bearing), np.sin(RAISED))
    turn = steer(fishes, minds, i, way)
    gap = plus(toward, times(-away, way))
    forward = dot(gap, x_axis(fishes.orientation[i])) / length
    stroke = min(max(STROKE * forward, -STROKE_MOST), STROKE_MOST)
    fishes.goal_speed[i] = stroke * careful(turn)
    scull(fishes, i, gap, NUDGE_BL_S)


@kernel
def nuzzled(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """True if he has nudged her often enough."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        done[k] = minds.male[who[k]] and minds.courtship_count[who[k]] >= NUDGES
    return done
