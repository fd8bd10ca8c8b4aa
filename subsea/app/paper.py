"""`subsea benchmark --paper`: tables 3 and 4 of SMC for this machine."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from subsea.app.benchmark import measure
from subsea.app.console import say
from subsea.app.start import headless, picture_maker, start_world
from subsea.biomechanics.body import build_body
from subsea.biomechanics.controllers import swim_contraction
from subsea.biomechanics.simulation import at_rest, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.kinematics.rotation import rotate
from subsea.ocean import step
from subsea.render.quality import PRESETS
from subsea.species import load_species
from subsea.state import Array, Fishes
from subsea.submarine.helm import HANDS_OFF
from subsea.world import World

DYNAMICS_1999_MS, PLAYBACK_1999_MS = 40.0, 0.01
FULL_1999_MS, REDUCED_1999_MS = 2340.0, 85.0
SIMULATED_TICKS = 400
PLAYED_FISH, PLAYED_TICKS = 1000, 60
RENDERED_FRAMES = 20
SIZE = (1280, 720)
SCENARIO = "peaceful"
UNIT = np.eye(3, dtype=np.float32)


def paper_tables() -> int:
    """Measure and print both tables; takes well under two minutes. Returns the exit code."""
    with headless():  # no OpenGL is told before anything is measured
        pass
    say("measuring the simulation of one fish")
    dynamics = dynamics_ms()
    say(f"measuring the playback of {PLAYED_FISH} fishes")
    playback, frame = playback_ms(start_world(SCENARIO, fish=PLAYED_FISH))
    say("measuring pictures")
    full, reduced, visible, renderer = rendering_ms()
    _table(
        "Table 3. CPU time for one fish and one frame (ms)",
        ("Dynamic simulation", DYNAMICS_1999_MS, dynamics),
        ("Synthetic motion capture", PLAYBACK_1999_MS, playback),
    )
    print(
        f"A fish out of sight, without nodes: {frame:.5f} ms, {dynamics / frame:.0f} times faster."
    )
    _table(
        f"Table 4. Time to draw a scene, about 40 fishes in sight in 1999, {visible:.0f} here (ms)",
        ("Without culling and levels of detail", FULL_1999_MS, full),
        ("With both", REDUCED_1999_MS, reduced),
    )
    print(f"1999: one 194 MHz R10000 with InfiniteReality. Here: {renderer}, {SIZE[0]}x{SIZE[1]}.")
    return 0


def dynamics_ms() -> float:
    """Milliseconds that one tick of one simulated fish takes: six steps of the whole body."""
    muscles = load_species("fusilier").muscles
    assert muscles
    body, swim = build_body(muscles.body), muscles.swim
    state = at_rest(body)
    steps = np.arange(SIMULATED_TICKS * STEPS_PER_TICK)
    phase = 2.0 * np.pi * steps / (swim.ticks_per_beat * STEPS_PER_TICK)
    contraction = swim_contraction(swim, phase)
    simulate(body, state, contraction[:STEPS_PER_TICK])  # compiles
    return 1000.0 * _seconds(lambda: simulate(body, state, contraction)) / SIMULATED_TICKS


def playback_ms(world: World) -> tuple[float, float]:
    """Milliseconds that one tick of one played-back fish takes: with all its nodes, and without.

    The first is the motor stage of the world and SMC eqs. 10-12 for all 23 nodes, as the paper
    counts it. The second is the motor stage alone: command, body frame and fins, which is all
    that a fish out of sight costs (SMC table 1).
    """
    fishes, library = world.state.fishes, world.library
    nodes = np.empty((len(fishes.species), *library.nodes.shape[1:]), np.float32)
    place_nodes(fishes, library.nodes, nodes)  # compiles
    motor, full = [], []
    for _ in range(PLAYED_TICKS):
        step(world, HANDS_OFF)
        placing = _seconds(lambda: place_nodes(fishes, library.nodes, nodes))
        motor.append(world.stages_s["motor"])
        full.append(world.stages_s["motor"] + placing)
    share = 1000.0 / len(fishes.species)
    return share * float(np.median(full)), share * float(np.median(motor))


@njit(cache=True)
def place_nodes(fishes: Fishes, nodes_body: Array, out: Array) -> None:
    """World nodes of all fishes into `out` (n, 23, 3), cm, from those of the library (eq. 12)."""
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


def rendering_ms() -> tuple[float, float, float, str]:
    """Milliseconds without and with culling and levels of detail, fishes in sight, renderer."""
    with headless() as context:
        name = context.info["GL_RENDERER"]
        world = start_world(SCENARIO)
        with picture_maker(context, world, SIZE, PRESETS["low"]) as renderer:
            without = frozenset(("culling", "lod"))
            full = measure(world, renderer, context, "mono", SIZE, RENDERED_FRAMES, without)
            reduced = measure(world, renderer, context, "mono", SIZE, RENDERED_FRAMES)
    return draw_ms(full), draw_ms(reduced), reduced["visible_mean"], name


def draw_ms(report: dict[str, Any]) -> float:
    """Time to draw a picture: the medians of the stages `upload` and `draw`, added."""
    return float(report["stages_ms"]["upload"] + report["stages_ms"]["draw"])


def _seconds(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _table(title: str, slow: tuple[str, float, float], fast: tuple[str, float, float]) -> None:
    print(f"\n{title}")
    print(f"{'':<40}{'1999':>12}{'here':>12}")
    for name, then, now in (slow, fast):
        print(f"{name:<40}{then:>12.4g}{now:>12.4g}")
    print(f"{'times faster':<40}{slow[1] / fast[1]:>12.4g}{slow[2] / fast[2]:>12.4g}")
