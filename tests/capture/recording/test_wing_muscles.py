"""A ray that swims by muscles: its gait, its turns, and what it cannot do."""

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from capture.recording.segment import motion_of_segment, record_spine_segment
from capture.recording.spine_motion import half_span
from capture.recording.wing_muscles import ray_of
from capture.recording.wing_surface import draw_tail
from subsea.base.errors import UserError
from subsea.biomechanics.solver import TICK_S
from subsea.fish.species import load_species
from subsea.fish.spine import SpinePlan
from subsea.fish.surface import rest_surface
from tests.support.spines import by_rules

SPECIES = load_species("spotted_eagle_ray")
PLAN, SURFACE = SPECIES.spine, SPECIES.surface
TIP = int(rest_surface(SURFACE)[:, 2].argmax())


@pytest.fixture(name="ray", scope="module")
def swimming_ray():
    return ray_of(PLAN, SURFACE)


@pytest.mark.nightly
@pytest.mark.parametrize("grade", ["slow", "fast"])
def test_the_water_and_the_muscles_make_the_gait(grade):
    """Rosenberger 2001 (Rhinoptera bonasus), and Fish et al. 2016 for the Strouhal number."""
    segment = record_spine_segment(PLAN, SURFACE, f"swim_{grade}")
    assert segment.cyclic and segment.loop_error_bl < 1e-7
    assert abs(segment.turn_deg) < 0.01
    period = len(segment.nodes) * TICK_S
    speed = segment.speed_cm_s / PLAN.length
    assert 0.3 < 1.0 / period < 1.2
    assert 0.25 < speed < 1.0
    sweep = np.ptp(segment.control_points[:, TIP, 1]) / PLAN.length
    assert 0.3 < 0.5 * sweep / half_span(SURFACE) < 0.6
    assert 0.2 < sweep / (speed * period) < 0.4


def test_the_wave_runs_to_the_tip_and_the_body_moves_little(ray):
    swum = ray.steady(PLAN.fast).swum
    height = swum.disc[:-1, :, 2, 1] - swum.height[:-1, None]
    turn = np.exp(-2j * np.pi * np.arange(len(height)) / len(height))
    parts = turn @ height  # of each column
    late = np.angle(parts[-3] / parts[-1])  # of the tip behind the middle of the wing
    assert 0.05 < (late / (2.0 * np.pi)) % 1.0 < 0.5
    assert np.ptp(height[:, len(parts) // 2]) < 0.3 * np.ptp(height[:, -1])


def test_weaker_muscles_swim_slower(ray):
    weak = replace(PLAN.fast, contraction=0.5 * PLAN.fast.contraction)
    assert 0.0 < ray.pace(weak) < 0.8 * ray.pace(PLAN.fast)


def leans(motion):
    """Sines of the lean to the left, by the nodes on both wings."""
    left, right = motion.nodes[:, [1, 4]].mean(axis=1), motion.nodes[:, [2, 3]].mean(axis=1)
    across = left - right
    return -across[:, 1] / np.linalg.norm(across, axis=1)


@pytest.mark.nightly
def test_a_turn_leans_inward_and_the_outer_wing_beats_stronger():
    left = motion_of_segment(PLAN, SURFACE, "turn_left_sharp")
    segment = record_spine_segment(PLAN, SURFACE, "turn_left_sharp")
    assert segment.turn_deg == pytest.approx(PLAN.turn.sharp, abs=0.1)
    middle = slice(PLAN.medium.ticks_per_beat, 2 * PLAN.medium.ticks_per_beat)
    assert np.radians(8.0) < abs(leans(left)[middle].mean()) < np.radians(30.0)
    other = int(rest_surface(SURFACE)[:, 2].argmin())
    inner, outer = (np.ptp(left.points[middle, tip, 1]) for tip in (other, TIP))
    assert outer > 1.1 * inner
    right = motion_of_segment(PLAN, SURFACE, "turn_right_sharp")
    np.testing.assert_allclose(left.nodes[:, 0] * (1, 1, -1), right.nodes[:, 0], atol=1e-6)
    assert leans(left)[middle].mean() > 0.0 > leans(right)[middle].mean()


def test_a_glide_begins_at_the_speed_of_the_swim(ray):
    motion = motion_of_segment(PLAN, SURFACE, "turn_left_glide")
    steps = np.linalg.norm(np.diff(motion.nodes[:, 0], axis=0), axis=1) / PLAN.length
    assert steps[0] == pytest.approx(ray.pace(PLAN.medium), rel=0.02)


def test_a_tail_follows_a_turn_late_and_keeps_its_length():
    heading = np.repeat([0.0, 1.0], [40, 80])
    ahead = np.stack([np.cos(heading), 0.0 * heading, -np.sin(heading)], axis=1)
    rear = 0.02 * np.cumsum(ahead, axis=0)
    tail = draw_tail(np.stack([rear, rear + 0.3 * ahead], axis=1), 0.02)
    reach = np.linalg.norm(np.diff(tail, axis=1), axis=2).sum(axis=1)
    assert reach == pytest.approx(reach[0], rel=0.03)
    end = tail[:, -2] - tail[:, -1]
    late = heading - np.arctan2(-end[:, 2], end[:, 0])
    assert abs(late[39]) < 1e-6 and late[50] > 0.5 and abs(late[-1]) < 0.05


@pytest.mark.nightly
def test_wings_that_tear_or_are_weak_or_have_no_muscles_are_refused():
    wings = PLAN.wings
    torn = replace(wings, muscles=replace(wings.muscles, contraction=(0.4, 0.4), stiffness=3e4))
    with pytest.raises(UserError, match="loses its shape"):
        ray_of(replace(PLAN, wings=torn), SURFACE).steady(PLAN.fast)
    weak = replace(PLAN, medium=replace(PLAN.medium, contraction=0.3))
    with pytest.raises(UserError, match="cannot turn the ray by 75°"):
        ray_of(weak, SURFACE).swim("turn_left_sharp")
    with pytest.raises(ValueError, match="no muscles"):
        ray_of(by_rules("spotted_eagle_ray").spine, SURFACE)
    table = msgspec.to_builtins(PLAN)
    for grade in ("slow", "medium", "fast", "burst"):
        table[grade]["slip"] = 0.5
    with pytest.raises(msgspec.ValidationError, match="need gaits without slip"):
        msgspec.convert(table, SpinePlan)
