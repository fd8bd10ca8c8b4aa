"""Codes of `repertoire.schema.SEGMENTS`, as plain numbers for compiled kernels."""

import numpy as np

from subsea.kernels import kernel
from subsea.repertoire import SEGMENTS

SLOW, MEDIUM, FAST, LEFT_GRADUAL, LEFT_SHARP, RIGHT_GRADUAL, RIGHT_SHARP = range(7)
BURST = SEGMENTS.index("swim_burst")
CSTARTS = range(SEGMENTS.index("cstart_left_moderate"), SEGMENTS.index("cstart_right_wide") + 1)
FIRST_CSTART, LAST_CSTART = CSTARTS[0], CSTARTS[-1]
LEFT_REST = SEGMENTS.index("turn_left_rest")
LEFT_GLIDE = SEGMENTS.index("turn_left_glide")
START, STOP = SEGMENTS.index("swim_start"), SEGMENTS.index("swim_stop")
ROW = SEGMENTS.index("row_forward")
# The side to which each segment turns: 1 left, -1 right, 0 none.
SIDES = np.array([("left" in name) - float("right" in name) for name in SEGMENTS])


@kernel
def is_cstart(segment: int) -> bool:
    """True for an escape."""
    return FIRST_CSTART <= segment <= LAST_CSTART


@kernel
def blends(segment: int) -> bool:
    """True for the straight swim and the gradual turns, which blend with it row by row."""
    return segment in (MEDIUM, LEFT_GRADUAL, RIGHT_GRADUAL)
