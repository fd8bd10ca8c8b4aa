"""Reefs: where growths stand, and the floor over them."""

import msgspec
import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.geometry.vector import vector
from subsea.habitat.formations import drawn_distance, formations
from subsea.habitat.reef import DEEPEST, KINDS, MOUND, PACKED, SUNK, floor_over, grow_reefs, tops
from subsea.habitat.sea import make_sea
from subsea.habitat.terrain import dome, heights_at, variant_of
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import GrowthKind, ReefTable

TABLES = [
    ReefTable(position_cm=(-150.0, 205.0), spread_cm=200.0, number=120, seed=1),
    ReefTable(position_cm=(90.0, -10.0), spread_cm=330.0, number=80, rock=0.9, seed=2),
    ReefTable(number=60, size=0.8, seed=3),
]


@pytest.fixture(scope="module")
def bay():
    """The peaceful bay, without and with reefs."""
    scenario = msgspec.structs.replace(load_scenario("peaceful")[0], reef=TABLES)
    return scenario, make_sea(scenario, np.random.default_rng(0))[0]


@pytest.fixture(scope="module")
def grown(bay):
    return grow_reefs(*bay)


def feet(reef):
    """Where growths touch the ground: less what they are sunk into it, to first order."""
    return reef.place.astype(np.float64), SUNK * reef.radius


def test_scenarios_know_all_kinds():
    assert set(KINDS) - {"mound"} == set(GrowthKind.__args__)


def test_it_is_the_same_again_and_another_with_another_seed(bay, grown):
    scenario, sea = bay
    again = grow_reefs(scenario, sea)[1]
    for one, other in zip(grown[1], again, strict=True):
        np.testing.assert_array_equal(one, other)
    tables = [msgspec.structs.replace(table, seed=9) for table in TABLES]
    other = grow_reefs(msgspec.structs.replace(scenario, reef=tables), sea)[1]
    assert not np.array_equal(grown[1].place[:50], other.place[:50])


def test_most_find_room_and_all_sizes_and_kinds_occur(grown):
    reef = grown[1]
    assert 0.7 * 260 < (reef.kind != MOUND).sum() < 1.2 * 260
    assert (reef.kind == MOUND).sum() > 2
    assert len(np.unique(reef.kind)) > 9
    assert (np.diff(reef.radius) <= 0).all()
    assert reef.radius.max() > 3 * np.median(reef.radius) > 0


def test_they_stand_on_the_ground(bay, grown):
    """On the sand, on a mound that stands there, or on the stone that is drawn."""
    sea, reef = bay[1], grown[1]
    place, sunk = feet(reef)
    assert 0.3 < reef.on_rock.mean() < 0.9
    gap = place[:, 2] - heights_at(sea.heights, sea.half_width, place[:, :2]) + sunk
    mound = reef.kind == MOUND
    assert (gap[mound] < 1.0).all()
    assert (gap[mound] > -0.8 * reef.radius[mound]).all()
    # On a slope they stand so deep that their lower side touches it.
    tall = np.array([kind.height for kind in KINDS.values()])[reef.kind] * reef.radius
    mounds = reef.taken(mound)
    forms = variant_of(mounds.own)
    stand = 0
    for k in np.flatnonzero(~reef.on_rock & ~mound):
        off = (place[k] - mounds.place) / mounds.radius[:, None]
        near = np.flatnonzero(np.hypot(*off[:, :2].T) < 1.0)
        above = [gap[k]]
        for m in near:
            cos, sin = np.cos(mounds.turn[m]), np.sin(mounds.turn[m])
            east, north, up = off[m]
            flat = np.array([east * cos + north * sin, north * cos - east * sin])
            above.append(float(mounds.radius[m] * (up - dome(forms[m], flat)) + sunk[k]))
        assert min(above) < 1.0
        assert max(above) > -DEEPEST * tall[k] - 1.0
        stand += min(above) < gap[k] - 2.0
    assert stand > 15
    blocks = formations(sea.pillars, sea.rocks)
    for p, deep in zip(place[reef.on_rock], sunk[reef.on_rock], strict=True):
        gaps = [drawn_distance(one, vector(p)) for one in blocks]
        assert abs(min(gaps, key=abs)) < deep + 4.0


