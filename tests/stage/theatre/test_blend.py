"""Blending: at every place of a screen the light of all projectors together is the same."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.theatre.channels import Projector, blend_mask, light_shares, overlap_count
from subsea.stage.theatre.screens import places_on, points_on, screen_of
from subsea.stage.theatre.theatre_file import Cylinder, Plane


def curved(left, right, bottom=-100.0, top=100.0):
    table = Cylinder(radius_cm=275, left_deg=left, right_deg=right, bottom_cm=bottom, top_cm=top)
    return screen_of(table, np.zeros(3), 1.0)


def wall(left, right, bottom, top):
    table = Plane(lower_left=(left, bottom, 200), lower_right=(right, bottom, 200),
                  upper_left=(left, top, 200))  # fmt: skip
    return screen_of(table, np.zeros(3), 1.0)


ROW = [curved(-57, -16), curved(-20, 20), curved(16, 57)]
FOUR = [wall(-200, 20, -150, 10), wall(-20, 200, -150, 10), wall(-200, 20, -10, 150),
        wall(-20, 200, -10, 150)]  # fmt: skip
TURNED = [  # walls that stand at an angle, each reaching a little behind the other
    wall(-200, 30, -100, 100),
    screen_of(Plane(lower_left=(-20, -100, 215), lower_right=(190, -100, 120),
                    upper_left=(-20, 100, 215)), np.zeros(3), 1.0),
]  # fmt: skip
THEATRES = {"row": ROW, "four": FOUR, "turned": TURNED}


def lamps(screens, black=0.0, gamma=2.2):
    return [Projector(screen, gamma, black) for screen in screens]


@pytest.mark.parametrize("name", THEATRES)
@given(s=st.floats(0, 1), t=st.floats(0, 1), number=st.integers(0, 3))
def test_shares_of_all_projectors_add_up_to_one(name, s, t, number):
    projectors = lamps(THEATRES[name])
    number %= len(projectors)
    point = points_on(projectors[number].screen, np.array([[s, t]]))
    total = 0.0
    for k, one in enumerate(projectors):
        place = places_on(one.screen, point)
        if np.isfinite(place).all() and (np.abs(place - 0.5) <= 0.5 + 1e-9).all():
            total += light_shares(projectors, k, place)[0]
    assert total == pytest.approx(1.0, abs=1e-6)


def test_the_light_changes_smoothly_across_an_overlap():
    projectors = lamps(ROW)
    s = np.linspace(0.8, 1.0, 400)
    share = light_shares(projectors, 0, np.column_stack([s, np.full_like(s, 0.5)]))
    assert share[0] == 1.0
    assert share[-1] == pytest.approx(0.0, abs=1e-5)
    assert (np.diff(share) <= 1e-12).all()
    assert np.abs(np.diff(share)).max() < 0.05
    assert np.abs(np.diff(share, 2)).max() < 0.002  # no edge that an eye could find


@pytest.mark.parametrize("gamma", [1.0, 2.2, 2.6])
@pytest.mark.parametrize("level", [1.0, 0.6, 0.2])
def test_luminance_is_the_same_all_over_within_two_percent(gamma, level):
    """Values that go to the projectors, raised to their gamma and added up on the screen."""
    projectors = lamps(ROW, gamma=gamma)
    angle = np.linspace(-56.9, 56.9, 3000)
    light = np.zeros_like(angle)
    for k, one in enumerate(projectors):
        s = (np.radians(angle) - one.screen.left) / (one.screen.right - one.screen.left)
        inside = (s >= 0) & (s <= 1)
        places = np.column_stack([s[inside], np.full(inside.sum(), 0.4)])
        mask = blend_mask(projectors, k, places)
        light[inside] += (level * mask[:, 0] + mask[:, 3]) ** gamma
    np.testing.assert_allclose(light, level**gamma, rtol=0.02)


def test_black_is_as_bright_where_one_projector_shines_as_where_two_do():
    black, gamma = 0.004, 2.2
    projectors = lamps(ROW, black, gamma)
    for white in (0.0, 1.0):
        found = []
        for angle in (0.0, 18.0, -40.0):  # one, two, one
            light = 0.0
            for k, one in enumerate(projectors):
                s = (np.radians(angle) - one.screen.left) / (one.screen.right - one.screen.left)
                if 0 <= s <= 1:
                    mask = blend_mask(projectors, k, np.array([[s, 0.5]]))[0]
                    light += (white * mask[0] + mask[3]) ** gamma + black
            found.append(light)
        np.testing.assert_allclose(found, found[0], rtol=0.02, atol=1e-5)
    assert overlap_count(projectors, 1, np.array([[0.5, 0.5], [0.01, 0.5]])).tolist() == [1, 2]
