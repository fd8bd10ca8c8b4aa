"""Playback of spine-driven fishes: their drawn surface, as nodes show little of it."""

import numpy as np
import pytest

from subsea.base.system import resource_path
from subsea.fish.skinning import couple
from subsea.fish.species import load_species, species_names
from subsea.motor.controller import command
from subsea.motor.playback import play
from subsea.motor.pose import control_points_world
from subsea.repertoire import read_repertoire
from subsea.repertoire.library import pack
from subsea.state import Clock, Fishes, empty
from tests.support.scenes import everyone

TICK = 0.033
SMALL_BL = 0.025  # body lengths per tick², as for nodes in test_transitions.py


@pytest.mark.parametrize("name", [name for name in species_names() if load_species(name).spine])
def test_at_random_commands_no_point_of_the_surface_is_jerked(name):
    repertoire = read_repertoire(resource_path(f"repertoires/{name}.h5"))
    nodes = repertoire.rest_nodes
    library = pack([repertoire], [couple("sections", nodes, np.tile(nodes[0], (426, 1)))])
    fishes = empty(Fishes, n=1)
    fishes.length[:] = repertoire.body_length_cm
    fishes.row_b[:] = 1
    fishes.orientation[:] = np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0
    rng = np.random.default_rng(1)
    path, tempo, segments = [], [], set()
    for tick in range(2400):
        if tick % 120 == 0:
            azimuth = rng.uniform(-np.pi, np.pi)
            fishes.goal_direction[:] = np.cos(azimuth), np.sin(azimuth), 0.0
            fishes.goal_speed[:] = rng.uniform(0.2, 1.0)
        command(everyone(fishes), fishes, library, Clock(1, tick, TICK))
        play(everyone(fishes), fishes, library, TICK)
        path.append(control_points_world(fishes, library, 0)[::5])
        tempo.append(max(fishes.tempo[0], 1.0))
        segments.add(int(fishes.segment[0]))
    # Accelerations grow as the square of the tempo.
    change = np.linalg.norm(np.diff(path, 2, axis=0), axis=2).max(axis=1)
    change = (change / np.square(tempo[2:])).max()
    assert 0.001 < change / repertoire.body_length_cm < SMALL_BL
    assert len(segments) >= 5
