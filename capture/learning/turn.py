"""Learn the turn controllers: angle and speed of bends, and the holds of the steering map."""

from itertools import islice

import msgspec
import numpy as np

from capture.inspection.gait import turn_contraction_step, turned
from capture.learning.fitness import (
    GRADUAL_DEG,
    UNSOUND,
    gradual_turn,
    measure_turning,
    turn_faults,
    turn_loss,
)
from capture.learning.search import Optimizer, distinct
from capture.learning.swim import MAX_VERIFIED, MIN_GAIN
from subsea.base.errors import UserError
from subsea.biomechanics.body import Body, Floats
from subsea.biomechanics.body_plan import Steering, SwimPlan, TurnPlan
from subsea.biomechanics.controllers import S_MAX
from subsea.biomechanics.simulation import BodyState
from subsea.biomechanics.trial import grade_contraction, steady_beat

BENDS = (0.03, 0.5)
BEND_TICKS = (4.0, 20.0)
RESTORE_TICKS = (8.0, 40.0)
AMPLITUDES = (0.0, 1.0)
LONGEST_HOLD = 320.0  # ticks
GRADUAL_DEG_PER_BEAT = 30.0  # angle of a gradual turn in one beat, if the body can bend so far
GRADUAL_BENDS = (0.3, 0.24, 0.18, 0.14, 0.1, 0.07, 0.05, 0.03)  # contractions that are tried


class Unreachable(Exception):  # noqa: N818 - a finding, no error
    """No hold times reach the angles of ``share`` of the rows of a steering map."""

    def __init__(self, share: float) -> None:
        super().__init__("its bends do not reach every angle of the steering map")
        self.share = share


def verified_turn(
    body: Body,
    swim: SwimPlan,
    old: TurnPlan,
    new_gait: bool,
    seed: int,
    optimize: Optimizer[TurnPlan],
    notes: list[str],
) -> TurnPlan | None:
    """A verified turn controller better than the old one, or None; ``notes`` collects faults.

    With a new gait any controller is better: the old hold times do not fit.
    """
    if (steady := _steady(body, swim, notes)) is None:
        return None
    # Two rows suffice for the search: the angles between them follow.
    ends = (old.steering[0], old.steering[-1])
    angles = [row.angle for row in ends]
    outline = msgspec.structs.replace(old, steering=ends)

    def loss(turn: TurnPlan) -> float:
        try:
            fitted = with_holds(body, swim, turn, steady)
            return turn_loss(measure_turning(body, swim, fitted, steady, angles), angles)
        except Unreachable as fault:
            return UNSOUND + fault.share
        except UserError:
            return UNSOUND + 2.0

    tried = optimize(loss, lambda point: turn_at(outline, point), turn_point(old))
    bound = UNSOUND
    if not new_gait:
        faults = turn_faults(body, swim, old, seed)
        if faults:
            notes.append(f"turn: the old controller is faulty: {faults[0]}")
        else:
            bound = turn_loss(measure_turning(body, swim, outline, steady, angles), angles)
    better = (one for one in distinct(tried) if one.loss < bound - MIN_GAIN)
    for one in islice(better, MAX_VERIFIED):
        found = _verified(body, swim, turn_at(old, one.point), steady, seed, notes)
        if found is not None:
            return found
    return None


def refit_holds(
    body: Body,
    swim: SwimPlan,
    turn: TurnPlan,
    seed: int,
    notes: list[str],
) -> TurnPlan | None:
    """The old bends with hold times for a new gait, and a smaller beat where it is too fast."""
    angles = [row.angle for row in turn.steering]
    while turn_contraction_step(body, swim, turn, angles) > 0.99 * S_MAX and turn.amplitude > 0:
        turn = msgspec.structs.replace(turn, amplitude=max(0.0, round(turn.amplitude - 0.01, 3)))
    steady = _steady(body, swim, notes)
    return _verified(body, swim, turn, steady, seed, notes) if steady else None


def _steady(body: Body, swim: SwimPlan, notes: list[str]) -> BodyState | None:
    """The steady medium swim in which turns begin; None, with a note, where there is none."""
    try:
        return steady_beat(body, grade_contraction(swim, "medium")).state
    except UserError as fault:
        notes.append(f"turn: rejected: {fault}")
        return None


