"""Schooling: align with the nearest neighbours, keep with them and apart from them.

Each fish minds its seven nearest companions. Some fishes of a school know its destination; the
others follow from fish to fish (Couzin et al., Nature 433:513, 2005). A school with a leader
follows this fish instead (`behavior/leading.py`).
"""

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import set_urge
from subsea.behavior.detour import detour, rocks_in_way
from subsea.behavior.leading import LOST_S, follow_leader
from subsea.behavior.moods import Temper, deviate, temper_of
from subsea.behavior.school_goals import NEAR_GOAL_BL, goal_of, is_informed
from subsea.behavior.threat_memory import flees_from_memory
from subsea.behavior.vigilance import away_from_threat, haste
from subsea.behavior.wandering import BOUND, redraw
from subsea.geometry.angles import arc_tangent, sine_cosine
from subsea.geometry.periodic import nearest_image
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import FEAR, PREY, Clock, Fishes, Minds, Nature, Sea
from subsea.state.places import place_near
from subsea.state.school_rules import (
    ALIGNMENT,
    ATTENDED,
    ATTRACTION,
    ATTRACTION_BL,
    FULL_ATTRACTION_BL,
    GOAL,
    INERTIA,
    NOISE_RAD,
    PACE_NOISE,
    REJOIN,
    SEPARATION,
    SEPARATION_BL,
)
from subsea.state.schools import known_by

LAYER = 0.65  # factor on vertical distances: the nearest neighbour is at nearly the same depth
FLEE = 1.2  # weight of the way from a predator
CRUISING = 0.62  # share of the fastest speed that a school at ease tends to ...
TENDENCY = 0.6  # ... with this weight against the speed of the neighbours
ALONG = 0.25  # change of speed by the attraction and separation along the heading
ALARMED_SPEED = 0.9
GATHERING = 0.5  # factor on the speed of an alarmed school out of sight of the threat
# A fish levels with its nearest LEVELLED companions of the school, unless they are steeply above
# or below: then it leaves their way. So schools have layers (Partridge et al. 1980).
LEVELLED, LEVEL_SINE, LEVELLING = 2, 0.6, 0.8
FLATTENING = 0.1  # weight of the mean height of the neighbours
# A fish keeps its nearest companion as far ahead or behind as aside (Partridge et al. 1980).
DIAGONAL_BL, DIAGONAL_PACE, DIAGONAL_TURN = 1.4, 0.4, 0.4
CLIMBING = 0.25  # noise of the climb over that of the heading
OWN_WAY, COMPANY = 2.0, 0.4  # weights of the way past an obstacle, and of all else meanwhile
LEAST_SPEED = 0.12
# A fish parts from a neighbour that comes nearer as if that were already as near as in FORESEEN_S.
# One farther than FORESEEN_BL beyond its room cannot be there so soon.
FORESEEN_S, FORESEEN_BL, LEAST_BL = 0.3, 0.8, 0.25
# A school of n extends RADIUS_BL n^(1/3) from its middle. A fish beyond the share WITHIN of this
# radius hurries to the middle.
RADIUS_BL, WITHIN, HURRY = 0.9, 0.6, 0.5
SLENDER = 1.25  # a school is this much narrower and longer than round
DIRECT = 2.0  # weight of the angle off the school in the choice of a side, for a fish beyond it
# A straggler has fewer than COMPANIONS companions within STRAGGLING_BL.
STRAGGLING_BL, COMPANIONS = 10.0, 4
LOOSE = 2.2  # factor on the distances of a school at ease in the night


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
def has_school(minds: Minds, i: int, now: float) -> bool:
    """True if fish i likes schooling, belongs to a school, and knows where it or company is.

    A leader follows nobody. The fishes of a school without a leader know where it is, as long as
    there is another one.
    """
    if not minds.schools[i]:
        return False
    company = minds.neighbour[i, 0] >= 0
    remembers = now - minds.leader_seen[i] < LOST_S
    if minds.leader[i] >= 0:
        return company or remembers
    return minds.leads[i] and not minds.led[i] and (company or (
        remembers and minds.school_size[i] > 1.0))  # fmt: skip


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Swim with the neighbours, and around obstacles, or follow the leader."""
    for i in who:
        if minds.led[i]:
            follow_leader(i, fishes, minds, sea, clock)
        else:
            swim_along(i, fishes, minds, sea, nature, clock)


@kernel
def swim_along(
    i: int, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Swim with the neighbours, and around obstacles, in a school without a leader.

    By night a school that is at ease disperses.
    """
    now, loose = clock.tick * clock.dt, LOOSE ** (1.0 - sea.sky[1])
    rule = minds.rules[minds.school_rule[i]]
    here, length = vector(fishes.position[i]), float(fishes.length[i])
    ahead, alarmed = x_axis(fishes.orientation[i]), minds.mental[i, FEAR] > nature.alarmed
    school = known_by(minds, i)
    temper = temper_of(minds, i, loose)
    errand = float(minds.errand[school])
    deviate(minds, i, rule, clock)
    urge, heading, pace = _company(fishes, minds, i, temper)
    middle, outside = way_back(fishes, minds, i, temper.spacing, heading, now)
    cruising = CRUISING * temper.speed * float(minds.activity[i])
    hurries = haste(minds, i, nature) * (1.0 if alarmed else temper.alarm)
    cruising += (ALARMED_SPEED - cruising) * hurries
    if errand > 0.0 and not alarmed:
        cruising = errand * np.sqrt(fishes.length[school] / length)
    if alarmed:
        flees = FLEE
        if flees_from_memory(minds, i):
            # Out of sight of the threat the school gathers: those outside come, the others wait.
            cruising *= GATHERING + (1.0 - GATHERING) * outside
            flees *= 1.0 - outside
        urge = plus(urge, times(flees, away_from_threat(fishes, minds, i, sea, nature)))
    else:
        goal = goal_of(fishes, minds, i, school, clock)
        urge = plus(urge, times(rule[GOAL], goal))
    pace += TENDENCY * (cruising - pace)
    pace *= np.exp(rule[PACE_NOISE] * temper.noise * float(minds.deviation[i, 2]))
    behind = min(dot(middle, ahead), 0.0) * (1.0 - outside)
    wish = plus(urge, times(rule[REJOIN], minus(middle, times(behind, ahead))))
    # All take the side that most head to, or the school would split at an obstacle.
    rocks = rocks_in_way(sea, here, length)
    way = detour(wish, heading, here, length, sea.pillars, rocks, DIRECT * outside)
    if norm(way) > 0.0:
        # It rejoins the others behind the obstacle.
        set_urge(minds, i, plus(times(COMPANY, urge), times(OWN_WAY, way)))
        pace = max(pace, cruising) + HURRY * outside
    else:
        set_urge(minds, i, wish)
        pace += HURRY * dot(middle, ahead)
    fishes.goal_speed[i] = min(max(pace, LEAST_SPEED), 1.0)


