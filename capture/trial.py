"""A trial: make the simulated fish swim or turn, and keep the nodes of what is worth recording.

Trials begin and end at phase 0 of a tail beat for a fish that turns left or swims straight, and
half a beat later for one that turns right, so that a right turn is the exact mirror of a left one.
"""

from typing import NamedTuple

import numpy as np

from subsea.biomechanics.body import Body, Floats
from subsea.biomechanics.controllers import (
    LEFT,
    bend_contraction,
    ease,
    steering,
    swim_contraction,
    turn_share,
)
from subsea.biomechanics.plan import Steering, SwimPlan, TurnPlan
from subsea.biomechanics.simulation import State, at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.errors import UserError
from subsea.kinematics.frame import body_frame, to_body

MIN_WARM_UP = 24
MAX_WARM_UP = 400
CLOSURE_GOAL = 1e-9
"""Loop closure, in body lengths, at which a beat counts as steady."""
STRAIGHT = (0.0, 0.0)
SETTLE_TICKS = 4
"""How long a straightened body takes to come to rest, as far as playback's blending can tell."""


class Trial(NamedTuple):
    """Nodes (T + 1, 23, 3) in world axes, cm, of T ticks, and how they came about."""

    frames: Floats
    state: State
    warm_up_beats: int


def deformation(frames: Floats) -> Floats:
    """World nodes (…, 23, 3) in their own body axes (SMC eq. 8)."""
    return np.asarray(to_body(frames, *body_frame(frames)))


def loop_error(frames: Floats) -> float:
    """Greatest distance of a node between the first and last deformation, cm."""
    ends = deformation(frames[[0, -1]])
    return float(np.linalg.norm(ends[1] - ends[0], axis=1).max())


def beat_phase(swim: SwimPlan, ticks: int, side: float = LEFT) -> Floats:
    """Swim phases (6 ticks,) of the steps of ``ticks`` ticks that begin at this side's phase 0."""
    steps = np.arange(ticks * STEPS_PER_TICK)
    start = 0.0 if side == LEFT else np.pi
    return np.asarray(start + 2 * np.pi * steps / (swim.ticks_per_beat * STEPS_PER_TICK))


def beat_contraction(
    swim: SwimPlan,
    amplitude: float,
    bias: tuple[float, float] = STRAIGHT,
    side: float = LEFT,
) -> Floats:
    """Contractions (6 T, 12) of one beat from this side's phase 0.

    ``bias`` contracts the turning muscles on ``side`` besides: the gradual turn.
    """
    phase = beat_phase(swim, swim.ticks_per_beat, side)
    return swim_contraction(swim, phase, amplitude) + bend_contraction(bias, side)


def steady_beat(body: Body, beat: Floats) -> Trial:
    """One beat of steady swimming, from rest through as many beats as it takes to close the loop.

    ``beat`` (6 T, 12) are the contractions of a beat. Raises UserError where the body loses its
    shape or never comes to swim steadily.
    """
    state = at_rest(body)
    # The first beat raises everything from nothing, so that no muscle jerks.
    simulate(body, state, ease(np.arange(len(beat)) / len(beat))[:, None] * beat)
    length = float(np.ptp(body.rest[:, 0]))
    for beats in range(1, MAX_WARM_UP):
        start = state.x.copy()
        frames = np.concatenate([start[None], simulate(body, state, beat)])
        if not is_sound(state):
            raise UserError(f"the body lost its shape in beat {beats} of its warm-up")
        if beats >= MIN_WARM_UP and loop_error(frames) <= CLOSURE_GOAL * length:
            return Trial(frames, state, beats)
    raise UserError(f"the body does not swim steadily after {MAX_WARM_UP} beats")


def sharp_turn(
    body: Body,
    swim: SwimPlan,
    turn: TurnPlan,
    angle: float,
    side: float,
    start: State,
    entry_phase: float = 0.0,
) -> Trial:
    """Turn by about ``angle`` degrees out of steady swimming at grade medium, and swim on.

    ``start`` is that swimming, left as it is, ``entry_phase`` radians after this side's phase 0.
    The trial lasts a whole number of beats, so that it ends in the phase in which it began.
    Raises UserError where the body loses its shape.
    """
    row = steering(turn, angle)
    state = copy_state(start)
    ticks = turn_beats(swim, row) * swim.ticks_per_beat
    share = turn_share(row, np.arange(ticks * STEPS_PER_TICK) / STEPS_PER_TICK)
    amplitude = swim.medium + (turn.amplitude - swim.medium) * share
    contraction = swim_contraction(
        swim, entry_phase + beat_phase(swim, ticks, side), amplitude
    ) + bend_contraction(row.contraction, side, share)
    frames = np.concatenate([start.x[None], simulate(body, state, contraction)])
    if not is_sound(state):
        raise UserError(f"the body lost its shape in a turn of {angle:g} degrees")
    return Trial(frames, state, 0)


def turn_beats(swim: SwimPlan, row: Steering) -> int:
    """Length of a sharp turn in beats: it ends with the beat in which the body has settled."""
    ticks = row.bend_ticks + row.hold_ticks + row.restore_ticks + SETTLE_TICKS
    return int(np.ceil(ticks / swim.ticks_per_beat))
