"""Measures of a record: where fishes are, what they intend, and how they touch, eat and court.

docs/reference/records.md defines each measure. Records have T ticks of n fishes.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.periodic import in_box, shortest
from subsea.geometry.rotation import matrix, rotate
from subsea.geometry.solids import from_pillar, from_rock, height_at
from subsea.geometry.vector import dot, minus, norm, plus, times, vector
from subsea.geometry.walls import WALL_CM
from subsea.habitat.formations import drawn_distance, formations
from subsea.kernels import kernel
from subsea.media.record import STATIONS, Record
from subsea.state import (
    ASCENDING,
    CIRCLING,
    EAT,
    ESCAPE,
    FEAR,
    HUNGER,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    NUZZLING,
    PREDATOR,
    PREY,
    SPAWNING,
)

BARRIERS = ("wall", "surface", "seabed", "pillar", "rock")
SAMPLE_S = 0.2  # interval at which the shape of schools is sampled
COMPANIONS, COMPANY_BL = 2, 2.5  # in company: at least 2 of its species within this distance
BEFORE_S = 3.0  # decisive period before a capture
TURNED_DEG, TURNED_S = 60.0, 3.0  # a rejected male turns by that angle within that time
COURTED_S = 1.0  # minimum duration of a courtship
SEQUENCE = (LOOPING, CIRCLING, ASCENDING, NUZZLING, SPAWNING)  # of a complete mating (Tu §7.9.3)
NESTING = (LOOPING, CIRCLING, SPAWNING)  # of one on a nest
SATED_BELOW, SATURATED_S = 0.99, 60.0  # hunger is saturated above this level for this time
WARNING_S = 1.0  # fear must come within this time before an escape
REACH = 1.0  # an attack comes as near as this to its target, lengths of the predator
APART_S = 2.0  # two approaches within this time are one attack
AFTER_S = 1.0  # prey that dies until then was caught by the attack
AT_STONE = ("graze", "shelter", "bathe")  # intentions of fishes that may touch drawn stone
LEAVING_S = 2.0  # how long such a fish needs to leave the shell around it
PERIOD_S = 180.0  # for which catches are counted


def headings(orientation: Array) -> Array:
    """Compute unit vectors (..., 3) along the body of quaternions (..., 4)."""
    return np.asarray(matrix(np.asarray(orientation, np.float64))[..., 0])


def runs(flags: Bools) -> Iterator[tuple[int, int]]:
    """Find beginnings and ends of the stretches in which flags (k,) hold."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    for start, end in edges.reshape(-1, 2):
        yield int(start), int(end)


class Barriers(NamedTuple):
    """The bounds and obstacles of a sea, for the kernel."""

    heights: Array  # (m, m) cm, of the seabed
    half_width_cm: float  # of the seabed's square
    radius_cm: float
    pillars: Array  # (p, 4)
    rocks: Array  # (r, 7)


def clearances(record: Record) -> tuple[Array, Ints]:
    """Measure the distance of each fish from its nearest barrier (T, n), cm, and name that.

    Names are indices in BARRIERS. The distance is the least over snout, middle and tail; it is
    negative where one of them is outside the sea or inside an obstacle. Distances from obstacles
    are those that the fishes perceive; the distance from the seabed is the height above it. Of a
    fish that feeds or hides at stone, or did so until lately, it is the distance from the drawn
    stone, which lies in a shell of free water. Dead fishes are infinitely far away.
    """
    shape = record.alive.shape
    least = np.full(shape, np.inf, np.float32)
    which = np.zeros(shape, np.uint8)
    # Paths in a box go on beyond the sea, and have no wall before them.
    radius_cm = np.inf if record.period[0] else record.radius_cm
    barriers = Barriers(
        record.heights, record.half_width_cm, radius_cm, record.pillars, record.rocks
    )
    for points in (record.snout, record.position, record.tail):
        _lower(points, record.alive, barriers, least, which)
    _from_drawn_stone(record, least, which)
    return least, which


