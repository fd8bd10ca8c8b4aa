"""What can be measured in a record of a simulation: pure functions, each over a whole record.

docs/records.md defines every measure in words.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from subsea.core.arrays import Array, Bools, Ints
from subsea.core.kernels import kernel
from subsea.geometry.height_field import height_at
from subsea.geometry.rotation import rotate
from subsea.geometry.vector import dot, minus, norm, plus, times, vector
from subsea.state import (
    ASCENDING,
    AVOID,
    CIRCLING,
    ESCAPE,
    FEAR,
    HUNGER,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    NUZZLING,
    PREDATOR,
    PREY,
    SCHOOL,
)
from subsea.study.record import STATIONS, Record

BARRIERS = ("wall", "surface", "seabed", "pillar", "rock")
SAMPLE_S = 0.2  # how often the shape of schools is looked at
SATED_BELOW, SATURATED_S = 0.99, 60.0  # hunger above that for so long is saturated
LINK_BL = 4.0  # fishes of a school that are nearer hang together
WHOLE = 0.9  # a school is whole while so much of it hangs together
SPLIT_S = 0.5  # what mends sooner is no split
WARNING_S = 1.0  # fear must come so shortly before an escape
COMPANIONS, COMPANY_BL = 2, 2.5  # in company: so many of its kind so near
BEFORE_S = 3.0  # of the state before a capture
TURNED_DEG, TURNED_S = 60.0, 3.0  # a rejected male turns that far in that time
COURTED_S = 1.0  # what is shorter is no courtship
SEQUENCE = (LOOPING, CIRCLING, ASCENDING, NUZZLING)  # of a complete mating (Tu §7.9.3)


# Bounds and obstacles


def clearances(record: Record) -> tuple[Array, Ints]:
    """How far each fish is from the nearest bound or obstacle (T, n), cm, and which (BARRIERS).

    The least over snout, middle and tail, negative where one of them is outside or inside; of the
    seabed the height above it. Dead fishes are infinitely far away.
    """
    shape = record.alive.shape
    least = np.full(shape, np.inf, np.float32)
    which = np.zeros(shape, np.uint8)
    for points in (record.snout, record.position, record.tail):
        _clear(
            points, record.alive, record.heights, record.half_width_cm, record.radius_cm,
            record.pillars, record.rocks, least, which,
        )  # fmt: skip
    return least, which


@kernel
def _clear(
    points: Array, alive: Bools, heights: Array, half_width: float, radius: float,
    pillars: Array, rocks: Array, least: Array, which: Ints,
) -> None:  # fmt: skip
    """Lower `least` to the clearance of `points` (T, n, 3)."""
    for t in range(points.shape[0]):
        for i in range(points.shape[1]):
            if not alive[t, i]:
                continue
            x, y, z = points[t, i, 0], points[t, i, 1], points[t, i, 2]
            best, code = radius - np.sqrt(x * x + y * y), 0
            if -z < best:
                best, code = -z, 1
            floor = z - height_at(heights, half_width, x, y)
            if floor < best:
                best, code = floor, 2
            for k in range(len(pillars)):
                aside = np.sqrt((x - pillars[k, 0]) ** 2 + (y - pillars[k, 1]) ** 2) - pillars[k, 2]
                above = z - pillars[k, 3]
                if aside > 0.0 and above > 0.0:
                    gap = np.sqrt(aside * aside + above * above)
                else:
                    gap = max(aside, above)
                if gap < best:
                    best, code = gap, 3
            for k in range(len(rocks)):
                gap = _from_rock(rocks[k], x, y, z)
                if gap < best:
                    best, code = gap, 4
            if best < least[t, i]:
                least[t, i], which[t, i] = best, code


@kernel
def _from_rock(rock: Array, x: float, y: float, z: float) -> float:
    """Distance to an ellipsoid along the ray from its centre, negative inside."""
    c, s = np.cos(rock[6]), np.sin(rock[6])
    dx, dy, dz = x - rock[0], y - rock[1], z - rock[2]
    along, across = c * dx + s * dy, c * dy - s * dx
    scaled = np.sqrt((along / rock[3]) ** 2 + (across / rock[4]) ** 2 + (dz / rock[5]) ** 2)
    if scaled < 1e-9:
        return -min(rock[3], rock[4], rock[5])
    return np.sqrt(dx * dx + dy * dy + dz * dz) * (1.0 - 1.0 / scaled)


# Bodies that overlap


def overlaps(record: Record) -> Ints:
    """Whether each fish's body overlaps another's (T, n): 0 no, 1 as meant to, 2 otherwise.

    A body is a row of ellipsoids along its centre line, which runs from the snout over the middle
    to the tail, with the species' half-width and half-height there. Two of them overlap where
    both reach beyond the other's end on the line between their centres: exact for bodies abreast,
    too seldom for some that cross. Courting partners are meant to touch, and hunter and prey.
    """
    outlines = np.stack([record.half_width, record.half_height], axis=2)[record.species]
    sizes = outlines * record.length[:, None, None]
    middle = record.snout_reach / record.length
    found = np.zeros(record.alive.shape, np.uint8)
    _overlap(
        record.snout, record.position, record.tail, record.orientation, record.alive,
        record.partner, record.kind, np.clip(middle, 0.05, 0.95), sizes, found,
    )  # fmt: skip
    return found


@kernel
def _overlap(
    snout: Array, middle: Array, tail: Array, orientation: Array, alive: Bools, partner: Ints,
    kind: Ints, share: Array, sizes: Array, found: Ints,
) -> None:  # fmt: skip
    """Fill `found`; `share` (n,) is how far along the body the middle lies."""
    n = middle.shape[1]
    beads = np.empty((n, STATIONS, 3))
    low, high = np.empty((n, 3)), np.empty((n, 3))
    thick = np.empty(n)
    for i in range(n):
        thick[i] = sizes[i].max()
    for t in range(middle.shape[0]):
        for i in range(n):
            for k in range(STATIONS):
                s = k / (STATIONS - 1.0)
                for axis in range(3):
                    m = middle[t, i, axis]
                    if s < share[i]:
                        a = snout[t, i, axis]
                        beads[i, k, axis] = a + (m - a) * s / share[i]
                    else:
                        b = tail[t, i, axis]
                        beads[i, k, axis] = m + (b - m) * (s - share[i]) / (1.0 - share[i])
            for axis in range(3):
                low[i, axis] = beads[i, :, axis].min() - thick[i]
                high[i, axis] = beads[i, :, axis].max() + thick[i]
        order = np.argsort(low[:, 0], kind="mergesort")
        for a in range(n):
            i = order[a]
            if not alive[t, i]:
                continue
            for b in range(a + 1, n):
                j = order[b]
                if low[j, 0] > high[i, 0]:
                    break
                if (
                    not alive[t, j]
                    or low[j, 1] > high[i, 1] or low[i, 1] > high[j, 1]
                    or low[j, 2] > high[i, 2] or low[i, 2] > high[j, 2]
                ):  # fmt: skip
                    continue
                hunt = min(kind[i], kind[j]) == PREY and max(kind[i], kind[j]) == PREDATOR
                meant = partner[t, i] == j or partner[t, j] == i or hunt
                code = 1 if meant else 2
                if found[t, i] >= code and found[t, j] >= code:
                    continue
                if _touch(
                    beads[i], orientation[t, i], sizes[i], beads[j], orientation[t, j], sizes[j]
                ):
                    found[t, i] = max(found[t, i], code)
                    found[t, j] = max(found[t, j], code)


@kernel
def _touch(a: Array, a_turn: Array, a_size: Array, b: Array, b_turn: Array, b_size: Array) -> bool:
    """Whether a bead of a meets the line through the beads of b, or one of b that of a."""
    return _meets(a, a_turn, a_size, b, b_turn, b_size) or _meets(
        b, b_turn, b_size, a, a_turn, a_size
    )


@kernel
def _meets(a: Array, a_turn: Array, a_size: Array, b: Array, b_turn: Array, b_size: Array) -> bool:
    most = a_size.max() + b_size.max()
    for k in range(STATIONS):
        here = vector(a[k])
        for m in range(STATIONS - 1):
            start = vector(b[m])
            way = minus(vector(b[m + 1]), start)
            long = max(dot(way, way), 1e-9)
            share = min(max(dot(minus(here, start), way) / long, 0.0), 1.0)
            gap = minus(plus(start, times(share, way)), here)
            distance = norm(gap)
            if distance > most:
                continue
            width = (1.0 - share) * b_size[m, 0] + share * b_size[m + 1, 0]
            height = (1.0 - share) * b_size[m, 1] + share * b_size[m + 1, 1]
            spacing = np.sqrt(long)
            reach = _radius(a_turn, a_size[k, 0], a_size[k, 1], spacing, gap, distance)
            reach += _radius(b_turn, width, height, spacing, gap, distance)
            if distance < reach:
                return True
    return False


@kernel
def _radius(
    turn: Array, width: float, height: float, spacing: float, gap: Any, distance: float
) -> float:
    """How far an ellipsoid reaches in the direction of `gap`, cm."""
    if width < 1e-6 or height < 1e-6:
        return 0.0
    if distance < 1e-6:
        return min(width, height)
    x = dot(gap, rotate(turn, (1.0, 0.0, 0.0))) / distance / min(spacing, height)
    y = dot(gap, rotate(turn, (0.0, 1.0, 0.0))) / distance / height
    z = dot(gap, rotate(turn, (0.0, 0.0, 1.0))) / distance / width
    return 1.0 / np.sqrt(x * x + y * y + z * z)


# Minds


def saturated(record: Record) -> Bools:
    """Fish-ticks (T, n) of hunger that has stayed full, with plankton to be had, beyond a minute.

    Of those that live on plankton.
    """
    full = (record.mental_state[:, :, HUNGER] >= SATED_BELOW) & record.alive
    full &= (record.plankton > 0)[:, None] & (record.kind != PREDATOR)
    found = np.zeros_like(full)
    for i in range(full.shape[1]):
        for start, end in runs(full[:, i]):
            if (end - start) * record.tick_s > SATURATED_S:
                found[start:end, i] = True
    return found


def time_budget(record: Record) -> Array:
    """Share of its living time that each species gives to each intention (s, b)."""
    budget = np.zeros((len(record.species_names), len(record.intention_names)))
    species = np.broadcast_to(record.species, record.alive.shape)[record.alive]
    np.add.at(budget, (species, record.intention[record.alive]), 1.0)
    return budget / np.maximum(budget.sum(axis=1, keepdims=True), 1.0)


def changes_per_second(record: Record) -> Array:
    """How often each fish changes its intention (n,), per second that it lives."""
    both = record.alive[1:] & record.alive[:-1]
    changed = (np.diff(record.intention.astype(np.int16), axis=0) != 0) & both
    return np.asarray(changed.sum(axis=0) / np.maximum(both.sum(axis=0) * record.tick_s, 1e-9))


def meals(record: Record) -> Bools:
    """Fish-ticks (T, n) in which something was eaten."""
    eaten = np.zeros_like(record.alive)
    eaten[1:] = np.diff(record.last_meal, axis=0) > 0
    return eaten


# Schools


class School(NamedTuple):
    """A school, k times looked at: the fishes of one leader."""

    leader: int
    time: Array  # (k,) s
    members: Ints  # (k,) fishes alive
    cruises: Bools  # (k,), whether half of them or more school, unalarmed
    polarisation: Array  # (k,) length of the mean heading of those that school
    nearest: Array  # (k,) median distance to the nearest of the school, body lengths
    distances: Array  # every such distance while it cruises, body lengths
    together: Array  # (k,) share of those that school in the largest part that hangs together


class Split(NamedTuple):
    """A time in which a school was in parts."""

    leader: int
    start: float  # s
    lasted: float  # s
    rejoined: bool  # or the record ended
    apart: float  # largest share that was not with the largest part


def schools(record: Record) -> list[School]:
    """The shape of every school of three fishes or more, five times a second.

    Those of its fishes count that school at the moment, or avoid something or escape, and the
    leader; the others are about their own errands.
    """
    every = max(round(SAMPLE_S / record.tick_s), 1)
    followed = record.leader[::every]
    leaders = [int(k) for k in np.unique(followed) if k >= 0]
    return [school for leader in leaders if len((school := _school(record, leader, every)).time)]


def _school(record: Record, leader: int, every: int) -> School:
    rows: list[tuple[float, int, bool, float, float, float]] = []
    distances: list[Array] = []
    for t in range(0, len(record.time), every):
        those = record.alive[t] & (record.leader[t] == leader)
        those[leader] = record.alive[t, leader]
        members = np.flatnonzero(those)
        doing = record.intention[t, members]
        led = members == leader
        schooling = members[np.isin(doing, (SCHOOL, AVOID, ESCAPE)) | led]
        if len(members) < 3 or len(schooling) < 2:
            continue
        calm = record.mental_state[t, members, FEAR].max() <= record.alarmed
        cruises = bool(calm and 2 * ((doing == SCHOOL) | led).sum() >= len(members))
        polarisation = float(
            np.linalg.norm(headings(record.orientation[t, schooling]).mean(axis=0))
        )
        nearest, together = _shape(
            record.position[t, schooling].astype(np.float64), record.length[schooling], LINK_BL
        )
        if cruises:
            distances.append(nearest)
        rows.append((
            float(record.time[t]), len(members), cruises, polarisation, float(np.median(nearest)),
            together,
        ))  # fmt: skip
    columns = [np.array(column) for column in zip(*rows, strict=True)] or [np.zeros(0)] * 6
    return School(
        leader=leader,
        time=columns[0],
        members=columns[1],
        cruises=columns[2],
        polarisation=columns[3],
        nearest=columns[4],
        distances=np.concatenate(distances) if distances else np.zeros(0),
        together=columns[5],
    )


@kernel
def _shape(position: Array, length: Array, link: float) -> tuple[Array, float]:
    """Distance to the nearest (m,) in body lengths, and the share of the largest connected part.

    A pair's body length is the mean of both.
    """
    m = len(length)
    order = np.argsort(position[:, 0], kind="mergesort")
    nearest = np.full(m, np.inf)
    part = np.arange(m)
    longest = length.max()
    for a in range(m):
        i = order[a]
        for side in (1, -1):
            b = a + side
            while 0 <= b < m:
                j = order[b]
                along = abs(position[j, 0] - position[i, 0]) / longest
                if along > link and along > nearest[i]:
                    break
                gap = norm(minus(vector(position[j]), vector(position[i])))
                distance = gap / (0.5 * (length[i] + length[j]))
                nearest[i] = min(nearest[i], distance)
                if distance <= link:
                    x, y = _root(part, i), _root(part, j)
                    part[max(x, y)] = min(x, y)
                b += side
    count = np.zeros(m, np.int64)
    for i in range(m):
        count[_root(part, i)] += 1
    return nearest, count.max() / m


@kernel
def _root(part: Ints, i: int) -> int:
    while part[i] != i:
        part[i] = part[part[i]]
        i = part[i]
    return i


def splits(school: School, end: float) -> list[Split]:
    """The times in which less than nine tenths of a school hung together; the record ends at `end`.

    What mends within half a second does not count.
    """
    found = []
    for first, after in runs(school.together < WHOLE):
        rejoined = after < len(school.time)
        lasted = float((school.time[after] if rejoined else end) - school.time[first])
        if lasted >= SPLIT_S:
            apart = float(1.0 - school.together[first:after].min())
            found.append(Split(school.leader, float(school.time[first]), lasted, rejoined, apart))
    return found


def headings(orientation: Array) -> Array:
    """Unit vectors (..., 3) along the body, of quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(orientation, np.float64), -1, 0)
    parts = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    return np.stack(parts, axis=-1)


