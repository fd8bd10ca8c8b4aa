"""The order of a tick."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from subsea.behavior.intention import decide
from subsea.habitat import plankton
from subsea.habitat.current import flow_at
from subsea.kinematics.heightfield import height_at
from subsea.motor.controller import command
from subsea.motor.fins import flap
from subsea.motor.playback import play
from subsea.motor.switching import swim
from subsea.perception.neighbours import LOOK_TICKS, REACH_CM, find_neighbours
from subsea.submarine.helm import Helm
from subsea.submarine.hull import step_hull
from subsea.world import TICK_S, World, create_world

__all__ = ["TICK_S", "World", "create_world", "step"]


def step(world: World, helm: Helm) -> None:
    """Advance the world by one tick: perceive, decide, move, flow, steer."""
    state, fishes = world.state, world.state.fishes
    seed, tick, now = state.seed, state.tick, state.tick * TICK_S
    radius = world.scenario.bounds.radius_cm
    sea = (world.terrain, world.terrain_half_width)
    flow = flow_at(world.scenario.water.current_cm_s, now)
    with _stage(world, "perception"):
        # To begin with everybody looks around, from then on a part of all in each tick.
        stride = LOOK_TICKS if tick else 1
        find_neighbours(fishes, REACH_CM, tick % stride, stride)
    with _stage(world, "behavior"):
        decide(fishes, *sea, radius, state.submarine.position, seed, tick, TICK_S)
    with _stage(world, "motor"):
        command(fishes, world.library, seed, tick, TICK_S)
        swim(
            fishes, world.library, world.dynamics, state.live,
            flow, state.submarine.position, tick, TICK_S,
        )  # fmt: skip
        play(fishes, world.library, flow, TICK_S)
        flap(fishes, TICK_S)
    with _stage(world, "habitat"):
        plankton.drift(state.plankton, flow, radius, *sea, seed, tick, TICK_S)
    step_hull(
        state.submarine, helm, TICK_S, lambda x, y: height_at(*sea, x, y), world.scenario.bounds
    )
    state.tick += 1


@contextmanager
def _stage(world: World, name: str) -> Iterator[None]:
    """Measure the wall-clock time of one stage of the tick."""
    start = time.perf_counter()
    yield
    world.stages_s[name] = time.perf_counter() - start
