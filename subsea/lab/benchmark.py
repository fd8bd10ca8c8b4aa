"""`subsea benchmark`: time of every stage of a frame.

Formulas are in docs/developers/benchmarks.md.
"""

import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from tqdm import tqdm

from subsea import __version__
from subsea.base.errors import UserError
from subsea.base.file_kinds import PICTURE, check_result
from subsea.base.system import require
from subsea.dive import adaptive_quality
from subsea.dive.directed_camera import check_tour, tour_steering
from subsea.dive.start import headless, picture_maker, ready_world
from subsea.dive.tour import Steer
from subsea.frame.packet import Packet, pack
from subsea.lab import benchmark_reports
from subsea.rendering.output.quality import AUTO, LADDER, PRESETS, first_rung, name_of, on_software
from subsea.scenario.load import LoadedScenario, load_scenario
from subsea.scenario.schema import AUTOPILOT
from subsea.view.display_rigs import chosen_rig, cockpit
from subsea.view.levels import HIDDEN, LEVELS, empty_lod_state
from subsea.view.rig import CameraRig, views
from subsea.world.step import step
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.rendering.renderer import Renderer

WARM_UP_FRAMES = 30
LIVE_WARM_UP_TICKS = 900  # limit of the wait until all fishes to be simulated have finished turning


@dataclass(frozen=True, kw_only=True)
class BenchmarkOptions:
    """The measured runs, and the files for results."""

    scenario: str = "peaceful"
    changes: Sequence[str] = ()  # to the scenario, as in --set
    seed: int | None = None  # None: the scenario's
    fish: Sequence[int | None] = (None,)  # a run for each number; None: the scenario's
    motor: str = "playback"
    tour: str = AUTOPILOT  # one of the scenario's, "auto" or "directed"
    frames: int = 120
    without: frozenset[str] = frozenset()  # stages to leave out
    display: str = "mono"
    size: tuple[int, int] = (1280, 720)
    theatre: str | None = None  # instead of one picture of `size`
    shrink: int = 1  # the theatre's width and height are divided by this
    quality: str = "low"
    target_ms: float | None = None  # for the quality auto; None: by the renderer
    json: Path | None = None  # the report
    compare: Path | None = None  # an older report
    csv: Path | None = None  # the times of every frame
    plot: Path | None = None  # the same as a picture; needs matplotlib
    force: bool = False  # replace files of another kind


def benchmark(options: BenchmarkOptions) -> int:
    """Measure, print the report as a table and write the results; returns the exit code.

    Raises a UserError before anything is measured if something cannot be shown, read or written.
    """
    _check_results(options)
    if options.plot is not None:
        require("plot", "plots")
    older = benchmark_reports.read_reports(options.compare) if options.compare else None
    rig, _ = chosen_rig(
        options.display, options.size, theatre=options.theatre, shrink=options.shrink
    )
    loaded = load_scenario(options.scenario, options.changes)
    check_tour(loaded.scenario, options.tour)
    runs = [_run(options, loaded, rig, number) for number in options.fish]
    reports = [report for report, _ in runs]
    if len(runs) == 1:
        benchmark_reports.print_report(reports[0])
    else:
        benchmark_reports.print_ladder(reports)
    if older is not None and options.compare is not None:
        benchmark_reports.compare(reports, older, options.compare)
    if options.csv is not None:
        benchmark_reports.write_csv(options.csv, runs)
    if options.plot is not None:
        benchmark_reports.plot_stages(options.plot, runs)
    if options.json is not None:
        benchmark_reports.write_json(options.json, reports)
    return 0


def _check_results(options: BenchmarkOptions) -> None:
    """Raise a UserError unless each file can be written and is named once."""
    files = (
        (options.json, benchmark_reports.REPORT),
        (options.csv, benchmark_reports.TIMES),
        (options.plot, PICTURE),
    )
    taken: set[Path] = set()
    for path, kind in files:
        if path is None:
            continue
        check_result(path, kind, options.force)
        if path.resolve() in taken:
            raise UserError("two results cannot go into one file", file=path)
        taken.add(path.resolve())


