"""Rows between a straight swim and its turns: see also `test_library`."""

import numpy as np
import pytest

from subsea.geometry.rotation import about, mixed, multiply, rotate
from subsea.repertoire.blending import LEVELS, STRAIGHT, TIGHTEST, blend_turns, course_of
from subsea.repertoire.schema import FAMILIES
from subsea.world.repertoires import repertoire_of


@pytest.fixture(scope="module")
def segments():
    return repertoire_of("clownfish").segments


def test_increments_are_mixed_as_playback_mixes_rotations(segments):
    straight = "swim_coast"  # its turns to both sides have the phase of the straight coast
    blend = blend_turns(segments, straight)
    swim, *turns = (segments[name].increment_rotation for name in (straight, *FAMILIES[straight]))
    expected = [
        mixed(a, b, level / LEVELS)
        for turn in turns
        for level in range(1, TIGHTEST + 1)
        for a, b in zip(swim, turn, strict=True)
    ]
    assert np.array_equal(blend.rotation, expected)


def test_the_full_turn_is_as_recorded(segments):
    straight = "swim_coast"
    blend, beat = blend_turns(segments, straight), len(segments[straight].nodes)
    full = slice((LEVELS - 1) * beat, LEVELS * beat)
    left = segments[FAMILIES[straight][0]]
    assert blend.nodes[full] == pytest.approx(left.nodes, abs=1e-9)
    assert blend.translation[full] == pytest.approx(left.increment_translation)


@pytest.mark.parametrize("name", ["turn_left_gradual", "cstart_left_wide"])
def test_a_course_integrates_the_increments_row_by_row(segments, name):
    segment = segments[name]
    course = course_of(segment)
    assert abs(segment.increment_rotation[:, 2].mean()) > STRAIGHT / 2
    lean = course.bank[0] if segment.cyclic else 0.0
    q = multiply(about(1.0, 0.0, 0.0, np.pi / 2), about(1.0, 0.0, 0.0, lean))
    heading, roll = [0.0], []
    for turned in segment.increment_rotation:
        q = multiply(q, tuple(turned))
        x, y = rotate(q, (1.0, 0.0, 0.0)), rotate(q, (0.0, 1.0, 0.0))
        heading.append(np.arctan2(x[1], x[0]))
        roll.append(np.arctan2(y[0] * x[1] - y[1] * x[0], y[2]))
    assert course.turn == np.unwrap(heading)[-1]
    assert np.array_equal(course.bank, np.full(len(roll), lean) if segment.cyclic else roll)
