"""Rules of your own: functions over arrays as behaviors, senses and orders of a world.

A rule is a plain Python function or one of `numba.njit`. Its parameters are names of arrays, which
it sees as they are at the time and cannot write. It returns new values for the fishes `who`.
"""

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn, TypedDict

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError, nearest
from subsea.behavior.intention import APPETITE, COLLISION, DANGER, EASE, Behavior, Routine
from subsea.geometry.rotation import matrix
from subsea.lab.functions import identified, name_of, parameters_of, raised, short, stays
from subsea.library import World, check_rules
from subsea.state import Clock, Fishes, Minds, Nature, Sea, Spec, declared
from subsea.submarine.vessel import NEUTRAL
from subsea.world.step import Order
from subsea.world.world import World as State

LEVELS = {"collision": COLLISION, "danger": DANGER, "appetite": APPETITE, "ease": EASE}
SPEED = 0.5  # of a rule that returns none, share of the fastest speed
SHORTEST = 1e-9  # of a direction; a shorter one keeps the heading

Groups = tuple[Fishes, Minds, Sea, Nature, Clock]
PARTS: dict[str, int] = {
    name: place for place, group in ((2, Sea), (1, Minds), (0, Fishes)) for name in declared(group)
}
"""The place in `Groups` of each array by its name; of two, that of the fishes is meant."""
MORE: dict[str, Callable[[Ints, Groups, str], Any]] = {
    "who": lambda who, groups, name: who,
    "heading": lambda who, groups, name: _headings(groups[0]),
    "tick": lambda who, groups, name: groups[4].tick,
    "seed": lambda who, groups, name: groups[4].seed,
    "dt": lambda who, groups, name: groups[4].dt,
    "random": lambda who, groups, name: np.random.default_rng(
        [groups[4].seed, groups[4].tick, zlib.crc32(name.encode())]
    ),
}
"""Parameters beside the arrays of the state."""
SENSED = {
    name: spec
    for name, spec in declared(Minds).items()
    if spec.writer == "perception"
    and (spec.within is None or spec.within[1] in ("n", "solids", "sites"))
}
"""Arrays that a sense may write. The others point to different things in different fishes."""


@dataclass(frozen=True)
class Rule:
    """A function with the names of the arrays that it takes, for use as `name`."""

    name: str  # of the behavior, or of what a sense writes
    function: Callable[..., Any]
    use: str  # "behavior", "desire of", "sense" or "orders", for messages

    def __post_init__(self) -> None:
        """Refuse a function with unknown parameters: a UserError."""
        if not callable(self.function):
            raise TypeError(f"{self.use} {self.name!r}: expected a function, got {self.function!r}")
        try:
            wanted = self.parameters
        except (TypeError, ValueError):
            self.fail("the names of its parameters are unknown; wrap it in a function of Python")
        for one in wanted:
            if one not in PARTS and one not in MORE:
                hint = nearest(one, [*PARTS, *MORE]) or ""
                self.fail(f"unknown parameter {one!r}{hint}; `subsea.rule` tells the names")

    @cached_property
    def parameters(self) -> list[str]:
        """The parameters to fill, in order; those with a default value are left to it."""
        return parameters_of(self.function, MORE)

    @cached_property
    def description(self) -> str:
        """The names of its module and function, and a hash of its text and of its bound values."""
        return identified(self.function)

    def call(self, who: Ints, groups: Groups) -> Any:
        """Call the function for the fishes `who`; a UserError if it raises."""
        given = {
            name: MORE[name](who, groups, self.name)
            if name in MORE
            else _locked(getattr(groups[PARTS[name]], name))
            for name in self.parameters
        }
        try:
            return self.function(**given)
        except Exception as fault:
            self.fail(raised(fault), fault)

    def numbers(self, values: Any, shape: tuple[int, ...], what: str, who: Ints) -> Array:
        """Check what the function returned for the fishes `who`: finite numbers of a shape."""
        try:
            array = np.asarray(values, np.float64)
        except (TypeError, ValueError):
            self.fail(f"returned {what} {short(values)}, expected numbers")
        if array.shape != shape:
            expected = f"{shape}, a row for each of `who`"
            self.fail(f"returned {what} of shape {array.shape}, expected {expected}")
        wrong = ~np.isfinite(array).reshape(len(who), -1).all(axis=1)
        if wrong.any():
            fish = int(who[wrong.argmax()])
            value = array[wrong.argmax()]
            self.fail(f"returned {what} {short(value)} for fish {fish}, expected finite numbers")
        return array

    def within(self, array: Array, least: float, most: float, what: str, who: Ints) -> Array:
        """Check the range of numbers (k,)."""
        wrong = (array < least) | (array > most)
        if wrong.any():
            k = int(wrong.argmax())
            self.fail(
                f"returned {what} {array[k]:g} for fish {who[k]}, expected {least:g} to {most:g}"
            )
        return array

    def fail(self, why: str, fault: Exception | None = None) -> NoReturn:
        """Raise a UserError that names the rule."""
        raise UserError(
            f"{self.use} {self.name!r}, rule {name_of(self.function)}: {why}"
        ) from fault