def test_they_stand_apart(grown):
    reef = grown[1].taken(grown[1].kind != MOUND)
    # The ground that they are sunk into slopes differently under each.
    foot = reef.place.astype(np.float64)
    away = np.linalg.norm(foot[:, None] - foot[None], axis=2)
    room = PACKED * (reef.radius[:, None] + reef.radius[None])
    room -= SUNK * (reef.radius[:, None] + reef.radius[None])
    np.fill_diagonal(away, np.inf)
    assert (away > room - 0.1).all()


def test_they_stay_inside_the_sea_and_under_water(bay, grown):
    scenario, reef = bay[0], grown[1]
    assert np.hypot(*reef.place[:, :2].T).max() < scenario.bounds.radius_cm
    assert tops(reef).max() < -15.0


def test_they_grow_upward_or_away_from_the_stone(grown):
    reef = grown[1]
    np.testing.assert_allclose(np.linalg.norm(reef.axis, axis=1), 1.0, atol=1e-5)
    assert (reef.axis[:, 2] > -0.2).all()
    assert np.median(reef.axis[:, 2]) > 0.8


def test_a_table_may_name_its_kinds(bay):
    scenario, sea = bay
    tables = [ReefTable(position_cm=(0.0, 200.0), number=40, kinds={"fan": 1.0, "brain": 2.0})]
    reef = grow_reefs(msgspec.structs.replace(scenario, reef=tables), sea)[1]
    assert {list(KINDS)[k] for k in reef.kind} == {"fan", "brain", "mound"}


def test_the_floor_lies_over_what_grows_and_is_the_sand_elsewhere(bay, grown):
    sea, reef = grown
    assert (sea.floor >= sea.heights).all()
    on_sand = np.flatnonzero(~reef.on_rock)
    for k in on_sand:
        kind = KINDS[list(KINDS)[reef.kind[k]]]
        x, y = reef.place[k, :2] + 0.5 * kind.height * reef.radius[k] * reef.axis[k, :2]
        turn = np.linspace(0, 2 * np.pi, 8)
        rim = np.stack([x + reef.radius[k] * np.cos(turn), y + reef.radius[k] * np.sin(turn)], 1)
        if kind.height * reef.radius[k] > 7.0:
            assert (heights_at(sea.floor, sea.half_width, rim) > tops(reef)[k] - 1.0).all()
    far = np.full(sea.heights.shape, True)
    axis = np.linspace(-sea.half_width, sea.half_width, len(far))
    for place, radius in zip(reef.place, reef.radius, strict=True):
        far &= np.hypot(axis[:, None] - place[1], axis[None] - place[0]) > 4 * radius + 100.0
    assert far.mean() > 0.2
    np.testing.assert_array_equal(sea.floor[far], sea.heights[far])


def test_no_arch_is_filled(bay, grown):
    """In the middle of the opening there is water down to the sand, or what grows on it."""
    scenario, sea = bay[0], grown[0]
    arch = scenario.arch[0]
    middle = np.array([arch.position_cm])
    lift = heights_at(sea.floor, sea.half_width, middle) - heights_at(
        sea.heights, sea.half_width, middle
    )
    assert lift[0] < 0.5 * arch.height_cm


def test_without_reefs_the_floor_is_the_sand(bay):
    scenario, sea = bay
    for tables in ([], [ReefTable(number=0)]):
        bare, reef = grow_reefs(msgspec.structs.replace(scenario, reef=tables), sea)
        assert len(reef.kind) == 0
    np.testing.assert_array_equal(bare.floor, sea.heights)
    np.testing.assert_array_equal(floor_over(sea, reef), sea.heights)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("position_cm = [9000.0, 0.0]", r"reef\[11\].position_cm"),
        ("number = 2001", "number"),
        ('kinds = { tree = 1.0 }', "tree"),
        ("size = 9.0", "size"),
    ],
)  # fmt: skip
def test_errors_are_one_line(tmp_path, text, said):
    path = load_scenario("schooling").path
    bare = path.read_text()
    (tmp_path / "own.toml").write_text(f"{bare}\n[[reef]]\n{text}\n")
    with pytest.raises(UserError, match=said):
        load_scenario(str(tmp_path / "own.toml"))


def test_stone_takes_light_from_what_grows_under_it(grown):
    reef = grown[1]
    assert (reef.light[~reef.on_rock] == 1.0).all()
    assert ((reef.light >= 0.0) & (reef.light <= 1.0)).all()
    assert reef.light[reef.on_rock].min() < 0.5 < reef.light[reef.on_rock].max()
