"""The physics of simulated fishes, and currents, set in the panel by real input."""

import math
from contextlib import closing

import numpy as np
import pytest

from subsea.state import Physics
from subsea.ui.dive import Dive
from subsea.ui.panels.initialisation import present
from subsea.world import snapshot
from tests.support.windows import dive_options
from tests.ui.panels.test_initialisation import POOL

NEAR = POOL.replace(
    "number = 3", "number = 3\nposition_cm = [-200.0, 0.0, -200.0]\nspread_cm = 60.0"
)


@pytest.fixture(scope="module")
def pool(display, hands, coarse, tmp_path_factory):
    path = tmp_path_factory.mktemp("sea") / "pool.toml"
    path.write_text(NEAR)
    with closing(Dive(dive_options(path, (720, 580), coarse, seed=None))) as running:
        running.overlay.toggle_help()
        running.inspector.toggle()
        running.inspector.shown = {"Physics"}
        hands.glide(running, 0.4)
        yield running


def test_the_chosen_fish_is_simulated_and_the_dive_goes_on(pool, hands, spots):
    fishes, world = pool.world.state.fishes, pool.world
    # Not the fish that would be simulated anyway.
    far = np.linalg.norm(fishes.position - world.state.submarine.position, axis=1)
    far[~world.dynamics.muscular[fishes.species]] = 0.0
    pool.inspector.chosen = fish = int(np.argmax(far))
    assert world.dynamics.muscular[fishes.species].sum() > 1
    hands.glide(pool, 0.2)
    place, tick = fishes.position[fish].copy(), world.state.tick
    spots.click(pool, "simulate it before all others", 0.05)
    hands.until(pool, lambda: pool.world is not world)
    fishes = pool.world.state.fishes
    assert pool.world.state.tick >= tick
    assert np.linalg.norm(fishes.position[fish] - place) < 40.0
    assert pool.inspector.chosen == fish
    hands.until(pool, lambda: fishes.live[fish])
    assert fishes.live.sum() == 1


def test_factors_act_are_kept_by_time_and_go_back_to_what_is_usual(pool, hands, spots):
    hands.glide(pool, 0.2)
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
    hands.glide(pool, 0.2)
    spots.click(pool, "Defaults")
    fish = pool.world.physics.fish
    assert pool.world.physics == Physics(fish=fish) and fish >= 0


def test_a_fish_that_explodes_is_told_and_comes_to_no_harm(pool, hands, spots, capsys):
    fish = pool.world.physics.fish
    hands.glide(pool, 0.2)
    hands.until(pool, lambda: pool.world.state.fishes.live[fish])
    capsys.readouterr()
    spots.drag(pool, "time step", 0.43, 0.9)
    hands.until(pool, lambda: pool.world.reported_bursts)
    hands.glide(pool, 0.2)
    told = capsys.readouterr().err
    assert "exploded" in told and "time step" in told
    assert np.isfinite(pool.world.state.fishes.position).all()
    assert pool.world.state.fishes.alive.all()
    spots.click(pool, "Defaults")


def test_the_current_is_turned_by_the_dial_made_stronger_and_switched_off(pool, hands, spots):
    hands.glide(pool, 0.2)
    assert pool.world.current_cm_s == (0.0, 0.0)
    spots.click(pool, "current", 0.1)
    assert pool.world.current_cm_s == (6.0, 0.0)
    left, top, right, bottom = spots["dial"]
    x, y = pool.window.position
    middle = x + (left + right) / 2, y + (top + bottom) / 2
    hands.do("mousemove", round(middle[0] + 20), round(middle[1]))
    hands.glide(pool, 0.2)
    hands.do("mousedown", 1)
    hands.glide(pool, 0.2)
    hands.do("mousemove", round(middle[0]), round(middle[1] - 30))  # up: along y
    hands.glide(pool, 0.2)
    hands.do("mouseup", 1)
    hands.glide(pool, 0.2)
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
