"""Sites, cover and shadows that a fish sees on stone."""

import numpy as np
import pytest

from subsea.perception.sites import (
    FOOD_CM,
    FULL_UP,
    LEAST_STOCK,
    grids_of,
    is_too_dark,
    reefers_of,
    see_sites,
)
from subsea.state import (
    ANEMONE,
    AVOID,
    BATHES,
    CLEANS,
    COVER,
    GRAZE,
    HIDES,
    HUNGER,
    NOBODY,
    POLYPS,
    POSE,
    SHELTER,
    SUBMARINE,
    TURF,
    WANDER,
)
from subsea.state.feelings import feel
from subsea.state.wants import TEMPTING


def reef(tank, n, *sites, **solids):
    """A tank with sites (kind, x, y, z) whose surfaces face up."""
    t = tank(n, **solids)
    places = np.array([site[1:] for site in sites], np.float32).reshape(-1, 3)
    normals = np.zeros_like(places)
    normals[:, 2] = 1.0
    sea = t.sea._replace(
        site_kind=np.array([site[0] for site in sites], np.uint8), site_place=places,
        site_normal=normals, site_growth=np.full(len(sites), -1, np.int32),
        site_depth=np.zeros(len(sites), np.float32), stock=np.ones(len(sites), np.float32),
    )  # fmt: skip
    t.minds.mental[:, HUNGER], t.minds.diet[:] = 0.6, 1 << TURF
    return t._replace(sea=sea)


def look(t):
    groups = grids_of(t.sea), reefers_of(t.fishes, t.minds)
    who = np.arange(len(t.fishes.species))
    see_sites(who, t.fishes, t.minds, t.sea, t.nature, t.clock, *groups)


def test_a_hungry_fish_chooses_near_food_of_its_diet(tank):
    t = reef(tank, 2, (POLYPS, 20.0, 0.0, -340.0), (TURF, 60.0, 0.0, -340.0))
    t.minds.diet[1] = 1 << POLYPS
    look(t)
    assert t.minds.site.tolist() == [1, 0]


def test_it_sees_no_food_that_is_far_behind_a_rock_bare_or_on_the_far_side(tank):
    below = (TURF, 60.0, 0.0, -340.0)
    far = reef(tank, 1, (TURF, FOOD_CM + 60.0, 0.0, -340.0))
    behind = reef(
        tank, 1, (TURF, 260.0, 0.0, -340.0), rocks=[(140.0, 0.0, -310.0, 60.0, 60.0, 60.0, 0.0)]
    )
    bare, turned = reef(tank, 1, below), reef(tank, 1, below)
    bare.sea.stock[0], turned.sea.site_normal[0] = LEAST_STOCK, (0.0, 0.0, -1.0)
    for t in (far, behind, bare, turned):
        look(t)
        assert t.minds.site[0] == -1
    seen = reef(tank, 1, below)
    look(seen)
    assert seen.minds.site[0] == 0


def test_a_meal_begins_with_hunger_and_ends_when_the_fish_is_full(tank):
    t = reef(tank, 1, (TURF, 60.0, 0.0, -340.0))
    keen, seen = t.nature.keen, []
    for share in (0.5, 0.9, 1.1, 0.9, 0.5, 0.9 * FULL_UP, 0.5, 0.9):
        t.minds.mental[:, HUNGER] = share * keen
        look(t)
        seen.append(bool(t.minds.site[0] >= 0))
        t.minds.intention[:] = GRAZE if seen[-1] else WANDER
    assert seen == [False, False, True, True, True, False, False, False]
    t.minds.intention[:], t.minds.memory[:] = AVOID, GRAZE
    look(t)
    assert t.minds.site[0] == 0  # it was interrupted


def test_it_does_not_feed_where_it_was_chased_off(tank):
    t = reef(tank, 2, (TURF, 60.0, 0.0, -340.0))
    t.minds.chaser[0], t.minds.territory[1] = 1, 60.0
    t.minds.home[1] = 70.0, 0.0, -340.0
    look(t)
    assert t.minds.site.tolist() == [-1, 0]


