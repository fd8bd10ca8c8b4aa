"""Pectoral fins and breath."""

import numpy as np
import pytest

from subsea.motor.fins import flap
from subsea.motor.playback import ROW, SIDES
from subsea.repertoire import SEGMENTS
from subsea.state import DORSAL, LIFT_LEFT, LIFT_RIGHT, MOUTH, SWEEP_LEFT, SWEEP_RIGHT, TAIL
from tests.support.scenes import everyone

TICK = 0.033


def _minute(make_fishes, library, steering, speed, oars=False, thrust=1.0):
    """The seven columns (T, 7) of a fish's fins over a minute."""
    fishes = make_fishes(1)
    fishes.steering[:], fishes.goal_speed[:] = steering, speed
    fishes.oars[:], fishes.thrust[:] = oars, thrust
    fins = []
    for _ in range(1800):
        flap(everyone(fishes), fishes, library, TICK)
        fins.append(fishes.fins[0].copy())
    return np.array(fins)


def _beats(signal):
    """Upward crossings of the mean."""
    centred = signal - signal.mean()
    return int(((centred[1:] > 0) & (centred[:-1] <= 0)).sum())


def test_fins_never_rest_and_beat_wider_and_faster_with_effort(make_fishes, library):
    calm = _minute(make_fishes, library, (0.0, 0.0), 0.9)
    climbing = _minute(make_fishes, library, (0.0, 0.5), 0.9)
    assert np.ptp(calm[:, 0]) > 0.2
    assert np.ptp(climbing[:, 0]) > 1.5 * np.ptp(calm[:, 0])
    assert _beats(climbing[:, 0]) > 1.5 * _beats(calm[:, 0])


def test_a_fast_fish_folds_its_fins_and_a_hovering_one_sculls(make_fishes, library):
    fast = _minute(make_fishes, library, (0.0, 0.0), 1.0)
    hovering = _minute(make_fishes, library, (0.0, 0.0), 0.0)
    assert fast[:, :2].mean() < hovering[:, :2].mean() - 0.2
    assert _beats(hovering[:, 0]) > 2 * _beats(fast[:, 0])


def test_oars_beat_faster_in_a_faster_fish(make_fishes, library):
    """Tu B.2; the fins of other fishes scull while they hover."""
    slow, fast = (
        _minute(make_fishes, library, (0.0, 0.0), speed, oars=True)[:, LIFT_LEFT]
        for speed in (0.1, 1.0)
    )
    assert _beats(fast) > 2 * _beats(slow)


def test_in_a_turn_one_fin_leads(make_fishes, library):
    left = _minute(make_fishes, library, (0.4, 0.0), 0.6)
    right = _minute(make_fishes, library, (-0.4, 0.0), 0.6)
    np.testing.assert_allclose(left[:, 0].mean(), right[:, 1].mean(), atol=0.02)
    assert left[:, 0].mean() > left[:, 1].mean() + 0.2


def test_breath_is_regular_and_quickens_with_speed(make_fishes, library):
    calm = _minute(make_fishes, library, (0.0, 0.0), 0.0)[:, MOUTH]
    hurried = _minute(make_fishes, library, (0.0, 0.0), 1.0)[:, MOUTH]
    assert 0 <= calm.min() < calm.max() <= 1
    assert _beats(hurried) > 1.7 * _beats(calm) > 60


def _turns(sweep, lift):
    """Turns of the fin round its cone: positive forwards."""
    angle = np.unwrap(np.arctan2(sweep - sweep.mean(), lift))
    return (angle[-1] - angle[0]) / (2 * np.pi)


def test_flat_fishes_oar_forwards_and_in_a_turn_the_inner_fin_backwards(make_fishes, library):
    ahead = _minute(make_fishes, library, (0.0, 0.0), 0.6, oars=True)
    left = _minute(make_fishes, library, (0.6, 0.0), 0.6, oars=True)
    assert _turns(ahead[:, SWEEP_LEFT], ahead[:, LIFT_LEFT]) > 60
    assert _turns(ahead[:, SWEEP_RIGHT], ahead[:, LIFT_RIGHT]) > 60
    assert _turns(left[:, SWEEP_LEFT], left[:, LIFT_LEFT]) < -60
    assert _turns(left[:, SWEEP_RIGHT], left[:, LIFT_RIGHT]) > 60


def test_they_brake_and_retreat_by_oaring_backwards(make_fishes, library):
    braking = _minute(make_fishes, library, (0.0, 0.0), 0.0, oars=True, thrust=0.0)
    for sweep, lift in ((SWEEP_LEFT, LIFT_LEFT), (SWEEP_RIGHT, LIFT_RIGHT)):
        assert _turns(braking[:, sweep], braking[:, lift]) < -60


