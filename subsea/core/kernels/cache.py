"""Compiled kernels are kept until any code that they may call changes.

Numba keeps a kernel as long as the file that defines it stays the same. It does not see that
the kernel calls functions of other files: after an update their old code would run on inside
it. `subsea/__init__.py` has it ask here instead.
"""

import hashlib
import pickle
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from llvmlite import binding  # type: ignore[import-untyped]
from numba.core import caching, codegen
from numba.core.registry import cpu_target
from numba.np import linalg

from subsea.core.kernels.compiling import asked_by
from subsea.core.source_stamp import ROOT, stamp


@cache
def _own(file: str) -> Path | None:
    """A file of this project, or None."""
    path = Path(file).resolve()
    own = path.is_relative_to(ROOT) and path.suffix == ".py" and path.is_file()
    return path if own else None


@cache
def _make_folder(path: str) -> None:
    """Make it, or raise an OSError; what can be written into is asked once, not for each kernel."""
    Path(path).mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=path).close()


class _Stamped:
    """Asks for the stamp of a file of this project, and numba's own of any other."""

    _py_file: str

    def get_source_stamp(self) -> object:
        own = _own(self._py_file)
        return super().get_source_stamp() if own is None else stamp(own)  # type: ignore[misc]

    def ensure_cache_path(self) -> None:
        _make_folder(self.get_cache_path())  # type: ignore[attr-defined]


class Provided(_Stamped, caching.UserProvidedCacheLocator):  # type: ignore[misc]
    """Kernels are kept in NUMBA_CACHE_DIR, ..."""


class InTree(_Stamped, caching.InTreeCacheLocator):  # type: ignore[misc]
    """... or else beside their sources, ..."""


class UserWide(_Stamped, caching.UserWideCacheLocator):  # type: ignore[misc]
    """... or else in the user's cache folder."""


class Kept(codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of a kernel that was kept.

    Numba also reads at once what kernels that call it are linked with, which takes as long as all
    else about it. Here that waits until such a one is compiled.
    """

    _shared_module: Any

    def __init__(self, owner: Any, name: str, code: bytes, bitcode: bytes) -> None:
        super().__init__(owner, name)
        self._code, self._bitcode = code, bitcode
        self.enable_object_caching()
        self._set_compiled_object(code)
        self._finalize_final_module()

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = binding.parse_bitcode(self._bitcode)
        return self._shared_module

    def get_pointer_to_function(self, name: str) -> int:
        """Where a function of it is, 0 for none."""
        known = name.encode() in self._code
        return int(self._codegen._engine.get_function_address(name)) if known else 0


_read = codegen.JITCPUCodegen.unserialize_library


def _unserialize(self: Any, state: Any) -> Any:
    name, kind, data = state
    return Kept(self, name, *data) if kind == "object" else _read(self, state)


codegen.JITCPUCodegen.unserialize_library = _unserialize


def _load(self: Any, signature: Any, target: Any) -> Any:
    """The code of a kernel that was kept, without all that its compiler knows: 0.07 s.

    Who compiles has it loaded; what runs needs numba's memory alone.
    """
    from numba.core.runtime.nrt import rtsys

    rtsys.initialize(target)
    with self._guard_against_spurious_io_errors():
        return self._load_overload(signature, target)


caching.Cache.load_overload = _load


def _no_blas() -> None:
    """Where scipy is installed, numba would load it for linear algebra: no kernel here has any."""
    raise ImportError("where subsea was imported kernels do without linear algebra")


linalg.ensure_blas = _no_blas


_save = caching.Cache._save_overload


@cache
def _tell(reason: str) -> None:
    print(f"subsea: compiled code cannot be kept ({reason}); every start compiles", file=sys.stderr)


def _save_if_there_is_room(self: Any, signature: Any, data: Any) -> None:
    """A kernel that cannot be kept is compiled all the same: a full disk stops no dive."""
    try:
        _save(self, signature, data)
    except OSError as fault:
        _tell(fault.strerror or str(fault))


caching.Cache._save_overload = _save_if_there_is_room


class Matched(caching.IndexDataCacheFile):  # type: ignore[misc]
    """The kept code of one kernel: what does not match its index, or is damaged, is none.

    Numba writes first the index and then the code. A process that is killed between the two, or
    a disk that is full then, would leave an index of today beside the code of yesterday, and two
    processes that write at once the code of one signature under the name of another.
    """

    def save(self, key: Any, data: Any) -> None:
        """Write the code of a signature, what it belongs to, and a digest of both."""
        whole = self._dump((self._version, self._source_stamp, key, data))
        super().save(key, (hashlib.sha256(whole).digest(), whole))

    def load(self, key: Any) -> Any:
        """Read it; None where there is none."""
        try:
            digest, whole = super().load(key)
            if hashlib.sha256(whole).digest() != digest:
                return None
            *of, data = pickle.loads(whole)
        except Exception:  # a pickle that is damaged may raise anything, and None is no two
            return None
        return data if of == [self._version, self._source_stamp, key] else None

    def _load_index(self) -> Any:
        try:
            return super()._load_index()
        except Exception:
            return {}


caching.IndexDataCacheFile = Matched


def is_kept(kernel: Any, signature: tuple[Any, ...], inner: bool) -> bool:
    """Whether code of today's source of a kernel for these types of numba is on the disk.

    An `inner` one is that which only kernels call (`subsea/core/kernels/compiling.py`).
    """
    kept = kernel._cache
    if not isinstance(kept, caching.FunctionCache):
        return False
    with asked_by(inner):
        key = kept._index_key(signature, cpu_target.target_context.codegen())
    return key in kept._cache_file._load_index()
