"""Choose the goals of a school without a leader: its destination, or the goals of its rules.

A share of the fishes knows the goal. The others follow from fish to fish (Couzin et al., Nature
433:513, 2005). Two shares may have two goals.
"""

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.noise import uniform
from subsea.geometry.periodic import nearest_image
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, times, vector
from subsea.kernels import kernel
from subsea.scenario.school_rules import MAX_GOALS
from subsea.state import Clock, Fishes, Minds
from subsea.state.school_rules import (
    GOAL_COLUMNS,
    GOAL_FEEDBACK,
    GOAL_KIND,
    GOAL_SHARE,
    GOAL_X,
    GOALS,
    INFORMED,
    NO_GOAL,
    PLACE,
)

NEAR_GOAL_BL = 6.0  # distance to a place at which its weight fades
OFF_COURSE = 0.1  # least cosine of the angle between heading and goal that feedback reads
GOLDEN = 0.6180339887498949  # shares of fishes in a row are spread evenly by it
INFORMED_PURPOSE = np.int64(80)  # key of the random numbers


@kernel
def lot(i: int, school: int, seed: int) -> float:
    """A number in [0, 1) for fish i, the same throughout a dive.

    Of n fishes in a row, n s have a number below s, give or take one or two.
    """
    drawn = uniform(seed, school, 0, INFORMED_PURPOSE) + GOLDEN * (i - school)
    return drawn - np.floor(drawn)


@kernel
def is_informed(i: int, school: int, rule: Array, clock: Clock) -> bool:
    """True if fish i knows the destination of its school."""
    return i == school or lot(i, school, clock.seed) < rule[INFORMED]


@kernel
def goal_of(fishes: Fishes, minds: Minds, i: int, school: int, clock: Clock) -> Vector:
    """Unit vector to where fish i wants to go, shorter near a place; ZERO if it does not know.

    With feedback it is shorter the more the fish heads elsewhere.
    """
    rule = minds.rules[minds.school_rule[i]]
    if rule[GOALS + GOAL_KIND] == NO_GOAL:
        if not is_informed(i, school, rule, clock):
            return ZERO
        return _toward(fishes, i, vector(minds.waypoint[school]))
    drawn, below, way = lot(i, school, clock.seed), 0.0, ZERO
    for k in range(MAX_GOALS):
        goal = rule[GOALS + k * GOAL_COLUMNS : GOALS + (k + 1) * GOAL_COLUMNS]
        if goal[GOAL_KIND] != NO_GOAL and below <= drawn < below + goal[GOAL_SHARE]:
            way = vector(goal[GOAL_X:])
            if goal[GOAL_KIND] == PLACE:
                way = _toward(fishes, i, way)
        below += goal[GOAL_SHARE]
    if rule[GOAL_FEEDBACK] > 0.0 and norm(way) > 0.0:
        cosine = dot(x_axis(fishes.orientation[i]), way) / norm(way)
        way = times(max(cosine, OFF_COURSE) ** rule[GOAL_FEEDBACK], way)
    return way


@kernel
def _toward(fishes: Fishes, i: int, place: Vector) -> Vector:
    here = vector(fishes.position[i])
    way = minus(nearest_image(place, here, fishes.period), here)
    return times(1.0 / max(norm(way), NEAR_GOAL_BL * fishes.length[i]), way)
