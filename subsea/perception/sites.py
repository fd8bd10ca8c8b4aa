"""Find what a fish sees on stone and among corals: food, cover, and shadows of large things.

Sites never move, so that their grids are made once for each sea. Only a hungry fish looks for food,
and only a fish that is alarmed, or bathes, for cover.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.noise import uniform
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.perception.grid import Grid, make_grid, near_slots, nearest
from subsea.perception.vision import ahead_of, eye_of, hidden
from subsea.state import (
    ANEMONE,
    BATHES,
    CLEANS,
    COVER,
    FOODS,
    GRAZE,
    HIDES,
    HUNGER,
    NO_COURTSHIP,
    NOBODY,
    POSE,
    SHELTER,
    SITES,
    SUBMARINE,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.feelings import feeling_for
from subsea.state.habits import is_pleasant
from subsea.state.wants import ITCH_BEGINS, ITCH_ENDS, is_tempted

CELL_CM = 60.0
FOOD_CM, COVER_CM = 400.0, 250.0  # distances at which food is seen and cover is reached
ANEMONE_CM = 80.0  # farthest anemone from the home of a fish that bathes
NEAREST = 8  # places of a kind among which a fish chooses
GUESS_CM = 80.0
LEAST_STOCK = 0.3  # at which a place is grazed bare
FULL = 0.6  # stock of a place that a fish chooses
NEAR_BL = 2.0  # distance at which a place is known without being seen
PEEK_CM = 12.0  # height over a place at which it is seen
TURN = 0.6  # share by which the way to a place straight behind is longer
SHUNS = 1.5  # radii of a territory within which a fish that was chased off does not feed
FACING = 0.1  # least cosine between the way to a fish and the normal of a surface that it sees
CHANCE_CM = 60.0  # by which the choice of a place varies, so that fishes do not crowd
FULL_UP = 0.35  # share of `keen` at which a feeding fish is full; it feeds again from `keen` on
STATION_CM, CLEANER_CM = 180.0, 500.0  # around a station; from which a client sees a cleaner
GLASS_CM, AMIABLE = 350.0, 0.1  # distance of a hull that a cleaner visits, and its liking
AWAY_CM = 300.0  # distance of a cleaner from its station at which it has no clients
ITCHES = 0.35  # itch at which a fish looks for a cleaner
FAVOURS_CM = 120.0  # by which a favourite place may be farther away ...
FAVOURS_TICKS = 600  # ... for 20 s, after which it may be another one
ROOM_BL = 1.0  # distance from a cover within which a fish takes it, in the mean length of both
NIGHT_CM = 800.0  # distance from which a fish goes to cover for the night
DUSK, SMALL_CM = (0.08, 0.3), 12.0  # daylight at which large and small fishes retire
LARGE_CM = 80.0  # a longer fish casts a shadow that frightens
OUTSIZED = 3.0  # ... if it is as many times longer than the fish below
HULL_HALF_CM = 110.0  # half the length of the submarine
SHADOW_CM = 300.0  # height from which a shadow frightens
ADRIFT_CM_S = 10.0  # a slower thing does not
STEEP = 0.6  # distance aside over the height within which a thing is overhead
CHOICE_PURPOSE, COVER_PURPOSE = np.int64(120), np.int64(123)  # keys of the random numbers

SiteGrids = tuple[Grid, Grid, Grid, Grid, Grid, Grid]  # by kind of site


class Nearest(NamedTuple):
    """Room for the nearest places of a kind, and their distances, cm."""

    found: Ints  # (NEAREST,)
    gaps: Array


def grids_of(sea: Sea) -> SiteGrids:
    """Sort the sites of a sea by kind."""
    first, *rest = (
        make_grid(sea.site_place, np.flatnonzero(sea.site_kind == kind), CELL_CM)
        for kind in range(len(SITES))
    )
    a, b, c, d, e = rest
    return first, a, b, c, d, e


class Reefers(NamedTuple):
    """Fishes that those of a reef look for."""

    large: Grid  # large fishes, which cast frightening shadows
    cleaners: Grid
    posing: Grid  # for a cleaner
    hiding: Grid  # those in cover, or on the way there


def reefers_of(fishes: Fishes, minds: Minds) -> Reefers:
    """Sort large fishes, cleaners, their clients and fishes that hide."""
    alive = fishes.alive
    chosen = alive & (fishes.length >= LARGE_CM), alive & (minds.ways & CLEANS > 0)
    groups = *chosen, alive & (minds.intention == POSE), alive & (minds.intention == SHELTER)
    cells = STATION_CM, STATION_CM, STATION_CM, CELL_CM
    a, b, c, d = (
        make_grid(fishes.position, np.flatnonzero(group), cell)
        for group, cell in zip(groups, cells, strict=True)
    )
    return Reefers(a, b, c, d)


@kernel
def see_sites(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock,
    grids: SiteGrids, others: Reefers,
) -> None:  # fmt: skip
    """Set site, cover, shadow, cleaner and client of the fishes `who`."""
    room = Nearest(np.empty(NEAREST, np.int64), np.empty(NEAREST))
    slots = np.empty(len(others.large.member), np.int64)
    one, gap = np.empty(1, np.int64), np.empty(1)
    for i in who:
        if minds.diet[i]:
            _see_food(i, fishes, minds, sea, nature, clock, grids, room)
        if minds.ways[i]:
            minds.dark[i] = is_too_dark(fishes, i, sea)
            minds.shadow[i] = shadow_over(fishes, i, sea, others.large, slots)
            _see_cover(i, fishes, minds, sea, clock, grids, others.hiding, room)
        before = minds.client[i]
        minds.cleaner[i] = minds.client[i] = NOBODY
        if minds.ways[i] & CLEANS and is_pleasant(minds, i, minds.home[i, 2]):
            # The fish that poses nearest to its station.
            nearest(others.posing, vector(minds.home[i]), STATION_CM, i, one, gap, GUESS_CM)
            minds.client[i] = one[0]
            least = ITCH_ENDS if before == SUBMARINE else ITCH_BEGINS
            if one[0] == NOBODY and minds.itch[i] > least and likes_glass(fishes, minds, i, sea):
                # One at a time: the nearest.
                nearest(
                    others.cleaners, vector(sea.submarine[:3]), GLASS_CM, -1, one, gap, GUESS_CM
                )
                if one[0] == i:
                    minds.client[i] = SUBMARINE
        elif minds.itch[i] > ITCHES and not minds.ways[i] & CLEANS:
            here = vector(fishes.position[i])
            nearest(others.cleaners, here, CLEANER_CM, i, one, gap, GUESS_CM)
            if one[0] >= 0 and is_near_station(fishes, minds, one[0]):
                way = minus(vector(minds.home[one[0]]), vector(minds.home[i]))
                suits = is_pleasant(minds, i, minds.home[one[0], 2])
                if norm(way) < minds.home_range[i] and suits:
                    minds.cleaner[i] = one[0]


@kernel
def is_near_station(fishes: Fishes, minds: Minds, i: int) -> bool:
    """True if cleaner i is not far from its station, and likes light and warmth there."""
    far = norm(minus(vector(fishes.position[i]), vector(minds.home[i])))
    return far < AWAY_CM and is_pleasant(minds, i, minds.home[i, 2])


@kernel
def likes_glass(fishes: Fishes, minds: Minds, i: int, sea: Sea) -> bool:
    """True if cleaner i likes the submarine, which stands still near it, in the fish's range."""
    hull = vector(sea.submarine[:3])
    if norm(vector(sea.submarine[3:6])) > ADRIFT_CM_S or feeling_for(minds, i, SUBMARINE) < AMIABLE:
        return False
    if norm(minus(hull, vector(minds.home[i]))) > minds.home_range[i]:
        return False
    return norm(minus(hull, vector(fishes.position[i]))) < GLASS_CM


