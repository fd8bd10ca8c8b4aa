"""The day: hours, daylight, and the sky of a world."""

import numpy as np
import pytest
from msgspec.structs import replace

from subsea.habitat.day import daylight_at, hour_at
from subsea.scenario.load import load_scenario
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import STATION, step
from subsea.world.world import TICK_S


def test_the_clock_stands_still_or_passes_a_day_in_its_minutes():
    assert hour_at(9.5, 0.0, 1e6) == 9.5
    assert hour_at(24.0, 0.0, 0.0) == 0.0
    assert hour_at(18.0, 12.0, 180.0) == pytest.approx(0.0)  # a quarter of a day of 12 minutes
    assert hour_at(6.0, 12.0, 7200.0) == pytest.approx(6.0)  # ten days later


def test_daylight_rises_from_night_to_noon_and_falls_evenly_and_smoothly():
    hours = np.linspace(0.0, 24.0, 2401)
    light = np.array([daylight_at(hour) for hour in hours])
    assert light[0] == light[-1] == 0.0
    assert daylight_at(12.0) == 1.0
    np.testing.assert_allclose(light, light[::-1], atol=1e-12)
    morning = light[:1201]
    assert (np.diff(morning) >= 0.0).all()
    assert np.abs(np.diff(light)).max() < 0.01  # in 36 s of the day
    assert 0.1 < daylight_at(6.0) < 0.35  # twilight
    assert daylight_at(4.5) == 0.0


def world_at(hour, day_minutes):
    scenario = load_scenario("peaceful")[0]
    water = replace(scenario.water, hour=hour, day_minutes=day_minutes)
    return create_world(replace(scenario, water=water), fish=6)


def test_the_sky_of_a_world_follows_its_clock_and_returns_with_a_snapshot():
    world = world_at(24.0, 1.0)
    assert world.state.sea.sky.tolist() == [0.0, 0.0]
    for _ in range(40):
        step(world, STATION)
    then, sky = snapshot.take(world), world.state.sea.sky.copy()
    assert sky[0] == pytest.approx(24.0 * 39 * TICK_S / 60.0)
    for _ in range(40):
        step(world, STATION)
    assert world.state.sea.sky[0] > sky[0]
    snapshot.restore(world, then)
    np.testing.assert_array_equal(world.state.sea.sky, sky)


def test_a_clock_that_stands_still_keeps_the_hour_of_the_scenario():
    world = world_at(9.0, 0.0)
    for _ in range(3):
        step(world, STATION)
    assert world.state.sea.sky.tolist() == [9.0, daylight_at(9.0)]
