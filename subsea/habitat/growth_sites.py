"""Candidate places for growths: on each stone, and on and around each mound on the sand.

Every stone and every mound has random numbers of its own, so that what is moved, added or removed
changes only what grows there.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.habitat.contact import clearances
from subsea.habitat.formations import stone_keys
from subsea.habitat.stone import samples
from subsea.habitat.terrain import FOOT, RADIUS_CM, dome, heights_at, variant_of
from subsea.scenario.schema import ReefTable
from subsea.state import Sea

TRIES = 10  # candidate places for each growth
ROOM_CM = 40.0  # water over a growth
FOOT_CM = 4.0  # least height above the sand of growths on rock
SUNK = 0.06  # share of its radius by which a growth is sunk in the ground
SPOTS_M2 = 50.0  # candidate places per m² of stone
PROBE_CM = 15.0  # baseline of the slope of the ground
STEEPEST = -0.35  # upward component of the normal of the steepest overhang with growths
HEAP = 15  # growths on the sand for each mound
ON_MOUND = 0.75  # share of them on the mound, ...
STEEP = 0.75  # ... within this share of its radius, beyond which it is too steep
SKIRT = 0.15  # share of its radius by which a mound extends below its edge
RIM = 8  # places around a foot that are tested
# Stone that bears a table's share of growths: as much as the ground about its middle, or this share
# of the ground of the whole sea.
STONY = 0.2

# Columns of a growth while a reef is laid out.
KIND, RADIUS, TURN, OWN = 0, 1, 2, 3
PLACE, NORMAL, AXIS, ON_ROCK, HUE, LIGHT = slice(4, 7), slice(7, 10), slice(10, 13), 13, 14, 15
COLUMNS = 16


class GrowthSites(NamedTuple):
    """Places where something may grow."""

    place: Array  # (n, 3) cm, on the sand, a mound or the drawn stone; NaN: not free
    normal: Array  # (n, 3) of the ground
    limit: Array  # (n,) cm, the largest radius that fits, infinite on sand
    light: Array  # (n,) share of the sky's light that stone lets through
    on_rock: Bools  # (n,)


class Spots(NamedTuple):
    """Places all over the stones of a sea."""

    sites: GrowthSites
    stone: Ints  # (n,) the solid of each, pillars before rocks, ascending
    keys: Ints  # (k,) a seed for each solid


class Tries(NamedTuple):
    """Candidate places for n growths, `TRIES` of each in a row, with their random numbers."""

    sites: GrowthSites  # n TRIES of them
    vigour: Array  # (n,) 0 to 1
    chance: Array  # (n TRIES, 3) uniform: kind, identity and turn
    bend: Array  # (n TRIES, 5) normal: axis, turn and hue


def joined(parts: list[Tries]) -> Tries:
    """All candidates in one, those of the most vigorous growths first."""
    vigour = np.concatenate([part.vigour for part in parts])
    order = np.argsort(-vigour, kind="stable")
    rows = (order[:, None] * TRIES + np.arange(TRIES)).ravel()
    columns = zip(*(part.sites for part in parts), strict=True)
    sites = GrowthSites(*(np.concatenate(column)[rows] for column in columns))
    chance, bend = (np.concatenate([part[k] for part in parts])[rows] for k in (2, 3))
    return Tries(sites, vigour[order], chance, bend)


def _tried(sites: GrowthSites, rng: np.random.Generator) -> Tries:
    """Candidates with random numbers."""
    n = len(sites.place)
    vigour = rng.uniform(size=n // TRIES)
    return Tries(sites, vigour, rng.uniform(size=(n, 3)), rng.normal(size=(n, 5)))


def rock_spots(sea: Sea) -> Spots:
    """Places all over rocks and pillars."""
    found = samples(sea.pillars, sea.rocks, SPOTS_M2)
    place, normal = found.place, found.normal
    fit = (normal[:, 2] > STEEPEST) & (place[:, 2] < -ROOM_CM) & (found.open > 0.08)
    fit &= place[:, 2] > heights_at(sea.heights, sea.half_width, place[:, :2]) + FOOT_CM
    fit &= np.hypot(place[:, 0], place[:, 1]) < 0.95 * sea.radius
    # Small stones bear small growths.
    sizes = np.concatenate([sea.pillars[:, 2], sea.rocks[:, 3:6].min(axis=1)])
    stone = found.stone[fit]
    limit = 0.5 * sizes[stone] + 5.0
    on_rock = np.ones(len(stone), np.bool_)
    sites = GrowthSites(place[fit], normal[fit], limit, found.open[fit], on_rock)
    return Spots(sites, stone, stone_keys(sea.pillars, sea.rocks))


def on_stones(table: ReefTable, number: int, spots: Spots, sea: Sea) -> Iterator[Tries]:
    """Candidates of a table on each stone, as dense as its number over the ground around."""
    near, ground = np.ones(len(spots.stone)), STONY * np.pi * sea.radius**2
    if table.position_cm is not None:
        away = ((spots.sites.place[:, :2] - table.position_cm) ** 2).sum(axis=1)
        near = np.exp(-2.0 * away / table.spread_cm**2)
        ground = 0.5 * np.pi * table.spread_cm**2
    each = table.rock * table.number / (ground / 1e4 * SPOTS_M2)
    bounds = np.searchsorted(spots.stone, np.arange(len(spots.keys) + 1))
    for stone, key in enumerate(spots.keys.tolist()):
        weight = near[bounds[stone] : bounds[stone + 1]]
        whole = float(weight.sum())
        if each * whole < 0.01:
            continue
        rng = np.random.default_rng([table.seed, number, key, 0x4EEF])
        n = int(each * whole + rng.uniform())
        if n:
            pick = bounds[stone] + rng.choice(len(weight), n * TRIES, p=weight / whole)
            yield _tried(GrowthSites(*(part[pick] for part in spots.sites)), rng)


def on_sand(table: ReefTable, number: int, mounds: Array, sea: Sea, wanted: int) -> Iterator[Tries]:
    """Candidates on and around each of a table's mounds (m, COLUMNS), NaN where one is missing."""
    for k, heap in enumerate(mounds):
        n = wanted // len(mounds) + (k < wanted % len(mounds))
        if n == 0 or np.isnan(heap[RADIUS]):
            continue
        rng = np.random.default_rng([table.seed, number, k, 0x5A4D])
        yield _tried(
            _around(heap, mounds[np.isfinite(mounds[:, RADIUS])], sea, n * TRIES, rng), rng
        )


