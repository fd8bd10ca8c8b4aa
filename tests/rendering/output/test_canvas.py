"""A canvas of integers: the same pictures as one of floats, up to what is shown as white."""

from dataclasses import replace

import numpy as np
import pytest

from subsea.frame.diagrams import Lines
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.schema import Grade

LOW = PRESETS["low"]
CURRENTS = [([-60, 100, -190], [60, 100, -170], [0.95, 0.9, 0.3, 0.5])]


@pytest.fixture
def both(drawn):
    """A packet -> pictures on canvases of integers and of floats."""

    def both(packet, **options):
        return [
            drawn(packet, quality=replace(LOW, floats=floats), **options)
            for floats in (False, True)
        ]

    return both


@pytest.mark.nightly
@pytest.mark.parametrize("pitch", [-0.4, 0.1, 0.7])
@pytest.mark.parametrize("samples", [0, 4])
def test_nobody_sees_which_canvas_it_was(both, make_packet, fish, pitch, samples):
    """Fishes with their shadows, sand, water, its surface, plankton, and a line."""
    rng = np.random.default_rng(3)
    fishes = [fish(k % 2, (12 * k - 40, 70 + 9 * k, -230), level=k % 5) for k in range(8)]
    plankton = rng.uniform((-200, 50, -260), (200, 400, -100), (60, 3)).astype(np.float32)
    packet = make_packet(fishes, pitch=pitch, plankton=plankton)
    ends = np.array([[one[0], one[1]] for one in CURRENTS], np.float32)
    colours = np.array([one[2] for one in CURRENTS], np.float32)
    packet = replace(packet, lines=Lines(ends, colours, np.zeros(1, np.float32)))
    integers, floats = both(packet)
    assert np.abs(integers - floats).max() <= 2
    assert np.abs(integers - floats).mean() < 0.2


@pytest.mark.parametrize("stops", [0.0, -3.0])
def test_the_sun_is_as_white(both, scene, make_packet, stops):
    """Seen straight at the sun, light is brighter than the canvas holds."""
    graded = replace(scene, grade=Grade(exposure_ev=stops))
    packet = make_packet([], eye=(0, 0, -60), heading=np.pi / 2, pitch=1.3)
    integers, floats = both(packet, scene=graded)
    assert floats.max() > (230 if stops == 0.0 else 150)
    off = np.abs(integers - floats).max(axis=2)
    assert off.mean() < 0.2
    assert (off > 2).mean() < 0.01
