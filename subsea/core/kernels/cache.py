"""Disk cache of compiled kernels, invalidated when code that they call changes.

Numba reuses a kernel while the file that defines it is unchanged. It ignores that the kernel calls
functions of other files, so their old code would run after an update. These classes are numba's
with another stamp; only this project's kernels use them. Reading compiled code can run anything, so
it is read only from files that nobody but the user can have written.
"""

import hashlib
import pickle
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import caching

from subsea.core.own_files import make_own_folder, open_own
from subsea.core.source_stamp import ROOT, source_stamp


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


class _Code(caching.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (ProvidedLocator, InTreeLocator, UserWideLocator)


class VerifiedFile(caching.IndexDataCacheFile):  # type: ignore[misc]
    """The cached code of one kernel; damaged or mismatched code is not loaded.

    Numba writes the index before the code. A process killed in between, or a full disk, would leave
    a new index beside old code. Two processes that write at once could store the code of one
    signature under the name of another.
    """

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

    def _load_index(self) -> Any:
        try:
            with open_own(Path(self._index_path)) as file:
                if pickle.load(file) != self._version:
                    return {}
                stamp, overloads = pickle.load(file)
        except (Exception, SystemExit):
            return {}
        return overloads if stamp == self._source_stamp and isinstance(overloads, dict) else {}

    def _load_data(self, name: str) -> Any:
        with open_own(Path(self._data_path(name))) as file:
            return pickle.load(file)


class KernelCache(caching.FunctionCache):  # type: ignore[misc]
    """The cache of one kernel."""

    _impl_class = _Code

    def __init__(self, function: Any) -> None:
        """Create the cache of a Python function; OSError or RuntimeError without a writable
        folder.
        """
        super().__init__(function)
        found = self._impl
        self._cache_file = VerifiedFile(
            self._cache_path, found.filename_base, found.locator.get_source_stamp()
        )

    def save_overload(self, signature: Any, data: Any) -> None:
        """Cache a compiled overload. A full disk is ignored: the kernel works without the cache."""
        try:
            super().save_overload(signature, data)
        except OSError as fault:
            report(fault.strerror or str(fault))
