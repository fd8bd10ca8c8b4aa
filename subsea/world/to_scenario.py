"""Export a world as a scenario, with the parameters that panels have changed.

These are traits of fishes, constants of all fishes, the current and the physics. Traits that a
whole shoal shares go into its table, traits of single fishes into `[[individual]]`. Present hunger
and libido are not exported.

`Tunables` copy these parameters. Together with a snapshot, which holds all that a tick changes,
they are the complete state of a world.
"""

from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from subsea.behavior.mental_state import (
    DIGESTION,
    DREAD_CM,
    HABITS,
    LIBIDO_RATE,
    SEAS_OWN,
    TRAITS_OF_CHARACTER,
    appetite_of,
    character_of,
    males_of,
)
from subsea.fish.character import MEAN_RANGE
from subsea.scenario.schema import IndividualTable, NatureTable, PhysicsTable, Scenario, Shoal
from subsea.state import KINDS, TRAITS, Nature, Physics
from subsea.world.world import World


class Tunables(NamedTuple):
    """A copy of the parameters that panels edit."""

    nature: Nature
    current_cm_s: tuple[float, float]  # strength of the swinging current along x and y
    physics: Physics  # of simulated fishes
    traits: dict[str, NDArray[Any]]  # by the names in `state.TRAITS`


def get_tunables(world: World) -> Tunables:
    """Copy the parameters of a world."""
    traits = {name: getattr(world.state.minds, name).copy() for name in TRAITS}
    return Tunables(world.nature, world.current_cm_s, world.physics, traits)


def set_tunables(world: World, tunables: Tunables) -> None:
    """Restore the parameters of a world.

    Call it before `snapshot.restore`: the values allowed in a snapshot depend on the traits.
    """
    world.nature, world.current_cm_s, world.physics = tunables[:3]
    for name, values in tunables.traits.items():
        getattr(world.state.minds, name)[...] = values


def equal_tunables(first: Tunables, second: Tunables) -> bool:
    """True if worlds with these parameters continue equally from the same snapshot."""
    return first[:3] == second[:3] and all(
        np.array_equal(values, second.traits[name]) for name, values in first.traits.items()
    )


Columns = dict[str, NDArray[Any]]  # one value for each fish, by the keys of `Individual`

RATES = {
    "digestion": DIGESTION, "libido_rate": LIBIDO_RATE, "dread_cm": DREAD_CM,
    "dusk": SEAS_OWN, "mild": SEAS_OWN,
}  # fmt: skip


def to_scenario(world: World) -> Scenario:
    """Make the scenario of a world with its present parameters."""
    shoals, tables = _fishes(world)
    return replace(
        world.scenario,
        fish=shoals,
        individual=tables,
        nature=NatureTable(**world.nature._asdict()),
        physics=PhysicsTable(**world.physics._asdict()),
        water=replace(world.scenario.water, current_cm_s=world.current_cm_s),
    )


def _fishes(world: World) -> tuple[list[Shoal], list[IndividualTable]]:
    """Make the shoals, and the tables of single fishes."""
    scenario = world.scenario
    given = {table.fish: table for table in scenario.individual}
    shoals: list[Shoal] = []
    tables = []
    first = 0
    for shoal in scenario.fish:
        these = slice(first, first + shoal.number)
        traits = _traits(world, these)
        shoal = _common(world, shoal, these, traits)
        usual = _usual(world, shoal, these, traits)
        differs = {key: _unlike(traits[key], usual[key]) for key in traits}
        for i in range(shoal.number):
            table = given.get(first + i, IndividualTable(fish=first + i))
            keys = [k for k in traits if differs[k][i] or getattr(table, k) is not None]
            table = replace(table, **{key: _plain(key, traits[key][i]) for key in keys})
            if table.fish in given or keys:
                tables.append(table)
        shoals.append(shoal)
        first += shoal.number
    tables += [table for fish, table in given.items() if fish >= first]
    return shoals, tables


def _traits(world: World, these: slice) -> Columns:
    minds = world.state.minds
    return {
        "kind": minds.kind[these], "male": minds.male[these], "likes": minds.likes[these],
        "schooling": minds.schools[these], "appetite": minds.appetite[these],
        "digestion": minds.digestion[these], "libido_rate": minds.libido_rate[these],
        "dread_cm": minds.dread[these], "dusk": minds.dusk[these], "mild": minds.mild[these],
        **{name: getattr(minds, name)[these] for name in TRAITS_OF_CHARACTER},
    }  # fmt: skip


def _usual(world: World, shoal: Shoal, these: slice, traits: Columns) -> Columns:
    """Return the traits that a shoal's table gives to its fishes, of the kinds in `traits`."""
    species = world.species[world.scenario.species.index(shoal.species)]
    character = character_of(shoal, species, world.state.seed, these.start, shoal.number)
    appetite = appetite_of(world.state.fishes.length[these], traits["kind"])
    schooling = species.schooling if shoal.schooling is None else shoal.schooling
    rates = {
        key: usual if getattr(shoal, key) is None else getattr(shoal, key)
        for key, usual in RATES.items()
    }
    return {
        "kind": np.full(shoal.number, KINDS.index(shoal.kind or species.kind), np.uint8),
        "male": males_of(shoal, shoal.number),
        "likes": np.tile([name in shoal.likes for name in HABITS], (shoal.number, 1)),
        "schooling": np.full(shoal.number, schooling),
        "appetite": np.float32(appetite) * character["appetite"],
        **{name: character[name] for name in TRAITS_OF_CHARACTER},
        **{key: np.full(shoal.number, rate, np.float32) for key, rate in rates.items()},
    }


def _common(world: World, shoal: Shoal, these: slice, traits: Columns) -> Shoal:
    """Give a shoal the traits that all of its fishes share, where its table has others."""
    if not shoal.number:
        return shoal
    usual = _usual(world, shoal, these, traits)
    for key in ("kind", "likes", "schooling", *RATES, *TRAITS_OF_CHARACTER):
        values = traits[key]
        alike = not _unlike(values, np.broadcast_to(values[0], values.shape)).any()
        if alike and _unlike(values, usual[key]).all():
            value = _plain(key, values[0])
            if key in TRAITS_OF_CHARACTER:
                low, high = MEAN_RANGE
                value = (min(max(value, low), high), 0.0)
            shoal = replace(shoal, **{key: value})
    males = traits["male"]
    if males.all() != males.any() or not _unlike(males, usual["male"]).any():
        return shoal
    return replace(shoal, male_share=float(males[0]))


def _unlike(first: NDArray[Any], second: NDArray[Any]) -> NDArray[np.bool_]:
    """Select the fishes (n,) whose values differ."""
    unlike = first != second
    return unlike if unlike.ndim == 1 else unlike.any(axis=1)


def _plain(key: str, value: Any) -> Any:
    """Convert a trait to the value of a file."""
    if key == "kind":
        return KINDS[value]
    if key == "likes":
        return [name for name, on in zip(HABITS, value, strict=True) if on]
    if key in ("male", "schooling"):
        return bool(value)
    return float(str(value))  # with the digits of single precision
