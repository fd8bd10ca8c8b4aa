"""The loss of a controller, which learning minimises, and its verification.

Candidates swim HORIZON beats from a slightly disturbed start. Winners are verified over
VERIFY_FACTOR times as many, with stronger disturbances and at all amplitudes.
"""

from typing import NamedTuple

import numpy as np

from capture.inspection.gait import (
    entries,
    muscle_work,
    speed_kept,
    swim_beats,
    turn_contraction_step,
    turned,
)
from capture.inspection.targets import (
    Range,
    at_least,
    at_most,
    limit_at_any_phase,
    limit_at_phase_0,
)
from subsea.base.errors import UserError
from subsea.biomechanics.body import LOWER_TAIL, NODES, UPPER_TAIL, Body, Floats, body_frame
from subsea.biomechanics.body_plan import SwimPlan, TurnPlan
from subsea.biomechanics.controllers import (
    LEFT,
    RIGHT,
    S_MAX,
    WIDEST_TURN,
    ease,
    turn_contraction,
)
from subsea.biomechanics.fins import (
    MIN_DISTANCE,
    contraction_step,
    headings,
    snout_bend,
    straightness,
    sweep,
)
from subsea.biomechanics.simulation import BodyState, at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.biomechanics.together import Bout, Course, swim_course
from subsea.biomechanics.trial import (
    STRAIGHT,
    beat_contraction,
    displacement,
    grade_contraction,
    loop_error,
    sharp_turn,
    speed_map,
    steady_beat,
)

HORIZON = 60  # beats of a candidate at each amplitude
VERIFY_FACTOR = 2.5  # horizons of a verification
MEASURED_BEATS = 20  # last beats of a swim, which are measured
AMPLITUDES = (1.0, 0.5, 0.25)  # of a candidate: a gait must be stable at all of its grades
DISTURBANCE, STRONG_DISTURBANCE = 0.1, 0.2  # rms random velocity of each node at the start, cm/tu
STARTS = 3  # disturbed starts of each grade in a verification, and number of random amplitudes
ECONOMY = 0.1  # weight of economy relative to speed: a gait that is 1% faster may cost 10% more
DURATION_WEIGHT = 0.5  # weight of the duration of a turn relative to the speed kept in it
PENALTY = 5.0  # loss for missing a limit by its whole value; a factor of e in speed is worth 1
UNSOUND = 100.0  # loss greater than any of a body that keeps its shape

GAIT_LIMITS = {  # of a fast gait (docs/developers/biomechanics-figures.md)
    "drift": at_most(1.0),
    "aside": at_most(0.02),
    "tail": Range(0.15, 0.25),
    "head": at_most(0.08),
    "snout": at_most(5.0),
    "strouhal": at_most(0.55),
    "contraction_step": at_most(S_MAX),
    "closure": at_most(1e-3),
}
STRIDE = at_least(0.35)  # L/beat of a fast gait; a body that cannot reach it may still learn
TURN_LIMITS = {"contraction_step": at_most(S_MAX), "snout": at_most(25.0), "kept": at_least(0.5)}
GRADE_RATIO, BURST_RATIO = at_least(1.4), at_least(1.1)
GRADUAL_DEG = Range(2.0, 45.0)


class GaitMeasures(NamedTuple):
    """Measures of steady swimming; L is the body length, tu 0.1 s."""

    stride: float  # L/beat
    speed: float  # L/tu
    cost: float  # J/(kg m), work of the muscles for each metre and kilogram of fish
    drift: float  # degrees of heading in 20 beats
    aside: float  # L in 20 beats
    tail: float  # L, peak to peak
    head: float  # L, peak to peak
    snout: float  # degrees
    strouhal: float
    contraction_step: float  # cm a step
    closure: float  # L, loop closure of the last beat


class TurnMeasures(NamedTuple):
    """Measures of sharp turns."""

    errors: tuple[float, ...]  # degrees, of each row entered at phase 0
    worst: tuple[float, ...]  # degrees, of each row at the worst phase
    ticks: float  # bend, hold and restore of the widest row
    kept: float  # share of the speed kept in the widest turn
    snout: float  # degrees, widest turn
    contraction_step: float  # cm a step, widest turn


