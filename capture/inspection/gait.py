"""Measures of a gait or a turn by simulation, and the time that a step and a frame take here."""

from collections.abc import Callable
from time import perf_counter

import numpy as np

from subsea.biomechanics.body import MUSCLES, NODES, UNITS, Body, Floats
from subsea.biomechanics.body_plan import SwimPlan, TurnPlan
from subsea.biomechanics.controllers import (
    LEFT,
    muscle_lengths,
    swim_contraction,
    turn_contraction,
)
from subsea.biomechanics.fins import contraction_step, headings
from subsea.biomechanics.simulation import (
    BodyState,
    copy_state,
    is_sound,
    simulate,
)
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK, advance
from subsea.biomechanics.trial import beat_phase, sharp_turn
from subsea.geometry.rotation import matrix
from subsea.kernels import kernel
from subsea.repertoire import Segment

ENTRY_PHASES = 7
SETTLE_BEATS = 6  # beats after a turn; the new heading is measured in the last one


def swim_beats(body: Body, state: BodyState, beat: Floats, count: int) -> Floats:
    """Nodes (count × T + 1, 23, 3) of ``count`` more beats of contractions; changes ``state``."""
    start = state.x.copy()
    return np.concatenate([start[None], simulate(body, state, np.tile(beat, (count, 1)))])


def turn_contraction_step(body: Body, swim: SwimPlan, turn: TurnPlan, angles: list[float]) -> float:
    """Greatest change of a muscle's rest length in one step, cm, in any of several sharp turns."""
    return max(contraction_step(body, turn_contraction(swim, turn, angle)) for angle in angles)


def entries(body: Body, swim: SwimPlan, steady: BodyState) -> list[tuple[BodyState, float]]:
    """States and phases of steady swimming at grade medium, evenly over a beat."""
    swim = swim.at("medium")
    found = []
    for k in range(ENTRY_PHASES):
        state = copy_state(steady)
        ticks = round(k * swim.ticks_per_beat / ENTRY_PHASES)
        simulate(body, state, swim_contraction(swim, beat_phase(swim, ticks), swim.medium))
        found.append((state, 2 * np.pi * ticks / swim.ticks_per_beat))
    return found


def turned(
    body: Body,
    swim: SwimPlan,
    turn: TurnPlan,
    angle: float,
    start: BodyState,
    phase: float = 0.0,
    settle: int = SETTLE_BEATS,
) -> float:
    """Degrees by which a turn changes the mean heading of steady swimming, left positive.

    The new heading is the mean over the last of ``settle`` beats after the turn. NaN where the
    body loses its shape after the turn; UserError where it does so within.
    """
    gait = swim.at("medium")
    beat = swim_contraction(gait, phase + beat_phase(gait, gait.ticks_per_beat), gait.medium)
    before = simulate(body, copy_state(start), beat)
    trial = sharp_turn(body, swim, turn, angle, LEFT, start, phase)
    after = simulate(body, trial.state, np.tile(beat, (settle, 1)))
    if not is_sound(trial.state):
        return float("nan")
    heading = headings(np.concatenate([before[:1], trial.frames, after]))
    return float(heading[-gait.ticks_per_beat :].mean() - headings(before).mean())


def muscle_work(body: Body, state: BodyState, contraction: Floats) -> float:
    """Work, g cm²/tu², that the muscles do while they follow ``contraction``; changes ``state``.

    The sum over muscles of tension × shortening. Tension is that of the spring, c (l - l_rest)
    with the contracted l_rest; the damper belongs to the passive body. A muscle that is stretched
    does negative work, so over a steady beat the sum is the work on water and viscosity.
    """
    start = state.x[None].copy()
    frames = np.concatenate([start, simulate(body, state, contraction, every=1)])
    rests = muscle_lengths(body, contraction)
    return tension_work(body.stiffness[:MUSCLES], _muscle_spans(frames), rests)


def tension_work(stiffness: Floats, lengths: Floats, rests: Floats) -> float:
    """Work of springs (m,) with ``lengths`` (T + 1, m) and rest lengths (T, m)."""
    middle = (lengths[1:] + lengths[:-1]) / 2
    return float(-(stiffness * (middle - rests) * np.diff(lengths, axis=0)).sum())


def _muscle_spans(x: Floats) -> Floats:
    """Lengths (…, 12) of the muscles of nodes (…, 23, 3)."""
    i, j = UNITS[:MUSCLES].T
    return np.asarray(np.linalg.norm(x[..., j, :] - x[..., i, :], axis=-1))


def speed_kept(body: Body, frames: Floats) -> float:
    """The least speed of the centre of mass in ``frames``, as a fraction of the first."""
    speed = np.linalg.norm(np.diff(body.mass @ frames, axis=0), axis=1)
    return float(speed.min() / speed[0])


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
