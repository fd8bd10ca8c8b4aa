"""Reefs: placement of corals, sponges and anemones, and the floor that fishes avoid."""

from typing import NamedTuple

import numpy as np

from subsea.core.arrays import Array, Bools, Ints
from subsea.core.disk_cache import cached
from subsea.core.kernels import kernel
from subsea.geometry.vector import dot, minus, store, vector
from subsea.habitat.clearance import clearances
from subsea.habitat.mounds import HEIGHT, dome, variant_of
from subsea.habitat.stone_samples import samples
from subsea.habitat.terrain import heights_at
from subsea.scenario.schema import ReefTable, Scenario
from subsea.state import Reef, Sea


class GrowthForm(NamedTuple):
    """One form of growth. Lengths are shares of the radius of a growth, or cm."""

    height: float  # over its radius
    radius_cm: tuple[float, float]  # of the smallest and the largest
    slope: float  # upward component of the normal of the ground that it prefers, ...
    picky: float  # ... and its tolerance
    sand: float  # how readily it grows on sand, ...
    rock: float  # ... and on rock
    lean: float  # 0 straight up to 1 along the normal of the ground
    foot: float  # radius of its foot


KINDS = {
    "staghorn": GrowthForm(1.0, (12.0, 46.0), 0.9, 0.4, 1.4, 1.0, 0.3, 0.25),
    "bush": GrowthForm(0.8, (6.0, 20.0), 0.7, 0.6, 0.6, 3.0, 0.8, 0.7),
    "table": GrowthForm(0.65, (22.0, 65.0), 0.8, 0.4, 0.6, 1.2, 0.1, 0.15),
    "brain": GrowthForm(0.75, (10.0, 42.0), 0.8, 0.5, 1.2, 1.0, 0.7, 0.9),
    "lettuce": GrowthForm(0.75, (10.0, 34.0), 0.5, 0.6, 0.5, 1.1, 0.5, 0.5),
    "finger": GrowthForm(0.9, (8.0, 24.0), 0.8, 0.4, 0.6, 0.8, 0.5, 0.35),
    "leather": GrowthForm(0.75, (7.0, 22.0), 0.8, 0.4, 0.4, 0.6, 0.4, 0.35),
    "soft": GrowthForm(1.4, (6.0, 19.0), 0.3, 0.5, 0.15, 1.6, 0.6, 0.12),
    "fan": GrowthForm(1.6, (16.0, 48.0), 0.2, 0.6, 0.12, 1.0, 0.35, 0.1),
    "pipes": GrowthForm(2.4, (5.0, 15.0), 0.6, 0.6, 0.3, 0.8, 0.3, 0.5),
    "barrel": GrowthForm(1.6, (12.0, 30.0), 0.9, 0.4, 0.1, 0.1, 0.3, 0.6),
    "anemone": GrowthForm(0.7, (9.0, 20.0), 0.9, 0.4, 0.5, 0.9, 0.5, 0.85),
    "rubble": GrowthForm(0.2, (14.0, 34.0), 1.0, 0.3, 2.2, 0.0, 1.0, 0.8),
    # Dead reef that others grow on; never chosen at random.
    "mound": GrowthForm(HEIGHT, (26.0, 68.0), 1.0, 0.3, 0.0, 0.0, 0.0, 0.95),
}
MOUND, RUBBLE = (list(KINDS).index(name) for name in ("mound", "rubble"))

PACKED = 0.62  # least distance of two growths over the sum of their radii
TRIES = 10  # candidate places for each growth
ROOM_CM = 40.0  # water over a growth
FOOT_CM = 4.0  # least height above the sand of growths on rock
SUNK = 0.06  # share of its radius by which a growth is sunk in the ground
PATCH_CM = 150.0  # size of patches of few kinds
FALL_CM = 55.0  # over which the floor comes down beside a growth
SPOTS_M2 = 50.0  # candidate places per m² of stone
PROBE_CM = 15.0  # baseline of the slope of the ground
STEEPEST = -0.35  # upward component of the normal of the steepest overhang with growths
HEAP = 15  # growths on the sand for each mound
ON_MOUND = 0.75  # share of them on the mound, ...
STEEP = 0.75  # ... within this share of its radius, beyond which it is too steep
SKIRT = 0.15  # share of its radius by which a mound extends below its edge
DEEPEST = 0.4  # share of its height by which a growth may be sunk on a slope
RIM = 8  # places around a foot that are tested
LOW_CM = 7.0  # height below which growths do not raise the floor


