"""Hash a source file together with the project files that it imports."""

import hashlib
import os
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Both forms in this project: `from a.b import c, d`, without and with parentheses.
IMPORT = re.compile(r"^\s*from ((?:subsea|capture)[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)


@cache
def source_stamp(file: Path, root: Path = ROOT) -> str:
    """Hash a source file and, transitively, all files of the project that it imports."""
    return _stamp(_with_imports(file, root))


@cache
def package_stamps(file: Path, root: Path = ROOT) -> dict[str, str]:
    """Hash the same files by package: ``subsea/fish`` and so on, and ``subsea`` itself."""
    packages: dict[str, set[str]] = {}
    for one in _with_imports(file, root):
        folder = Path(one).relative_to(root).parent.parts[:2]
        packages.setdefault("/".join(folder), set()).add(one)
    return {name: _stamp(packages[name]) for name in sorted(packages)}


def _with_imports(file: Path, root: Path) -> set[str]:
    found, waiting = {file.as_posix()}, [file.as_posix()]
    while waiting:
        for other in _imported(waiting.pop(), root.as_posix()) - found:
            found.add(other)
            waiting.append(other)
    return found


def _stamp(files: set[str]) -> str:
    sha = hashlib.sha256()
    for one in sorted(files, key=lambda path: path.split("/")):
        sha.update(_digest(one))
    return sha.hexdigest()


@cache
def _digest(file: str) -> bytes:
    return hashlib.sha256(Path(file).read_bytes()).digest()


@cache
def _imported(file: str, root: str) -> set[str]:
    """The files of the project that a file imports directly."""
    found = set()
    for package, names in IMPORT.findall(Path(file).read_text(encoding="utf-8")):
        base = f"{root}/{package.replace('.', '/')}"
        if _is_file(f"{base}.py"):
            found.add(f"{base}.py")
        else:
            modules = "__init__", *re.findall(r"\w+", names)
            found |= {f"{base}/{name}.py" for name in modules}
    return {path for path in found if _is_file(path)}


# Strings; Path objects would be four times slower.
_is_file = cache(os.path.isfile)
