"""Reefs: placement of corals, sponges and anemones, and the floor that fishes avoid."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.disk_cache import cached
from subsea.geometry.vector import dot, minus, store, vector
from subsea.habitat.contact import clearances
from subsea.habitat.formations import formations, stone_above
from subsea.habitat.growth_sites import (
    AXIS,
    COLUMNS,
    HUE,
    KIND,
    LIGHT,
    NORMAL,
    ON_ROCK,
    OWN,
    PLACE,
    RADIUS,
    ROOM_CM,
    SUNK,
    TRIES,
    TURN,
    Spots,
    Tries,
    foot_gap,
    joined,
    make_mounds,
    on_sand,
    on_stones,
    rock_spots,
)
from subsea.habitat.sea import bare
from subsea.habitat.terrain import FOOT, HEIGHT, RADIUS_CM, heights_at
from subsea.kernels import kernel
from subsea.scenario.schema import CoralTable, ReefTable, Scenario
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
    "mound": GrowthForm(HEIGHT, RADIUS_CM, 1.0, 0.3, 0.0, 0.0, 0.0, FOOT),
}
MOUND, RUBBLE = (list(KINDS).index(name) for name in ("mound", "rubble"))

PACKED = 0.62  # least distance of two growths over the sum of their radii
PATCH_CM = 150.0  # size of patches of few kinds
FALL_CM = 55.0  # over which the floor comes down beside a growth
DEEPEST = 0.4  # share of its height by which a growth may be sunk on a slope
LOW_CM = 7.0  # height below which growths do not raise the floor


def grow_reefs(scenario: Scenario, sea: Sea) -> tuple[Sea, Reef]:
    """All reefs of a scenario, and the sea whose floor lies over them."""
    current = scenario.water.current_cm_s
    floor, reef = cached(_grow, scenario.reef, scenario.coral, current, bare(sea))
    return sea._replace(floor=floor), reef


def _grow(
    tables: list[ReefTable], corals: list[CoralTable], current_cm_s: tuple[float, float], sea: Sea
) -> tuple[Array, Reef]:
    """The single corals and the reefs of these tables in a sea, and the floor over them."""
    rows: list[Array] = [_locked(corals, sea)]
    spots = rock_spots(sea) if tables else None
    seen: dict[int, int] = {}
    for table in tables:
        # Tables are counted by seed, so that one more leaves the others as they are.
        number = seen[table.seed] = seen.get(table.seed, -1) + 1
        rows.append(_lay_out(table, number, sea, spots, np.concatenate(rows), current_cm_s))
    reef = _reef(np.concatenate(rows))
    return floor_over(sea, reef), reef


def _locked(corals: list[CoralTable], sea: Sea) -> Array:
    """Growths (k, COLUMNS) that stand where a scenario says, on the sand or the stone above it."""
    rows = np.zeros((len(corals), COLUMNS))
    stones = formations(sea.pillars, sea.rocks) if corals else []
    for row, one in zip(rows, corals, strict=True):
        x, y = one.position_cm
        sand = float(heights_at(sea.heights, sea.half_width, np.array([[x, y]]))[0])
        top = max((stone_above(blocks, x, y, sand) for blocks in stones), default=sand)
        rng = np.random.default_rng([one.seed, 0xC0EA])
        row[KIND], row[RADIUS] = list(KINDS).index(one.kind), one.size_cm
        row[TURN], row[OWN], row[HUE] = np.radians(one.yaw_deg), rng.uniform(), rng.uniform()
        row[PLACE], row[LIGHT], row[ON_ROCK] = (x, y, top), 1.0, top > sand + 1.0
        row[NORMAL] = row[AXIS] = 0.0, 0.0, 1.0
    return rows


def _lay_out(
    table: ReefTable,
    number: int,
    sea: Sea,
    spots: Spots | None,
    before: Array,
    current_cm_s: tuple[float, float],
) -> Array:
    """Growths (k, COLUMNS) of one table, largest first, that keep clear of those `before`."""
    stony = spots is not None and len(spots.stone) > 0
    on_the_sand = round((1.0 - table.rock if stony else 1.0) * table.number)
    heaps = make_mounds(table, number, MOUND, sea, on_the_sand)
    parts = [*on_sand(table, number, heaps, sea, on_the_sand)]
    if spots is not None and stony:
        parts += on_stones(table, number, spots, sea)
    mounds = heaps[np.isfinite(heaps[:, RADIUS])]
    if not parts:
        return mounds
    rows, fits = _candidates(table, number, sea, mounds, joined(parts), current_cm_s)
    before = before[before[:, KIND] != MOUND]
    grown = _spaced(rows.reshape(-1, TRIES, COLUMNS), fits.reshape(-1, TRIES), before)
    return np.concatenate([mounds, grown])


def _candidates(
    table: ReefTable,
    number: int,
    sea: Sea,
    mounds: Array,
    tries: Tries,
    current_cm_s: tuple[float, float],
) -> tuple[Array, Bools]:
    """A growth for each candidate place: rows (n, COLUMNS), and True where it fits."""
    names, wave = list(KINDS), np.random.default_rng([table.seed, number, 0x4EEF])
    traits = np.array([KINDS[name][:1] + KINDS[name][1] + KINDS[name][2:] for name in names])
    height, least, most, slope, picky, sand, rock, lean, foot = traits.T
    weights = {str(name): share for name, share in table.kinds.items()}
    weights = weights or dict.fromkeys(names, 1.0)
    share = np.array([weights.get(name, 0.0) for name in names])
    place, normal, limit, light, on_rock = tries.sites
    stony = np.isfinite(limit)
    # Suitability of each place for each kind, patch by patch.
    suits = np.exp(-(((normal[:, 2:] - slope) / picky) ** 2)) * np.where(stony[:, None], rock, sand)
    suits = suits * share * np.exp(2.0 * _patches(place, len(names), wave)) + 1e-12 * share
    cut = np.cumsum(suits, axis=1)
    kind = (tries.chance[:, :1] * cut[:, -1:] > cut).sum(axis=1)
    kind = np.minimum(kind, len(names) - 1)
    # The largest choose first.
    radius = table.size * (least + np.repeat(tries.vigour, TRIES)[:, None] ** 2.4 * (most - least))
    radius = radius[np.arange(len(kind)), kind]
    tall = height[kind]
    radius = np.minimum(radius, np.maximum(limit, 0.8 * least[kind]))
    radius = np.minimum(radius, (-ROOM_CM - place[:, 2]) / tall)
    tilt = lean[kind, None]
    axis = tilt * normal + (1.0 - tilt) * np.array([0.0, 0.0, 1.0])
    axis += 0.07 * tries.bend[:, :3]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    gap = foot_gap(sea, mounds, place, axis, foot[kind] * radius)
    place[:, 2] -= np.where(on_rock, 0.0, np.minimum(gap, DEEPEST * tall * radius))
    across = np.arctan2(*current_cm_s[::-1]) + np.pi / 2 + 0.5 * tries.bend[:, 3]
    turn = np.where(kind == names.index("fan"), across, 2 * np.pi * tries.chance[:, 2])
    hue = 0.9 * _patches(place, len(names), wave)[np.arange(len(kind)), kind]
    hue = (hue + 0.06 * tries.bend[:, 4]) % 1.0
    own = tries.chance[:, 1]
    rows = np.column_stack([kind, radius, turn, own, place, normal, axis, on_rock, hue, light])
    fits = (radius > 0.6 * least[kind] * min(table.size, 1.0)) & np.isfinite(place).all(axis=1)
    return rows, fits


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
