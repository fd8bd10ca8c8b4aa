"""How good a recorded motion is: measures beside what docs/biomechanics.md asks of them.

Everything here but the cost swims the fish again, from the plans in a repertoire's provenance.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from capture.cost import frame_cost, replay_cost, step_cost
from capture.record import Motion, run_trial, steady_contraction
from capture.trial import Trial, beat_contraction, beat_phase, sharp_turn, speed_map, way
from subsea.biomechanics.body import LOWER_TAIL, UPPER_TAIL, Body, Floats, build_body
from subsea.biomechanics.controllers import LEFT, S_MAX, muscle_lengths, swim_contraction
from subsea.biomechanics.fins import UP, balance, pectoral_force
from subsea.biomechanics.simulation import (
    STILL,
    State,
    at_rest,
    copy_state,
    is_sound,
    simulate,
)
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.kinematics.frame import Array, body_frame, to_world
from subsea.kinematics.rotation import matrix
from subsea.repertoire import Repertoire, Segment

STEADY_BEATS = 20
REPLAYED_CYCLES = 10
TURN_ANGLES = (30.0, 45.0, 60.0, 90.0)
ENTRY_PHASES = 7
FIN_AREA = 0.01
"""Area of a pectoral fin over the square of the body length."""
LEAN = np.radians(15.0)


class Measure(NamedTuple):
    """One line of the report: the measured value, what is asked at least, and the verdict."""

    name: str
    value: str
    at_least: str
    passed: bool


def replay(segment: Segment, origin: Array, rotation: Array, cycles: int) -> Floats:
    """World nodes (cycles × T, 23, 3) of a segment played back from a start (SMC eqs. 10-12)."""
    turns = matrix(segment.increment_rotation)
    frames = []
    for _ in range(cycles):
        for turn, step, nodes in zip(
            turns, segment.increment_translation, segment.nodes, strict=True
        ):
            origin = origin + rotation @ step
            rotation = rotation @ turn
            frames.append(to_world(nodes, origin, rotation))
    return np.array(frames)


def swim_on(body: Body, state: State, beat: Floats, count: int) -> Floats:
    """Nodes (count × T + 1, 23, 3) of ``count`` more beats of contractions; changes ``state``."""
    start = state.x.copy()
    return np.concatenate([start[None], simulate(body, state, np.tile(beat, (count, 1)))])


def measure(motion: Motion, repertoire: Repertoire) -> Iterator[Measure]:
    """All measures of a repertoire, one after another as they are taken."""
    body = build_body(motion.body)
    length = motion.body.length
    trials = {name: run_trial(motion, name) for name in repertoire.segments}
    yield from _swimming(motion, body, trials)
    yield from _straightness(motion, body, trials["swim_fast"].state)
    yield from _attitude(motion, body, trials["swim_medium"].state)
    yield from _turning(motion, body, trials["swim_medium"].state)
    cyclic = [name for name, segment in repertoire.segments.items() if segment.cyclic]
    closure = max(repertoire.segments[name].loop_error_bl for name in cyclic)
    yield Measure("loop closure, worst cycle", f"{closure:.1e} L", "≤ 1e-3 L", closure <= 1e-3)
    error = max(
        _replay_error(motion, body, trials[name], repertoire.segments[name], name)
        for name in cyclic
    )
    name = f"{REPLAYED_CYCLES} cycles replayed against simulation"
    yield Measure(name, f"{error / length:.1e} L", "≤ 1e-2 L", error <= 1e-2 * length)
    step, nodes, frame = (
        step_cost(body, trials["swim_fast"].state),
        replay_cost(repertoire.segments["swim_fast"]),
        frame_cost(repertoire.segments["swim_fast"]),
    )
    yield Measure("one step of simulation", f"{step:.2f} µs", "≤ 5 µs", step <= 5)
    yield Measure("replay of 23 nodes", f"{nodes:.3f} µs", "≤ 0.15 µs", nodes <= 0.15)
    yield Measure("replay of a body frame", f"{frame:.3f} µs", "≤ 0.03 µs", frame <= 0.03)
    ratio = STEPS_PER_TICK * step / nodes
    yield Measure("a tick simulated over one replayed", f"{ratio:.0f} ×", "", True)


def _swimming(motion: Motion, body: Body, trials: dict[str, Trial]) -> Iterator[Measure]:
    length, ticks = motion.body.length, motion.swim.ticks_per_beat
    beat_tu = ticks * STEPS_PER_TICK * STEP
    speeds = {
        grade: float(np.linalg.norm(way(trials[f"swim_{grade}"].frames))) / length
        for grade in ("slow", "medium", "fast")
    }
    fast = speeds["fast"]
    yield Measure("fast swim, per beat", f"{fast:.3f} L", "≥ 0.35 L", fast >= 0.35)
    rate = fast / beat_tu
    yield Measure("fast swim, per tu (0.1 s)", f"{rate:.4f} L", "≥ 0.08 L", rate >= 0.08)
    muscles = muscle_lengths(body, beat_contraction(motion.swim, 1.0))
    s = float(np.abs(np.diff(muscles, axis=0)).max())
    yield Measure("its contraction a step", f"{s:.4f} cm", f"≤ {S_MAX:g} cm", s <= S_MAX)
    for slow, quick in (("slow", "medium"), ("medium", "fast")):
        ratio = speeds[quick] / speeds[slow]
        yield Measure(f"{quick} over {slow}", f"{ratio:.2f} ×", "≥ 1.4 ×", ratio >= 1.4)
    levels, swum = (column[1:] for column in speed_map(body, motion.swim))
    fit = float(np.corrcoef(levels, swum)[0, 1] ** 2)
    steady = bool((np.diff(swum) > 0).all())
    text = f"{'monotone' if steady else 'not monotone'}, R² {fit:.3f}"
    yield Measure("speed over 10 amplitudes", text, "monotone", steady)
    trial = trials["swim_fast"]
    tail = _sweep(trial, [UPPER_TAIL, LOWER_TAIL]) / length
    head = _sweep(trial, [0]) / length
    yield Measure("tail sweep, fast", f"{tail:.3f} L", "0.15-0.25 L", 0.15 <= tail <= 0.25)
    yield Measure("head sweep, fast", f"{head:.3f} L", "", True)
    snout = _snout_bend(trial.frames)
    yield Measure("bend of the snout, fast", f"{snout:.1f}°", "", True)
    strouhal = tail / fast
    yield Measure("Strouhal number, fast", f"{strouhal:.3f}", "≤ 0.55", strouhal <= 0.55)


def _sweep(trial: Trial, nodes: list[int]) -> float:
    """Peak-to-peak distance of the middle of ``nodes`` across the way of one beat, cm."""
    chord = way(trial.frames)
    aside = np.cross(UP, chord / np.linalg.norm(chord))
    across = trial.frames[:, nodes].mean(axis=1) @ aside
    drift = np.linspace(0.0, across[-1] - across[0], len(across))
    return float(np.ptp(across - drift))


def _snout_bend(frames: Floats) -> float:
    """Greatest angle in degrees between the snout and the head behind it, which should be stiff."""
    nose, first, second = frames[:, 0], frames[:, 1:5].mean(axis=1), frames[:, 5:9].mean(axis=1)
    return max(
        float(np.degrees(_angle(snout, head)))
        for snout, head in zip(nose - first, first - second, strict=True)
    )


def _straightness(motion: Motion, body: Body, steady: State) -> Iterator[Measure]:
    frames = swim_on(body, copy_state(steady), beat_contraction(motion.swim, 1.0), STEADY_BEATS)
    centres = frames[:: motion.swim.ticks_per_beat].mean(axis=1)
    steps = np.diff(centres, axis=0)
    drift = float(np.degrees(_angle(steps[0], steps[-1])))
    way = (centres[-1] - centres[0]) / np.linalg.norm(centres[-1] - centres[0])
    offset = centres - centres[0]
    aside = np.linalg.norm(offset - np.outer(offset @ way, way), axis=1).max()
    aside = float(aside) / motion.body.length
    name = f"drift of heading in {STEADY_BEATS} beats"
    yield Measure(name, f"{drift:.4f}°", "≤ 1°", drift <= 1)
    yield Measure("drift aside meanwhile", f"{aside:.1e} L", "≤ 0.02 L", aside <= 0.02)


def _angle(a: Floats, b: Floats) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _attitude(motion: Motion, body: Body, steady: State) -> Iterator[Measure]:
    beat = beat_contraction(motion.swim, motion.swim.medium)
    roll, pitch = _mean_attitude(swim_on(body, copy_state(steady), beat, STEADY_BEATS))
    text = f"{roll:.4f}°, {pitch:.4f}°"
    yield Measure("roll, pitch without fins", text, "≤ 0.1°", max(roll, pitch) <= 0.1)
    tall = build_body(motion.body, back=1.1)
    roll, pitch = _balanced(motion, tall, at_rest(tall), 60)
    text = f"{roll:.3f}°, {pitch:.3f}°"
    yield Measure("the same, back 10% taller, balanced", text, "≤ 1°", max(roll, pitch) <= 1)
    leaning = copy_state(steady)
    _lean(leaning, body.mass)
    roll, pitch = _balanced(motion, body, leaning, 40)
    text = f"{roll:.3f}°, {pitch:.3f}°"
    yield Measure("40 beats after a roll of 15°, balanced", text, "≤ 1°", max(roll, pitch) <= 1)


def _mean_attitude(frames: Floats) -> tuple[float, float]:
    """Roll and pitch in degrees, positive, averaged over whole beats.

    The frame B of an upright body sways within a beat, so only the mean tells its attitude.
    """
    rotation = body_frame(frames)[1]
    roll, pitch = (np.degrees(np.arcsin(np.mean(rotation[1:, 1, axis]))) for axis in (2, 0))
    return abs(float(roll)), abs(float(pitch))


def _lean(state: State, mass: Floats) -> None:
    """Roll a swimming fish about its way."""
    way = mass @ state.v
    axis = way / np.linalg.norm(way)
    turn = matrix(np.concatenate([[np.cos(LEAN / 2)], np.sin(LEAN / 2) * axis]))
    state.x[:] = state.x @ turn.T
    state.v[:] = state.v @ turn.T


def _balanced(motion: Motion, body: Body, state: State, count: int) -> tuple[float, float]:
    """Roll and pitch of the last of ``count`` beats swum at grade medium with balancing fins."""
    swim = motion.swim
    beat = beat_contraction(swim, swim.medium)
    area = FIN_AREA * motion.body.length**2
    frames = []
    for _ in range(count):
        frames = [state.x.copy()]
        for tick in np.split(beat, swim.ticks_per_beat):
            force = pectoral_force(state, area, *balance(state), STILL)
            frames.extend(simulate(body, state, tick, force=force))
    return _mean_attitude(np.array(frames))


def _turning(motion: Motion, body: Body, steady: State) -> Iterator[Measure]:
    entries = []
    for k in range(ENTRY_PHASES):
        state = copy_state(steady)
        ticks = round(k * motion.swim.ticks_per_beat / ENTRY_PHASES)
        phase = beat_phase(motion.swim, ticks)
        simulate(body, state, swim_contraction(motion.swim, phase, motion.swim.medium))
        entries.append((state, 2 * np.pi * ticks / motion.swim.ticks_per_beat))
    for angle in TURN_ANGLES:
        errors = [_turned(motion, body, angle, *entry) - angle for entry in entries]
        allowed, spread = (3, 7) if angle <= 60 else (6, 10)
        worst = max(errors, key=abs)
        yield Measure(
            f"turn of {angle:g}°, entered at phase 0",
            f"{errors[0]:+.2f}°",
            f"± {allowed}°",
            abs(errors[0]) <= allowed,
        )
        yield Measure(
            f"turn of {angle:g}°, at the worst phase",
            f"{worst:+.2f}°",
            f"± {spread}°",
            abs(worst) <= spread,
        )
    sharp = run_trial(motion, "turn_left_sharp").frames
    speed = np.linalg.norm(np.diff(body.mass @ sharp, axis=0), axis=1)
    kept = float(speed.min() / speed[0])
    yield Measure("speed kept in the sharp turn", f"{kept:.2f} ×", "", True)


def _turned(motion: Motion, body: Body, angle: float, start: State, phase: float) -> float:
    """Degrees by which a turn changes the mean heading of steady swimming, left positive."""
    swim = motion.swim
    beat = swim_contraction(swim, phase + beat_phase(swim, swim.ticks_per_beat), swim.medium)
    before = simulate(body, copy_state(start), beat)
    trial = sharp_turn(body, swim, motion.turn, angle, LEFT, start, phase)
    after = simulate(body, trial.state, np.tile(beat, (6, 1)))
    if not is_sound(trial.state):
        return float("nan")
    headings = _headings(np.concatenate([before[:1], trial.frames, after]))
    mean_before = _headings(before).mean()
    return float(headings[-swim.ticks_per_beat :].mean() - mean_before)


def _headings(frames: Floats) -> Floats:
    """Heading of the body frame in degrees, left positive, without jumps."""
    forward = body_frame(frames)[1][:, :, 0]
    return np.asarray(np.degrees(np.unwrap(np.arctan2(-forward[:, 2], forward[:, 0]))))


def _replay_error(motion: Motion, body: Body, trial: Trial, segment: Segment, name: str) -> float:
    """Greatest distance, cm, between a cycle played back again and again and the simulation."""
    origin, rotation = body_frame(trial.frames[-1])
    played = replay(segment, origin, rotation, REPLAYED_CYCLES)
    beat = steady_contraction(motion, name)
    swum = swim_on(body, copy_state(trial.state), beat, REPLAYED_CYCLES)[1:]
    return float(np.linalg.norm(played - swum, axis=2).max())
