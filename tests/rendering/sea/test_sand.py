"""Textures of sand: tileable, with the stated content."""

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from subsea.rendering.sea.seabed import (
    LITTER_HIGH,
    LITTER_LOW,
    RIPPLES,
    SPAN,
    TRACK_SPAN,
    flow_of,
    litter,
    ripples,
    tracks,
)


@pytest.mark.parametrize("make", [ripples, litter, tracks])
def test_edges_meet(make):
    for layer in make(1):
        jump = np.abs(layer[:, 0] - layer[:, -1]).mean(), np.abs(layer[0] - layer[-1]).mean()
        inner = np.abs(np.diff(layer, axis=1)).mean(), np.abs(np.diff(layer, axis=0)).mean()
        assert jump[0] < 3.0 * inner[0] + 0.02
        assert jump[1] < 3.0 * inner[1] + 0.02


def test_ripples_are_as_many_as_said_and_steeper_on_one_side():
    slope_x, slope_y, height, _ = ripples(2)
    power = np.abs(np.fft.fft(height, axis=1)).mean(axis=0)[1 : len(height) // 2]
    assert 1 + power.argmax() == pytest.approx(RIPPLES, abs=3)
    assert slope_x.std() > 4.0 * slope_y.std()
    assert abs((slope_x**3).mean()) > 0.1  # a sine's would be 0


def test_ripples_wander():
    """Crests bend: columns far apart differ."""
    height = ripples(3)[2]
    assert np.corrcoef(height[0], height[len(height) // 2])[0, 1] < 0.8


def test_litter_is_where_it_is_common():
    slope_x, slope_y, tone, common = litter(2)
    assert 0.0 <= tone.min() < tone.max() <= 1.0
    assert common.min() == 0.0
    assert 0.05 < (common > 0.0).mean() < 0.6
    flat = common < 1e-6
    steep = np.hypot(slope_x, slope_y)
    assert steep[~flat].mean() > 5.0 * steep[flat].mean()


def test_bytes_span_nearly_all_of_it():
    for layers, low, high in (
        (ripples(1), -SPAN, SPAN),
        (litter(1), LITTER_LOW, LITTER_HIGH),
        (tracks(1), -TRACK_SPAN, TRACK_SPAN),
    ):
        for layer, least, most in zip(layers, low, high, strict=True):
            assert ((layer < least) | (layer > most)).mean() < 0.01


def test_tracks_are_narrow_and_leave_most_of_the_sand_as_it_is():
    slope_x, slope_y, height, _ = tracks(2)
    marked = np.abs(height) > 0.05
    assert 0.03 < marked.mean() < 0.35
    assert height.min() < -0.8  # furrows and holes
    assert height.max() > 0.5  # walls and ridges
    steep = np.hypot(slope_x, slope_y)
    assert steep[marked].mean() > 10.0 * steep[~marked].mean()
    np.testing.assert_array_equal(tracks(2)[2], height)
    assert np.abs(tracks(3)[2] - height).max() > 0.5


def test_ripples_lie_across_the_current(scene, drawn, make_packet):
    """Seen from above, brightness varies along the current and little across it."""
    assert flow_of((0.0, 0.0)) == (1.0, 0.0)
    assert flow_of((0.0, -3.0)) == (0.0, -1.0)
    pictures = []
    for current in ((3.0, 0.0), (0.0, 3.0)):
        water = structs.replace(scene.water, current_cm_s=current)
        packet = make_packet([], eye=(300.0, 0.0, -180.0), pitch=-1.5, size=(200, 200))
        pictures.append(drawn(packet, scene=replace(scene, water=water)).mean(axis=2))
    assert np.abs(pictures[0] - pictures[1]).mean() > 2.0