@kernel
def _lower(points: Array, alive: Bools, barriers: Barriers, least: Array, which: Ints) -> None:
    """Lower `least` to the clearance of `points` (T, n, 3)."""
    for t in range(points.shape[0]):
        for i in range(points.shape[1]):
            if not alive[t, i]:
                continue
            x, y, z = float(points[t, i, 0]), float(points[t, i, 1]), float(points[t, i, 2])
            best, code = barriers.radius_cm - np.sqrt(x * x + y * y), 0
            if -z < best:
                best, code = -z, 1
            floor = z - height_at(barriers.heights, barriers.half_width_cm, x, y)
            if floor < best:
                best, code = floor, 2
            for k in range(len(barriers.pillars)):
                gap = from_pillar(barriers.pillars[k], (x, y, z))[1]
                if gap < best:
                    best, code = gap, 0 if barriers.pillars[k, 2] >= WALL_CM else 3
            for k in range(len(barriers.rocks)):
                gap = from_rock(barriers.rocks[k], (x, y, z))[1]
                if gap < best:
                    best, code = gap, 4
            if best < least[t, i]:
                least[t, i], which[t, i] = best, code


class Outside(NamedTuple):
    """Fish-ticks of a species out of bounds or inside obstacles, by snout, middle or tail."""

    species: str
    fish_ticks: int  # alive
    outside: int
    deepest_cm: float  # 0 if none was outside
    barrier: str  # of the deepest, one of BARRIERS
    longest_s: float  # of one fish


def outside(record: Record) -> list[Outside]:
    """Count the fish-ticks outside the free water, for each species in a record.

    A fish that struggles on the hook is lifted out of the water and does not count.
    """
    gaps, which = clearances(record)
    if "struggle" in record.intention_names:
        gaps[record.intention == record.intention_names.index("struggle")] = np.inf
    rows = []
    for k, name in enumerate(record.species_names):
        members = np.flatnonzero(record.species == k)
        if not len(members):
            continue
        gap = gaps[:, members]
        deepest = np.unravel_index(np.argmin(gap), gap.shape)
        stretches = [end - start for column in gap.T for start, end in runs(column < 0.0)]
        rows.append(
            Outside(
                name,
                int(record.alive[:, members].sum()),
                int((gap < 0.0).sum()),
                max(-float(gap[deepest]), 0.0),
                BARRIERS[which[:, members][deepest]],
                max(stretches, default=0) * record.tick_s,
            )
        )
    return rows


def _from_drawn_stone(record: Record, gaps: Array, which: Ints) -> None:
    """Measure `gaps` (T, n) of fishes that feed or hide in the shell of stone from drawn stone.

    In the first `LEAVING_S` of a later part of a dive those of all fishes are.
    """
    names = [k for k, name in enumerate(record.intention_names) if name in AT_STONE]
    there = np.isin(record.intention, names)
    lately = round(LEAVING_S / record.tick_s)
    close = there.copy()
    for back in range(1, lately + 1):
        close[back:] |= there[:-back]
    if record.time[0] > record.tick_s:
        close[:lately] = True  # a later part of a dive does not know what they did before
    ticks, fishes = np.nonzero(close & (gaps < 0.0) & (which >= BARRIERS.index("pillar")))
    if len(ticks) == 0:
        return
    stones = formations(record.pillars, record.rocks)
    for t, i in zip(ticks, fishes, strict=True):
        parts = (record.snout[t, i], record.position[t, i], record.tail[t, i])
        gaps[t, i] = min(drawn_distance(rocks, vector(p)) for rocks in stones for p in parts)


class Captures(NamedTuple):
    """Prey in company and alone: time spent so, and number caught."""

    lost: int  # fishes that died or were landed, of any kind
    caught: tuple[int, int]  # prey in company, and alone, for most of the three seconds before
    exposed_s: tuple[float, float]  # fish-seconds of prey in company, and alone