def disturbed(state: BodyState, rms: float, rng: np.random.Generator) -> BodyState:
    """A copy of ``state`` with random velocities added to the nodes."""
    pushed = copy_state(state)
    pushed.v[:] += rng.normal(0.0, rms, (NODES, 3))
    return pushed


def start_swimming(body: Body, beat: Floats, rms: float, rng: np.random.Generator) -> BodyState:
    """A disturbed body after its first beat, which is faded in."""
    return swim_course(starting(body, beat, rms, rng))


def starting(body: Body, beat: Floats, rms: float, rng: np.random.Generator) -> Course[BodyState]:
    """As `start_swimming`, as a course."""
    state = disturbed(at_rest(body), rms, rng)
    yield Bout(body, state, ease(np.arange(len(beat)) / len(beat))[:, None] * beat)
    return state


def beats_survived(body: Body, state: BodyState, beat: Floats, count: int) -> int:
    """Swim up to ``count`` beats and check the shape every five; changes ``state``."""
    return swim_course(surviving(body, state, beat, count))


def surviving(body: Body, state: BodyState, beat: Floats, count: int) -> Course[int]:
    """As `beats_survived`, as a course."""
    for done in range(0, count, 5):
        yield Bout(body, state, np.tile(beat, (min(5, count - done), 1)))
        if not is_sound(state):
            return done
    return count


def measure_gait(body: Body, swim: SwimPlan, amplitude: float, state: BodyState) -> GaitMeasures:
    """Measure MEASURED_BEATS more beats of ``state``, which changes."""
    length = float(np.ptp(body.rest[:, 0]))
    beat = beat_contraction(swim, amplitude)
    frames = swim_beats(body, state, beat, MEASURED_BEATS)
    drift, aside = straightness(frames, swim.ticks_per_beat)
    last = frames[-swim.ticks_per_beat - 1 :]
    forward = body_frame(last)[1][:, :, 0].mean(axis=0)
    chord = displacement(last)
    # A fish that swims backwards has a negative speed.
    ahead = float(np.copysign(max(float(np.linalg.norm(chord)), MIN_DISTANCE), chord @ forward))
    tail = sweep(last, [UPPER_TAIL, LOWER_TAIL]) / length
    work = muscle_work(body, copy_state(state), beat)
    return GaitMeasures(
        stride=ahead / length,
        speed=ahead / length / (swim.ticks_per_beat * STEPS_PER_TICK * STEP),
        # g cm²/tu² for each g and cm: cm/tu² is m/s² is J/(kg m).
        cost=work / (float(body.mass.sum()) * abs(ahead)),
        drift=drift,
        aside=aside / length,
        tail=tail,
        head=sweep(last, [0]) / length,
        snout=snout_bend(last),
        strouhal=tail * length / abs(ahead),
        contraction_step=contraction_step(body, beat),
        closure=loop_error(last) / length,
    )


def excess(value: float, limit: Range) -> float:
    """The relative distance of a value from a limit, at most 2; 2 for NaN."""
    if limit.holds(value):
        return 0.0
    bound = limit.low if value < limit.low else limit.high
    return float(np.nan_to_num(min(abs(value - bound) / abs(bound), 2.0), nan=2.0))


def missed(measured: GaitMeasures | TurnMeasures, limits: dict[str, Range]) -> dict[str, float]:
    """The names of missed limits and their :func:`excess`."""
    shares = {name: excess(getattr(measured, name), limit) for name, limit in limits.items()}
    return {name: share for name, share in shares.items() if share}


