"""Sounds of one tick: events, and beds that sound on."""

import math
from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.language import marked
from subsea.geometry.noise import uniform
from subsea.geometry.solids import height_at
from subsea.habitat.plankton import SLOWEST, departures
from subsea.sound.ambience import Loom, Place, loom_of, place_of, spared
from subsea.sound.score import Mood, mood_of
from subsea.sound.space import METRE, Listener, doppler, fading, toward
from subsea.sound.voices import (
    BUBBLE,
    CREAK,
    CRUNCH,
    KNOCK,
    POP,
    SNAP,
    STRIKE,
    WHOOSH,
    minnaert_hz,
)  # fmt: skip
from subsea.state import HOOKED, PREDATOR, SINKING
from subsea.submarine.vessel import AHEAD_CM_S
from subsea.world.world import TICK_S, World

SURF, CRACKLE, FLOW, MOTOR, SCHOOL, WINCH, BREATH, LAP, SAND, DEEP, LARGE = range(11)
BEDS = (
    "surf", "crackle", "flow", "motor", "school", "winch", "breath", "lap", "sand", "deep", "large",
)  # fmt: skip
SEA, FISHES, VESSEL, SCORE = range(4)
GROUPS = ("sea", "fishes", "vessel", "score")
GROUP_OF_BED = (SEA, SEA, VESSEL, VESSEL, FISHES, SEA, VESSEL, SEA, SEA, SEA, FISHES)
GROUP_OF_VOICE = {SNAP: SEA, BUBBLE: SEA, POP: FISHES, CRUNCH: FISHES, WHOOSH: FISHES,
                  STRIKE: FISHES, KNOCK: VESSEL, CREAK: VESSEL}  # fmt: skip
# Levels at 1 m, or of what is all round, of full scale (designed).
LOUD = {SNAP: 0.60, BUBBLE: 0.10, POP: 0.10, CRUNCH: 0.20, WHOOSH: 0.16, STRIKE: 0.55,
        KNOCK: 0.30, CREAK: 0.05}  # fmt: skip
SURF_LEVEL, CRACKLE_LEVEL, FLOW_LEVEL, MOTOR_LEVEL = 0.07, 0.065, 0.045, 0.08
SCHOOL_LEVEL, WINCH_LEVEL, BREATH_LEVEL = 0.016, 0.12, 0.02
LAP_LEVEL, SAND_LEVEL, DEEP_LEVEL, LARGE_LEVEL = 0.05, 0.035, 0.05, 0.05
SURF_CM, LAP_CM = 500.0, 90.0  # depths in which waves, and their splashes, fade by a factor e
SAND_CM, MOVED_CM = 130.0, 900.0  # height, and depth, in which moving sand does
DEEP_CM = 1200.0  # depth in which the hum of the deep grows to 1 - 1/e
UNDER_ROOF = 0.8  # share of the sounds of the surface that stone above takes
HUSHED = 0.9  # share of the hiss of far snaps that something large silences

# Snaps of a whole reef around: 1,500 to 2,000 a minute in summer (Everest et al. 1948).
SNAPS_S, FEWEST_SNAPS_S = 30.0, 1.0
LIVELY = 1.9  # snaps of a reef at its liveliest, over the mean
REEF_CM = 250.0  # distance and size of a stone that are a whole reef
EARSHOT_CM = 1500.0  # of bubbles, mouths and turns
SCHOOL_CM = 500.0
MOST_EVENTS = 64  # of a tick, the loudest
MOST_STARTS = 2  # in a tick: when a school scatters, its nearest fishes drown the others
MOTOR_HZ, MOTOR_RISE_HZ, WINCH_HZ = 36.0, 44.0, 170.0
# Keys of the random numbers.
COUNT, WHERE, AROUND, LOUDNESS, TOUCH, SETTLE, SIZE = (np.int64(k) for k in range(310, 317))
EVENT_COLUMNS = ("voice", "when", "level", "right", "ahead", "up", "away", "size", "pitch", "seed")
STILL = np.zeros(3)
BED_COLUMNS = ("level", "right", "ahead", "up", "pitch")


