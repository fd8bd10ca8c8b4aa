"""World and views in, packet out: all that drawing ever sees of the world."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.scenario import Water
from subsea.species import Species
from subsea.view.camera import View

Array = NDArray[np.floating[Any]]

LEVELS = ("tessellated", "control mesh", "far")

# Columns of an instance record: 16 float32, 64 bytes, four vec4 attributes in the shader.
POSITION = slice(0, 3)  # cm, world, interpolated between the last two ticks
SCALE = 3  # length of the fish over length of the recorded one (α of SMC eq. 12)
ORIENTATION = slice(4, 8)  # w, x, y, z, body to world
ROW_A, ROW_B, WEIGHT = 8, 9, 10  # a pose mixes two rows of the control-point table
IDENTITY = 11  # constant per fish, in [0, 1): individual variation
PECTORAL_LEFT, PECTORAL_RIGHT = 12, 13  # rad, sweep of the fin from its rest plane
MOUTH = 14  # opening, 0 to 1
FADE = 15  # 0 invisible to 1 opaque
INSTANCE_COLUMNS = 16


@dataclass(frozen=True)
class Scene:
    """What drawing needs once: constant for a dive."""

    species: tuple[Species, ...]
    control_points: Array  # (rows, 426, 3) float32 cm, all species and frames
    recorded_length_cm: tuple[float, ...]  # per species
    terrain: Array  # (n, n) float32 cm, height of the seabed, row i is y, column j is x
    terrain_half_width_cm: float  # the grid spans [-w, w] in x and y
    world_radius_cm: float
    water: Water


@dataclass(frozen=True)
class Batch:
    """Consecutive instances that share species and level of detail."""

    species: int
    level: int
    first: int
    count: int


@dataclass(frozen=True)
class Packet:
    """One frame."""

    time_s: float  # world time, interpolated
    views: tuple[View, ...]
    instances: Array  # (m, 16) float32, sorted by batch
    batches: tuple[Batch, ...]
    plankton: Array  # (p, 3) float32 cm
    hidden: int  # fishes culled away
