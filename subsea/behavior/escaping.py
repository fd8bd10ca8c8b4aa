"""Escaping from a predator by eleven rules (Tu §7.9.2), beginning with a C-start when attacked.

A fish starts when the predator looms: when the angle that it subtends grows fast (Domenici and
Blake, J. Exp. Biol. 200:1165, 1997). A predator that is near or fast is answered within a tick,
one at the threshold after 0.1 s, and one behind the fish late.

A fish flees from a far predator so that it keeps it at the edge of its field of view. So fishes of
a school part before the predator and meet again behind it, like a fountain (Hall, Wardle and
MacLennan, Mar. Biol. 91:143, 1986). It turns the same way to a threat that it remembers, to see
whether it comes after it.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import burst, mouth_of, set_urge
from subsea.behavior.schooling import has_school
from subsea.behavior.threat_memory import (
    flees_from_memory,
    is_warned,
    knows_threat,
    place_of,
)
from subsea.behavior.vigilance import is_hidden
from subsea.geometry.noise import uniform
from subsea.geometry.periodic import nearest_image
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import Vector, dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.state import (
    EAT,
    ESCAPE,
    FEAR,
    HULL_CM,
    NOBODY,
    PREY,
    SUBMARINE,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.feelings import dread_of, feel

CLOSE = 0.6  # share of D0 within which a predator is close
FRONT_RAD = np.radians(45.0)  # bearing below which it is in front ...
BEHIND_RAD = np.radians(135.0)  # ... and beyond which it is behind
ALIKE_RAD = np.radians(45.0)  # headings that differ by less are the same ...
OPPOSITE_RAD = np.radians(135.0)  # ... and up to this perpendicular
TURN_BACK_RAD = np.radians(175.0)  # a half turn, with a side to turn by
EDGE_RAD = np.radians(140.0)  # bearing at which it keeps what it flees from: still in view
DODGE_RAD = np.radians(30.0), np.radians(75.0)  # from a predator that is close, or touches
STEEP = 0.5  # steepest escape up or down, as a share of the level way
LOOMS_RAD_S = 0.5  # growth of the angle that a predator subtends at which a fish starts ...
BEHIND = 1.0  # ... and by how much more, as a share, if it comes from straight behind
LATENCY_S = 0.1  # delay of a start at the threshold; shorter for a greater stimulus
LEAST_START, MOST_START = 0.6, 2.6  # rad, range of C-starts; straight ahead without one
SPREAD_RAD = 0.7  # range of angles by which starts differ: the direction is not to be foreseen
REFRACTORY_S = 1.5  # shortest time until the next start
FLIGHT_S = 2.0  # length of the burst after a start ...
COMMITTED_S = 0.8  # ... in which a fish flees on at first, whether it sees the predator or not
STILL_PANICKED = 0.95  # share of f1 below which a fish that flees is no longer in panic
CAUTIOUS, FROZEN = 0.5, 0.03  # shares of the fastest speed: fear is just over f0; hidden
FROM_ALL_SIDES = 2.0  # by how much more starts from a predator in contact differ, as a share
GRUDGE = 0.2  # 1/s: dislike that grows for a predator that chases the fish
START_PURPOSE = np.int64(81)  # key of the random numbers
ADRIFT_CM_S = 5.0  # a slower submarine is taken to head for the fish


class Danger(NamedTuple):
    """A predator relative to the fleeing fish, in the horizontal plane; angles left positive."""

    near: float  # 0 at the limit of close, 1 at contact; below 0 it is far
    bearing: float  # rad, from the heading of the fish to the predator
    course: float  # rad, from the heading of the fish to that of the predator
    approaches: bool
    above: float  # sine of the angle by which the predator is higher


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Fear above f0, of prey without a school or that see a predator as fearful as f1 (Tu §7.5).

    A fish that has no leader, such as the leader itself, is without a school. An attack in the
    open scatters the fishes that it is aimed at, however calm they were, and so do companions
    that start. A fish that has started sees its flight through.
    """
    now = clock.tick * clock.dt
    for i in who:
        fear = minds.mental[i, FEAR]
        out[i] = 0.0
        if minds.kind[i] != PREY or minds.fright[i] == 0.0:
            continue
        if minds.startled[i] < COMMITTED_S:
            out[i] = 1.0
        elif fear > nature.alarmed and knows_threat(minds, i, nature):
            if attacked(fishes, minds, i, sea):
                out[i] = 1.0
            elif not has_school(minds, i, now) or panics(minds, i, nature):
                out[i] = fear


