"""`subsea benchmark`: how long every stage of a frame takes. docs/diving.md has the formulas."""

import time
from collections import defaultdict
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from tqdm import tqdm

from subsea.core.atomic_io import check_file
from subsea.core.errors import UserError
from subsea.dive import adaptive_quality
from subsea.dive.directed_camera import check_tour, guided
from subsea.dive.start import headless, picture_maker, start_world
from subsea.dive.theatre_setup import chosen_rig
from subsea.dive.tour import Steer
from subsea.frame.packet import Packet, pack
from subsea.profiling.comparison import compare, read_reports
from subsea.profiling.frame_statistics import (
    Frames,
    figures,
    print_ladder,
    print_report,
    write_csv,
    write_json,
)
from subsea.profiling.machine import described, yardstick
from subsea.render.output.quality import AUTO, LADDER, PRESETS, first_rung, name_of
from subsea.scenario.schema import AUTOPILOT, load_scenario
from subsea.view.display_rigs import cockpit
from subsea.view.levels import HIDDEN, LEVELS, empty_lod_state
from subsea.view.rig import CameraRig, views
from subsea.world.step import step
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.render import Renderer

WARM_UP_FRAMES = 30
LIVE_WARM_UP_TICKS = 900  # at most, until all that are to be simulated have come out of turns


def benchmark(
    scenario: str,
    fish: Sequence[int] | None,
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
    tour: str = AUTOPILOT,
    against: Path | None = None,
    csv: Path | None = None,
    plot: Path | None = None,
) -> int:
    """Measure, print the report as a table, and write it as JSON to `out` if that is named.

    With several numbers of `fish` one run follows another, and the table has a row for each.
    `tour` is one of the scenario's, "auto" or "directed". A `theatre` is shown instead of one
    picture of `size`, `shrink` times smaller. The report is set `against` an older one; `csv`
    takes what every frame took, `plot` a picture of it (needs matplotlib).

    Raises:
        UserError: for what cannot be shown, read or written; before anything is measured.

    """
    files = [path for path in (out, csv, plot) if path is not None]
    for k, path in enumerate(files):
        check_file(path)
        if path.resolve() in [other.resolve() for other in files[:k]]:
            raise UserError(f"{path}: two results cannot go into one file")
    if plot is not None:
        from subsea.study.plots import check_plots

        check_plots()
    older = read_reports(against) if against else None
    rig, _ = chosen_rig(display, size, theatre=theatre, shrink=shrink)
    chosen, _ = load_scenario(scenario, changes)
    check_tour(chosen, tour)
    runs: list[tuple[dict[str, Any], Frames]] = []
    for number in fish or (None,):
        with headless() as context:
            world = start_world(scenario, seed, number, motor=motor, changes=changes)
            gpu, hold_ms = context.info["GL_RENDERER"], None
            machine = described(context.info)
            if quality == AUTO:
                hold_ms = target_ms or adaptive_quality.target_for(gpu)
            begin = LADDER[first_rung(gpu)] if quality == AUTO else PRESETS[quality]
            with picture_maker(context, world, rig, begin) as renderer:
                measured = measure(world, renderer, context, rig, tour, frames, without, hold_ms)
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
            "tour": tour,
            "fish": len(world.state.fishes.species),
            "seed": world.state.seed,
            "version": version("subsea"),
            "without": sorted(without),
            "motor": motor,
            "machine": machine,
            **figures(measured),
        }
        runs.append((report, measured))
    reports = [report for report, _ in runs]
    if len(runs) == 1:
        print_report(reports[0])
    else:
        print_ladder(reports)
    if older is not None and against is not None:
        compare(reports, older, against)
    if csv is not None:
        write_csv(csv, runs)
    if plot is not None:
        from subsea.profiling.stages_plot import plot_stages

        plot_stages(plot, runs)
    if out is not None:
        write_json(out, reports)
    return 0


def measure(
    world: World,
    renderer: "Renderer",
    context: Any,
    rig: CameraRig,
    tour: str,
    frames: int,
    without: frozenset[str] = frozenset(),
    hold_ms: float | None = None,
) -> Frames:
    """What each of `frames` takes and shows: one tick and one picture, after a warm-up.

    The submarine goes on the `tour`, see `check_tour`. With `hold_ms` the quality
    changes from frame to frame, to hold that time; None keeps it.
    """
    steer: Steer = guided(world, tour)
    for _ in range(LIVE_WARM_UP_TICKS if len(world.state.live.fish) else 0):
        able = world.dynamics.muscular[world.state.fishes.species]
        if world.state.fishes.live[able].all():
            break
        step(world, steer(world))
    columns: dict[str, list[float]] = defaultdict(list)
    stages: dict[str, list[float]] = defaultdict(list)
    levels = np.zeros((frames, len(LEVELS)))
    memory = empty_lod_state(len(world.state.fishes.species))
    pace = adaptive_quality.start(LADDER.index(renderer.quality), rig.exact) if hold_ms else None
    with yardstick() as beside:
        for k in tqdm(range(-WARM_UP_FRAMES, frames), unit="frame", disable=None, leave=False):
            order = steer(world)  # a visitor's hands would take no time of the program's
            fixed_s = beside()
            cpu, thread, start = time.process_time(), time.thread_time(), time.perf_counter()
            step(world, order)
            packet = pack(
                world, views(rig, cockpit(world.state.submarine, 1.0)), 1.0,
                culling="culling" not in without, lod="lod" not in without,
                detail=renderer.quality.detail, growth=renderer.quality.growth, memory=memory,
            )  # fmt: skip
            packed = time.perf_counter()
            drawing, host_s = _draw(renderer, context, packet)
            end = time.perf_counter()
            cpu, thread = time.process_time() - cpu, time.thread_time() - thread
            if pace and hold_ms:
                pace = adaptive_quality.paced(pace, 1000.0 * (end - start), hold_ms)
                if LADDER[pace.rung] != renderer.quality:
                    renderer.adapt(LADDER[pace.rung])
            if k < 0:
                continue
            columns["frame_s"].append(end - start)
            columns["host_s"].append(packed - start + host_s)
            columns["cpu_s"].append(cpu)
            columns["thread_s"].append(thread)
            columns["yardstick_s"].append(fixed_s)
            for name, seconds in (world.stages_s | drawing).items():
                stages[name].append(seconds)
            levels[k] = np.bincount(memory.level[memory.level != HIDDEN], minlength=len(LEVELS))
            columns["simulated"].append(world.state.fishes.live.sum())
            columns["visible"].append(len(world.state.fishes.species) - packet.hidden)
            columns["triangles"].append(renderer.triangles)
            columns["draw_calls"].append(renderer.draw_calls)
    return Frames(
        stages_s={name: np.array(values) for name, values in stages.items()},
        levels=levels,
        **{name: np.array(values) for name, values in columns.items()},
    )


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
