"""Times that the GPU spends in the stages of a picture, by timer queries (OpenGL 3.3)."""

from contextlib import AbstractContextManager, nullcontext
from typing import Any

# Of a picture, in the order of drawing; several views add up.
GPU_STAGES = (
    "shafts", "stone", "corals", "seaweed", "sand", "shadows", "water", "fishes", "particles",
    "output",
)  # fmt: skip
NOTHING = nullcontext()


class GpuTimer:
    """Measures stages that do not overlap; does nothing until it is switched on.

    moderngl cannot free queries: they exist as long as their context, and are used again.
    """

    def __init__(self, context: Any) -> None:
        self.on = False
        self._context = context
        self._queries: list[Any] = []
        self._names: list[str] = []  # of the queries since the last call of `seconds`

    def stage(self, name: str) -> AbstractContextManager[object]:
        """Measure the drawing calls within the context."""
        if not self.on:
            return NOTHING
        if len(self._names) == len(self._queries):
            self._queries.append(self._context.query(time=True))
        self._names.append(name)
        query: AbstractContextManager[object] = self._queries[len(self._names) - 1]
        return query

    def seconds(self) -> dict[str, float]:
        """Seconds in each stage since the last call; waits until the GPU is done."""
        spent = dict.fromkeys(GPU_STAGES, 0.0)
        for name, query in zip(self._names, self._queries, strict=False):
            spent[name] += 1e-9 * query.elapsed
        self._names.clear()
        return spent
