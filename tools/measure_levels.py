"""What levels of detail and culling save: a fish at each level, and a sea full of fishes.

.venv/bin/python tools/measure_levels.py

Times are those of all processors together, so that other work on the machine counts for little.
Every figure is the least of several.
"""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from subsea.dive.tour import Tour
from subsea.frame.packet import Batch, Packet, PackOptions, make_scene, pack
from subsea.render import Renderer, headless_context
from subsea.render.output.quality import PRESETS
from subsea.scenario.load import load_scenario
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.view.levels import LEVELS, empty_lod_state
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import World

SIZE = (1280, 720)
QUALITY = PRESETS["low"]
WARM_UP_TICKS = 40
REPEATS = 5


def least_ms(work: Callable[[], object]) -> float:
    """The shortest of several runs, in milliseconds; the first one compiles."""
    work()
    durations = []
    for _ in range(REPEATS):
        start = time.process_time()
        work()
        durations.append(time.process_time() - start)
    return 1000.0 * min(durations)


def drawing_ms(context: object, renderer: Renderer, packet: Packet) -> float:
    """What the fishes of a picture cost beside the picture without them."""

    def draw(shown: Packet) -> None:
        renderer.draw(shown)
        renderer.read_pixels()

    bare = replace(packet, instances=packet.instances[:0], batches=((),))
    return least_ms(lambda: draw(packet)) - least_ms(lambda: draw(bare))


def sea(fish: int) -> World:
    """The open ocean, some ticks after its start."""
    world, tour = create_world(load_scenario("open-ocean")[0], fish=fish), Tour()
    for _ in range(WARM_UP_TICKS):
        step(world, tour.helm(world))
    return world


def packed(world: World, **options: bool) -> Packet:
    """A frame of the tour."""
    views = views_for("mono", SIZE, cockpit(world.state.submarine, 1.0))
    return pack(world, views, 1.0, PackOptions(QUALITY.detail, **options))


def each_level(world: World) -> None:
    """The same fishes, in the same places, all of them at one level and then at the next."""
    packet = packed(world)
    count = len(packet.instances)
    with headless_context() as context:
        renderer = Renderer(context, make_scene(world), display_rig("mono", SIZE), QUALITY)
        for level, name in enumerate(LEVELS):
            drawn = replace(packet, batches=((Batch(level, 0, count),),))
            cost = drawing_ms(context, renderer, drawn)
            print(f"{name:12s}{1000.0 * cost / count:8.1f} µs a fish ({count} of them)")
        renderer.release()


def with_and_without(world: World, number: int) -> None:
    """The fishes of a picture with and without both, and the rest of a frame."""
    memory = empty_lod_state(number)
    views = views_for("mono", SIZE, cockpit(world.state.submarine, 1.0))
    tour = Tour()
    both, neither = packed(world), packed(world, culling=False, lod=False)
    with headless_context() as context:
        renderer = Renderer(context, make_scene(world), display_rig("mono", SIZE), QUALITY)
        costs = [drawing_ms(context, renderer, packet) for packet in (both, neither)]
        renderer.release()
    print(f"{number} fishes, {len(both.instances)} in sight: {costs[0]:.1f} ms")
    print(f"without both {costs[1]:.0f} ms, {costs[1] / costs[0]:.0f} times as much")
    counts = np.zeros(len(LEVELS), int)
    for batch in both.batches[0]:
        counts[batch.level] += batch.count
    print(dict(zip(LEVELS, counts.tolist(), strict=True)))
    packing = least_ms(lambda: pack(world, views, 1.0, PackOptions(QUALITY.detail), memory=memory))
    print(f"packing {packing:.2f} ms, a tick {least_ms(lambda: step(world, tour.helm(world))):.1f}")


def main() -> None:
    """Print a small table."""
    each_level(sea(1_000))
    for number in (1_000, 30_000):
        with_and_without(sea(number), number)


if __name__ == "__main__":
    main()
