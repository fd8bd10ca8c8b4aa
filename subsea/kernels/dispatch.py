"""Call compiled kernels from Python with little delay.

At each call numba looks up the types of all arguments. That takes a microsecond or more for each
named tuple and each group of arrays: longer than many kernels run. A `Kernel` remembers the code
for arguments of the same traits, which are quick to read, and calls it at once.
"""

from collections.abc import Callable
from contextlib import suppress
from functools import cached_property
from typing import Any

import numpy as np
from numba.core.registry import CPUDispatcher

PLAIN = frozenset(
    {int, float, bool, type(None), np.bool_, np.uint8, np.int32, np.int64, np.float32, np.float64}
)
"""Classes whose objects all have one type in kernels."""
POINTED: set[type] = set()
"""Classes of groups of arrays: each group knows its own type (`struct_ref.py`)."""
MOST_KEPT = 256

Code = Callable[..., Any]

# Tuples of numbers by their addresses, and their traits.
_kept: dict[int, tuple[Any, tuple[Any, ...]]] = {}


def traits(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Read what decides the types of arguments; a TypeError where only numba can tell."""
    found: list[Any] = []
    for value in values:
        kind = type(value)
        if kind in POINTED:
            found.append(value._numba_type_._code)  # a number that no other type has
        elif kind is np.ndarray:
            found += value.dtype, value.ndim, value.flags.num
        elif kind in PLAIN:
            found.append(kind)
        elif issubclass(kind, tuple):
            found.append(_traits_of_tuple(value))
        else:
            raise TypeError(f"only numba can tell the type of a {kind.__name__}")
    return tuple(found)


def _traits_of_tuple(value: Any) -> tuple[Any, ...]:
    """The traits of a tuple; those of the last tuples of numbers, which never change, are kept."""
    kept = _kept.get(id(value))
    if kept and kept[0] is value:
        return kept[1]
    found = type(value), *traits(value)
    if PLAIN.issuperset(found[1:]):
        if len(_kept) >= MOST_KEPT:
            _kept.clear()
        _kept[id(value)] = value, found
    return found


class Kernel(CPUDispatcher):  # type: ignore[misc]
    """A function that numba compiles for each set of types of its arguments."""

    @cached_property
    def codes(self) -> dict[Any, Code]:
        """Compiled code by the traits of its arguments."""
        return {}

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Run the kernel. For types that are new it is compiled, or read from the cache."""
        try:
            code = self.codes[traits(given)]
        except (KeyError, TypeError):
            code = self._first
        return code(*given, **named)

    def _first(self, *given: Any, **named: Any) -> Any:
        """Run the kernel by numba's own call, and remember the code that numba chose."""
        result = super().__call__(*given, **named)
        chosen = self.overloads.get(tuple([self.typeof_pyval(value) for value in given]))
        if chosen and not named:
            with suppress(TypeError):  # numba looks up these types at each call
                self.codes[traits(given)] = chosen.entry_point
        return result
