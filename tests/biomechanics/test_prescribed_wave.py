"""The elongated-body theory on prescribed waves."""

import numpy as np
import pytest

from subsea.biomechanics import prescribed_wave
from subsea.biomechanics.prescribed_wave import (
    CROSS_DRAG,
    DENSITY,
    SKIN_DRAG,
    Strips,
    follow,
    force_and_shed,
    start_momentum,
    steady_beat,
    swim,
    trailing,
)

LENGTH, TALL, PERIOD = 50.0, 6.0, 0.5


def ribbon(amplitude, times=192, sections=60, wave=0.9, grow=1.0):
    """A ribbon with the wave h = A(x) sin 2π(t - x/λ) aside; times of a beat and its end."""
    at = (np.arange(sections) + 0.5) / sections
    t = np.linspace(0.0, 1.0, times + 1)[:, None]
    phase, rise = 2 * np.pi * (t - at / wave), amplitude * (1 - grow + grow * at**2)
    aside = rise * np.sin(phase)
    slope = 2 * grow * amplitude * at * np.sin(phase) - 2 * np.pi / wave * rise * np.cos(phase)
    place = np.zeros((times + 1, 1, sections, 3))
    place[:, 0, :, 0], place[:, 0, :, 1] = LENGTH * (0.5 - at), LENGTH * aside
    speed = np.zeros_like(place)
    speed[:, 0, :, 1] = LENGTH * 2 * np.pi / PERIOD * rise * np.cos(phase)
    tangent = np.zeros_like(place)
    tangent[:, 0, :, 0], tangent[:, 0, :, 1] = 1.0, -slope
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    normal = np.stack([-tangent[..., 1], tangent[..., 0], tangent[..., 2]], axis=-1)
    ds = LENGTH / sections
    added = 0.25 * np.pi * DENSITY * TALL**2 * np.minimum(4 * at[None], 1.0)  # grows from the snout
    area = np.full((1, sections), TALL * ds)
    mass = np.full((1, sections), 0.3 * TALL**2 * ds)
    return Strips(place, speed, tangent, normal, mass, added * ds, trailing(added), area, 2 * area)


def held(parts, speed):
    """Force (T, 3) on a fish that is held at a speed, without drag, and power of its wave (T,)."""
    step = PERIOD / (len(parts.place) - 1)
    velocity = parts.speed + (speed, 0.0, 0.0)
    w = np.einsum("tkjc,tkjc->tkj", velocity, parts.normal)[..., None]
    water = parts.added[..., None] * w * parts.normal
    rows = zip(parts.tangent, parts.normal, velocity, strict=True)
    shed = np.array([force_and_shed(parts, *row)[1] for row in rows])
    rate = (np.roll(water[:-1], -1, 0) - np.roll(water[:-1], 1, 0)) / (2 * step)
    passing = np.einsum("tkjc,tkjc->tkj", velocity, parts.tangent)[..., None]
    flux = passing * w * parts.normal - 0.5 * w**2 * parts.tangent  # per added mass
    ds = LENGTH / parts.mass.shape[1]
    flux = flux * parts.added[..., None] / ds
    between = 0.5 * (flux[:, :, 1:] + flux[:, :, :-1])
    into = np.concatenate([np.zeros_like(between[:, :, :1]), between], axis=2)
    out = np.concatenate([between, shed[:, :, -1:]], axis=2)
    slabs = -rate + (into - out)[:-1]
    power = -np.einsum("tkjc,tkjc->t", slabs, parts.speed[:-1])
    return slabs.sum(axis=(1, 2)), power


def test_small_waves_thrust_as_lighthill_found():
    """T = ½ m (<h_t²> - U² <h_x²>), P = m U <h_t (h_t + U h_x)> at the tail (Lighthill 1960)."""
    amplitude, wave = 0.004, 0.9
    for speed in (30.0, 60.0):
        force, power = held(ribbon(amplitude, grow=0.0, wave=wave), speed)
        m = 0.25 * np.pi * DENSITY * TALL**2
        rate = LENGTH * amplitude * 2 * np.pi / PERIOD
        slip = speed * PERIOD / (wave * LENGTH)
        thrust = 0.25 * m * rate**2 * (1 - slip**2)
        assert force[:, 0].mean() == pytest.approx(thrust, rel=0.005)
        assert power.mean() == pytest.approx(0.5 * m * speed * rate**2 * (1 - slip), rel=0.02)
        efficiency = force[:, 0].mean() * speed / power.mean()
        assert efficiency == pytest.approx(0.5 * (1 + slip), rel=0.02)


