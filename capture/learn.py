"""Learn the motor controllers of a body that is given (Tu §11.2, KS §I.D).

First the swim controller: both contractions, the lag and the ticks of a beat are searched, the
amplitudes of the slower grades follow from the speeds measured. Then the turn controllers: how
far, how fast and how long to bend is searched, the holds of the steering map follow from the
headings measured. Whoever wins a search is verified (capture/fitness.py), the next best after it,
until one passes.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import msgspec
import numpy as np

from capture.fitness import (
    GRADUAL_DEG,
    THRIFT,
    UNSOUND,
    Gait,
    Turning,
    gait_faults,
    gradual_turn,
    measure_gait,
    measure_turning,
    swim_faults,
    swim_loss,
    turn_faults,
    turn_loss,
)
from capture.gait import pull, turned
from capture.search import search
from capture.trial import beat_contraction, speed_map, steady_beat
from subsea.biomechanics.body import MUSCLES, Body, Floats, build_body
from subsea.biomechanics.controllers import S_MAX, swim_amplitude, turn_contraction
from subsea.biomechanics.plan import BodyPlan, Steering, SwimPlan, TurnPlan
from subsea.biomechanics.simulation import State, copy_state
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.errors import UserError

TICKS = (8, 24)
"""Ticks of a beat that are searched, unless the number is given."""
STRONGEST = 0.6
"""Greatest contraction, as in the species file."""
LAGS = (0.0, 3.2)
BENDS = (0.03, 0.35)
BEND_TICKS = (4.0, 20.0)
RESTORE_TICKS = (8.0, 40.0)
LONGEST_HOLD = 160.0
"""Ticks."""
GRADES = (1 / 1.5**2, 1 / 1.5)
"""Speeds of slow and medium relative to fast."""
GRADUAL_TURN = 8.0
"""Degrees that a gradual turn turns in a beat."""
BETTER = 0.002
"""By how much a winner's loss must lie below the old one's."""
VERIFIED = 12
"""Candidates of a search that are verified at most."""


class Learned(NamedTuple):
    """Controllers that were verified; None where nothing better than the old one was found."""

    swim: SwimPlan | None
    turn: TurnPlan | None
    notes: list[str]


Tell = Callable[[str, float, SwimPlan | TurnPlan], object]
"""Called with ``swim`` or ``turn``, a candidate's loss and the candidate."""


def learn(
    plan: BodyPlan,
    swim: SwimPlan,
    turn: TurnPlan,
    only: str = "",
    method: str = "cma",
    budget: int = 300,
    seed: int = 1,
    ticks: int | None = None,
    thrift: float = THRIFT,
    tell: Tell = lambda stage, loss, plan: None,
) -> Learned:
    """Search for a better swim and turn controller of a body, begun at the given ones.

    ``only`` is ``swim``, ``turn`` or empty for both; ``budget`` counts evaluations of each
    search. ``ticks`` fixes the ticks of a beat. A new gait needs new holds in the steering map
    in any case. ``thrift`` is what
    economy weighs beside speed. ``tell(stage, loss, candidate)`` is called after each evaluation.
    """
    body = build_body(plan)
    notes: list[str] = []

    def learn_turn(gait: SwimPlan, new_gait: bool) -> TurnPlan | None:
        found = None
        if only != "swim":
            found = _learn_turn(body, gait, turn, new_gait, method, budget, seed, tell, notes)
        if found is None and new_gait:
            found = _refitted(body, gait, turn, seed, notes)
        return found

    if only == "turn":
        return Learned(None, learn_turn(swim, False), notes)
    for winner in _swim_winners(body, swim, ticks, thrift, method, budget, seed, tell, notes):
        bends = learn_turn(winner, True)
        if bends is not None:
            return Learned(winner, bends, notes)
        notes.append("swim: a gait that cannot turn is left")
    return Learned(None, None if only else learn_turn(swim, False), notes)


def _swim_winners(
    body: Body,
    old: SwimPlan,
    ticks: int | None,
    thrift: float,
    method: str,
    budget: int,
    seed: int,
    tell: Tell,
    notes: list[str],
) -> Iterator[SwimPlan]:
    """Verified swim controllers that beat the old one, best first."""
    start = swim_point(body, old)

    def gait(point: Floats | tuple[float, ...]) -> SwimPlan:
        return swim_at(body, old, point, ticks)

    tried = search(
        lambda point: swim_loss(body, gait(point), seed, thrift),
        start if ticks is None else start[:3],
        method,
        budget,
        seed,
        lambda one: tell("swim", one.loss, gait(one.point)),
    )
    faults = swim_faults(body, old, seed)
    bound = UNSOUND if faults else swim_loss(body, old, seed, thrift)
    if faults:
        notes.append(f"swim: the old controller is faulty: {faults[0]}")
    plans = dict.fromkeys(gait(one.point) for one in tried if one.loss < bound - BETTER)
    for plan in [*plans][:VERIFIED]:
        faults = gait_faults(body, plan)
        if not faults:
            try:
                plan = with_grades(body, plan)
                faults = swim_faults(body, plan, seed)
            except UserError as fault:
                faults = [str(fault)]
        if faults:
            notes.append(f"swim: rejected: {faults[0]}")
        else:
            yield plan


