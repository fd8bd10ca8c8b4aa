"""Schooling: align with the nearest neighbours, keep with them and apart from them.

Each fish minds its seven nearest companions. Some fishes of a school know its destination; the
others follow from fish to fish (Couzin et al., Nature 433:513, 2005). A school with a leader
follows this fish instead (`behavior/leading.py`).
"""

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.detour import detour
from subsea.behavior.leading import LOST_S, follow_leader
from subsea.behavior.vigilance import away_from_threat, closed_by, haste
from subsea.behavior.wandering import BOUND, redraw
from subsea.geometry.noise import uniform
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import FEAR, PREY, Clock, Fishes, Minds, Nature, Sea

APART_BL, ATTRACT_BL, FAR_BL = 0.8, 1.0, 3.0  # separation within, attraction beyond, full beyond
LAYER = 0.65  # factor on vertical distances: the nearest neighbour is at nearly the same depth
ALIGN, SEPARATE, ATTRACT, GOAL, FLEE = 1.0, 1.3, 0.9, 0.5, 1.2  # weights
INFORMED = 0.2  # share of fishes that know the destination
NEAR_GOAL_BL = 6.0  # distance to the destination at which its weight fades
CRUISING = 0.62  # share of the fastest speed that a school at ease tends to ...
TENDENCY = 0.15  # ... with this weight against the speed of the neighbours
ALONG = 0.25  # change of speed by the attraction and separation along the heading
ALARMED_SPEED = 0.9
OWN_WAY, COMPANY = 2.0, 0.4  # weights of the way past an obstacle, and of all else meanwhile
LEAST_SPEED = 0.3
# A school of n extends RADIUS_BL n^(1/3) from its middle. A fish beyond the share WITHIN of this
# radius hurries to the middle.
RADIUS_BL, WITHIN, REJOIN, HURRY = 0.9, 0.6, 1.2, 0.5
DIRECT = 2.0  # weight of the angle off the school in the choice of a side, for a fish beyond it
# A straggler has fewer than COMPANIONS companions within STRAGGLING_BL.
STRAGGLING_BL, COMPANIONS = 10.0, 4
LOOSE = 2.2  # factor on the distances of a school at ease in the night
INFORMED_PURPOSE = np.int64(80)  # key of the random numbers


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Slightly more than wandering, for fishes that like schooling and know of a school.

    Stronger than curiosity while their school is on an errand.
    """
    now = clock.tick * clock.dt
    for i in who:
        out[i] = 0.02 if has_school(minds, i, now) else 0.0
        if out[i] > 0.0 and not minds.led[i] and minds.errand[known_by(minds, i)] > 0.0:
            out[i] = BOUND


@kernel
def alarmed_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Fear, while no single predator is too fearful (f0 < F, F^m < f1; Tu §7.5)."""
    now = clock.tick * clock.dt
    for i in who:
        fear = minds.mental[i, FEAR]
        afraid = minds.kind[i] == PREY and fear > nature.alarmed
        calm_enough = minds.menace[i] < nature.panicked
        out[i] = fear if afraid and calm_enough and has_school(minds, i, now) else 0.0


@kernel
def known_by(minds: Minds, i: int) -> int:
    """The fish by which the school of fish i is known, or i itself without a school."""
    return int(minds.leader[i]) if minds.leader[i] >= 0 else i


