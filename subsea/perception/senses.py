"""Choose the fishes that think in a tick, and run all of their senses.

Fishes that are far away or hidden think less often.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.kernels.threads import cut, run_all, share, side_by_side
from subsea.perception import (
    collision,
    companions,
    foraging,
    leader_tracking,
    mates,
    predators,
    rivals,
    territory,
)
from subsea.perception.comfort import sense_comfort
from subsea.perception.crowd import Crowd, crowd_of
from subsea.perception.grid import Grid, find_neighbours, grid_of, make_grid, make_grid_of_images
from subsea.perception.leader_tracking import Schools
from subsea.state import CIRCLING, PACIFIST, PREDATOR, PREY, Clock, Fishes, Minds, Nature, Sea
from subsea.state.habits import brightness_above

NEAR_CM = 400.0  # distance to the submarine within which a fish thinks every tick
FAR_TICKS = 4  # interval beyond, 0.13 s ...
UNSEEN_TICKS = 8  # ... and where the water hides it
LEAST_DUE = 8192  # fishes for which another thread pays


def fish_due(fishes: Fishes, minds: Minds, sea: Sea, visibility: float, clock: Clock) -> Ints:
    """List the living fishes that think now, rising; add a tick to `minds.pause` of all."""
    due = np.empty(len(minds.intention), np.bool_)
    everyone = np.arange(len(due))
    share(mark_due, everyone, LEAST_DUE, fishes, minds, sea, visibility, clock, due)
    return np.flatnonzero(due)


@kernel
def mark_due(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, visibility: float, clock: Clock, due: Bools
) -> None:
    """Set `due` of the fishes `who`, and add a tick to their `minds.pause`.

    Turns are spread evenly over ticks. In the first tick all think, and pairs that circle or do
    what follows always do: they move close to each other. So do all in a box, where every place is
    like any other.
    """
    submarine, in_box = vector(sea.submarine), fishes.period[0] > 0.0
    for i in who:
        minds.pause[i] += np.float32(clock.dt)
        due[i] = False
        if not fishes.alive[i]:
            continue
        distance = norm(minus(vector(fishes.position[i]), submarine))
        every = 1
        if distance > NEAR_CM and minds.courtship[i] < CIRCLING and not in_box:
            every = FAR_TICKS if distance < visibility else UNSEEN_TICKS
        due[i] = clock.tick == 0 or (clock.tick + i) % every == 0


LEAST_PART, LEAST_HUNTERS = 256, 32  # fishes for which another thread pays ...
LEAST_GRIDS = 4096  # ... and those in a sea whose grids are sorted side by side


class Surroundings(NamedTuple):
    """All things that a fish may look for, sorted."""

    crowd: Crowd
    specks: Grid
    scattered: Grid  # the specks that are food from the submarine
    hunters: Grid
    mild: Grid  # pacifists


class Survey(NamedTuple):
    """Everything in the sea, sorted for the fishes that look around."""

    around: Surroundings
    schools: Schools
    prey: Grid
    fellows: dict[int, Grid]  # by species


def sense(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Update all that perception writes of the fishes `who`, except by the focusser."""
    if len(who) == 0:
        return
    hunting = who[minds.kind[who] == PREDATOR]
    survey = survey_of(who, fishes, minds, sea)
    seen = np.zeros(len(minds.led), np.bool_)
    kinds = fishes.species[who]
    looks = cut(look_around, who, LEAST_PART, fishes, minds, sea, nature, survey.around, seen)
    for kind, grid in survey.fellows.items():
        looks += cut(find_neighbours, who[kinds == kind], LEAST_PART, fishes, minds, grid)
    run_all(looks, shared=len(who) >= 2 * LEAST_PART)
    share(companions.keep_perceived, who, LEAST_PART, fishes, minds, nature)
    leader_tracking.watch_leader(who, fishes, minds, seen, clock)
    leader_tracking.watch_schools(who, fishes, minds, nature, survey.schools, clock)
    # Foraging needs the companions of prey.
    if len(hunting):
        rivals.perceive_rivals(hunting, fishes, minds, survey.around.hunters)
        groups = fishes, minds, sea, survey.prey, nature
        share(foraging.perceive_prey, hunting, LEAST_HUNTERS, *groups)


@kernel
def look_around(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, around: Surroundings,
    seen: Bools,
) -> None:  # fmt: skip
    """Update what the fishes `who` perceive, except neighbours and prey.

    Sets `seen` (n,) where a fish sees the leader of its school.
    """
    feel_water(who, fishes.position, sea, minds.light, minds.temperature)
    sense_comfort(who, minds, sea.climate, nature)
    leader_tracking.see_leader(who, fishes, minds, sea, nature, seen)
    collision.find_threats(who, fishes, minds, around.crowd, nature)
    territory.find_intruders(who, fishes, minds, around.crowd)
    collision.find_barriers(who, fishes, minds, sea, nature)
    predators.see_predators(who, fishes, minds, sea, around.hunters, nature)
    foraging.perceive_plankton(who, fishes, minds, sea, around.specks, around.scattered, nature)
    if len(around.mild.member) > 0:
        mates.see_mates(who, fishes, minds, sea, around.mild, nature)


def survey_of(who: Ints, fishes: Fishes, minds: Minds, sea: Sea) -> Survey:
    """Sort everything that the fishes `who` may look for."""
    alive, kinds = fishes.alive, minds.kind
    hunting = bool((kinds[who] == PREDATOR).any())
    courting = bool((kinds[who] == PACIFIST).any())

    def grid(wanted: bool, kind: int, cell: float) -> Callable[[], Any]:
        return lambda: make_grid_of_images(
            fishes.position, np.flatnonzero(alive & (kinds == kind) & wanted), cell, fishes.period
        )

    species = [int(kind) for kind in np.unique(fishes.species[who])]
    crowd, schools, specks, scattered, hunters, prey, mild, *fellows = side_by_side(
        [
            lambda: crowd_of(fishes),
            lambda: leader_tracking.schools_of(fishes, minds),
            lambda: make_grid(
                sea.plankton, np.flatnonzero(sea.absent <= 0.0), foraging.cell_cm(sea)
            ),
            lambda: make_grid(
                sea.plankton, np.flatnonzero(sea.absent < 0.0), foraging.cell_cm(sea)
            ),
            grid(True, PREDATOR, predators.CELL_CM),
            grid(hunting, PREY, foraging.PREY_CELL_CM),
            grid(courting, PACIFIST, mates.CELL_CM),
            *(partial(grid_of, fishes, kind) for kind in species),
        ],
        len(alive) >= LEAST_GRIDS,
    )
    by_species = dict(zip(species, fellows, strict=True))
    return Survey(Surroundings(crowd, specks, scattered, hunters, mild), schools, prey, by_species)


@kernel
def feel_water(who: Ints, position: Array, sea: Sea, light: Array, temperature: Array) -> None:
    """Set brightness and temperature of the water around the fishes `who`.

    Daylight fades with depth as exp(-depth / l), as moonlight does by night; the water cools evenly
    down to the depth of the lower temperature, and no further.
    """
    surface_c, depth_c, depth, fade = sea.climate
    above = brightness_above(sea)
    for i in who:
        below = max(-float(position[i, 2]), 0.0)
        light[i] = above * np.exp(-below / fade)
        temperature[i] = surface_c + (depth_c - surface_c) * min(below / depth, 1.0)