@kernel
def _see_food(
    i: int, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock,
    grids: SiteGrids, room: Nearest,
) -> None:  # fmt: skip
    """Keep the place where fish i feeds, or choose another one in sight.

    It lies where the fish likes light and warmth. A fish that courts or is not hungry has none;
    nor has one that food from the submarine tempts. Hunger begins a meal above `keen`, and ends it
    when the fish is full.
    """
    busy = minds.courtship[i] != NO_COURTSHIP or minds.betrothed[i] != NOBODY
    busy = busy or is_tempted(minds, i, sea, nature)
    eats = minds.intention[i] == GRAZE or minds.memory[i] == GRAZE
    full = minds.mental[i, HUNGER] <= nature.keen * (FULL_UP if eats else 1.0)
    if busy or minds.errand[i] > 0.0 or full:
        minds.site[i] = -1
        return
    if minds.site[i] >= 0 and sea.stock[minds.site[i]] > LEAST_STOCK:
        return
    eye, ahead = eye_of(fishes, i), ahead_of(fishes, i)
    best, least = -1, np.inf
    found, gaps = room.found, room.gaps
    for kind in range(FOODS):
        if not minds.diet[i] & (1 << kind) or len(grids[kind].member) == 0:
            continue
        nearest(grids[kind], eye, FOOD_CM, -1, found, gaps, GUESS_CM)
        for k in range(NEAREST):
            s = found[k]
            if s < 0:
                break
            place = vector(sea.site_place[s])
            toward = minus(place, eye)
            cosine = dot(toward, ahead) / max(gaps[k], 1e-6)
            cost = gaps[k] * (1.0 + 0.5 * TURN * (1.0 - cosine))
            cost += CHANCE_CM * uniform(clock.seed, i, clock.tick + (s << 40), CHOICE_PURPOSE)
            facing = -dot(toward, vector(sea.site_normal[s]))
            if cost >= least or sea.stock[s] < FULL or facing < FACING * gaps[k]:
                continue
            away = norm(minus(place, vector(minds.home[i])))
            if away > minds.home_range[i] or not is_pleasant(minds, i, place[2]):
                continue
            j = minds.chaser[i]
            if (
                j != NOBODY
                and norm(minus(place, vector(minds.home[j]))) < SHUNS * minds.territory[j]
            ):
                continue
            height = PEEK_CM + float(sea.site_depth[s])
            above = plus(place, times(height, vector(sea.site_normal[s])))
            if gaps[k] < NEAR_BL * fishes.length[i] or not hidden(sea, eye, above):
                best, least = s, cost
    minds.site[i] = best


