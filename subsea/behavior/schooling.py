"""Schooling: with a leader, heading like the neighbours, one body length apart (Tu §7.9.2)."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subsea.kinematics.vector import ZERO, Vector, dot, minus, norm, plus, times, vector
from subsea.state import FEAR, PREY, Clock, Fishes, Minds, Nature, Sea

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

SPACING_BL = 1.0  # schooling fishes keep one body length apart
FOLLOW_BL = 5.0  # a follower farther than this from its leader catches up


@njit(cache=True, error_model="numpy")
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """At ease: a little more than wandering, of fishes that like it and have a leader."""
    for i in who:
        leader = minds.leader[i]
        out[i] = 0.02 if minds.schools[i] and leader >= 0 and fishes.alive[leader] else 0.0


@njit(cache=True, error_model="numpy")
def alarmed_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Close the ranks while no single predator is too fearful (f0 < F, F^m < f1; Tu §7.5)."""
    for i in who:
        fear = minds.mental[i, FEAR]
        afraid = minds.kind[i] == PREY and fear > nature.alarmed
        calm_enough = minds.menace[i] < nature.panicked
        leader = minds.leader[i]
        led = minds.schools[i] and leader >= 0 and fishes.alive[leader]
        out[i] = fear if afraid and calm_enough and led else 0.0


@njit(cache=True, error_model="numpy")
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Follow the leader in company."""
    for i in who:
        urge = plus(_follow(fishes, minds, i), _keep_company(fishes, minds, i))
        for axis in range(3):
            minds.urge[i, axis] = urge[axis]
        fishes.goal_speed[i] = _keep_pace(fishes, minds, i)


@njit(cache=True, error_model="numpy")
def _follow(fishes: Fishes, minds: Minds, i: int) -> Vector:
    """Toward the leader, more the farther it is, and along with it when near."""
    leader = minds.leader[i]
    toward = minus(vector(fishes.position[leader]), vector(fishes.position[i]))
    distance = norm(toward)
    lag = distance / (FOLLOW_BL * fishes.length[i])
    pull = min(lag * lag, 2.5) / max(distance, 1.0)
    return plus(times(pull, toward), vector(fishes.goal_direction[leader]))


@njit(cache=True, error_model="numpy")
def _keep_company(fishes: Fishes, minds: Minds, i: int) -> Vector:
    """Heading like the neighbours, and one body length away from each of them."""
    out, ahead = ZERO, ZERO
    here = vector(fishes.position[i])
    count = 0
    for j in minds.neighbour[i]:
        if j < 0:
            break
        away = minus(here, vector(fishes.position[j]))
        distance = norm(away)
        space = SPACING_BL * 0.5 * (fishes.length[i] + fishes.length[j])
        if distance < 1.5 * space:
            crowd = 1.5 - distance / space
            out = plus(out, times(1.8 * crowd / max(distance, 0.1), away))
        velocity = vector(fishes.velocity[j])
        ahead = plus(ahead, times(1.0 / max(norm(velocity), 1.0), velocity))
        count += 1
    return plus(out, times(0.7 / max(count, 1), ahead))


@njit(cache=True, error_model="numpy")
def _keep_pace(fishes: Fishes, minds: Minds, i: int) -> float:
    """Faster when behind the leader or far away, slower when ahead of it."""
    leader = minds.leader[i]
    gap = minus(vector(fishes.position[leader]), vector(fishes.position[i]))
    behind = dot(gap, vector(fishes.goal_direction[leader])) / (FOLLOW_BL * fishes.length[i])
    distance = norm(gap) / (FOLLOW_BL * fishes.length[i])
    pace = fishes.goal_speed[leader] + 0.25 * behind + 0.08 * (fishes.identity[i] - 0.5)
    pace += 0.5 * max(distance - 1.5, 0.0)
    return min(max(pace, 0.08), 1.0)
