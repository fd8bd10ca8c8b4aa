"""What pillars, rocks, seaweed and the current cost: in a picture, and in a tick.

.venv/bin/python tools/measure_habitat.py

Times of a picture are those of all processors together, so that other work on the machine counts
for little. Every figure is the least of several.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import msgspec
import numpy as np

from subsea.app.tour import Tour
from subsea.frame import make_scene, pack
from subsea.habitat import plankton
from subsea.habitat.current import carry
from subsea.habitat.seaweed import sway
from subsea.ocean import step
from subsea.render import Renderer, headless_context
from subsea.scenario import Scenario, Seaweed, load_scenario
from subsea.state import Clock
from subsea.view.rigs import cockpit, views_for
from subsea.world import TICK_S, create_world

SIZE = (1280, 720)
AT_TICKS = (30, 60, 90)
REPEATS = 9


def least_ms(clock: Callable[[], float], work: Callable[[], object]) -> float:
    """The shortest of several runs, in milliseconds; the first one compiles."""
    work()
    durations = []
    for _ in range(REPEATS):
        start = clock()
        work()
        durations.append(clock() - start)
    return 1000.0 * min(durations)


def pictures(scenario: Scenario) -> None:
    """Three frames of the tour, with and without what stands and grows there."""
    world, tour = create_world(scenario), Tour()
    packets = []
    for tick in range(1, AT_TICKS[-1] + 1):
        step(world, tour.helm(world))
        if tick in AT_TICKS:
            views = views_for("mono", SIZE, cockpit(world.state.submarine, 1.0))
            packets.append(pack(world, views, 1.0))
    scene = make_scene(world)
    bare = replace(scene, pillars=scene.pillars[:0], rocks=scene.rocks[:0])
    with headless_context() as context:
        full, empty = Renderer(context, scene, SIZE), Renderer(context, bare, SIZE)
        least = 0.0
        for name, renderer, leaves in (
            ("sand alone", empty, False),
            ("with rocks", full, False),
            ("with seaweed", empty, True),
            ("with both", full, True),
        ):

            def draw(renderer: Renderer = renderer, leaves: bool = leaves) -> None:
                for packet in packets:
                    none = replace(packet, leaves=packet.leaves[:0], fine_leaves=0)
                    renderer.draw(packet if leaves else none)
                    context.finish()

            cost = least_ms(time.process_time, draw) / len(packets)
            least = least or cost
            print(f"a picture, {name:14s}{cost:7.1f} ms{cost / least:7.2f} ×")


def ticks(scenario: Scenario) -> None:
    """Kernels of the habitat for 10,000 fishes and 100 clusters of six leaves."""
    bed = Seaweed(clusters=100, leaves=6, position_cm=(0.0, 0.0), spread_cm=500.0)
    flow, clock = np.array([3.0, 1.0, 0.0]), Clock(0, 1, TICK_S)
    for number in (60, 10_000):
        world = create_world(msgspec.structs.replace(scenario, seaweed=[bed]), fish=number)
        fishes, sea, weed = world.state.fishes, world.state.sea, world.state.seaweed
        rows = {
            "current": partial(carry, fishes, sea, flow),
            "plankton": partial(plankton.drift, sea, flow, clock),
            "seaweed": partial(sway, weed, fishes, sea, flow, 1e9, clock),
        }
        for name, work in rows.items():
            print(f"{number} fishes, {name:10s}{least_ms(time.perf_counter, work):8.3f} ms")


def main() -> None:
    """Print a small table."""
    scenario, _ = load_scenario("peaceful")
    pictures(scenario)
    ticks(scenario)


if __name__ == "__main__":
    main()
