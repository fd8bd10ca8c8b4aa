"""`subsea benchmark --paper`: tables 3 and 4 of SMC for this machine."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from subsea import __version__
from subsea.base.arrays import Array
from subsea.base.progress import say
from subsea.biomechanics.body import build_body
from subsea.biomechanics.controllers import swim_contraction
from subsea.biomechanics.simulation import at_rest, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.dive.start import headless, picture_maker, start_world
from subsea.fish.species import load_species
from subsea.frame.packet import Packet, PackOptions, pack
from subsea.geometry.rotation import rotate
from subsea.kernels import kernel
from subsea.lab.benchmark_reports import describe_machine, machine_line
from subsea.rendering.output.quality import PRESETS
from subsea.state import Fishes
from subsea.submarine.vessel import NEUTRAL
from subsea.view.camera import View
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.view.rig import pose_from_angles
from subsea.world.step import step
from subsea.world.world import World

if TYPE_CHECKING:
    from subsea.rendering.renderer import Renderer

DYNAMICS_1999_MS, PLAYBACK_1999_MS = 40.0, 0.01
FULL_1999_MS, REDUCED_1999_MS = 2340.0, 85.0
SIMULATED_TICKS, GROUP_TICKS = 2000, 20
PLAYED_FISH, PLAYED_TICKS = 1000, 60
RENDERED = ("peaceful", "open-ocean")
IN_SIGHT_1999 = 40  # fishes
HEADINGS = 72  # tried to find a view of IN_SIGHT_1999 fishes
AWAKE_TICKS = 30
REDUCED_PICTURES, FULL_PICTURES = 15, 3
MAX_DRAWING_S = 12.0  # no further picture of a kind starts after this time
SIZE = (1280, 720)
SCENARIO = "peaceful"
UNIT = np.eye(3, dtype=np.float32)


def paper_tables() -> int:
    """Measure and print both tables; takes well under two minutes. Returns the exit code."""
    with headless() as context:  # missing OpenGL is reported before anything is measured
        machine, renderer = describe_machine(context.info), context.info["GL_RENDERER"]
    say("measuring the simulation of one fish")
    dynamics = dynamics_ms()
    say(f"measuring the playback of {PLAYED_FISH} fishes")
    playback, frame = playback_ms(start_world(SCENARIO, fish=PLAYED_FISH))
    say("measuring pictures")
    drawn = [rendering_ms(scenario) for scenario in RENDERED]
    _table(
        "Table 3. CPU time for one fish and one frame (ms)",
        ("1999", "here"),
        ("Dynamic simulation", DYNAMICS_1999_MS, dynamics),
        ("Synthetic motion capture", PLAYBACK_1999_MS, playback),
    )
    print(
        f"A fish out of sight, without nodes: {frame:.5f} ms, {dynamics / frame:.0f} times faster."
    )
    _table(
        "Table 4. Time to draw a scene with about 40 fishes in sight (ms)",
        ("1999", *(scene.title for scene in drawn)),
        ("Without culling and levels of detail", FULL_1999_MS, *(scene.full_ms for scene in drawn)),
        ("With both", REDUCED_1999_MS, *(scene.reduced_ms for scene in drawn)),
    )
    _table(
        "The same in processor time of all threads (ms)",
        ("", *(scene.title for scene in drawn)),
        ("Without culling and levels of detail", "", *(scene.full_cpu_ms for scene in drawn)),
        ("With both", "", *(scene.reduced_cpu_ms for scene in drawn)),
    )
    for scene in drawn:
        print(f"{scene.title}: {scene.in_sight} of {scene.fishes} fishes in sight.")
    print("1999: one 194 MHz R10000 with InfiniteReality.")
    print(f"Here: subsea {__version__}, {renderer}, {SIZE[0]}x{SIZE[1]}, quality low;")
    print(f"{machine_line(machine)}.")
    return 0


def dynamics_ms() -> float:
    """Measure milliseconds for one tick of one simulated fish: six steps of the whole body."""
    muscles = load_species("fusilier").muscles
    assert muscles
    body, swim = build_body(muscles.body), muscles.swim
    state = at_rest(body)
    steps = np.arange(SIMULATED_TICKS * STEPS_PER_TICK)
    phase = 2.0 * np.pi * steps / (swim.ticks_per_beat * STEPS_PER_TICK)
    contraction = swim_contraction(swim, phase)
    simulate(body, state, contraction[:STEPS_PER_TICK])  # compiles
    groups = np.split(contraction, SIMULATED_TICKS // GROUP_TICKS)
    took = [_seconds(partial(simulate, body, state, group)) for group in groups]
    return 1000.0 * float(np.median(took)) / GROUP_TICKS


def playback_ms(world: World) -> tuple[float, float]:
    """Measure milliseconds for one tick of one played-back fish, with and without its nodes.

    The first is the motor stage of the world and SMC eqs. 10-12 for all 23 nodes, as in the paper.
    The second is the motor stage alone: command, body frame and fins, the full cost of a fish out
    of sight (SMC table 1).
    """
    fishes, library = world.state.fishes, world.library
    nodes = np.empty((len(fishes.species), *library.nodes.shape[1:]), np.float32)
    place_nodes(fishes, library.nodes, nodes)  # compiles
    motor, full = [], []
    for _ in range(PLAYED_TICKS):
        step(world, NEUTRAL)
        placing = _seconds(lambda: place_nodes(fishes, library.nodes, nodes))
        motor.append(world.stages_s["motor"])
        full.append(world.stages_s["motor"] + placing)
    share = 1000.0 / len(fishes.species)
    return share * float(np.median(full)), share * float(np.median(motor))


@kernel
def place_nodes(fishes: Fishes, nodes_body: Array, out: Array) -> None:
    """Write world nodes of all fishes to `out` (n, 23, 3), cm, from recorded ones (SMC eq. 12)."""
    axes = np.empty((3, 3), np.float32)
    for i in range(len(out)):
        a, b, w = fishes.row_a[i], fishes.row_b[i], fishes.weight[i]
        for k in range(3):  # columns of the rotation, scaled
            turned = rotate(fishes.orientation[i], UNIT[k])
            for axis in range(3):
                axes[axis, k] = fishes.scale[i] * turned[axis]
        for k in range(out.shape[1]):
            for axis in range(3):
                out[i, k, axis] = fishes.position[i, axis]
            for j in range(3):
                body = (1.0 - w) * nodes_body[a, k, j] + w * nodes_body[b, k, j]
                for axis in range(3):
                    out[i, k, axis] += axes[axis, j] * body


class RenderingTimes(NamedTuple):
    """Times to draw a scene in full, and with culling and levels of detail."""

    title: str
    fishes: int
    in_sight: int
    full_ms: float  # without culling and levels of detail
    reduced_ms: float  # with both
    full_cpu_ms: float  # the same in processor time of all threads
    reduced_cpu_ms: float


def rendering_ms(scenario: str) -> RenderingTimes:
    """Measure the drawing of a scenario with about 40 fishes in sight."""
    with headless() as context:
        world = start_world(scenario)
        for _ in range(AWAKE_TICKS):
            step(world, NEUTRAL)
        views = view_of(world, IN_SIGHT_1999)
        quality = PRESETS["low"]
        with picture_maker(context, world, display_rig("mono", SIZE), quality) as renderer:
            packet = pack(world, views, 1.0, options=quality.packing)
            reduced, reduced_cpu = drawing_ms(renderer, context, packet, REDUCED_PICTURES)
            renderer.adapt(replace(quality, detail=np.inf))  # for static objects
            everything = pack(
                world, views, 1.0, PackOptions(growth=quality.growth, culling=False, lod=False)
            )
            full, full_cpu = drawing_ms(renderer, context, everything, FULL_PICTURES)
    return RenderingTimes(
        world.scenario.title, len(world.state.fishes.species), len(packet.instances),
        full, reduced, full_cpu, reduced_cpu,
    )  # fmt: skip


def view_of(world: World, number: int) -> tuple[View, ...]:
    """Find the view from the submarine with closest to `number` fishes in sight."""
    eye = cockpit(world.state.submarine, 1.0).eye
    sights = [
        views_for("mono", SIZE, pose_from_angles(eye, heading, 0.0))
        for heading in np.linspace(0.0, 2 * np.pi, HEADINGS, endpoint=False)
    ]
    return min(sights, key=lambda views: abs(len(pack(world, views, 1.0).instances) - number))


def drawing_ms(
    renderer: "Renderer", context: Any, packet: Packet, pictures: int
) -> tuple[float, float]:
    """Measure median wall and processor time to upload and draw a packet, ms.

    Draws the given number of pictures, or fewer within MAX_DRAWING_S. The first, for which drivers
    compile, counts only if it is the only one.
    """
    took: list[tuple[float, float]] = []
    begun = time.perf_counter()
    while (len(took) <= pictures and time.perf_counter() - begun < MAX_DRAWING_S) or not took:
        start, cpu = time.perf_counter(), time.process_time()
        renderer.draw(packet)
        context.finish()
        took.append((time.perf_counter() - start, time.process_time() - cpu))
    clock, processor = 1000.0 * np.median(took[1:] or took, axis=0)
    return float(clock), float(processor)


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _table(
    title: str, columns: tuple[str, ...], slow: tuple[Any, ...], fast: tuple[Any, ...]
) -> None:
    """Print two rows of a name and its figures, and the speedup; unnamed columns are empty."""
    ratios = [
        a / b if column else "" for column, a, b in zip(columns, slow[1:], fast[1:], strict=True)
    ]
    print(f"\n{title}")
    print(f"{'':<40}" + "".join(f"{column:>14}" for column in columns))
    for name, *figures in (slow, fast, ("times faster", *ratios)):
        told = [f"{figure:.4g}" if figure else "" for figure in figures]
        print(f"{name:<40}" + "".join(f"{word:>14}" for word in told))
