"""Kernels that only kernels call are compiled without what Python needs to call them."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit, types
from numba.extending import overload

FLOATS = types.float64[::1]


def _pair():
    @njit
    def inner(values):
        return values.sum()

    @njit
    def outer(values):
        return 2.0 * inner(values)

    return inner, outer


def _wrappers(kernel):
    """Names of the wrappers that a kernel's only overload has."""
    (result,) = kernel.overloads.values()
    description, functions = result.fndesc, {f.name for f in result.library.get_defined_functions()}
    return {
        description.llvm_cpython_wrapper_name,
        description.llvm_cfunc_wrapper_name,
    } & functions


def test_only_the_kernel_that_python_calls_has_wrappers():
    inner, outer = _pair()
    assert outer(np.ones(3)) == 6.0
    assert len(_wrappers(outer)) == 2
    assert not _wrappers(inner)


def test_python_may_call_the_other_one_later():
    inner, outer = _pair()
    outer(np.ones(3))
    assert inner(np.ones(3)) == 3.0
    assert len(_wrappers(inner)) == 2
    assert inner(np.ones(4)) == 4.0
    assert outer(np.ones(4)) == 8.0


def test_it_is_compiled_again_but_once_whoever_asks():
    inner, outer = _pair()
    outer(np.ones(3))
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(inner, [np.ones(3)] * 4)) == [3.0] * 4
    compiled = inner.overloads[(FLOATS,)]
    inner.compile((FLOATS,))
    assert inner(np.ones(3)) == 3.0
    assert inner.overloads[(FLOATS,)] is compiled


def test_python_may_call_the_other_one_first():
    inner, outer = _pair()
    assert inner(np.ones(3)) == 3.0
    assert outer(np.ones(3)) == 6.0
    assert inner.signatures == [(FLOATS,)]
    assert len(_wrappers(inner)) == 2


def test_it_may_ask_for_one_while_a_kernel_is_compiled():
    """What is computed of a constant, say."""
    inner, _ = _pair()

    def told():
        raise NotImplementedError

    @overload(told)
    def _told():
        found = inner(np.ones(5))
        return lambda: found

    assert njit(lambda: told())() == 5.0


PROGRAM = """
import sys
import subsea
from numba import njit

@njit(cache=True)
def inner(x):
    return 2.0 * x

@njit(cache=True)
def outer(x):
    return inner(x) + 1.0

@njit(cache=True)
def other(x):
    return inner(x) - 1.0

exec(sys.argv[1])
assert "scipy.linalg" not in sys.modules
print([sum(kernel.stats.cache_hits.values()) for kernel in (inner, outer)])
"""


def test_both_forms_are_kept(tmp_path):
    """Python never finds the form that is for kernels, and a new kernel is linked with that."""
    program = tmp_path / "kernels.py"
    program.write_text(PROGRAM)
    found = [
        subprocess.run(
            [sys.executable, str(program), text], capture_output=True, text=True, check=True,
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "kept")},
        ).stdout.strip()
        for text in (
            "assert outer(1.0) == 3.0",
            "assert inner(1.0) == 2.0",
            "assert inner(1.0) == 2.0; assert outer(1.0) == 3.0",
            "assert other(1.0) == 1.0",
        )
    ]  # fmt: skip
    assert found == ["[0, 0]", "[0, 0]", "[1, 1]", "[1, 0]"]