def test_it_feeds_where_it_likes_light_and_warmth(tank):
    t = reef(tank, 3, (TURF, 60.0, 0.0, -340.0), (TURF, 160.0, 0.0, -380.0))
    t.minds.comfort[:] = (0.0, np.inf), (360.0, 500.0), (0.0, 330.0)
    look(t)
    assert t.minds.site.tolist() == [0, 1, -1]


def test_a_hungry_fish_leaves_stone_for_food_from_the_submarine(tank):
    t = reef(lambda n: tank(n, specks=2), 2, (TURF, 60.0, 0.0, -340.0))
    t.minds.food[:] = 0, 1
    t.sea.absent[1] = -20.0  # it was scattered; the other one drifts as ever
    look(t)
    assert t.minds.site.tolist() == [0, -1]
    t.minds.mental[:, HUNGER], t.minds.intention[:] = 0.95 * TEMPTING * t.nature.keen, GRAZE
    look(t)
    assert t.minds.site.tolist() == [0, 0]


def test_a_cleaner_that_dislikes_the_water_of_its_station_has_no_clients(tank):
    t = reef(tank, 2)
    t.minds.ways[:], t.minds.itch[1] = (CLEANS, HIDES), 1.0
    t.minds.home[:] = t.fishes.position
    for comfort, cleaner in (((0.0, 400.0), 0), ((350.0, 400.0), NOBODY)):
        t.minds.comfort[0] = comfort
        t.minds.intention[1] = POSE
        look(t)
        assert t.minds.cleaner[1] == cleaner
        assert t.minds.client[0] == (1 if cleaner == 0 else NOBODY)


def test_a_cleaner_that_likes_a_submarine_at_rest_has_it_for_a_client(tank):
    t = reef(tank, 2)
    t.minds.ways[:], t.minds.home[:] = (CLEANS, HIDES), t.fishes.position
    t.sea.submarine[:3] = 150.0, 0.0, -300.0
    t.minds.itch[0] = 1.0
    look(t)
    assert t.minds.client[0] == NOBODY
    feel(t.minds, 0, SUBMARINE, 0.3)
    look(t)
    assert t.minds.client[0] == SUBMARINE
    t.sea.submarine[3] = 40.0  # it leaves
    look(t)
    assert t.minds.client[0] == NOBODY
    t.sea.submarine[3], t.minds.intention[1] = 0.0, POSE  # a fish has precedence
    look(t)
    assert t.minds.client[0] == 1


def test_a_visit_to_the_window_begins_and_ends_as_an_itch_does(tank):
    t = reef(tank, 1)
    t.minds.ways[:], t.minds.home[:] = CLEANS, t.fishes.position
    t.sea.submarine[:3] = 150.0, 0.0, -300.0
    feel(t.minds, 0, SUBMARINE, 0.3)
    seen = []
    for itch in (0.59, 0.61, 0.31, 0.29, 0.31):
        t.minds.itch[0] = itch
        look(t)
        seen.append(int(t.minds.client[0]))
    assert seen == [NOBODY, SUBMARINE, SUBMARINE, NOBODY, NOBODY]


def test_large_fishes_leave_their_cover_before_small_ones(tank):
    t = reef(tank, 3)
    t.minds.ways[:], t.fishes.length[:] = HIDES, (10.0, 20.0, 40.0)
    left = []
    for daylight in np.arange(0.0, 0.4, 0.005):
        t.sea.sky[1] = daylight
        look(t)
        left.append((~t.minds.dark.astype(bool)).tolist())
    dawn = np.argmax(left, axis=0)
    assert (np.diff(dawn) < 0).all()


