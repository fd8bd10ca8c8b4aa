"""Learn the motor controllers of a body that is given (Tu §11.2, KS §I.D).

First the swim controller: both contractions, the lag and the ticks of a beat are searched; the
amplitudes of the slower grades follow from measured speeds. Then the turn controllers: the angle,
speed and duration of a bend are searched; the hold times of the steering map follow from measured
headings. Candidates are verified, best first, until one passes (capture/learning/fitness.py).
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from capture.learning.fitness import THRIFT
from capture.learning.search import Tried, search
from capture.learning.swim import swim_winners
from capture.learning.turn import refitted, turn_winner
from subsea.biomechanics.body import Floats, build_body
from subsea.biomechanics.body_plan import Muscles, SwimPlan, TurnPlan


class Learned(NamedTuple):
    """Controllers that were verified; None where nothing better than the old one was found."""

    swim: SwimPlan | None
    turn: TurnPlan | None
    notes: list[str]  # what was rejected, and why


Tell = Callable[[str, float, SwimPlan | TurnPlan], object]
"""Called with ``swim`` or ``turn``, a candidate's loss and the candidate."""


def learn(
    muscles: Muscles,
    only: str = "",
    method: str = "cma",
    budget: int = 300,
    seed: int = 1,
    ticks: int | None = None,
    thrift: float = THRIFT,
    tell: Tell = lambda stage, loss, plan: None,
) -> Learned:
    """Search for a better swim and turn controller of a body, begun at the given ones.

    ``only`` is ``swim``, ``turn`` or empty for both; a new gait gets new holds in the steering
    map in any case. ``budget`` counts the evaluations of each search, ``ticks`` fixes the ticks
    of a beat, ``thrift`` is what economy weighs beside speed. ``tell`` is called after each
    evaluation.
    """
    plan, swim, turn = muscles
    body = build_body(plan)
    notes: list[str] = []

    def hunt(
        stage: str,
        loss: Callable[[Any], float],
        at: Callable[[Floats | tuple[float, ...]], Any],
        start: Floats,
    ) -> list[Tried]:
        def told(one: Tried) -> None:
            tell(stage, one.loss, at(one.point))

        return search(lambda point: loss(at(point)), start, method, budget, seed, told)

    def learn_turn(gait: SwimPlan, new: bool) -> TurnPlan | None:
        found = None
        if only != "swim":
            found = turn_winner(body, gait, turn, new, seed, partial(hunt, "turn"), notes)
        if found is None and new:
            found = refitted(body, gait, turn, seed, notes)
        return found

    if only == "turn":
        return Learned(None, learn_turn(swim, False), notes)
    for winner in swim_winners(body, swim, ticks, thrift, seed, partial(hunt, "swim"), notes):
        bends = learn_turn(winner, True)
        if bends is not None:
            return Learned(winner, bends, notes)
        notes.append("swim: rejected: it cannot turn")
    return Learned(None, None if only else learn_turn(swim, False), notes)