def _run(
    options: BenchmarkOptions, loaded: LoadedScenario, rig: CameraRig, fish: int | None
) -> tuple[dict[str, Any], benchmark_reports.Frames]:
    """Measure with this number of fishes; the report and the frames."""
    automatic = options.quality == AUTO
    with headless() as context:
        world = ready_world(loaded, options.seed, fish=fish, motor=options.motor, levels=True)
        gpu, hold_ms = context.info["GL_RENDERER"], None
        machine = benchmark_reports.describe_machine(context.info)
        if automatic:
            hold_ms = options.target_ms or adaptive_quality.target_for(gpu)
        begin = LADDER[first_rung(gpu)] if automatic else PRESETS[options.quality]
        with picture_maker(context, world, rig, begin) as renderer:
            measured = measure(
                world, renderer, context, rig, options.tour, options.frames, options.without,
                hold_ms,
            )  # fmt: skip
            drawn = name_of(renderer.quality)
    sizes = [list(output) for output in rig.outputs]
    return {
        "renderer": gpu,
        "size": sizes if options.theatre else list(options.size),
        "theatre": options.theatre,
        "display": options.display,
        "quality": options.quality,
        "quality_drawn": drawn,
        "target_ms": hold_ms,
        "scenario": options.scenario,
        "set": [*options.changes],
        "tour": options.tour,
        "fish": len(world.state.fishes.species),
        "seed": world.state.seed,
        "version": __version__,
        "without": sorted(options.without),
        "motor": options.motor,
        "machine": machine,
        **benchmark_reports.statistics(measured),
    }, measured


def measure(
    world: World,
    renderer: "Renderer",
    context: Any,
    rig: CameraRig,
    tour: str,
    frames: int,
    without: frozenset[str] = frozenset(),
    hold_ms: float | None = None,
) -> benchmark_reports.Frames:
    """Measure `frames` of one tick and one picture each, after a warm-up.

    With `hold_ms` the quality adapts from frame to frame to hold that time.
    """
    steer: Steer = tour_steering(world, tour)
    for _ in range(LIVE_WARM_UP_TICKS if len(world.state.live.fish) else 0):
        able = world.dynamics.muscular[world.state.fishes.species]
        if world.state.fishes.live[able].all():
            break
        step(world, steer(world))
    columns: dict[str, list[float]] = defaultdict(list)
    stages: dict[str, list[float]] = defaultdict(list)
    gpu: dict[str, list[float]] = defaultdict(list)
    together = "sync" in without
    # A software renderer rasterises all stages tile by tile, so its queries overlap.
    on_gpu = not on_software(context.info["GL_RENDERER"])
    renderer.timer.on = on_gpu and not together
    levels = np.zeros((frames, len(LEVELS)))
    memory = empty_lod_state(len(world.state.fishes.species))
    pace = adaptive_quality.start(LADDER.index(renderer.quality), rig.exact) if hold_ms else None
    with benchmark_reports.reference_work() as fixed_work:
        for k in tqdm(range(-WARM_UP_FRAMES, frames), unit="frame", disable=None, leave=False):
            order = steer(world)  # not measured: in a dive the visitor steers
            fixed_s = fixed_work()
            cpu, thread, start = time.process_time(), time.thread_time(), time.perf_counter()
            step(world, order)
            packet = pack(
                world, views(rig, cockpit(world.state.submarine, 1.0)), 1.0,
                replace(
                    renderer.quality.packing,
                    culling="culling" not in without,
                    lod="lod" not in without,
                ),
                memory=memory,
            )  # fmt: skip
            packed = time.perf_counter()
            drawing, host_s = (
                _draw_beside(renderer, packet) if together else _draw(renderer, context, packet)
            )
            end = time.perf_counter()
            cpu, thread = time.process_time() - cpu, time.thread_time() - thread
            gpu_s = {"picture": renderer.gpu_s} if together else renderer.timer.seconds()
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
            for name, seconds in gpu_s.items() if on_gpu else ():
                gpu[name].append(seconds)
            levels[k] = np.bincount(memory.level[memory.level != HIDDEN], minlength=len(LEVELS))
            columns["simulated"].append(world.state.fishes.live.sum())
            columns["visible"].append(len(world.state.fishes.species) - packet.hidden)
            columns["triangles"].append(renderer.triangles)
            columns["draw_calls"].append(renderer.draw_calls)
    return benchmark_reports.Frames(
        stages_s={name: np.array(values) for name, values in stages.items()},
        gpu_s={name: np.array(values) for name, values in gpu.items()},
        levels=levels,
        **{name: np.array(values) for name, values in columns.items()},
    )


def _draw(renderer: "Renderer", context: Any, packet: Packet) -> tuple[dict[str, float], float]:
    """Draw a packet completely; seconds of the stages upload, draw and present.

    Also the seconds that the renderer spent outside its drawing calls.
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


def _draw_beside(renderer: "Renderer", packet: Packet) -> tuple[dict[str, float], float]:
    """As `_draw`, but return while the GPU draws; presenting is waiting for the picture before."""
    begin = time.perf_counter()
    renderer.draw(packet)
    renderer.timer.flush()
    waited_s, spent_s = renderer.waited_s, time.perf_counter() - begin
    stages = {
        "upload": renderer.upload_s,
        "draw": spent_s - renderer.upload_s - waited_s,
        "present": waited_s,
    }
    return stages, spent_s - renderer.draw_s - waited_s