def swim_point(body: Body, swim: SwimPlan) -> Floats:
    """The point (4,) of the unit box at which a swim controller lies, see :func:`swim_at`."""
    low, high = LAGS
    return np.array(
        [
            *(np.array(swim.contraction) / strongest(body, swim.ticks_per_beat)),
            (swim.lag - low) / (high - low),
            (swim.ticks_per_beat + 0.5 - TICKS[0]) / (TICKS[1] + 1 - TICKS[0]),
        ]
    )


def swim_at(
    body: Body, base: SwimPlan, point: Floats | tuple[float, ...], ticks: int | None = None
) -> SwimPlan:
    """The swim controller at a point of the unit box; grades are those of ``base``.

    Contractions are shares of the greatest that keeps to S_MAX, then the lag and, unless it is
    given, the ticks of a beat. Numbers are rounded as they are written.
    """
    if ticks is None:
        ticks = min(int(TICKS[0] + point[3] * (TICKS[1] + 1 - TICKS[0])), TICKS[1])
    # Rounded down, or the strongest stroke would be too fast.
    front, back = np.floor(1000 * np.array(point[:2]) * strongest(body, ticks)) / 1000
    low, high = LAGS
    return msgspec.structs.replace(
        base,
        ticks_per_beat=ticks,
        contraction=(float(front), float(back)),
        lag=round(float(low + point[2] * (high - low)), 3),
    )


def strongest(body: Body, ticks: int) -> Floats:
    """The greatest contractions (2,) of the swimming segments with beats of ``ticks`` ticks.

    A sine of contraction c on a muscle of length l over n steps is steepest with c l sin(π/n).
    """
    lengths = body.length[:MUSCLES].reshape(3, 4).max(axis=1)[1:]
    return np.minimum(STRONGEST, S_MAX / (lengths * np.sin(np.pi / (ticks * STEPS_PER_TICK))))


def with_grades(body: Body, swim: SwimPlan) -> SwimPlan:
    """The controller with amplitudes of slow and medium that make them clearly slower grades.

    Raises UserError where the body does not swim steadily at any amplitude.
    """
    speeds = speed_map(body, swim)
    if not (np.diff(speeds.speed) > 0).all():
        raise UserError("its speed does not rise with the amplitude")
    slow, medium = swim_amplitude(speeds, np.array(GRADES) * speeds.speed[-1])
    return msgspec.structs.replace(swim, slow=round(float(slow), 3), medium=round(float(medium), 3))


class Unreachable(Exception):  # noqa: N818 - a finding, not a fault
    """A steering map lacks holds; ``share`` of its rows cannot be reached."""

    def __init__(self, share: float) -> None:
        super().__init__("its bends do not reach every angle of the steering map")
        self.share = share


def _learn_turn(
    body: Body,
    swim: SwimPlan,
    old: TurnPlan,
    new_gait: bool,
    method: str,
    budget: int,
    seed: int,
    tell: Tell,
    notes: list[str],
) -> TurnPlan | None:
    """A verified turn controller that beats the old one, or None."""
    steady = steady_beat(body, beat_contraction(swim, swim.medium)).state
    ends = (old.steering[0], old.steering[-1])
    angles = [row.angle for row in ends]
    outline = msgspec.structs.replace(old, steering=ends, sharp=min(old.sharp, angles[-1]))

    def loss(turn: TurnPlan) -> float:
        try:
            fitted = with_holds(body, swim, turn, steady)
            return turn_loss(measure_turning(body, swim, fitted, steady, angles), angles)
        except Unreachable as fault:
            return UNSOUND + fault.share
        except UserError:
            return UNSOUND + 2.0

    tried = search(
        lambda point: loss(turn_at(outline, point)),
        turn_point(old),
        method,
        budget,
        seed,
        lambda one: tell("turn", one.loss, turn_at(old, one.point)),
    )
    bound = UNSOUND
    if not new_gait:
        faults = turn_faults(body, swim, old, seed)
        if faults:
            notes.append(f"turn: the old controller is faulty: {faults[0]}")
        else:
            bound = turn_loss(measure_turning(body, swim, outline, steady, angles), angles)
    plans = dict.fromkeys(turn_at(old, one.point) for one in tried if one.loss < bound - BETTER)
    for plan in [*plans][:VERIFIED]:
        found = _verified_turn(body, swim, plan, steady, seed, notes)
        if found is not None:
            return found
    return None


