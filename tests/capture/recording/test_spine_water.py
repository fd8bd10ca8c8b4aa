"""Speeds of an eel and a ray in the water."""

from itertools import pairwise

import msgspec
import numpy as np
import pytest

from capture.recording.spine_motion import spine_motion
from capture.recording.spine_water import coast, recoil_of, stride_of, swim_beat, wing_strips
from subsea.biomechanics.solver import TICK_S
from tests.support.spines import by_rules

EEL, RAY = by_rules("ribbon_eel"), by_rules("spotted_eagle_ray")
GRADES = ("slow", "medium", "fast", "burst")


@pytest.mark.parametrize(
    ("species", "slips", "strouhal", "speeds"),
    [
        # Tytell 2004 (American eel), in body lengths per second; Gillis 1998.
        (EEL, (0.58, 0.8), (0.25, 0.4), (0.3, 2.0)),
        # Rosenberger 2001: 1-3 disc lengths per second; Fish et al. 2016: St 0.2-0.4.
        (RAY, (0.5, 0.8), (0.2, 0.4), (0.25, 1.4)),
    ],
)
def test_speeds_are_those_of_real_fishes(species, slips, strouhal, speeds):
    plan, surface = species.spine, species.surface
    found = []
    for grade in GRADES:
        gait = getattr(plan, grade)
        stride = stride_of(plan, surface, gait)
        points = spine_motion(plan, surface, f"swim_{grade}").points / plan.length
        last = points[..., 1 if plan.wings else 2]
        amplitude = np.ptp(last[:, points[0, :, 2].argmax() if plan.wings else 20])
        assert slips[0] < stride / plan.wavelength < slips[1]
        assert strouhal[0] < amplitude / stride < strouhal[1]
        found.append(stride / (gait.ticks_per_beat * TICK_S))
    assert speeds[0] < found[0] and found[-1] < speeds[1]
    assert all(b > 1.4 * a for a, b in pairwise(found[:3])) and found[3] > found[2]


@pytest.mark.parametrize("species", [EEL, RAY])
def test_frequency_sets_the_speed_and_amplitude_the_stride(species):
    plan, surface = species.spine, species.surface
    gait = plan.medium
    quick = msgspec.structs.replace(gait, ticks_per_beat=gait.ticks_per_beat // 2)
    small = msgspec.structs.replace(gait, amplitude=0.5 * gait.amplitude)
    stride = stride_of(plan, surface, gait)
    assert stride_of(plan, surface, quick) == pytest.approx(stride, rel=1e-6)
    assert stride_of(plan, surface, small) < stride


def test_an_eel_trims_itself_by_symmetry_and_recoils_by_half_beats():
    beat = swim_beat(EEL.spine, EEL.surface, EEL.spine.fast)
    half = len(beat.recoil) // 2
    np.testing.assert_allclose(beat.recoil[half:-1, 1:], -beat.recoil[:half, 1:], atol=1e-4)
    times = np.linspace(0.0, 2.0, 5)
    there = recoil_of(EEL.spine, EEL.surface, EEL.spine.fast, times)
    np.testing.assert_allclose(there[[0, 1]], there[[2, 3]], atol=1e-12)


def test_a_plate_carries_the_water_of_a_cylinder_around_its_chord():
    """Added mass ¼πρc² per span of each wing."""
    parts = wing_strips(RAY.spine, RAY.surface, np.linspace(0, 1, 5), 0.5, 1.0)
    dy = RAY.surface.wing.span * RAY.spine.length / len(parts.added)
    chord = parts.across.sum(axis=1) / (2.0 * dy)
    np.testing.assert_allclose(parts.added.sum(axis=1), 2 * 0.25 * np.pi * chord**2 * dy, rtol=1e-9)


def test_a_ray_coasts_as_its_drag_says():
    travelled = coast(RAY.spine, RAY.surface, 0.016, 1.9)
    speed = np.diff(travelled)
    assert travelled[-2] < 1.9 <= travelled[-1]
    loss = np.diff(1.0 / speed)
    np.testing.assert_allclose(loss, loss[0], rtol=0.01)
    assert 0.4 * speed[0] < speed[-1] < 0.9 * speed[0]
