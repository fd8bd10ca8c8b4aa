"""How good a controller is: the loss that learning lowers, and what a winner has to bear.

A candidate is judged over :data:`HORIZON` beats from a slightly disturbed start. A winner is
verified over :data:`LONGER` times as many, disturbed more and at all its amplitudes, because
gaits can win within the horizon and fall into circling beyond it.
"""

from typing import NamedTuple

import numpy as np

from capture.inspection.gait import (
    NOWHERE,
    entries,
    headings,
    muscle_work,
    pull,
    snout_bend,
    speed_kept,
    straightness,
    sweep,
    swim_on,
    turned,
    widest_pull,
)
from capture.inspection.targets import Range, at_least, at_most, within
from capture.recording.trial import (
    STRAIGHT,
    beat_contraction,
    displacement,
    loop_error,
    sharp_turn,
    speed_map,
    steady_beat,
)
from subsea.biomechanics.body import LOWER_TAIL, NODES, UPPER_TAIL, Body, Floats
from subsea.biomechanics.body_frame import body_frame
from subsea.biomechanics.body_plan import SwimPlan, TurnPlan
from subsea.biomechanics.controllers import LEFT, RIGHT, S_MAX, WIDEST_TURN, ease, turn_contraction
from subsea.biomechanics.simulation import BodyState, at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.core.errors import UserError

HORIZON = 60
"""Beats that a candidate swims at each amplitude."""
LONGER = 2.5
"""Horizons that a winner swims."""
WATCHED = 20
"""Last beats of a swim, over which it must go straight."""
TRAINED = (1.0, 0.5, 0.25)
"""Amplitudes at which a candidate swims: a gait must hold at all of its grades."""
DISTURBANCE, STRONG_DISTURBANCE = 0.1, 0.2
"""Root mean square of the random velocity of each node at the start, cm/tu.

At 0.5 the kick itself tears light nodes out of shape, whatever the gait.
"""
STARTS = 3
"""Starts from which each grade of a winner is verified, and other amplitudes drawn at random."""
ECONOMY = 0.1
"""What economy weighs beside speed: a gait that is 1% faster may cost 10% more."""
DURATION_WEIGHT = 0.5
"""What the duration of a turn weighs beside the speed that is kept in it."""
PENALTY = 5.0
"""Loss for missing a limit by all of its value; the speed of e-fold is worth 1."""
UNSOUND = 100.0
"""Loss beyond any of a body that keeps its shape."""

GAIT_LIMITS = {
    "drift": at_most(1.0),
    "aside": at_most(0.02),
    "tail": Range(0.15, 0.25),
    "head": at_most(0.08),
    "snout": at_most(5.0),
    "strouhal": at_most(0.55),
    "pull": at_most(S_MAX),
    "closure": at_most(1e-3),
}
"""What a fast gait must keep (docs/biomechanics.md)."""
STRIDE = at_least(0.35)
"""L a beat that are asked of a fast gait; a body that cannot reach them may still learn."""
TURN_LIMITS = {"pull": at_most(S_MAX), "snout": at_most(25.0), "kept": at_least(0.7)}
GRADE_RATIO = at_least(1.4)
GRADUAL_DEG = Range(2.0, 18.0)


class GaitMeasures(NamedTuple):
    """What is measured on steady swimming; L is the body length, tu 0.1 s."""

    stride: float  # L a beat
    speed: float  # L/tu
    cost: float  # J/(kg m), work of the muscles for each metre and kilogram of fish
    drift: float  # degrees of heading in 20 beats
    aside: float  # L in 20 beats
    tail: float  # L, peak to peak
    head: float  # L, peak to peak
    snout: float  # degrees
    strouhal: float
    pull: float  # cm a step
    closure: float  # L, loop closure of the last beat


class TurnMeasures(NamedTuple):
    """What is measured on sharp turns."""

    errors: tuple[float, ...]  # degrees, of each row entered at phase 0
    worst: tuple[float, ...]  # degrees, of each row at the worst phase
    ticks: float  # bend, hold and restore of the widest row
    kept: float  # share of the speed kept in the widest turn
    snout: float  # degrees, widest turn
    pull: float  # cm a step, widest turn


def disturbed(state: BodyState, rms: float, rng: np.random.Generator) -> BodyState:
    """A copy of ``state`` whose nodes are pushed at random."""
    pushed = copy_state(state)
    pushed.v[:] += rng.normal(0.0, rms, (NODES, 3))
    return pushed


