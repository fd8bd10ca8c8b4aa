"""Fins and breath."""

import numpy as np
import pytest

from subsea.motor.fins import fins_at, flap, flap_in_turn
from subsea.motor.playback import ROW, SIDES
from subsea.repertoire import SEGMENTS
from subsea.state import (
    DORSAL,
    LAG,
    LIFT_LEFT,
    LIFT_RIGHT,
    MOUTH,
    PELVIC,
    SOFT,
    SWEEP_LEFT,
    SWEEP_RIGHT,
    TAIL,
    TWIST_LEFT,
    TWIST_RIGHT,
    WAVE_COSINE,
    WAVE_SINE,
)
from tests.support.scenes import everyone

TICK = 0.033


def _minute(make_fishes, library, steering, speed, oars=False, thrust=1.0, way=0.0, **members):
    """The columns (T, 11) of a fish's fins over a minute; `way` is its speed, cm/s."""
    fishes = make_fishes(1)
    fishes.steering[:], fishes.goal_speed[:] = steering, speed
    fishes.oars[:], fishes.thrust[:], fishes.velocity[:, 0] = oars, thrust, way
    for name, value in members.items():
        getattr(fishes, name)[:] = value
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
    for thrust, way in ((0.0, 10.0), (-0.6, -10.0)):
        fins = _minute(make_fishes, library, (0.0, 0.0), 0.0, oars=True, thrust=thrust, way=way)
        for sweep, lift in ((SWEEP_LEFT, LIFT_LEFT), (SWEEP_RIGHT, LIFT_RIGHT)):
            assert _turns(fins[:, sweep], fins[:, lift]) < -60


@pytest.mark.parametrize("oars", [False, True])
def test_a_hovering_fish_sculls_in_turns_and_in_a_figure_of_eight(make_fishes, library, oars):
    """The left fin goes out as the right one comes in; both rise twice in a beat."""
    fins = _minute(make_fishes, library, (0.0, 0.0), 0.0, oars=oars, thrust=0.0)[300:]
    left, right = (fins[:, side] - fins[:, side].mean() for side in (SWEEP_LEFT, SWEEP_RIGHT))
    assert np.corrcoef(left, right)[0, 1] < -0.98
    for side, lift in ((SWEEP_LEFT, LIFT_LEFT), (SWEEP_RIGHT, LIFT_RIGHT)):
        assert _beats(fins[:, lift]) == pytest.approx(2 * _beats(fins[:, side]), abs=2)
        assert np.ptp(fins[:, lift]) > 0.3


@pytest.mark.parametrize("oars", [False, True])
def test_the_blade_of_a_sculling_fin_reverses_its_pitch_between_half_strokes(
    make_fishes, library, oars
):
    """The upper edge leads on the way out and on the way back."""
    fins = _minute(make_fishes, library, (0.0, 0.0), 0.0, oars=oars, thrust=0.0)[300:]
    for sweep, twist in ((SWEEP_LEFT, TWIST_LEFT), (SWEEP_RIGHT, TWIST_RIGHT)):
        speed = np.gradient(fins[:, sweep])
        assert np.corrcoef(speed, fins[:, twist])[0, 1] > 0.98
        assert fins[:, twist].min() < -0.4 and fins[:, twist].max() > 0.4


def test_the_inner_fin_of_a_recorded_turn_stands_off(make_fishes, library):
    """Nothing steers besides: the body bends as it was recorded."""
    for segment, inner in (("turn_left_sharp", SWEEP_LEFT), ("turn_right_sharp", SWEEP_RIGHT)):
        fishes = make_fishes(1, segment)
        fishes.goal_speed[:] = 0.65
        sweeps = []
        for _ in range(200):
            flap(everyone(fishes), fishes, library, TICK)
            sweeps.append(fishes.fins[0, :2].copy())
        left, right = np.mean(sweeps, axis=0)
        assert (left - right) * (1 if inner == SWEEP_LEFT else -1) > 0.5