def _verified(
    body: Body,
    swim: SwimPlan,
    turn: TurnPlan,
    steady: BodyState,
    seed: int,
    notes: list[str],
) -> TurnPlan | None:
    """The controller with hold times and gradual turn, if it passes verification."""
    try:
        whole = with_gradual(body, swim, with_holds(body, swim, turn, steady))
        faults = turn_faults(body, swim, whole, seed)
    except (UserError, Unreachable) as fault:
        faults = [str(fault)]
    if faults:
        notes.append(f"turn: rejected: {faults[0]}")
        return None
    return whole


def turn_point(turn: TurnPlan) -> Floats:
    """The point (5,) of a turn controller's widest row in the unit box."""
    row = turn.steering[-1]
    low, high = np.array([BENDS, BENDS, BEND_TICKS, RESTORE_TICKS, AMPLITUDES]).T
    values = [*row.contraction, row.bend_ticks, row.restore_ticks, turn.amplitude]
    return (np.array(values) - low) / (high - low)


def turn_at(base: TurnPlan, point: Floats | tuple[float, ...]) -> TurnPlan:
    """The turn controller at a point of the unit box: equal bends, hold times of ``base``.

    A body is never straightened faster than it was bent (Tu §4.6.1).
    """
    low, high = np.array([BENDS, BENDS, BEND_TICKS, RESTORE_TICKS, AMPLITUDES]).T
    front, back, bend, restore, amplitude = (low + np.array(point) * (high - low)).tolist()
    rows = tuple(
        msgspec.structs.replace(
            row,
            contraction=(round(front, 3), round(back, 3)),
            bend_ticks=round(bend, 1),
            restore_ticks=round(max(restore, bend + 0.1), 1),
        )
        for row in base.steering
    )
    return msgspec.structs.replace(base, steering=rows, amplitude=round(amplitude, 3))


def with_holds(body: Body, swim: SwimPlan, turn: TurnPlan, steady: BodyState) -> TurnPlan:
    """Set the hold times so that each row turns by its angle from ``steady``.

    Unreachable if no hold time does, or the body loses its shape.
    """
    from scipy.optimize import brentq

    rows: list[Steering] = []

    def error(hold: float, row: Steering) -> float:
        held = msgspec.structs.replace(row, hold_ticks=float(hold))
        alone = msgspec.structs.replace(turn, steering=(held,), sharp=row.angle)
        try:
            found = turned(body, swim, alone, row.angle, steady) - row.angle
        except UserError:
            found = float("nan")
        if np.isnan(found):
            raise Unreachable(1 - len(rows) / len(turn.steering))
        return found

    hold = 0.0
    for row in turn.steering:
        longest = hold + 20.0
        while error(longest, row) < 0:
            longest *= 2
            if longest > LONGEST_HOLD:
                raise Unreachable(1 - len(rows) / len(turn.steering))
        if error(hold, row) > 0:
            raise Unreachable(1 - len(rows) / len(turn.steering))
        hold = round(float(brentq(error, hold, longest, args=(row,), xtol=0.02)), 1)
        rows.append(msgspec.structs.replace(row, hold_ticks=hold))
    return msgspec.structs.replace(turn, steering=tuple(rows))


def with_gradual(body: Body, swim: SwimPlan, turn: TurnPlan) -> TurnPlan:
    """Set the gradual turn to the equal bends that come nearest to GRADUAL_DEG_PER_BEAT.

    UserError if no bend turns a body that keeps its shape by the least of GRADUAL_DEG.
    """
    found: dict[float, float] = {}

    def miss(bend: float) -> float:
        """Distance of the turn by this bend from the goal, degrees; infinite without a turn."""
        if bend not in found:
            try:
                found[bend] = gradual_turn(body, swim, (bend, bend))
            except UserError:
                found[bend] = np.nan
        reached = GRADUAL_DEG.holds(found[bend])
        return abs(found[bend] - GRADUAL_DEG_PER_BEAT) if reached else np.inf

    best = min(GRADUAL_BENDS, key=miss)
    if np.isinf(miss(best)):
        raise UserError("no bend gives a gradual turn")
    if found[best] > GRADUAL_DEG_PER_BEAT:
        finer = [round(float(bend), 3) for bend in np.linspace(0.4 * best, best, 7)]
        best = min(finer, key=miss)
    return msgspec.structs.replace(turn, gradual=(best, best))
