"""Simulate a fish that swims or turns.

Trials begin and end at phase 0 of a tail beat. Right turns begin half a beat later, so that they
are exact mirror images of left ones.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.errors import UserError
from subsea.biomechanics.body import Body, Floats, body_frame, to_body
from subsea.biomechanics.body_plan import SwimPlan, TurnPlan
from subsea.biomechanics.controllers import (
    LEFT,
    SpeedMap,
    bend_contraction,
    ease,
    swim_contraction,
    turn_contraction,
)
from subsea.biomechanics.simulation import BodyState, at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK

MIN_WARM_UP = 24
MAX_WARM_UP = 1000
CLOSURE_GOAL = 1e-9  # loop closure of a steady beat, body lengths
STRAIGHT = (0.0, 0.0)


class Trial(NamedTuple):
    """Nodes (T + 1, 23, 3) of T ticks in world axes, cm, and the state at the end."""

    frames: Floats
    state: BodyState
    warm_up_beats: int = 0
    bend: tuple[float, ...] = ()  # of a turn: how it bends, see `biomechanics.manoeuvres.Bend`
    slowing: float = 0.0  # share of its speed that a fish loses in a tick, where nothing drives it


def deformation(frames: Floats) -> Floats:
    """World nodes (…, 23, 3) in their own body axes (SMC eq. 8)."""
    return np.asarray(to_body(frames, *body_frame(frames)))


def loop_error(frames: Floats) -> float:
    """Greatest distance of a node between the first and last deformation, cm."""
    ends = deformation(frames[[0, -1]])
    return float(np.linalg.norm(ends[1] - ends[0], axis=1).max())


def side_phase(side: float) -> float:
    """The swim phase, rad, at which the beat of a turn to this side begins."""
    return 0.0 if side == LEFT else np.pi


def beat_phase(swim: SwimPlan, ticks: int, side: float = LEFT) -> Floats:
    """Swim phases (6 ticks,) of all steps, from phase 0 of this side."""
    steps = np.arange(ticks * STEPS_PER_TICK)
    return np.asarray(side_phase(side) + 2 * np.pi * steps / (swim.ticks_per_beat * STEPS_PER_TICK))


def beat_contraction(
    swim: SwimPlan,
    amplitude: float,
    bias: tuple[float, float] = STRAIGHT,
    side: float = LEFT,
) -> Floats:
    """Contractions (6 T, 12) of one beat from phase 0 of this side.

    ``bias`` also contracts the turning muscles on ``side``: the gradual turn.
    """
    phase = beat_phase(swim, swim.ticks_per_beat, side)
    return swim_contraction(swim, phase, amplitude) + bend_contraction(bias, side)


def grade_contraction(
    swim: SwimPlan, grade: str, bias: tuple[float, float] = STRAIGHT, side: float = LEFT
) -> Floats:
    """Contractions (6 T, 12) of one beat of a grade; the rest as :func:`beat_contraction`."""
    return beat_contraction(swim.at(grade), swim.amplitude(grade), bias, side)


def steady_beat(body: Body, beat: Floats) -> Trial:
    """Swim from rest until the loop closes; return the last, steady beat.

    ``beat`` (6 T, 12) are the contractions of a beat. UserError where the body loses its shape
    or never swims steadily.
    """
    state = at_rest(body)
    # The first beat is faded in, so that no muscle jerks.
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


def speed_map(body: Body, swim: SwimPlan, levels: int = 10) -> SpeedMap:
    """Measure the steady speeds at ``levels`` amplitudes of the beat.

    UserError where the body loses its shape at one of them.
    """
    amplitude = np.linspace(0.0, 1.0, levels + 1)
    beat_tu = swim.ticks_per_beat * STEPS_PER_TICK * STEP
    ways = [
        np.linalg.norm(displacement(steady_beat(body, beat_contraction(swim, level)).frames))
        for level in amplitude[1:]
    ]
    return SpeedMap(amplitude, np.array([0.0, *ways]) / beat_tu)


def displacement(frames: Floats) -> Floats:
    """Mean displacement (3,) of the nodes from the first to the last of ``frames`` (T, 23, 3)."""
    return np.asarray((frames[-1] - frames[0]).mean(axis=0))


def sharp_turn(
    body: Body,
    swim: SwimPlan,
    turn: TurnPlan,
    angle: float,
    side: float,
    start: BodyState,
    entry_phase: float = 0.0,
) -> Trial:
    """Turn by about ``angle`` degrees from steady swimming at grade medium, and swim on.

    ``start`` is the state at ``entry_phase`` radians after phase 0 of this side; it is not
    changed. The trial lasts a whole number of beats. UserError where the body loses its shape.
    """
    state = copy_state(start)
    phase = entry_phase + side_phase(side)
    contraction = turn_contraction(swim, turn, side * angle, phase)
    frames = np.concatenate([start.x[None], simulate(body, state, contraction)])
    if not is_sound(state):
        raise UserError(f"the body lost its shape in a turn of {angle:g} degrees")
    return Trial(frames, state, 0)
