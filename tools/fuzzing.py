"""Options and rounds of the tools that try odd input, and the ends that a command may have."""

import argparse
import random
import re
from collections.abc import Callable, Iterable
from pathlib import Path

CODES = 0, 1, 2, 75, 130  # with which a command may end


def main(
    doc: str,
    kinds: Iterable[str],
    rounds: int,
    fuzz: Callable[[str, argparse.Namespace], int],
    add_options: Callable[[argparse.ArgumentParser], None] = lambda parser: None,
) -> int:
    """Count the findings of `fuzz` for the chosen kinds; returns the exit code of the tool.

    `fuzz` gets a kind and the options, among them `rounds` and `seed`.
    """
    known = [*kinds]
    parser = argparse.ArgumentParser(description=doc.split("\n\n")[0])
    parser.add_argument("kinds", metavar="KIND", nargs="*", help=f"of {', '.join(known)} (all)")
    parser.add_argument("--rounds", type=int, default=rounds, help=f"of each kind ({rounds})")
    parser.add_argument("--seed", type=int, default=0)
    add_options(parser)
    options = parser.parse_args()
    if wrong := {*options.kinds} - {*known}:
        parser.error(f"unknown kind {min(wrong)!r}; there are: {', '.join(known)}")
    findings = [fuzz(kind, options) for kind in options.kinds or known]
    return 1 if any(findings) else 0


def random_of(kind: str, seed: int, number: int) -> random.Random:
    """Make the random numbers of a round."""
    return random.Random(f"{kind} {seed} {number}")


def resident_mb(process: int) -> list[float]:
    """Read the resident memory of a process, MB, as a list; empty if it has ended."""
    try:
        status = Path(f"/proc/{process}/status").read_text()
    except OSError:
        return []
    return [int(kb) / 1024 for kb in re.findall(r"^VmRSS:\s*(\d+)", status, re.MULTILINE)]
