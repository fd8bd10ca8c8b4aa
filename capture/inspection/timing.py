"""Time a step of simulation and a frame of replay on this computer, in microseconds."""

from collections.abc import Callable
from time import perf_counter

import numpy as np

from subsea.biomechanics.body import MUSCLES, NODES, Body, Floats
from subsea.biomechanics.simulation import BodyState, copy_state, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, advance
from subsea.geometry.rotation import matrix
from subsea.kernels import kernel
from subsea.repertoire import Segment

ROUNDS = 25
STEPS = 400
FRAMES = 4_000


def step_cost(body: Body, state: BodyState) -> float:
    """Microseconds of one compiled step of a moving fish with constant muscles."""
    simulate(body, copy_state(state), np.zeros((STEPS_PER_TICK, MUSCLES)))  # compiles
    muscles = np.tile(body.length[:MUSCLES], (STEPS, 1))

    def swim() -> None:
        x, v, watch = copy_state(state)
        still, none = np.zeros(3), np.zeros((NODES, 3))
        advance(x, v, body.material, muscles, still, none, STEP, watch)

    return fastest_us(swim) / STEPS


def replay_cost(segment: Segment) -> float:
    """Microseconds of replaying one frame with all 23 nodes (SMC eqs. 10-12)."""
    return _replay_cost(segment, np.ascontiguousarray(segment.nodes))


def frame_cost(segment: Segment) -> float:
    """Microseconds of replaying only the body frame, as for invisible fishes (SMC §5.3)."""
    return _replay_cost(segment, np.zeros((len(segment.nodes), 0, 3)))


def _replay_cost(segment: Segment, nodes: Floats) -> float:
    turns = np.ascontiguousarray(matrix(segment.increment_rotation))
    steps = np.ascontiguousarray(segment.increment_translation)
    out = np.empty(nodes.shape[1:])
    _replay(turns, steps, nodes, 1, out)  # compiles
    return fastest_us(lambda: _replay(turns, steps, nodes, FRAMES, out)) / FRAMES


def fastest_us(run: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Microseconds of the fastest round, which other processes disturb least."""
    times = []
    for _ in range(rounds):
        start = perf_counter()
        run()
        times.append(perf_counter() - start)
    return min(times) * 1e6


@kernel
def _replay(turns: Floats, steps: Floats, nodes: Floats, frames: int, out: Floats) -> float:
    origin = np.zeros(3)
    rotation = np.eye(3)
    turned = np.empty((3, 3))
    for frame in range(frames):
        k = frame % len(turns)
        for i in range(3):
            for j in range(3):
                origin[i] += rotation[i, j] * steps[k, j]
                turned[i, j] = (
                    rotation[i, 0] * turns[k, 0, j]
                    + rotation[i, 1] * turns[k, 1, j]
                    + rotation[i, 2] * turns[k, 2, j]
                )
        rotation[:] = turned
        for node in range(nodes.shape[1]):
            x, y, z = nodes[k, node, 0], nodes[k, node, 1], nodes[k, node, 2]
            for i in range(3):
                out[node, i] = (
                    origin[i] + rotation[i, 0] * x + rotation[i, 1] * y + rotation[i, 2] * z
                )
    return origin[0]
