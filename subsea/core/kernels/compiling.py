"""Kernels that only kernels call are compiled without what Python needs to call them.

Numba gives every kernel two wrappers, one that unpacks Python's objects and one for C: with most
of ours they are more code than the kernel itself, compiled with it and with each of its callers.
Here a kernel that another one calls gets none. If Python calls it after all, it is compiled again.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from threading import local
from typing import Any

from numba.core import dispatcher
from numba.core.caching import Cache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.sigutils import normalize_signature

FORM = 1  # of what is compiled here: another number where that changes, as all of it is kept

# What its own hints do not tell, or forbid to replace.
Base: Any = dispatcher._DispatcherBase
Dispatcher: Any = dispatcher.Dispatcher
Compiler: Any = vars(dispatcher)["_FunctionCompiler"]


class _Asking(local):
    """Who asks for a kernel in this thread."""

    kernel = False  # another one, which is being compiled; else Python


_asking = _Asking()


@contextmanager
def asked_by(kernel: bool) -> Iterator[None]:
    """A kernel asks for what is compiled in here, or else Python."""
    before, _asking.kernel = _asking.kernel, kernel
    try:
        yield
    finally:
        _asking.kernel = before


def _asked(method: Callable[..., Any], kernel: bool) -> Callable[..., Any]:
    @wraps(method)
    def call(*given: Any, **named: Any) -> Any:
        with asked_by(kernel):
            return method(*given, **named)

    return call


def _compile(self: Any, signature: Any) -> Any:
    """As numba does it, but for Python never what only kernels can call."""
    with global_compiler_lock:
        if not _asking.kernel:
            types = normalize_signature(signature)[0]
            if self.__dict__.get("inner", {}).pop(types, None) is not None:
                self.overloads.pop(types, None)
        return _compiled(self, signature)


def _add(self: Any, result: Any) -> None:
    """Keep what was compiled; Python does not find what it cannot call."""
    if not _asking.kernel:
        return _added(self, result)
    types = tuple(result.signature.args)
    self.overloads[types] = self.__dict__.setdefault("inner", {})[types] = result
    return None


def _flags(self: Any, flags: Any) -> Any:
    if _asking.kernel:
        flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    return flags


def _key(self: Any, signature: Any, codegen: Any) -> Any:
    return *_keyed(self, signature, codegen), FORM, _asking.kernel


_compiled, _added, _keyed = Dispatcher.compile, Base.add_overload, Cache._index_key
Base.get_call_template = _asked(Base.get_call_template, True)
Base._compile_for_args = _asked(Base._compile_for_args, False)
Base.add_overload = _add
Dispatcher.compile = _compile
Compiler._customize_flags = _flags
Cache._index_key = _key
