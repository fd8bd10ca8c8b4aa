"""Senses, feelings and intentions of the fishes (Tu chs. 6, 7)."""

from typing import Annotated, NamedTuple

from subsea.core.kernels.struct_ref import Kind, by_pointer
from subsea.state.codes import (
    ANYONE,
    BAIT,
    CHOICES,
    COURTSHIP,
    NEIGHBOURS,
    NOBODY,
    SUBMARINE,
    WALL,
    WANDER,
)
from subsea.state.declaration import (
    BOOL,
    F32,
    I8,
    I32,
    PANELS,
    U8,
    behavior,
    declared,
    directing,
    panels,
    perception,
)

NEVER = float("inf")
FISH = {"start": NOBODY, "within": (NOBODY, "n")}
INTENTION = {"start": -1, "within": (-1, "b")}


class MindsKind(Kind):
    """The compiler's type of `Minds`."""


@by_pointer(MindsKind)
class Minds(NamedTuple):
    """Minds of the n fishes, which know b behaviors and d desires.

    An eater of plankton is after a speck, a predator after a fish. Perception writes the rows of
    those fishes whose turn it is.
    """

    kind: Annotated[U8, panels("n"), "code in KINDS (Tu §7.9)"]
    male: Annotated[BOOL, panels("n"), "sex"]
    likes: Annotated[BOOL, panels("n", 4), "habits (Tu §7.3), columns BRIGHTNESS to WARMTH"]
    schools: Annotated[BOOL, panels("n"), "whether it likes schooling"]
    appetite: Annotated[
        F32, panels("n", unit="meals", start=1), "n^a: full after these; more for larger fishes"
    ]
    digestion: Annotated[F32, panels("n", unit="1/s"), "p0 (Tu §7.4)"]
    libido_rate: Annotated[F32, panels("n", unit="1/s"), "p1 (Tu §7.4)"]
    dread: Annotated[F32, panels("n", unit="cm"), "D0: distance of a predator at which fear is 1"]

    neighbour: Annotated[
        I32,
        perception("n", NEIGHBOURS, **FISH),
        "companions of its species, nearest first, or NOBODY",
    ]
    leader_place: Annotated[F32, perception("n", 3, unit="cm"), "where the leader was last seen"]
    leader_seen: Annotated[F32, perception("n", unit="s", start=-NEVER), "world time of that"]
    threat: Annotated[
        I32, perception("n", **FISH), "fish with the most imminent collision, or NOBODY"
    ]
    barrier: Annotated[
        I32,
        perception("n", start=-1, within=(WALL, "solids")),
        "obstacle ahead: pillar, rock, SEABED, SURFACE, WALL, or -1",
    ]
    predators: Annotated[
        I32,
        perception("n", CHOICES, start=NOBODY, within=(SUBMARINE, "n")),
        "those in sight, most dangerous first, or NOBODY",
    ]
    predator: Annotated[
        I32,
        perception("n", start=NOBODY, within=(SUBMARINE, "n")),
        "most dangerous one in sight, SUBMARINE, or NOBODY",
    ]
    menace: Annotated[F32, perception("n"), "F^m, fear of `predator`, in [0, 1]"]
    menaces: Annotated[F32, perception("n"), "sum of F^i over all predators in sight, at most 1"]
    food: Annotated[
        I32,
        perception("n", start=-1, within=(-1, "food")),
        "nearest speck perceived; of a predator: nearest prey; or -1",
    ]
    foods: Annotated[
        I32,
        perception("n", CHOICES, start=-1, within=(-1, "food")),
        "best specks perceived, nearest first; prey by cost; or -1",
    ]
    food_distance: Annotated[F32, perception("n", unit="cm", start=NEVER), "infinite for none"]
    mate: Annotated[I32, perception("n", **FISH), "nearest possible mate in sight, or NOBODY"]
    mates: Annotated[
        I32, perception("n", CHOICES, **FISH), "those in sight, its species first, nearest first"
    ]
    mate_distance: Annotated[F32, perception("n", unit="cm", start=NEVER), "infinite for none"]
    light: Annotated[F32, perception("n"), "ambient brightness, in [0, 1]"]
    temperature: Annotated[F32, perception("n", unit="°C"), "of the water"]
    target: Annotated[
        I32,
        perception("n", start=-1, within=(BAIT, "target")),
        "object of the intention: a fish, speck or BAIT, -1 for none",
    ]
    preference: Annotated[F32, perception("n", 6), "motor preferences, columns LEFT to DESCEND"]

    mental: Annotated[F32, behavior("n", 3), "columns HUNGER, LIBIDO, FEAR, in [0, 1]"]
    eaten: Annotated[F32, behavior("n", unit="meals"), "n^e, since the last complete digestion"]
    last_meal: Annotated[F32, behavior("n", unit="s"), "world time"]
    last_mating: Annotated[F32, behavior("n", unit="s"), "world time"]
    desire: Annotated[F32, behavior("d", "n"), "strength of each desire in `behavior/table.py`"]
    intention: Annotated[U8, behavior("n", start=WANDER, within=(0, "b")), "code, from AVOID on"]
    busy: Annotated[F32, behavior("n", unit="s"), "duration of this intention, or of a reaction"]
    fatigue: Annotated[F32, behavior("b", "n", unit="s"), "active less inactive time of a behavior"]
    pause: Annotated[F32, behavior("n", unit="s"), "time since the fish last had its turn"]
    memory: Annotated[
        I8, behavior("n", **INTENTION), "interrupted intention (Tu §7.7.1), -1 for none"
    ]
    memory_target: Annotated[
        I32,
        behavior("n", start=-1, within=(BAIT, "remembered")),
        "object of the interrupted intention",
    ]
    resumed: Annotated[BOOL, behavior("n"), "whether the intention came from memory"]
    urge: Annotated[F32, behavior("n", 3), "direction of the routine, any length, world axes"]
    waypoint: Annotated[F32, behavior("n", 3, unit="cm"), "destination of a wandering fish"]
    patience: Annotated[F32, behavior("n", unit="s"), "time until a wandering fish turns elsewhere"]
    leader: Annotated[
        I32, behavior("n", **FISH), "whom a schooling fish follows; NOBODY for leaders and loners"
    ]
    leads: Annotated[BOOL, behavior("n"), "whether others follow it"]
    partner: Annotated[
        I32, behavior("n", **FISH), "fish that it courts, or NOBODY; mutual from CIRCLING on"
    ]
    courtship: Annotated[U8, behavior("n", within=(0, len(COURTSHIP))), "code in COURTSHIP"]
    courtship_time: Annotated[F32, behavior("n", unit="s"), "time in this state"]
    courtship_count: Annotated[F32, behavior("n"), "points reached, turns or nudges in this state"]
    courtship_mark: Annotated[
        F32, behavior("n"), "start of that count: see `behavior/courtship.py`"
    ]
    alone: Annotated[F32, behavior("n", unit="s"), "time for which the partner minded others"]
    shunned: Annotated[
        I32, behavior("n", **FISH), "no longer courted: it refused, or they just spawned"
    ]
    shunning: Annotated[F32, behavior("n", unit="s"), "time until `shunned` is forgotten"]

    errand: Annotated[F32, directing("n"), "share of its fastest speed to its waypoint, 0 for none"]
    fright: Annotated[F32, directing("n", start=-1), "imposed fear; negative: what it sees decides"]
    fancy: Annotated[
        I8,
        directing("n", start=-1, within=(-1, 16)),
        "imposed habits: bits of the columns of `likes`, or -1",
    ]
    quarry: Annotated[
        I32,
        directing("n", 3, start=ANYONE, within=(-1, 2**31)),
        "prey allowed: first fish, last fish + 1, species or -1 for any",
    ]
    betrothed: Annotated[I32, directing("n", **FISH), "only possible partner, or NOBODY"]


TRAITS = tuple(name for name, spec in declared(Minds).items() if spec.writer == PANELS)
"""Sex, habits and temper of each fish: members of `Minds` that panels edit and no tick changes."""
