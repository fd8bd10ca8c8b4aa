"""Switching between playback and simulation: unseen, bounded by the budget, repeatable."""

from itertools import product

import numpy as np
import pytest

from subsea.body.pose import nodes_world
from subsea.motor.controller import command
from subsea.motor.playback import play
from subsea.motor.switching import make_dynamics, may_go_live, swim, to_live
from subsea.repertoire import SEGMENTS, read_repertoire
from subsea.repertoire.library import pack
from subsea.resources import resource_path
from subsea.species import load_species, species_names
from subsea.state import empty_fishes, empty_live

TICK = 0.033
STILL = np.zeros(3)
LIMIT = 2.0  # times the largest change of velocity that playback itself makes
CYCLIC = [name for name in SEGMENTS if "sharp" not in name]
DIRECTIONS = {"swim": 0.0, "left": np.radians(50.0), "right": np.radians(-50.0)}


class Tank:
    """One fish of a species in still water, playback and simulation, at a goal of one's choice."""

    def __init__(self, species, scale=1.0):
        repertoire = read_repertoire(resource_path("repertoires") / f"{species}.h5")
        self.library = pack([repertoire], [np.zeros((426, 3))], live=1)
        self.dynamics = make_dynamics([load_species(species)], [repertoire], self.library, np.inf)
        rows = len(self.library.entry)
        tables = (self.library.rotation, self.library.translation, self.library.nodes)
        self.live = empty_live(*(table[rows:] for table in tables))
        self.fishes = empty_fishes(1)
        self.fishes.scale[:] = scale
        self.fishes.rate[:] = scale**-0.5
        self.fishes.length[:] = scale * self.library.recorded_length[0]
        self.tick = 1  # not one at which the choice is thought over

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

    def step(self, ticks, obey=True):
        """Nodes (ticks, 23, 3) of every tick."""
        path = []
        for _ in range(ticks):
            f = self.fishes
            if obey:
                command(f, self.library, 1, self.tick, TICK)
            swim(f, self.library, self.dynamics, self.live, STILL, STILL, 10 * self.tick + 1, TICK)
            play(f, self.library, STILL, TICK)
            self.tick += 1
            path.append(nodes_world(f, self.library, 0))
        return np.array(path)

    def to_live(self):
        to_live(self.fishes, self.library, self.dynamics, self.live, 0, 0)

    def leave(self):
        self.live.waiting[0] = 1


def changes(path):
    """The largest change of any node's velocity at each frame, cm per tick²."""
    return np.linalg.norm(np.diff(path, 2, axis=0), axis=2).max(axis=1)


def steps(path):
    """The largest step of any node at each frame, cm."""
    return np.linalg.norm(np.diff(path, axis=0), axis=2).max(axis=1)
