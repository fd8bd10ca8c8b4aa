"""Blending: at every place of a screen the light of all projectors together is the same."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.theatre.channels import Projector, blend_mask, light_shares, overlap_count
from subsea.stage.theatre.screens import places_on, points_on, screen_of
from subsea.stage.theatre.theatre_file import Cylinder, Plane
from subsea.stage.theatre.warp import rasterized
from tests.support.daily import only


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


@pytest.mark.parametrize("widths", [(0.5, 0.5, 0.5), (2.0, 2.0, 2.0), (0.3, 1.0, 1.7)])
def test_fades_of_any_width_add_up_and_a_width_of_half_halves_the_fade(widths):
    projectors = [one._replace(width=width) for one, width in zip(lamps(ROW), widths, strict=True)]
    s = np.linspace(0.0, 1.0, 2001)
    places = np.column_stack([s, np.full_like(s, 0.5)])
    total = light_shares(projectors, 0, places)
    points = points_on(ROW[0], places)
    there = places_on(ROW[1], points)
    seen = (there[:, 0] >= 0.0) & (there[:, 0] <= 1.0)
    total[seen] += light_shares(projectors, 1, there[seen])
    np.testing.assert_allclose(total, 1.0, atol=1e-6)

    def span(factor):
        share = light_shares([one._replace(width=factor) for one in lamps(ROW)], 0, places)
        return np.interp(-0.1, -share[s > 0.8], s[s > 0.8]) - np.interp(
            -0.9, -share[s > 0.8], s[s > 0.8]
        )

    assert span(0.5) == pytest.approx(span(1.0) / 2.0, rel=0.12)


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
        light[inside] += (level * mask[:, 0]) ** gamma + mask[:, 3]
    np.testing.assert_allclose(light, level**gamma, rtol=0.02)


@pytest.mark.parametrize("level", [0.0, 0.05, 0.2, 0.5, 1.0])
@pytest.mark.parametrize("black", [0.004, 0.05])
def test_a_raised_black_is_the_same_light_in_and_outside_of_overlaps(level, black):
    """Black is added to light, so grey is right as well as black and white."""
    gamma = 2.2
    projectors = lamps(ROW, black, gamma)
    found = []
    for angle in (0.0, 18.0, -40.0):  # one, two, one
        light = 0.0
        for k, one in enumerate(projectors):
            s = (np.radians(angle) - one.screen.left) / (one.screen.right - one.screen.left)
            if 0 <= s <= 1:
                factor, _, _, added = blend_mask(projectors, k, np.array([[s, 0.5]]))[0]
                assert factor**gamma + added <= 1.0 + 1e-12  # a projector gives no more
                light += (level * factor) ** gamma + added + black
        found.append(light)
    np.testing.assert_allclose(found, level**gamma * (1.0 - black) + 2.0 * black, rtol=1e-9)


def test_overlaps_are_counted():
    assert overlap_count(lamps(ROW), 1, np.array([[0.5, 0.5], [0.01, 0.5]])).tolist() == [1, 2]


def sampled(mask, size):
    """The factors (h, w) of a mask at the pixels of a projector, as a shader samples them."""
    at = []
    for count, length in zip(mask.shape[:2], size[::-1], strict=True):
        place = np.clip((np.arange(length) + 0.5) / length * count - 0.5, 0.0, count - 1.0)
        lower = np.minimum(place.astype(int), count - 2)
        at.append((lower, place - lower))
    (row, down), (column, across) = at
    values = mask[..., 0].astype(np.float64)
    values = values[row] * (1 - down[:, None]) + values[row + 1] * down[:, None]
    return values[:, column] * (1 - across) + values[:, column + 1] * across


@pytest.mark.parametrize("kind", only(["wall", "dome"], ["wall", "curved", "dome"]))
def test_every_blended_edge_of_a_planned_theatre_falls_to_black(planned_channels, kind):
    """Outside of a mesh a coarse mask continues, as pixels at its edge are mixed with that."""
    size = 320, 240  # a mask of 80×60
    channels = planned_channels(kind, size)
    projectors = [
        Projector(one.screen, one.adjustment.gamma, one.adjustment.black) for one in channels
    ]
    for number, one in enumerate(channels):
        x, y = (np.arange(n) + 0.5 for n in size)
        places = np.stack(np.meshgrid(x / size[0], 1 - y / size[1]), axis=-1)
        lit = np.ones(size[::-1], bool)
        if one.warp is not None:
            shown = one.warp.vertices[:, 2:4].T.astype(np.float64)
            places = np.stack([rasterized(one.warp, part, size) for part in shown], axis=-1)
            lit = rasterized(one.warp, np.ones(len(one.warp.vertices)), size) > 0
        meant = blend_mask(projectors, number, places[lit])[:, 0]
        seen = sampled(one.mask, size)
        assert np.abs(seen[lit] - meant).max() < 0.08
        exact = np.zeros(size[::-1])
        exact[lit] = meant
        for row in range(0, size[1], 5):
            columns = np.flatnonzero(lit[row])
            for edge in (columns[-10:], columns[:10][::-1]):
                if len(edge) == 10 and exact[row, edge[-1]] < 0.1 < exact[row, edge[0]]:
                    assert (np.diff(seen[row, edge]) < 1e-3).all()
                    assert seen[row, edge[-1]] < 0.1
