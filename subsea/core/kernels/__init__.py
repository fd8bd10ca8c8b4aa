"""Compiled kernels: one decorator, their cache on disk, struct references, warm-up."""

from typing import Any

from numba import njit

kernel: Any = njit(cache=True, error_model="numpy", nogil=True)
"""Compile a function: cached on disk, divisions by zero as numpy has them, without the GIL."""
