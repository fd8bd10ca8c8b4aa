"""Disk cache of compiled kernels, invalidated when code that they call changes.

Numba reuses a kernel while the file that defines it is unchanged. It ignores that the kernel calls
functions of other files, so their old code would run after an update. These classes are numba's
with another stamp; only this project's kernels use them. Reading compiled code can run anything, so
it is read only from files that nobody but the user can have written, and from the installed
package, which is as trusted as its sources.

A wheel ships kernels that are compiled for the features of a common processor. A kernel comes from
the user's cache, else from the shipped code, else from the compiler.
"""

import hashlib
import json
import os
import pickle
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, cached_property
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import llvmlite
import numba
import numpy as np
from numba.core import caching
from numba.core.registry import cpu_target

from subsea.base.files import OWN_MODE, make_own_folder, open_own
from subsea.base.source_stamp import ROOT, source_stamp

SHIPPED = ROOT / "subsea" / "_data" / "kernels"
MANIFEST = "manifest.json"  # what the code in that folder is compiled with and for


class Target(NamedTuple):
    """A processor as numba describes it: the second part of the key of compiled code."""

    triple: str
    cpu: str
    features: str

    @property
    def present(self) -> set[str]:
        """The features that it has."""
        return {name for name in self.features.split(",") if name.startswith("+")}

    def runs(self, code: "Target") -> bool:
        """True if this processor and system run code that is compiled for another one."""
        systems = [triple.rstrip("0123456789.") for triple in (self.triple, code.triple)]
        return systems[0] == systems[1] and code.present <= self.present


@cache
def processor() -> Target:
    """The processor that numba compiles for in this process."""
    return Target(*cpu_target.target_context.codegen().magic_tuple())


def versions() -> dict[str, str]:
    """The versions of all that compiled code depends on beside its sources."""
    return {
        "python": sys.implementation.cache_tag, "numba": numba.__version__,
        "llvmlite": llvmlite.__version__, "numpy": np.__version__,
    }  # fmt: skip


def write_manifest(folder: Path, target: Target, code: str) -> None:
    """Record what the kernels in a folder are compiled with and for, and a hash of their code."""
    about = {"versions": versions(), "target": target, "code": code}
    (folder / MANIFEST).write_text(json.dumps(about), encoding="utf-8")


@cache
def _manifest() -> tuple[Target | None, str]:
    """The processor that shipped kernels are for, and a hash of their code; None if of no use."""
    try:
        about = json.loads((SHIPPED / MANIFEST).read_bytes())
        target = Target(*about["target"])
        if about["versions"] == versions() and processor().runs(target):
            return target, str(about["code"])
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        pass  # nothing is shipped, or it is damaged
    return None, ""


def shipped_target() -> Target | None:
    """The processor that shipped kernels are compiled for; None if this process cannot use them."""
    return _manifest()[0]


def shipped_code() -> str:
    """A hash of the code whose kernels are all shipped; empty if of no use in this process."""
    return _manifest()[1]


@cache
def _own(file: str) -> Path | None:
    """A source file of this project, or None."""
    path = Path(file).resolve()
    own = path.is_relative_to(ROOT) and path.suffix == ".py" and path.is_file()
    return path if own else None


@cache
def _make_folder(path: str) -> None:
    """Make a folder; OSError unless this user, and nobody else, may write to it.

    Tests this once per folder, not once per kernel.
    """
    make_own_folder(Path(path))
    tempfile.TemporaryFile(dir=path).close()


@cache
def report(reason: str) -> None:
    """Report once why compiled code is not cached."""
    print(f"subsea: cannot cache compiled code ({reason}); every start compiles", file=sys.stderr)


class _Stamped:
    """Stamp a file of this project with all its imports, and any other file as numba does."""

    _py_file: str

    def get_source_stamp(self) -> object:
        own = _own(self._py_file)
        return super().get_source_stamp() if own is None else source_stamp(own)  # type: ignore[misc]

    def ensure_cache_path(self) -> None:
        _make_folder(self.get_cache_path())  # type: ignore[attr-defined]


class ProvidedLocator(_Stamped, caching.UserProvidedCacheLocator):  # type: ignore[misc]
    """Cache in NUMBA_CACHE_DIR (first choice)."""


class InTreeLocator(_Stamped, caching.InTreeCacheLocator):  # type: ignore[misc]
    """Cache beside the sources (second choice)."""


class UserWideLocator(_Stamped, caching.UserWideCacheLocator):  # type: ignore[misc]
    """Cache in the user's cache folder (last choice)."""


