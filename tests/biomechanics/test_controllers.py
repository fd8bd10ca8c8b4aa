import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.biomechanics.body import MUSCLE_LEFT, MUSCLES, build_body
from subsea.biomechanics.controllers import (
    LEFT,
    RIGHT,
    S_MAX,
    bend_contraction,
    ease,
    muscle_lengths,
    steering,
    swim_contraction,
    turn_share,
)
from subsea.biomechanics.solver import STEPS_PER_TICK

left, right = MUSCLE_LEFT > 0, MUSCLE_LEFT < 0
PHASES = np.linspace(0, 2 * np.pi, 61)


def test_the_sides_swim_in_antiphase(species):
    now = swim_contraction(species.swim, PHASES)
    half_a_beat_on = swim_contraction(species.swim, PHASES + np.pi)
    np.testing.assert_allclose(now[:, left], half_a_beat_on[:, right], atol=1e-12)
    assert (now >= -1e-15).all()
    assert now.max() <= max(species.swim.contraction)


def test_the_foremost_segment_rests_and_the_hindmost_follows(species):
    wave = swim_contraction(species.swim, PHASES)
    later = swim_contraction(species.swim, PHASES + species.swim.lag)
    assert not wave[:, :4].any()
    front, back = species.swim.contraction
    np.testing.assert_allclose(later[:, 8:] / back, wave[:, 4:8] / front, atol=1e-12)


def test_amplitude_scales_the_contraction(species):
    np.testing.assert_allclose(
        swim_contraction(species.swim, PHASES, 0.3), 0.3 * swim_contraction(species.swim, PHASES)
    )


def test_no_muscle_shortens_faster_than_s_max(species):
    body = build_body(species.body)
    steps = species.swim.ticks_per_beat * STEPS_PER_TICK
    phase = 2 * np.pi * np.arange(steps + 1) / steps
    swum = muscle_lengths(body, swim_contraction(species.swim, phase))
    assert np.abs(np.diff(swum, axis=0)).max() <= S_MAX
    row = steering(species.turn, species.turn.sharp)
    share = turn_share(row, np.arange(0, 120, 1 / STEPS_PER_TICK))
    turned = muscle_lengths(body, bend_contraction(row.contraction, LEFT, share))
    assert np.abs(np.diff(turned, axis=0)).max() <= S_MAX


def test_only_the_inner_side_bends():
    bent = bend_contraction((0.2, 0.1), RIGHT)[0]
    np.testing.assert_allclose(bent[:8], [0, 0.2, 0.2, 0, 0, 0.1, 0.1, 0])
    assert not bent[8:].any()
    np.testing.assert_allclose(bend_contraction((0.2, 0.1), LEFT)[0][left], bent[right])


@given(st.floats(-3, 3))
def test_easing_is_monotone_from_nothing_to_all(share):
    assert 0 <= ease(share) <= ease(share + 0.1) <= 1
    assert ease(0) == 0
    assert ease(1) == 1
    assert ease(0.5) == 0.5


@pytest.mark.parametrize("angle", [10.0, 30.0, 52.5, 90.0])
def test_a_turn_bends_fast_holds_and_relaxes(species, angle):
    row = steering(species.turn, angle)
    ends = np.cumsum([0, row.bend_ticks, row.hold_ticks, row.restore_ticks])
    np.testing.assert_allclose(turn_share(row, ends), [0, 1, 1, 0], atol=1e-12)
    assert row.bend_ticks < row.restore_ticks


def test_the_steering_map_passes_through_its_rows(species):
    for row in species.turn.steering:
        assert steering(species.turn, row.angle) == row
    first, second = species.turn.steering[:2]
    middle = steering(species.turn, (first.angle + second.angle) / 2)
    assert middle.hold_ticks == pytest.approx((first.hold_ticks + second.hold_ticks) / 2)
    half = steering(species.turn, first.angle / 2)
    assert half.contraction == pytest.approx(tuple(c / 2 for c in first.contraction))


def test_lengths_are_rest_lengths_less_their_contraction(fusilier):
    body = build_body(fusilier.body)
    lengths = muscle_lengths(body, np.tile([0.0, 0.25], (3, 6)))
    np.testing.assert_allclose(lengths[1], body.length[:MUSCLES] * np.tile([1, 0.75], 6))
