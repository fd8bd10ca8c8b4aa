"""Food in range: plankton, or prey for predators (Tu §6.3.1, §7.9.1)."""

import math

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.solids import far_from_rock, from_pillar, from_rock, height_at
from subsea.geometry.vector import Vector, dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.perception.grid import Grid, farthest, insert, near_slots, nearest
from subsea.perception.vision import ahead_of, eye_of, hidden, sees_fish, sight
from subsea.state import ESCAPE, PREDATOR, Fishes, Minds, Nature, Sea
from subsea.state.places import place_near
from subsea.state.wants import takes_scattered

PREY_CELL_CM = 100.0
WALL_BL = 2.5  # distance of food from the wall, for fishes that turn in wide arcs
COMPANY_CM = 110.0  # range of companions of the prey, which confuse a predator
STEEPEST = 0.34  # sine of the steepest way of a stalking predator, as in `motor/controller.py`
WARNED_COST = 2.0  # factor on the cost of prey that it missed, and of other prey that flees
SCHOOL_COST, TURN_COST = 0.5, 0.2  # beta1 and beta2 of Tu §7.9.1


def cell_cm(sea: Sea) -> float:
    """Return the side, cm, of a cell that holds about one speck."""
    volume = math.pi * sea.radius**2 * float(sea.climate[2])
    return float((volume / max(len(sea.plankton), 1)) ** (1 / 3))


@kernel
def perceive_plankton(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, specks: Grid, scattered: Grid,
    nature: Nature,
) -> None:  # fmt: skip
    """Set the food of the plankton eaters among the fishes `who` from the grids of all `specks`.

    A speck is seen within V_r, and smelled within O_r in all directions and behind solids. As O_r
    is the larger, smell alone decides. A fish that keeps to the ground minds only specks that are
    no higher than it cruises, in open water, and that leave it room to turn before the wall. A
    pinch of `scattered` food from the submarine, which lies together, is more than single specks: a
    fish that it tempts minds nothing else.
    """
    gaps = np.empty(minds.foods.shape[1])
    for i in who:
        if minds.kind[i] == PREDATOR:
            continue
        mouth, foods = eye_of(fishes, i), minds.foods[i]
        guess = farthest(sea.plankton, mouth, foods)
        foods[:] = -1
        if len(scattered.member) > 0 and takes_scattered(minds, i, nature):
            nearest(scattered, mouth, nature.smell_cm, -1, foods, gaps, nature.smell_cm)
            _forget_unfit(fishes, minds, i, sea, gaps)
            if foods[0] >= 0:
                away = minus(vector(sea.plankton[foods[0]]), vector(minds.home[i]))
                foods[0] = foods[0] if norm(away) <= minds.home_range[i] else -1
        if foods[0] < 0:
            nearest(specks, mouth, nature.smell_cm, -1, foods, gaps, guess)
            _forget_unfit(fishes, minds, i, sea, gaps)
        minds.food[i] = foods[0]
        minds.food_distance[i] = gaps[0]


@kernel
def _forget_unfit(fishes: Fishes, minds: Minds, i: int, sea: Sea, gaps: Array) -> None:
    """Remove specks from the food of fish i, and their `gaps`, that it cannot reach with ease.

    They are higher than it cruises, nearer to the wall than it turns, or behind stone or at it.
    """
    kept, foods = 0, minds.foods[i]
    if minds.cruise_height[i, 1] == np.inf:
        return
    edge = sea.radius - WALL_BL * float(fishes.length[i])
    for k in range(len(foods)):
        if foods[k] < 0:
            continue
        x, y, z = vector(sea.plankton[foods[k]])
        low = z - height_at(sea.floor, sea.half_width, x, y) <= minds.cruise_height[i, 1]
        inside = x * x + y * y < edge * edge
        if low and inside and _is_open(fishes, i, sea, (x, y, z)):
            foods[kept], gaps[kept] = foods[k], gaps[k]
            kept += 1
    foods[kept:] = -1
    gaps[kept:] = np.inf


@kernel
def _is_open(fishes: Fishes, i: int, sea: Sea, p: Vector) -> bool:
    """True if p is in view of fish i, with half a length of free water to pillars and rocks."""
    room = 0.5 * float(fishes.length[i])
    for k in range(len(sea.pillars)):
        if from_pillar(sea.pillars[k], p)[1] < room:
            return False
    for k in range(len(sea.rocks)):
        if not far_from_rock(sea.rocks[k], p, room) and from_rock(sea.rocks[k], p)[1] < room:
            return False
    return not hidden(sea, eye_of(fishes, i), p)


