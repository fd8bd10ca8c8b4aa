"""Measure the presets of quality, their fields, the stages and the parts of drawing.

.venv/bin/python tools/measure_quality.py [SCENARIO] [--size WxH]

Figures are processor times of all threads, the least of several runs, at three moments of the
tour. With a software rasteriser that is the cost of a picture, with a GPU only that of the driver.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

from subsea.dive.start import headless, start_world
from subsea.dive.tour import Tour
from subsea.frame.packet import Packet, make_scene, pack
from subsea.rendering.output.quality import LADDER, PRESETS, Quality
from subsea.rendering.renderer import Renderer
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.world.step import step

PARTS = {  # of the renderer, and the methods that draw them
    "stone": ("_rocks", "draw"), "corals": ("_coral", "draw"), "sand": ("_seabed", "draw"),
    "seaweed": ("_seaweed", "draw"), "water and surface": ("_water", "draw"),
    "fishes": ("_fishes", "draw"), "bubbles": ("_bubbles", "draw"),
    "snow and plankton": ("_particles", "draw"), "shafts": ("_shafts", "draw"),
    "shadows of fishes": ("_shadows", "draw"), "maps of shadows": ("", "_cast"),
    "to the screen": ("", "_show"),
}  # fmt: skip
AT_TICKS = (30, 60, 90)
REPEATS = 5


def variants() -> dict[str, Quality]:
    """Make the presets, and low with one field at a time as high has it, or a smaller canvas."""
    low, high = PRESETS["low"], asdict(PRESETS["high"])
    named = dict(PRESETS)
    for field, value in asdict(low).items():
        if high[field] != value:
            named[f"{field} {value:g} to {high[field]:g}"] = replace(low, **{field: high[field]})
    for scale in (0.75, LADDER[0].scale):
        named[f"scale 1 to {scale:g}"] = replace(low, scale=scale)
    return named


def packets(
    scenario: str, size: tuple[int, int], qualities: dict[str, Quality]
) -> tuple[Any, dict[str, list[Packet]]]:
    """Make the scene, and for each quality the packets of three moments."""
    world, tour = start_world(scenario), Tour()
    shown: dict[str, list[Packet]] = {name: [] for name in qualities}
    for tick in range(1, AT_TICKS[-1] + 1):
        step(world, tour.helm(world))
        if tick in AT_TICKS:
            views = views_for("mono", size, cockpit(world.state.submarine, 1.0))
            for name, quality in qualities.items():
                shown[name].append(pack(world, views, 1.0, options=quality.packing))
    return make_scene(world), shown


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenario", nargs="?", default="peaceful")
    parser.add_argument("--size", default="1280x720")
    options = parser.parse_args()
    size, qualities = tuple(map(int, options.size.split("x"))), variants()
    scene, shown = packets(options.scenario, size, qualities)
    with headless() as context:
        renderer = Renderer(context, scene, display_rig("mono", size), PRESETS["low"])

        def cost(name: str) -> float:
            durations = []
            for _ in range(1 + REPEATS):  # the first compiles
                start = time.process_time()
                for packet in shown[name]:
                    renderer.draw(packet)
                    context.finish()
                durations.append(time.process_time() - start)
            return 1000.0 * min(durations[1:]) / len(AT_TICKS)

        print(f"{context.info['GL_RENDERER']}, {options.scenario}, {options.size}: ms a picture")
        low = cost("low")
        for name, quality in qualities.items():
            renderer.adapt(quality)
            ms = low if name == "low" else cost(name)
            triangles = f"{renderer.triangles:9d} triangles" if name in PRESETS else ""
            print(f"{name:24s}{ms:8.1f}{ms - low:+8.1f}{ms / low:7.2f} ×{triangles}")
        renderer.adapt(PRESETS["low"])
        stages(context, renderer, low, cost)
        parts(context, renderer, shown["low"])
        renderer.release()


def stages(context: Any, renderer: Renderer, whole: float, cost: Callable[[str], float]) -> None:
    """Print the cost of vertices, triangles and fragments of a picture at low.

    Vertices: without rasterisation. Triangles: the difference to a canvas of a few pixels.
    Fragments: the rest.
    """
    context.enable(context.RASTERIZER_DISCARD)
    vertices = cost("low")
    context.disable(context.RASTERIZER_DISCARD)
    renderer.adapt(replace(PRESETS["low"], scale=0.02))
    triangles = cost("low")
    renderer.adapt(PRESETS["low"])
    for name, ms in (
        ("vertices", vertices),
        ("triangles", triangles - vertices),
        ("fragments", whole - triangles),
    ):
        print(f"{name:24s}{ms:8.1f}{ms / whole:15.0%}")


def parts(context: Any, renderer: Any, shown: list[Packet]) -> None:
    """Print the cost of each part of a picture at low, finished before the next begins."""
    spent: dict[str, float] = {}

    def timed(name: str, draw: Callable[..., Any]) -> Callable[..., Any]:
        def run(*given: Any) -> Any:
            context.finish()
            start = time.process_time()
            result = draw(*given)
            context.finish()
            spent[name] = spent.get(name, 0.0) + time.process_time() - start
            return result

        return run

    for name, (part, method) in PARTS.items():
        owner = getattr(renderer, part) if part else renderer
        setattr(owner, method, timed(name, getattr(owner, method)))
    least: dict[str, float] = {}
    for _ in range(1 + REPEATS):
        spent.clear()
        for packet in shown:
            renderer.draw(packet)
        least = {name: min(took, least.get(name, took)) for name, took in spent.items()}
    for name, took in sorted(least.items(), key=lambda part: -part[1]):
        print(f"{name:24s}{1000.0 * took / len(shown):8.1f}")


if __name__ == "__main__":
    main()
