"""The map of the sand around stones: dark beneath, bright far away, littered beside."""

import numpy as np

from subsea.habitat.formations import formations
from subsea.habitat.stone import SUN
from subsea.rendering.sea.ground_map import MOST_TEXELS, ground_map, with_growths

NO_PILLARS, NO_ROCKS = np.zeros((0, 4)), np.zeros((0, 7))
ROCK = np.array([[30.0, -20.0, -570.0, 70.0, 60.0, 60.0, 0.5]])


def floor(x, y):
    return -600.0 + 0.0 * x


def at(ground, x, y):
    rows, columns = ground.light.shape[:2]
    column, row = ((np.array([x, y]) - ground.corner) / ground.size * (columns, rows)).astype(int)
    return ground.light[row, column].astype(float) / 255.0


def test_far_from_all_stone_the_light_is_whole():
    ground = ground_map(formations(NO_PILLARS, ROCK), floor)
    rim = np.concatenate([ground.light[[0, -1]].reshape(-1, 4), ground.light[:, 0]])
    np.testing.assert_array_equal(rim[:, :3], np.broadcast_to([255, 255, 0], (len(rim), 3)))
    nothing = ground_map([], floor)
    np.testing.assert_array_equal(nothing.light[0, 0, :3], [255, 255, 0])


def test_beside_a_stone_it_is_darker_and_littered_most_so_away_from_the_sun():
    ground = ground_map(formations(NO_PILLARS, ROCK), floor)
    way = np.array(SUN[:2]) / np.hypot(*SUN[:2])
    lit, shaded = (at(ground, *(ROCK[0, :2] + sign * 72.0 * way)) for sign in (1.0, -1.0))
    assert shaded[0] < lit[0] - 0.2
    assert max(lit[1], shaded[1]) < 0.85
    around = [at(ground, 30 + 78 * np.cos(t), -20 + 78 * np.sin(t))[2] for t in np.arange(16.0)]
    assert np.mean(around) > 0.3
    far = [at(ground, 30 + 200 * np.cos(t), -20 + 200 * np.sin(t))[2] for t in np.arange(16.0)]
    assert np.mean(far) < 0.5 * np.mean(around)


def test_what_hangs_high_above_has_its_shadow_aside():
    roof = ROCK + [0, 0, 250.0, 0, 0, 0, 0]
    ground = ground_map(formations(NO_PILLARS, roof), floor)
    shift = 280.0 / SUN[2] * np.array(SUN[:2])
    assert at(ground, *(roof[0, :2] - shift))[0] < 0.3
    assert at(ground, *(roof[0, :2] + 1.2 * shift))[0] > 0.9


def test_the_map_of_a_wide_sea_is_no_larger_than_allowed():
    rocks = np.concatenate([ROCK, ROCK + [15000.0, 9000.0, 0, 0, 0, 0, 0]])
    ground = ground_map(formations(NO_PILLARS, rocks), floor)
    assert max(ground.light.shape) <= MOST_TEXELS + 1
    # The shade is still at its place.
    assert at(ground, 30.0, -20.0)[1] < 0.6
    assert at(ground, 15030.0, 8980.0)[1] < 0.6


def test_a_growth_darkens_the_sand_at_its_foot_and_away_from_the_sun():
    growths = np.array([[50.0, -40.0, 20.0, 30.0, 0.9]])
    bare = ground_map([], floor, SUN, growths)
    assert (bare.light[..., :2] == 255).all()
    ground = bare._replace(light=with_growths(bare, growths, SUN)[0])
    way = np.array(SUN[:2]) / np.hypot(*SUN[:2])
    middle = growths[0, :2]
    foot, near, far = (at(ground, *(middle + r * way))[1] for r in (19.0, 30.0, 90.0))
    assert foot < 0.4 < near < 0.95 < far
    sunny, shaded = (at(ground, *(middle + sign * 26.0 * way))[0] for sign in (1.0, -1.0))
    assert shaded < 0.6 < 0.9 < sunny
    assert (ground.light[..., 2] == bare.light[..., 2]).all()  # no rubble
