"""Places to feed and hide lie on what is drawn."""

import numpy as np
import pytest

from subsea.geometry.vector import vector
from subsea.habitat.contact import clearances
from subsea.habitat.formations import drawn_distance, formations
from subsea.habitat.reef import KINDS, MOUND
from subsea.habitat.sites import DEEPEST_CM, OFFERS, REGROW_S, ROOM_CM, lay_sites, regrow
from subsea.scenario.load import load_scenario
from subsea.state import ANEMONE, COVER, FOODS, SITES, TURF, Reef, empty
from subsea.world.build import make_surroundings


@pytest.fixture(scope="module")
def lagoon():
    """Sea and reef of `mating`: sand, outcrops and patch reefs."""
    scenario = load_scenario("mating")[0]
    sea, reef, *_ = make_surroundings(scenario, np.random.default_rng(1), 1)
    return sea, reef


def test_a_reef_has_food_of_every_kind_and_cover(lagoon):
    sea, _ = lagoon
    number = np.bincount(sea.site_kind, minlength=len(SITES))
    assert (np.delete(number, ANEMONE) > 5).all(), dict(zip(SITES, number, strict=True))
    assert number[ANEMONE] == 0  # the scenario says so: its clownfishes dance for each other
    assert (sea.stock == 1.0).all()
    np.testing.assert_allclose(np.linalg.norm(sea.site_normal, axis=1), 1.0, atol=1e-5)


def test_turf_on_rock_lies_on_the_drawn_stone_and_faces_out_of_it(lagoon):
    sea, _ = lagoon
    turf = np.flatnonzero((sea.site_kind == TURF) & (sea.site_growth < 0))
    stones = formations(sea.pillars, sea.rocks)
    assert len(turf) > 50
    for k in turf:
        place, normal = sea.site_place[k].astype(float), sea.site_normal[k].astype(float)
        assert min(abs(drawn_distance(blocks, vector(place))) for blocks in stones) < 2.5
        outside = min(drawn_distance(blocks, vector(place + 4.0 * normal)) for blocks in stones)
        assert outside > 0.2


def test_a_site_knows_how_deep_it_lies_in_the_shell_that_fishes_avoid(lagoon):
    sea, _ = lagoon
    gap = clearances(sea.pillars, sea.rocks, sea.site_place.astype(float))
    np.testing.assert_allclose(sea.site_depth, np.maximum(-gap, 0.0), atol=0.01)
    assert sea.site_depth.max() < DEEPEST_CM


def test_cover_in_stone_has_room_for_a_body(lagoon):
    sea, _ = lagoon
    cover = np.flatnonzero((sea.site_kind == COVER) & (sea.site_growth < 0))
    stones = formations(sea.pillars, sea.rocks)
    assert len(cover)
    for place in sea.site_place[cover].astype(float):
        assert min(drawn_distance(blocks, vector(place)) for blocks in stones) > ROOM_CM - 0.1


def test_food_on_growths_belongs_to_kinds_that_offer_it_and_is_within_them(lagoon):
    sea, reef = lagoon
    for k in np.flatnonzero((sea.site_growth >= 0) & (sea.site_kind < FOODS)):
        growth = sea.site_growth[k]
        name = list(KINDS)[reef.kind[growth]]
        assert sea.site_kind[k] == (TURF if reef.kind[growth] == MOUND else OFFERS[name][0])
        off = sea.site_place[k] - reef.place[growth]
        tall = off @ reef.axis[growth]
        radius = reef.radius[growth]
        assert np.linalg.norm(off - tall * reef.axis[growth]) < 0.8 * radius
        assert 0.0 < tall < 1.05 * KINDS[name].height * radius


def test_no_food_lies_under_a_table_coral(lagoon):
    sea, reef = lagoon
    table = list(KINDS).index("table")
    for k in np.flatnonzero(reef.kind == table):
        off = sea.site_place - reef.place[k]
        up = off @ reef.axis[k]
        away = np.linalg.norm(off - up[:, None] * reef.axis[k], axis=1)
        under = (away < 0.8 * reef.radius[k]) & (up > 0.0) & (up < 0.3 * reef.radius[k])
        assert not (under & (sea.site_kind < FOODS)).any()


def test_bare_sand_offers_nothing(make_sea):
    assert len(lay_sites(make_sea(), empty(Reef, k=0)).stock) == 0


def test_what_was_eaten_grows_again(lagoon):
    sea, _ = lagoon
    sea = sea._replace(stock=np.array([0.0, 0.5, 1.0], np.float32))
    regrow(sea, REGROW_S / 4)
    np.testing.assert_allclose(sea.stock, [0.25, 0.75, 1.0])