def start_swimming(body: Body, beat: Floats, rms: float, rng: np.random.Generator) -> BodyState:
    """A body at rest, kicked, whose first beat has risen from nothing."""
    state = disturbed(at_rest(body), rms, rng)
    simulate(body, state, ease(np.arange(len(beat)) / len(beat))[:, None] * beat)
    return state


def beats_survived(body: Body, state: BodyState, beat: Floats, count: int) -> int:
    """Swim ``count`` beats, or until the body loses its shape; changes ``state``.

    The shape is looked at every five beats.
    """
    for done in range(0, count, 5):
        simulate(body, state, np.tile(beat, (min(5, count - done), 1)))
        if not is_sound(state):
            return done
    return count


def measure_gait(body: Body, swim: SwimPlan, amplitude: float, state: BodyState) -> GaitMeasures:
    """Measure the swimming of ``state``, over :data:`WATCHED` more beats; changes ``state``."""
    length = float(np.ptp(body.rest[:, 0]))
    beat = beat_contraction(swim, amplitude)
    frames = swim_on(body, state, beat, WATCHED)
    drift, aside = straightness(frames, swim.ticks_per_beat)
    last = frames[-swim.ticks_per_beat - 1 :]
    forward = body_frame(last)[1][:, :, 0].mean(axis=0)
    chord = displacement(last)
    # A fish that swims backwards has a negative speed.
    ahead = float(np.copysign(max(float(np.linalg.norm(chord)), NOWHERE), chord @ forward))
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
        pull=pull(body, beat),
        closure=loop_error(last) / length,
    )


def excess(value: float, limit: Range) -> float:
    """By what share of a limit a value misses it, at most 2; NaN misses it by most."""
    if limit.holds(value):
        return 0.0
    bound = limit.low if value < limit.low else limit.high
    return float(np.nan_to_num(min(abs(value - bound) / abs(bound), 2.0), nan=2.0))


def missed(measured: GaitMeasures | TurnMeasures, limits: dict[str, Range]) -> dict[str, float]:
    """The limits that are missed, and by what share."""
    shares = {name: excess(getattr(measured, name), limit) for name, limit in limits.items()}
    return {name: share for name, share in shares.items() if share}


def swim_loss(body: Body, swim: SwimPlan, seed: int, thrift: float = ECONOMY) -> float:
    """-ln(speed) + ``thrift`` ln(cost) of the fast swim, and penalties; less is better.

    ``seed`` decides how the start is disturbed.
    """
    rng = np.random.default_rng(seed)
    states, survived = [], 0
    for amplitude in TRAINED:
        beat = beat_contraction(swim, amplitude)
        state = start_swimming(body, beat, DISTURBANCE, rng)
        beats = HORIZON - 1 - WATCHED
        survived += beats_survived(body, state, beat, beats) if is_sound(state) else 0
        states.append(state)
    if not all(map(is_sound, states)):
        return UNSOUND + 1.0 - survived / (len(TRAINED) * HORIZON)
    gaits = [measure_gait(body, swim, *pair) for pair in zip(TRAINED, states, strict=True)]
    if not all(map(is_sound, states)):
        return UNSOUND
    loss = -np.log(max(gaits[0].speed, 1e-4)) + thrift * np.log(max(gaits[0].cost, 1e-4))
    loss += PENALTY * sum(missed(gaits[0], GAIT_LIMITS).values())
    loss += PENALTY * excess(gaits[0].stride, STRIDE)
    steady = {name: GAIT_LIMITS[name] for name in ("drift", "aside")}
    for gait, faster in zip(gaits[1:], gaits[:-1], strict=True):
        loss += PENALTY * sum(missed(gait, steady).values())
        loss += PENALTY * min(2.0, max(0.0, gait.speed / max(faster.speed, 1e-4) - 0.8))
    return float(loss)


def gait_faults(body: Body, swim: SwimPlan) -> list[str]:
    """What a controller's steady fast swim misses; or nothing."""
    try:
        steady = steady_beat(body, beat_contraction(swim, 1.0)).state
    except UserError as fault:
        return [str(fault)]
    gait = measure_gait(body, swim, 1.0, steady)
    return [f"{name} is {getattr(gait, name):.4g}" for name in missed(gait, GAIT_LIMITS)]


