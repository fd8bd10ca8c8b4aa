"""Import scipy's linear algebra only when compiled code needs it.

Before it compiles or loads the first kernel, numba imports the C module below to learn whether
`np.dot` can be compiled. That imports all of `scipy.linalg`, a tenth of the time of a start, and
no kernel of this project uses it.
"""

import sys
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any

BLAS = "scipy.linalg.cython_blas"


class _Late(ModuleType):
    """A stand-in for a C module until its table of functions is read, which is all that it has."""

    def __getattr__(self, name: str) -> Any:
        if name != "__pyx_capi__":
            raise AttributeError(name)
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]
        return import_module(self.__name__).__dict__[name]


def import_when_used() -> None:
    """Put the stand-in in place of the C module, unless that is imported or not installed."""
    if BLAS not in sys.modules and find_spec("scipy"):
        sys.modules[BLAS] = _Late(BLAS)
