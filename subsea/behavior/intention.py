"""The intention generator in its first form: wander, school, avoid (SMC §6, Tu §7.5)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.behavior.routines import (
    FOLLOW_BL,
    follow,
    give_way,
    keep_company,
    stay_inside,
    wander,
)
from subsea.kinematics.vector import Vector, dot, minus, norm, plus, times, unit, vector
from subsea.state import AVOID, SCHOOL, WANDER, Fishes

Array = NDArray[np.floating[Any]]

AVOID_ABOVE = 0.6  # an avoidance stronger than this is what the fish is busy with
CRUISE = (0.1, 0.62, 0.85)  # shares of the fastest speed: hovering, medium and brisk cruising
LEADING = 0.45  # a leader keeps its school moving
URGE_EASE = 4.0  # 1/s: how fast a wish may change, so that no fish twitches


@njit(cache=True)
def decide(
    fishes: Fishes,
    heights: Array,
    half_width: float,
    radius: float,
    submarine: Array,
    seed: int,
    tick: int,
    dt: float,
) -> None:
    """Set intention, goal direction and goal speed of every fish.

    Leaders and loners wander; the others follow their leader in company. Avoidance is added on
    top. Against monotony the secondary controller recommends another swim; a wandering fish takes
    it up, one that schools or is in danger refuses (SMC §6.1).
    """
    for i in range(len(fishes.species)):
        danger = plus(
            stay_inside(fishes, i, heights, half_width, radius), give_way(fishes, i, submarine)
        )
        alarm = norm(danger)
        if fishes.leader[i] >= 0:
            urge = plus(follow(fishes, i), keep_company(fishes, i))
            fishes.intention[i] = SCHOOL
            speed = _keep_pace(fishes, i)
        else:
            urge = wander(fishes, i, heights, half_width, radius, seed, tick, dt)
            fishes.intention[i] = WANDER
            speed = _cruise(fishes, i)
        if alarm > AVOID_ABOVE:
            fishes.intention[i] = AVOID
            speed = max(speed, min(0.5 + 0.35 * alarm, 1.0))
        _turn_wish(fishes, i, plus(urge, danger), min(URGE_EASE * dt, 1.0))
        fishes.goal_speed[i] = speed


@njit(cache=True)
def _turn_wish(fishes: Fishes, i: int, urge: Vector, share: float) -> None:
    """Turn the goal direction by a share of its angle to the urge, along the great circle."""
    length = norm(urge)
    if length < 1e-6:
        return
    now = vector(fishes.goal_direction[i])
    along = dot(now, urge) / length
    across = minus(times(1.0 / length, urge), times(along, now))
    sine = norm(across)
    if sine < 1e-4:
        if along > 0.0:
            return
        # Dead astern: either side will do, so the left one.
        across = unit((1e-6 - now[1], now[0], 0.0))
    else:
        across = times(1.0 / sine, across)
    angle = share * np.arctan2(sine, along)
    wish = unit(plus(times(np.cos(angle), now), times(np.sin(angle), across)))
    for axis in range(3):
        fishes.goal_direction[i, axis] = wish[axis]


@njit(cache=True)
def _cruise(fishes: Fishes, i: int) -> float:
    """The speed of the swim that is recommended, or the present one within what is cruising."""
    speed = float(fishes.goal_speed[i])
    if fishes.recommended[i] >= 0:
        speed = CRUISE[fishes.recommended[i]]
    return min(max(speed, LEADING if fishes.leads[i] else CRUISE[0]), CRUISE[2])


@njit(cache=True)
def _keep_pace(fishes: Fishes, i: int) -> float:
    """Faster when behind the leader or far away, slower when ahead of it."""
    leader = fishes.leader[i]
    gap = minus(vector(fishes.position[leader]), vector(fishes.position[i]))
    behind = dot(gap, vector(fishes.goal_direction[leader])) / (FOLLOW_BL * fishes.length[i])
    distance = norm(gap) / (FOLLOW_BL * fishes.length[i])
    pace = fishes.goal_speed[leader] + 0.25 * behind + 0.08 * (fishes.identity[i] - 0.5)
    pace += 0.5 * max(distance - 1.5, 0.0)
    return min(max(pace, 0.08), 1.0)
