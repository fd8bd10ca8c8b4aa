"""Measure how high fishes are over the ground and how deep below the surface."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.geometry.solids import height_at
from subsea.kernels import kernel
from subsea.lab.measures import SAMPLE_S
from subsea.media.record import Record

SHALLOW_BL = 0.5  # near the surface: less deep


class Whereabouts(NamedTuple):
    """Heights and depths of a species, sampled five times a second."""

    height_bl: Array  # (k,) of the origin of the body over the seabed, body lengths
    shallow: tuple[float, float]  # samples nearer to the surface than SHALLOW_BL, of all


def whereabouts(record: Record) -> dict[str, Whereabouts]:
    """Measure heights over the seabed and the time near the surface of each species."""
    every = max(round(SAMPLE_S / record.tick_s), 1)
    found = {}
    for k, name in enumerate(record.species_names):
        those = np.flatnonzero(record.species == k)
        alive = record.alive[::every][:, those]
        if not alive.any():
            continue
        place = record.position[::every][:, those][alive].astype(np.float64)
        length = np.broadcast_to(record.length[those], alive.shape)[alive].astype(np.float64)
        ground = np.empty(len(place))
        _ground(place, record.heights, record.half_width_cm, ground)
        shallow = float((-place[:, 2] < SHALLOW_BL * length).sum())
        found[name] = Whereabouts((place[:, 2] - ground) / length, (shallow, float(len(place))))
    return found


@kernel
def _ground(place: Array, heights: Array, half_width_cm: float, ground: Array) -> None:
    """Fill `ground` (k,) with the height of the seabed below each place (k, 3), cm."""
    for k in range(len(place)):
        ground[k] = height_at(heights, half_width_cm, place[k, 0], place[k, 1])


def joined(parts: Sequence[Whereabouts]) -> Whereabouts:
    """Join the whereabouts of one species in several records."""
    shallow, whole = np.sum([part.shallow for part in parts], axis=0).tolist()
    return Whereabouts(np.concatenate([part.height_bl for part in parts]), (shallow, whole))
