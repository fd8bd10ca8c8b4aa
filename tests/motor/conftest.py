"""Fishes that play the closed-form repertoire, and one in a tank that can be simulated."""

from functools import cache

import numpy as np
import pytest

from subsea.base.system import resource_path
from subsea.fish.skinning import couple
from subsea.fish.species import load_species
from subsea.motor.controller import command
from subsea.motor.playback import play
from subsea.motor.pose import nodes_world
from subsea.motor.switching import LiveWater, make_dynamics, swim, to_live
from subsea.repertoire import read_repertoire
from subsea.repertoire.library import LIVE_TABLES, Library, pack
from subsea.repertoire.schema import SEGMENTS
from subsea.state import Clock, Fishes, Live, empty
from subsea.world.repertoires import with_live
from tests.support.scenes import everyone

TICK = 0.033
STILL = np.zeros(3)


@pytest.fixture(scope="session")
def library(known_repertoire) -> Library:
    return pack(
        [known_repertoire], [couple("sections", known_repertoire.rest_nodes, np.zeros((426, 3)))]
    )


@pytest.fixture
def make_fishes(library):
    """A function that makes n fishes at the start of a segment."""

    def make(n: int, name: str = "swim_medium") -> Fishes:
        fishes = empty(Fishes, n=n)
        code = SEGMENTS.index(name)
        first, length = library.first[0, code], library.length[0, code]
        fishes.segment[:] = code
        fishes.wanted_segment[:] = code
        fishes.row_a[:] = first + length - 1  # state 0 is the last frame's
        fishes.row_b[:] = first
        fishes.length[:] = library.recorded_length[0]
        fishes.goal_direction[:, 0] = 1.0
        return fishes

    return make


@cache
def packed(species):
    """Shipped data of a species: repertoire, coupling and library."""
    repertoire = read_repertoire(resource_path(f"repertoires/{species}.h5"))
    coupling = couple("sections", repertoire.rest_nodes, np.zeros((426, 3)))
    return repertoire, coupling, pack([repertoire], [coupling])


@cache
def dynamics_of(species):
    repertoire, _, library = packed(species)
    return make_dynamics([load_species(species)], [repertoire], library, np.inf)


@pytest.fixture(scope="session")
def shipped_library():
    """Return the function `packed`."""
    return packed


class Tank:
    """One fish of a species in still water, played back or simulated, with a free goal."""

    def __init__(self, species, scale=1.0):
        repertoire, coupling, _ = packed(species)
        self.dynamics = dynamics_of(species)
        self.library = with_live(pack([repertoire], [coupling]), 1)
        rows = len(self.library.entry)
        tables = {name: getattr(self.library, name)[rows:] for name in LIVE_TABLES}
        self.live = empty(Live, k=len(tables["nodes"]) // 2, given=tables)
        self.fishes = empty(Fishes, n=1)
        self.fishes.scale[:] = scale
        self.fishes.rate[:] = scale**-0.5
        self.fishes.length[:] = scale * self.library.recorded_length[0]
        self.shear = np.zeros((1, 2, 3))  # of the water at snout and tail
        self.tick = 1  # a tick without a review of the slots

    def put(self, name, row=0):
        code = SEGMENTS.index(name)
        first, length = self.library.first[0, code], self.library.length[0, code]
        f = self.fishes
        f.segment[:] = f.wanted_segment[:] = code
        f.row_a[:], f.row_b[:] = first + row, first + (row + 1) % length
        f.orientation[:] = np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0
        self.aim(0.0, self.library.speed[0, code] / self.library.speed[0, 2])
        return self

    def aim(self, azimuth, speed, climb=0.0):
        c = np.cos(climb)
        self.fishes.goal_direction[:] = np.cos(azimuth) * c, np.sin(azimuth) * c, np.sin(climb)
        self.fishes.goal_speed[:] = speed

    def run(self, ticks, obey=True):
        """Advance by a number of ticks."""
        f = self.fishes
        for _ in range(ticks):
            if obey:
                command(everyone(f), f, self.library, Clock(1, self.tick, TICK))
            clock = Clock(1, 10 * self.tick + 1, TICK)
            around = LiveWater(STILL, shear=self.shear)
            swim(f, self.library, self.dynamics, self.live, around, clock)
            play(everyone(f), f, self.library, TICK)
            self.tick += 1

    def step(self, ticks, obey=True):
        """Advance likewise; returns nodes (ticks, 23, 3) of every tick."""
        path = []
        for _ in range(ticks):
            self.run(1, obey)
            path.append(nodes_world(self.fishes, self.library, 0))
        return np.array(path)

    def to_live(self):
        to_live(self.fishes, self.library, self.dynamics, self.live, 0, 0)

    def leave(self):
        self.live.waiting[0] = 1


@pytest.fixture(scope="session")
def make_tank():
    """Return the tank class, for a species and a scale."""
    return Tank
