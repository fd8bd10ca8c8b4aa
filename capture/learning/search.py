"""Minimise a loss in a box: CMA-ES, or simulated annealing as in KS §I.D.

The libraries `cma` and `scipy` propose the points; the caller chooses among all evaluations.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import NamedTuple, TypeVar

import numpy as np

from subsea.biomechanics.body import Floats

METHODS = ("cma", "annealing")
SPREAD = 0.2  # initial step size of CMA-ES in the unit box
MIN_DISTANCE = 0.02  # least distance, in some coordinate of the unit box, of distinct points
TEMPERATURE = 5.0  # initial, of annealing; scipy's 5230 suits budgets a thousand times larger


class Evaluation(NamedTuple):
    """A point of the unit box and its loss."""

    loss: float
    point: tuple[float, ...]


Candidate = TypeVar("Candidate")

Optimizer = Callable[
    [Callable[[Candidate], float], Callable[[Floats | tuple[float, ...]], Candidate], Floats],
    list[Evaluation],
]
"""A search that minimises a loss over candidates at points of the unit box, from one on."""


Losses = Callable[[Sequence[Floats]], list[float]]
"""The losses of several points, which may be found side by side."""


def one_by_one(loss: Callable[[Floats], float]) -> Losses:
    """The losses of points, found one after another."""
    return lambda points: [loss(point) for point in points]


class _BudgetSpent(Exception):  # noqa: N818 - ends a search, no error
    """All evaluations of the budget are made."""


def search(
    losses: Losses,
    start: Floats,
    method: str,
    budget: int,
    seed: int,
    progress: Callable[[Evaluation], object] = lambda evaluation: None,
    spread: float = SPREAD,
) -> list[Evaluation]:
    """Evaluate ``losses`` at ``budget`` points of the unit box [0, 1]ⁿ; return them, best first.

    The search begins at ``start`` (n,) and is deterministic. CMA-ES begins with steps of
    ``spread``.
    """
    tried: list[Evaluation] = []

    def evaluate(points: Sequence[Floats]) -> list[float]:
        places = [np.clip(point, 0.0, 1.0) for point in points][: budget - len(tried)]
        found = losses(places)
        for loss, place in zip(found, places, strict=True):
            tried.append(Evaluation(loss, tuple(place.tolist())))
            progress(tried[-1])
        if len(places) < len(points):
            raise _BudgetSpent
        return found

    with suppress(_BudgetSpent):
        begin = np.clip(start, 0.0, 1.0)
        if method == "cma":
            _cma(evaluate, begin, seed, spread)
        else:
            _annealing(evaluate, begin, seed, budget)
    return sorted(tried)


def distinct(tried: list[Evaluation]) -> Iterator[Evaluation]:
    """Evaluations, best first, that are not close to one yielded before."""
    yielded: list[tuple[float, ...]] = []
    for one in sorted(tried):
        if all(np.abs(np.subtract(one.point, other)).max() > MIN_DISTANCE for other in yielded):
            yielded.append(one.point)
            yield one


def _cma(evaluate: Losses, start: Floats, seed: int, spread: float) -> None:
    """CMA-ES; after convergence restarted at random with twice the population."""
    import cma

    # It uses numpy's global generator, which is restored afterwards.
    state = np.random.get_state()  # noqa: NPY002
    rng = np.random.default_rng(seed)
    evaluate([start])
    population = int(4 + 3 * np.log(len(start)))
    try:
        while True:
            options = {
                "bounds": [0.0, 1.0],
                "popsize": population,
                "seed": int(rng.integers(1, 2**31)),
                "verbose": -10,
            }
            strategy = cma.CMAEvolutionStrategy(start, spread, options)
            while not strategy.stop():
                points = strategy.ask()
                strategy.tell(points, evaluate(points))
            start, spread = rng.random(len(start)), SPREAD
            population *= 2
    finally:
        np.random.set_state(state)  # noqa: NPY002


def _annealing(evaluate: Losses, start: Floats, seed: int, budget: int) -> None:
    """Generalised simulated annealing without local search, as in KS."""
    from scipy.optimize import dual_annealing

    dual_annealing(
        lambda point: evaluate([point])[0],
        [(0.0, 1.0)] * len(start),
        x0=start,
        maxiter=budget,
        maxfun=2 * budget,
        initial_temp=TEMPERATURE,
        no_local_search=True,
        seed=seed,
    )