def swim_faults(body: Body, swim: SwimPlan, seed: int) -> list[str]:
    """Why a swim controller is no winner, verified for longer and disturbed more; or nothing."""
    faults = gait_faults(body, swim)
    if faults:
        return faults
    try:
        levels = speed_map(body, swim).speed
        grades = [
            steady_beat(body, beat_contraction(swim, level)).frames
            for level in (swim.slow, swim.medium, 1.0)
        ]
    except UserError as fault:
        return [str(fault)]
    if not (np.diff(levels) > 0).all():
        faults.append("its speed does not rise with the amplitude")
    slow, medium, fast = (float(np.linalg.norm(displacement(frames))) for frames in grades)
    for name, ratio in (("medium", medium / slow), ("fast", fast / medium)):
        if not GRADE_RATIO.holds(ratio):
            faults.append(f"{name} is only {ratio:.2f} times as fast as the grade below")
    rng = np.random.default_rng([seed, HORIZON])
    others = rng.uniform(TRAINED[-1] / 2, 1.0, STARTS)
    for amplitude in (*STARTS * (1.0, swim.medium, swim.slow), *others.tolist()):
        beat = beat_contraction(swim, amplitude)
        state = start_swimming(body, beat, STRONG_DISTURBANCE, rng)
        beats = round(LONGER * HORIZON) - 1 - WATCHED
        survived = beats_survived(body, state, beat, beats)
        if survived < beats:
            return [*faults, f"kicked, it lost its shape within {survived + 5} beats"]
        gait = measure_gait(body, swim, amplitude, state)
        steady = {name: GAIT_LIMITS[name] for name in ("drift", "aside", "closure")}
        if not is_sound(state) or missed(gait, steady):
            return [*faults, f"kicked, it does not swim straight at amplitude {amplitude:.2g}"]
    return faults


def measure_turning(
    body: Body, swim: SwimPlan, turn: TurnPlan, steady: BodyState, angles: list[float]
) -> TurnMeasures:
    """Measure sharp turns by ``angles`` out of ``steady``, swimming at grade medium at phase 0.

    Raises UserError where the body loses its shape.
    """
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
        pull=widest_pull(body, swim, turn, angles),
    )


def worst_error(angle: float) -> Range:
    """How far a turn by ``angle`` degrees may miss it from the worst phase of the beat."""
    return within(7.0) if angle <= 60 else within(10.0)


def entered_error(angle: float) -> Range:
    """How far a turn by ``angle`` degrees may miss it from phase 0."""
    return within(3.0) if angle <= 60 else within(6.0)


def turn_loss(turning: TurnMeasures, angles: list[float]) -> float:
    """-ln(speed kept) + :data:`HASTE` ln(duration) of the widest turn, and penalties."""
    loss = -np.log(max(turning.kept, 1e-3)) + DURATION_WEIGHT * np.log(turning.ticks)
    loss += PENALTY * sum(missed(turning, TURN_LIMITS).values())
    for angle, error, worst in zip(angles, turning.errors, turning.worst, strict=True):
        loss += PENALTY * (excess(error, entered_error(angle)) + excess(worst, worst_error(angle)))
        loss += 0.1 * abs(worst) / worst_error(angle).high
    return float(loss)


def turn_faults(body: Body, swim: SwimPlan, turn: TurnPlan, seed: int) -> list[str]:
    """Why a turn controller is no winner; or nothing."""
    faults = []
    angles = [row.angle for row in turn.steering]
    try:
        steady = steady_beat(body, beat_contraction(swim, swim.medium)).state
        turning = measure_turning(body, swim, turn, steady, angles)
        rng = np.random.default_rng([seed, HORIZON])
        for angle in angles:
            beat = beat_contraction(swim, swim.medium)
            start = disturbed(steady, DISTURBANCE, rng)
            simulate(body, start, np.tile(beat, (WATCHED, 1)))
            settle = round(LONGER * HORIZON)
            error = turned(body, swim, turn, angle, start, settle=settle) - angle
            if not worst_error(angle).holds(error):
                faults.append(f"kicked, a turn by {angle:g}° misses it by {error:+.1f}°")
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
        if not entered_error(angle).holds(error):
            faults.append(f"a turn by {angle:g}° misses it by {error:+.1f}°")
        if not worst_error(angle).holds(worst):
            faults.append(f"a turn by {angle:g}° misses it by {worst:+.1f}° at the worst phase")
    return faults


def gradual_turn(
    body: Body, swim: SwimPlan, bend: tuple[float, float] = STRAIGHT, side: float = LEFT
) -> float:
    """Degrees that steady swimming at grade medium with a constant bend turns in a beat."""
    frames = steady_beat(body, beat_contraction(swim, swim.medium, bend, side)).frames
    heading = headings(frames)
    return float(side * (heading[-1] - heading[0]))