@kernel
def has_school(minds: Minds, i: int, now: float) -> bool:
    """True if fish i likes schooling, belongs to a school, and knows where it or company is.

    A leader follows nobody. The fishes of a school without a leader know where it is, as long as
    there is another one.
    """
    if not minds.schools[i]:
        return False
    company = minds.neighbour[i, 0] >= 0
    if minds.leader[i] >= 0:
        return company or now - minds.leader_seen[i] < LOST_S
    return minds.leads[i] and not minds.led[i] and (company or minds.school_size[i] > 1.0)


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Swim with the neighbours, and around obstacles, or follow the leader.

    By night a school that is at ease disperses.
    """
    loose = LOOSE ** (1.0 - sea.sky[1])
    for i in who:
        if minds.led[i]:
            follow_leader(i, fishes, minds, sea, nature, clock)
            continue
        here, length = vector(fishes.position[i]), float(fishes.length[i])
        alarmed = minds.mental[i, FEAR] > nature.alarmed
        school = known_by(minds, i)
        spacing = closed_by(minds, i, nature) / np.sqrt(float(minds.sociability[i]))
        if not alarmed:
            spacing *= loose
        urge, heading, pace = _company(fishes, minds, i, spacing)
        cruising = CRUISING * float(minds.activity[i])
        if minds.errand[school] > 0.0:
            cruising = minds.errand[school] * np.sqrt(fishes.length[school] / length)
        if alarmed:
            cruising += (ALARMED_SPEED - CRUISING) * haste(minds, i, nature)
            urge = plus(urge, times(FLEE, away_from_threat(fishes, minds, i, sea, nature)))
        elif is_informed(i, school, clock):
            toward = minus(vector(minds.waypoint[school]), here)
            distance = max(norm(toward), NEAR_GOAL_BL * length)
            urge = plus(urge, times(GOAL / distance, toward))
        pace += TENDENCY * (cruising - pace)
        middle = minus(vector(minds.leader_place[i]), here)
        radius = RADIUS_BL * spacing * length * minds.school_size[i] ** (1.0 / 3.0)
        outside = min(max(norm(middle) / radius - WITHIN, 0.0), 1.0)
        middle = times(outside / max(norm(middle), 1.0), middle)
        wish = plus(urge, times(REJOIN, middle))
        # All take the side that most head to, or the school would split at an obstacle.
        way = detour(wish, heading, here, length, sea.pillars, sea.rocks,
                     DIRECT * outside)  # fmt: skip
        if norm(way) > 0.0:
            # It rejoins the others behind the obstacle.
            set_urge(minds, i, plus(times(COMPANY, urge), times(OWN_WAY, way)))
            pace = max(pace, cruising) + HURRY * outside
        else:
            set_urge(minds, i, wish)
            pace += HURRY * dot(middle, x_axis(fishes.orientation[i]))
        fishes.goal_speed[i] = min(max(pace, LEAST_SPEED), 1.0)


@kernel
def is_informed(i: int, school: int, clock: Clock) -> bool:
    """True if fish i knows the destination of its school: the same fishes throughout a dive."""
    return i == school or uniform(clock.seed, i, 0, INFORMED_PURPOSE) < INFORMED


@kernel
def _company(fishes: Fishes, minds: Minds, i: int, spacing: float) -> tuple[Vector, Vector, float]:
    """Alignment, separation and attraction of the neighbours, their heading, and their pace.

    `spacing` is a factor on the distances. Separation counts most from the nearest. The heading,
    of any length, is the mean with that of fish i.
    """
    here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    apart, toward, heading = ZERO, ZERO, ahead
    speed, count = 0.0, 0
    for j in minds.neighbour[i]:
        if j < 0:
            break
        way = minus(vector(fishes.position[j]), here)
        distance = max(norm((way[0], way[1], LAYER * way[2])), 0.1)
        apart_bl = distance / (0.5 * (fishes.length[i] + fishes.length[j]) * spacing)
        way = times(1.0 / distance, way)
        if apart_bl < APART_BL:
            push = 1.0 - apart_bl / APART_BL
            apart = minus(apart, times(push, way))
        if not minds.schools[j] or known_by(minds, j) != known_by(minds, i):
            continue
        heading = plus(heading, x_axis(fishes.orientation[j]))
        pull = min(max((apart_bl - ATTRACT_BL) / (FAR_BL - ATTRACT_BL), 0.0), 1.0)
        toward = plus(toward, times(pull, way))
        speed += norm(minus(vector(fishes.velocity[j]), vector(fishes.drift[j])))
        count += 1
    share = 1.0 / max(count, 1)
    keep = plus(times(SEPARATE, apart), times(ATTRACT * share, toward))
    urge = plus(times(ALIGN / (count + 1.0), heading), keep)
    if count == 0:
        return urge, heading, CRUISING
    return urge, heading, share * speed / fishes.fast[i] + ALONG * dot(keep, ahead)


@kernel
def guide_schools(fishes: Fishes, minds: Minds, sea: Sea, clock: Clock) -> None:
    """Choose new destinations of schools without a leader; runs every tick.

    The destination is the waypoint of the fish by which a school is known. It is redrawn when an
    informed fish is there, or after a while.
    """
    for i in range(len(minds.leader)):
        school = known_by(minds, i)
        if minds.led[i] or not minds.leads[school] or not fishes.alive[i]:
            continue
        if i == school:
            minds.patience[i] -= np.float32(clock.dt)
        toward = minus(vector(minds.waypoint[school]), vector(fishes.position[i]))
        there = norm(toward) < NEAR_GOAL_BL * fishes.length[i]
        if there and is_informed(i, school, clock):
            minds.patience[school] = 0.0
    for i in range(len(minds.leader)):
        done = minds.patience[i] <= 0.0 and minds.errand[i] <= 0.0
        if minds.leads[i] and not minds.led[i] and done:
            redraw(fishes, minds, i, sea, clock)


@kernel
def straggles(fishes: Fishes, minds: Minds, i: int, now: float) -> bool:
    """True if fish i is far from its school, with little company."""
    j = minds.neighbour[i, COMPANIONS - 1]
    here, reach = vector(fishes.position[i]), STRAGGLING_BL * fishes.length[i]
    if j >= 0 and norm(minus(vector(fishes.position[j]), here)) < reach:
        return False
    if minds.leader[i] < 0 or now - minds.leader_seen[i] > LOST_S:
        return False
    return norm(minus(vector(minds.leader_place[i]), here)) > reach


@kernel
def join_schools(who: Ints, alive: NDArray[np.bool_], minds: Minds) -> None:
    """Let fishes that like schooling but have no school join a companion.

    A fish that meets a school joins it; when two loners meet, the school is known by one, which
    leads it if the other follows leaders.
    """
    for i in who:
        if not minds.schools[i] or minds.leader[i] >= 0 or minds.leads[i]:
            continue
        for j in minds.neighbour[i]:
            if j < 0:
                break
            if alive[j] and minds.schools[j]:
                minds.leader[i] = minds.leader[j] if minds.leader[j] >= 0 else j
                minds.leads[minds.leader[i]] = True
                break