# Fear and captures


def escapes(record: Record) -> tuple[int, int]:
    """How many escapes began, and of these, how many with alarming fear within a second before."""
    began = (record.intention[1:] == ESCAPE) & (record.intention[:-1] != ESCAPE)
    window = max(round(WARNING_S / record.tick_s), 1)
    fearful = record.mental_state[:, :, FEAR] > record.alarmed
    times_, fishes = np.nonzero(began & record.alive[1:])
    warned = [
        fearful[max(t + 1 - window, 0) : t + 1, i].any()
        for t, i in zip(times_, fishes, strict=True)
    ]
    return len(warned), int(np.sum(warned))


class Captures(NamedTuple):
    """Prey in company and alone: how long it was so, and how many were caught."""

    lost: int  # fishes that died or were landed, of any kind
    caught: tuple[int, int]  # prey in company, and alone, most of three seconds before
    exposed_s: tuple[float, float]  # fish-seconds of prey in company, and alone


def captures(record: Record) -> Captures:
    """Who is caught: prey in company, with two of its species within 2.5 body lengths, or alone."""
    every = max(round(SAMPLE_S / record.tick_s), 1)
    prey = np.flatnonzero(record.kind == PREY)
    last, fishes = np.nonzero(record.alive[:-1] & ~record.alive[1:])
    company = np.zeros((len(range(0, len(record.time), every)), len(prey)), np.bool_)
    alive = record.alive[::every][:, prey]
    if len(prey) > COMPANIONS:
        _company(
            record.position[::every][:, prey], alive, record.species[prey], record.length[prey],
            company,
        )  # fmt: skip
    back = max(round(BEFORE_S / SAMPLE_S), 1)
    caught = [0, 0]
    for t, i in zip(last, fishes, strict=True):
        if record.kind[i] == PREY:
            k = t // every
            before = company[max(k - back + 1, 0) : k + 1, np.searchsorted(prey, i)]
            caught[0 if 2 * before.sum() > len(before) else 1] += 1
    second = every * record.tick_s
    exposed = ((company & alive).sum() * second, (~company & alive).sum() * second)
    return Captures(len(last), (caught[0], caught[1]), (float(exposed[0]), float(exposed[1])))


