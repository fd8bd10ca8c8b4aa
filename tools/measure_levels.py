"""Measure levels of detail and culling: a fish at each level, and a sea full of fishes.

.venv/bin/python tools/measure_levels.py

Figures are processor times of all threads, the least of several runs.
"""

from dataclasses import replace

import numpy as np
from fastest import fastest_ms

from subsea.dive.tour import Tour
from subsea.frame.packet import Batch, Packet, PackOptions, make_scene, pack
from subsea.rendering.gl.context import headless_context
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.renderer import Renderer
from subsea.scenario.load import load_scenario
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.view.levels import LEVELS, empty_lod_state
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import World

SIZE = (1280, 720)
QUALITY = PRESETS["low"]
WARM_UP_TICKS = 40


def drawing_ms(context: object, renderer: Renderer, packet: Packet) -> float:
    """The cost of the fishes of a picture: with minus without them."""

    def draw(shown: Packet) -> None:
        renderer.draw(shown)
        renderer.read_pixels()

    bare = replace(packet, instances=packet.instances[:0], batches=((),))
    return fastest_ms(lambda: draw(packet)) - fastest_ms(lambda: draw(bare))


def sea(fish: int) -> World:
    """The open ocean after some ticks."""
    world, tour = create_world(load_scenario("open-ocean")[0], fish=fish), Tour()
    for _ in range(WARM_UP_TICKS):
        step(world, tour.helm(world))
    return world


def packed(world: World, **options: bool) -> Packet:
    """A frame of the tour."""
    views = views_for("mono", SIZE, cockpit(world.state.submarine, 1.0))
    return pack(world, views, 1.0, PackOptions(QUALITY.detail, **options))


def each_level(world: World) -> None:
    """Measure the same fishes at each level in turn."""
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
    """Measure the fishes of a picture with and without both, and the rest of a frame."""
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
    options = PackOptions(QUALITY.detail)
    packing = fastest_ms(lambda: pack(world, views, 1.0, options, memory=memory))
    tick = fastest_ms(lambda: step(world, tour.helm(world)))
    print(f"packing {packing:.2f} ms, a tick {tick:.1f}")


def main() -> None:
    """Print a small table."""
    each_level(sea(1_000))
    for number in (1_000, 30_000):
        with_and_without(sea(number), number)


if __name__ == "__main__":
    main()
