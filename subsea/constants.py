"""What no tick changes, but a panel may while diving: as it is now, and back.

`snapshot` holds all that a tick changes. The two together are a world at a moment.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.behavior.temper import HABITS
from subsea.scenario import Individual, PhysicsTable, Scenario, Temper
from subsea.state import KINDS, Nature, Physics
from subsea.world import MINDS, World


class Constants(NamedTuple):
    """A copy: nothing that happens to the world changes it."""

    nature: Nature
    current_cm_s: tuple[float, float]  # strength of the swinging current along x and y
    physics: Physics  # of the fishes that are simulated
    minds: dict[str, NDArray[Any]]  # by the names of `MINDS`


def constants_of(world: World) -> Constants:
    """The constants of a world as they are now."""
    minds = {name: getattr(world.state.minds, name).copy() for name in MINDS}
    return Constants(world.nature, world.current_cm_s, world.physics, minds)


def put_back(world: World, constants: Constants) -> None:
    """Give the world the constants that `constants_of` saw in it.

    Before `snapshot.restore` of the same moment: what a snapshot may hold depends on them.
    """
    world.nature, world.current_cm_s, world.physics = constants[:3]
    for name, values in constants.minds.items():
        getattr(world.state.minds, name)[...] = values


def scenario_now(world: World) -> Scenario:
    """The scenario that a world began with, with its constants as they are now: to be saved.

    What panels changed in single fishes becomes their tables ``[[individual]]``; hunger and
    libido, which come and go, stay as they began. Numbers of single precision are told in few
    digits.
    """
    scenario, minds = world.scenario, world.state.minds
    tables = {one.fish: one for one in scenario.individual}
    for name, (key, told) in TOLD.items():
        now, begin = getattr(minds, name), world.tempers[name]
        changed = now != begin
        for fish in np.flatnonzero(changed if changed.ndim == 1 else changed.any(axis=1)):
            one = tables.get(int(fish), Individual(fish=int(fish)))
            tables[int(fish)] = msgspec.structs.replace(one, **{key: told(now[fish])})
    return msgspec.structs.replace(
        scenario,
        water=msgspec.structs.replace(
            scenario.water, current_cm_s=tuple(map(_few_digits, world.current_cm_s))
        ),
        nature=Temper(**_all_few(world.nature)),
        physics=PhysicsTable(**_all_few(world.physics)),
        individual=[tables[fish] for fish in sorted(tables)],
    )


def _all_few(values: Nature | Physics) -> dict[str, Any]:
    return {
        name: _few_digits(value) if isinstance(value, float) else value
        for name, value in values._asdict().items()
    }


def _few_digits(value: float) -> float:
    """The shortest number that is the same in single precision, if this is one of that."""
    single = np.float32(value)
    return float(str(single)) if float(single) == value else float(value)


TOLD: dict[str, tuple[str, Callable[[Any], Any]]] = {
    "kind": ("kind", lambda code: KINDS[code]),
    "male": ("male", bool),
    "likes": (
        "likes",
        lambda row: [name for name, likes in zip(HABITS, row, strict=True) if likes],
    ),
    "schools": ("schooling", bool),
    "digestion": ("digestion", lambda value: _few_digits(float(value))),
    "libido_rate": ("libido_rate", lambda value: _few_digits(float(value))),
    "dread": ("dread_cm", lambda value: _few_digits(float(value))),
}
"""What of `MINDS` a table of a single fish says, under which key, and how; the rest follows."""


def same(one: Constants, other: Constants) -> bool:
    """Whether worlds with these constants go on alike from the same snapshot."""
    return one[:3] == other[:3] and all(
        np.array_equal(values, other.minds[name]) for name, values in one.minds.items()
    )