@kernel
def _company(position: Array, alive: Bools, species: Ints, length: Array, company: Bools) -> None:
    n = len(species)
    count, farthest = np.empty(n, np.int64), COMPANY_BL * length.max()
    for t in range(len(position)):
        count[:] = 0
        order = np.argsort(position[t, :, 0], kind="mergesort")
        for a in range(n):
            i = order[a]
            for b in range(a + 1, n):
                j = order[b]
                if position[t, j, 0] - position[t, i, 0] > farthest:
                    break
                if species[i] != species[j] or not alive[t, i] or not alive[t, j]:
                    continue
                gap = norm(minus(vector(position[t, j]), vector(position[t, i])))
                if gap <= COMPANY_BL * 0.5 * (length[i] + length[j]):
                    count[i] += 1
                    count[j] += 1
        company[t] = (count >= COMPANIONS) & alive[t]


# Courtship


class Courtship(NamedTuple):
    """What a male went through with a female, or with one that did not want him."""

    male: int
    partner: int  # NOBODY if she never became that
    start: float  # s
    lasted: float  # s
    states: tuple[int, ...]  # codes in COURTSHIP, in their order
    complete: bool
    rejected: bool  # it ended before they circled
    turned_away: bool  # by more than 60° within three seconds after


def courtships(record: Record) -> list[Courtship]:
    """Every courtship of every male, in order of time."""
    found = []
    for i in np.flatnonzero(record.male):
        state = record.courtship[:, i]
        for start, end in runs((state != NO_COURTSHIP) & record.alive[:, i]):
            if (end - start) * record.tick_s < COURTED_S:
                continue
            codes = state[start:end]
            order = tuple(int(k) for k in codes[np.insert(np.diff(codes) != 0, 0, True)])
            partners = record.partner[start:end, i]
            partners = partners[partners != NOBODY]
            over = end < len(record.time)
            rejected = over and not set(order) & {CIRCLING, ASCENDING, NUZZLING}
            found.append(
                Courtship(
                    male=int(i),
                    partner=int(np.bincount(partners).argmax()) if len(partners) else NOBODY,
                    start=float(record.time[start]),
                    lasted=(end - start) * record.tick_s,
                    states=order,
                    complete=over and order[-len(SEQUENCE) :] == SEQUENCE,
                    rejected=rejected,
                    turned_away=rejected and turned_after(record, int(i), end - 1) > TURNED_DEG,
                )
            )
    return sorted(found, key=lambda one: (one.start, one.male))


def turned_after(record: Record, fish: int, tick: int) -> float:
    """The largest angle, degrees, between a fish's heading now and in the three seconds after."""
    later = tick + 1 + round(TURNED_S / record.tick_s)
    ways = headings(record.orientation[tick:later, fish])
    return float(np.degrees(np.arccos(np.clip(ways @ ways[0], -1.0, 1.0))).max())


def runs(flags: Bools) -> Iterator[tuple[int, int]]:
    """Beginnings and ends of the stretches in which flags (k,) hold."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2):
        yield int(start), int(end)