def test_the_edge_of_the_tail_lags_behind_its_stroke(make_fishes, library):
    """More so in a faster beat, and not at all in a pose that is held."""
    widest = []
    for name in ("swim_slow", "swim_fast"):
        fishes = make_fishes(1, name)
        code = SEGMENTS.index(name)
        first, length = library.first[0, code], library.length[0, code]
        lags = []
        for row in range(length):
            fishes.row_a[:], fishes.row_b[:] = first + row, first + (row + 1) % length
            flap(everyone(fishes), fishes, library, TICK)
            lags.append(fishes.fins[0, LAG])
        tail = library.nodes[first : first + length, 21:23, 2].mean(axis=1)
        stroke = np.roll(tail, -1) - tail
        assert np.corrcoef(stroke, lags)[0, 1] < -0.95
        widest.append(np.abs(lags).max())
    assert 0.02 < widest[0] < widest[1] <= 0.35
    fishes.row_b[:] = fishes.row_a
    flap(everyone(fishes), fishes, library, TICK)
    assert fishes.fins[0, LAG] == 0.0


def test_a_fast_fish_folds_its_oars(make_fishes, library):
    slow, fast = (
        _minute(make_fishes, library, (0.0, 0.0), speed, oars=True)[:, SWEEP_LEFT]
        for speed in (0.3, 1.0)
    )
    assert fast.max() < 0.35 < 0.8 < slow.max()


def test_others_flap_without_lifting(make_fishes, library):
    fins = _minute(make_fishes, library, (0.3, 0.3), 0.6)
    assert (fins[:, [LIFT_LEFT, LIFT_RIGHT]] == 0).all()


def test_speed_folds_the_dorsal_fin_and_braking_spreads_the_tail(make_fishes, library):
    fast, slow = (_minute(make_fishes, library, (0.0, 0.0), speed)[-1] for speed in (1.0, 0.1))
    braking = _minute(make_fishes, library, (0.0, 0.0), 0.0, thrust=0.0, way=15.0)
    assert 0.6 < fast[DORSAL] < 0.75 < 0.95 < slow[DORSAL] <= 1.0
    assert fast[TAIL] < 0.01 < 0.2 < braking[-1, TAIL]
    assert np.abs(np.diff(braking, axis=0)[:, [DORSAL, TAIL]]).max() < 0.11  # eased


def test_a_fast_or_gliding_fish_closes_its_tail(make_fishes, library):
    still, fast, gliding = (
        _minute(make_fishes, library, (0.0, 0.0), speed, span=span)[-1, TAIL]
        for speed, span in ((0.1, 1.0), (1.0, 1.0), (0.1, 9.0))
    )
    assert max(fast, gliding) < -0.1 < -0.01 < still


def test_median_fins_are_raised_in_turns_when_braking_and_in_threat(make_fishes, library):
    cruising, turning, braking, threatened = (
        _minute(make_fishes, library, (steering, 0.0), speed, way=20.0, raised=raised)
        for steering, speed, raised in ((0, 0.7, 0), (1.5, 0.7, 0), (0, 0.1, 0), (0, 0.7, 1))
    )
    for column in (DORSAL, SOFT):
        assert cruising[-1, column] < 0.9
        assert min(fins[-1, column] for fins in (turning, braking, threatened)) > 1.05


def test_a_burst_folds_median_and_pelvic_fins_and_the_soft_rays_follow(make_fishes, library):
    fins = _minute(make_fishes, library, (0.0, 0.0), 2.0, tempo=2.5, raised=1.0)
    assert fins[-1, [DORSAL, SOFT]].max() < 0.55 and fins[-1, PELVIC] < 0.01
    half = [int((fins[:, column] > 0.75).sum()) for column in (DORSAL, SOFT)]
    assert half[0] < half[1] < 12  # ticks
    assert np.abs(fins[-1, [WAVE_SINE, WAVE_COSINE]]).max() < 1e-3


