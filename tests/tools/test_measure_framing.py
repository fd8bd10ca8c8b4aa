"""The measure of framing counts uncut subjects that are large enough."""

import numpy as np
import pytest

from subsea.rendering.gl.id_buffer import FISH, IdMaps
from tools.measure_framing import groups_of, subject_of

WIDE, HIGH = 256, 144


def maps(*boxes):
    """Make maps with a fish in each box: left, top, right, bottom."""
    kind, number = np.zeros((HIGH, WIDE), np.uint8), np.zeros((HIGH, WIDE), np.int32)
    for k, (left, top, right, bottom) in enumerate(boxes):
        kind[top:bottom, left:right], number[top:bottom, left:right] = FISH, k
    return IdMaps(kind, number, np.full((HIGH, WIDE), np.inf, np.float32))


@pytest.mark.parametrize(
    ("boxes", "framed"),
    [
        ([], False),
        ([(60, 40, 120, 80)], True),
        ([(60, 40, 90, 60)], False),  # too small
        ([(0, 40, 60, 80)], False),  # cut
        ([(60, 40, 90, 60), (95, 40, 125, 60), (75, 64, 105, 84)], True),  # a group
        ([(20, 10, 50, 30), (200, 100, 230, 120)], False),  # far apart
    ],
)
def test_a_subject_is_uncut_and_a_twentieth_of_the_picture(boxes, framed):
    assert (subject_of(maps(*boxes)) is not None) is framed


def test_groups_join_over_their_neighbours():
    row = np.array([(10 * k, 0, 10 * k + 8, 6) for k in range(5)], np.float64)
    far = np.array([(150, 80, 158, 86)], np.float64)
    groups = groups_of(np.concatenate([row, far]))
    assert sorted(map(tuple, groups)) == [(0, 0, 48, 6), (150, 80, 158, 86)]
