"""`subsea benchmark`: how long every stage of a frame takes. docs/diving.md has the formulas."""

import json
import time
from collections import defaultdict
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from tqdm import tqdm

from subsea.app import pacing
from subsea.app.house import chosen_rig
from subsea.app.start import headless, picture_maker, start_world
from subsea.app.timing import summary
from subsea.app.tour import Tour
from subsea.frame import Packet, pack
from subsea.ocean import step
from subsea.places import check_file, replacing
from subsea.render.quality import AUTO, LADDER, PRESETS, first_rung, name_of
from subsea.scenario import load_scenario
from subsea.view.levels import HIDDEN, LEVELS, nothing_drawn
from subsea.view.rig import Rig, views
from subsea.view.rigs import cockpit
from subsea.world import World

if TYPE_CHECKING:
    from subsea.render import Renderer

STAGES = (
    "perception",
    "behavior",
    "motor",
    "habitat",
    "pose",
    "cull",
    "upload",
    "draw",
    "present",
)
WARM_UP_FRAMES = 30
LIVE_WARM_UP_TICKS = 900  # at most, until all that are to be simulated have come out of turns


def benchmark(
    scenario: str,
    fish: int | None,
    frames: int,
    size: tuple[int, int],
    display: str,
    seed: int | None,
    without: frozenset[str],
    out: Path | None,
    motor: str = "playback",
    quality: str = "low",
    target_ms: float | None = None,
    theatre: str | None = None,
    shrink: int = 1,
    changes: Sequence[str] = (),
) -> int:
    """Measure, print the report as a table, and write it as JSON to `out` if that is named.

    A `theatre` is shown instead of one picture of `size`, `shrink` times smaller.
    """
    if out is not None:
        check_file(out)
    rig, _ = chosen_rig(display, size, theatre=theatre, shrink=shrink)
    load_scenario(scenario, changes)
    with headless() as context:
        world = start_world(scenario, seed, fish, motor=motor, changes=changes)
        gpu, hold_ms = context.info["GL_RENDERER"], None
        if quality == AUTO:
            hold_ms = target_ms or pacing.target_for(gpu)
        begin = LADDER[first_rung(gpu)] if quality == AUTO else PRESETS[quality]
        with picture_maker(context, world, rig, begin) as renderer:
            measured = measure(world, renderer, context, rig, frames, without, hold_ms)
            drawn = name_of(renderer.quality)
        report = {
            "renderer": gpu,
            "size": [list(output) for output in rig.outputs] if theatre else list(size),
            "theatre": theatre,
            "display": display,
            "quality": quality,
            "quality_drawn": drawn,
            "target_ms": hold_ms,
            "scenario": scenario,
            "set": [*changes],
            "fish": len(world.state.fishes.species),
            "seed": world.state.seed,
            "version": version("subsea"),
            "without": sorted(without),
            "motor": motor,
            **measured,
        }
    _print(report)
    if out is not None:
        _write(out, report)
    return 0


def measure(
    world: World,
    renderer: "Renderer",
    context: Any,
    rig: Rig,
    frames: int,
    without: frozenset[str] = frozenset(),
    hold_ms: float | None = None,
) -> dict[str, Any]:
    """The measured part of the report: one tick and one picture a frame, after a warm-up.

    With `hold_ms` the quality changes from frame to frame, to hold that time; None keeps it.
    """
    durations: list[float] = []
    host: list[float] = []
    stages: dict[str, list[float]] = defaultdict(list)
    levels = np.zeros(len(LEVELS))
    simulated = 0
    tour = Tour()
    for _ in range(LIVE_WARM_UP_TICKS if len(world.state.live.fish) else 0):
        able = world.dynamics.muscular[world.state.fishes.species]
        if world.state.fishes.live[able].all():
            break
        step(world, tour.helm(world))
    memory = nothing_drawn(len(world.state.fishes.species))
    triangles = visible = calls = 0
    pace = pacing.start(LADDER.index(renderer.quality), rig.exact) if hold_ms else None
    for k in tqdm(range(-WARM_UP_FRAMES, frames), unit="frame", disable=None, leave=False):
        helm = tour.helm(world)  # a visitor's hands would take no time of the program's
        start = time.perf_counter()
        step(world, helm)
        packet = pack(
            world, views(rig, cockpit(world.state.submarine, 1.0)), 1.0,
            culling="culling" not in without, lod="lod" not in without,
            detail=renderer.quality.detail, growth=renderer.quality.growth, memory=memory,
        )  # fmt: skip
        packed = time.perf_counter()
        drawing, host_s = _draw(renderer, context, packet)
        end = time.perf_counter()
        if pace and hold_ms:
            pace = pacing.paced(pace, 1000.0 * (end - start), hold_ms)
            if LADDER[pace.rung] != renderer.quality:
                renderer.adapt(LADDER[pace.rung])
        if k < 0:
            continue
        durations.append(end - start)
        host.append(packed - start + host_s)
        for name, seconds in (world.stages_s | drawing).items():
            stages[name].append(seconds)
        levels += np.bincount(memory.level[memory.level != HIDDEN], minlength=len(LEVELS))
        simulated += int(world.state.fishes.live.sum())
        visible += len(world.state.fishes.species) - packet.hidden
        triangles += renderer.triangles
        calls = max(calls, renderer.draw_calls)
    frame_ms = summary(durations)
    return {
        "frames": frames,
        "visible_mean": visible / frames,
        "simulated_mean": simulated / frames,
        "frame_ms": frame_ms,
        "host_ms": summary(host)["p50"],
        "fps": 1000.0 / frame_ms["mean"],
        "stages_ms": {name: summary(stages[name])["p50"] for name in STAGES},
        "lod": dict(zip(LEVELS, (levels / frames).tolist(), strict=True)),
        "triangles_mean": triangles / frames,
        "draw_calls": calls,
    }


def _draw(renderer: "Renderer", context: Any, packet: Packet) -> tuple[dict[str, float], float]:
    """Draw a packet to the end; seconds of the stages upload, draw and present.

    Also the seconds that the renderer spent beside its drawing calls.
    """
    context.finish()
    begin = time.perf_counter()
    renderer.draw(packet)
    asked = time.perf_counter()
    context.finish()
    drawn = time.perf_counter()
    renderer.read_pixels()
    stages = {
        "upload": renderer.upload_s,
        "draw": drawn - begin - renderer.upload_s,
        "present": time.perf_counter() - drawn,
    }
    return stages, asked - begin - renderer.draw_s


def _print(report: dict[str, Any]) -> None:
    """The report for people: one figure a line."""
    sizes = report["size"] if report["theatre"] else [report["size"]]
    pixels = " + ".join(f"{width}x{height}" for width, height in sizes)
    print(f"{report['fish']} fishes, {report['visible_mean']:.1f} visible, {pixels}")
    print(f"motor {report['motor']}, {report['simulated_mean']:.1f} simulated")
    print(f"{report['renderer']}, quality {report['quality']} ({report['quality_drawn']})")
    for title in ("frame_ms", "stages_ms", "lod"):
        print(title)
        for name, value in report[title].items():
            print(f"  {name:<14}{value:>10.3f}")
    print(f"host_ms {report['host_ms']:.2f}, at most {report['draw_calls']} drawing calls a frame")
    print(f"triangles {report['triangles_mean']:.0f} a frame, {report['fps']:.1f} frames a second")


def _write(path: Path, report: dict[str, Any]) -> None:
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
