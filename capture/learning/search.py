"""Searching a box for the least loss: CMA-ES, or simulated annealing as in KS §I.D.

Both are kept libraries (`cma`, `scipy`). They only propose points; what is worth keeping is
decided by whoever asked, from all that was tried.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from subsea.biomechanics.body import Floats
from subsea.core.errors import UserError

METHODS = ("cma", "annealing")
SPREAD = 0.2
"""First step of CMA-ES in each direction of the unit box."""
APART = 0.02
"""In some direction of the unit box, for points that count as different."""
TEMPERATURE = 5.0
"""At which annealing begins; scipy's 5230 is for budgets a thousand times as large."""


class Evaluation(NamedTuple):
    """A point of the unit box and its loss."""

    loss: float
    point: tuple[float, ...]


Candidate = TypeVar("Candidate")


class Optimizer(Protocol[Candidate]):
    """A search with method, budget and seed settled, that knows its candidates."""

    def __call__(
        self,
        loss: Callable[[Candidate], float],
        at: Callable[[Floats | tuple[float, ...]], Candidate],
        start: Floats,
    ) -> list[Evaluation]:
        """Minimise ``loss`` over the candidates ``at`` the points of the unit box."""
        ...


class _Spent(Exception):  # noqa: N818 - it ends a search, nothing is wrong
    """The budget is spent."""


def search(
    loss: Callable[[Floats], float],
    start: Floats,
    method: str,
    budget: int,
    seed: int,
    tell: Callable[[Evaluation], object] = lambda tried: None,
) -> list[Evaluation]:
    """Evaluate ``loss`` at ``budget`` points of the unit box [0, 1]ⁿ and return them, best first.

    The search begins at ``start`` (n,). ``tell`` is called after each evaluation with its point.
    The same arguments give the same points. UserError where the library is not installed.
    """
    tried: list[Evaluation] = []

    def evaluate(point: Floats) -> float:
        if len(tried) == budget:
            raise _Spent
        point = np.clip(point, 0.0, 1.0)
        tried.append(Evaluation(loss(point), tuple(point.tolist())))
        tell(tried[-1])
        return tried[-1].loss

    try:
        {"cma": _cma, "annealing": _annealing}[method](evaluate, np.clip(start, 0, 1), seed, budget)
    except _Spent:
        pass
    except ImportError as fault:
        raise UserError(f"learning needs {fault.name}: install subsea[learn]") from fault
    return sorted(tried)


def distinct(tried: list[Evaluation]) -> Iterator[Evaluation]:
    """Those of ``tried``, best first, that lie apart from all that were yielded before.

    Whoever takes the next because the last was no good is not offered its like.
    """
    yielded: list[tuple[float, ...]] = []
    for one in sorted(tried):
        if all(np.abs(np.subtract(one.point, other)).max() > APART for other in yielded):
            yielded.append(one.point)
            yield one


def _cma(evaluate: Callable[[Floats], float], start: Floats, seed: int, budget: int) -> None:
    """CMA-ES, begun again elsewhere with twice the population where it has converged."""
    import cma

    # Its generator is numpy's global one, which is put back as it was.
    state = np.random.get_state()  # noqa: NPY002
    rng = np.random.default_rng(seed)
    evaluate(start)
    population = int(4 + 3 * np.log(len(start)))
    try:
        while True:
            options = {
                "bounds": [0.0, 1.0],
                "popsize": population,
                "seed": int(rng.integers(1, 2**31)),
                "verbose": -10,
            }
            strategy = cma.CMAEvolutionStrategy(start, SPREAD, options)
            while not strategy.stop():
                points = strategy.ask()
                strategy.tell(points, [evaluate(point) for point in points])
            start = rng.random(len(start))
            population *= 2
    finally:
        np.random.set_state(state)  # noqa: NPY002


def _annealing(evaluate: Callable[[Floats], float], start: Floats, seed: int, budget: int) -> None:
    """Generalised simulated annealing without local search: KS's has none."""
    from scipy.optimize import dual_annealing

    dual_annealing(
        evaluate,
        [(0.0, 1.0)] * len(start),
        x0=start,
        maxiter=budget,
        maxfun=2 * budget,
        initial_temp=TEMPERATURE,
        no_local_search=True,
        seed=seed,
    )