Row = tuple[float, ...]
"""An event: EVENT_COLUMNS."""


class Moment(NamedTuple):
    """The sounds of a tick, as a listener hears them."""

    tick: int
    seed: int
    events: Array  # (e, 10) columns EVENT_COLUMNS; `when` in [0, 1) of the tick, `level` as heard
    beds: Array  # (11, 5) rows BEDS, columns BED_COLUMNS at the end of the tick
    words: tuple["HeardSound", ...]  # for captions
    room: float = 0.0  # how enclosed the place is, 0 to 1
    mood: Mood = Mood()


class HeardSound(NamedTuple):
    """A sound that a caption may name."""

    words: str
    way: tuple[float, float, float]  # its direction right, ahead and up; zeros for all round
    level: float
    away: float = METRE  # cm
    leads: bool = False  # whether it announces something that is not seen yet


class Sources(NamedTuple):
    """Stones and vents of a world, which do not move."""

    stones: Array  # (s, 4) middle and size, cm
    vents: Array  # (v, 5) foot, cm, bubbles a second, largest diameter, cm


def sources_of(world: World) -> Sources:
    """The stones and vents of a world."""
    sea = world.state.sea
    rocks = np.column_stack([sea.rocks[:, :3], sea.rocks[:, 3:6].mean(axis=1)])
    low = [height_at(sea.heights, sea.half_width, x, y) for x, y in sea.pillars[:, :2]]
    middles = 0.5 * (sea.pillars[:, 3] + np.array(low)) if low else np.zeros(0)
    pillars = np.column_stack([sea.pillars[:, :2], middles, sea.pillars[:, 2]])
    reef = np.column_stack([world.state.reef.place, world.state.reef.radius])
    vents = [
        (x, y, height_at(sea.heights, sea.half_width, x, y), vent.rate_per_s, vent.size_cm)
        for vent in world.scenario.vent
        for x, y in [vent.position_cm]
    ]
    stones = np.concatenate([rocks, pillars, reef]).astype(np.float64)
    return Sources(stones, np.array(vents, np.float64).reshape(-1, 5))


def hear(world: World, listener: Listener, sources: Sources) -> Moment:
    """The sounds of the tick that the world has just made."""
    rows: list[Row] = []
    words: list[HeardSound] = []
    place = place_of(world, listener)
    gap = world.state.fishes.position - listener.place
    away = np.sqrt(np.einsum("ni,ni->n", gap, gap))
    loom = loom_of(world, listener, gap, away)
    area = _area_around(sources.stones, listener)
    amount = float(min(area.sum(), 1.0))
    if len(loom.fishes):
        area = area * spared(world, loom, sources.stones[:, :3])
    rows += _snaps(world, listener, sources.stones, area, LIVELY * place.reef)
    rows += _bubbles(world, listener, sources.vents)
    for voice, fishes in _acting(world, away):
        places = world.state.fishes.position[fishes].astype(np.float64)
        loud = spared(world, loom, places) if voice in (POP, CRUNCH) else np.ones(len(places))
        for i, position, share in zip(fishes.tolist(), places, loud.tolist(), strict=True):
            row = _event(world, listener, voice, position, world.state.fishes.velocity[i], i)
            row = (*row[:2], share * row[2], *row[3:])
            rows.append(row)
            if voice in CAPTIONS and row[2] > HEARD:
                words.append(HeardSound(CAPTIONS[voice], (row[3], row[4], row[5]), row[2], row[6]))
    if listener.aboard:
        rows += _hull(world, listener)
    beds = _beds(world, listener, amount, place, loom)
    words += _school(world, listener, gap, away, beds[SCHOOL])
    words += _leading(loom, amount * place.reef)
    rows.sort(key=lambda row: -row[2])
    events = np.array(rows[:MOST_EVENTS], np.float64).reshape(-1, len(EVENT_COLUMNS))
    room = min(0.7 * place.roof + 0.5 * place.walls, 1.0)
    mood = mood_of(world, place.depth, away)
    return Moment(world.state.tick, world.state.seed, events, beds, tuple(words), room, mood)


