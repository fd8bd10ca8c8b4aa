"""Motor controllers: muscle contractions for swimming, turning and gliding (Tu §4.6.1).

Every controller returns *contractions* (T, 12), the fraction by which each muscle's rest length is
shortened in each step. Contractions of several controllers add up; see :func:`muscle_lengths`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from subsea.biomechanics.body import MUSCLE_LEFT, MUSCLE_SEGMENT, MUSCLES, Body, Floats
from subsea.biomechanics.body_plan import Steering, SwimPlan, TurnPlan
from subsea.biomechanics.solver import STEPS_PER_TICK

S_MAX = 0.075  # greatest change of a muscle's rest length in one step, cm (Tu §4.6.1)
LEFT, RIGHT = 1.0, -1.0
WIDEST_TURN = 90.0  # widest single turn in degrees; wider ones are split (Tu §4.6.1)
SETTLE_TICKS = 4  # time in which a straightened body comes to rest


class SpeedMap(NamedTuple):
    """Steady speed by amplitude of the beat; both increase from zero."""

    amplitude: Floats  # (n,) relative to grade fast
    speed: Floats  # (n,) cm/tu


def swim_amplitude(speeds: SpeedMap, speed: ArrayLike) -> Floats:
    """Amplitude of the beat for a swimming speed in cm/tu: swim-MC (Tu §4.6.1).

    Only the amplitude sets the speed; the frequency hardly matters. Speeds out of range give the
    amplitude of the nearest in range.
    """
    return np.asarray(np.interp(np.asarray(speed), speeds.speed, speeds.amplitude))


def swim_contraction(plan: SwimPlan, phase: ArrayLike, amplitude: ArrayLike = 1.0) -> Floats:
    """Contractions (T, 12) of the swim controller at phases (T,) in radians.

    Left and right contract in antiphase and the posterior segment follows by ``plan.lag``;
    ``amplitude`` (scalar or (T,)) sets the speed, 1 being grade fast.
    """
    phase, amplitude = np.atleast_1d(phase), np.asarray(amplitude)
    segment = np.array([0.0, *plan.contraction])[MUSCLE_SEGMENT]
    lag = np.array([0.0, 0.0, plan.lag])[MUSCLE_SEGMENT]
    wave = np.sin(phase[:, None] - lag) * MUSCLE_LEFT
    return np.reshape(amplitude, (-1, 1)) * segment * (1.0 + wave) / 2.0


def bend_contraction(bend: tuple[float, float], side: float, share: ArrayLike = 1.0) -> Floats:
    """Contractions (T, 12) of the turning muscles on ``side`` (LEFT or RIGHT).

    ``bend`` holds those of the anterior and posterior turning segment, ``share`` (T,) how much
    of it is applied.
    """
    segment = np.array([*bend, 0.0])[MUSCLE_SEGMENT]
    inner = segment * (side == MUSCLE_LEFT)
    return np.asarray(np.reshape(share, (-1, 1)) * inner)


def ease(share: ArrayLike) -> Floats:
    """Smooth step from 0 to 1 with level ends; clips outside [0, 1]."""
    u = np.clip(np.asarray(share, dtype=np.float64), 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))


def steering(plan: TurnPlan, angle: float) -> Steering:
    """The steering map at ``angle`` degrees, linear between its rows (Tu fig. 4.9).

    Below the first row the contraction shrinks in proportion; above the last it is the last.
    """
    angles = [row.angle for row in plan.steering]
    rows = [
        (*row.contraction, row.bend_ticks, row.hold_ticks, row.restore_ticks)
        for row in plan.steering
    ]
    front, back, *ticks = (float(np.interp(angle, angles, v)) for v in zip(*rows, strict=True))
    scale = min(1.0, angle / angles[0])
    bend, hold, restore = ticks
    return Steering(
        angle=angle,
        contraction=(scale * front, scale * back),
        bend_ticks=bend,
        hold_ticks=hold,
        restore_ticks=restore,
    )


def turn_share(row: Steering, ticks: ArrayLike) -> Floats:
    """Share of a sharp turn's bend applied at times ``ticks`` (T,) after its start.

    The bend comes fast and relaxes slowly, so that the fish keeps its new heading.
    """
    ticks = np.asarray(ticks, dtype=np.float64)
    released = row.bend_ticks + row.hold_ticks
    return ease(ticks / row.bend_ticks) - ease((ticks - released) / row.restore_ticks)


def turn_beats(swim: SwimPlan, row: Steering) -> int:
    """Length of a sharp turn in beats of medium; the body has settled before the last one ends."""
    ticks = row.bend_ticks + row.hold_ticks + row.restore_ticks + SETTLE_TICKS
    return int(np.ceil(ticks / swim.at("medium").ticks_per_beat))


def turn_contraction(swim: SwimPlan, turn: TurnPlan, angle: float, phase: float = 0.0) -> Floats:
    """Contractions (6 T, 12) of a turn by ``angle`` degrees, left positive: turn-MC (Tu §4.6.1).

    It begins in steady swimming at grade medium, at ``phase`` radians of the beat, whose ticks it
    keeps; the steering map holds for left turns at phase 0 and right ones at π. A turn wider than
    WIDEST_TURN is a sequence of equal smaller ones, each of a whole number of beats.
    """
    side, gait = LEFT if angle >= 0 else RIGHT, swim.at("medium")
    parts = max(1, int(np.ceil(abs(angle) / WIDEST_TURN)))
    row = steering(turn, abs(angle) / parts)
    per_beat = gait.ticks_per_beat * STEPS_PER_TICK
    steps = np.arange(turn_beats(swim, row) * per_beat)
    share = turn_share(row, steps / STEPS_PER_TICK)
    amplitude = swim.medium + (turn.amplitude - swim.medium) * share
    beat = swim_contraction(gait, phase + 2 * np.pi * steps / per_beat, amplitude)
    return np.tile(beat + bend_contraction(row.contraction, side, share), (parts, 1))


def glide_contraction(contraction: Floats, steps: int) -> Floats:
    """Contractions (steps, 12) that relax muscles from ``contraction`` (12,) to none: glide-MC.

    The relaxation is smooth, and complete with the last step (Tu §4.6.1).
    """
    return np.outer(1.0 - ease(np.arange(1, steps + 1) / steps), contraction)


def muscle_lengths(body: Body, contraction: Floats) -> Floats:
    """Rest lengths (T, 12), cm, of muscles contracted by the fractions ``contraction`` (T, 12)."""
    return np.ascontiguousarray(body.length[:MUSCLES] * (1.0 - contraction))