@dataclass(frozen=True)
class Act:
    """The routine of a behavior: sets where fishes head, and how fast."""

    rule: Rule

    @property
    def description(self) -> str:
        """The names and the hash of the rule."""
        return self.rule.description

    def __call__(
        self, who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
    ) -> None:
        """Set the urge and the goal speed of the fishes `who`."""
        if not len(who):
            return
        found = self.rule.call(who, (fishes, minds, sea, nature, clock))
        way, pace = found if isinstance(found, tuple) and len(found) == 2 else (found, SPEED)
        if np.ndim(pace) == 0:
            pace = np.full(len(who), pace)
        way = self.rule.numbers(way, (len(who), 3), "directions", who)
        pace = self.rule.numbers(pace, (len(who),), "speeds", who)
        self.rule.within(pace, -1.0, 1.0, "a speed", who)
        sizes = np.linalg.norm(way, axis=1, keepdims=True)
        ahead = _headings(fishes)[who]
        minds.urge[who] = np.where(sizes > SHORTEST, way / np.maximum(sizes, SHORTEST), ahead)
        fishes.goal_speed[who] = pace


@dataclass(frozen=True)
class Wish:
    """A desire: a number, or a function that returns one for each fish."""

    rule: Rule | None
    strength: float = 0.0

    @property
    def description(self) -> str:
        """The names and the hash of the rule, or the strength."""
        return self.rule.description if self.rule else f"{self.strength:g}"

    def __call__(
        self, who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock,
        out: Array,
    ) -> None:  # fmt: skip
        """Write the strengths of the desire of the fishes `who` into `out` (n,)."""
        if self.rule is None:
            out[who] = self.strength
        elif len(who):
            found = self.rule.call(who, (fishes, minds, sea, nature, clock))
            wish = self.rule.numbers(found, (len(who),), "strengths", who)
            out[who] = self.rule.within(wish, 0.0, 1.0, "a strength", who)


@dataclass(frozen=True)
class Sensing:
    """A sense: writes one array of the minds."""

    rule: Rule
    spec: Spec

    @property
    def description(self) -> str:
        """The array that the sense writes, and the names and the hash of the rule."""
        return f"{self.rule.name}: {self.rule.description}"

    def __call__(
        self, who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock
    ) -> None:
        """Write what the fishes `who` perceive."""
        if not len(who):
            return
        target = getattr(minds, self.rule.name)
        found = self.rule.call(who, (fishes, minds, sea, nature, clock))
        shape = (len(who), *target.shape[1:])
        if self.spec.may_be_infinite:
            found = np.minimum(np.asarray(found, np.float64), np.finfo(np.float32).max)
        values = self.rule.numbers(found, shape, "values", who)
        if self.spec.within is not None:
            sizes = {
                "n": len(fishes.length),
                "solids": len(sea.pillars) + len(sea.rocks),
                "sites": len(sea.site_kind),
            }
            most = sizes[str(self.spec.within[1])] - 1
            rows = values.reshape(len(who), -1)
            for column in rows.T:
                self.rule.within(column, self.spec.within[0], most, "an index", who)
            if (values != np.round(values)).any():
                self.rule.fail("returned a fraction as an index, expected whole numbers")
        target[who] = values


