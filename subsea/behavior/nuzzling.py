"""Nuzzling: nudging the abdomen of a hovering female from below (Tu §7.9.3)."""

import numpy as np

from subsea.base.arrays import Bools, Ints
from subsea.behavior.chasing import mouth_of
from subsea.behavior.manoeuvring import CLOSE_RAD, abdomen_of, careful, hover, steer
from subsea.geometry.vector import Vector, minus, norm, plus
from subsea.kernels import kernel
from subsea.state import MATE, Clock, Fishes, Minds, Sea

BELOW_BL = 0.6  # depth under her abdomen to which he goes first
GATHER_BL = 1.1  # distance within which he must approach ...
SLOPES = (0.3, 0.9)  # ... straight and at a slope between these
GENTLE = 0.6  # slope at which a retreat may end
NIP_BL = 0.25  # distance within which he breaks off only once he has passed her
LEAST_PACE = 0.12  # share of the fastest speed at which he arrives
TOUCH_BL = 0.1  # mouth to abdomen
RETREAT_S, WAIT_S = 2.5, 1.0  # after each nudge
MORE_S = 0.3  # longer retreat while she is too steep above him
BACKING = -0.4  # speed of the retreat
NUDGES = 3


@kernel
def nuzzle(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """She hovers; he nudges her abdomen from below, retreats, waits and comes again."""
    for i in who:
        if not minds.male[i]:
            hover(fishes, minds, i, 0.0)
            continue
        toward = minus(abdomen_of(fishes, minds.partner[i]), mouth_of(fishes, i))
        distance = norm(toward)
        minds.courtship_mark[i] -= minds.pause[i] * fishes.size_rate[i]
        if minds.courtship_mark[i] > 0.0:
            _retreat(fishes, minds, i, toward)
        elif distance < TOUCH_BL * fishes.length[i]:
            minds.courtship_count[i] += 1.0
            minds.courtship_mark[i] = RETREAT_S + WAIT_S
            minds.fatigue[MATE, i] = 0.0
        else:
            _nudge(fishes, minds, i, toward, distance)


@kernel
def _nudge(fishes: Fishes, minds: Minds, i: int, toward: Vector, distance: float) -> None:
    """Nudge the abdomen from below and straight; break off any other approach."""
    length = fishes.length[i]
    slope = toward[2] / max(np.sqrt(toward[0] * toward[0] + toward[1] * toward[1]), 1e-6)
    if slope < SLOPES[0] and distance > GATHER_BL * length:
        toward = plus(toward, (0.0, 0.0, -BELOW_BL * length))
    turn = steer(fishes, minds, i, toward)
    pace = min(max(0.5 * distance / length, LEAST_PACE), 1.0)
    fishes.goal_speed[i] = pace * careful(turn)
    # Very near, where a small error is a large angle, go on unless he has passed her.
    good = turn < CLOSE_RAD and SLOPES[0] < slope < SLOPES[1]
    if distance < NIP_BL * length:
        good = turn < np.pi / 2.0
    if distance < GATHER_BL * length and not good:
        minds.courtship_mark[i] = RETREAT_S + WAIT_S


@kernel
def _retreat(fishes: Fishes, minds: Minds, i: int, toward: Vector) -> None:
    """Back off facing her: nose up, which leads down, or level if she is too steep above.

    It lasts until the slope to her is gentle. Then he waits.
    """
    level = np.sqrt(toward[0] * toward[0] + toward[1] * toward[1])
    steep = toward[2] > GENTLE * level
    steer(fishes, minds, i, (toward[0], toward[1], 0.0 if steep else level))
    if minds.courtship_mark[i] < WAIT_S:
        fishes.goal_speed[i] = 0.0
        return
    fishes.goal_speed[i] = BACKING
    if steep:
        minds.courtship_mark[i] = max(minds.courtship_mark[i], WAIT_S + MORE_S)


@kernel
def nuzzled(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Bools:
    """True if he has nudged her often enough."""
    done = np.zeros(len(who), np.bool_)
    for k in range(len(who)):
        done[k] = minds.male[who[k]] and minds.courtship_count[who[k]] >= NUDGES
    return done
