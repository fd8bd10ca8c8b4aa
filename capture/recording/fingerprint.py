"""Identify what a recording depends on: the numbers of a species and the code that records it."""

import ast
import hashlib
import io
import re
import tokenize
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import msgspec
import numba
import numpy as np

from subsea import __version__
from subsea.base.syntax import parse_source
from subsea.fish.species import Species

ROOT = "capture.recording.record"
ROOTS = {"flatfish": "capture.recording.flatfish", "boxfish": "capture.recording.boxfish"}
SKIPPED = (
    *("subsea.base", "subsea.jobs", "subsea.kernels", "subsea.fish.species"),
    "capture.recording.fingerprint",
)
"""Input, output and species files: their result is part of the fingerprint as numbers."""
UNRECORDED = (
    "name", "scientific_name", "kind", "size_cm", "pace", "home_cm", "cruise_height",
    "character", "life", "scavenges", "skin",
)  # fmt: skip
"""Keys of a species that recorded motion does not depend on."""
BLOCKS = {tokenize.INDENT: "{", tokenize.DEDENT: "}"}
IGNORED = (tokenize.COMMENT, tokenize.NL)


def fingerprint(species: Species, root: str | None = None) -> str:
    """Hash the plans of a species (what recording needs), its code and libraries.

    The code is that of the module ``root``, by default the one that records a fish of this form,
    and of all that this uses.
    """
    plans = msgspec.to_builtins(species)
    root = root or ROOTS.get(species.form, ROOT)
    if species.form == "fish":  # as before there were others
        del plans["form"]
    for key in UNRECORDED:
        del plans[key]
    libraries = {"numpy": np.__version__, "numba": numba.__version__}
    known = {"plans": plans, "versions": libraries, "code": _code_hash(root)}
    return hashlib.sha256(msgspec.json.encode(known, order="deterministic")).hexdigest()


def library_versions() -> dict[str, str]:
    """The versions of the programs that make a recording, for its provenance."""
    return {"subsea": __version__, "numpy": np.__version__, "numba": numba.__version__}


@cache
def _code_hash(root: str) -> str:
    code = "\0".join(sorted(code_of(text) for text in definitions(root).values()))
    return hashlib.sha256(code.encode()).hexdigest()


class _Module:
    """The statements of a module by the names that they define, and what it imports."""

    def __init__(self, name: str) -> None:
        spec = find_spec(name)
        assert spec and spec.origin
        source = Path(spec.origin).read_text(encoding="utf-8")
        self.statements: dict[str, list[ast.stmt]] = {}
        self.imports: dict[str, tuple[str, str]] = {}
        tree, self._lines = parse_source(source), source.splitlines()
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                for alias in node.names:
                    self.imports[alias.asname or alias.name] = node.module, alias.name
        for statement in tree.body:
            if isinstance(statement, ast.Import | ast.ImportFrom) or _is_text(statement):
                continue
            for name in _defined(statement) or [""]:  # without a name it belongs to all
                self.statements.setdefault(name, []).append(statement)

    def text(self, statement: ast.stmt) -> str:
        """The source of a statement with its decorators."""
        decorators = getattr(statement, "decorator_list", [])
        first = min([statement.lineno, *(node.lineno for node in decorators)])
        return "\n".join(self._lines[first - 1 : statement.end_lineno]) + "\n"


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _defined(statement: ast.stmt) -> list[str]:
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return [statement.name]
    if isinstance(statement, ast.Assign | ast.AnnAssign | ast.AugAssign):
        names = [node for node in ast.walk(statement) if isinstance(node, ast.Name)]
        return [node.id for node in names if isinstance(node.ctx, ast.Store)]
    return []


_module = cache(_Module)


@cache
def _is_module(name: str) -> bool:
    """True if a name is one of a module of this project."""
    if not name.startswith(("subsea.", "capture.")):
        return False
    with suppress(ModuleNotFoundError):  # of something in a module
        return find_spec(name) is not None
    return False


def definitions(root: str = ROOT) -> dict[tuple[str, int], str]:
    """The sources of all that ``root`` defines and that this uses, by module and line.

    Definitions of modules that are SKIPPED are left out. So the code is the same wherever in the
    project its functions stand, and whatever stands beside them.
    """
    texts: dict[tuple[str, int], str] = {}
    waiting = [(root, name) for name in _module(root).statements]
    seen = set(waiting)
    while waiting:
        place, name = waiting.pop()
        module, more = _module(place), {(place, "")}
        for statement in module.statements.get(name, []):
            texts[place, statement.lineno] = module.text(statement)
            for node in ast.walk(statement):
                if isinstance(node, ast.Name):
                    more.add((place, node.id))
                elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                    more.add((".".join(module.imports.get(node.value.id, ())), node.attr))
        if not module.statements.get(name):
            more.add(module.imports.get(name, (place, "")))
        for used in more - seen:
            seen.add(used)
            if _is_module(used[0]) and not used[0].startswith(SKIPPED):
                waiting.append(used)
    return texts


def code_of(source: str) -> str:
    """The code without comments, docstrings and white space; blocks are in braces."""
    lines: list[str] = []
    line: list[tokenize.TokenInfo] = []
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type in BLOCKS:
            lines.append(BLOCKS[token.type])
        elif token.type == tokenize.NEWLINE:
            if len(line) > 1 or line[0].type != tokenize.STRING:
                lines.append(re.sub(r"\s", "", "".join(part.string for part in line)))
            line = []
        elif token.type not in IGNORED:
            line.append(token)
    return "\n".join(lines)
