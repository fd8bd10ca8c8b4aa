"""Times that the GPU spends in the stages of a picture, by timer queries (OpenGL 3.3)."""

from contextlib import AbstractContextManager, nullcontext
from typing import Any

# Of a picture, in the order of drawing; several views add up.
GPU_STAGES = (
    "shafts", "stone", "corals", "seaweed", "sand", "shadows", "water", "fishes", "particles",
    "output",
)  # fmt: skip
NOTHING = nullcontext()
UNKNOWN_S = 4.2  # drivers count nanoseconds in 32 bits: longer times mean nothing


class GpuTimer:
    """Measures whole pictures, or while it is `on` their stages, which do not overlap.

    moderngl cannot free queries: they exist as long as their context, and are used again.
    """

    def __init__(self, context: Any) -> None:
        self.on = False
        self._context = context
        self._whole = context.extra.picture_query
        self._drawn = False  # a picture is measured as a whole, and not read yet
        self._queries: list[Any] = []
        self._names: list[str] = []  # of the queries since the last call of `seconds`

    def picture(self) -> AbstractContextManager[object]:
        """Measure the picture that is drawn within the context, unless its stages are measured."""
        if self.on:
            return NOTHING
        self._drawn = True
        query: AbstractContextManager[object] = self._whole
        return query

    def wait(self) -> float:
        """Wait until the GPU has drawn the last `picture`; seconds that it took, 0 if unknown."""
        if not self._drawn:
            return 0.0
        self._drawn = False
        seconds = 1e-9 * self._whole.elapsed
        return seconds if seconds < UNKNOWN_S else 0.0

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
