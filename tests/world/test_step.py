"""The whole world over many ticks."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from subsea.base.system import resource_path
from subsea.fish.species import load_species
from subsea.geometry.solids import height_at
from subsea.motor.containment import roll_of
from subsea.scenario.load import load_scenario
from subsea.state import GRAZE, HULL_CM, LOOPING, POSE, SHELTER
from subsea.submarine.vessel import Helm
from subsea.world.build import create_world
from subsea.world.snapshot import checksum
from subsea.world.step import step
from subsea.world.world import TICK_S

AHEAD = Helm(surge=0.4, yaw=0.1)
HOLDING = GRAZE, SHELTER, POSE  # fishes that do so stand, and lean over


def _world(seed=None, fish=None):
    return create_world(load_scenario("peaceful")[0], seed=seed, fish=fish)


@pytest.fixture(scope="module")
def voyage():
    """40 s of the peaceful bay.

    World, paths of fishes (T, n, 3) and of the hull (T, 3), and whether each fish is close to stone
    and holds its place (T, n).
    """
    world = create_world(load_scenario("peaceful", ["seaweed=[]"])[0])  # which is slow
    path, hull, close, holds = [], [], [], []
    for _ in range(1200):
        step(world, AHEAD)
        path.append(world.state.fishes.position.copy())
        hull.append(world.state.submarine.position.copy())
        close.append(world.state.fishes.close.copy())
        holds.append(np.isin(world.state.minds.intention, HOLDING))
    return world, np.array(path), np.array(hull), np.array(close), np.array(holds)


@pytest.mark.parametrize("fish", [None, 0, 1, 7, 61, 500])
def test_shoals_scale_to_any_number_of_fishes(fish):
    world = _world(fish=fish)
    step(world, AHEAD)
    number = sum(shoal.number for shoal in world.scenario.fish) if fish is None else fish
    assert len(world.state.fishes.species) == number


def test_courting_males_show_their_colours():
    world = _world(fish=7)
    minds, display = world.state.minds, world.state.fishes.display
    minds.male[:2] = True, False
    for _ in range(10):
        minds.courtship[:2] = LOOPING  # without partners, behavior ends it at each turn
        minds.pause[:2] = 0.0
        step(world, Helm())
    assert display[0] > 0.0
    assert display[1] == 0.0


def test_fishes_stay_inside_the_sea(voyage):
    """Fishes that feed or hide at the ground touch it, and no other comes near."""
    world, path, _, close, _ = voyage
    bounds = world.scenario.bounds
    assert np.isfinite(path).all()
    assert np.hypot(path[..., 0], path[..., 1]).max() < bounds.radius_cm
    assert path[..., 2].max() < 0
    sea = world.state.sea
    depth = np.array(
        [
            p[2] - height_at(sea.heights, sea.half_width, p[0], p[1])
            for p in path[::10].reshape(-1, 3)
        ]
    )
    near = close[::10].ravel()
    assert depth[~near].min() > 3.0
    assert depth.min() > 0.0


def test_speeds_are_those_of_fishes(voyage):
    """No leaps, no standing still: speeds are in the measured ranges of each species.

    Fishes in the bow wave of the moving submarine are not counted, nor means of those that stand.
    """
    world, path, hull, _, holds = voyage
    measured = tomllib.loads(resource_path("assets/swimming.toml").read_text())["species"]
    keys = {load_species(key).name: key for key in measured}
    fishes = world.state.fishes
    speed = np.linalg.norm(np.diff(path, axis=0), axis=2) / TICK_S / fishes.length
    free = np.linalg.norm(path - hull[:, None], axis=2)[1:] > 2 * HULL_CM
    for k in np.unique(fishes.species):
        ranges, those = measured[keys[world.species[k].name]], fishes.species == k
        assert speed[:, those][free[:, those]].max() < ranges["burst"]["range"][1]
        mean = np.ma.array(speed, mask=holds[1:])[:, those].mean(axis=0)
        assert mean.min() > ranges["slow"]["range"][0]
        assert mean.max() < ranges["cruise"]["range"][1]


def test_schools_stay_together(voyage):
    world, path, *_ = voyage
    schooling = world.state.minds.leader >= 0
    leaders = world.state.minds.leader[schooling]
    assert len(set(leaders)) == 2
    gap = np.linalg.norm(path[600:, schooling] - path[600:, leaders], axis=2)
    assert np.median(gap) < 150
    assert (gap < 350).mean() > 0.98


def test_schooling_fishes_keep_their_distance(voyage):
    world, path, *_ = voyage
    schooling = world.state.minds.leader >= 0
    places = path[900::60, schooling]
    gap = np.linalg.norm(places[:, :, None] - places[:, None], axis=3)
    gap += 1e9 * np.eye(gap.shape[1])
    nearest = gap.min(axis=2) / world.state.fishes.length[schooling].mean()
    assert np.median(nearest) > 0.5


def test_fishes_stay_upright(voyage):
    """Only fishes that feed on stone, dive into it or pose for a cleaner lean over."""
    world, *_ = voyage
    rolls = np.array([abs(roll_of(q)) for q in world.state.fishes.orientation.astype(float)])
    leans = np.isin(world.state.minds.intention, HOLDING)
    assert np.degrees(np.median(rolls)) < 5
    assert np.degrees(rolls[~leans].max()) < 40


def test_equal_seeds_are_equal_worlds_and_others_are_not():
    worlds = [_world(seed=5, fish=40), _world(seed=5, fish=40), _world(seed=6, fish=40)]
    for _ in range(120):
        for world in worlds:
            step(world, AHEAD)
    first, second, other = (checksum(world) for world in worlds)
    assert first == second
    assert first != other


def test_the_checksum_includes_every_array():
    world = _world(fish=3)
    before = checksum(world)
    world.state.fishes.fins[2, 1] += 1e-3
    assert checksum(world) != before


GOLDEN = Path(__file__).parent / "golden_positions.npy"
GOLDEN_TICKS = 150


def test_positions_match_the_golden_file(request):
    """Positions after 150 ticks match the file within 1 mm.

    Processors and their mathematical libraries differ in the last bits.
    """
    world = _world(seed=11)
    for _ in range(GOLDEN_TICKS):
        step(world, AHEAD)
    positions = np.concatenate(
        [world.state.fishes.position, world.state.submarine.position[None].astype(np.float32)]
    )
    if request.config.getoption("--regenerate"):
        np.save(GOLDEN, positions)
    np.testing.assert_allclose(positions, np.load(GOLDEN), atol=0.1)
