"""Directions: scripted events of a scenario, from its tables `[[direction]]`.

A direction begins once all its conditions hold. `directing` carries it out.
"""

from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal

import msgspec
from msgspec.structs import replace

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
    radius_cm: Annotated[float, msgspec.Meta(ge=0.001, le=1e5)] = 100.0  # ... within this distance
    fewer_than: Annotated[int, msgspec.Meta(ge=1, le=100_000)] | None = None  # living fishes
    once: bool = True  # else each time that the conditions become true
    every_s: Annotated[float, msgspec.Meta(ge=0.1, le=1e5)] | None = None  # repeat while true

    # Effects, affected fishes and durations.
    who: FishSelector | None = None  # affected fishes
    path_cm: Annotated[list[Place], msgspec.Meta(min_length=1, max_length=200)] | None = None
    loop: bool = False  # repeat the path
    speed_cm_s: Annotated[float, msgspec.Meta(ge=0.001, le=1000)] | None = (
        None  # None: cruising speed
    )
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