@kernel
def way_back(
    fishes: Fishes, minds: Minds, i: int, spacing: float, heading: Vector, now: float
) -> tuple[Vector, float]:
    """The way to the middle of the school of fish i, as long as the second number.

    That is how far the fish is outside, from 0 within the school to 1. `heading` is that of its
    company, and `spacing` a factor on the size of the school.
    """
    if now - minds.leader_seen[i] >= LOST_S:
        return ZERO, 0.0
    middle = minus(vector(minds.leader_place[i]), vector(fishes.position[i]))
    size = max(float(minds.school_size[i]), 1.0) ** (1.0 / 3.0)
    way = stretched(middle, heading, SLENDER)
    outside = norm(way) / (RADIUS_BL * spacing * fishes.length[i] * size) - WITHIN
    outside = min(max(outside, 0.0), 1.0)
    way = stretched(way, heading, SLENDER)
    return times(outside / max(norm(way), 1.0), way), outside


@kernel
def stretched(way: Vector, heading: Vector, by: float) -> Vector:
    """A vector whose part across a heading is `by` times as long, and along it 1/`by` times."""
    level = np.sqrt(heading[0] * heading[0] + heading[1] * heading[1])
    if level < 1e-6 or by == 1.0:
        return way
    x, y = heading[0] / level, heading[1] / level
    along, aside = (way[0] * x + way[1] * y) / by, (way[1] * x - way[0] * y) * by
    return along * x - aside * y, along * y + aside * x, way[2]