def captures(record: Record) -> Captures:
    """Count caught prey in company (two of its species within 2.5 body lengths) and alone."""
    every = max(round(SAMPLE_S / record.tick_s), 1)
    prey = np.flatnonzero(record.kind == PREY)
    last, fishes = np.nonzero(record.alive[:-1] & ~record.alive[1:])
    company = np.zeros((len(range(0, len(record.time), every)), len(prey)), np.bool_)
    # Numpy keeps columns together; the kernel is compiled for rows.
    alive = np.ascontiguousarray(record.alive[::every][:, prey])
    position = np.ascontiguousarray(record.position[::every][:, prey])
    if len(prey) > COMPANIONS:
        for (place,) in views(record.period, position):
            near = np.zeros_like(company)
            order = np.argsort(place[..., 0], axis=1, kind="stable")
            groups = place, alive, record.species[prey], record.length[prey]
            _company(order, *groups, near)
            company |= near
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
def _company(
    order: Ints, position: Array, alive: Bools, species: Ints, length: Array, company: Bools
) -> None:
    """Find fishes (T, n) in company; `order` (T, n) lists them by x."""
    n = len(species)
    count, farthest = np.empty(n, np.int64), COMPANY_BL * length.max()
    for t in range(len(position)):
        count[:] = 0
        for a in range(n):
            i = order[t, a]
            for b in range(a + 1, n):
                j = order[t, b]
                if position[t, j, 0] - position[t, i, 0] > farthest:
                    break
                if species[i] != species[j] or not alive[t, i] or not alive[t, j]:
                    continue
                gap = norm(minus(vector(position[t, j]), vector(position[t, i])))
                if gap <= COMPANY_BL * 0.5 * (length[i] + length[j]):
                    count[i] += 1
                    count[j] += 1
        for i in range(n):
            company[t, i] = count[i] >= COMPANIONS and alive[t, i]


class Courtship(NamedTuple):
    """The courtship of one male."""

    male: int
    partner: int  # NOBODY if no female accepted
    start: float  # s
    duration: float  # s
    states: tuple[int, ...]  # codes in COURTSHIP, in order of time
    complete: bool
    rejected: bool  # it ended before they circled
    turned_away: bool  # by more than 60° within three seconds after


def courtships(record: Record) -> list[Courtship]:
    """List every courtship of every male, in order of time."""
    rows = []
    whole = SEQUENCE[: len(record.courtship_names) - LOOPING]  # older records know no spawning
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
            rejected = over and not set(order) & {CIRCLING, ASCENDING, NUZZLING, SPAWNING}
            rows.append(
                Courtship(
                    male=int(i),
                    partner=int(np.bincount(partners).argmax()) if len(partners) else NOBODY,
                    start=float(record.time[start]),
                    duration=(end - start) * record.tick_s,
                    states=order,
                    complete=over and (order[-len(whole) :] == whole or order[-3:] == NESTING),
                    rejected=rejected,
                    turned_away=rejected and turned_after(record, int(i), end - 1) > TURNED_DEG,
                )
            )
    return sorted(rows, key=lambda courtship: (courtship.start, courtship.male))


def turned_after(record: Record, fish: int, tick: int) -> float:
    """Measure by how much a fish turns within three seconds after a tick, degrees."""
    later = tick + 1 + round(TURNED_S / record.tick_s)
    ways = headings(record.orientation[tick:later, fish])
    return float(np.degrees(np.arccos(np.clip(ways @ ways[0], -1.0, 1.0))).max())


def saturated(record: Record) -> Bools:
    """Find fish-ticks (T, n) of plankton eaters whose hunger stays full for over a minute.

    Ticks without plankton do not count.
    """
    full = (record.mental_state[:, :, HUNGER] >= SATED_BELOW) & record.alive
    full &= (record.plankton > 0)[:, None] & (record.kind != PREDATOR)
    long = np.zeros_like(full)
    for i in range(full.shape[1]):
        for start, end in runs(full[:, i]):
            if (end - start) * record.tick_s > SATURATED_S:
                long[start:end, i] = True
    return long


def time_budget(record: Record) -> Array:
    """Measure the share of living time that each species spends on each intention (s, b)."""
    budget = np.zeros((len(record.species_names), len(record.intention_names)))
    species = np.broadcast_to(record.species, record.alive.shape)[record.alive]
    np.add.at(budget, (species, record.intention[record.alive]), 1.0)
    return budget / np.maximum(budget.sum(axis=1, keepdims=True), 1.0)


