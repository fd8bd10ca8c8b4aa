"""A box with periodic sides: no place in it is like no other, and no fish notices a side."""

import re
from pathlib import Path

import numpy as np
import pytest

import subsea
from subsea.base.errors import UserError
from subsea.behavior import table
from subsea.geometry.periodic import gathered, shortest
from subsea.kernels.threads import use_threads
from subsea.perception import focusser, senses
from subsea.perception.leader_tracking import schools_of
from subsea.scenario.load import load_scenario
from subsea.scenario.save import scenario_text
from subsea.submarine.vessel import NEUTRAL
from subsea.world import step as stepping
from subsea.world.build import create_world
from subsea.world.migrate import migrate
from subsea.world.periodic import places_of, wrap
from subsea.world.snapshot import checksum
from subsea.world.step import step
from tests.support.scenes import BOX, SCHOOL, SIDE

ROOT = Path(__file__).parents[2]
# Prey, and a shark that sees them.
HUNT = [
    "nature.vision_cm=120", "nature.smell_cm=200", "school.sight_bl=15", "bounds.radius_cm=1600",
    "submarine.position_cm=[-1400, 0, -250]",
    'fish=[{ species = "fusilier", number = 24, size_cm = [17, 19], position_cm = [0, 0, -250], '
    "spread_cm = 70, heading_deg = 30 }, "
    '{ species = "blacktip_reef_shark", number = 1, size_cm = [110, 110], hunger = 1.0, '
    "position_cm = [0, -150, -250], heading_deg = 90 }]",
]  # fmt: skip


def box(changes=SCHOOL, seed=2):
    return create_world(load_scenario(BOX, changes)[0], seed=seed)


def moved(world, way):
    """Move all fishes of a world, and what they remember, by a way (2,), cm."""
    fishes, minds = world.state.fishes, world.state.minds
    for places in places_of(fishes, minds):
        places[:, :2] += way
    wrap(fishes, minds)
    return world


@pytest.mark.parametrize("changes", [SCHOOL, HUNT], ids=["school", "hunt"])
def test_a_school_across_the_seams_swims_as_in_the_middle(changes):
    """In a corner of the box, the four parts of a school are at four corners of the sea."""
    middle, corner = box(changes), moved(box(changes), [SIDE / 2, SIDE / 2])
    assert len(np.unique(np.sign(corner.state.fishes.position[:, :2]), axis=0)) == 4
    for _ in range(60):
        step(middle, NEUTRAL)
        step(corner, NEUTRAL)
    here, there = middle.state.fishes, corner.state.fishes
    off = there.position - here.position + [SIDE / 2, SIDE / 2, 0.0]
    assert np.abs(shortest(off, here.period)).max() < 0.05
    assert there.velocity == pytest.approx(here.velocity, abs=0.5)
    for name in ("neighbour", "intention", "predator", "target"):
        same = getattr(middle.state.minds, name) == getattr(corner.state.minds, name)
        assert same.mean() > 0.98, name
    assert (middle.state.minds.neighbour >= 0).any()
    if changes is HUNT:
        assert (middle.state.minds.predator >= 0).any() and middle.state.minds.foods[-1, 0] >= 0


def test_a_fish_that_leaves_comes_in_on_the_other_side():
    """Its path goes on, and so does the way to its goal."""
    world = box([*SCHOOL, "fish.0.position_cm=[505, -505, -250]"])
    fishes, minds = world.state.fishes, world.state.minds
    left = 0
    for _ in range(60):
        before, goal = fishes.position.copy(), minds.waypoint - fishes.position
        patience = minds.patience.copy()
        step(world, NEUTRAL)
        assert np.abs(fishes.position[:, :2]).max() <= SIDE / 2
        leap = fishes.position - before
        way = shortest(leap, fishes.period)
        left += (leap != way).any(axis=1).sum()
        assert np.linalg.norm(way, axis=1).max() < 10.0
        assert fishes.position - fishes.previous_position == pytest.approx(way, abs=1e-3)
        same = minds.patience <= patience  # else it has a new goal
        assert (minds.waypoint - fishes.position)[same] == pytest.approx(
            (goal - way)[same], abs=0.1
        )
    assert left > 10


def test_all_places_of_a_fish_are_shifted_with_it():
    """A new array of places that is not would be a goal far outside of the box."""
    world = box()
    fishes, minds = world.state.fishes, world.state.minds
    for group in (fishes, minds):
        for name in ("position", "previous_position", "home", "waypoint", "leader_place",
                     "threat_place"):  # fmt: skip
            if hasattr(group, name):
                getattr(group, name)[0] = 600.0, -30.0, -250.0
    wrap(fishes, minds)
    rows = np.array([places[0] for places in places_of(fishes, minds)])
    assert len(rows) == 6
    assert rows == pytest.approx(np.tile([600.0 - SIDE, -30.0, -250.0], (6, 1)))


def test_only_images_are_compared():
    """No rule of open water subtracts the plain place of another fish."""
    reef = {"cleaning", "courtship", "mating", "seaweed", "spawning", "territory"}
    pattern = re.compile(r"(minus|toward)\([^\n]*vector\(fishes\.position\[(?!i\])")
    for room in ("perception", "behavior", "habitat"):
        for path in (ROOT / "subsea" / room).glob("*.py"):
            if path.stem not in reef:
                assert not pattern.findall(path.read_text("utf-8")), path


