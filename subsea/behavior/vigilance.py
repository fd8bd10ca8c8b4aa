"""Vigilance before and during an attack: close up, keep clear, hide, watch and inspect.

A fish answers a threat by degrees. Below f0 it turns an eye to the predator, closes up with its
companions and stops feeding (Magurran and Pitcher, Proc. R. Soc. B 229:439, 1987). A fish of an
alarmed school keeps a clear space about the predator (vacuole), and passes it on its own side
(fountain).
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.threat_memory import flees_from_memory, place_of, wariness
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import (
    far_from_rock,
    from_pillar,
    from_rock,
    height_at,
    is_far_from_rocks,
)
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import FEAR, PREY, SUBMARINE, Clock, Fishes, Minds, Nature, Sea
from subsea.state.feelings import dread_of

ASIDE_RAD = np.radians(35.0)  # from straight away: the predator is at the edge of the field of view
CLEAR = 0.75  # radius of the clear space about a predator, over its D0 ...
PUSH = 2.0  # ... and weight of leaving it, at the predator, beside that of keeping away
REMEMBERED = 0.5  # weight of keeping off the place of a threat out of sight
COVER_BL = 1.2  # distance of stone or seabed that hides a fish
WATCHFUL = 0.3  # desire to watch of a fish that is fully wary
AFTER_S = 2.0  # how long it watches the place where the predator was
HOVER = 0.12  # share of the fastest speed of a fish that watches
ASIDE = 0.35  # part of a watching fish's way that leads away


@kernel
def haste(minds: Minds, i: int, nature: Nature) -> float:
    """How fast an alarmed school swims: 1 before a predator, less as fear fades out of sight."""
    if not flees_from_memory(minds, i):
        return 1.0
    share = (float(minds.mental[i, FEAR]) - nature.alarmed) / max(1.0 - nature.alarmed, 1e-6)
    return min(max(share, 0.0), 1.0)


@kernel
def away_from_threat(fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature) -> Vector:
    """Direction in which a fish of an alarmed school leaves the predator; zero if it knows of none.

    Its length is 1, and more within the clear space about the predator. It leads ASIDE_RAD from
    straight away, to the fish's side of the predator's course. Beyond twice the clear space it is
    the direction for the middle of the school: all flee the same way.
    """
    if flees_from_memory(minds, i):
        if minds.unseen[i] == np.inf:
            return ZERO
        away = minus(vector(fishes.position[i]), vector(minds.threat_place[i]))
        return times(REMEMBERED / max(norm(away), 1.0), away)
    j = int(minds.predator[i])
    here = vector(fishes.position[i])
    there = place_of(fishes, sea, j, here)
    away = minus(here, there)
    distance = max(norm(away), 1.0)
    clear = CLEAR * dread_of(minds, i, j, nature)
    alike = min(max(distance / max(clear, 1.0) - 1.0, 0.0), 1.0)
    if alike > 0.0 and minds.school_size[i] > 1.0:
        common = minus(vector(minds.leader_place[i]), there)
        away = plus(
            times((1.0 - alike) / distance, away), times(alike / max(norm(common), 1.0), common)
        )
    course = vector(sea.submarine[3:6]) if j == SUBMARINE else vector(fishes.velocity[j])
    left = course[0] * away[1] - course[1] * away[0]
    turn = 0.0 if left == 0.0 else ASIDE_RAD if left > 0.0 else -ASIDE_RAD
    c, s = np.cos(turn), np.sin(turn)
    push = 1.0 + PUSH * max(1.0 - distance / max(clear, 1.0), 0.0)
    out = (c * away[0] - s * away[1], s * away[0] + c * away[1], away[2])
    return times(push / max(norm(away), 1e-6), out)


@kernel
def is_hidden(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> bool:
    """True if fish i, which schools with nobody, is close to stone, to the seabed or at home."""
    if minds.schools[i]:
        return False
    here, reach = vector(fishes.position[i]), COVER_BL * float(fishes.length[i])
    if here[2] - height_at(sea.floor, sea.half_width, here[0], here[1]) < reach:
        return True
    for k in range(len(sea.pillars)):
        if from_pillar(sea.pillars[k], here)[1] < reach:
            return True
    clear = is_far_from_rocks(sea.tops, sea.half_width, here, reach)
    for k in range(0 if clear else len(sea.rocks)):
        near = not far_from_rock(sea.rocks[k], here, reach)
        if near and from_rock(sea.rocks[k], here)[1] < reach:
            return True
    return False


@kernel
def watch_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Wariness of prey without a school that see a predator."""
    for i in who:
        out[i] = 0.0
        if minds.kind[i] == PREY and minds.unseen[i] < AFTER_S and not minds.schools[i]:
            out[i] = WATCHFUL * wariness(minds, i, nature)


@kernel
def watch(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Hover broadside to the predator, with an eye on it, and move away slowly."""
    for i in who:
        away = minus(vector(fishes.position[i]), vector(minds.threat_place[i]))
        away = times(1.0 / max(norm((away[0], away[1], 0.0)), 1.0), (away[0], away[1], 0.0))
        side = (-away[1], away[0], 0.0)
        if dot(side, x_axis(fishes.orientation[i])) < 0.0:
            side = times(-1.0, side)
        set_urge(minds, i, plus(side, times(ASIDE, away)))
        fishes.goal_speed[i] = HOVER
