"""Seeds and values of a sweep as they are written on the command line."""

import re

from subsea.base.errors import UserError

MAX_RUNS = 100_000
_SEEDS = re.compile(r"(\d+)(?:[:-](\d+))?")
_CLOSING = {"[": "]", "{": "}"}


def read_seeds(text: str) -> tuple[int, ...]:
    """Seeds such as ``1:64`` or ``1-64`` (1 to 64) or ``1,5,9``; a UserError for anything else."""
    seeds: list[int] = []
    for part in text.split(","):
        found = _SEEDS.fullmatch(part.strip())
        first = int(found[1]) if found and len(part) < 30 else -1
        last = int(found[2] or first) if found and first >= 0 else -1
        if not 0 <= first <= last < 2**32 or last - first >= MAX_RUNS:
            raise UserError(
                f"--seeds {text}: expected seeds such as 1:64 or 1,5,9, from 0 to 4294967295"
            )
        seeds += range(first, last + 1)
    if len(set(seeds)) < len(seeds):
        raise UserError(f"--seeds {text}: a seed is there twice")
    return tuple(seeds)


def read_values(settings: list[str]) -> dict[str, tuple[str, ...]]:
    """The values of each key of settings such as ``fish.0.number=10,20``.

    Commas within brackets, braces and quotes belong to a value.
    """
    found: dict[str, tuple[str, ...]] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        key = ".".join(step.strip() for step in key.split("."))
        values = split_values(text)
        if not equals or not key or not all(values):
            raise UserError(
                "expected KEY=VALUE,VALUE… such as fish.0.number=10,20", file=f"--set {setting}"
            )
        if key in found:
            raise UserError("is given twice; give all values at once", file=f"--set {key}")
        if len(set(values)) < len(values):
            raise UserError("a value is there twice", file=f"--set {setting}")
        if key == "seed":
            raise UserError("give the seeds with --seeds", file=f"--set {setting}")
        found[key] = values
    return found


def split_values(text: str) -> tuple[str, ...]:
    """The parts of a text between commas outside brackets, braces and quotes."""
    parts, part, closing, quote = [], "", "", ""
    escaped = False
    for letter in text:
        if quote:
            if letter == quote and not escaped:
                quote = ""
            escaped = letter == "\\" and quote == '"' and not escaped
        elif letter in "\"'":
            quote = letter
        elif letter in _CLOSING:
            closing += _CLOSING[letter]
        elif closing and letter == closing[-1]:
            closing = closing[:-1]
        elif letter == "," and not closing:
            parts.append(part.strip())
            part = ""
            continue
        part += letter
    return *parts, part.strip()