def rule(
    name: str,
    function: Callable[..., Any],
    *,
    desire: float | Callable[..., Any] | None = None,
    level: str = "ease",
) -> Behavior:
    """Make a behavior of a function over arrays, for `subsea.load(…, behaviors=[…])`.

    Args:
        name: The behavior. One of ours, such as "school", is replaced; any other is added.
        function: A plain function, or one of `numba.njit`, that is called in each tick for the k
            fishes that follow this behavior and decide in this tick. It returns directions (k, 3)
            in world axes, of any length; a zero keeps the heading. Or it returns a pair of
            directions and speeds (k,), as shares of a fish's fastest speed, from -1 (astern) to 1;
            without speeds it is 0.5.
        desire: How strongly a fish wants this, from 0 to 1: a number, or a function that returns
            numbers (k,). None: as the behavior that is replaced, with its level.
        level: "collision", "danger", "appetite" or "ease". A desire comes before those of later
            levels; on one level the strongest wins.

    The parameters of both functions are names of arrays of all n fishes and of the sea, from
    docs/reference/state.md: `position`, `velocity`, `length`, `mental`, `leader`, `plankton` …
    More are `who` (k,), the fishes to decide for; `heading` (n, 3), unit vectors; `tick`; `dt`, s;
    `seed`; and `random`, a generator whose numbers depend on seed, tick and name only. Arrays
    cannot be written. Parameters with a default value are yours: set them with `functools.partial`.

    Obstacles still bend the way of a fish, and its motor system does the rest.

    Raises:
        UserError: An unknown parameter or level. While a world is stepped: a rule that raises, or
            that returns NaN, another shape or a value outside its range. The line names the rule.

    Examples:
        >>> def north(who):
        ...     return np.tile([0.0, 1.0, 0.0], (len(who), 1))
        >>> world = subsea.load("peaceful", fish=10, behaviors=[subsea.rule("wander", north)])
        >>> world.step(3)
    """
    if level not in LEVELS:
        raise UserError(f"unknown level {level!r}; expected one of {', '.join(LEVELS)}")
    act = Act(Rule(name, function, "behavior"))
    desires: tuple[tuple[int, Wish], ...] = ()
    if callable(desire):
        desires = ((LEVELS[level], Wish(Rule(name, desire, "desire of"))),)
    elif desire is not None:
        if not 0.0 <= float(desire) <= 1.0:
            raise UserError(f"behavior {name!r}: desire {desire!r}, expected 0 to 1")
        desires = ((LEVELS[level], Wish(None, float(desire))),)
    return Behavior(name, act, desires, whole=True)


def sense(name: str, function: Callable[..., Any]) -> Routine:
    """Make a sense of a function over arrays, for `subsea.load(…, senses=[…])`.

    Args:
        name: The array of the minds to write, after a fish's own senses have: one that
            docs/reference/state.md says perception writes, such as "light" or "neighbour".
        function: A function as of `subsea.rule`, which returns the values (k, …) of the k fishes
            `who` that perceive in this tick.

    Raises:
        UserError: An array that no sense may write, or an unknown parameter; otherwise as `rule`.

    Examples:
        >>> def dim(who, light):
        ...     return 0.1 * light[who]
        >>> world = subsea.load("peaceful", fish=10, senses=[subsea.sense("light", dim)])
        >>> world.step(3)
        >>> bool(world.minds.light.max() < 0.1)
        True
    """
    if name not in SENSED:
        hint = nearest(name, list(SENSED)) or f"; expected one of {', '.join(SENSED)}"
        raise UserError(f"sense {name!r}: no sense may write it{hint}")
    return Sensing(Rule(name, function, "sense"), SENSED[name])


class RulesGiven(TypedDict, total=False):
    """The keywords of `Rules`."""

    behaviors: Sequence[Behavior]
    senses: Sequence[Routine]
    orders: Callable[[World], Order | None] | None


@dataclass(frozen=True)
class Rules:
    """Behaviors, senses and orders of a program for a run."""

    behaviors: Sequence[Behavior] = ()
    senses: Sequence[Routine] = ()
    orders: Callable[[World], Order | None] | None = None

    def __post_init__(self) -> None:
        """Check the types; raises a TypeError."""
        check_rules(self.behaviors, self.senses)
        if self.orders is not None and not callable(self.orders):
            raise TypeError(f"orders: expected a function of a world, got {self.orders!r}")

    @property
    def fields(self) -> dict[str, Any]:
        """The same as fields of a `Run`."""
        orders = None if self.orders is None else Orders(self.orders)
        return {
            "behaviors": tuple(self.behaviors),
            "senses": tuple(self.senses),
            "orders": orders,
        }

    @property
    def stay(self) -> bool:
        """True if no other process can import the rules: a notebook, a script or a function."""
        return stays(self)


@dataclass(frozen=True)
class Orders:
    """A function that is asked for an order before each tick."""

    function: Callable[[World], Order | None]

    @cached_property
    def description(self) -> str:
        """The names and the hash of the function."""
        return identified(self.function)

    def __call__(self, state: State) -> Order:
        """Return the order; a UserError for a function that raises, and for an order of no use."""
        world = World(state)
        try:
            order = self.function(world)
        except Exception as fault:
            raise UserError(
                f"orders {name_of(self.function)}, tick {state.state.tick}: {raised(fault)}"
            ) from fault
        try:
            return NEUTRAL if order is None else world.checked(order)
        except (TypeError, ValueError) as fault:
            raise UserError(
                f"orders {name_of(self.function)}, tick {state.state.tick}: {fault}"
            ) from fault


def _headings(fishes: Fishes) -> Array:
    """Compute unit vectors (n, 3) along the bodies."""
    return np.asarray(matrix(np.asarray(fishes.orientation, np.float64))[..., 0])


def _locked(array: Any) -> Any:
    """View an array that cannot be written; numbers stay."""
    if not isinstance(array, np.ndarray):
        return array
    view: NDArray[Any] = array.view()
    view.flags.writeable = False
    return view
