"""The nine motor controllers in the water: each does to a swimming fish what its name says."""

import numpy as np
import pytest

from subsea.biomechanics.body import body_frame, build_body
from subsea.biomechanics.controllers import (
    ease,
    glide_contraction,
    swim_contraction,
    turn_contraction,
)
from subsea.biomechanics.fins import ascend, backward, balance, brake, descend, pectoral_force
from subsea.biomechanics.simulation import STILL, BodyState, at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.geometry.rotation import about, matrix

RELAXED = np.zeros((STEPS_PER_TICK, 12))


def medium_beat(species):
    steps = species.swim.ticks_per_beat * STEPS_PER_TICK
    phase = 2 * np.pi * np.arange(steps) / steps
    return swim_contraction(species.swim, phase, species.swim.medium)


@pytest.fixture
def body(species):
    return build_body(species.body)


@pytest.fixture
def area(species):
    return 0.01 * species.body.length**2


@pytest.fixture
def swimming(species, body):
    """Steady swimming at grade medium, at phase 0 of the beat."""
    state, beat = at_rest(body), medium_beat(species)
    simulate(body, state, ease(np.arange(len(beat)) / len(beat))[:, None] * beat)
    simulate(body, state, np.tile(beat, (30, 1)))
    return state


def speed(body, state):
    return float(np.linalg.norm(body.mass @ state.v) / body.mass.sum())


def climb(frames, ticks):
    """Angle in degrees at which the fish rises over the last `ticks`."""
    way = (frames[-1] - frames[-1 - ticks]).mean(axis=0)
    return float(np.degrees(np.arctan2(way[1], np.hypot(way[0], way[2]))))


@pytest.mark.parametrize("angle", [-45, -20, 0, 20, 45])
def test_ascend_and_descend_lead_to_the_angle(species, body, area, swimming, angle):
    frames = []
    for _ in range(40):
        for tick in np.split(medium_beat(species), species.swim.ticks_per_beat):
            if angle < 0:
                fins = descend(swimming, np.radians(-angle))
            else:
                fins = ascend(swimming, np.radians(angle))
            assert all(np.pi / 4 <= fin <= 3 * np.pi / 4 for fin in fins)
            force = pectoral_force(swimming, area, *fins, STILL)
            frames.extend(simulate(body, swimming, tick, force=force))
    assert is_sound(swimming)
    assert climb(np.array(frames), species.swim.ticks_per_beat) == pytest.approx(angle, abs=0.5)


def test_balance_rights_a_rolled_fish_that_would_stay_rolled(species, body, area, swimming):
    def lean(frames):
        return float(np.degrees(np.arcsin(body_frame(frames)[1][:, 1, 2].mean())))

    turn = matrix(about(1.0, 0.0, 0.0, np.radians(25)))
    rolled = BodyState(swimming.x @ turn.T, swimming.v @ turn.T, swimming.watch.copy())
    alone = copy_state(rolled)
    for _ in range(40):
        frames = []
        limp = simulate(body, alone, medium_beat(species))
        for tick in np.split(medium_beat(species), species.swim.ticks_per_beat):
            force = pectoral_force(rolled, area, *balance(rolled), STILL)
            frames.extend(simulate(body, rolled, tick, force=force))
    assert abs(lean(np.array(frames))) < 0.1
    assert abs(lean(limp)) > 20


def test_brakes_stop_a_gliding_fish_sooner(body, area, swimming):
    braking, start = copy_state(swimming), speed(body, swimming)
    for _ in range(45):
        simulate(body, swimming, RELAXED)
        force = pectoral_force(braking, area, *brake(), STILL)
        simulate(body, braking, RELAXED, force=force)
    assert 0.5 * start < speed(body, swimming) < start
    assert 0.1 * start < speed(body, braking) < 0.6 * start
    assert speed(body, braking) < 0.75 * speed(body, swimming)


@pytest.mark.parametrize("retreat", [0.3, 1.0])
def test_backward_reaches_the_speed_of_retreat(body, area, retreat):
    state = at_rest(body)
    rowing = backward(body, area, retreat)
    for _ in range(1000):
        force = pectoral_force(state, area, *brake(), STILL, rowing)
        simulate(body, state, RELAXED, force=force)
    assert body.mass @ state.v[:, 0] / body.mass.sum() == pytest.approx(-retreat, rel=0.02)
    assert is_sound(state)


def test_a_fish_in_a_current_brakes_against_the_water(body, area):
    """Fins and hull alike feel only what the water does relative to them."""
    current = np.array([-0.8, 0.0, 0.0])
    held = at_rest(body)
    for _ in range(1500):
        simulate(body, held, RELAXED, current, pectoral_force(held, area, *brake(), current))
    carried = body.mass @ held.v / body.mass.sum()
    np.testing.assert_allclose(carried, current, atol=0.05)


def test_gliding_relaxes_every_muscle_smoothly_in_the_time_given(species, body, swimming):
    contraction = medium_beat(species)[0]
    relaxing = glide_contraction(contraction, 60)
    assert not relaxing[-1].any()
    assert (np.diff(relaxing, axis=0) <= 1e-15).all()
    np.testing.assert_allclose(relaxing[0], contraction, atol=0.01)
    start = speed(body, swimming)
    simulate(body, swimming, relaxing)
    simulate(body, swimming, np.zeros((600, 12)))
    lengths = np.linalg.norm(swimming.x[1:5] - swimming.x[5:9], axis=1)
    np.testing.assert_allclose(lengths, body.length[:4], rtol=0.01)
    assert 0.3 * start < speed(body, swimming) < start


@pytest.mark.parametrize(("angle", "allowed"), [(45, 3), (-45, 3), (135, 7), (180, 9), (-180, 9)])
def test_turns_lead_to_their_angle_and_wider_ones_are_composed(
    species, body, swimming, angle, allowed
):
    beat, ticks = medium_beat(species), species.swim.ticks_per_beat
    phase = 0.0
    if angle < 0:  # a right turn is entered half a beat later
        half = STEPS_PER_TICK * (ticks // 2)
        phase = 2 * np.pi * half / len(beat)
        simulate(body, swimming, beat[:half])
        beat = np.roll(beat, -half, axis=0)

    def heading(frames):
        forward = body_frame(frames)[1][:, :, 0]
        return float(np.degrees(np.unwrap(np.arctan2(-forward[:, 2], forward[:, 0]))).mean())

    before = heading(simulate(body, copy_state(swimming), beat))
    turning = turn_contraction(species.swim, species.turn, angle, phase)
    assert len(turning) % len(beat) == 0
    simulate(body, swimming, turning)
    after = heading(simulate(body, swimming, np.tile(beat, (6, 1)))[-ticks:])
    turned = (after - before - angle + 180) % 360 - 180
    assert is_sound(swimming)
    assert abs(turned) <= allowed


def test_a_wide_turn_is_a_sequence_of_equal_lesser_ones(species):
    whole = turn_contraction(species.swim, species.turn, 150.0)
    half = turn_contraction(species.swim, species.turn, 75.0)
    np.testing.assert_array_equal(whole, np.tile(half, (2, 1)))
    np.testing.assert_array_equal(
        turn_contraction(species.swim, species.turn, -60.0, np.pi)[:, [1, 0, 3, 2]],
        turn_contraction(species.swim, species.turn, 60.0, 0.0)[:, :4],
    )
