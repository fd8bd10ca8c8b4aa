"""Ownership of OpenGL objects: an owner releases all objects that it made."""

from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


class GpuOwner:
    """Base class of everything that holds OpenGL objects."""

    def __init__(self) -> None:
        self._owned: list[Any] = []

    def own(self, made: T) -> T:
        """Register `made`, anything with a method `release`, as owned, and return it."""
        self._owned.append(made)
        return made

    def own_buffers(self, context: Any, *parts: Any) -> list[Any]:
        """Upload arrays to buffers, one each."""
        return [self.own(context.buffer(np.ascontiguousarray(part))) for part in parts]

    def release(self) -> None:
        """Release every owned object, the last one first."""
        while self._owned:
            self._owned.pop().release()


def replace_data(buffer: Any, data: Any) -> None:
    """Write a contiguous array to a buffer; draws in progress keep the old data."""
    buffer.orphan(data.nbytes)
    buffer.write(data)
