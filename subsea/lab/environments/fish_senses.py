"""Senses of fishes as numbers: what their perception wrote into their minds, seen from the snout.

Directions are unit vectors in body axes: ahead, up, right. Nearness is s / (s + d) for a distance d
from the snout and the scale s of a group, so that it is 1 at contact and falls toward 0; 0 and a
zero direction mean nothing perceived. All numbers lie in [-1, 1].
"""

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.height_field import height_at
from subsea.geometry.rotation import matrix
from subsea.geometry.solids import from_pillar, from_rock
from subsea.geometry.vector import vector
from subsea.state import (
    CHOICES,
    FEAR,
    HUNGER,
    LIBIDO,
    NOBODY,
    PREDATOR,
    SEABED,
    SUBMARINE,
    SURFACE,
    WALL,
    Sea,
)
from subsea.world.world import World

COMPANIONS = 3  # nearest neighbours that are listed
FASTEST_BL_S = 6.0  # body lengths per second that count as 1
# Scales of nearness, body lengths.
FOOD_BL, PREDATOR_BL, NEIGHBOUR_BL, OBSTACLE_BL = 1.0, 10.0, 2.0, 2.0

DIRECTION = ("ahead", "up", "right")
OWN = (
    "hunger", "libido", "fear", "light", "depth", "pitch", "gape",
    *(f"velocity {axis}" for axis in DIRECTION),
)  # fmt: skip
NAMES = (
    *OWN,
    *(f"food {k} {part}" for k in range(CHOICES) for part in (*DIRECTION, "nearness")),
    *(f"predator {k} {part}" for k in range(CHOICES) for part in (*DIRECTION, "nearness")),
    *(
        f"neighbour {k} {part}"
        for k in range(COMPANIONS)
        for part in (*DIRECTION, "nearness", *(f"heading {axis}" for axis in DIRECTION))
    ),
    *(f"threat {part}" for part in (*DIRECTION, "nearness")),
    *(f"barrier {part}" for part in (*DIRECTION, "nearness")),
)
"""The meaning of each number of `senses`. Prey is the food of predators."""


def senses(world: World, who: Ints) -> Array:
    """Perceptions of fishes `who` (k,): float32 (k, len(NAMES)) in [-1, 1]; zeros for dead ones."""
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    axes = matrix(fishes.orientation[who].astype(np.float64))  # columns are the body axes
    length = fishes.length[who].astype(np.float64)
    ahead = axes[:, :, 0]
    snout = fishes.position[who] + fishes.snout[who, None] * ahead
    through = fishes.velocity[who] - fishes.drift[who].astype(np.float64)
    own = np.column_stack(
        [
            minds.mental[who][:, [HUNGER, LIBIDO, FEAR]], minds.light[who],
            -fishes.position[who, 2] / world.scenario.bounds.depth_cm, ahead[:, 2],
            fishes.gape[who], _to_body(axes, through) / (FASTEST_BL_S * length)[:, None],
        ]
    )  # fmt: skip

    def toward(places: Array, seen: Bools, scale_bl: float) -> Array:
        """Directions and nearness (k, 4 m) of places (k, m, 3) that are `seen` (k, m)."""
        gap = places - snout[:, None]
        distance = np.linalg.norm(gap, axis=2)
        way = _to_body(axes, gap) / np.maximum(distance, 1e-6)[..., None]
        scale = scale_bl * length[:, None]
        out = np.concatenate([way, (scale / (scale + distance))[..., None]], axis=2)
        return np.where(seen[..., None], out, 0.0).reshape(len(who), -1)

    foods, hunts = minds.foods[who], (minds.kind[who] == PREDATOR)[:, None]
    edible = foods >= 0
    prey = edible & hunts & fishes.alive[np.where(hunts, foods, 0)]
    specks = edible & ~hunts
    food_places = fishes.position[np.where(prey, foods, 0)].astype(np.float64)
    if len(sea.plankton):
        specks &= sea.absent[np.where(specks, foods, 0)] <= 0.0
        drifting = sea.plankton[np.where(specks, foods, 0)]
        food_places = np.where(hunts[..., None], food_places, drifting)
    feared = minds.predators[who]
    hull = (feared == SUBMARINE)[..., None]
    frightening = feared != NOBODY
    if world.nature.submarine_cm <= 0.0:  # then it is listed, but nobody minds it
        frightening &= feared != SUBMARINE
    feared_places = np.where(
        hull, sea.submarine[:3], fishes.position[np.maximum(feared, 0)].astype(np.float64)
    )
    near = minds.neighbour[who, :COMPANIONS]
    known = near != NOBODY
    near_places = fishes.position[np.maximum(near, 0)].astype(np.float64)
    headings = matrix(fishes.orientation[np.maximum(near, 0)].astype(np.float64))[..., 0]
    facing = np.where(known[..., None], _to_body(axes, headings), 0.0)
    company = np.concatenate(
        [toward(near_places, known, NEIGHBOUR_BL).reshape(len(who), COMPANIONS, 4), facing], axis=2
    )
    threat = minds.threat[who, None]
    threat_places = fishes.position[np.maximum(threat, 0)].astype(np.float64)
    barrier = minds.barrier[who]
    barrier_places = np.array(
        [barrier_place(sea, int(code), spot) for code, spot in zip(barrier, snout, strict=True)]
    )
    out = np.concatenate(
        [
            own,
            toward(food_places, prey | specks, FOOD_BL),
            toward(feared_places, frightening, PREDATOR_BL),
            company.reshape(len(who), -1),
            toward(threat_places, threat != NOBODY, OBSTACLE_BL),
            toward(barrier_places[:, None], (barrier != -1)[:, None], OBSTACLE_BL),
        ],
        axis=1,
    )
    out[~fishes.alive[who]] = 0.0
    return np.clip(out, -1.0, 1.0).astype(np.float32)


def barrier_place(sea: Sea, code: int, spot: Array) -> Array:
    """The nearest point (3,), cm, of an obstacle as `Minds.barrier` names it; none: `spot`."""
    if code == SEABED:
        return np.array([*spot[:2], height_at(sea.floor, sea.half_width, spot[0], spot[1])])
    if code == SURFACE:
        return np.array([*spot[:2], 0.0])
    if code == WALL:
        return np.array([*(sea.radius / max(np.hypot(*spot[:2]), 1e-6) * spot[:2]), spot[2]])
    if code < 0:
        return spot
    pillars = len(sea.pillars)
    near = from_pillar if code < pillars else from_rock
    solid = sea.pillars[code] if code < pillars else sea.rocks[code - pillars]
    normal, distance = near(solid, vector(spot))
    return np.asarray(spot - distance * np.array(normal))


def _to_body(axes: Array, vectors: Array) -> Array:
    """Vectors (k, 3) or (k, m, 3), world, in body axes; columns of `axes` (k, 3, 3) are these."""
    return np.asarray(np.einsum("kij,k...i->k...j", axes, vectors))
