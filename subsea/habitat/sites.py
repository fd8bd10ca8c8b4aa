"""Places on stone and among corals where fishes feed, bathe and hide, as these are drawn.

Turf grows on lit rock and on mounds of dead reef. Crowns of corals bear polyps, tops of sponges are
eaten too, and small animals live in rubble. Fishes bathe in anemones. They hide under overhangs, in
crevices, below table corals and among branches.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.base.disk_cache import cached
from subsea.geometry.vector import vector
from subsea.habitat.contact import clearances
from subsea.habitat.formations import drawn_distance, formations
from subsea.habitat.growth_sites import SPOTS_M2, rock_spots
from subsea.habitat.reef import KINDS, MOUND
from subsea.habitat.sea import bare
from subsea.habitat.terrain import dome, heights_at, variant_of
from subsea.state import ANEMONE, COVER, POLYPS, RUBBLE, SPONGES, TURF, Reef, Sea

# Height of the crown of each kind at these distances from its axis, both over its radius. Means
# over the drawn meshes, within 0.09 of each; `tests/rendering/reef/test_crowns.py` measures them.
CROWN_AT = (0.075, 0.225, 0.375, 0.525, 0.675)
CROWNS = {
    "staghorn": (0.73, 0.75, 0.77, 0.80, 0.86),
    "bush": (0.76, 0.74, 0.75, 0.69, 0.69),
    "table": (0.49, 0.54, 0.55, 0.57, 0.59),
    "brain": (0.73, 0.74, 0.72, 0.69, 0.62),
    "lettuce": (0.51, 0.61, 0.63, 0.55, 0.54),
    "finger": (0.63, 0.73, 0.76, 0.71, 0.79),
    "soft": (1.13, 1.23, 1.23, 1.22, 1.18),
    "pipes": (2.38, 2.38, 2.16, 1.98, 1.38),
    "barrel": (1.50, 1.50, 1.50, 1.54, 1.51),
    "anemone": (0.47, 0.58, 0.60, 0.59, 0.55),
    "rubble": (0.10, 0.15, 0.19, 0.14, 0.16),
}
# The food on each kind, and the range of its distance from the axis, over the radius.
OFFERS: dict[str, tuple[int, float, float]] = {
    "staghorn": (POLYPS, 0.2, 0.7), "bush": (POLYPS, 0.1, 0.65), "table": (POLYPS, 0.2, 0.7),
    "brain": (POLYPS, 0.0, 0.65), "lettuce": (POLYPS, 0.1, 0.6), "finger": (POLYPS, 0.1, 0.65),
    "soft": (POLYPS, 0.1, 0.6), "pipes": (SPONGES, 0.0, 0.3), "barrel": (SPONGES, 0.5, 0.65),
    "rubble": (RUBBLE, 0.0, 0.65),
}  # fmt: skip
HIDES = {"staghorn": 22.0, "table": 32.0}  # kinds that hide fishes, from this radius, cm
HIDDEN = 0.5  # height of a fish that hides in them, over that of the crown
EACH_CM2 = 140.0  # ground of a growth for each place to feed
MOST = 8  # places on a growth
TURF_M2 = 7.0  # places to graze per m² of rock or mound
COVER_M2 = 6.0  # dark places per m² of rock
LIT = 0.35  # share of the sky's light from which turf grows, ...
DARK = 0.34  # ... and below which a place hides fishes
STEEPEST = -0.15  # upward component of the normal of the steepest rock that is grazed
DEEPEST_CM = 24.0  # depth below what fishes avoid at which food is still reached
ABOVE_CM = 5.0  # least height of places on rock above the sand
MOUTH_CM = 5.0  # height over food that must be free of other growths ...
MOUTH_ROOM_CM = 1.5  # ... and its least distance from stone, as between two stones
OUT_CM = 11.0  # of a hidden fish, from the rock
ROOM_CM = 7.0  # free water around it ...
DOOR_CM = 25.0  # ... and this far before it, out of the shell around stone
MOUND_SHARE = 0.75  # share of a mound's radius within which turf is grazed
REGROW_S = 240.0  # until a place that was grazed bare has grown again
SEED = 0x517E


class Sites(NamedTuple):
    """s places, by kind."""

    kind: Ints  # (s,) uint8, index into SITES
    place: Array  # (s, 3) float32, cm
    normal: Array  # (s, 3) float32, unit vectors out of the drawn surface
    growth: Ints  # (s,) int32, of the reef, or -1
    depth: Array  # (s,) float32, cm, below what fishes avoid around stone
    stones: Array  # (q, 11) blocks of all formations


def lay_sites(sea: Sea, reef: Reef) -> Sea:
    """The sea with the places of its stones and growths, all with their full stock."""
    if len(reef.kind) == 0 and len(sea.rocks) == 0 and len(sea.pillars) == 0:
        return sea
    sites = cached(_find, bare(sea), reef)
    return sea._replace(
        site_kind=sites.kind, site_place=sites.place, site_normal=sites.normal,
        site_growth=sites.growth, site_depth=sites.depth,
        stock=np.ones(len(sites.kind), np.float32), stones=sites.stones,
    )  # fmt: skip


def regrow(sea: Sea, dt: float) -> None:
    """Let what was eaten grow again for `dt` s."""
    np.minimum(sea.stock + np.float32(dt / REGROW_S), np.float32(1.0), out=sea.stock)


def _find(sea: Sea, reef: Reef) -> Sites:
    """All places of the stones and growths of a sea."""
    parts = [_on_rock(sea), *(_on_growth(reef, k) for k in range(len(reef.kind)))]
    kind, place, normal, growth = (np.concatenate(part) for part in zip(*parts, strict=True))
    # No mouth reaches deep into the shell that fishes avoid around stone.
    depth = np.maximum(-clearances(sea.pillars, sea.rocks, place), 0.0)
    reached = depth < DEEPEST_CM
    reached &= np.hypot(place[:, 0], place[:, 1]) < 0.95 * sea.radius
    low = heights_at(sea.heights, sea.half_width, place[:, :2])
    reached &= place[:, 2] > low
    reached &= ~_covered(reef, place + MOUTH_CM * normal, growth) | (kind == COVER)
    order = np.flatnonzero(reached)
    f = np.float32
    return Sites(
        kind[order].astype(np.uint8), place[order].astype(f), normal[order].astype(f),
        growth[order].astype(np.int32), depth[order].astype(f),
        np.concatenate([np.zeros((0, 11)), *formations(sea.pillars, sea.rocks)]),
    )  # fmt: skip


def _covered(reef: Reef, place: Array, growth: Ints) -> Bools:
    """True for places (s, 3) in or below the crown of another growth than their own."""
    covered = np.zeros(len(place), np.bool_)
    tall = np.array([kind.height for kind in KINDS.values()])
    for k in np.flatnonzero(reef.kind != MOUND):
        radius = float(reef.radius[k])
        near = np.flatnonzero((np.abs(place - reef.place[k]) < 3.0 * radius).all(axis=1))
        off = place[near] - reef.place[k]
        up = off @ reef.axis[k]
        away = np.sqrt(np.maximum((off * off).sum(axis=1) - up * up, 0.0))
        inside = (away < radius) & (up > 0.0) & (up < tall[reef.kind[k]] * radius)
        covered[near[inside & (growth[near] != k)]] = True
    return covered


Rows = tuple[Ints, Array, Array, Ints]


def _on_rock(sea: Sea) -> Rows:
    """Turf on lit rock, and hiding places where it is dark."""
    spots = rock_spots(sea).sites
    place, normal, light = spots.place, spots.normal, spots.light
    chance = np.random.default_rng([SEED]).uniform(size=len(place))
    sand = heights_at(sea.heights, sea.half_width, place[:, :2])
    turf = (light > LIT) & (normal[:, 2] > STEEPEST) & (place[:, 2] > sand + ABOVE_CM)
    turf &= chance < TURF_M2 / SPOTS_M2
    stones = formations(sea.pillars, sea.rocks)
    _keep_open(turf, place + MOUTH_CM * normal, stones, MOUTH_ROOM_CM)
    hidden = place + OUT_CM * normal
    cover = (light < DARK) & (hidden[:, 2] > sand + ROOM_CM) & (chance < COVER_M2 / SPOTS_M2)
    # Its door lies in open water.
    depth = np.maximum(-clearances(sea.pillars, sea.rocks, hidden), 0.0)
    door = hidden + (DOOR_CM + depth)[:, None] * normal
    cover &= clearances(sea.pillars, sea.rocks, door) > ROOM_CM
    cover &= door[:, 2] > sand + ROOM_CM
    _keep_open(cover, hidden, stones, ROOM_CM)
    kind = np.concatenate([np.full(turf.sum(), TURF), np.full(cover.sum(), COVER)])
    return (
        kind,
        np.concatenate([place[turf], hidden[cover]]),
        np.concatenate([normal[turf], normal[cover]]),
        np.full(len(kind), -1),
    )


def _keep_open(chosen: Bools, places: Array, stones: Sequence[Array], room: float) -> None:
    """Drop those of the chosen places (s, 3) that are within `room` cm of a drawn stone."""
    for k in np.flatnonzero(chosen):
        place = vector(places[k])
        chosen[k] = all(drawn_distance(blocks, place) > room for blocks in stones)


def _on_growth(reef: Reef, k: int) -> Rows:
    """The places of growth k, spread over its crown by its own random numbers."""
    name, radius = list(KINDS)[reef.kind[k]], float(reef.radius[k])
    rng = np.random.default_rng([SEED, int(float(reef.own[k]) * 2**24)])
    if reef.kind[k] == MOUND:
        return _on_mound(reef, k, rng)
    middle = reef.place[k].astype(np.float64)
    axis = reef.axis[k].astype(np.float64)
    kinds, places, normals = [], [], []
    if name in OFFERS:
        food, least, most = OFFERS[name]
        ground = np.pi * (radius * most) ** 2
        number = int(min(max(ground / EACH_CM2 + rng.uniform(), 1.0), MOST))
        away = np.sqrt(rng.uniform(least**2, most**2, number))
        place, normal = _crown(name, middle, axis, radius, away, rng.uniform(0, 2 * np.pi, number))
        kinds += [food] * number
        places.append(place)
        normals.append(normal)
    if name == "anemone":
        kinds.append(ANEMONE)
        places.append(middle[None] + CROWNS[name][2] * radius * axis)
        normals.append(axis[None])
    if radius >= HIDES.get(name, np.inf):
        kinds.append(COVER)
        places.append(middle[None] + HIDDEN * CROWNS[name][2] * radius * axis)
        normals.append(axis[None])
    none = np.zeros((0, 3))
    return (
        np.array(kinds, np.int64),
        np.concatenate([none, *places]),
        np.concatenate([none, *normals]),
        np.full(len(kinds), k),
    )


def _crown(
    name: str, middle: Array, axis: Array, radius: float, away: Array, turn: Array
) -> tuple[Array, Array]:
    """Places (n, 3) on the crown of a growth, and normals, at distances and turns (n,)."""
    east = np.cross([0.0, 1.0, 0.0], axis)
    east /= np.linalg.norm(east)
    out = np.cos(turn)[:, None] * east + np.sin(turn)[:, None] * np.cross(axis, east)
    tall = np.interp(away, CROWN_AT, CROWNS[name])
    ahead, behind = (np.interp(away + step, CROWN_AT, CROWNS[name]) for step in (0.08, -0.08))
    slope = np.clip((ahead - behind) / 0.16, -1.0, 0.3)
    normal = axis - slope[:, None] * out
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return middle + radius * (away[:, None] * out + tall[:, None] * axis), normal


def _on_mound(reef: Reef, k: int, rng: np.random.Generator) -> Rows:
    """Turf on a mound of dead reef."""
    radius, middle = float(reef.radius[k]), reef.place[k].astype(np.float64)
    number = int(np.pi * (MOUND_SHARE * radius) ** 2 / 1e4 * TURF_M2 * 2.0 + rng.uniform())
    away = MOUND_SHARE * np.sqrt(rng.uniform(size=number))
    turn = rng.uniform(0, 2 * np.pi, number)
    off = away[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    form = int(variant_of(reef.own[k : k + 1])[0])
    cos, sin = np.cos(reef.turn[k]), np.sin(reef.turn[k])
    turned = np.array([[cos, -sin], [sin, cos]])

    def rise(at: Array) -> Array:
        return np.asarray(dome(form, at @ turned))

    step = 0.04
    east = rise(off + (step, 0.0)) - rise(off - (step, 0.0))
    north = rise(off + (0.0, step)) - rise(off - (0.0, step))
    normal = np.column_stack([-east, -north, np.full(number, 2.0 * step)])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    place = middle + radius * np.column_stack([off, rise(off)])
    return np.full(number, TURF), place, normal, np.full(number, k)