def changes_per_second(record: Record) -> Array:
    """Count the changes of intention of each fish (n,) per second of its life."""
    both = record.alive[1:] & record.alive[:-1]
    changed = (np.diff(record.intention.astype(np.int16), axis=0) != 0) & both
    return np.asarray(changed.sum(axis=0) / np.maximum(both.sum(axis=0) * record.tick_s, 1e-9))


def meals(record: Record) -> Bools:
    """Find the fish-ticks (T, n) in which something was eaten.

    A direction that holds the hunger of fishes moves their last meal, too, but to an earlier time.
    """
    eaten = np.zeros_like(record.alive)
    before = record.time[:-1, None] - 0.5 * record.tick_s
    eaten[1:] = (np.diff(record.last_meal, axis=0) > 0) & (record.last_meal[1:] > before)
    return eaten


def escapes(record: Record) -> tuple[int, int]:
    """Count escapes, and how many of them follow alarming fear within a second."""
    began = (record.intention[1:] == ESCAPE) & (record.intention[:-1] != ESCAPE)
    window = max(round(WARNING_S / record.tick_s), 1)
    fearful = record.mental_state[:, :, FEAR] > record.alarmed
    times_, fishes = np.nonzero(began & record.alive[1:])
    warned = [
        fearful[max(t + 1 - window, 0) : t + 1, i].any()
        for t, i in zip(times_, fishes, strict=True)
    ]
    return len(warned), int(np.sum(warned))


def views(period: Array, *points: Array) -> Iterator[list[Array]]:
    """List points (…, 3) of bodies as they are, or in a box as four views see them.

    The views are shifted by half a period along x, y, both or none. Each cuts the box elsewhere: so
    bodies near each other are on one side of the cuts in at least one view. The first of the points
    decide where a body is, and the others stay with it.
    """
    if not period[0]:
        yield [*points]
        return
    for part in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)):
        cut = np.append(part * period, 0.0).astype(points[0].dtype)
        origin = points[0] + cut
        yield [in_box(place + cut, origin, period) for place in points]


class BeadBodies(NamedTuple):
    """Bodies as rows of ellipsoids, for the kernel."""

    snout: Array  # (T, n, 3) cm
    middle: Array  # (T, n, 3) cm
    tail: Array  # (T, n, 3) cm
    orientation: Array  # (T, n, 4)
    share: Array  # (n,) position of the middle along the body, 0 to 1
    sizes: Array  # (n, STATIONS, 2) half-width and half-height, cm


def overlaps(record: Record) -> Ints:
    """Find overlaps of each fish's body with another's (T, n): 0 none, 1 intended, 2 unintended.

    A body is a row of ellipsoids along its centre line from the snout over the middle to the tail,
    with the species' half-width and half-height there. Two of them overlap if their radii on the
    line between their centres add up to more than its length. This is exact for bodies side by
    side, but misses some that cross. Courting partners, and hunter and prey, touch intentionally.
    """
    outlines = np.stack([record.half_width, record.half_height], axis=2)[record.species]
    sizes = outlines * record.length[:, None, None]
    middle = record.snout_reach / record.length
    found = np.zeros(record.alive.shape, np.uint8)
    for origin, snout, tail in views(record.period, record.position, record.snout, record.tail):
        bodies = BeadBodies(
            snout, origin, tail, record.orientation, np.clip(middle, 0.05, 0.95), sizes
        )
        _overlap(bodies, record.alive, record.partner, record.kind, found)
    return found


@kernel
def _overlap(bodies: BeadBodies, alive: Bools, partner: Ints, kind: Ints, found: Ints) -> None:
    """Fill `found` (T, n)."""
    snout, middle, tail, orientation, share, sizes = bodies
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
                a_body = beads[i], orientation[t, i], sizes[i]
                b_body = beads[j], orientation[t, j], sizes[j]
                if _meets(a_body, b_body) or _meets(b_body, a_body):
                    found[t, i] = max(found[t, i], code)
                    found[t, j] = max(found[t, j], code)