def _around(
    heap: Array, mounds: Array, sea: Sea, number: int, rng: np.random.Generator
) -> GrowthSites:
    """Places on and around a mound."""
    on, away = rng.uniform(0, 1, number) < ON_MOUND, np.abs(rng.normal(size=number))
    out = np.where(on, STEEP * np.sqrt(rng.uniform(0, 1, number)), 1.05 + 0.6 * away)
    turn = rng.uniform(0, 2 * np.pi, number)
    off = (heap[RADIUS] * out)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    flat = heap[PLACE][:2] + off
    height, under = ground(sea, mounds, flat)
    step = 0.5 * PROBE_CM * np.array([[1.0, 0.0], [0.0, 1.0]])
    fall = [ground(sea, mounds, flat - s)[0] - ground(sea, mounds, flat + s)[0] for s in step]
    normal = np.column_stack([*fall, np.full(number, PROBE_CM)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    limit = np.full(number, np.inf)
    limit[under >= 0] = 0.75 * mounds[under[under >= 0], RADIUS]
    place = np.column_stack([flat, height])
    free = clearances(sea.pillars, sea.rocks, place) > 0.0
    place[~free | (np.hypot(*flat.T) > 0.95 * sea.radius)] = np.nan
    return GrowthSites(place, normal, limit, np.ones(number), np.zeros(number, np.bool_))


def make_mounds(table: ReefTable, number: int, kind: int, sea: Sea, wanted: int) -> Array:
    """Rows (m, COLUMNS) of the mounds on the sand, of one `kind`; NaN for one without room."""
    m = -(-wanted // HEAP)
    rows = np.full((m, COLUMNS), np.nan)
    for k in range(m):
        rng = np.random.default_rng([table.seed, number, k, 0x304D])
        if table.position_cm is None:
            turn, out = rng.uniform(0, 2 * np.pi), 0.92 * sea.radius * rng.uniform() ** 0.5
            flat = out * np.array([np.cos(turn), np.sin(turn)])
        else:
            flat = np.array(table.position_cm) + 0.45 * table.spread_cm * rng.normal(size=2)
        row = np.zeros(COLUMNS)
        row[KIND], row[HUE], row[LIGHT] = kind, rng.uniform(), 1.0
        row[RADIUS] = table.size * (RADIUS_CM[0] + np.ptp(RADIUS_CM) * rng.uniform() ** 1.5)
        row[TURN], row[OWN] = rng.uniform(0, 2 * np.pi), rng.uniform()
        row[PLACE] = *flat, heights_at(sea.heights, sea.half_width, flat[None])[0]
        row[NORMAL] = row[AXIS] = 0.0, 0.0, 1.0
        free = clearances(sea.pillars, sea.rocks, row[None, PLACE])[0] > 0.0
        if not free or np.hypot(*flat) > 0.9 * sea.radius:
            continue
        reach = np.array([FOOT * row[RADIUS]])
        hollow = foot_gap(sea, rows[:0], row[None, PLACE], row[None, AXIS], reach)[0]
        row[PLACE.start + 2] -= max(hollow - SKIRT * row[RADIUS], 0.0)
        rows[k] = row
    return rows


def ground(sea: Sea, mounds: Array, flat: Array) -> tuple[Array, Ints]:
    """Height (n,) of the sand or a mound at places (n, 2), and the mound, or -1."""
    flat = np.nan_to_num(flat)
    height = heights_at(sea.heights, sea.half_width, flat)
    under = np.full(len(flat), -1)
    for k, form in enumerate(variant_of(mounds[:, OWN])):
        radius, turn, middle = mounds[k, RADIUS], mounds[k, TURN], mounds[k, PLACE]
        off = (flat - middle[:2]) / radius
        near = np.flatnonzero((off * off).sum(axis=1) < 1.0)
        cos, sin = np.cos(turn), np.sin(turn)
        rise = dome(int(form), off[near] @ np.array([[cos, -sin], [sin, cos]]))
        top = middle[2] + radius * (rise - SUNK)
        over = (rise > 0.0) & (top > height[near])
        height[near[over]], under[near[over]] = top[over], k
    return height, under


def foot_gap(sea: Sea, mounds: Array, place: Array, axis: Array, reach: Array) -> Array:
    """Greatest depth (n,) of the ground below the rims of feet of radius `reach`, cm."""
    east = np.cross([0.0, 1.0, 0.0], axis)
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    north = np.cross(axis, east)
    deepest = np.zeros(len(place))
    for turn in np.arange(RIM) * 2 * np.pi / RIM:
        rim = place + reach[:, None] * (np.cos(turn) * east + np.sin(turn) * north)
        gap = rim[:, 2] - ground(sea, mounds, rim[:, :2])[0]
        np.maximum(deepest, gap, out=deepest, where=gap > 0.0)
    return deepest