@kernel
def _see_cover(
    i: int, fishes: Fishes, minds: Minds, sea: Sea, clock: Clock, grids: SiteGrids, hiding: Grid,
    room: Nearest,
) -> None:  # fmt: skip
    """Set the cover of fish i: its anemone, or the nearest free hiding place in sight.

    A fish that hides keeps its hiding place until it leaves it, or finds it taken.
    """
    found, gaps = room.found, room.gaps
    if minds.ways[i] & BATHES and len(grids[ANEMONE].member) > 0:
        if minds.cover[i] < 0:
            home = vector(minds.home[i])
            nearest(grids[ANEMONE], home, ANEMONE_CM, -1, found[:1], gaps[:1], GUESS_CM)
            minds.cover[i] = found[0]
        if minds.cover[i] >= 0:
            return
    night = minds.dark[i]
    if not minds.ways[i] & HIDES:
        return
    kept = minds.cover[i] >= 0 and (night or minds.wary[i] > 0.0)
    if kept and not _is_taken(fishes, i, sea, minds.cover[i], hiding):
        return
    minds.cover[i] = -1
    afraid = minds.shadow[i] > 0.0 or minds.fright[i] > 0.0 or minds.wary[i] > 0.0
    if not (afraid or night) or len(grids[COVER].member) == 0:
        return
    eye = eye_of(fishes, i)
    reach = COVER_CM if afraid else NIGHT_CM
    nearest(grids[COVER], eye, reach, -1, found, gaps, GUESS_CM)
    least, turn = np.inf, np.int64(clock.tick // FAVOURS_TICKS)
    for k in range(NEAREST):
        if found[k] < 0:
            break
        # Each fish has its favourites, so that not all come to the same place.
        cost = gaps[k] + FAVOURS_CM * uniform(clock.seed, i, found[k] + (turn << 40), COVER_PURPOSE)
        if cost >= least or _is_taken(fishes, i, sea, found[k], hiding):
            continue
        height = float(sea.site_depth[found[k]])
        door = plus(
            vector(sea.site_place[found[k]]), times(height, vector(sea.site_normal[found[k]]))
        )
        # By night it goes to a place that it knows.
        if night or gaps[k] < NEAR_BL * fishes.length[i] or not hidden(sea, eye, door):
            minds.cover[i], least = found[k], cost


@kernel
def _is_taken(fishes: Fishes, i: int, sea: Sea, s: int, hiding: Grid) -> bool:
    """True if another fish hides in cover s, and is nearer to it than fish i."""
    place = vector(sea.site_place[s])
    one, gap = np.empty(1, np.int64), np.empty(1)
    nearest(hiding, place, LARGE_CM, i, one, gap, CELL_CM)
    if one[0] < 0:
        return False
    room = ROOM_BL * 0.5 * (fishes.length[i] + fishes.length[one[0]])
    own = norm(minus(place, vector(fishes.position[i])))
    return bool(gap[0] < min(room, own))


@kernel
def is_too_dark(fishes: Fishes, i: int, sea: Sea) -> bool:
    """True if it is too dark for fish i to be about.

    Small fishes retire first in the evening and emerge last in the morning (Hobson 1972).
    """
    least, more = DUSK
    return bool(sea.sky[1] < least + more * math.exp(-float(fishes.length[i]) / SMALL_CM))


@kernel
def shadow_over(fishes: Fishes, i: int, sea: Sea, large: Grid, slots: Ints) -> float:
    """Measure the darkness of the shadow that moves over fish i, 0 to 1.

    The submarine and large fishes cast one on all below them.
    """
    here = vector(fishes.position[i])
    hull = minus(vector(sea.submarine[:3]), here)
    darkest = 0.0
    if norm(vector(sea.submarine[3:6])) > ADRIFT_CM_S:
        darkest = _darkness(hull, HULL_HALF_CM)
    for k in range(near_slots(large, here, SHADOW_CM, slots)):
        j = large.member[slots[k]]
        moves = norm(vector(fishes.velocity[j])) > ADRIFT_CM_S
        if moves and fishes.length[j] > OUTSIZED * fishes.length[i]:
            toward = minus(vector(large.place[slots[k]]), here)
            darkest = max(darkest, _darkness(toward, 0.5 * float(fishes.length[j])))
    return darkest


@kernel
def _darkness(toward: Vector, half: float) -> float:
    """Darkness of the shadow of a thing at `toward`, cm, that is `half` cm wide to each side."""
    height = toward[2]
    if height <= 0.0 or height > SHADOW_CM:
        return 0.0
    aside = math.sqrt(toward[0] * toward[0] + toward[1] * toward[1])
    if aside > half + STEEP * height:
        return 0.0
    return 1.0 - height / SHADOW_CM
