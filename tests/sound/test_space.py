"""Pan, delay, distance and Doppler against geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.sound.space import (
    AMBISONIC,
    BINAURAL_S,
    BLOCK,
    LAYOUTS,
    OPEN_HZ,
    RATE,
    SOUND_CM_S,
    doppler,
    fading,
    layout_of,
    loudspeakers,
    muffling,
    pan,
    reach_ears,
    toward,
)
from tests.sound.conftest import AHEAD

WAYS = st.tuples(*3 * [st.floats(-1.0, 1.0)]).filter(lambda way: np.linalg.norm(way) > 0.1)


def gains(layout, way):
    out = np.empty(layout.channels)
    pan(layout.directions, layout.width, tuple(float(x) for x in way), out)
    return out


def test_a_tick_is_a_whole_number_of_samples():
    assert BLOCK == 1584
    assert pytest.approx(0.033) == BLOCK / RATE


@pytest.mark.parametrize("name", [name for name in LAYOUTS if name != AMBISONIC])
@given(way=WAYS)
def test_the_power_of_a_source_does_not_depend_on_its_direction(name, way):
    assert (gains(LAYOUTS[name], way / np.linalg.norm(way)) ** 2).sum() == pytest.approx(1.0)


@given(way=WAYS)
def test_channels_of_a_sphere_hold_the_direction(way):
    """Those of ambiX: all round, left, up, ahead, each harmonic as large as the first (SN3D)."""
    right, ahead, up = way / np.linalg.norm(way)
    found = gains(LAYOUTS[AMBISONIC], (right, ahead, up))
    assert found == pytest.approx([1.0, -right, up, ahead])
    assert (gains(LAYOUTS[AMBISONIC], (0.0, 0.0, 0.0)) == [1.0, 0.0, 0.0, 0.0]).all()


@pytest.mark.parametrize("name", ["quad", "5.1", "7.1"])
def test_a_source_at_a_loudspeaker_is_loudest_there(name):
    layout = LAYOUTS[name]
    for number, direction in enumerate(layout.directions):
        if direction.any():
            found = gains(layout, direction)
            assert found.argmax() == number
    silent = ~layout.directions.any(axis=1)
    assert (gains(layout, (0.0, 1.0, 0.0))[silent] == 0.0).all()


def test_two_ears_hear_the_side():
    left, right = gains(LAYOUTS["stereo"], (-1.0, 0.0, 0.0)), gains(LAYOUTS["stereo"], (1.0, 0, 0))
    assert left[0] > 3.0 * left[1]
    assert left == pytest.approx(right[::-1])
    assert gains(LAYOUTS["stereo"], (0.0, 1.0, 0.0)) == pytest.approx([0.5**0.5] * 2)


def test_the_far_ear_hears_later_and_duller():
    delays, corners = np.empty(2), np.empty(2)
    binaural = LAYOUTS["binaural"]
    reach_ears(binaural.width, binaural.delay_s, (1.0, 0.0, 0.0), delays, corners)
    assert delays == pytest.approx([BINAURAL_S * RATE, 0.0])
    assert corners[1] == OPEN_HZ
    assert corners[0] < 0.3 * OPEN_HZ
    reach_ears(binaural.width, binaural.delay_s, (0.0, 1.0, 0.0), delays, corners)
    assert (delays == 0.0).all()
    assert (corners == OPEN_HZ).all()


def test_loudspeakers_of_a_list():
    layout = loudspeakers([(0.0, 0.0), (90.0, 0.0), (0.0, 90.0)])
    assert layout.directions == pytest.approx(np.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]]), abs=1e-9)
    assert gains(layout, (0.0, 0.0, 1.0)).argmax() == 2


def test_directions_are_those_of_the_listener():
    way, away = toward(AHEAD, np.zeros(3), (0.0, -200.0, 0.0))  # looking along x, y is left
    assert way == pytest.approx((1.0, 0.0, 0.0))
    assert away == pytest.approx(200.0)


@given(st.floats(60.0, 1e4))
def test_sound_spreads_and_water_muffles(away):
    assert fading(2.0 * away) == pytest.approx(0.5 * fading(away))
    assert muffling(2.0 * away) < muffling(away)
    assert fading(1.0) == fading(50.0)  # never endless


@given(st.floats(-5000.0, 5000.0), st.floats(-5000.0, 5000.0))
def test_doppler_is_the_ratio_of_speeds(source, own):
    ahead = (0.0, 1.0, 0.0)
    expected = (SOUND_CM_S + own) / (SOUND_CM_S + source)
    assert doppler(ahead, (0.0, source, 0.0), (0.0, own, 0.0)) == pytest.approx(expected)
    assert doppler(ahead, (source, 0.0, 0.0), (own, 0.0, 0.0)) == 1.0  # across: none


def test_an_unknown_layout_is_one_line():
    with pytest.raises(UserError, match="unknown layout 'sterio'; did you mean 'stereo'"):
        layout_of("sterio")
