"""Motor controllers: what the twelve muscles do (Tu §4.6.1).

Every controller gives *contractions*, the fraction by which a muscle's rest length is shortened,
as an array (T, 12). Contractions of several controllers add up; see :func:`muscle_lengths`.
"""

import numpy as np
from numpy.typing import ArrayLike

from subsea.biomechanics.body import MUSCLE_LEFT, MUSCLE_SEGMENT, MUSCLES, Body, Floats
from subsea.biomechanics.plan import Steering, SwimPlan, TurnPlan

S_MAX = 0.075
"""Greatest change of a muscle's rest length in one step, cm (Tu §4.6.1)."""
LEFT, RIGHT = 1.0, -1.0


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
    """Smooth step from 0 to 1, without a jump of speed at either end; clips outside [0, 1]."""
    u = np.clip(np.asarray(share, dtype=np.float64), 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))


def steering(plan: TurnPlan, angle: float) -> Steering:
    """The steering map at ``angle`` degrees, linear between its rows (Tu fig. 4.9).

    Below the first row the contraction shrinks in proportion; above the last it is the last.
    """
    angles = [row.angle for row in plan.steering]

    def at(values: list[float]) -> float:
        return float(np.interp(angle, angles, values))

    scale = min(1.0, angle / angles[0])
    return Steering(
        angle=angle,
        contraction=(
            scale * at([row.contraction[0] for row in plan.steering]),
            scale * at([row.contraction[1] for row in plan.steering]),
        ),
        bend_ticks=at([row.bend_ticks for row in plan.steering]),
        hold_ticks=at([row.hold_ticks for row in plan.steering]),
        restore_ticks=at([row.restore_ticks for row in plan.steering]),
    )


def turn_share(row: Steering, ticks: ArrayLike) -> Floats:
    """How much of a sharp turn's bend is applied at times ``ticks`` (T,) after its start.

    The bend comes fast and is given back slowly, so that the fish keeps its new heading.
    """
    ticks = np.asarray(ticks, dtype=np.float64)
    released = row.bend_ticks + row.hold_ticks
    return ease(ticks / row.bend_ticks) - ease((ticks - released) / row.restore_ticks)


def muscle_lengths(body: Body, contraction: Floats) -> Floats:
    """Rest lengths (T, 12), cm, of muscles contracted by the fractions ``contraction`` (T, 12)."""
    return np.ascontiguousarray(body.length[:MUSCLES] * (1.0 - contraction))
