"""A scenario with what panels have changed in its world: what is to be saved of a dive.

Sexes, habits and tempers of fishes, what holds for all of them, the current and the physics. What
all of a shoal have in common goes into its own table, what single ones have into `[[individual]]`.
Hunger and libido of the moment are none of these: a dive begins with the scenario's.
"""

from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from subsea.behavior.mental_state import DIGESTION, DREAD_CM, LIBIDO_RATE
from subsea.behavior.temperament import HABITS, appetite_of, males_of
from subsea.fish.species import Species
from subsea.scenario.schema import Individual, PhysicsTable, Scenario, Shoal, Temper
from subsea.state import KINDS
from subsea.world.world import World

Columns = dict[str, NDArray[Any]]  # a value of each fish, by the keys of `Individual`

RATES = {"digestion": DIGESTION, "libido_rate": LIBIDO_RATE, "dread_cm": DREAD_CM}


def as_it_is(world: World) -> Scenario:
    """The scenario that a world began with, so that one made of it has the constants of now."""
    shoals, tables = _fishes(world)
    return replace(
        world.scenario,
        fish=shoals,
        individual=tables,
        nature=Temper(**world.nature._asdict()),
        physics=PhysicsTable(**world.physics._asdict()),
        water=replace(world.scenario.water, current_cm_s=world.current_cm_s),
    )


def _fishes(world: World) -> tuple[list[Shoal], list[Individual]]:
    """Shoals, and what single fishes have of their own."""
    scenario = world.scenario
    own = {one.fish: one for one in scenario.individual}
    shoals: list[Shoal] = []
    tables = []
    first = 0
    for shoal in scenario.fish:
        these = slice(first, first + shoal.number)
        species = world.species[scenario.species.index(shoal.species)]
        now = _now(world, these)
        shoal = _common(shoal, species, now)
        usual = _usual(shoal, species, now, world.state.fishes.length[these])
        differs = {key: _unlike(now[key], usual[key]) for key in now}
        for i in range(shoal.number):
            given = own.get(first + i, Individual(fish=first + i))
            keys = [k for k in now if differs[k][i] or getattr(given, k) is not None]
            one = replace(given, **{key: _plain(key, now[key][i]) for key in keys})
            if one.fish in own or keys:
                tables.append(one)
        shoals.append(shoal)
        first += shoal.number
    tables += [one for fish, one in own.items() if fish >= first]
    return shoals, tables


def _now(world: World, these: slice) -> Columns:
    minds = world.state.minds
    return {
        "kind": minds.kind[these], "male": minds.male[these], "likes": minds.likes[these],
        "schooling": minds.schools[these], "appetite": minds.appetite[these],
        "digestion": minds.digestion[these], "libido_rate": minds.libido_rate[these],
        "dread_cm": minds.dread[these],
    }  # fmt: skip


def _usual(shoal: Shoal, species: Species, now: Columns, length: NDArray[Any]) -> Columns:
    """What a shoal's table gives to its fishes, of the lengths and kinds that they have."""
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
        "appetite": appetite_of(length, now["kind"]).astype(np.float32),
        **{key: np.full(shoal.number, rate, np.float32) for key, rate in rates.items()},
    }


def _common(shoal: Shoal, species: Species, now: Columns) -> Shoal:
    """The shoal with what all of its fishes have, and would not have by its table."""
    if not shoal.number:
        return shoal
    usual = _usual(shoal, species, now, np.zeros(shoal.number))
    for key in ("kind", "likes", "schooling", *RATES):
        alike = not _unlike(now[key], np.broadcast_to(now[key][0], now[key].shape)).any()
        if alike and _unlike(now[key], usual[key]).all():
            shoal = replace(shoal, **{key: _plain(key, now[key][0])})
    males = now["male"]
    if males.all() != males.any() or not _unlike(males, usual["male"]).any():
        return shoal
    return replace(shoal, male_share=float(males[0]))


def _unlike(one: NDArray[Any], other: NDArray[Any]) -> NDArray[np.bool_]:
    """Of which fishes a value is another."""
    unlike = one != other
    return unlike if unlike.ndim == 1 else unlike.any(axis=1)


def _plain(key: str, value: Any) -> Any:
    """A value as a file has it."""
    if key == "kind":
        return KINDS[value]
    if key == "likes":
        return [name for name, on in zip(HABITS, value, strict=True) if on]
    if key in ("male", "schooling"):
        return bool(value)
    return float(str(value))  # in as few digits as single precision needs