def test_cover_is_sought_under_a_moving_shadow(tank):
    t = reef(tank, 1, (COVER, 60.0, 0.0, -340.0))
    t.minds.ways[:] = HIDES
    look(t)
    assert t.minds.shadow[0] == 0.0
    assert t.minds.cover[0] == -1
    t.sea.submarine[:3] = 40.0, 0.0, -180.0
    look(t)
    assert t.minds.shadow[0] == 0.0  # it lies still
    t.sea.submarine[3] = 60.0
    look(t)
    assert t.minds.shadow[0] > 0.5
    assert t.minds.cover[0] == 0


def test_a_cover_that_another_fish_is_in_is_passed_over(tank):
    t = reef(tank, 3, (COVER, 60.0, 0.0, -300.0), (COVER, 400.0, 0.0, -300.0))
    t.minds.ways[:], t.sea.sky[1] = HIDES, 0.0
    t.fishes.position[:, 0] = 52.0, 0.0, -150.0
    t.minds.cover[:] = 0, 0, -1
    t.minds.intention[:2] = SHELTER
    look(t)
    assert t.minds.cover.tolist() == [0, 1, 1], "the nearest keeps it; also on the way there"
    t.fishes.alive[0] = False
    t.minds.cover[:] = -1
    look(t)
    assert t.minds.cover[1:].tolist() == [0, 0]


def test_large_fishes_cast_shadows_on_those_below(tank):
    t = reef(tank, 2, (COVER, 60.0, 0.0, -340.0))
    t.minds.ways[:], t.fishes.length[1] = HIDES, 140.0
    t.fishes.position[1] = 20.0, 0.0, -200.0
    look(t)
    assert t.minds.shadow[0] > 0.0
    assert t.minds.shadow[1] == 0.0
    t.fishes.position[1, 0] = 400.0
    look(t)
    assert t.minds.shadow[0] == 0.0


def test_a_clownfish_knows_the_anemone_of_its_home(tank):
    t = reef(tank, 1, (ANEMONE, 60.0, 0.0, -340.0), (ANEMONE, 500.0, 0.0, -340.0))
    t.minds.ways[:], t.minds.home[0] = BATHES, (500.0, 0.0, -320.0)
    look(t)
    assert t.minds.cover[0] == 1


def test_small_fishes_rest_first_in_the_evening_and_longest_in_the_morning(tank):
    t = reef(tank, 2)
    t.fishes.length[:] = 8.0, 30.0
    asleep = []
    for daylight in (0.0, 0.15, 0.2, 0.5, 1.0):
        t.sea.sky[1] = daylight
        asleep.append([is_too_dark(t.fishes, i, t.sea) for i in range(2)])
    assert asleep[0] == [True, True]
    assert [True, False] in asleep
    assert [False, True] not in asleep
    assert asleep[-1] == [False, False]


def test_a_client_finds_a_cleaner_at_its_station_and_is_found(tank):
    t = reef(tank, 2, (TURF, 60.0, 0.0, -340.0))
    t.minds.ways[:] = CLEANS, HIDES
    t.fishes.position[1, 0] = 100.0
    t.minds.home[:] = t.fishes.position
    t.minds.itch[1] = 0.9
    look(t)
    assert t.minds.cleaner.tolist() == [NOBODY, 0]
    t.minds.intention[1] = POSE
    look(t)
    assert t.minds.client.tolist() == [1, NOBODY]
    t.fishes.position[0, 0] = -500.0  # the cleaner is away
    look(t)
    assert t.minds.cleaner[1] == NOBODY


@pytest.mark.parametrize("kind", [TURF, COVER])
def test_a_sea_without_places_of_a_kind_is_searched_in_vain(tank, kind):
    t = reef(tank, 1, (ANEMONE, 60.0, 0.0, -340.0))
    t.minds.ways[:] = HIDES
    t.sea.submarine[:4] = 0.0, 0.0, -150.0, 60.0
    look(t)
    assert t.minds.site[0] == t.minds.cover[0] == -1
    assert kind not in t.sea.site_kind