def swim_loss(body: Body, swim: SwimPlan, seed: int, economy: float = ECONOMY) -> float:
    """-ln(speed) + ``economy`` ln(cost) of the fast swim, plus penalties; ``seed`` disturbs it."""
    rng = np.random.default_rng(seed)
    states, survived = [], 0
    for amplitude in AMPLITUDES:
        beat = beat_contraction(swim, amplitude)
        state = start_swimming(body, beat, DISTURBANCE, rng)
        beats = HORIZON - 1 - MEASURED_BEATS
        survived += beats_survived(body, state, beat, beats) if is_sound(state) else 0
        states.append(state)
    if not all(map(is_sound, states)):
        return UNSOUND + 1.0 - survived / (len(AMPLITUDES) * HORIZON)
    gaits = [measure_gait(body, swim, *pair) for pair in zip(AMPLITUDES, states, strict=True)]
    if not all(map(is_sound, states)):
        return UNSOUND
    loss = -np.log(max(gaits[0].speed, 1e-4)) + economy * np.log(max(gaits[0].cost, 1e-4))
    loss += PENALTY * sum(missed(gaits[0], GAIT_LIMITS).values())
    loss += PENALTY * excess(gaits[0].stride, STRIDE)
    steady = {name: GAIT_LIMITS[name] for name in ("drift", "aside")}
    for gait, faster in zip(gaits[1:], gaits[:-1], strict=True):
        loss += PENALTY * sum(missed(gait, steady).values())
        loss += PENALTY * min(2.0, max(0.0, gait.speed / max(faster.speed, 1e-4) - 0.8))
    return float(loss)


def gait_faults(body: Body, swim: SwimPlan) -> list[str]:
    """The limits that the steady fast swim of a controller misses."""
    try:
        steady = steady_beat(body, beat_contraction(swim, 1.0)).state
    except UserError as fault:
        return [str(fault)]
    gait = measure_gait(body, swim, 1.0, steady)
    return [f"{name} is {getattr(gait, name):.4g}" for name in missed(gait, GAIT_LIMITS)]


def swim_faults(body: Body, swim: SwimPlan, seed: int) -> list[str]:
    """Verify a swim controller for longer and with stronger disturbances; return its faults."""
    faults = gait_faults(body, swim)
    if faults:
        return faults
    try:
        levels = speed_map(body, swim).speed
        speeds = [steady_speed(body, swim, grade) for grade in swim.grades]
    except UserError as fault:
        return [str(fault)]
    if not (np.diff(levels) > 0).all():
        faults.append("its speed does not rise with the amplitude")
    for name, below, speed in zip(swim.grades[1:], speeds[:-1], speeds[1:], strict=True):
        if not (GRADE_RATIO if name != "burst" else BURST_RATIO).holds(speed / below):
            faults.append(f"{name} is only {speed / below:.2f} times as fast as the grade below")
    others = np.random.default_rng([seed, HORIZON]).uniform(AMPLITUDES[-1] / 2, 1.0, STARTS)
    graded = [(swim.at(grade), swim.amplitude(grade)) for grade in reversed(swim.grades)]
    trials = [*STARTS * graded, *((swim, float(other)) for other in others)]
    return faults + disturbed_faults(body, trials, seed)


def steady_speed(body: Body, swim: SwimPlan, grade: str) -> float:
    """Speed of a steady grade, cm a tick; UserError without one."""
    frames = steady_beat(body, grade_contraction(swim, grade)).frames
    return float(np.linalg.norm(displacement(frames))) / (len(frames) - 1)


def disturbed_faults(body: Body, trials: list[tuple[SwimPlan, float]], seed: int) -> list[str]:
    """The fault of the first of ``trials``, plans with amplitudes, that a disturbance throws off.

    A fish must keep its shape, and then swim straight and steadily.
    """
    rng = np.random.default_rng([seed, HORIZON, 1])
    for gear, amplitude in trials:
        beat = beat_contraction(gear, amplitude)
        state = start_swimming(body, beat, STRONG_DISTURBANCE, rng)
        beats = round(VERIFY_FACTOR * HORIZON) - 1 - MEASURED_BEATS
        survived = beats_survived(body, state, beat, beats)
        if survived < beats:
            return [f"disturbed, it lost its shape within {survived + 5} beats"]
        gait = measure_gait(body, gear, amplitude, state)
        steady = {name: GAIT_LIMITS[name] for name in ("drift", "aside", "closure")}
        if not is_sound(state) or missed(gait, steady):
            return [f"disturbed, it does not swim straight at amplitude {amplitude:.2g}"]
    return []