def test_force_does_not_depend_on_the_axes():
    parts, rng = ribbon(0.1), np.random.default_rng(1)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    velocity = parts.speed[7] + rng.normal(size=3) * 20
    there = [one @ rotation.T for one in (parts.tangent[7], parts.normal[7], velocity)]
    seen = force_and_shed(parts, parts.tangent[7], parts.normal[7], velocity)
    for a, b in zip(seen, force_and_shed(parts, *there), strict=True):
        np.testing.assert_allclose(a @ rotation.T, b, atol=1e-9 * np.abs(a).max())


def test_body_water_and_wake_keep_their_momentum(monkeypatch):
    """Without drag: measured from the track in the world, with what was shed on the way."""
    monkeypatch.setattr(prescribed_wave, "CROSS_DRAG", 0.0)
    monkeypatch.setattr(prescribed_wave, "SKIN_DRAG", 0.0)
    parts = ribbon(0.08, times=800)
    step = PERIOD / 800
    track = swim(parts, step, start_momentum(parts, np.array([40.0, 3.0, 0.4])))
    way = follow(track.velocity, 2 * step)
    c, s = np.cos(way[:, 2]), np.sin(way[:, 2])
    turn = np.moveaxis(np.array([[c, -s, 0 * c], [s, c, 0 * c], [0 * c, 0 * c, 1 + 0 * c]]), -1, 0)
    place, tangent, normal = (
        np.einsum("tab,tkjb->tkja", turn, getattr(parts, name)[::2])
        for name in ("place", "tangent", "normal")
    )
    place = place + (way * (1, 1, 0))[:, None, None]
    velocity = np.gradient(place, 2 * step, axis=0)
    w = np.einsum("tkjc,tkjc->tkj", velocity, normal)[..., None]
    momentum = parts.mass[..., None] * velocity + parts.added[..., None] * w * normal
    rows = zip(tangent, normal, velocity, strict=True)
    shed = np.array([force_and_shed(parts, *row)[1] for row in rows])
    for now, lost in ((momentum, shed), (np.cross(place, momentum), np.cross(place, shed))):
        now, lost = now.sum(axis=(1, 2)), lost.sum(axis=(1, 2))
        wake = np.concatenate([np.zeros((1, 3)), np.cumsum(step * (lost[1:] + lost[:-1]), axis=0)])
        total = (now + wake)[1:-1]
        change = np.ptp(now[1:-1], axis=0).max()
        assert np.ptp(total, axis=0).max() < 0.01 * change


def test_a_straight_body_glides_as_its_drag_says():
    """1/U grows by ½ ρ S C t / m."""
    parts = ribbon(0.0)
    track = swim(parts, 0.01, start_momentum(parts, np.array([80.0, 0.0, 0.0])))
    loss = 0.5 * DENSITY * SKIN_DRAG * parts.skin.sum() / parts.mass.sum()
    end = 1 / (1 / 80.0 + loss * 0.01 * 192)
    assert track.velocity[-1, 0] == pytest.approx(end, rel=1e-9)


def test_a_body_that_slides_sideways_carries_its_water():
    parts = ribbon(0.0)
    heavy = parts.mass.sum() + parts.added.sum()
    momentum = start_momentum(parts, np.array([0.0, 5.0, 0.0]))
    np.testing.assert_allclose(momentum[:2], (0.0, 5.0 * heavy), atol=1e-6)
    track = swim(parts, 0.001, momentum)
    loss = 0.5 * DENSITY * CROSS_DRAG * parts.across.sum() / heavy
    # The slower front turns the body, and the tail sheds little as long as nothing flows along it.
    assert track.velocity[1, 1] == pytest.approx(1 / (1 / 5.0 + loss * 0.002), rel=1e-3)


@pytest.mark.nightly
def test_a_steady_beat_repeats_and_its_step_hardly_matters():
    fine, coarse = (steady_beat(ribbon(0.1, times=times), PERIOD, 20.0) for times in (384, 96))
    assert coarse.stride == pytest.approx(fine.stride, rel=1e-4)
    parts = ribbon(0.1, times=384)
    again = swim(parts, PERIOD / 384, fine.track.momentum[-1])
    np.testing.assert_allclose(again.velocity, fine.track.velocity, atol=1e-4)
    assert np.abs(fine.recoil[:-1, :2].mean(axis=0)).max() < 1e-9
    assert 0.6 < fine.stride / (0.9 * LENGTH) < 0.8  # as eels do (Tytell 2004)


def test_speed_is_proportional_to_frequency():
    parts = ribbon(0.1, times=96)
    twice = parts._replace(speed=2 * parts.speed)
    one, other = steady_beat(parts, PERIOD, 20.0), steady_beat(twice, PERIOD / 2, 40.0)
    assert other.stride == pytest.approx(one.stride, rel=1e-5)