def test_others_flap_without_lifting(make_fishes, library):
    fins = _minute(make_fishes, library, (0.3, 0.3), 0.6)
    assert (fins[:, [LIFT_LEFT, LIFT_RIGHT]] == 0).all()


def test_speed_folds_the_dorsal_fin_and_braking_spreads_the_tail(make_fishes, library):
    fast, slow = (_minute(make_fishes, library, (0.0, 0.0), speed)[-1] for speed in (1.0, 0.1))
    braking = _minute(make_fishes, library, (0.0, 0.0), 0.0, thrust=0.0)
    assert 0.6 < fast[DORSAL] < 0.75 < 0.95 < slow[DORSAL] <= 1.0
    assert fast[TAIL] < 0.01 < 0.2 < braking[-1, TAIL]
    assert np.abs(np.diff(braking, axis=0)[:, [DORSAL, TAIL]]).max() < 0.11  # eased


@pytest.mark.parametrize("segment", SEGMENTS)
def test_a_turn_spreads_the_tail_and_straight_swimming_does_not(make_fishes, library, segment):
    fishes = make_fishes(1, segment)
    fishes.goal_speed[:] = fishes.thrust[:] = 1.0
    for _ in range(90):
        flap(everyone(fishes), fishes, library, TICK)
    turns = "left" in segment or "right" in segment
    assert (fishes.fins[0, TAIL] > 0.15) == turns
    assert SIDES[SEGMENTS.index(segment)] == (segment.count("left") - segment.count("right"))


def _rowing(make_fishes, library, flaps, steering=0.0):
    """Sweep and lift of the left fin at every row of the pectoral gait, and the phase, rad."""
    rows = library._replace(has=np.ones_like(library.has))
    fishes = make_fishes(1, "row_forward")
    fishes.flaps[:], fishes.steering[:, 0] = flaps, steering
    first, length = library.first[0, ROW], library.length[0, ROW]
    sweeps, lifts = [], []
    for row in range(length):
        fishes.row_a[:], fishes.row_b[:] = first + (row - 1) % length, first + row
        flap(everyone(fishes), fishes, rows, TICK)
        sweeps.append(fishes.fins[0, SWEEP_LEFT])
        lifts.append(fishes.fins[0, LIFT_LEFT])
    return np.array(sweeps), np.array(lifts), 2 * np.pi * np.arange(length) / length


def test_a_rowing_fin_is_foremost_as_the_stroke_begins_and_goes_back_below(make_fishes, library):
    """The phase of the fins is that of the recorded row, however fast it is played."""
    sweeps, lifts, phase = _rowing(make_fishes, library, flaps=False)
    np.testing.assert_allclose(sweeps, np.pi / 3 + np.pi / 4 * np.cos(phase), atol=1e-6)
    down = (phase > 0.0) & (phase < np.pi)
    assert np.mean(lifts[down]) < 0 < np.mean(lifts[phase > np.pi])


def test_a_flapping_fin_beats_up_and_down_across_the_way(make_fishes, library):
    sweeps, lifts, phase = _rowing(make_fishes, library, flaps=True)
    assert np.ptp(sweeps) < 1e-6
    np.testing.assert_allclose(lifts, np.radians(50.0) * np.cos(phase), atol=1e-6)


@pytest.mark.parametrize("flaps", [False, True])
def test_a_rowing_fish_strokes_with_the_outer_fin_and_brakes_with_the_inner(
    make_fishes, library, flaps
):
    """Steering to the left: the left fin stands broadside; to the right it strokes as ever."""
    inner, raised, _ = _rowing(make_fishes, library, flaps, steering=0.6)
    assert np.ptp(inner) < 1e-3 and np.ptp(raised) < 1e-3 and inner.mean() > 1.0
    straight, outer = (_rowing(make_fishes, library, flaps, steering=s)[0:2] for s in (0.0, -0.6))
    np.testing.assert_allclose(outer, straight, atol=1e-6)


def test_a_burst_folds_the_fins_and_holds_them_still(make_fishes, library):
    fishes = make_fishes(1, "swim_fast")
    fishes.goal_speed[:], fishes.tempo[:] = 2.0, 2.5
    sweeps = []
    for _ in range(60):
        flap(everyone(fishes), fishes, library, TICK)
        sweeps.append(fishes.fins[0, SWEEP_LEFT])
    assert max(sweeps) < 0.06
    assert np.ptp(sweeps) < 1e-6