def measure_turning(
    body: Body, swim: SwimPlan, turn: TurnPlan, steady: BodyState, angles: list[float]
) -> TurnMeasures:
    """Measure sharp turns from ``steady`` swimming at grade medium; UserError for a lost shape."""
    starts = entries(body, swim, steady)
    errors = np.array(
        [[turned(body, swim, turn, angle, *start) - angle for start in starts] for angle in angles]
    )
    widest = sharp_turn(body, swim, turn, angles[-1], LEFT, steady).frames
    row = turn.steering[-1]
    return TurnMeasures(
        errors=tuple(errors[:, 0].tolist()),
        worst=tuple(errors[np.arange(len(angles)), np.abs(errors).argmax(axis=1)].tolist()),
        ticks=row.bend_ticks + row.hold_ticks + row.restore_ticks,
        kept=speed_kept(body, widest),
        snout=snout_bend(widest),
        contraction_step=turn_contraction_step(body, swim, turn, angles),
    )


def turn_loss(turning: TurnMeasures, angles: list[float]) -> float:
    """-ln(speed kept) + DURATION_WEIGHT ln(duration) of the widest turn, plus penalties."""
    loss = -np.log(max(turning.kept, 1e-3)) + DURATION_WEIGHT * np.log(turning.ticks)
    loss += PENALTY * sum(missed(turning, TURN_LIMITS).values())
    for angle, error, worst in zip(angles, turning.errors, turning.worst, strict=True):
        entered, anywhere = limit_at_phase_0(angle), limit_at_any_phase(angle)
        loss += PENALTY * (excess(error, entered) + excess(worst, anywhere))
        loss += 0.1 * abs(worst) / anywhere.high
    return float(loss)


def turn_faults(body: Body, swim: SwimPlan, turn: TurnPlan, seed: int) -> list[str]:
    """Verify a turn controller; return its faults."""
    faults = []
    angles = [row.angle for row in turn.steering]
    try:
        steady = steady_beat(body, grade_contraction(swim, "medium")).state
        turning = measure_turning(body, swim, turn, steady, angles)
        rng = np.random.default_rng([seed, HORIZON])
        for angle in angles:
            beat = grade_contraction(swim, "medium")
            start = disturbed(steady, DISTURBANCE, rng)
            simulate(body, start, np.tile(beat, (MEASURED_BEATS, 1)))
            settle = round(VERIFY_FACTOR * HORIZON)
            error = turned(body, swim, turn, angle, start, settle=settle) - angle
            if not limit_at_any_phase(angle).holds(error):
                faults.append(f"disturbed, a turn by {angle:g}° misses it by {error:+.1f}°")
        for angle in (2 * WIDEST_TURN, -2 * WIDEST_TURN):
            state = copy_state(steady)
            simulate(body, state, turn_contraction(swim, turn, angle))
            if not is_sound(state):
                faults.append(f"it loses its shape in a turn by {angle:g}°")
        for side in (LEFT, RIGHT):
            each = gradual_turn(body, swim, turn.gradual, side)
            if not GRADUAL_DEG.holds(each):
                faults.append(f"its gradual turn is {each:.1f}° a beat")
    except UserError as fault:
        return [*faults, str(fault)]
    faults += [f"{name} is {getattr(turning, name):.4g}" for name in missed(turning, TURN_LIMITS)]
    for angle, error, worst in zip(angles, turning.errors, turning.worst, strict=True):
        if not limit_at_phase_0(angle).holds(error):
            faults.append(f"a turn by {angle:g}° misses it by {error:+.1f}°")
        if not limit_at_any_phase(angle).holds(worst):
            faults.append(f"a turn by {angle:g}° misses it by {worst:+.1f}° at the worst phase")
    return faults


def gradual_turn(
    body: Body, swim: SwimPlan, bend: tuple[float, float] = STRAIGHT, side: float = LEFT
) -> float:
    """Degrees per beat of steady swimming at grade medium with a constant bend."""
    frames = steady_beat(body, grade_contraction(swim, "medium", bend, side)).frames
    heading = headings(frames)
    return float(side * (heading[-1] - heading[0]))
