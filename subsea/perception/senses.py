"""Run all senses of the fishes that think in a tick."""

import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel
from subsea.perception import collision, foraging, leader_tracking, mates, predators
from subsea.perception.grid import make_grid
from subsea.perception.neighbours import find_neighbours
from subsea.perception.vision import middles_of
from subsea.state import PACIFIST, PREDATOR, PREY, Clock, Fishes, Minds, Nature, Sea

LARGE_CM = 45.0  # longer fishes are kept in a grid of their own ...
SMALL_CELL_CM, LARGE_CELL_CM = 30.0, 150.0  # ... so that small ones are searched nearby


def sense(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Update all that perception writes of the fishes `who`, except by the focusser."""
    if len(who) == 0:
        return
    feel_water(who, fishes.position, sea.climate, minds.light, minds.temperature)
    find_neighbours(who, fishes, minds)
    leader_tracking.watch_leader(who, fishes, minds, sea, nature, clock)
    leader_tracking.watch_schools(who, fishes, minds, clock)
    alive, place, kinds = fishes.alive, fishes.position, minds.kind
    large, middles = fishes.length > LARGE_CM, middles_of(fishes)
    crowd = (
        make_grid(middles, np.flatnonzero(alive & ~large), SMALL_CELL_CM),
        make_grid(middles, np.flatnonzero(alive & large), LARGE_CELL_CM),
    )
    collision.find_threats(who, fishes, minds, crowd, nature)
    collision.find_barriers(who, fishes, minds, sea, nature)
    hunters = make_grid(place, np.flatnonzero(alive & (kinds == PREDATOR)), predators.CELL_CM)
    predators.see_predators(who, fishes, minds, sea, hunters, nature)
    specks = make_grid(sea.plankton, np.flatnonzero(sea.absent <= 0.0), foraging.cell_cm(sea))
    foraging.perceive_plankton(who, fishes, minds, specks, nature)
    if (kinds[who] == PREDATOR).any():
        prey = make_grid(place, np.flatnonzero(alive & (kinds == PREY)), foraging.PREY_CELL_CM)
        foraging.perceive_prey(who, fishes, minds, sea, prey, nature)
    if (kinds[who] == PACIFIST).any():
        mild = make_grid(place, np.flatnonzero(alive & (kinds == PACIFIST)), mates.CELL_CM)
        mates.see_mates(who, fishes, minds, sea, mild, nature)


@kernel
def feel_water(
    who: Ints, position: Array, climate: Array, light: Array, temperature: Array
) -> None:
    """Set brightness and temperature of the water around the fishes `who`.

    Light fades with depth as exp(-depth / l); the water cools evenly down to the depth of the
    lower temperature, and no further.
    """
    surface_c, depth_c, depth, fade = climate
    for i in who:
        below = max(-float(position[i, 2]), 0.0)
        light[i] = np.exp(-below / fade)
        temperature[i] = surface_c + (depth_c - surface_c) * min(below / depth, 1.0)
