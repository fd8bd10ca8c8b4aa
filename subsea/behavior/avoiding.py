"""Avoid collisions with other fishes and with obstacles (Tu §7.8.1)."""

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.schooling import known_by
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import dot, minus, norm, plus, times, unit, vector
from subsea.kernels import kernel
from subsea.state import (
    ASCEND,
    BATHE,
    DESCEND,
    LEFT,
    NOBODY,
    PREDATOR,
    PREY,
    RIGHT,
    SCHOOL,
    SHELTER,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)

ASIDE = 1.5  # weight of turning away against keeping the course
MAKING_ROOM = 0.6  # this weight in a school, so that the fish stays with it
SLOWED = 0.35  # share of the fastest speed while a fish ahead passes
CAREFUL = 0.6  # largest share while it rounds an obstacle
PASSING_BL = 0.05  # a fish whose middle is less far aside is straight ahead


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """1 where perception found a danger of collision, else 0.

    Hunters do not yield to prey, and prey in panic minds its predator alone: `keep_clear` leads
    both past what they meet. Fishes of a school make room for each other by schooling.
    """
    for i in who:
        j = minds.threat[i]
        yields = j != NOBODY and (minds.kind[i] != PREDATOR or minds.kind[j] != PREY)
        if yields and minds.intention[i] == SCHOOL and minds.intention[j] == SCHOOL:
            yields = minds.led[i] or known_by(minds, i) != known_by(minds, j)
        # In cover, contact alone keeps bodies apart.
        yields = yields and not (fishes.close[i] and minds.intention[i] in (BATHE, SHELTER))
        panics = minds.kind[i] == PREY and minds.menace[i] >= nature.panicked
        out[i] = 1.0 if (yields or minds.barrier[i] != -1) and not panics else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Turn aside; where both sides are equal, to the side that the motor preferences favour."""
    for i in who:
        ahead = x_axis(fishes.orientation[i])
        j = minds.threat[i]
        if j == NOBODY and minds.barrier[i] == -1:
            continue  # the danger has just passed: it keeps its course
        if j == NOBODY:
            # `steering.keep_clear` leads around obstacles; a slower fish turns more tightly.
            fishes.goal_speed[i] = min(max(fishes.goal_speed[i], SLOWED), CAREFUL)
            set_urge(minds, i, ahead)
            side = _side(minds, i)
            minds.urge[i, 0] -= 0.4 * side * ahead[1]
            minds.urge[i, 1] += 0.4 * side * ahead[0]
            continue
        away = minus(vector(fishes.position[i]), vector(fishes.position[j]))
        before = -dot(away, ahead)
        aside = plus(away, times(before, ahead))
        if norm(aside) < PASSING_BL * fishes.length[i]:
            side = _side(minds, i)
            aside = (-side * ahead[1], side * ahead[0], 0.01)
        schooling = minds.memory[i] == SCHOOL
        urge = plus(ahead, times(MAKING_ROOM if schooling else ASIDE, unit(aside)))
        if minds.preference[i, ASCEND] < 0.0 < urge[2]:
            urge = (urge[0], urge[1], 0.0)
        if minds.preference[i, DESCEND] < 0.0 > urge[2]:
            urge = (urge[0], urge[1], 0.0)
        set_urge(minds, i, urge)
        if before > 0.0:
            # In a school, fishes behind it would have to slow down too.
            least = max(0.8 * fishes.goal_speed[j], SLOWED) if schooling else SLOWED
            fishes.goal_speed[i] = min(max(fishes.goal_speed[i], SLOWED), least)


@kernel
def _side(minds: Minds, i: int) -> float:
    """1 for left, -1 for right: the preferred side, else a fixed one for each fish."""
    difference = minds.preference[i, LEFT] - minds.preference[i, RIGHT]
    if difference == 0.0:
        return 1.0 if i % 2 == 0 else -1.0
    return 1.0 if difference > 0.0 else -1.0
