"""Compiled kernels: the decorator, their disk cache, and groups of arrays by pointer."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from numba import config

from subsea.base.errors import UserError
from subsea.kernels.cache import KernelCache
from subsea.kernels.dispatch import Kernel
from subsea.kernels.late_blas import import_when_used

if config.DISABLE_JIT:  # a tick would take minutes, and groups of arrays need compiled code
    raise UserError("numba's compiler is off; unset NUMBA_DISABLE_JIT (or `disable_jit`)")

import_when_used()

OPTIONS = {
    "nopython": True, "boundscheck": None, "error_model": "numpy", "nogil": True,
    "fastmath": False, "no_cfunc_wrapper": True,
}  # fmt: skip


def kernel(function: Callable[..., Any]) -> Any:
    """Decorate a function to compile it when it is first called.

    The code is cached on disk, divides by zero as numpy does, keeps the order of floating-point
    operations, and runs without the GIL. A wrapper for C, which numba would add, is left out: it
    takes a tenth of the time to compile.
    """
    compiled = Kernel(function, targetoptions=dict(OPTIONS))
    with suppress(OSError, RuntimeError):  # a function without a file
        compiled._cache = KernelCache(function)
    return compiled