CAPTIONS = {
    STRIKE: marked("a predator strikes"),
    CRUNCH: marked("crunching"),
    WHOOSH: marked("a fish darts off"),
}
HEARD = 0.02  # level from which a sound has a caption
SCHOOL_WORDS, FEW, MOST_SCHOOL = marked("a school passes"), 8, 0.06
LARGE_WORDS, HUSH_WORDS = marked("something large"), marked("the reef falls silent")
STONE, SILENCED = 0.15, 0.5  # least reef that a listener misses, and least hush
CLOSE_CM, FAR_CM = 250.0, 900.0


def _leading(loom: Loom, reef: float) -> list[HeardSound]:
    """Captions of something large that comes, and of the silence before it."""
    if loom.nearest == math.inf:
        return []
    found = [HeardSound(LARGE_WORDS, _row(loom.way), loom.level, loom.nearest, True)]
    if reef > STONE and loom.hush > SILENCED:
        found.append(HeardSound(HUSH_WORDS, (0.0, 0.0, 0.0), loom.hush, METRE, True))
    return found


def _row(way: Array) -> tuple[float, float, float]:
    return float(way[0]), float(way[1]), float(way[2])


def side_of(way: tuple[float, float, float]) -> str:
    """The side of a direction in words; "" for a sound all round."""
    right, ahead, up = way
    if abs(up) > 0.8:
        return marked("above") if up > 0.0 else marked("below")
    if abs(right) > 0.4:
        return marked("left") if right < 0.0 else marked("right")
    if right == ahead == 0.0:
        return ""
    return marked("ahead") if ahead >= 0.0 else marked("behind")


def nearness_of(away: float) -> str:
    """A distance, cm, in words; "" for one of some metres."""
    if away < CLOSE_CM:
        return marked("close")
    return marked("far off") if away > FAR_CM else ""


def _event(
    world: World, listener: Listener, voice: int, place: Iterable[float], velocity: Array, key: int
) -> Row:
    """A row of an event at a place."""
    way, away = toward(listener.axes, listener.place, (*map(float, place),))
    tick, seed = world.state.tick, world.state.seed
    level = LOUD[voice] * fading(away) * (0.6 + 0.4 * uniform(seed, key, tick, LOUDNESS))
    pitch = _doppler(listener, way, velocity)
    own = _seed(seed, tick, key)
    return (voice, uniform(seed, key, tick, WHERE), level, *way, away, 0.0, pitch, own)


def _seed(seed: int, tick: int, key: int) -> float:
    """A seed of an event's noise."""
    return float(int(uniform(seed, key, tick, SIZE) * 2**31))


def _doppler(listener: Listener, way: tuple[float, float, float], velocity: Array) -> float:
    still = velocity is STILL or not velocity.any()
    turned = STILL if still else listener.axes @ np.asarray(velocity, np.float64)
    own = listener.axes @ listener.velocity
    return float(doppler(way, tuple(turned.tolist()), tuple(own.tolist())))


def _area_around(stones: Array, listener: Listener) -> Array:
    """The apparent size of each stone (s,), as a share of a whole reef around."""
    away = np.linalg.norm(stones[:, :3] - listener.place, axis=1)
    return np.asarray((stones[:, 3] / np.maximum(away, REEF_CM)) ** 2)


def _snaps(world: World, listener: Listener, stones: Array, area: Array, share: float) -> list[Row]:
    """Snaps of shrimp in the stones near, a `share` of those of the mean."""
    tick, seed = world.state.tick, world.state.seed
    weight = np.cumsum(area)
    if not len(weight):
        return []
    expected = (FEWEST_SNAPS_S + (SNAPS_S - FEWEST_SNAPS_S) * min(weight[-1], 1.0) * share) * TICK_S
    number = _poisson(expected, uniform(seed, 0, tick, COUNT))
    rows = []
    for k in range(number):
        at = int(np.searchsorted(weight, uniform(seed, k, tick, WHERE) * weight[-1]))
        x, y, z, size = stones[min(at, len(stones) - 1)]
        turn, up = math.tau * uniform(seed, k, tick, AROUND), uniform(seed, k, tick, SIZE)
        flat = math.sqrt(1.0 - up * up)
        on_stone = size * flat * math.cos(turn), size * flat * math.sin(turn), size * up
        place = (x + on_stone[0], y + on_stone[1], z + on_stone[2])
        row = list(_event(world, listener, SNAP, place, STILL, 1000 + k))
        # Claws differ: few snaps are loud.
        row[2] *= 0.25 + 3.0 * uniform(seed, k, tick, TOUCH) ** 6
        rows.append(tuple(row))
    return rows


