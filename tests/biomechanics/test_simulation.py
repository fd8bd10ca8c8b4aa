import numpy as np
import pytest

from subsea.biomechanics.body import MUSCLES, build_body
from subsea.biomechanics.controllers import LEFT, RIGHT, bend_contraction, ease, swim_contraction
from subsea.biomechanics.manoeuvres import MIRROR
from subsea.biomechanics.simulation import at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK


def swim(species, beats, amplitude, start=0.0, side=None):
    body = build_body(species.body)
    per_beat = species.swim.ticks_per_beat * STEPS_PER_TICK
    beat = np.arange(beats * per_beat) / per_beat
    contraction = swim_contraction(species.swim, start + 2 * np.pi * beat, amplitude * ease(beat))
    if side is not None:
        contraction = contraction + bend_contraction(species.turn.gradual, side, ease(beat))
    state = at_rest(body)
    return simulate(body, state, contraction), state


def test_a_fish_at_rest_stays_at_rest(species):
    body = build_body(species.body)
    state = at_rest(body)
    frames = simulate(body, state, np.zeros((60, MUSCLES)))
    np.testing.assert_allclose(frames, np.tile(body.rest, (10, 1, 1)), atol=1e-12)
    assert is_sound(state)


def test_a_bent_body_comes_back_to_its_shape(fusilier):
    body = build_body(fusilier.body)
    state = at_rest(body)
    bent = bend_contraction((0.2, 0.2), LEFT)
    simulate(body, state, np.tile(bent, (300, 1)))
    frames = simulate(body, state, np.zeros((3000, MUSCLES)))
    distance = np.linalg.norm(frames[-1][:, None] - frames[-1][None], axis=2)
    rest = np.linalg.norm(body.rest[:, None] - body.rest[None], axis=2)
    np.testing.assert_allclose(distance, rest, atol=0.03 * fusilier.body.length)


def test_faster_with_every_step_of_amplitude_and_always_in_shape(species):
    speeds = []
    for amplitude in (0.25, 0.5, 0.75, 1.0):
        frames, state = swim(species, 30, amplitude)
        assert is_sound(state)
        speeds.append(
            np.linalg.norm((frames[-1] - frames[-1 - species.swim.ticks_per_beat]).mean(0))
        )
    assert (np.diff(speeds) > 0).all()
    assert speeds[-1] > 0.35 * species.body.length


def test_a_fish_swims_straight_level_and_upright(species):
    frames, _ = swim(species, 50, 1.0)
    centres = frames[:: species.swim.ticks_per_beat].mean(axis=1)[-21:]
    first, last = np.diff(centres, axis=0)[[0, -1]]
    assert np.degrees(np.arccos(first @ last / np.linalg.norm(first) / np.linalg.norm(last))) < 1
    assert abs(centres[-1, 1]) < 1e-6
    assert (frames[:, 21, 1] > frames[:, 22, 1]).all()


def test_a_right_turn_is_the_mirror_of_a_left_one(species):
    left, _ = swim(species, 12, 0.6, side=LEFT)
    right, _ = swim(species, 12, 0.6, start=np.pi, side=RIGHT)
    np.testing.assert_allclose(right[:, MIRROR] * (1, 1, -1), left, atol=1e-6)
    assert left[-1, 0, 2] - left[-1, 21, 2] < right[-1, 0, 2] - right[-1, 21, 2]


def test_a_copied_state_has_a_future_of_its_own(fusilier):
    body = build_body(fusilier.body)
    state = at_rest(body)
    other = copy_state(state)
    simulate(body, other, np.tile(bend_contraction((0.2, 0.2), LEFT), (12, 1)))
    np.testing.assert_array_equal(state.x, body.rest)
    assert not np.array_equal(other.x, body.rest)


def test_an_overstrained_body_is_not_sound(fusilier):
    body = build_body(fusilier.body)
    state = at_rest(body)
    simulate(body, state, np.tile(bend_contraction((0.6, 0.6), LEFT), (600, 1)))
    assert np.isfinite(state.x).all()
    assert not is_sound(state)


def test_incomplete_ticks_and_missing_muscles_are_refused(fusilier):
    body = build_body(fusilier.body)
    for shape in ((5, MUSCLES), (6, 11), (0,)):
        with pytest.raises(ValueError, match="contraction"):
            simulate(body, at_rest(body), np.zeros(shape))