def test_pelvic_fins_are_folded_in_a_fast_fish_and_spread_by_a_slow_or_braking_one(
    make_fishes, library
):
    fast, slow, braking = (
        _minute(make_fishes, library, (0.0, 0.0), speed, way=way)[-1, PELVIC]
        for speed, way in ((0.8, 20.0), (0.0, 0.0), (0.15, 20.0))
    )
    assert fast < 0.01 < 0.9 < min(slow, braking)


def test_the_wave_is_large_in_calm_fishes_and_steady_in_time(make_fishes, library):
    """Its phase advances evenly, backwards in a retreat, so that it can be interpolated."""
    rows = library._replace(has=np.ones_like(library.has))
    hovering, cruising, retreating = (
        _minute(make_fishes, rows, (0.0, 0.0), speed, thrust=thrust, way=way)[:, WAVE_SINE:PELVIC]
        for speed, thrust, way in ((0.0, 0.0, 0.0), (1.0, 1.0, 30.0), (0.0, -0.6, -5.0))
    )
    wide = [np.hypot(*wave[-1]) for wave in (hovering, cruising, retreating)]
    assert wide[0] > 0.1 and wide[1] < 0.25 * wide[0]
    for wave, way in ((hovering, 1), (cruising, 1), (retreating, -1)):
        steps = way * np.diff(np.unwrap(np.arctan2(*wave.T))[9:])
        assert 0.2 < steps.min() <= steps.max() < 1.31


@pytest.mark.parametrize("segment", SEGMENTS)
def test_a_turn_spreads_the_tail_and_straight_swimming_does_not(make_fishes, library, segment):
    fishes = make_fishes(1, segment)
    fishes.goal_speed[:] = fishes.thrust[:] = 1.0
    fishes.bend[:] = SIDES[SEGMENTS.index(segment)]
    for _ in range(90):
        flap(everyone(fishes), fishes, library, TICK)
    turns = "left" in segment or "right" in segment
    assert (fishes.fins[0, TAIL] > 0.15) == turns
    assert SIDES[SEGMENTS.index(segment)] == (segment.count("left") - segment.count("right"))


def _rowing(make_fishes, library, flaps, steering=0.0):
    """Sweep, lift, phase and twist of the left fin at every row of the pectoral gait, rad."""
    rows = library._replace(has=np.ones_like(library.has))
    fishes = make_fishes(1, "row_forward")
    fishes.flaps[:], fishes.steering[:, 0] = flaps, steering
    first, length = library.first[0, ROW], library.length[0, ROW]
    sweeps, lifts, twists = [], [], []
    for row in range(length):
        fishes.row_a[:], fishes.row_b[:] = first + (row - 1) % length, first + row
        flap(everyone(fishes), fishes, rows, TICK)
        sweeps.append(fishes.fins[0, SWEEP_LEFT])
        lifts.append(fishes.fins[0, LIFT_LEFT])
        twists.append(fishes.fins[0, TWIST_LEFT])
    phase = 2 * np.pi * np.arange(length) / length
    return np.array(sweeps), np.array(lifts), phase, np.array(twists)


def test_a_rowing_fin_is_foremost_as_the_stroke_begins_and_goes_back_below(make_fishes, library):
    """The phase of the fins is that of the recorded row, however fast it is played."""
    sweeps, lifts, phase, _ = _rowing(make_fishes, library, flaps=False)
    np.testing.assert_allclose(sweeps, np.pi / 3 + np.pi / 4 * np.cos(phase), atol=1e-6)
    down = (phase > 0.0) & (phase < np.pi)
    assert np.mean(lifts[down]) < 0 < np.mean(lifts[phase > np.pi])


def test_a_flapping_fin_beats_up_and_down_across_the_way(make_fishes, library):
    sweeps, lifts, phase, _ = _rowing(make_fishes, library, flaps=True)
    assert np.ptp(sweeps) < 1e-6
    np.testing.assert_allclose(lifts, np.radians(50.0) * np.cos(phase), atol=1e-6)


