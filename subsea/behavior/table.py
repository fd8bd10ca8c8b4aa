"""List the behaviors in one table, and make the kernels that call all of them from it."""

import hashlib
import inspect
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base import registry
from subsea.base.arrays import Ints
from subsea.base.progress import say
from subsea.behavior import (
    avoiding,
    biting,
    curious,
    eating,
    escaping,
    leaving,
    mating,
    schooling,
    wandering,
)
from subsea.behavior.intention import APPETITE, COLLISION, DANGER, EASE, Behavior, Desire
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.state import Clock, Fishes, Minds, Nature, Sea

LEAST_PART = 1024  # fishes of an intention for which another thread pays

# The first seven in the order of the codes AVOID to WANDER of `state`.
OURS = (
    Behavior("avoid", avoiding.act, ((COLLISION, avoiding.desire),), in_turn=True),
    Behavior("escape", escaping.act, ((DANGER, escaping.desire),)),
    Behavior(
        "school",
        schooling.act,
        ((DANGER, schooling.alarmed_desire), (EASE, schooling.desire)),
    ),
    Behavior("eat", eating.act, ((APPETITE, eating.desire),), tires=True),
    Behavior("mate", mating.act, ((APPETITE, mating.desire),), tires=True, in_turn=True),
    Behavior("leave", leaving.act, ((EASE, leaving.desire),)),
    Behavior("wander", wandering.act, ((EASE, wandering.desire),)),
    Behavior("curious", curious.act, ((EASE, curious.desire),), tires=True),
    Behavior("struggle", biting.struggle, ((COLLISION, biting.hooked_desire),)),
)


def _registered() -> list[Behavior]:
    """Load the behaviors of other packages, and say which are of another type."""
    behaviors = []
    for name, behavior in registry.load_all(registry.BEHAVIORS):
        if isinstance(behavior, Behavior):
            behaviors.append(behavior._replace(name=name))
        else:
            say(f"{registry.BEHAVIORS}: {name} is not a Behavior of subsea.behavior.intention")
    return behaviors


def _code_of(behaviors: Sequence[Behavior]) -> str:
    """A name for the code of other packages' behaviors: a hash of all files of these packages."""
    functions: list[Any] = []
    for behavior in behaviors:
        functions += [behavior.routine, *(desire for _, desire in behavior.desires)]
    sources = [Path(inspect.getfile(getattr(kernel, "py_func", kernel))) for kernel in functions]
    files = {file for source in sources for file in source.parent.glob("*.py")}
    digests = [hashlib.sha256(file.read_bytes()).hexdigest() for file in sorted(files)]
    return "_" + hashlib.sha256("".join(digests).encode()).hexdigest()[:16] if files else ""


_FOREIGN = _registered()
FOREIGN_CODE = _code_of(_FOREIGN)
BEHAVIORS = (*OURS, *_FOREIGN)
INTENTIONS = tuple(behavior.name for behavior in BEHAVIORS)


def desires_of(behaviors: Sequence[Behavior]) -> list[tuple[int, int, Desire]]:
    """List every desire as (level, behavior, function), most urgent first."""
    rows = [
        (level, code, desire)
        for code, behavior in enumerate(behaviors)
        for level, desire in behavior.desires
    ]
    return sorted(rows, key=lambda row: row[:2])


SOURCE = """
def compute_desires{name}(who, fishes, minds, sea, nature, clock):
    out = minds.desire
    {desires}

def run_routine{name}(code, who, fishes, minds, sea, nature, clock):
    {routines}
"""


def dispatchers(behaviors: Sequence[Behavior], name: str = "") -> tuple[Any, Any]:
    """Make the kernels that fill `minds.desire` and that follow an intention, by its code.

    A kernel cannot loop over functions, so they have a line for each row of the table. Tables with
    other behaviors need a `name` of their own, by which the compiled code is kept.
    """
    given = "who, fishes, minds, sea, nature, clock"
    names: dict[str, Any] = {"__name__": __name__}
    desires, routines = [], []
    for row, (_, _, desire) in enumerate(desires_of(behaviors)):
        names[f"desire_{row}"] = desire
        desires.append(f"desire_{row}({given}, out[{row}])")
    for code, behavior in enumerate(behaviors):
        names[f"routine_{code}"] = behavior.routine
        routines.append(f"{'elif' if code else 'if'} code == {code}: routine_{code}({given})")
    source = SOURCE.format(
        name=name, desires="\n    ".join(desires), routines="\n    ".join(routines)
    )
    # Compiled under this file's name, so that numba caches it with this file's kernels.
    exec(compile(source, __file__, "exec"), names)
    return kernel(names[f"compute_desires{name}"]), kernel(names[f"run_routine{name}"])


DESIRES = desires_of(BEHAVIORS)
LEVEL_OF_DESIRE = np.array([level for level, _, _ in DESIRES])
BEHAVIOR_OF_DESIRE = np.array([code for _, code, _ in DESIRES])
TIRES = np.array([behavior.tires for behavior in BEHAVIORS])
compute_desires, run_routine = dispatchers(BEHAVIORS, FOREIGN_CODE)


def run_routines(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
) -> None:
    """Let each of the fishes `who` follow its intention, one intention after the other."""
    now = minds.intention[who]
    for code in np.flatnonzero(np.bincount(now)):
        follow = partial(_follow, int(code), nature, clock)
        if BEHAVIORS[code].in_turn:
            follow(who[now == code], fishes, minds, sea)
        else:
            share(follow, who[now == code], LEAST_PART, fishes, minds, sea)


def _follow(
    code: int, nature: Nature, clock: Clock, who: Ints, fishes: Fishes, minds: Minds, sea: Sea
) -> None:
    run_routine(code, who, fishes, minds, sea, nature, clock)
