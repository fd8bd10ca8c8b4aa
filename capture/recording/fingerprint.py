"""Identify what a recording depends on: the numbers of a species and the code that records it."""

import hashlib
import io
import re
import tokenize
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import msgspec
import numba
import numpy as np

from subsea import __version__
from subsea.fish.species import Species

ROOT = "capture.recording.record"
SKIPPED = ("subsea.base", "subsea.jobs", "subsea.kernels", "subsea.fish.species")
"""Input, output and species files: their result is part of the fingerprint as numbers."""
BLOCKS = {tokenize.INDENT: "{", tokenize.DEDENT: "}"}
IGNORED = (tokenize.COMMENT, tokenize.NL)


def fingerprint(species: Species, root: str = ROOT) -> str:
    """Hash the plans of a species (what recording needs), its code and libraries.

    The code is that of the module ``root`` and of all that it imports.
    """
    plans = msgspec.to_builtins(species)
    for key in ("name", "scientific_name", "kind", "size_cm", "pace", "home_cm", "skin"):
        del plans[key]
    libraries = {"numpy": np.__version__, "numba": numba.__version__}
    known = {"plans": plans, "versions": libraries, "code": _code_hash(root)}
    return hashlib.sha256(msgspec.json.encode(known, order="deterministic")).hexdigest()


def library_versions() -> dict[str, str]:
    """The versions of the programs that make a recording, for its provenance."""
    return {"subsea": __version__, "numpy": np.__version__, "numba": numba.__version__}


@cache
def _code_hash(root: str) -> str:
    modules = code_modules(root)
    code = "\0".join(code_of(modules[name]) for name in sorted(modules))
    return hashlib.sha256(code.encode()).hexdigest()


def code_modules(root: str = ROOT) -> dict[str, str]:
    """Names and sources of ``root`` and of all modules that it imports, except SKIPPED."""
    found: dict[str, str] = {}
    waiting = [root]
    while waiting:
        name = waiting.pop()
        spec = find_spec(name)
        if name in found or name.startswith(SKIPPED) or spec is None or spec.origin is None:
            continue
        found[name] = Path(spec.origin).read_text(encoding="utf-8")
        imported = r"^from ((?:capture|subsea)\.\S+) import"
        waiting += re.findall(imported, found[name], re.MULTILINE)
    return found


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