def _refitted(
    body: Body, swim: SwimPlan, turn: TurnPlan, seed: int, notes: list[str]
) -> TurnPlan | None:
    """The old bends with the holds that a new gait needs, beating less where it is too fast."""
    widest = turn.steering[-1].angle
    while pull(body, turn_contraction(swim, turn, widest)) > 0.99 * S_MAX and turn.amplitude > 0:
        turn = msgspec.structs.replace(turn, amplitude=max(0.0, round(turn.amplitude - 0.01, 3)))
    steady = steady_beat(body, beat_contraction(swim, swim.medium)).state
    return _verified_turn(body, swim, turn, steady, seed, notes)


def _verified_turn(
    body: Body, swim: SwimPlan, turn: TurnPlan, steady: State, seed: int, notes: list[str]
) -> TurnPlan | None:
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
    """The point (5,) of the unit box at which a turn controller's widest row lies."""
    row = turn.steering[-1]
    low, high = np.array([BENDS, BENDS, BEND_TICKS, RESTORE_TICKS, (0.0, 1.0)]).T
    values = [*row.contraction, row.bend_ticks, row.restore_ticks, turn.amplitude]
    return (np.array(values) - low) / (high - low)


def turn_at(base: TurnPlan, point: Floats | tuple[float, ...]) -> TurnPlan:
    """The turn controller at a point of the unit box: all rows bend alike, holds are ``base``'s."""
    low, high = np.array([BENDS, BENDS, BEND_TICKS, RESTORE_TICKS, (0.0, 1.0)]).T
    front, back, bend, restore, amplitude = (low + np.array(point) * (high - low)).tolist()
    rows = tuple(
        msgspec.structs.replace(
            row,
            contraction=(round(front, 3), round(back, 3)),
            bend_ticks=round(bend, 1),
            restore_ticks=round(restore, 1),
        )
        for row in base.steering
    )
    return msgspec.structs.replace(base, steering=rows, amplitude=round(amplitude, 3))


def with_holds(body: Body, swim: SwimPlan, turn: TurnPlan, steady: State) -> TurnPlan:
    """The controller with holds that make each row turn by its angle out of ``steady``.

    Raises Unreachable where a bend turns too far by itself, or not far enough however long.
    """
    from scipy.optimize import brentq

    rows: list[Steering] = []

    def error(hold: float, place: int) -> float:
        row = turn.steering[place]
        held = msgspec.structs.replace(row, hold_ticks=float(hold))
        only = msgspec.structs.replace(turn, steering=(held,), sharp=row.angle)
        try:
            return turned(body, swim, only, row.angle, steady) - row.angle
        except UserError:
            return float("nan")

    least = 0.0
    for place, row in enumerate(turn.steering):
        most = least + 20.0
        below = error(least, place)
        above = error(most, place)
        while above < 0 and most < LONGEST_HOLD:
            most *= 2
            above = error(most, place)
        if not (below <= 0 <= above):
            raise Unreachable(1 - place / len(turn.steering))
        hold = round(float(brentq(error, least, most, args=(place,), xtol=0.02)), 1)
        rows.append(msgspec.structs.replace(row, hold_ticks=hold))
        least = hold
    return msgspec.structs.replace(turn, steering=tuple(rows))


def with_gradual(body: Body, swim: SwimPlan, turn: TurnPlan) -> TurnPlan:
    """The controller with a gradual turn of :data:`GRADUAL_TURN` degrees a beat.

    It bends the two segments in the proportion of the widest turn. Raises UserError where no
    part of that bend turns so.
    """
    from scipy.optimize import brentq

    bend = np.array(turn.steering[-1].contraction)

    def part(share: float) -> tuple[float, float]:
        front, back = np.round(share * bend, 3).tolist()
        return front, back

    def error(share: float) -> float:
        return gradual_turn(body, swim, part(share)) - GRADUAL_TURN

    if error(1.0) > 0:
        share = brentq(error, 0.0, 1.0, xtol=0.01)
    elif error(1.0) + GRADUAL_TURN >= GRADUAL_DEG.low:
        share = 1.0
    else:
        raise UserError("its bend is too small for a gradual turn")
    return msgspec.structs.replace(turn, gradual=part(float(share)))


def gait_of(plan: BodyPlan, swim: SwimPlan) -> Gait | None:
    """The fast gait of a controller, None where the body does not swim steadily."""
    body = build_body(plan)
    try:
        state = steady_beat(body, beat_contraction(swim, 1.0)).state
    except UserError:
        return None
    return measure_gait(body, swim, 1.0, copy_state(state))


def turning_of(plan: BodyPlan, swim: SwimPlan, turn: TurnPlan) -> Turning | None:
    """The turns of a controller, None where the body does not turn."""
    body = build_body(plan)
    try:
        steady = steady_beat(body, beat_contraction(swim, swim.medium)).state
        angles = [row.angle for row in turn.steering]
        return measure_turning(body, swim, turn, steady, angles)
    except UserError:
        return None
