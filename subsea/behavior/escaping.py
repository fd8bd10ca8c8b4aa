"""Escaping from a predator by eleven rules (Tu §7.9.2)."""

from typing import NamedTuple

import numpy as np

from subsea.behavior.chasing import set_urge
from subsea.behavior.schooling import has_school
from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, vector
from subsea.state import FEAR, NOBODY, PREY, SUBMARINE, Clock, Fishes, Minds, Nature, Sea

CLOSE = 0.6  # share of D0 within which a predator is close
FRONT_RAD = np.radians(45.0)  # bearing below which it is in front ...
BEHIND_RAD = np.radians(135.0)  # ... and beyond which it is behind
ALIKE_RAD = np.radians(45.0)  # headings that differ by less are the same ...
OPPOSITE_RAD = np.radians(135.0)  # ... and up to this perpendicular
TURN_BACK_RAD = np.radians(175.0)  # a half turn, with a side to turn by
DODGE_RAD = np.radians(30.0), np.radians(75.0)  # from a predator that is close, or touches
STEEP = 0.5  # steepest escape up or down, as a share of the level way
ADRIFT_CM_S = 5.0  # a slower submarine is taken to head for the fish


class Danger(NamedTuple):
    """A predator relative to the fleeing fish, in the horizontal plane; angles left positive."""

    near: float  # 0 at the limit of close, 1 at contact; below 0 it is far
    bearing: float  # rad, from my heading to where it is
    course: float  # rad, from my heading to its heading
    approaches: bool
    above: float  # sine of the angle by which it is higher


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Fear above f0, of prey without a school or that see a predator as fearful as f1 (Tu §7.5).

    A fish that has no leader, such as the leader itself, is without a school.
    """
    now = clock.tick * clock.dt
    for i in who:
        fear = minds.mental[i, FEAR]
        panics = minds.menace[i] >= nature.panicked or not has_school(minds, i, now)
        sees = minds.predator[i] != NOBODY
        out[i] = (
            fear if minds.kind[i] == PREY and sees and fear > nature.alarmed and panics else 0.0
        )


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Turn as the rule says at full speed, and climb or dive away from the predator."""
    for i in who:
        if minds.predator[i] == NOBODY:
            continue
        danger = danger_of(fishes, minds, i, sea, nature)
        turn = turn_of(rule_of(danger), danger)
        ahead = x_axis(fishes.orientation[i])
        heading = np.arctan2(ahead[1], ahead[0]) + turn
        set_urge(
            minds, i, (np.cos(heading), np.sin(heading), -min(max(danger.above, -STEEP), STEEP))
        )
        fishes.goal_speed[i] = 1.0


@kernel
def danger_of(fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature) -> Danger:
    """The danger to fish i from `minds.predator[i]`, which must not be NOBODY."""
    j = minds.predator[i]
    if j == SUBMARINE:
        there, velocity = vector(sea.submarine[:3]), vector(sea.submarine[3:6])
        dread = nature.submarine_cm
    else:
        there, velocity = vector(fishes.position[j]), vector(fishes.velocity[j])
        dread = float(minds.dread[i])
    toward = minus(there, vector(fishes.position[i]))
    distance = max(norm(toward), 1e-6)
    ahead, course = x_axis(fishes.orientation[i]), velocity
    if j != SUBMARINE:
        course = x_axis(fishes.orientation[j])
    elif norm(velocity) < ADRIFT_CM_S:
        course = (-toward[0], -toward[1], -toward[2])
    return Danger(
        1.0 - distance / max(CLOSE * dread, 1e-6),
        _angle(ahead, toward),
        _angle(ahead, course),
        dot(toward, minus(velocity, vector(fishes.velocity[i]))) < 0.0,
        toward[2] / distance,
    )


@kernel
def rule_of(danger: Danger) -> int:
    """The rule that applies, 1 to 11: four for a far predator, seven for a close one."""
    in_front = abs(danger.bearing) < FRONT_RAD
    behind = abs(danger.bearing) > BEHIND_RAD
    to_the_left = danger.bearing > 0.0
    same_heading = abs(danger.course) < ALIKE_RAD
    perpendicular = ALIKE_RAD <= abs(danger.course) <= OPPOSITE_RAD
    if danger.near < 0.0:
        if in_front:
            return 1  # turn 180 degrees
        if behind:
            return 2  # proceed at full speed
        return 3 if to_the_left else 4  # turn away from it
    if in_front:
        return 5 if perpendicular else 6  # turn away from where it heads; turn 180 degrees
    if behind:
        if same_heading and danger.approaches:
            return 7  # turn away from it, out of its way
        return 8 if perpendicular else 9  # turn away from where it heads; proceed at full speed
    return 10 if to_the_left else 11  # turn away from it


@kernel
def turn_of(rule: int, danger: Danger) -> float:
    """The turn of a rule, rad, left positive."""
    from_it = -1.0 if danger.bearing > 0.0 else 1.0
    from_its_course = -1.0 if danger.course > 0.0 else 1.0
    if rule in (1, 6):
        return from_it * TURN_BACK_RAD
    if rule in (3, 4, 10, 11):  # until it is right behind
        return from_it * (np.pi - abs(danger.bearing))
    if rule == 5:  # until it heads the other way
        return from_its_course * (np.pi - abs(danger.course))
    if rule == 7:
        return from_it * (DODGE_RAD[0] + danger.near * (DODGE_RAD[1] - DODGE_RAD[0]))
    if rule == 8:  # half as far: it is behind already
        return from_its_course * 0.5 * (np.pi - abs(danger.course))
    return 0.0


@kernel
def _angle(a: Vector, b: Vector) -> float:
    """The horizontal angle from a to b, rad in (-π, π], left positive."""
    return np.arctan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])