@pytest.mark.parametrize("flaps", [False, True])
def test_a_rowing_fin_is_broadside_in_its_stroke_and_edge_on_as_it_returns(
    make_fishes, library, flaps
):
    """One that flaps is level: its leading edge is lower on the way down than on the way up."""
    _, _, phase, twists = _rowing(make_fishes, library, flaps)
    there, back = (twists[np.abs(phase - way).argmin()] for way in (np.pi / 2, 1.5 * np.pi))
    if flaps:
        assert back < 0.9 < np.pi / 2 < there
    else:
        assert there < 0.05 and back > 1.0


@pytest.mark.parametrize("flaps", [False, True])
def test_a_rowing_fish_strokes_with_the_outer_fin_and_brakes_with_the_inner(
    make_fishes, library, flaps
):
    """Steering to the left: the left fin stands broadside; to the right it strokes as ever."""
    inner, raised, _, twists = _rowing(make_fishes, library, flaps, steering=0.6)
    assert np.ptp(twists) < 1e-3
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


def _drawn(fishes, library, alpha):
    fins, phase = np.empty(fishes.fins.shape[1], np.float32), np.empty(3, np.float32)
    fins_at(fishes, library, 0, alpha, fins, phase)
    return fins


def test_fins_that_rested_end_where_those_do_that_moved_in_every_tick(make_fishes, library):
    """The phases after eight ticks are the same, and eased fins come as near to their goals."""
    every, late = make_fishes(1), make_fishes(1)
    for fishes in (every, late):
        fishes.goal_speed[:], fishes.steering[:] = 0.3, (0.2, 0.1)
    for tick in range(1, 65):
        flap(everyone(every), every, library, TICK)
        flap_in_turn(everyone(late), late, library, np.array([tick % 8 == 0]), TICK)
        assert late.rested[0] == tick % 8
    np.testing.assert_allclose(late.fin_phase, every.fin_phase, atol=1e-4)
    np.testing.assert_allclose(late.breath, every.breath, atol=1e-4)
    np.testing.assert_allclose(late.fins, every.fins, atol=0.02)


def test_fins_that_are_due_move_as_ever(make_fishes, library):
    every, due = make_fishes(2), make_fishes(2)
    for _ in range(5):
        flap(everyone(every), every, library, TICK)
        flap_in_turn(everyone(due), due, library, np.ones(2, bool), TICK)
    np.testing.assert_array_equal(due.fins, every.fins)
    np.testing.assert_array_equal(due.previous_fins, every.previous_fins)


def test_resting_fins_are_drawn_in_motion_without_a_jump(make_fishes, library):
    """They are drawn as those that move in every tick, and drawing changes nothing."""
    every, late = make_fishes(1), make_fishes(1)
    for fishes in (every, late):
        fishes.goal_speed[:] = 0.3
    before, moved = None, 0.0
    for tick in range(1, 65):
        flap(everyone(every), every, library, TICK)
        flap_in_turn(everyone(late), late, library, np.array([tick % 8 == 0]), TICK)
        state = [array.copy() for array in late]
        for alpha in (0.0, 0.5, 1.0):
            fins = _drawn(late, library, alpha)
            if tick > 16:  # once what is eased has settled
                np.testing.assert_allclose(fins, _drawn(every, library, alpha), atol=0.04)
                moved = max(moved, np.abs(fins - before).max())
                assert np.abs(fins - before).max() < 0.1
            before = fins
        for array, kept in zip(late, state, strict=True):
            np.testing.assert_array_equal(array, kept)
    assert moved > 0.02


def test_the_dead_do_not_rest(make_fishes, library):
    fishes = make_fishes(1)
    fishes.alive[:] = False
    for _ in range(200):
        flap_in_turn(everyone(fishes), fishes, library, np.zeros(1, bool), TICK)
    assert fishes.rested[0] == 0
