"""Rules of schools: the tables `[school]`, `[school.species.NAME]` and `[fish.rules]`.

A table gives only the keys that differ from the table before it; `USUAL` has all of them.
"""

from collections.abc import Sequence
from typing import Annotated, Any

import msgspec
from msgspec.structs import replace

from subsea.scenario.directions import Coordinate

MAX_GOALS = 2
MAX_COMPANIONS = 7  # companions that a fish attends to
MAX_RULES = 64  # different rules in a scenario

Portion = Annotated[float, msgspec.Meta(ge=0, le=1)]
RuleWeight = Annotated[float, msgspec.Meta(ge=0, le=10)]
NearRange = Annotated[float, msgspec.Meta(ge=0.1, le=5)]
FarRange = Annotated[float, msgspec.Meta(ge=0.1, le=50)]
SenseRange = Annotated[float, msgspec.Meta(ge=0, le=100)]


class Goal(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A goal of a share of the fishes of a school: a place or a direction."""

    share: Portion
    position_cm: tuple[Coordinate, Coordinate, Coordinate] | None = None
    heading_deg: Coordinate | None = None

    def __post_init__(self) -> None:
        """Refuse a goal that is both or neither."""
        if (self.position_cm is None) == (self.heading_deg is None):
            raise ValueError("expected one of `position_cm` and `heading_deg`")


class SchoolRules(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Rules of a school. None: as in the table before. Distances are in body lengths (`_bl`)."""

    separation_bl: NearRange | None = None  # apart within it
    attraction_bl: FarRange | None = None  # together beyond it ...
    full_attraction_bl: FarRange | None = None  # ... with full strength beyond this
    inertia: RuleWeight | None = None  # weights: of the fish's own heading
    alignment: RuleWeight | None = None
    separation: RuleWeight | None = None
    attraction: RuleWeight | None = None
    goal: RuleWeight | None = None  # of fishes that know where to go
    rejoin: RuleWeight | None = None  # toward the middle, of fishes outside of their school
    noise_deg: Annotated[float, msgspec.Meta(ge=0, le=180)] | None = None  # of the heading
    noise_s: Annotated[float, msgspec.Meta(ge=0.05, le=100)] | None = None  # its time constant
    pace_noise: Portion | None = None  # standard deviation of the logarithm of the speed
    neighbours: Annotated[int, msgspec.Meta(ge=1, le=MAX_COMPANIONS)] | None = None
    blind_deg: Annotated[float, msgspec.Meta(ge=0, le=360)] | None = None  # behind the fish
    sight_bl: SenseRange | None = None
    lateral_line_bl: SenseRange | None = None
    informed: Portion | None = None  # share that knows the destination, where `goals` is empty
    goals: Annotated[list[Goal], msgspec.Meta(max_length=MAX_GOALS)] | None = None
    goal_feedback: Annotated[float, msgspec.Meta(ge=0, le=10)] | None = None  # off course, less
    rest: Portion | None = None  # share of the time in which a school stays to feed
    moods: Portion | None = None  # how much hunger and fear change these rules
    contagion: Annotated[float, msgspec.Meta(ge=0, le=10)] | None = None  # 1/s, of moods


class SchoolTable(SchoolRules, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The rules of all schools, and those of single species."""

    species: dict[str, SchoolRules] = {}


USUAL = SchoolRules(
    separation_bl=0.9,
    attraction_bl=1.0,
    full_attraction_bl=3.0,
    inertia=0.15,
    alignment=0.7,
    separation=2.0,
    attraction=0.6,
    goal=0.5,
    rejoin=0.8,
    noise_deg=8.0,
    noise_s=1.0,
    pace_noise=0.12,
    neighbours=7,
    blind_deg=60.0,
    sight_bl=25.0,
    lateral_line_bl=1.5,
    informed=0.2,
    goals=[],
    goal_feedback=0.0,
    rest=0.3,
    moods=1.0,
    contagion=0.5,
)
NAMES = tuple(field.name for field in msgspec.structs.fields(SchoolRules))


def merged(tables: Sequence[SchoolRules]) -> SchoolRules:
    """Merge tables of rules key by key, later ones first; missing keys are `USUAL`.

    A missing `attraction_bl` is at least the given `separation_bl`.
    """
    given: dict[str, Any] = {}
    for table in tables:
        values = {name: getattr(table, name) for name in NAMES}
        given |= {name: value for name, value in values.items() if value is not None}
    usual: Any = USUAL.attraction_bl
    given.setdefault("attraction_bl", max(usual, given.get("separation_bl", usual)))
    return replace(USUAL, **given)
