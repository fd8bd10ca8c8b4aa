"""A tank in the sea: its walls hold fishes, water and the submarine, and are not drawn."""

import numpy as np
import pytest

import subsea
from subsea.base.errors import UserError
from subsea.geometry.solids import from_pillar
from subsea.geometry.walls import is_wall, tank_of, wall_rows
from subsea.habitat.formations import first_of_formation, formations, numbered_formations
from subsea.lab.measures import BARRIERS, clearances
from subsea.scenario.load import load_scenario
from subsea.scenario.save import scenario_text
from subsea.world.migrate import migrate
from subsea.world.to_scenario import to_scenario
from tests.support.scenes import BARE

TANK = [
    "bounds.tank_cm=[1000, 600]", "water.plankton=200", "submarine.position_cm=[-400, -60, -250]",
]  # fmt: skip
ROCK = np.array([[100.0, 0.0, -400.0, 60.0, 50.0, 40.0, 0.3]])
PILLAR = np.array([[-200.0, 50.0, 30.0, -100.0]])


def test_walls_are_flat_and_face_inward():
    walls = wall_rows((1000.0, 600.0))
    assert is_wall(walls).all() and not is_wall(PILLAR).any()
    assert wall_rows(None).shape == (0, 4) and tank_of(PILLAR) is None
    assert tank_of(np.concatenate([PILLAR, walls])) == pytest.approx((1000.0, 600.0))
    for place, gaps in (
        ((0.0, 0.0, -50.0), (500, 500, 300, 300)), ((490.0, -295.0, -5.0), (10, 990, 595, 5)),
        ((510.0, 0.0, -5.0), (-10, 1010, 300, 300)),
    ):  # fmt: skip
        found = [from_pillar(wall, place)[1] for wall in walls]
        assert found == pytest.approx(gaps, abs=0.02)
    normals = np.array([from_pillar(wall, (1.0, 2.0, -5.0))[0] for wall in walls])
    assert normals == pytest.approx(
        np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]]), abs=1e-5
    )


def test_walls_are_of_no_stone():
    both = np.concatenate([PILLAR, wall_rows((1000.0, 600.0))])
    plain = formations(PILLAR, ROCK)
    assert all(map(np.array_equal, formations(both, ROCK), plain))
    assert sorted(n for _, those in numbered_formations(both, ROCK) for n in those) == [0, 5]
    assert first_of_formation(both, ROCK).tolist() == [0, 1, 2, 3, 4, 5]
    assert not formations(both[1:], ROCK[:0])


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    out = tmp_path_factory.mktemp("tank") / "run.h5"
    return subsea.simulate(str(BARE), out, seconds=8.0, seed=3, fish=30, changes=TANK)


def test_fishes_and_plankton_stay_inside(path):
    record = subsea.open_record(path)
    inside = np.abs(record.snout[..., :2]) < (500.0, 300.0)
    assert inside.all()
    assert subsea.measure(record)["sea"]["out_of_bounds_or_inside"] == 0
    assert np.ptp(record.position[..., :2], axis=(0, 1)).min() > 200.0
    world = subsea.load(str(BARE), seed=3, fish=5, changes=TANK)
    world.step(30)
    assert (np.abs(world.sea.plankton[:, :2]) < (500.5, 300.5)).all()


def test_the_nearest_barrier_of_a_fish_at_a_wall_is_the_wall(path):
    record = subsea.open_record(path)
    place = np.array([496.0, 0.0, -250.0], np.float32)
    for name in ("snout", "position", "tail"):
        getattr(record, name)[0, 0] = place
    least, which = clearances(record)
    assert least[0, 0] == pytest.approx(4.0, abs=0.1)
    assert BARRIERS[which[0, 0]] == "wall"


def test_fishes_without_a_place_spread_over_the_tank():
    world = subsea.load(
        str(BARE), seed=3,
        changes=[*TANK, "fish=[{ species = 'clownfish', number = 60 }]", "rock=[]"],
    )  # fmt: skip
    across = np.abs(world.fishes.position[:, :2]).max(axis=0)
    assert (across < (500.0, 300.0)).all() and (across > (300.0, 180.0)).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["bounds.tank_cm=[1700, 900]"], "its corners are 962 cm from the middle"),
        (["bounds.tank_cm=[100, 900]"], "tank_cm"),
        ([TANK[0], "water.stream_cm_s=[1, 0]"], "water.stream_cm_s`: expected 0 in a tank"),
        ([TANK[0], "submarine.position_cm=[-470, 0, -250]"], "30.0 cm from a wall of the tank"),
        ([*TANK, "fish.0.position_cm=[-300, 310, -250]"], "lies inside a wall of the tank"),
    ],
)
def test_what_does_not_fit_is_one_line(changes, words):
    with pytest.raises(UserError, match=words) as fault:
        subsea.load(str(BARE), changes=changes)
    assert "\n" not in str(fault.value)


def test_a_tank_is_saved(tmp_path):
    loaded = load_scenario(str(BARE), TANK)
    saved = tmp_path / "saved.toml"
    saved.write_text(scenario_text(loaded.scenario, loaded.path))
    assert load_scenario(str(saved)).scenario.bounds.tank_cm == (1000.0, 600.0)


def test_a_snapshot_of_a_tank_is_restored():
    world = subsea.load(str(BARE), seed=3, fish=5, changes=TANK)
    before = world.snapshot()
    world.step(5)
    end = world.checksum()
    world.restore(before)
    world.step(5)
    assert world.checksum() == end


def test_fishes_of_a_dive_that_gets_a_tank_are_moved_into_it():
    usual = [
        "rock=[]", "fish.0.spread_cm=600", "submarine.position_cm=[-150, -60, -250]",
        "fish.1.position_cm=[-150, 100, -250]", "fish.0.position_cm=[-150, 0, -250]",
    ]  # fmt: skip
    before = subsea.load(str(BARE), seed=3, fish=30, changes=usual)
    before.step(10)
    after = subsea.load(str(BARE), seed=3, fish=30, changes=[*usual, "bounds.tank_cm=[500, 400]"])
    assert np.abs(before.fishes.position[:, :2]).max() > 500.0
    migrate(before.internal, after.internal)
    assert (np.abs(after.fishes.position[:, :2]) < (250.0, 200.0)).all()
    assert to_scenario(after.internal).bounds.tank_cm == (500.0, 400.0)
