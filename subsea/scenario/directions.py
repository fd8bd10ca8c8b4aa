"""Directions: scripted events of a scenario, from its tables `[[direction]]`.

A direction begins once all its conditions hold. `directing` carries it out.
"""

from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, NamedTuple, NoReturn

import msgspec
from msgspec.structs import replace

from subsea.base.errors import UserError, unknown
from subsea.fish.surface import Share

MAX_DIRECTIONS = 200
Coordinate = Annotated[float, msgspec.Meta(ge=-1e5, le=1e5)]
Place = tuple[Coordinate, Coordinate, Coordinate]
Flow = Annotated[float, msgspec.Meta(ge=-200, le=200)]
Habit = Literal["brightness", "darkness", "cold", "warmth"]
Number = Annotated[int, msgspec.Meta(ge=0, lt=100_000)]
Seconds = Annotated[float, msgspec.Meta(ge=0, le=1e5)]
Event = Literal[
    "courting", "spawned", "eaten", "caught", "sated", "fleeing", "hunting", "passes"
]  # fmt: skip

MOVES = ("path_cm", "hunger", "libido", "fear", "likes", "hunts", "rests")
"""Influences on the fishes that `who` selects."""

INFLUENCES = (*MOVES, "pair", "current_cm_s", "hook", "lights", "camera", "caption", "end")


