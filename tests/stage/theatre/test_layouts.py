"""Planned theatres cover their screens, with the wanted overlap, for any sensible measures."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.stage.theatre.channels import Projector, light_shares, overlap_count
from subsea.stage.theatre.layouts import HOUSING_CM, front_channel, layout
from subsea.stage.theatre.lenses import nodes_text
from subsea.stage.theatre.measures import chosen
from subsea.stage.theatre.mesh_formats import parse_bourke
from subsea.stage.theatre.screens import frustum_of, places_on, points_on, screen_of
from subsea.stage.theatre.warp import mesh
from subsea.view.rig import sources_at
from tests.support.daily import examples

FEW = settings(  # smaller examples are not clearer, and take minutes to find
    max_examples=examples(5), suppress_health_check=[HealthCheck.filter_too_much],
    phases=(Phase.explicit, Phase.reuse, Phase.generate),
)  # fmt: skip
SHARES = np.stack(np.meshgrid([0.0, 0.31, 0.5, 0.83, 1.0], [0.0, 0.4, 1.0]), axis=-1).reshape(-1, 2)
share = st.floats(0.0, 1.0)
percent = st.floats(2, 40)


def planned(kind, **measures):
    """The layout and its screens; the example is rejected if it is impossible."""
    try:
        made = layout(kind, chosen(kind, measures))
    except UserError:
        assume(False)
    return made, [screen_of(one.screen, np.zeros(3), 1.0) for one in made.channels]


def check_light(screens, points):
    """Each point is lit, and the shares of its light add up to one."""
    lamps = [Projector(screen, 2.2, 0.0) for screen in screens]
    total = np.zeros(len(points))
    for number, screen in enumerate(screens):
        places = places_on(screen, points)
        with np.errstate(invalid="ignore"):
            lit = ((places > -1e-6) & (places < 1.0 + 1e-6)).all(axis=1)
        if lit.any():
            total[lit] += light_shares(lamps, number, places[lit])
    np.testing.assert_allclose(total, 1.0, atol=1e-6)


def check_frusta(screens):
    for screen in screens:
        left, right, bottom, top = frustum_of(screen, np.zeros(3), points_on(screen, SHARES)).edges
        assert 1e-4 < right - left < 20.0
        assert 1e-4 < top - bottom < 20.0


def check_mesh(one, screen):
    """The projector's own picture holds all of its screen, at the place where its light goes."""
    warp = parse_bourke(nodes_text(one.nodes).encode(), (1920, 1080), "test").warp
    shown = warp.vertices[:, 2:4]
    inverse = mesh(shown, warp.vertices[:, :2], warp.triangles)
    inner = 0.001 + 0.998 * SHARES
    places = sources_at(inverse, inner)
    assert not np.isnan(places).any()
    assert places.min() > -1e-6
    assert places.max() < 1.0 + 1e-6


@FEW
@given(n=st.integers(1, 32), overlap=percent, width=st.floats(100, 5000),
       distance=st.floats(100, 5000), s=share, t=share)  # fmt: skip
def test_a_wall_is_covered(n, overlap, width, distance, s, t):
    made, screens = planned("wall", projectors=n, overlap=overlap, width=width, distance=distance,
                            bottom=0)  # fmt: skip
    first, last = made.channels[0].screen, made.channels[-1].screen
    assert last.lower_right[0] - first.lower_left[0] == pytest.approx(width)
    low, high = first.lower_left[1], first.upper_left[1]
    x, y = first.lower_left[0] + s * width, low + t * (high - low)
    check_light(screens, np.array([[x, y, distance]]))
    for one, other in zip(made.channels[:-1], made.channels[1:], strict=True):
        own = one.screen.lower_right[0] - one.screen.lower_left[0]
        shared = one.screen.lower_right[0] - other.screen.lower_left[0]
        assert shared >= overlap / 100.0 * own - 1e-6
        assert own / (high - low) == pytest.approx(1920 / 1080)
    assume(width / 2 < 7 * distance and max(abs(low), abs(high)) < 7 * distance)
    check_frusta(screens)


