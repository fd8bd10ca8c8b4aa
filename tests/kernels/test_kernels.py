"""Importing subsea leaves numba as it is for other code."""

import importlib
import subprocess
import sys

import numba
import numpy as np
import pytest

from subsea import kernels
from subsea.base.errors import UserError
from subsea.base.source_stamp import ROOT, source_stamp
from subsea.kernels import kernel
from tests.support.daily import only

STALE_CALLEES = """
{imports}
from subsea.behavior.steering import ease_goals
print(ease_goals._cache._impl.locator.get_source_stamp())
"""
LINEAR_ALGEBRA = """
import sys
{before}
import numpy as np
{imports}
assert dot((1.0, 0.0, 0.0), (2.0, 0.0, 0.0)) == 2.0

@njit
def square(matrix):
    return matrix @ matrix

print(square(2.0 * np.eye(2))[0, 0])
"""
UNTOUCHED = """
import numba
from numba.core import caching, codegen, compiler, dispatcher
from numba.np import linalg

PARTS = caching, caching.Cache, caching.FunctionCache, caching.CacheImpl, \\
    caching.CompileResultCacheImpl, caching.IndexDataCacheFile, codegen, codegen.JITCPUCodegen, \\
    codegen.CPUCodegen, dispatcher, dispatcher.Dispatcher, dispatcher._DispatcherBase, linalg, \\
    compiler, compiler.CompilerBase, numba.config
before = [dict(vars(part)) for part in PARTS]
import subsea.motor.switching, subsea.rendering.reef.rocks, subsea.lab, subsea.world.step
for part, names in zip(PARTS, before):
    now = dict(vars(part))
    changed = [name for name in names if now.get(name) is not names[name]]
    assert not changed and not now.keys() - names.keys(), (part, changed)
print("untouched")
"""


def _printed(program: str) -> str:
    run = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


@pytest.mark.parametrize("imports", ["import numba\nimport subsea", "import subsea\nimport numba"])
def test_changed_callees_are_noticed_in_either_order_of_import(imports):
    expected = source_stamp(ROOT / "subsea" / "behavior" / "steering.py")
    assert _printed(STALE_CALLEES.format(imports=imports)) == expected


OURS, NUMBA = "from subsea.geometry.vector import dot", "from numba import njit"


@pytest.mark.nightly
@pytest.mark.parametrize(
    "imports", only([f"{OURS}\n{NUMBA}"], [f"{OURS}\n{NUMBA}", f"{NUMBA}\n{OURS}"])
)
def test_other_code_in_the_process_has_linear_algebra(imports):
    assert _printed(LINEAR_ALGEBRA.format(before="", imports=imports)) == "4.0"


def test_without_scipy_kernels_work_and_linear_algebra_fails_as_numba_has_it():
    program = LINEAR_ALGEBRA.format(
        before="sys.modules['scipy'] = None", imports=f"{OURS}\n{NUMBA}"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert run.returncode != 0
    assert "scipy 0.16+ is required for linear algebra" in run.stderr


def test_importing_kernels_replaces_nothing_in_numba():
    assert _printed(UNTOUCHED) == "untouched"


def test_a_kernel_divides_by_zero_as_numpy_does_and_keeps_the_order_of_sums():
    @kernel
    def ratio(a: float, b: float) -> float:
        return a / b

    @kernel
    def total(values: np.ndarray) -> float:
        out = 0.0
        for value in values:
            out += value
        return out

    assert ratio(1.0, 0.0) == np.inf
    values = np.random.default_rng(1).normal(size=1001)
    plain = 0.0
    for value in values:
        plain += value
    assert total(values) == plain


def test_without_the_compiler_it_is_one_line(monkeypatch):
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    with pytest.raises(UserError, match="compiler is off; unset NUMBA_DISABLE_JIT"):
        importlib.reload(kernels)