@kernel
def attacked(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> bool:
    """True if a predator looms before fish i, or its companions start, or it just did."""
    if is_warned(minds, i):
        return True
    if minds.predator[i] == NOBODY:
        return False
    return minds.startled[i] < FLIGHT_S or looming(fishes, minds, i, sea) > LOOMS_RAD_S


@kernel
def panics(minds: Minds, i: int, nature: Nature) -> bool:
    """True if one predator frightens fish i by f1, or did while it flees."""
    if minds.menace[i] >= nature.panicked:
        return True
    return (
        minds.intention[i] == ESCAPE and minds.mental[i, FEAR] >= STILL_PANICKED * nature.panicked
    )


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Turn as the rule says, and climb or dive away from the predator.

    At full speed, unless the predator is far and does not come nearer.

    A fish with a home flees there.
    """
    for i in who:
        if flees_from_memory(minds, i):
            flee_from_memory(fishes, minds, i, sea, nature, clock)
            continue
        danger = danger_of(fishes, minds, i, sea, nature)
        if danger.approaches and is_chased(minds, i):
            feel(minds, i, minds.predator[i], -GRUDGE * minds.pause[i])
        turn = turn_of(rule_of(danger), danger)
        ahead = x_axis(fishes.orientation[i])
        heading = np.arctan2(ahead[1], ahead[0]) + turn
        set_urge(
            minds, i, (np.cos(heading), np.sin(heading), -min(max(danger.above, -STEEP), STEEP))
        )
        fishes.goal_speed[i] = 1.0
        if minds.home_range[i] < np.inf:
            set_urge(minds, i, minus(vector(minds.home[i]), vector(fishes.position[i])))
        warned = is_warned(minds, i) and minds.startled[i] >= REFRACTORY_S
        if warned or is_startled(fishes, minds, i, sea, danger):
            start(fishes, minds, i, turn, max(danger.near, 0.0), clock)
        elif danger.near < 0.0 and not danger.approaches:
            hidden = is_hidden(fishes, minds, i, sea)
            fishes.goal_speed[i] = FROZEN if hidden else calming(minds, i, nature)
        if minds.startled[i] < FLIGHT_S:
            burst(fishes, minds, i)


@kernel
def is_chased(minds: Minds, i: int) -> bool:
    """True if the predator of fish i is after this fish; the submarine is after all that flee."""
    j = minds.predator[i]
    return j == SUBMARINE or (minds.intention[j] == EAT and minds.target[j] == i)


@kernel
def flee_from_memory(
    fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Flee on while the start is fresh, then keep off the place of the threat and look there.

    The speed falls with the fear. A fish that is hidden freezes.
    """
    ahead = x_axis(fishes.orientation[i])
    known = knows_threat(minds, i, nature)
    toward = minus(vector(minds.threat_place[i]), vector(fishes.position[i]))
    bearing = _angle(ahead, toward)
    turn = (EDGE_RAD - abs(bearing)) * (-1.0 if bearing > 0.0 else 1.0)
    if known and is_warned(minds, i) and minds.startled[i] >= REFRACTORY_S:
        start(fishes, minds, i, turn, 1.0, clock)
    if minds.startled[i] < COMMITTED_S:
        burst(fishes, minds, i)
        return
    if not known:
        return  # it keeps its course
    above = toward[2] / max(norm(toward), 1e-6)
    heading = np.arctan2(ahead[1], ahead[0]) + turn
    set_urge(minds, i, (np.cos(heading), np.sin(heading), -min(max(above, -STEEP), STEEP)))
    fishes.goal_speed[i] = calming(minds, i, nature)
    if minds.home_range[i] < np.inf:
        set_urge(minds, i, minus(vector(minds.home[i]), vector(fishes.position[i])))
    if is_hidden(fishes, minds, i, sea):
        fishes.goal_speed[i] = FROZEN


@kernel
def calming(minds: Minds, i: int, nature: Nature) -> float:
    """Share of the fastest speed at which a fish flees that is not pursued: less with its fear."""
    share = (minds.mental[i, FEAR] - nature.alarmed) / max(1.0 - nature.alarmed, 1e-6)
    return CAUTIOUS + (1.0 - CAUTIOUS) * min(max(share, 0.0), 1.0)


@kernel
def start(fishes: Fishes, minds: Minds, i: int, turn: float, near: float, clock: Clock) -> None:
    """Begin a C-start by about `turn` rad; the directions differ more, the nearer the attack.

    So a school that is struck flashes apart in all directions. `near` is 1 at contact.
    """
    spread = SPREAD_RAD * (1.0 + FROM_ALL_SIDES * near * near)
    noise = spread * (uniform(clock.seed, i, clock.tick, START_PURPOSE) - 0.5)
    bend = turn + noise if turn != 0.0 else 0.0
    minds.startled[i] = minds.alert[i] = 0.0
    if abs(bend) >= LEAST_START:
        fishes.startle[i] = min(max(bend, -MOST_START), MOST_START)


@kernel
def is_startled(fishes: Fishes, minds: Minds, i: int, sea: Sea, danger: Danger) -> bool:
    """True if the attack is evident: evidence grows by the looming over its threshold."""
    threshold = LOOMS_RAD_S * (1.0 + BEHIND * abs(danger.bearing) / np.pi)
    stimulus = looming(fishes, minds, i, sea) / threshold
    if stimulus < 1.0 or minds.startled[i] < REFRACTORY_S:
        minds.alert[i] = 0.0
        return False
    minds.alert[i] += np.float32(stimulus * minds.pause[i])
    return minds.alert[i] >= LATENCY_S


@kernel
def looming(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> float:
    """Growth, rad/s, of the angle 2 atan(s/2d) that the predator's body of width s subtends."""
    j = minds.predator[i]
    if j == SUBMARINE:
        there, velocity, width = vector(sea.submarine[:3]), vector(sea.submarine[3:6]), 2 * HULL_CM
    else:
        there, velocity = mouth_of(fishes, j), vector(fishes.velocity[j])
        there = nearest_image(there, vector(fishes.position[i]), fishes.period)
        width = 0.5 * float(fishes.girth[j, 0] + fishes.girth[j, 1])
    toward = minus(there, vector(fishes.position[i]))
    distance = max(norm(toward), 1e-3)
    approach = -dot(toward, minus(velocity, vector(fishes.velocity[i]))) / distance
    return approach * width / (distance * distance + 0.25 * width * width)


@kernel
def danger_of(fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature) -> Danger:
    """The danger to fish i from `minds.predator[i]`, which must not be NOBODY."""
    j = minds.predator[i]
    here, dread = vector(fishes.position[i]), dread_of(minds, i, j, nature)
    velocity = vector(sea.submarine[3:6]) if j == SUBMARINE else vector(fishes.velocity[j])
    toward = minus(place_of(fishes, sea, j, here), here)
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
            return 1  # turn away from it
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
    if rule == 6:
        return from_it * TURN_BACK_RAD
    if rule in (1, 3, 4):  # until it is at the edge of the field of view
        return from_it * max(EDGE_RAD - abs(danger.bearing), 0.0)
    if rule in (10, 11):  # until it is right behind
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