@kernel
def _company(fishes: Fishes, minds: Minds, i: int, temper: Temper) -> tuple[Vector, Vector, float]:
    """The urge by the neighbours of fish i, their heading, and their pace.

    Alignment, separation and attraction, with noise. The heading, of any length, is the sum with
    that of fish i. Sums are level, along and across its own heading, and up.
    """
    rule = minds.rules[minds.school_rule[i]]
    here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
    level = max(np.sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1]), 1e-6)
    x, y = ahead[0] / level, ahead[1] / level
    apart, toward, heading, nearest = ZERO, ZERO, ZERO, ZERO
    speed, rise, levelling, count, attended = 0.0, 0.0, 0.0, 0, 0
    for j in minds.neighbour[i]:
        if j < 0 or attended >= rule[ATTENDED]:
            break
        attended += 1
        way = minus(place_near(fishes, j, here), here)
        unit = 1.0 / (0.5 * (fishes.length[i] + fishes.length[j]) * temper.spacing)
        away = unit * (way[0] * x + way[1] * y), unit * (way[1] * x - way[0] * y), unit * way[2]
        distance = max(norm((away[0], away[1], LAYER * away[2])), 0.01)
        full = max(norm(away), 0.01)
        if distance < FORESEEN_BL + rule[SEPARATION_BL]:
            own = minus(vector(fishes.velocity[j]), vector(fishes.velocity[i]))
            closing = -unit * unit * dot(own, way) / full
            foreseen = max(distance - FORESEEN_S * max(closing, 0.0), LEAST_BL)
            push = max(rule[SEPARATION_BL] / foreseen - 1.0, 0.0)
            apart = minus(apart, times(push / full, away))
        if not minds.schools[j] or known_by(minds, j) != known_by(minds, i):
            continue
        heading = plus(heading, x_axis(fishes.orientation[j]))
        pull = (distance - rule[ATTRACTION_BL]) / (rule[FULL_ATTRACTION_BL] - rule[ATTRACTION_BL])
        toward = plus(toward, times(min(max(pull, 0.0), 1.0) / full, away))
        rise += away[2]
        if count == 0:
            nearest = away
        if count < LEVELLED:
            if abs(away[2]) < LEVEL_SINE * full:
                levelling += LEVELLING * away[2] / full
            elif distance < rule[ATTRACTION_BL]:
                levelling -= LEVELLING * away[2] / full
        speed += norm(minus(vector(fishes.velocity[j]), vector(fishes.drift[j])))
        count += 1
    share = 1.0 / max(count, 1)
    keep = plus(times(rule[SEPARATION], apart), times(rule[ATTRACTION] * share, toward))
    diagonal = abs(nearest[1]) - abs(nearest[0])
    diagonal = diagonal if max(abs(nearest[0]), abs(nearest[1])) < DIAGONAL_BL else 0.0
    # Beside a companion it changes its pace, in line with it its way.
    shift = DIAGONAL_TURN * min(diagonal, 0.0) * (1.0 if nearest[1] > 0.0 else -1.0)
    align = share * rule[ALIGNMENT] * temper.alignment
    # It waits for those behind it, and for room ahead, rather than turn back.
    along = rule[INERTIA] + max(keep[0], 0.0) + align * (heading[0] * x + heading[1] * y)
    aside = keep[1] + shift + align * (heading[1] * x - heading[0] * y)
    size = np.sqrt(along * along + aside * aside)
    noise = rule[NOISE_RAD] * temper.noise
    turn = arc_tangent(aside, along) + noise * float(minds.deviation[i, 0])
    climb = keep[2] + levelling + FLATTENING * share * rise + align * heading[2]
    climb += CLIMBING * noise * float(minds.deviation[i, 1]) * size
    sine, cosine = sine_cosine(turn)
    along, aside = size * cosine, size * sine
    urge = along * x - aside * y, along * y + aside * x, climb
    pace = CRUISING
    if count > 0:
        pace = share * speed / fishes.fast[i] + ALONG * keep[0]
        pace += DIAGONAL_PACE * (diagonal if nearest[0] < 0.0 else -diagonal)
    return urge, plus(heading, ahead), pace


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
        here = vector(fishes.position[i])
        toward = minus(nearest_image(vector(minds.waypoint[school]), here, fishes.period), here)
        there = norm(toward) < NEAR_GOAL_BL * fishes.length[i]
        rule = minds.rules[minds.school_rule[i]]
        if there and is_informed(i, school, rule, clock):
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
    if j >= 0 and norm(minus(place_near(fishes, j, here), here)) < reach:
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
                minds.leader[i] = known_by(minds, j)
                minds.leads[minds.leader[i]] = True
                break
