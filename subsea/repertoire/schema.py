"""Data of a repertoire: the segments that one species plays back (SMC §4.3)."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints

FORMAT = "subsea-repertoire"
VERSION = 3
NODES = 23
CONTROL_POINTS = 426
MAX_FRAMES = 2000
MAX_GLIDE_FRAMES = 14
PATTERNS = ("forward", "left", "right")
GRADES = (
    "slow",
    "medium",
    "fast",
    "gradual",
    "sharp",
    "burst",
    "moderate",
    "wide",
    "rest",
    "glide",
    "start",
    "stop",
    "forward",
    "coast",
    "row",
)

ACYCLIC = ("sharp", "moderate", "wide", "rest", "glide", "start", "stop")  # grades: played once

# Every repertoire has these.
BASIC_SEGMENTS = (
    "swim_slow",
    "swim_medium",
    "swim_fast",
    "turn_left_gradual",
    "turn_left_sharp",
    "turn_right_gradual",
    "turn_right_sharp",
)

# A repertoire may lack these; playback then takes the substitute.
SUBSTITUTES = {
    "swim_burst": "swim_fast",
    "cstart_left_moderate": "turn_left_sharp",
    "cstart_left_wide": "turn_left_sharp",
    "cstart_right_moderate": "turn_right_sharp",
    "cstart_right_wide": "turn_right_sharp",
    "turn_left_rest": "turn_left_sharp",
    "turn_right_rest": "turn_right_sharp",
    "turn_left_glide": "turn_left_sharp",
    "turn_right_glide": "turn_right_sharp",
    "swim_start": "swim_medium",
    "swim_stop": "swim_slow",
    "row_forward": "swim_slow",
    "swim_coast": "swim_slow",
    "turn_left_coast": "turn_left_gradual",
    "turn_right_coast": "turn_right_gradual",
    "turn_left_row": "turn_left_gradual",
    "turn_right_row": "turn_right_gradual",
}

# Swims and their turns to left and right that bend the body step by step.
FAMILIES = {
    "swim_medium": ("turn_left_gradual", "turn_right_gradual"),
    "swim_coast": ("turn_left_coast", "turn_right_coast"),
    "row_forward": ("turn_left_row", "turn_right_row"),
}

# The code of a segment in `state.fishes.segment` is its place in this list.
SEGMENTS = (*BASIC_SEGMENTS, *SUBSTITUTES)


@dataclass(frozen=True)
class Segment:
    """One recorded action. Row k leads from state k to k+1 and holds the deformation at k+1.

    Playback: R ← R·M_k, o ← o + R_old·t_k, n = o + R·d_k (SMC eqs. 10-12, increments in body
    axes and applied on the right, so that they hold at any attitude).
    """

    pattern: str  # one of PATTERNS
    grade: str  # one of GRADES
    cyclic: bool  # the last row is followed by the first
    increment_rotation: Array  # (T, 4) unit quaternions w, x, y, z
    increment_translation: Array  # (T, 3) cm, in the body axes before the increment
    nodes: Array  # (T, 23, 3) cm, in body axes
    control_points: Array | None  # (T, 426, 3) cm, in body axes
    speed_cm_s: float  # mean over the segment
    turn_deg: float  # change of heading over the segment, left positive
    loop_error_bl: float  # gap between last and first frame, body lengths
    bounding_radius_bl: float  # farthest node from the origin, body lengths
    # The share of this speed that the fish loses in a row, where nothing drives it.
    slowing: float = 0.0


class Transitions(NamedTuple):
    """From each of the r rows of a repertoire to each of its m segments, as in `recorded_names`.

    Rows are the frames of the segments, one segment after another.
    """

    entry: Ints  # (r, m) row at which the segment is entered
    frames: Ints  # (r, m) length of the glide, 1 to MAX_GLIDE_FRAMES
    leave: NDArray[np.bool_]  # (r, m) True if this row is a good one to leave


@dataclass(frozen=True)
class Repertoire:
    """All segments of one species and their provenance."""

    species: str
    tick_s: float
    body_length_cm: float
    source: str
    provenance: dict[str, Any]  # parameters, versions, seed: enough to rebuild the file
    rest_nodes: Array  # (23, 3) cm
    segments: dict[str, Segment]
    transitions: Transitions | None = None  # planned when it is written, or else on packing

    def recorded_names(self) -> list[str]:
        """Names of the known segments that the file has, in the order of SEGMENTS."""
        return [name for name in SEGMENTS if name in self.segments]
