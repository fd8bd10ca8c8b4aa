"""An eel that swims by muscles: its gait, its turns, and what it cannot do."""

import numpy as np
import pytest
from msgspec.structs import replace

from capture.recording.segment import record_spine_segment
from capture.recording.spine_manoeuvre import Manoeuvre, search_bend
from capture.recording.spine_muscles import eel_of, muscle_motion
from subsea.base.errors import UserError
from subsea.biomechanics.solver import TICK_S
from subsea.fish.species import load_species
from tests.support.spines import by_rules

SPECIES = load_species("ribbon_eel")
PLAN, SURFACE = SPECIES.spine, SPECIES.surface
SHARP_BEND = Manoeuvre(17, PLAN.fast, -2.0, 1.0, 0.0, 1.0, 14)


@pytest.fixture(name="eel", scope="module")
def swimming_eel():
    return eel_of(PLAN, SURFACE)


def test_the_water_and_the_muscles_make_the_gait(eel):
    """Tytell 2004, and Borazjani and Sotiropoulos 2009."""
    segment = record_spine_segment(PLAN, SURFACE, "swim_fast")
    assert segment.cyclic and segment.loop_error_bl < 1e-7
    assert segment.control_points.shape == (PLAN.fast.ticks_per_beat, 426, 3)
    speed = segment.speed_cm_s / PLAN.length
    assert 0.5 < speed < 2.0
    beat = eel.steady(PLAN.fast)
    aside = ((beat.line - beat.path[:, None]) / np.exp(1j * beat.heading[:, None])).imag
    sweep = np.ptp(aside, axis=0)
    assert 0.25 < sweep[-1] / (speed * PLAN.fast.ticks_per_beat * TICK_S) < 0.45
    # The snout moves a little, and the wave grows towards the tail.
    assert 0.02 < sweep[0] < 0.35 * sweep[-1]
    assert 1.0 < np.degrees(np.ptp(beat.yaw)) < 15.0


def test_weaker_muscles_swim_slower(eel):
    weak = replace(PLAN.fast, contraction=0.5 * PLAN.fast.contraction)
    assert 0.0 < eel.pace(weak) < 0.8 * eel.pace(PLAN.fast)


def test_a_bend_turns_the_eel_to_its_side_and_runs_on(eel):
    left, right = (eel.move(SHARP_BEND, size) for size in (0.2, -0.2))
    turned = [float(np.degrees(one.heading[-1] - one.heading[0])) for one in (left, right)]
    assert 20.0 < turned[0] < 90.0
    # The beat is the same on both sides: its second half would mirror the turn.
    assert -90.0 < turned[1] < -20.0


def test_a_right_turn_mirrors_a_left_one(eel, monkeypatch):
    swum = eel.move(SHARP_BEND, 0.1)
    monkeypatch.setattr(type(eel), "swim", lambda self, name: swum)
    left, right = (muscle_motion(PLAN, SURFACE, f"turn_{side}_rest") for side in ("left", "right"))
    for node in (left.nodes, right.nodes):
        assert np.isfinite(node).all()
    np.testing.assert_allclose(left.nodes[:, 0] * (1, 1, -1), right.nodes[:, 0], atol=1e-9)
    a, b = left.points, right.points * (1, 1, -1)
    swapped = np.concatenate([b[:, 189:378], b[:, :189], b[:, 378:]], axis=1)
    np.testing.assert_allclose(a, swapped, atol=1e-3)


def test_a_bend_that_tears_the_body_and_a_spine_without_muscles_are_refused(eel):
    with pytest.raises(UserError, match="loses its shape"):
        eel.move(SHARP_BEND, 0.9)
    with pytest.raises(ValueError, match="no muscles"):
        eel_of(by_rules("ribbon_eel").spine, SURFACE)
    with pytest.raises(ValueError, match="no bend turns the fish by 57 degrees"):
        search_bend(lambda size: 0.1 * size, 1.0, 0.0, 1.0)