@kernel
def perceive_prey(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, grid: Grid, nature: Nature
) -> None:
    """Set the food of the predators among the fishes `who` from the prey of `grid`.

    `minds.food` is the nearest, `minds.foods` the cheapest to catch.
    """
    reach = nature.smell_cm
    for j in grid.member:
        reach = max(reach, sight(float(fishes.length[j]), nature))
    cost, slots = np.empty(minds.foods.shape[1]), np.empty(len(grid.member), np.int64)
    for i in who:
        if minds.kind[i] != PREDATOR:
            continue
        found, least = minds.foods[i], np.inf
        found[:] = -1
        cost[:] = np.inf
        minds.food[i] = -1
        mouth, ahead = eye_of(fishes, i), ahead_of(fishes, i)
        inner, outer = -1.0, min(grid.cell, reach)
        while True:
            for k in range(near_slots(grid, mouth, outer, slots)):
                slot = slots[k]
                j = grid.member[slot]
                toward = minus(vector(grid.place[slot]), mouth)
                distance = norm(toward)
                if not inner < distance <= outer or distance > cost[-1]:
                    continue
                if j == minds.conceded[i] or not is_quarry(minds, fishes.species, i, j):
                    continue
                if not perceives(fishes, i, j, sea, nature, distance):
                    continue
                insert(found, cost, j, price_of(fishes, minds, i, j, mouth, ahead))
                if distance < least or (distance == least and j < minds.food[i]):
                    minds.food[i], least = j, distance
            if cost[-1] <= outer or outer >= reach:
                break  # a cost is never less than the distance
            inner, outer = outer, min(2.0 * outer, reach)
        minds.food_distance[i] = least


@kernel
def is_quarry(minds: Minds, species: Ints, i: int, j: int) -> bool:
    """True if predator i may hunt fish j; a direction may restrict its quarry."""
    first, end, kind = minds.quarry[i]
    return bool(first <= j < end and (kind < 0 or species[j] == kind))


@kernel
def is_in_school(fishes: Fishes, minds: Minds, j: int) -> bool:
    """True if fish j belongs to a school and has company of its species near."""
    belongs, k = (
        minds.leads[j] or (minds.schools[j] and minds.leader[j] >= 0),
        minds.neighbour[j, 0],
    )
    if not belongs or k < 0:
        return False
    there = vector(fishes.position[j])
    return norm(minus(place_near(fishes, k, there), there)) < COMPANY_CM


@kernel
def perceives(fishes: Fishes, i: int, j: int, sea: Sea, nature: Nature, distance: float) -> bool:
    """True if predator i smells or sees prey j, `distance` cm from its mouth."""
    return distance <= nature.smell_cm or sees_fish(fishes, i, j, sea, nature)


@kernel
def price_of(fishes: Fishes, minds: Minds, i: int, j: int, mouth: Vector, ahead: Vector) -> float:
    """The cost, cm, of catching prey j for predator i; more of prey that is warned of it."""
    toward = minus(place_near(fishes, j, mouth), mouth)
    cost = cost_of(toward, norm(toward), ahead, is_in_school(fishes, minds, j))
    cost *= WARNED_COST if minds.missed[i] == j else 1.0
    flees = minds.intention[j] == ESCAPE and minds.target[i] != j
    return cost * (WARNED_COST if flees else 1.0)


@kernel
def cost_of(toward: Vector, distance: float, ahead: Vector, schools: bool) -> float:
    """Cost of catching prey, cm: C = d (1 + beta1 S + beta2 E / pi) (Tu §7.9.1).

    S is 1 for prey in a school, else 0; E is the angle by which the predator has to turn. d is the
    length of the way to swim: recorded motion climbs and dives slowly.
    """
    distance = max(distance, abs(toward[2]) / STEEPEST)
    cosine = dot(toward, ahead) / max(norm(toward), 1e-9)
    turn = math.acos(min(max(cosine, -1.0), 1.0))
    return distance * (1.0 + (SCHOOL_COST if schools else 0.0) + TURN_COST * turn / math.pi)