@FEW
@given(n=st.integers(1, 12), overlap=percent, angle=st.floats(30, 300), radius=st.floats(150, 2000),
       s=share, t=share)  # fmt: skip
def test_a_curved_screen_is_covered(n, overlap, angle, radius, s, t):
    made, screens = planned("curved", projectors=n, overlap=overlap, angle=angle, radius=radius,
                            height=1.2 * radius * np.radians(angle) / n)  # fmt: skip
    turn = np.radians(angle * (s - 0.5) * 0.9999)
    y = screens[0].bottom + t * (screens[0].top - screens[0].bottom)
    check_light(screens, np.array([[radius * np.sin(turn), y, radius * np.cos(turn)]]))
    check_frusta(screens)
    for one, other in zip(made.channels[:-1], made.channels[1:], strict=True):
        own = one.screen.right_deg - one.screen.left_deg
        assert one.screen.right_deg - other.screen.left_deg >= overlap / 100.0 * own - 0.002
    check_mesh(made.channels[0], screens[0])


@pytest.mark.nightly
@FEW
@given(n=st.integers(4, 20), overlap=percent, tilt=st.floats(0, 60), radius=st.floats(100, 2000),
       seed=st.integers(0, 99))  # fmt: skip
def test_a_dome_is_covered(n, overlap, tilt, radius, seed):
    made, screens = planned("dome", projectors=n, overlap=overlap, tilt=tilt, radius=radius)
    assert len(made.channels) == n
    ways = np.random.default_rng(seed).normal(size=(4, 3))
    zenith = np.array([0.0, np.cos(np.radians(tilt)), np.sin(np.radians(tilt))])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    ways = ways[ways @ zenith > 1e-3]
    check_light(screens, radius * ways)
    check_frusta(screens)
    check_mesh(made.channels[0], screens[0])
    check_mesh(made.channels[-1], screens[-1])
    for one in made.channels:  # lenses are in the dome, at its rim or within
        assert np.linalg.norm(one.lens.place) < radius
        assert abs(one.lens.place @ zenith) < 1e-6 * radius


@pytest.mark.parametrize(("n", "overlap"), [(6, 10), (8, 25), (12, 15)])
def test_neighbours_in_a_dome_share_what_was_wanted(n, overlap):
    """Along the horizon the shared part of the lowest ring is at least the wanted one."""
    _, screens = planned("dome", projectors=n, overlap=overlap)
    turn = np.linspace(0.0, 2.0 * np.pi, 7200, endpoint=False)
    ways = np.stack([np.sin(turn), np.full_like(turn, 1e-6), np.cos(turn)], axis=1)
    lit = []
    for screen in screens:
        places = places_on(screen, ways)
        with np.errstate(invalid="ignore"):
            lit.append(((places >= 0) & (places <= 1)).all(axis=1))
    ring = [one for one in lit if one.any()]
    for k, one in enumerate(ring):
        shared = one & ring[(k + 1) % len(ring)]
        assert shared.sum() >= overlap / 100.0 * one.sum() - 2


@FEW
@given(
    n=st.integers(2, 6),
    width=st.floats(150, 1000),
    height=st.floats(200, 1000),
    seed=st.integers(0, 9),
)
def test_a_cave_is_closed(n, width, height, seed):
    made, screens = planned("cave", projectors=n, width=width, height=height)
    check_frusta(screens)
    ways = np.random.default_rng(seed).normal(size=(100, 3))
    lamps = [Projector(screen, 2.2, 0.0) for screen in screens]
    met = np.zeros(len(ways), int)
    for k, screen in enumerate(screens):
        places = places_on(screen, ways)
        with np.errstate(invalid="ignore"):
            met += ((places >= 0) & (places <= 1)).all(axis=1)
        normal = np.cross(screen.along, screen.up)
        assert screen.corner @ normal < 0.0 or screen.corner @ np.cross(screen.up, screen.along) < 0
        assert overlap_count(lamps, k, np.array([[0.5, 0.5]]))[0] == 1
    assert (met <= 1).all()
    assert n < 6 or (met == 1).all()
    for one, screen in zip(made.channels, screens, strict=True):
        lights = points_on(screen, np.array([[0.5, 0.5]]))[0] - one.lens.place
        assert lights @ one.lens.axes[2] == pytest.approx(np.linalg.norm(lights))