def test_the_middle_of_a_school_is_that_of_its_nearest_images():
    world = box()
    fishes = world.state.fishes
    mean = fishes.position.astype(float).mean(axis=0)
    across = moved(world, [SIDE / 2 - mean[0], -SIDE / 2 - mean[1]]).state
    found = schools_of(across.fishes, across.minds)
    middle = found.middle[0] / found.size[0]
    expected = np.array([SIDE / 2, -SIDE / 2, mean[2]])
    assert shortest(middle - expected, fishes.period) == pytest.approx(np.zeros(3), abs=1e-3)
    around = gathered(fishes.position.astype(float), fishes.period)
    assert np.ptp(around, axis=0).max() < 300.0 < np.ptp(fishes.position, axis=0).max()


def test_every_fish_thinks_in_every_tick():
    """The submarine is far away, and a box has no other place that is special."""
    world = box()
    for _ in range(3):
        step(world, NEUTRAL)
        assert (world.state.minds.pause == 0.0).all()


def test_the_number_of_threads_does_not_matter(monkeypatch):
    for module in (stepping, senses, focusser, table):
        monkeypatch.setattr(module, "LEAST_PART", 3)
    for name in ("LEAST_MINDS", "LEAST_SPECKS"):
        monkeypatch.setattr(stepping, name, 3)
    monkeypatch.setattr(senses, "LEAST_GRIDS", 1)
    found = []
    try:
        for threads in (1, 3):
            use_threads(threads)
            world = moved(box(HUNT), [500.0, 500.0])
            for _ in range(20):
                step(world, NEUTRAL)
            found.append(checksum(world))
    finally:
        use_threads()
    assert len(set(found)) == 1


PERIODIC = "bounds.periodic_cm"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["bounds.periodic_cm=[1024, 900]"], "others at 475 cm, expected at least 988 along x"),
        (["bounds.periodic_cm=[1024]"], PERIODIC),
        (["bounds.tank_cm=[500, 500]"], "bounds.tank_cm`: expected none beside `bounds.periodic"),
        (["bounds.radius_cm=900"], "bounds.radius_cm` 900: expected at least 1001"),
        (["terrain.dune_height_cm=20"], "terrain.dune_height_cm` 20: expected 0 in a box"),
        (["terrain.shelf_cm=20"], "terrain.shelf_cm` 20: expected 0 in a box"),
        (["water.plankton=10"], "water.plankton` 10: expected 0 in a box"),
        (["nature.submarine_cm=80"], "nature.submarine_cm` 80: expected 0 in a box"),
        (["nature.curiosity_cm=80"], "nature.curiosity_cm` 80: expected 0 in a box"),
        (["submarine.position_cm=[-600, 0, -250]"], "submarine.position_cm` .* at least 276 cm"),
        (["rock=[{ position_cm = [0, 0], size_cm = [50, 50, 50] }]"], "`rock`: expected none"),
        (["reef=[{ number = 5 }]"], "`reef`: expected none in a box with periodic sides"),
        (["fish.0.position_cm=[600, 0, -250]"], "lies outside the box: expected x and y within"),
        (['fish.0.species="clownfish"'], "fish.0..species` 'clownfish': it lives at a reef"),
        (['fish.0.kind="pacifist"'], "it lives at a reef, expected prey or predators"),
        (
            ["school.goals=[{ share = 0.1, position_cm = [0, 0, -250] }]"],
            "school.goals.0..position_cm`: expected `heading_deg` in a box",
        ),
    ],
)
def test_what_does_not_fit_is_one_line(changes, words):
    with pytest.raises(UserError, match=words) as fault:
        box(changes)
    assert "\n" not in str(fault.value)


def test_a_box_is_saved_and_stays_when_a_dive_is_changed(tmp_path):
    loaded = load_scenario(BOX)
    saved = tmp_path / "saved.toml"
    saved.write_text(scenario_text(loaded.scenario, loaded.path))
    assert load_scenario(str(saved)).scenario.bounds.periodic_cm == (SIDE, SIDE)
    open_sea = [*SCHOOL, "bounds.periodic_cm=[4096, 4096]", "bounds.radius_cm=6000",
                "submarine.position_cm=[-4000, 0, -250]"]  # fmt: skip
    before, after = box(open_sea), box()
    before.state.fishes.position[:, 0] += 700.0
    migrate(before, after)
    assert after.state.fishes.period.tolist() == [SIDE, SIDE]
    assert np.abs(after.state.fishes.position[:, 0]).max() <= SIDE / 2


def test_a_rule_of_ones_own_has_the_period():
    seen = []

    def meet(who, position, period):
        gap = position - position[who, None]
        gap[..., :2] -= period * np.round(gap[..., :2] / period)
        seen.append(np.linalg.norm(gap, axis=2).max())
        return gap.mean(axis=1)

    loaded = load_scenario(BOX, [*SCHOOL, "fish.0.position_cm=[512, 512, -250]"])
    rule = subsea.rule("school", meet, desire=1.0)
    world = create_world(loaded.scenario, seed=2, behaviors=[rule])
    for _ in range(3):
        step(world, NEUTRAL)
    assert 0.0 < max(seen) < 400.0
