"""Compiled kernels: one decorator, their cache on disk, groups of arrays by pointer."""

from collections.abc import Callable
from typing import Any

from numba import njit

from subsea.core.kernels.cache import KernelCache, report


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a function when it is called: a decorator, and all that numba is told.

    The code is cached on disk, divides by zero as numpy does, keeps the order of floating-point
    operations, and runs without the GIL.
    """
    compiled = njit(error_model="numpy", nogil=True, fastmath=False)(function)
    try:
        compiled._cache = KernelCache(function)
    except (OSError, RuntimeError):  # no folder can be written
        report("no folder for it can be written")
    return compiled
