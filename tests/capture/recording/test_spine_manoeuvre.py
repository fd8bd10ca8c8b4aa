"""Escapes, starts, stops and free turns of an eel by rules."""

import numpy as np
import pytest

from capture.recording.segment import record_spine_segment, spine_segments
from capture.recording.spine_manoeuvre import find_bend, manoeuvre, move, spine_manoeuvre
from subsea.repertoire import BASIC_SEGMENTS
from tests.support.spines import by_rules

EEL, RAY = by_rules("ribbon_eel"), by_rules("spotted_eagle_ray")


@pytest.mark.parametrize(
    ("name", "turn"),
    [("cstart_left_moderate", 70.0), ("cstart_right_wide", -135.0), ("turn_left_glide", 90.0)],
)
def test_the_water_turns_an_eel_that_bends(name, turn):
    segment = record_spine_segment(EEL.spine, EEL.surface, name)
    assert segment.turn_deg == pytest.approx(turn, abs=0.1)
    assert not segment.cyclic
    fastest = np.linalg.norm(segment.increment_translation, axis=1).max() / EEL.spine.length / 0.033
    if "cstart" in name:
        assert 1.3 < fastest < 3.0  # body lengths per second
        assert len(segment.nodes) * 0.033 < 1.0


def test_a_bend_to_the_other_side_is_the_mirror_image():
    left, right = (
        spine_manoeuvre(EEL.spine, EEL.surface, f"cstart_{side}_moderate").nodes
        for side in ("left", "right")
    )
    np.testing.assert_allclose(left[:, 0] * (1, 1, -1), right[:, 0], atol=1e-6)


def test_an_eel_starts_from_rest_and_comes_to_rest():
    for name, speeds in (("swim_start", (0.0, 0.45)), ("swim_stop", (0.45, 0.0))):
        segment = record_spine_segment(EEL.spine, EEL.surface, name)
        way = np.linalg.norm(segment.increment_translation, axis=1) / EEL.spine.length / 0.033
        assert way[0] == pytest.approx(speeds[0], abs=0.06)
        assert way[-1] == pytest.approx(speeds[1], abs=0.2)
        assert abs(segment.turn_deg) < 0.1


def test_too_far_a_turn_is_refused():
    what = manoeuvre(EEL.spine, "cstart_left_wide", lambda gait: 0.01)._replace(turn=6.0)
    with pytest.raises(ValueError, match="no bend"):
        find_bend(EEL.spine, EEL.surface, what)
    assert move(EEL.spine, EEL.surface, what, 0.0).frame.shape == (what.ticks + 1, 3)


def test_rays_bank_and_glide_but_do_not_rest():
    names = spine_segments(RAY.spine)
    assert "turn_left_glide" in names and "turn_left_rest" not in names
    assert "cstart_left_wide" in spine_segments(EEL.spine)
    assert set(BASIC_SEGMENTS) < set(names)
    segment = record_spine_segment(RAY.spine, RAY.surface, "turn_left_glide")
    assert segment.turn_deg == pytest.approx(90.0, abs=1e-6)
    # The wing tips lean into the turn by more than when gliding straight.
    tips = segment.control_points[:, np.abs(segment.control_points[0, :, 2]).argsort()[-2:]]
    lean = np.degrees(np.arctan2(np.ptp(tips[..., 1], axis=1), np.ptp(tips[..., 2], axis=1)))
    assert 25.0 < lean.max() < 50.0
    assert lean[0] < 3.0 and lean[-1] < 3.0
