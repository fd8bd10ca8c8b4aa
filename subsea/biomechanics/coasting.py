"""Simulate bodies that no tail drives: a fish that coasts, and one that rows in a turn.

Muscles hold the body straight, or bent to the inner side of a turn as in a gradual one. The trial
goes on until the motion repeats. A coasting fish would slow down: a tow along its head keeps it at
the speed of grade medium, as drag grows with the square of the speed and changes the way little.
The speed that it loses is measured when the tow is let go.
"""

from collections.abc import Callable

import numpy as np

from subsea.base.errors import UserError
from subsea.biomechanics.body import Body, Floats, body_frame, build_body
from subsea.biomechanics.body_plan import Muscles
from subsea.biomechanics.controllers import LEFT, bend_contraction, ease
from subsea.biomechanics.fins import UP, couple_force, side_force
from subsea.biomechanics.rowing import MIDDLE, Oars, balanced_speed, thrust
from subsea.biomechanics.simulation import BodyState, at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEP, STEPS_PER_TICK
from subsea.biomechanics.trial import (
    Trial,
    displacement,
    grade_contraction,
    loop_error,
    steady_beat,
)

COAST_TICKS = 4  # rows of a coast, which are alike
BEND_TICKS = 15  # in which the body is bent
FREE_TICKS = 6  # after the tow, in which the loss of speed is measured
TOW_GAIN = 2.0  # 1/tu: of the tow, on the lack of speed
MOST_PERIODS = 200
CLOSURES = 1e-6, 1e-3  # of the body at the end of a period, body lengths: enough, and the limit

TICK_TU = STEP * STEPS_PER_TICK

Push = Callable[[BodyState, int], Floats]  # force (23, 3) on a state in the n-th tick


def coast(motion: Muscles, turns: bool) -> Trial:
    """Coast straight on, or in a turn to the left; UserError where the body does not settle."""
    body = build_body(motion.body)
    beat = steady_beat(body, grade_contraction(motion.swim, "medium"))
    ticks = len(beat.frames) - 1
    speed = float(np.linalg.norm(displacement(beat.frames))) / (ticks * TICK_TU)

    def tow(state: BodyState, _: int) -> Floats:
        ahead = body_frame(state.x)[1][:, 0]
        lack = speed - float(np.linalg.norm(_velocity(body, state)))
        return np.asarray(TOW_GAIN * lack * body.mass[:, None] * ahead)

    trial = _settle(motion, body, speed, tow, COAST_TICKS, turns)
    free = copy_state(trial.state)
    before = float(np.linalg.norm(_velocity(body, free)))
    simulate(body, free, np.tile(_held(motion, turns), (FREE_TICKS * STEPS_PER_TICK, 1)))
    after = float(np.linalg.norm(_velocity(body, free)))
    return trial._replace(slowing=(before / after - 1.0) / FREE_TICKS)


def row_turn(motion: Muscles, oars: Oars, ticks: int) -> Trial:
    """Turn to the left by strokes of ``ticks`` ticks of the outer fin; the inner one brakes.

    A fin pushes at its middle: beside the body, so that it turns it. UserError where the body
    does not settle.
    """
    body = build_body(motion.body)
    area = 0.25 * np.pi * oars.length * oars.width
    reach = 0.5 * oars.length * float(np.sin(MIDDLE))

    def row(state: BodyState, tick: int) -> Floats:
        rotation = body_frame(state.x)[1]
        ahead, up = rotation[:, 0], rotation[:, 1]
        speed = float(_velocity(body, state) @ ahead)
        phase = 2.0 * np.pi * (tick % ticks + 0.5) / ticks
        outer, inner = 0.5 * thrust(oars, phase, speed), -area * speed * abs(speed)
        arm = state.x - body.mass @ state.x / body.mass.sum()
        arm -= np.outer(arm @ up, up)
        couple = reach * (outer - inner) / float(body.mass @ (arm**2).sum(axis=1))
        force = couple_force(state.x, body.mass, up, couple)
        return np.asarray(force + side_force(np.outer([inner, outer], ahead)))

    return _settle(motion, body, balanced_speed(oars), row, ticks, True)


def _settle(
    motion: Muscles, body: Body, speed: float, push: Push, ticks: int, turns: bool
) -> Trial:
    """Bend, and go on from ``speed``, cm/tu, until the shape repeats itself in ``ticks`` ticks."""
    state, held = at_rest(body), _held(motion, turns)
    state.v[:, 0] = speed
    enough, limit = (share * motion.body.length for share in CLOSURES)
    best: Trial | None = None
    for period in range(MOST_PERIODS):
        frames = [state.x.copy()]
        for tick in range(ticks):
            at = np.arange(STEPS_PER_TICK) / STEPS_PER_TICK + period * ticks + tick
            contraction = ease(at / BEND_TICKS)[:, None] * held
            frames.extend(simulate(body, state, contraction, force=push(state, tick)))
        if not is_sound(state):
            raise UserError("the body lost its shape without a beat of its tail")
        trial = Trial(np.array(frames), copy_state(state), period)
        if period * ticks < 2 * BEND_TICKS:
            continue
        if best is None or loop_error(trial.frames) < loop_error(best.frames):
            best = trial
        if loop_error(best.frames) <= enough:
            break
    if best is None or loop_error(best.frames) > limit:
        raise UserError("the body does not settle without a beat of its tail")
    return best


def _held(motion: Muscles, turns: bool) -> Floats:
    """The contractions (1, 12) that hold the body."""
    return bend_contraction(motion.turn.gradual, LEFT, float(turns))


def _velocity(body: Body, state: BodyState) -> Floats:
    """The velocity (3,) of the centre of mass in the horizontal plane, cm/tu."""
    velocity = body.mass @ state.v / body.mass.sum()
    return np.asarray(velocity - (velocity @ UP) * UP)