class FishSelector(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Select the fishes of a shoal, one fish, or all of a species."""

    shoal: Number | None = None  # its number, from 0
    fish: Number | None = None  # its number from 0, counted through all shoals
    species: str | None = None

    def __post_init__(self) -> None:
        """Require exactly one."""
        given = (self.shoal is not None) + (self.fish is not None) + (self.species is not None)
        if given != 1:
            raise ValueError("expected one of `shoal`, `fish` and `species`")


class Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A directed camera: a tour, or a position and a target."""

    tour: str | None = None  # the name of a tour, which starts over
    position_cm: Place | None = None  # its position; None: `distance_cm` from the target
    look_at_cm: Place | None = None
    follow: FishSelector | Literal["cast"] | None = None  # fishes; "cast": those of the event
    distance_cm: Annotated[float, msgspec.Meta(ge=60, le=5000)] = 200.0
    behind: bool = False  # film from behind its target, not from its own side
    over_s: Seconds = 3.0  # duration of the way there, longer if it is far; 0: a cut

    def __post_init__(self) -> None:
        """Require exactly one target."""
        if self.look_at_cm is not None and self.follow is not None:
            raise ValueError("only one of `look_at_cm` and `follow` can be looked at")
        looks = self.look_at_cm is not None or self.follow is not None
        if self.tour is not None and (looks or self.position_cm is not None):
            raise ValueError("a `tour` says itself where it is and what it looks at")
        if self.tour is None and not looks:
            raise ValueError("expected `tour`, `look_at_cm` or `follow`")
        if self.look_at_cm is not None and self.position_cm is None:
            raise ValueError("`look_at_cm` needs a `position_cm`")
        if self.behind and (self.follow is None or self.position_cm is not None):
            raise ValueError("`behind` is for `follow` without a `position_cm`")


class Direction(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One scripted event: its conditions and its effects."""

    # For other directions (`after`) and for records.
    name: Annotated[str, msgspec.Meta(max_length=60)] = ""

    # Conditions; the event begins once all are met, or at once if there are none.
    at_s: Seconds | None = None  # not before
    after: str | None = None  # not before the direction of this name has begun ...
    delay_s: Seconds = 0.0  # ... and this delay has passed
    event: Event | None = None
    of: FishSelector | None = None  # of the event; None: any fish, or the submarine for "passes"
    gate_cm: Place | None = None  # the place to pass ...
    radius_cm: Annotated[float, msgspec.Meta(gt=0, le=1e5)] = 100.0  # ... within this distance
    fewer_than: Annotated[int, msgspec.Meta(ge=1, le=100_000)] | None = None  # living fishes
    once: bool = True  # else each time that the conditions become true
    every_s: Annotated[float, msgspec.Meta(ge=0.1, le=1e5)] | None = None  # repeat while true

    # Effects, affected fishes and durations.
    who: FishSelector | None = None  # affected fishes
    path_cm: Annotated[list[Place], msgspec.Meta(min_length=1, max_length=200)] | None = None
    loop: bool = False  # repeat the path
    speed_cm_s: Annotated[float, msgspec.Meta(gt=0, le=1000)] | None = None  # None: cruising speed
    hunger: Share | None = None
    libido: Share | None = None
    fear: Share | None = None
    over_s: Seconds = 0.0  # duration of a change
    for_s: Seconds | None = None  # duration of holding it
    likes: list[Habit] | None = None  # Tu §7.3
    hunts: FishSelector | Literal["any"] | None = None  # predators: hunt only these
    rests: bool = False  # predators stop hunting
    pair: tuple[Number, Number] | Literal["nearest"] | None = None  # two fishes court ...
    place_cm: Place | None = None  # ... there
    current_cm_s: tuple[Flow, Flow] | None = None
    hook: Literal["down", "up"] | None = None
    lights: bool | None = None  # of the submarine
    camera: Camera | None = None
    caption: Annotated[str, msgspec.Meta(min_length=1, max_length=300)] | None = None
    end: bool = False  # end the directed film

    @property
    def influences(self) -> tuple[str, ...]:
        """The names of its influences."""
        values = {name: getattr(self, name) for name in INFLUENCES}
        values |= {"rests": self.rests or None, "end": self.end or None}
        return tuple(name for name, value in values.items() if value is not None)


class Shoals(NamedTuple):
    """Valid references of directions: species and size of each shoal, kind of each fish."""

    species: Sequence[str]
    numbers: Sequence[int]
    kind: Sequence[str]  # of each fish


def check_directions(
    directions: Sequence[Direction],
    shoals: Shoals,
    tours: Sequence[str],
    hook: bool,
    inside: Callable[[str, Place], None],
) -> None:
    """Raise a UserError with its key for a direction that cannot be carried out.

    `tours` are the names of the scenario's tours; `hook` is true if it has a hook; `inside` raises
    a UserError for the key of a place outside the sea.
    """
    names: dict[str, int] = {}
    for k, one in enumerate(directions):
        if one.name and names.setdefault(one.name, k) != k:
            _refuse(f"direction[{k}].name", f"the name {one.name!r} is taken, expected another")
    for k, one in enumerate(directions):
        here = f"direction[{k}]"
        for key, fault in _faults(one, shoals, tours, hook):
            _refuse(f"{here}.{key}" if key else here, fault)
        if one.after is not None and one.after not in names:
            _refuse(f"{here}.after", unknown("direction", one.after, list(names)).message)
        for key in ("gate_cm", "place_cm"):
            if (place := getattr(one, key)) is not None:
                inside(f"{here}.{key}", place)
        for i, place in enumerate(one.path_cm or []):
            inside(f"{here}.path_cm[{i}]", place)
        for key in ("position_cm", "look_at_cm"):
            if one.camera is not None and (place := getattr(one.camera, key)) is not None:
                inside(f"{here}.camera.{key}", place)
    for k in range(len(directions)):
        chain = [k]
        while (after := directions[chain[-1]].after) is not None:
            if (before := names[after]) in chain:
                expected = "expected a direction that can begin before it"
                _refuse(
                    f"direction[{k}].after", f"it waits for itself, by way of {after!r}, {expected}"
                )
            chain.append(before)


def _refuse(key: str, fault: str) -> NoReturn:
    raise UserError(f"`{key}`: {fault}", key=key)


def _faults(
    one: Direction, shoals: Shoals, tours: Sequence[str], hook: bool
) -> list[tuple[str, str]]:
    """Key and fault of each error in a single direction."""
    faults: list[tuple[str, str]] = []
    wholes = [("of", one.of), ("who", one.who)]
    wholes += [("hunts", one.hunts)] if isinstance(one.hunts, FishSelector) else []
    if one.camera is not None and isinstance(one.camera.follow, FishSelector):
        wholes.append(("camera.follow", one.camera.follow))
    for key, whose in wholes:
        if whose is not None:
            faults += [(f"{key}.{which}", fault) for which, fault in _strangers(whose, shoals)]
    if faults:
        return faults
    if not one.influences and not one.name:
        expected = f"expected one of {', '.join(INFLUENCES)}, or a name that others follow"
        faults.append(("", f"nothing happens: {expected}"))
    moved = [name for name in MOVES if name in one.influences]
    if moved and one.who is None:
        faults.append(("who", f"missing: whom `{moved[0]}` is about"))
    if one.who is not None and not moved and one.pair != "nearest":
        faults.append(("who", f"nothing moves them: expected one of {', '.join(MOVES)}"))
    if one.pair == "nearest" and one.who is None:
        faults.append(("who", "missing: among whom the nearest two are to be found"))
    if isinstance(one.pair, tuple) and max(one.pair) >= len(shoals.kind):
        faults.append(("pair", _no_fish(max(one.pair), shoals)))
    elif isinstance(one.pair, tuple) and one.pair[0] == one.pair[1]:
        faults.append(("pair", "a fish cannot court itself, expected two"))
    if isinstance(one.pair, tuple):
        faults += [
            ("pair", f"fish {i} is a {shoals.kind[i]}, expected two pacifists: only they court")
            for i in one.pair
            if i < len(shoals.kind) and shoals.kind[i] != "pacifist"
        ]
    if (one.event == "passes") != (one.gate_cm is not None):
        faults.append(("gate_cm", 'goes with `event = "passes"`, and that with it'))
    if one.of is not None and one.event is None and one.fewer_than is None:
        faults.append(("of", "expected an `event` or `fewer_than` that is theirs"))
    if one.delay_s and one.after is None:
        faults.append(
            ("delay_s", "expected the direction `after` which it waits, or a later `at_s`")
        )
    for key in ("speed_cm_s", "loop"):
        if getattr(one, key) and one.path_cm is None:
            faults.append((key, "expected a `path_cm`"))
    if one.place_cm is not None and one.pair is None:
        faults.append(("place_cm", "expected a `pair`"))
    if one.pair is not None and one.path_cm is not None:
        faults.append(("pair", "a pair that courts follows no path, expected `place_cm`"))
    if one.hunts is not None and one.rests:
        faults.append(("rests", "who `hunts` does not rest, expected one of them"))
    if one.hook is not None and not hook:
        faults.append(("hook", "expected a table [hook] that says where it hangs"))
    if one.camera is not None and one.camera.tour is not None and one.camera.tour not in tours:
        faults.append(("camera.tour", unknown("tour", one.camera.tour, list(tours)).message))
    about = one.event is not None or one.after is not None or one.pair is not None
    if one.camera is not None and one.camera.follow == "cast" and not about:
        faults.append(("camera.follow", 'of "cast": expected an `event`, `pair` or `after`'))
    for name, kind in (("hunts", "predator"), ("rests", "predator"), ("fear", "prey"),
                       ("libido", "pacifist"), ("pair", "pacifist")):  # fmt: skip
        if name == "pair" and one.pair != "nearest":
            continue  # the pair is not part of `who`
        if one.who is not None and name in one.influences:
            kinds = {shoals.kind[i] for i in numbers_of(one.who, shoals)}
            if kinds and kind not in kinds:
                faults.append((name, f"there is no {kind} among them, expected one"))
    return faults


def numbers_of(whose: FishSelector, shoals: Shoals) -> range | list[int]:
    """The numbers of the selected fishes that exist."""
    if whose.fish is not None:
        return range(whose.fish, min(whose.fish + 1, sum(shoals.numbers)))
    if whose.shoal is not None:
        if whose.shoal >= len(shoals.numbers):
            return range(0)
        first = sum(shoals.numbers[: whose.shoal])
        return range(first, first + shoals.numbers[whose.shoal])
    found: list[int] = []
    first = 0
    for species, number in zip(shoals.species, shoals.numbers, strict=True):
        if species == whose.species:
            found += range(first, first + number)
        first += number
    return found


def renumbered(
    directions: Sequence[Direction], fish: Callable[[int], int], shoal: Callable[[int], int]
) -> list[Direction]:
    """Renumber fishes and shoals in directions by two functions from old to new numbers.

    -1 means removed: directions about it are dropped, with those that wait for them.
    """

    def now(whose: Any) -> Any:
        if isinstance(whose, FishSelector) and whose.fish is not None:
            return replace(whose, fish=fish(whose.fish))
        if isinstance(whose, FishSelector) and whose.shoal is not None:
            return replace(whose, shoal=shoal(whose.shoal))
        return whose

    def is_gone(whose: Any) -> bool:
        return isinstance(whose, FishSelector) and -1 in (whose.fish, whose.shoal)

    left: list[Direction] = []
    gone: set[str] = set()
    for one in directions:
        if one.camera is not None:
            one = replace(one, camera=replace(one.camera, follow=now(one.camera.follow)))
        if isinstance(one.pair, tuple):
            one = replace(one, pair=(fish(one.pair[0]), fish(one.pair[1])))
        one = replace(one, of=now(one.of), who=now(one.who), hunts=now(one.hunts))
        follow = one.camera.follow if one.camera is not None else None
        lost = any(map(is_gone, (one.of, one.who, one.hunts, follow)))
        if lost or (isinstance(one.pair, tuple) and -1 in one.pair):
            gone.add(one.name)
        else:
            left.append(one)
    while orphans := [one for one in left if one.after is not None and one.after in gone]:
        gone |= {one.name for one in orphans}
        left = [one for one in left if one not in orphans]
    return left


def _strangers(whose: FishSelector, shoals: Shoals) -> list[tuple[str, str]]:
    """Key and fault of a selector of fishes that do not exist."""
    if whose.shoal is not None and whose.shoal >= len(shoals.species):
        last = len(shoals.species) - 1
        return [("shoal", f"{whose.shoal}: there is no such shoal, expected 0 to {last}")]
    if whose.fish is not None and whose.fish >= len(shoals.kind):
        return [("fish", _no_fish(whose.fish, shoals))]
    if whose.species is not None and whose.species not in shoals.species:
        return [("species", unknown("fish", whose.species, sorted(set(shoals.species))).message)]
    return []


def _no_fish(fish: int, shoals: Shoals) -> str:
    last = len(shoals.kind) - 1
    return f"{fish}: there is no such fish, expected " + (f"0 to {last}" if last >= 0 else "none")
