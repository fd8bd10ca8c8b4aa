"""The physics of simulated fishes, and currents, set in the panel by real input."""

import math
from contextlib import closing

import numpy as np
import pytest

from subsea.state import Physics
from subsea.ui.dive import Dive
from subsea.ui.panels.initialisation import open_file, present
from subsea.world import snapshot
from tests.support.windows import dive_options
from tests.ui.panels.test_initialisation import POOL

NEAR = POOL.replace(
    "number = 3", "number = 3\nposition_cm = [-200.0, 0.0, -200.0]\nspread_cm = 60.0"
)


@pytest.fixture(scope="module")
def dive(display, user, coarse, tmp_path_factory):
    path = tmp_path_factory.mktemp("sea") / "pool.toml"
    path.write_text(NEAR)
    with closing(Dive(dive_options(path, (720, 580), coarse, seed=None))) as running:
        running.overlay.hide_help()
        running.inspector.toggle()
        running.inspector.shown = {"Physics"}
        yield running


@pytest.fixture
def pool(dive, user, spots):
    """The dive, begun again as its file says."""
    assert open_file(dive.inspector, str(dive.source))
    user.glide(dive, 0.4)
    return dive


def simulate(pool, user, spots):
    """Simulate a fish by the panel, not the one that would be simulated anyway; its number."""
    fishes, world = pool.world.state.fishes, pool.world
    far = np.linalg.norm(fishes.position - world.state.submarine.position, axis=1)
    far[~world.dynamics.muscular[fishes.species]] = 0.0
    pool.inspector.chosen = fish = int(np.argmax(far))
    user.glide(pool, 0.2)
    spots.click(pool, "simulate it before all others", 0.05)
    user.until(pool, lambda: pool.world is not world)
    user.until(pool, lambda: pool.world.state.fishes.live[fish])
    return fish


def test_the_chosen_fish_is_simulated_and_the_dive_goes_on(pool, user, spots):
    places, tick = pool.world.state.fishes.position.copy(), pool.world.state.tick
    assert pool.world.dynamics.muscular[pool.world.state.fishes.species].sum() > 1
    fish = simulate(pool, user, spots)
    fishes = pool.world.state.fishes
    assert pool.world.state.tick >= tick
    assert np.linalg.norm(fishes.position[fish] - places[fish]) < 60.0
    assert pool.inspector.chosen == fish
    assert fishes.live.sum() == 1


@pytest.mark.nightly
def test_factors_act_are_restored_by_a_rewind_and_have_defaults(pool, user, spots):
    fish = simulate(pool, user, spots)
    before = snapshot.checksum(pool.world)
    tick = pool.timeline.tick
    spots.drag(pool, "unit mass", 0.45, 0.55)
    assert pool.world.physics.unit_mass > 1.5
    spots.click(pool, "hydrodynamics", 0.05)
    assert not pool.world.physics.hydrodynamics
    assert present(pool.inspector).physics.unit_mass == pool.world.physics.unit_mass
    changed = pool.world.physics
    pool.timeline.go(tick)
    assert snapshot.checksum(pool.world) == before
    assert pool.world.physics.unit_mass == 1.0
    pool.world.physics = changed
    user.glide(pool, 0.2)
    spots.click(pool, "Defaults")
    assert pool.world.physics == Physics(fish=fish)


@pytest.mark.nightly
def test_an_exploding_fish_is_reported_and_survives(pool, user, spots, capsys):
    simulate(pool, user, spots)
    capsys.readouterr()
    spots.drag(pool, "time step", 0.43, 0.9)
    user.until(pool, lambda: pool.world.reported_bursts)
    user.glide(pool, 0.2)
    told = capsys.readouterr().err
    assert "exploded" in told and "time step" in told
    assert np.isfinite(pool.world.state.fishes.position).all()
    assert pool.world.state.fishes.alive.all()


def test_the_current_is_turned_by_the_dial_made_stronger_and_switched_off(pool, user, spots):
    assert pool.world.current_cm_s == (0.0, 0.0)
    spots.click(pool, "current", 0.1)
    assert pool.world.current_cm_s == (6.0, 0.0)
    left, top, right, bottom = spots["dial"]
    x, y = pool.window.position
    middle = x + (left + right) / 2, y + (top + bottom) / 2
    right, up = (middle[0] + 20, middle[1]), (middle[0], middle[1] - 30)
    user.drag(pool, *(tuple(map(round, place)) for place in (right, up)))
    along, across = pool.world.current_cm_s
    assert abs(math.degrees(math.atan2(across, along)) - 90.0) < 6.0
    spots.drag(pool, "strength", 0.1, 0.4)
    assert math.hypot(*pool.world.current_cm_s) > 15.0
    kept = pool.world.current_cm_s
    spots.click(pool, "current", 0.1)
    assert pool.world.current_cm_s == (0.0, 0.0)
    spots.click(pool, "current", 0.1)
    assert pool.world.current_cm_s == kept
    assert present(pool.inspector).water.current_cm_s == kept