class GrowthSites(NamedTuple):
    """Places where something may grow."""

    place: Array  # (n, 3) cm, on the sand, a mound or the drawn stone; NaN: not free
    normal: Array  # (n, 3) of the ground
    limit: Array  # (n,) cm, the largest radius that fits, infinite on sand
    light: Array  # (n,) share of the sky's light that stone lets through
    on_rock: Bools  # (n,)


def grow_reefs(scenario: Scenario, sea: Sea) -> tuple[Sea, Reef]:
    """All reefs of a scenario, and the sea whose floor lies over them."""
    # Without plankton, which differs with every seed and does not affect reefs.
    still = sea._replace(plankton=sea.plankton[:0], absent=sea.absent[:0])
    floor, reef = cached(_grow, scenario.reef, scenario.water.current_cm_s, still)
    return sea._replace(floor=floor), reef


def _grow(
    tables: list[ReefTable], current_cm_s: tuple[float, float], sea: Sea
) -> tuple[Array, Reef]:
    """The reefs of these tables in a sea, and the floor over them."""
    rows: list[Array] = [np.zeros((0, COLUMNS))]
    spots = rock_spots(sea, np.random.default_rng(0x5707)) if tables else None
    for number, table in enumerate(tables):
        rng = np.random.default_rng([table.seed, number, 0x4EEF])
        rows.append(_lay_out(table, sea, spots, np.concatenate(rows), rng, current_cm_s))
    reef = _reef(np.concatenate(rows))
    return floor_over(sea, reef), reef


# Columns of a growth while a reef is laid out.
KIND, RADIUS, TURN, OWN = 0, 1, 2, 3
PLACE, NORMAL, AXIS, ON_ROCK, HUE, LIGHT = slice(4, 7), slice(7, 10), slice(10, 13), 13, 14, 15
COLUMNS = 16


def _lay_out(
    table: ReefTable,
    sea: Sea,
    spots: GrowthSites | None,
    before: Array,
    rng: np.random.Generator,
    current_cm_s: tuple[float, float],
) -> Array:
    """Growths (k, COLUMNS) of one table, largest first, that keep clear of those `before`."""
    names = list(KINDS)
    traits = np.array([KINDS[name][:1] + KINDS[name][1] + KINDS[name][2:] for name in names])
    height, least, most, slope, picky, sand, rock, lean, foot = traits.T
    weights = {str(name): share for name, share in table.kinds.items()}
    weights = weights or dict.fromkeys(names, 1.0)
    share = np.array([weights.get(name, 0.0) for name in names])
    number = table.number * TRIES
    mounds = _mounds(table, sea, spots, rng)
    place, normal, limit, light, on_rock = _candidates(table, sea, spots, mounds, number, rng)
    stony = np.isfinite(limit)
    # Suitability of each place for each kind, patch by patch.
    suits = np.exp(-(((normal[:, 2:] - slope) / picky) ** 2)) * np.where(stony[:, None], rock, sand)
    suits = suits * share * np.exp(2.0 * _patches(place, len(names), rng)) + 1e-12 * share
    cut = np.cumsum(suits, axis=1)
    kind = (rng.uniform(0, 1, (number, 1)) * cut[:, -1:] > cut).sum(axis=1)
    kind = np.minimum(kind, len(names) - 1)
    # One vigour for all candidates of a growth: the largest choose first.
    vigour = np.repeat(np.sort(rng.uniform(0, 1, table.number))[::-1] ** 2.4, TRIES)
    radius = table.size * (least[kind] + vigour * (most - least)[kind])
    tall = height[kind]
    radius = np.minimum(radius, np.maximum(limit, 0.8 * least[kind]))
    radius = np.minimum(radius, (-ROOM_CM - place[:, 2]) / tall)
    tilt = lean[kind, None]
    axis = tilt * normal + (1.0 - tilt) * np.array([0.0, 0.0, 1.0])
    axis += rng.normal(0.0, 0.07, axis.shape)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    reach = foot[kind] * radius
    sunk = np.minimum(_foot_gap(sea, mounds, place, axis, reach), DEEPEST * tall * radius)
    place[:, 2] -= np.where(on_rock, 0.0, sunk)
    turn = rng.uniform(0, 2 * np.pi, number)
    across = np.arctan2(*current_cm_s[::-1]) + np.pi / 2 + rng.normal(0, 0.5, number)
    turn = np.where(kind == names.index("fan"), across, turn)
    hue = 0.9 * _patches(place, len(names), rng)[np.arange(number), kind]
    hue = (hue + rng.normal(0.0, 0.06, number)) % 1.0
    rows = np.column_stack(
        [kind, radius, turn, rng.uniform(0, 1, number), place, normal, axis, on_rock, hue, light]
    )
    fits = (radius > 0.6 * least[kind] * min(table.size, 1.0)) & np.isfinite(place).all(axis=1)
    before = before[before[:, KIND] != MOUND]
    grown = _spaced(rows.reshape(table.number, TRIES, COLUMNS), fits.reshape(-1, TRIES), before)
    return np.concatenate([mounds, grown])


