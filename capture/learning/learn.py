"""Learn the motor controllers of a given body (Tu §11.2, KS §I.D).

First contractions, lag and ticks of the swim controller are searched; the grades follow from
measured speeds. Then angle, speed and duration of bends are searched; hold times follow from
measured headings. Candidates are verified, best first, until one passes (fitness.py).
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from capture.learning.fitness import ECONOMY
from capture.learning.search import Evaluation, one_by_one, search
from capture.learning.swim import verified_swims
from capture.learning.turn import refit_holds, verified_turn
from subsea.biomechanics.body import Floats, build_body
from subsea.biomechanics.body_plan import Muscles, SwimPlan, TurnPlan


class LearnedControllers(NamedTuple):
    """Verified controllers; None where nothing better than the old one was found."""

    swim: SwimPlan | None
    turn: TurnPlan | None
    notes: list[str]  # rejected candidates and the reasons


Progress = Callable[[str, float, SwimPlan | TurnPlan], object]  # "swim" or "turn", loss, candidate


def learn(
    muscles: Muscles,
    only: str = "",
    method: str = "cma",
    budget: int = 300,
    seed: int = 1,
    ticks: int | None = None,
    economy: float = ECONOMY,
    progress: Progress = lambda stage, loss, plan: None,
) -> LearnedControllers:
    """Search for better swim and turn controllers of a body, from the given ones.

    ``only`` is ``swim``, ``turn`` or empty; a new gait always gets new hold times. ``budget`` is
    the number of evaluations of each search, ``ticks`` fixes the ticks of a beat, ``economy`` is
    weighed against speed. ``progress`` is called after each evaluation.
    """
    plan, swim, turn = muscles
    body = build_body(plan)
    notes: list[str] = []

    def optimize(
        stage: str,
        loss: Callable[[Any], float],
        at: Callable[[Floats | tuple[float, ...]], Any],
        start: Floats,
    ) -> list[Evaluation]:
        def report(one: Evaluation) -> None:
            progress(stage, one.loss, at(one.point))

        return search(
            one_by_one(lambda point: loss(at(point))), start, method, budget, seed, report
        )

    def learn_turn(gait: SwimPlan, new: bool) -> TurnPlan | None:
        found = None
        if only != "swim":
            found = verified_turn(body, gait, turn, new, seed, partial(optimize, "turn"), notes)
        if found is None and new:
            found = refit_holds(body, gait, turn, seed, notes)
        return found

    if only == "turn":
        return LearnedControllers(None, learn_turn(swim, False), notes)
    for winner in verified_swims(
        body, swim, ticks, economy, seed, partial(optimize, "swim"), notes
    ):
        turns = learn_turn(winner, True)
        if turns is not None:
            return LearnedControllers(winner, turns, notes)
        notes.append("swim: rejected: it cannot turn")
    return LearnedControllers(None, None if only else learn_turn(swim, False), notes)