@kernel
def _meets(a_body: tuple[Array, Array, Array], b_body: tuple[Array, Array, Array]) -> bool:
    """Check if a bead of body a meets the line through the beads of body b.

    A body is its beads, its orientation and its sizes.
    """
    a, a_turn, a_size = a_body
    b, b_turn, b_size = b_body
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
    """Compute the radius of an ellipsoid in the direction of `gap`, cm."""
    if width < 1e-6 or height < 1e-6:
        return 0.0
    if distance < 1e-6:
        return min(width, height)
    x = dot(gap, rotate(turn, (1.0, 0.0, 0.0))) / distance / min(spacing, height)
    y = dot(gap, rotate(turn, (0.0, 1.0, 0.0))) / distance / height
    z = dot(gap, rotate(turn, (0.0, 0.0, 1.0))) / distance / width
    return 1.0 / np.sqrt(x * x + y * y + z * z)


class Predation(NamedTuple):
    """Attacks in a record."""

    attacks: int
    captures: int  # attacks that caught prey
    catches: list[int]  # of each predator in the first PERIOD_S of the dive
    seconds: float  # length of the record

    def rates(self) -> list[float]:
        """Scale the catches of each predator from a shorter record to PERIOD_S."""
        scale = max(PERIOD_S / self.seconds, 1.0)
        return [round(scale * number, 1) for number in self.catches]


def predation(record: Record) -> Predation:
    """Count the attacks and captures of all predators.

    An attack is a period in which the predator hunts and its snout is within its own length of the
    prey that it targets. The predator nearest to prey that dies has caught it.
    """
    seconds = float(record.time[-1] - record.time[0] + record.tick_s)
    hunters = np.flatnonzero(record.kind == PREDATOR)
    caught: dict[int, list[int]] = {int(i): [] for i in hunters}  # ticks
    for t, i in zip(*np.nonzero(record.alive[:-1] & ~record.alive[1:]), strict=True):
        if record.kind[i] == PREY and len(hunters):
            ways = shortest(record.snout[t, hunters] - record.position[t, i], record.period)
            gap = np.linalg.norm(ways, axis=1)
            caught[int(hunters[gap.argmin()])].append(int(t))
    attacks = captures = 0
    for i in hunters:
        found = _attacks(record, int(i))
        after = AFTER_S / record.tick_s
        attacks += len(found)
        captures += sum(
            any(start <= t <= end + after for t in caught[int(i)]) for start, end in found
        )
    last = np.searchsorted(record.time, PERIOD_S)
    catches = [sum(bool(t < last) for t in ticks) for ticks in caught.values()]
    return Predation(attacks, captures, catches, seconds)


def joined(parts: Sequence[Predation]) -> Predation:
    """Join the predation of a dive that was recorded in parts, one after another."""
    attacks, captures, catches, seconds = zip(*parts, strict=True)
    whole = [sum(numbers) for numbers in zip(*catches, strict=True)]
    return Predation(sum(attacks), sum(captures), whole, sum(seconds))


def _attacks(record: Record, i: int) -> list[tuple[int, int]]:
    """Find the first and last ticks of the attacks of fish i."""
    target = record.target[:, i]
    n = record.position.shape[1]
    aims = (record.intention[:, i] == EAT) & record.alive[:, i] & (target >= 0) & (target < n)
    ticks = np.flatnonzero(aims)
    prey = target[ticks]
    ways = shortest(record.snout[ticks, i] - record.position[ticks, prey], record.period)
    near = np.linalg.norm(ways, axis=1)
    close = np.zeros(len(target), np.bool_)
    close[ticks] = (near <= REACH * record.length[i]) & (record.kind[prey] == PREY)
    found: list[tuple[int, int]] = []
    for start, end in runs(close):
        if found and (start - found[-1][1]) * record.tick_s < APART_S:
            found[-1] = found[-1][0], end
        else:
            found.append((start, end))
    return found
