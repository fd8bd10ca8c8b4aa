"""Scipy's linear algebra is imported when code needs it, and then it is the real one."""

import sys

import pytest
from numba.extending import get_cython_function_address
from scipy.linalg import cython_blas

from subsea.kernels.late_blas import BLAS, import_when_used


@pytest.fixture
def missing(monkeypatch):
    monkeypatch.delitem(sys.modules, BLAS)


def test_only_a_use_of_the_module_imports_it(missing):
    import_when_used()
    late = sys.modules[BLAS]
    assert not hasattr(late, "anything")  # as `pickle` asks all modules
    assert sys.modules[BLAS] is late is not cython_blas
    assert "ddot" in late.__pyx_capi__
    assert sys.modules[BLAS].__file__ == cython_blas.__file__


def test_an_imported_module_stays():
    import_when_used()
    assert sys.modules[BLAS] is cython_blas


def test_compiled_code_finds_the_functions(missing):
    import_when_used()
    assert get_cython_function_address(BLAS, "ddot")