class NoLocator(_Stamped, caching.UserWideCacheLocator):  # type: ignore[misc]
    """No cache, where no folder may be written: shipped code is read all the same."""

    def get_cache_path(self) -> str:
        """A folder that cannot exist."""
        return f"{os.devnull}/none"

    def ensure_cache_path(self) -> None:
        """Raise an OSError that says why nothing is cached."""
        raise OSError("no folder for it is yours alone")

    @classmethod
    def from_function(cls, function: Any, file: str) -> Any:
        """Accept any function of a file."""
        return cls(function, file) if Path(file).exists() else None


class _Code(caching.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (ProvidedLocator, InTreeLocator, UserWideLocator, NoLocator)


class VerifiedFile(caching.IndexDataCacheFile):  # type: ignore[misc]
    """The cached code of one kernel; damaged or mismatched code is not loaded.

    Numba writes the index before the code. A process killed in between, or a full disk, would leave
    a new index beside old code. Two processes that write at once could store the code of one
    signature under the name of another.
    """

    _open: Callable[[Path], BinaryIO] = staticmethod(open_own)

    def save(self, key: Any, data: Any) -> None:
        """Write the code of a signature with its key and a digest of both."""
        whole = self._dump((self._version, self._source_stamp, key, data))
        super().save(key, (hashlib.sha256(whole).digest(), whole))

    def load(self, key: Any) -> Any:
        """Read the code of a signature; None if it is not cached."""
        try:
            digest, whole = super().load(key)
            if hashlib.sha256(whole).digest() != digest:
                return None
            *of, data = pickle.loads(whole)
        except (Exception, SystemExit):  # a damaged pickle may raise anything
            return None
        return data if of == [self._version, self._source_stamp, key] else None

    @contextmanager
    def _open_for_write(self, path: str) -> Iterator[Any]:
        """Open a file that nobody else may write, whatever the umask: only such code is read."""
        with super()._open_for_write(path) as file:
            Path(file.name).chmod(OWN_MODE)
            yield file

    def _load_index(self) -> Any:
        try:
            with self._open(Path(self._index_path)) as file:
                if pickle.load(file) != self._version:
                    return {}
                stamp, overloads = pickle.load(file)
        except (Exception, SystemExit):
            return {}
        return overloads if stamp == self._source_stamp and isinstance(overloads, dict) else {}

    def _load_data(self, name: str) -> Any:
        with self._open(Path(self._data_path(name))) as file:
            return pickle.load(file)


class ShippedFile(VerifiedFile):
    """The code of one kernel that is part of the package; any account may own its files."""

    _open = staticmethod(lambda path: path.open("rb"))


class KernelCache(caching.FunctionCache):  # type: ignore[misc]
    """The cache of one kernel."""

    _impl_class = _Code

    def __init__(self, function: Any) -> None:
        """Create the cache of a Python function; RuntimeError for one without a file.

        Its parts are made when they are needed: a start calls a sixth of the kernels.
        """
        self._py_func, self._name = function, repr(function)
        self._source = _own(function.__code__.co_filename)
        if self._source is None:
            _ = self._impl  # which raises the error
        self.enable()

    @cached_property
    def _impl(self) -> Any:
        return self._impl_class(self._py_func)

    @cached_property
    def _cache_path(self) -> str:
        return str(self._impl.locator.get_cache_path())

    @cached_property
    def _cache_file(self) -> VerifiedFile:
        return self._file(VerifiedFile, self._cache_path)

    @cached_property
    def _shipped_file(self) -> VerifiedFile | None:
        """The shipped code; None for a function of another project."""
        if self._source is None:
            return None
        return self._file(ShippedFile, str(SHIPPED / self._source.parent.relative_to(ROOT)))

    def _file(self, kind: type[VerifiedFile], folder: str) -> VerifiedFile:
        return kind(folder, self._impl.filename_base, self._impl.locator.get_source_stamp())

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        """Identify compiled code of a signature.

        Numba adds a hash of the bytecode, which differs without docstrings (`python -OO`). The
        stamp stands for the code of this project.
        """
        signature, target, (code, cells) = super()._index_key(signature, codegen)
        return signature, target, (code if self._source is None else "", cells)

    def _load_overload(self, signature: Any, context: Any) -> Any:
        """Read the code of a signature from the user's cache, else the shipped code, else None."""
        code = super()._load_overload(signature, context)
        target = shipped_target()
        if code is not None or target is None or self._shipped_file is None:
            return code
        signature, _, function = self._index_key(signature, context.codegen())
        data = self._shipped_file.load((signature, target, function))
        return None if data is None else self._impl.rebuild(context, data)

    def save_overload(self, signature: Any, data: Any) -> None:
        """Cache a compiled overload. A full disk is ignored: the kernel works without the cache."""
        try:
            super().save_overload(signature, data)
        except OSError as fault:
            report(fault.strerror or str(fault))