def _mounds(
    table: ReefTable, sea: Sea, spots: GrowthSites | None, rng: np.random.Generator
) -> Array:
    """Rows (m, COLUMNS) of the mounds on the sand around which a table's growths stand."""
    bare = 1.0 if spots is None or not len(spots.place) else 1.0 - table.rock
    m = int(np.ceil(bare * table.number / HEAP))
    if table.position_cm is None:
        turn, out = rng.uniform(0, 2 * np.pi, m), np.sqrt(rng.uniform(0, 1, m))
        flat = 0.92 * sea.radius * out[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    else:
        flat = np.array(table.position_cm) + 0.45 * table.spread_cm * rng.normal(size=(m, 2))
    rows = np.zeros((m, COLUMNS))
    least, most = KINDS["mound"].radius_cm
    rows[:, KIND], rows[:, HUE] = MOUND, rng.uniform(0, 1, m)
    rows[:, RADIUS] = table.size * (least + (most - least) * rng.uniform(0, 1, m) ** 1.5)
    rows[:, TURN], rows[:, OWN] = rng.uniform(0, 2 * np.pi, m), rng.uniform(0, 1, m)
    rows[:, PLACE] = np.column_stack([flat, heights_at(sea.heights, sea.half_width, flat)])
    rows[:, NORMAL] = rows[:, AXIS] = 0.0, 0.0, 1.0
    wide = rows[:, RADIUS]
    hollow = _foot_gap(sea, rows[:0], rows[:, PLACE], rows[:, AXIS], KINDS["mound"].foot * wide)
    rows[:, PLACE.start + 2] -= np.maximum(hollow - SKIRT * wide, 0.0)
    rows[:, LIGHT] = 1.0
    free = clearances(sea.pillars, sea.rocks, rows[:, PLACE]) > 0.0
    return rows[free & (np.hypot(*flat.T) < 0.9 * sea.radius)]


def _spaced(offers: Array, fits: Bools, before: Array) -> Array:
    """The first free one of the candidates (k, tries, COLUMNS) of each growth."""
    room = np.column_stack([before[:, PLACE], before[:, RADIUS]])
    taken = np.concatenate([room, np.zeros((len(fits), 4))])
    choice = _first_free(offers[..., PLACE], offers[..., RADIUS], fits, taken, len(room))
    grown = np.flatnonzero(choice >= 0)
    return np.asarray(offers[grown, choice[grown]])


@kernel
def _first_free(place: Array, radius: Array, fits: Bools, taken: Array, count: int) -> Ints:
    """The first try (k,) of places (k, tries, 3) that keeps off earlier choices, or -1.

    `taken` (count + k, 4) has `count` places and radii to keep off, and room for those chosen.
    """
    choice = np.full(len(place), -1)
    for k in range(len(place)):
        for i in range(place.shape[1]):
            free = fits[k, i]
            for j in range(count):
                if not free:
                    break
                away = minus(vector(place[k, i]), vector(taken[j]))
                room = PACKED * (radius[k, i] + taken[j, 3])
                free = dot(away, away) >= room * room
            if free:
                choice[k] = i
                store(taken[count], vector(place[k, i]))
                taken[count, 3] = radius[k, i]
                count += 1
                break
    return choice


def _candidates(
    table: ReefTable,
    sea: Sea,
    spots: GrowthSites | None,
    mounds: Array,
    number: int,
    rng: np.random.Generator,
) -> GrowthSites:
    """Candidate places for a table's growths: around its mounds, and on rocks nearby."""
    sand = _sand_sites(table, sea, mounds, number, rng)
    if spots is not None and len(spots.place):
        near = np.ones(len(spots.place))
        if table.position_cm is not None:
            away = ((spots.place[:, :2] - table.position_cm) ** 2).sum(axis=1)
            near = np.exp(-2.0 * away / table.spread_cm**2)
        if near.sum() > 1e-3:
            pick = rng.choice(len(near), number, p=near / near.sum())
            rock = rng.uniform(0, 1, number) < table.rock
            for mine, theirs in zip(sand, spots, strict=True):
                mine[rock] = theirs[pick[rock]]
    inside = np.hypot(sand.place[:, 0], sand.place[:, 1]) < 0.95 * sea.radius
    free = sand.on_rock | (clearances(sea.pillars, sea.rocks, sand.place) > 0.0)
    sand.place[~(inside & free)] = np.nan
    return sand


def _sand_sites(
    table: ReefTable, sea: Sea, mounds: Array, number: int, rng: np.random.Generator
) -> GrowthSites:
    """Places on and around mounds, or on the sand without mounds."""
    here, spread = np.array(table.position_cm or (0.0, 0.0)), table.spread_cm
    flat = here + 0.5 * spread * rng.normal(size=(number, 2))
    if len(mounds):
        heap = mounds[rng.integers(0, len(mounds), number)]
        on, away = rng.uniform(0, 1, number) < ON_MOUND, np.abs(rng.normal(size=number))
        out = np.where(on, STEEP * np.sqrt(rng.uniform(0, 1, number)), 1.05 + 0.6 * away)
        turn = rng.uniform(0, 2 * np.pi, number)
        off = (heap[:, RADIUS] * out)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        flat = heap[:, PLACE][:, :2] + off
    height, under = _ground(sea, mounds, flat)
    step = 0.5 * PROBE_CM * np.array([[1.0, 0.0], [0.0, 1.0]])
    fall = [_ground(sea, mounds, flat - s)[0] - _ground(sea, mounds, flat + s)[0] for s in step]
    normal = np.column_stack([*fall, np.full(number, PROBE_CM)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    limit = np.full(number, np.inf)
    limit[under >= 0] = 0.75 * mounds[under[under >= 0], RADIUS]
    place = np.column_stack([flat, height])
    return GrowthSites(place, normal, limit, np.ones(number), np.zeros(number, np.bool_))


def _ground(sea: Sea, mounds: Array, flat: Array) -> tuple[Array, Ints]:
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


def _foot_gap(sea: Sea, mounds: Array, place: Array, axis: Array, reach: Array) -> Array:
    """Greatest depth (n,) of the ground below the rims of feet of radius `reach`, cm."""
    east = np.cross([0.0, 1.0, 0.0], axis)
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    north = np.cross(axis, east)
    deepest = np.zeros(len(place))
    for turn in np.arange(RIM) * 2 * np.pi / RIM:
        rim = place + reach[:, None] * (np.cos(turn) * east + np.sin(turn) * north)
        gap = rim[:, 2] - _ground(sea, mounds, rim[:, :2])[0]
        np.maximum(deepest, gap, out=deepest, where=gap > 0.0)
    return deepest


def rock_spots(sea: Sea, rng: np.random.Generator) -> GrowthSites:
    """Places all over rocks and pillars."""
    found = samples(sea.pillars, sea.rocks, SPOTS_M2, rng)
    place, normal = found.place, found.normal
    fit = (normal[:, 2] > STEEPEST) & (place[:, 2] < -ROOM_CM) & (found.open > 0.08)
    fit &= place[:, 2] > heights_at(sea.heights, sea.half_width, place[:, :2]) + FOOT_CM
    place, normal, light = place[fit], normal[fit], found.open[fit]
    # Small stones bear small growths.
    sizes = np.concatenate([sea.pillars[:, 2], sea.rocks[:, 3:6].min(axis=1)])
    nearest, limit = np.full(len(place), np.inf), np.zeros(len(place))
    for k, size in enumerate(sizes):
        p = len(sea.pillars)
        rock = sea.rocks[max(k - p, 0) : max(k - p + 1, 0)]
        gap = clearances(sea.pillars[k : k + 1], rock, place)
        limit = np.where(gap < nearest, 0.5 * size + 5.0, limit)
        nearest = np.minimum(nearest, gap)
    return GrowthSites(place, normal, limit, light, np.ones(len(place), np.bool_))


def _patches(place: Array, kinds: int, rng: np.random.Generator) -> Array:
    """Smooth noise (n, kinds) around 0 that says where each kind thrives."""
    at = np.nan_to_num(place)
    out = np.zeros((len(place), kinds))
    for _ in range(4):
        wave = rng.normal(0.0, 2 * np.pi / PATCH_CM / 1.7, (3, kinds))
        out += 0.5 * np.sin(at @ wave + rng.uniform(0, 2 * np.pi, kinds))
    return out


def _reef(rows: Array) -> Reef:
    rows = rows[np.argsort(-rows[:, RADIUS], kind="stable")]
    f = np.float32
    place = rows[:, PLACE] - SUNK * rows[:, RADIUS, None] * rows[:, NORMAL]
    return Reef(
        kind=rows[:, KIND].astype(np.uint8), place=place.astype(f), axis=rows[:, AXIS].astype(f),
        turn=rows[:, TURN].astype(f), radius=rows[:, RADIUS].astype(f), own=rows[:, OWN].astype(f),
        light=rows[:, LIGHT].astype(f), hue=np.minimum(rows[:, HUE], 0.999).astype(f),
        on_rock=rows[:, ON_ROCK] > 0.5,
    )  # fmt: skip


def tops(reef: Reef) -> Array:
    """Greatest height (k,) of each growth, cm."""
    tall = np.array([kind.height for kind in KINDS.values()])[reef.kind]
    up = reef.axis[:, 2]
    aside = np.sqrt(np.maximum(1.0 - up * up, 0.0))
    return np.asarray(reef.place[:, 2] + reef.radius * (tall * np.maximum(up, 0.0) + 0.6 * aside))


def floor_over(sea: Sea, reef: Reef) -> Array:
    """Heights (n, n) float32, cm, of the seabed and smoothly over the growths on it.

    A growth on rock counts if there is only rock below it, so that no arch is filled.
    """
    floor = sea.heights.astype(np.float64)
    n, w = len(floor), sea.half_width
    cell = 2 * w / (n - 1)
    axis = np.linspace(-w, w, n)
    top = tops(reef)
    solid = ~reef.on_rock | _grounded(sea, reef)
    for k in np.flatnonzero(solid):
        x, y, _ = reef.place[k]
        tall = KINDS[list(KINDS)[reef.kind[k]]].height * reef.radius[k]
        if tall < LOW_CM:
            continue
        # The crown of a leaning growth is not above its foot.
        x, y = x + 0.5 * tall * reef.axis[k, 0], y + 0.5 * tall * reef.axis[k, 1]
        inner = reef.radius[k] + 0.72 * cell
        reach = inner + FALL_CM
        i0, i1 = np.searchsorted(axis, (y - reach, y + reach))
        j0, j1 = np.searchsorted(axis, (x - reach, x + reach))
        far = np.hypot(axis[i0:i1, None] - y, axis[None, j0:j1] - x)
        share = np.clip((far - inner) / FALL_CM, 0.0, 1.0)
        share = 0.5 + 0.5 * np.cos(np.pi * share)
        sand = sea.heights[i0:i1, j0:j1]
        part = floor[i0:i1, j0:j1]
        np.maximum(part, sand + share * np.maximum(top[k] - sand, 0.0), out=part)
    return floor.astype(np.float32)


def _grounded(sea: Sea, reef: Reef) -> Bools:
    """True if only rock lies between each growth (k,) and the sand below it."""
    place = reef.place.astype(np.float64)
    sand = heights_at(sea.heights, sea.half_width, place[:, :2])
    solid = np.ones(len(place), np.bool_)
    for share in np.arange(1, 9) / 9.0:
        at = place.copy()
        at[:, 2] += share * (sand - place[:, 2])
        solid &= clearances(sea.pillars, sea.rocks, at) < 3.0
    return solid