def _poisson(expected: float, share: float) -> int:
    """A number of events, from a random number in [0, 1)."""
    number, chance = 0, math.exp(-expected)
    total = chance
    while share >= total and number < MOST_EVENTS:
        number += 1
        chance *= expected / number
        total += chance
    return number


def _bubbles(world: World, listener: Listener, vents: Array) -> list[Row]:
    """Bubbles that leave the vents."""
    rows = []
    begin, end = (world.state.tick - 1) * TICK_S, world.state.tick * TICK_S
    for number, (x, y, z, rate, size) in enumerate(vents):
        place = (x, y, z)
        if math.dist(place, listener.place) > EARSHOT_CM:
            continue
        moments, period = _departures(-z, rate, size, number)
        # A slot's first bubble leaves at its moment, and each next one a period later.
        last = moments + period * np.floor((end - moments) / period)
        last = np.where(last >= end, last - period, last)
        since = last - begin
        for slot in np.flatnonzero((last >= begin) & (last >= moments)).tolist():
            key = 5000 + 1000 * number + slot % 1000
            row = list(_event(world, listener, BUBBLE, place, STILL, key))
            share = uniform(world.state.seed, key, world.state.tick, SIZE)
            radius = 0.5 * size * (SLOWEST + (1.0 - SLOWEST) * share)
            row[1], row[7] = float(since[slot]) / TICK_S, minnaert_hz(radius, max(-z, 0.0))
            row[2] *= min(radius / 0.3, 1.5)
            rows.append(tuple(row))
    return rows


_departures = cache(departures)


def _acting(world: World, away: Array) -> list[tuple[int, Ints]]:
    """Fishes within earshot, `away` (n,) cm, that bite, strike or start in this tick."""
    fishes, minds = world.state.fishes, world.state.minds
    begin = (world.state.tick - 1) * TICK_S
    near = away < EARSHOT_CM
    fed = near & (np.abs(minds.last_meal - begin) < 0.4 * TICK_S) & (minds.eaten > 0.0)
    strikes = fed & (minds.kind == PREDATOR)
    crunchers = np.array(["wrasse" in one.name.lower() for one in world.species], np.bool_)
    crunches = fed & ~strikes & crunchers[fishes.species]
    starts = np.flatnonzero(near & fishes.alive & (minds.startled < 1.4 * TICK_S))
    starts = starts[np.argsort(away[starts], kind="stable")[:MOST_STARTS]]
    return [
        (STRIKE, np.flatnonzero(strikes)),
        (CRUNCH, np.flatnonzero(crunches)),
        (POP, np.flatnonzero(fed & ~strikes & ~crunches)),
        (WHOOSH, starts),
    ]


def _hull(world: World, listener: Listener) -> list[Row]:
    """Knocks on stone, and creaks when the depth changes."""
    submarine, seed, tick = world.state.submarine, world.state.seed, world.state.tick
    rows = []
    pushed = submarine.position - submarine.previous_position - TICK_S * submarine.velocity
    push = float(np.linalg.norm(pushed))
    if push > 0.5 and uniform(seed, 0, tick, TOUCH) < 0.2:
        row = list(_event(world, listener, KNOCK, listener.place - METRE * pushed / push,
                          submarine.velocity, 1))  # fmt: skip
        row[2] *= min(push / 4.0, 1.0)
        rows.append(tuple(row))
    sinking = abs(float(submarine.velocity[2])) / 60.0
    if uniform(seed, 0, tick, SETTLE) < 0.008 * min(sinking, 1.5):
        aside = 2.0 * uniform(seed, 1, tick, SETTLE) - 1.0
        place = listener.place + METRE * (aside * listener.axes[0] + listener.axes[2])
        rows.append(_event(world, listener, CREAK, place, submarine.velocity, 2))
    return rows


