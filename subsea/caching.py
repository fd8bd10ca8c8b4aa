"""Compiled kernels are kept until any code that they may call changes.

Numba keeps a kernel as long as the file that defines it stays the same. It does not see that
the kernel calls functions of other files: after an update their old code would run on inside
it. `subsea/__init__.py` has it ask here instead.
"""

import hashlib
import re
import sys
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import caching

import subsea.compiling  # noqa: F401

ROOT = Path(__file__).resolve().parent.parent
# Both forms that this project uses: `from a.b import c, d` and the same in parentheses.
IMPORT = re.compile(r"^\s*from ((?:subsea|capture)[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)


@cache
def stamp(file: Path, root: Path = ROOT) -> str:
    """A hash over a source file and all files of the project that it imports, and they import."""
    found, waiting = {file}, [file]
    while waiting:
        for other in _imported(waiting.pop(), root) - found:
            found.add(other)
            waiting.append(other)
    sha = hashlib.sha256()
    for one in sorted(found):
        sha.update(_text(one).encode())
    return sha.hexdigest()


@cache
def _text(file: Path) -> str:
    return file.read_text(encoding="utf-8")


@cache
def _imported(file: Path, root: Path) -> set[Path]:
    """The files of the project that a file imports itself."""
    found = set()
    for package, names in IMPORT.findall(_text(file)):
        base = root.joinpath(*package.split("."))
        modules = [base / name for name in re.findall(r"\w+", names)]
        found |= {path.with_suffix(".py") for path in [base, *modules]} | {base / "__init__.py"}
    return {path for path in found if path.is_file()}


class _Stamped:
    """Asks for the stamp of a file of this project, and numba's own of any other."""

    _py_file: str

    def get_source_stamp(self) -> object:
        file = Path(self._py_file).resolve()
        if file.is_relative_to(ROOT) and file.suffix == ".py" and file.is_file():
            return stamp(file)
        return super().get_source_stamp()  # type: ignore[misc]


class Provided(_Stamped, caching.UserProvidedCacheLocator):  # type: ignore[misc]
    """Kernels are kept in NUMBA_CACHE_DIR, ..."""


class InTree(_Stamped, caching.InTreeCacheLocator):  # type: ignore[misc]
    """... or else beside their sources, ..."""


class UserWide(_Stamped, caching.UserWideCacheLocator):  # type: ignore[misc]
    """... or else in the user's cache folder."""


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