@pytest.mark.parametrize(
    ("kind", "measures", "message"),
    [
        ("dome", {"projectors": 3}, "--projectors 3: a dome has 1 .a fisheye., or 4 or more"),
        ("dome", {"projectors": 4, "overlap": 40}, "expected more projectors or less overlap"),
        ("dome", {"throw": 3}, r"--throw 3 lights too little of .* expected 0\.\d\d or less"),
        ("curved", {"projectors": 1, "angle": 200}, "would light 200 degrees .* expected 150"),
        ("curved", {"projectors": 8, "angle": 30}, r"would use \d+% of its pixels, expected 30%"),
        ("curved", {"throw": 9}, "--throw 9 lights too little of its part of the screen"),
        ("curved", {"height": 60, "across": 1080, "down": 1920}, "--across 1920 --down 1080"),
        ("cave", {"projectors": 7}, "--projectors 7: a cave has 2 to 6"),
        ("cave", {"height": 100}, "--height 100: walls end below the eyes at 120 cm"),
        ("mirror", {"mirror": 200}, "--mirror 200 is too large for a dome of 300 cm"),
        ("mirror", {"throw": 15}, "--throw 15 puts the lens 855 cm from the mirror, out of"),
    ],
)
def test_impossible_measures_are_refused(kind, measures, message):
    with pytest.raises(UserError, match=message):
        layout(kind, chosen(kind, measures))


@pytest.mark.parametrize(
    ("kind", "measures"),
    [("wall", {}), ("curved", {}), ("curved", {"throw": 0.9}), ("curved", {"throw": 1.5}),
     ("curved", {"projectors": 6, "angle": 300}), ("dome", {}), ("dome", {"projectors": 4}),
     ("dome", {"projectors": 12, "tilt": 20}), ("cave", {"projectors": 6})],
)  # fmt: skip
def test_housings_of_projectors_keep_apart(kind, measures):
    made = layout(kind, chosen(kind, measures))
    places = [one.lens.place for one in made.channels]
    assert min(np.linalg.norm(a - b) for a, b in combinations(places, 2)) >= HOUSING_CM - 0.1
    assert not any("housings" in note for note in made.notes)


def test_lenses_that_cannot_keep_apart_are_noted():
    notes = layout("wall", chosen("wall", {"width": 100})).notes
    assert "two lenses are 31 cm apart: their housings must be narrower" in notes


@pytest.mark.parametrize(
    ("kind", "measures", "name"),
    [("wall", {}, "middle"), ("curved", {"projectors": 5}, "projector-3"), ("cave", {}, "front"),
     ("dome", {}, "projector-1"), ("dome", {"projectors": 12}, "projector-1")],
)  # fmt: skip
def test_the_front_channel_is_ahead_of_the_audience(kind, measures, name):
    assert front_channel(layout(kind, chosen(kind, measures))).name == name


@pytest.mark.parametrize("size", [(1920, 1080), (1080, 1920), (1200, 1200)])
def test_pixels_of_a_cave_are_square(size):
    across, down = size
    measures = {"projectors": 4, "height": 200, "across": across, "down": down}
    made, screens = planned("cave", **measures)
    for one, screen in zip(made.channels, screens, strict=True):
        x, y, width, height = one.viewport or (0, 0, *size)
        assert min(x, y) >= 0 and x + width <= across and y + height <= down
        assert width == across or height == down
        pixel = np.linalg.norm(screen.along) / width
        assert pixel == pytest.approx(np.linalg.norm(screen.up) / height, rel=2e-3)
        away = np.linalg.norm(points_on(screen, np.array([[0.5, 0.5]]))[0] - one.lens.place)
        assert one.lens.half[0] * 2 * away == pytest.approx(pixel * across, rel=2e-3)
