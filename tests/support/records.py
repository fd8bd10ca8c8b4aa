"""Tiny records of a simulation, for tests of measures."""

from pathlib import Path

import numpy as np

from subsea.lab.measures import headings
from subsea.media.record import FIELDS, READ, STATIONS, Record
from subsea.repertoire import SEGMENTS
from subsea.state import KINDS, WANDER

OLDEST_RECORD = Path(__file__).with_name("record_version_2.h5.xz")  # of the first release
TICK_S = 0.1
LENGTH = 20.0  # cm; the bodies are 2 cm wide and 6 cm high
INTENTIONS = ["avoid", "escape", "school", "eat", "mate", "leave", "wander"]
COURTSHIP = ["none", "approaching", "looping", "circling", "ascending", "nuzzling", "spawning"]
# Body axes to world: heading along x with the back up, and quarter turns to the left of that.
EAST = np.array([0.5**0.5, 0.5**0.5, 0.0, 0.0])
NORTH = np.array([0.5, 0.5, 0.5, 0.5])


def a_record(position, orientation=EAST, **changed):
    """Make a record of fishes at `position` (T, n, 3) in a flat sea 10 m wide and 4 m deep.

    Arrays have the types and the order of a file, or each test would compile kernels again.
    """
    position = np.asarray(position, np.float32)
    ticks, n = position.shape[:2]
    turns = np.broadcast_to(np.asarray(orientation, np.float32), (ticks, n, 4)).copy()
    ahead = headings(turns)
    zeros = np.zeros((ticks, n), np.int32)
    mental = np.zeros((ticks, n, 3), np.float32)
    given = {
        "time": TICK_S * np.arange(1, ticks + 1),
        "position": position,
        "orientation": turns,
        "snout": np.float32(position + 0.4 * LENGTH * ahead),
        "tail": np.float32(position - 0.6 * LENGTH * ahead),
        "centre": position,
        "intention": zeros + WANDER,
        "segment": zeros,
        "mental_state": mental,
        "alive": np.ones((ticks, n), bool),
        "leader": zeros - 1,
        "target": zeros - 1,
        "partner": zeros - 1,
        "courtship": zeros,
        "last_meal": np.zeros((ticks, n), np.float32),
        "species": np.zeros(n, np.uint8),
        "kind": np.zeros(n, np.uint8),
        "male": np.zeros(n, bool),
        "length": np.full(n, LENGTH, np.float32),
        "snout_reach": np.full(n, 0.4 * LENGTH, np.float32),
        "half_width": np.full((1, STATIONS), 1.0 / LENGTH, np.float32),
        "half_height": np.full((1, STATIONS), 3.0 / LENGTH, np.float32),
        "heights": np.full((3, 3), -400.0, np.float32),
        "pillars": np.zeros((0, 4)),
        "rocks": np.zeros((0, 7)),
        "plankton": np.full(ticks, 100, np.int32),
        "tick_s": TICK_S,
        "seed": 1,
        "radius_cm": 500.0,
        "half_width_cm": 800.0,
        "alarmed": 0.5,
        "species_names": ["Fish"],
        "intention_names": INTENTIONS,
        "segment_names": list(SEGMENTS),
        "mental_state_names": ["hunger", "libido", "fear"],
        "courtship_names": COURTSHIP,
        "kind_names": list(KINDS),
    }
    given |= changed
    for name, path in READ.items():
        given[name] = np.ascontiguousarray(given[name], FIELDS[path].type)
    return Record(**given)


def still(ticks, *places):
    """Places (T, n, 3) of fishes that do not move."""
    return np.broadcast_to(np.array(places, float), (ticks, len(places), 3))


def row(n, apart_bl):
    """Places (n, 3) of fishes one behind another."""
    return np.array([[k * apart_bl * LENGTH, 0, 0] for k in range(n)])