def _beds(world: World, listener: Listener, amount: float, place: Place, loom: Loom) -> Array:
    """Levels, directions and pitches of the beds, but of a school."""
    beds = np.zeros((len(BEDS), len(BED_COLUMNS)))
    beds[:, 4] = 1.0
    open_above = 1.0 - UNDER_ROOF * place.roof
    beds[SURF, 0] = SURF_LEVEL * open_above * math.exp(-place.depth / SURF_CM)
    beds[LAP, 0] = LAP_LEVEL * open_above * math.exp(-place.depth / LAP_CM)
    beds[SURF, 1:4] = beds[LAP, 1:4] = listener.axes[:, 2]
    beds[CRACKLE, 0] = CRACKLE_LEVEL * math.sqrt(amount) * place.reef * (1.0 - HUSHED * loom.hush)
    bare = (1.0 - math.sqrt(amount)) * place.others
    beds[SAND, 0] = SAND_LEVEL * bare * math.exp(-place.height / SAND_CM - place.depth / MOVED_CM)
    beds[SAND, 1:4] = -listener.axes[:, 2]
    beds[DEEP, 0] = DEEP_LEVEL * place.others * (1.0 - math.exp(-((place.depth / DEEP_CM) ** 2)))
    beds[LARGE, :4] = LARGE_LEVEL * loom.level, *loom.way
    speed = float(np.linalg.norm(listener.velocity))
    share = min(speed / AHEAD_CM_S, 2.0)
    beds[FLOW, 0] = FLOW_LEVEL * share**2 * (1.0 if listener.aboard else 0.3)
    if listener.aboard:
        turning = float(np.abs(world.state.submarine.rates).max())
        thrust = min(share + 0.5 * turning, 1.5)
        beds[MOTOR, 0] = MOTOR_LEVEL * min(thrust, 1.0) * (0.4 + 0.6 * thrust)
        beds[MOTOR, 1:4] = 0.0, -0.8, -0.6  # behind and below
        beds[MOTOR, 4] = MOTOR_HZ + MOTOR_RISE_HZ * thrust
        beds[BREATH, 0] = BREATH_LEVEL
    sea = world.state.sea
    if sea.catch[0] in (SINKING, HOOKED):
        way, away = toward(listener.axes, listener.place, (sea.tackle[0], sea.tackle[1], 0.0))
        beds[WINCH] = (WINCH_LEVEL * fading(away), *way,
                       WINCH_HZ * _doppler(listener, way, np.zeros(3)))  # fmt: skip
    return beds


def _school(
    world: World, listener: Listener, gap: Array, away: Array, bed: Array
) -> list[HeardSound]:
    """Write the rush of fishes that swim close by to their `bed`; returns its caption."""
    fishes = world.state.fishes
    near = np.flatnonzero((away < SCHOOL_CM) & fishes.alive & (away > 1.0))
    if not len(near):
        return []
    speed = np.linalg.norm(fishes.velocity[near] - fishes.drift[near], axis=1)
    size = fishes.length[near] / 20.0
    loud = (speed / 100.0) ** 2 * size**2 * (METRE / np.maximum(away[near], METRE)) ** 2
    total = float(loud.sum())
    bed[0] = min(SCHOOL_LEVEL * math.sqrt(total), MOST_SCHOOL)
    bed[1:4] = listener.axes @ (loud @ (gap[near] / away[near, None])) / max(total, 1e-9)
    heard = len(near) >= FEW and bed[0] > HEARD
    nearest = float(away[near].min())
    return [HeardSound(SCHOOL_WORDS, _row(bed[1:4]), float(bed[0]), nearest)] if heard else []
