"""Pectoral fins and breath."""

import numpy as np

from subsea.motor.fins import flap

TICK = 0.033


def _minute(make_fishes, steering, speed):
    """Sweeps (T, 2) and mouth (T,) of a fish over a minute."""
    fishes = make_fishes(1)
    fishes.steering[:] = steering
    fishes.goal_speed[:] = speed
    sweeps, mouth = [], []
    for _ in range(1800):
        flap(fishes, TICK)
        sweeps.append(fishes.pectoral[0].copy())
        mouth.append(float(fishes.mouth[0]))
    return np.array(sweeps), np.array(mouth)


def _beats(signal):
    """Upward crossings of the mean."""
    centred = signal - signal.mean()
    return int(((centred[1:] > 0) & (centred[:-1] <= 0)).sum())


def test_fins_never_rest_and_beat_wider_and_faster_with_effort(make_fishes):
    calm, _ = _minute(make_fishes, (0.0, 0.0), 0.9)
    climbing, _ = _minute(make_fishes, (0.0, 0.5), 0.9)
    assert np.ptp(calm[:, 0]) > 0.2
    assert np.ptp(climbing[:, 0]) > 1.5 * np.ptp(calm[:, 0])
    assert _beats(climbing[:, 0]) > 1.5 * _beats(calm[:, 0])


def test_a_fast_fish_folds_its_fins_and_a_hovering_one_sculls(make_fishes):
    fast, _ = _minute(make_fishes, (0.0, 0.0), 1.0)
    hovering, _ = _minute(make_fishes, (0.0, 0.0), 0.0)
    assert fast.mean() < hovering.mean() - 0.2
    assert _beats(hovering[:, 0]) > 2 * _beats(fast[:, 0])


def test_in_a_turn_one_fin_leads(make_fishes):
    left, _ = _minute(make_fishes, (0.4, 0.0), 0.6)
    right, _ = _minute(make_fishes, (-0.4, 0.0), 0.6)
    np.testing.assert_allclose(
        left.mean(axis=0) - left.mean(), -(right.mean(axis=0) - right.mean()), atol=0.02
    )
    assert left[:, 0].mean() > left[:, 1].mean() + 0.2


def test_breath_is_regular_and_quickens_with_speed(make_fishes):
    _, calm = _minute(make_fishes, (0.0, 0.0), 0.0)
    _, hurried = _minute(make_fishes, (0.0, 0.0), 1.0)
    assert 0 <= calm.min() < calm.max() <= 1
    assert _beats(hurried) > 1.7 * _beats(calm) > 60
