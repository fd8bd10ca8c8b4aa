"""Groups of arrays: fishes, minds, surroundings, directions, submarine; parameters of a tick."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.geometry.solids import CELLS, RANGES_CM, REACHES_CM, SQUARES
from subsea.kernels.struct_ref import Kind, by_pointer
from subsea.scenario.school_rules import MAX_RULES
from subsea.state.codes import (
    ANYONE,
    BAIT,
    CHOICES,
    FEELINGS,
    FIN_COLUMNS,
    FINS_AT_EASE,
    NEIGHBOURS,
    NOBODY,
    STOWED,
    WALL,
    WANDER,
)
from subsea.state.declaration import (
    BOOL,
    COURTSHIP_STATE,
    F32,
    F64,
    FISH,
    FISH_OR_HULL,
    FOOD,
    HUNT_PHASE,
    I8,
    I32,
    I64,
    NUMBER,
    PANELS,
    ROW,
    SEGMENT,
    SITE,
    U8,
    U16,
    Spec,
    behavior,
    creation,
    declared,
    directing,
    habitat,
    motor,
    panels,
    perception,
    starts,
    submarine,
    written_by,
)
from subsea.state.school_rules import RULE_COLUMNS, USUAL_RULES

NEVER = float("inf")
MOST = 2**31 - 1  # counts and waiting times are below
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
water = written_by("habitat, behavior")
startled = written_by("behavior, motor")
hooked = written_by("habitat, behavior, directing")


class FishesKind(Kind):
    """The compiler's type of `Fishes`."""


@by_pointer(FishesKind)
class Fishes(NamedTuple):
    """Bodies of the n fishes of a dive. Playback mixes two rows of the motion library."""

    species: Annotated[U8, creation("n"), "index into the scenario's species"]
    length: Annotated[F32, creation("n", unit="cm"), "body length"]
    scale: Annotated[F32, creation("n", start=1), "length over recorded length: α, SMC eq. 12"]
    rate: Annotated[
        F32, creation("n", start=1), "recorded rows per tick, by size and pace of the species"
    ]
    size_rate: Annotated[F32, creation("n", start=1), "large fishes breathe and court slowly"]
    identity: Annotated[F32, creation("n"), "individual variation in [0, 1)"]
    snout: Annotated[F32, creation("n", unit="cm"), "x of the tip of the snout in body axes"]
    girth: Annotated[F32, creation("n", 2, unit="cm"), "height and width of the body without fins"]
    fast: Annotated[F32, creation("n", start=30, unit="cm/s"), "speed of its fast swim"]
    oars: Annotated[BOOL, creation("n"), "whether it rows with its pectoral fins (Tu appendix B.2)"]
    flaps: Annotated[BOOL, creation("n"), "whether it rows by flapping these fins up and down"]
    burst: Annotated[F32, creation("n", start=1), "greatest goal speed, in a burst"]
    ram: Annotated[F32, creation("n"), "least goal speed: a ram ventilator never stops"]

    position: Annotated[F32, motor("n", 3, unit="cm"), "origin of the body frame B, world axes"]
    orientation: Annotated[F32, motor("n", 4, start=UPRIGHT), "quaternion, body to world axes"]
    row_a: Annotated[ROW, motor("n"), "the pose mixes rows a and b of the library"]
    row_b: Annotated[ROW, motor("n"), "see `row_a`"]
    weight: Annotated[F32, motor("n"), "share of row b in the pose, in [0, 1)"]
    span: Annotated[F32, motor("n", start=1), "frames from a to b: 1 in playback, more in a glide"]
    previous_position: Annotated[F32, motor("n", 3, unit="cm"), "one tick ago"]
    previous_orientation: Annotated[F32, motor("n", 4, start=UPRIGHT), "one tick ago"]
    previous_row_a: Annotated[ROW, motor("n"), "one tick ago"]
    previous_row_b: Annotated[ROW, motor("n"), "one tick ago"]
    previous_weight: Annotated[F32, motor("n"), "one tick ago"]
    previous_span: Annotated[F32, motor("n", start=1), "one tick ago"]
    velocity: Annotated[
        F32,
        motor("n", 3, unit="cm/s"),
        "of the body frame, of a simulated fish of its centre of mass; world axes",
    ]
    segment: Annotated[SEGMENT, motor("n"), "code of the segment of row b"]
    wanted_segment: Annotated[SEGMENT, motor("n"), "request of the secondary controller"]
    tempo: Annotated[F32, motor("n", start=1), "playback rate of the segment, 1 is the recorded"]
    thrust: Annotated[F32, motor("n", start=1), "share of the recorded way; negative retreats"]
    glide_tempo: Annotated[F32, motor("n", start=1), "tempo at the start of the current glide"]
    glide_thrust: Annotated[F32, motor("n", start=1), "thrust at the start of the current glide"]
    bend: Annotated[F32, motor("n"), "turn asked for, over the gradual turn's, left positive"]
    steering: Annotated[F32, motor("n", 2, unit="rad/s"), "yaw and pitch added to the recording"]
    roll: Annotated[F32, motor("n", unit="rad"), "smoothed roll"]
    fin_phase: Annotated[
        F32,
        motor("n", 3, unit="rad"),
        "beat of the left and right pectoral fin, wave of dorsal and ventral fin",
    ]
    breath: Annotated[F32, motor("n", unit="rad"), "phase of breathing"]
    fins: Annotated[F32, motor("n", FIN_COLUMNS, start=FINS_AT_EASE), "columns SWEEP_LEFT to LAG"]
    previous_fins: Annotated[F32, motor("n", FIN_COLUMNS, start=FINS_AT_EASE), "one tick ago"]
    rested: Annotated[I8, motor("n", unit="tick", within=(0, 127)), "since its fins last moved"]
    monotony: Annotated[F32, motor("n", unit="s"), "time in the same segment"]
    recommended: Annotated[
        I8,
        motor("n", start=-1, within=(-1, "segments")),
        "swim recommended against monotony, -1 for none",
    ]
    live: Annotated[BOOL, motor("n"), "whether it is simulated, not played back"]
    stay: Annotated[F32, motor("n", unit="s", start=NEVER), "time since `live` changed"]

    startle: Annotated[
        F32, startled("n", unit="rad"), "C-start asked for by behavior, left positive; then 0"
    ]

    drift: Annotated[F32, water("n", 3, unit="cm/s"), "imposed by water, suction or a line"]

    alive: Annotated[BOOL, behavior("n", start=True), "False once it was eaten or landed"]
    goal_direction: Annotated[F32, behavior("n", 3), "unit vector, world axes"]
    goal_speed: Annotated[F32, behavior("n"), "share of the fast swim's speed; negative retreats"]
    gape: Annotated[F32, behavior("n"), "opening of the mouth asked for, in [0, 1]"]
    display: Annotated[F32, behavior("n"), "mating colours, to 1; paleness by night, to -1"]
    raised: Annotated[F32, behavior("n"), "raising of dorsal and ventral fin asked for, in [0, 1]"]
    close: Annotated[BOOL, behavior("n"), "whether it feeds or hides at stone, and may touch it"]
    shell: Annotated[
        F32, behavior("n", unit="cm"), "how deep it may be in the free shell around drawn stone"
    ]
    period: Annotated[
        F32, creation(2, unit="cm"), "of the box along x and y, 0 without periodic sides"
    ]


class Live(NamedTuple):
    """k slots for simulated fishes, at the size and pace of the recorded fish.

    Each slot owns two rows behind the recorded ones of the library, for this pose and the next.
    A fish keeps its slot until the glide back to playback has left the slot's rows.
    """

    fish: Annotated[FISH, motor("k"), "index of the fish, -1 for a free slot"]
    waiting: Annotated[I32, motor("k", unit="tick", within=(0, MOST)), "it has waited to leave"]
    x: Annotated[F64, motor("k", 23, 3, unit="cm"), "nodes relative to the origin of B, world axes"]
    v: Annotated[F64, motor("k", 23, 3, unit="cm/tu"), "velocity relative to the water"]
    phase: Annotated[F64, motor("k", unit="rad"), "of the beat"]
    tempo: Annotated[F64, motor("k", start=1), "of the beat, 1 is the recorded one"]
    gear: Annotated[F64, motor("k"), "of the beat: 0 still, 1 slow, 2 medium, 3 fast"]
    bend: Annotated[F64, motor("k", 2), "contractions of the two turning segments, left positive"]
    speed: Annotated[F64, motor("k", unit="cm/s"), "smoothed, along x, of the recorded fish"]
    course: Annotated[F64, motor("k", unit="rad"), "mean heading, without the beat of the head"]
    rotation: Annotated[F32, motor("2 k", 4), "rows of the library: rotation of B per frame"]
    translation: Annotated[F32, motor("2 k", 3, unit="cm"), "the same: way of B per frame"]
    nodes: Annotated[F32, motor("2 k", 23, 3, unit="cm"), "rows of the library: pose in body axes"]
    sway: Annotated[F32, motor("2 k", unit="rad"), "rows of the library: heading of B beyond it"]


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
    appetite: Annotated[F32, panels("n", unit="meals", start=1), "n^a, more for larger fishes"]
    digestion: Annotated[F32, panels("n", unit="1/s"), "p0 (Tu §7.4)"]
    libido_rate: Annotated[F32, panels("n", unit="1/s"), "p1 (Tu §7.4)"]
    dread: Annotated[F32, panels("n", unit="cm"), "D0: distance of a predator at which fear is 1"]
    timidity: Annotated[F32, panels("n", start=1), "factor on D0 and on the room for collisions"]
    devotion: Annotated[F32, panels("n", start=1), "factor on `nature.devotion_cm`"]
    activity: Annotated[F32, panels("n", start=1), "factor on its speed at ease"]
    sociability: Annotated[F32, panels("n", start=1), "over 1: nearer to companions"]
    dusk: Annotated[F32, panels("n", start=-1), "its own `nature.dusk`, or negative"]
    mild: Annotated[F32, panels("n", start=-1), "its own `nature.mild`, or negative"]

    home: Annotated[F32, creation("n", 3, unit="cm"), "place that it keeps to, as an anemone"]
    home_range: Annotated[F32, creation("n", unit="cm", start=NEVER), "how far it goes from there"]
    cruise_height: Annotated[
        F32, creation("n", 2, unit="cm", start=NEVER), "lowest and highest cruise over the ground"
    ]
    led: Annotated[BOOL, creation("n"), "whether it follows the leader of its school"]
    voracity: Annotated[F32, creation("n", start=1), "its appetite over the usual one"]
    diet: Annotated[U8, creation("n"), "foods on stone: bits 1 << TURF to 1 << RUBBLE, 0 for none"]
    ways: Annotated[U8, creation("n"), "how it lives on stone: bits HIDES, BATHES and CLEANS"]
    territory: Annotated[F32, creation("n", unit="cm"), "radius about its home that it guards"]
    scavenges: Annotated[BOOL, creation("n"), "whether it follows the odour of food and blood"]
    rules: Annotated[
        F64,
        creation(MAX_RULES, RULE_COLUMNS, start=USUAL_RULES),
        "rules of schools, columns SEPARATION_BL to GOALS of `state/school_rules.py`",
    ]
    school_rule: Annotated[U8, creation("n"), "row of `rules` by which it schools"]

    neighbour: Annotated[FISH, perception("n", NEIGHBOURS), "its species nearby, nearest first"]
    leader_place: Annotated[
        F32,
        perception("n", 3, unit="cm"),
        "where the leader, or the middle of its school, was last seen",
    ]
    leader_seen: Annotated[F32, perception("n", unit="s", start=-NEVER), "world time of that"]
    school_size: Annotated[F32, perception("n"), "fishes of its school, if that has no leader"]
    company_mood: Annotated[F32, perception("n"), "mean `mood` of its neighbours of the school"]
    threat: Annotated[FISH, perception("n"), "fish with the most imminent collision, or NOBODY"]
    barrier: Annotated[
        I32,
        perception("n", start=-1, within=(WALL, "solids")),
        "obstacle ahead: pillar, rock, SEABED, SURFACE, WALL, or -1",
    ]
    predators: Annotated[FISH_OR_HULL, perception("n", CHOICES), "in sight, most dangerous first"]
    predator: Annotated[FISH_OR_HULL, perception("n"), "most dangerous one in sight"]
    menace: Annotated[F32, perception("n"), "F^m, fear of `predator`, in [0, 1]"]
    menaces: Annotated[F32, perception("n"), "sum of F^i over all predators in sight, at most 1"]
    rival: Annotated[FISH, perception("n"), "nearest other predator, within its reach"]
    conceded: Annotated[FISH, perception("n"), "prey that it leaves to another predator"]
    scent: Annotated[F32, perception("n", 3), "odour at the nostrils, columns of ODOURS, 1/m³"]
    richer: Annotated[F32, perception("n", 3), "unit vector to more odour of food, or 0"]
    food: Annotated[FOOD, perception("n"), "nearest speck perceived; of a predator: nearest prey"]
    foods: Annotated[FOOD, perception("n", CHOICES), "nearest specks perceived, or prey by cost"]
    food_distance: Annotated[F32, perception("n", unit="cm", start=NEVER), "infinite for none"]
    mate: Annotated[FISH, perception("n"), "nearest possible mate in sight, or NOBODY"]
    mates: Annotated[FISH, perception("n", CHOICES), "in sight: its species first, nearest first"]
    mate_distance: Annotated[F32, perception("n", unit="cm", start=NEVER), "infinite for none"]
    light: Annotated[F32, perception("n"), "ambient brightness, in [0, 1]"]
    temperature: Annotated[F32, perception("n", unit="°C"), "of the water"]
    comfort: Annotated[
        F32,
        perception("n", 2, unit="cm", start=(0, NEVER)),
        "depths between which it likes light and temperature",
    ]
    target: Annotated[
        I32,
        perception("n", start=-1, within=(BAIT, "target")),
        "object of the intention: a fish, speck or BAIT, -1 for none",
    ]
    preference: Annotated[F32, perception("n", 6), "motor preferences, columns LEFT to DESCEND"]
    site: Annotated[SITE, perception("n"), "where it feeds, -1 for nowhere"]
    cover: Annotated[SITE, perception("n"), "nearest place to hide or bathe, -1 for none"]
    shadow: Annotated[F32, perception("n"), "darkest shadow of a large thing overhead, in [0, 1]"]
    dark: Annotated[BOOL, perception("n"), "whether it is too dark for it to be about"]
    intruder: Annotated[FISH, perception("n"), "fish in its territory, or NOBODY"]
    cleaner: Annotated[FISH, perception("n"), "cleaner whose station it knows, or NOBODY"]
    client: Annotated[
        FISH_OR_HULL, perception("n"), "fish that poses for this cleaner, SUBMARINE or NOBODY"
    ]

    mental: Annotated[F32, behavior("n", 3), "columns HUNGER, LIBIDO, FEAR, in [0, 1]"]
    eaten: Annotated[F32, behavior("n", unit="meals"), "n^e, since the last complete digestion"]
    last_meal: Annotated[F32, behavior("n", unit="s"), "world time"]
    last_mating: Annotated[F32, behavior("n", unit="s"), "world time"]
    ardent: Annotated[
        BOOL,
        written_by("behavior, directing")("n"),
        "whether its libido was set by a direction or a visitor: at any hour",
    ]
    desire: Annotated[F32, behavior("d", "n"), "strength of each desire in `behavior/table.py`"]
    intention: Annotated[U8, behavior("n", start=WANDER, within=(0, "b")), "code, from AVOID on"]
    busy: Annotated[F32, behavior("n", unit="s"), "duration of this intention, or of a reaction"]
    fatigue: Annotated[F32, behavior("b", "n", unit="s"), "active less inactive time of a behavior"]
    pause: Annotated[F32, behavior("n", unit="s"), "time since the fish last had its turn"]
    held: Annotated[
        F32,
        behavior("n", unit="s", start=NEVER),
        "time for which it has had this intention, or of a reaction since its cause was perceived",
    ]
    spent: Annotated[F32, behavior("n", unit="s"), "time of full burst not yet recovered"]
    startled: Annotated[F32, behavior("n", unit="s", start=NEVER), "time since its last C-start"]
    alert: Annotated[F32, behavior("n", unit="s"), "evidence of an attack: time at the threshold"]
    threat_place: Annotated[
        F32, behavior("n", 3, unit="cm"), "where it last perceived what it fears most"
    ]
    unseen: Annotated[F32, behavior("n", unit="s", start=NEVER), "time since it perceived that"]
    hull_dread: Annotated[
        F32, behavior("n", start=1), "share of the submarine's D0 left by habituation, in (0, 1]"
    ]
    inspection: Annotated[
        F32,
        behavior("n", unit="s"),
        "time for which it inspects a predator; negative: until it may again",
    ]
    hunt: Annotated[HUNT_PHASE, behavior("n"), "phase of a predator's hunt, code in HUNT"]
    hunt_time: Annotated[F32, behavior("n", unit="s"), "time in this phase"]
    lull: Annotated[F32, behavior("n", unit="s"), "time until a predator stalks again"]
    missed: Annotated[FISH, behavior("n"), "prey that it missed or gave up last, or NOBODY"]
    misses: Annotated[F32, behavior("n"), "rushes without a catch since the last one"]
    trail: Annotated[F32, behavior("n", unit="s", start=NEVER), "time since it lost an odour"]
    memory: Annotated[I8, behavior("n", start=-1, within=(-1, "b")), "interrupted (Tu §7.7.1)"]
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
        FISH, behavior("n"), "whom a schooling fish follows, or by whom its school is known"
    ]
    leads: Annotated[BOOL, behavior("n"), "whether others follow it, or a school is known by it"]
    mood: Annotated[F32, behavior("n"), "of a schooling fish: -1 feeds, 0 cruises, 1 is alarmed"]
    deviation: Annotated[
        F32,
        behavior("n", 3),
        "noise of heading, climb and speed in a school, in standard deviations",
    ]
    partner: Annotated[FISH, behavior("n"), "fish that it courts; mutual from CIRCLING on"]
    courtship: Annotated[COURTSHIP_STATE, behavior("n"), "code in COURTSHIP"]
    courtship_time: Annotated[F32, behavior("n", unit="s"), "time in this state"]
    courtship_count: Annotated[F32, behavior("n"), "points reached, turns or nudges in this state"]
    courtship_mark: Annotated[F32, behavior("n"), "see `behavior/courtship.py`"]
    alone: Annotated[F32, behavior("n", unit="s"), "time for which the partner minded others"]
    shunned: Annotated[FISH, behavior("n"), "no longer courted: it refused, or they just spawned"]
    shunning: Annotated[F32, behavior("n", unit="s"), "time until `shunned` is forgotten"]
    liked: Annotated[FISH_OR_HULL, behavior("n", FEELINGS), "whom it has a feeling for, or NOBODY"]
    liking: Annotated[F32, behavior("n", FEELINGS), "the feeling: -1 dislike to 1 liking"]
    peck: Annotated[F32, behavior("n", unit="s"), "time until it bites again at `site`"]
    wary: Annotated[F32, behavior("n", unit="s"), "time until it leaves its cover"]
    itch: Annotated[F32, behavior("n"), "how much it wants to be cleaned, or a cleaner the glass"]
    chaser: Annotated[FISH, behavior("n"), "whose territory it leaves, or NOBODY"]
    chased: Annotated[F32, behavior("n", unit="s"), "time until it forgets `chaser`"]

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
    betrothed: Annotated[FISH, directing("n"), "only possible partner, or NOBODY"]


TRAITS = tuple(name for name, spec in declared(Minds).items() if spec.writer == PANELS)
"""Sex, habits and mood of each fish: members of `Minds` that panels edit and no tick changes."""


class SeaKind(Kind):
    """The compiler's type of `Sea`."""


@by_pointer(SeaKind)
class Sea(NamedTuple):
    """Everything around the fishes that they may perceive."""

    heights: Annotated[F32, creation("m", "m", unit="cm"), "seabed: rows along y, columns along x"]
    floor: Annotated[F32, creation("m", "m", unit="cm"), "seabed with all that grows on it"]
    half_width: Annotated[NUMBER, creation(unit="cm"), "of the height field in x and y"]
    radius: Annotated[NUMBER, creation(unit="cm"), "of the cylinder that bounds the sea"]
    pillars: Annotated[F64, creation("k", 4, unit="cm"), "x, y, radius, height of the top"]
    rocks: Annotated[F64, creation("k", 7, unit="cm"), "ellipsoid: centre, half axes, yaw in rad"]
    tops: Annotated[
        F32,
        creation(len(RANGES_CM), CELLS, CELLS, unit="cm", start=NEVER),
        "height above which no rock is near: see `geometry/solids.py`",
    ]
    skyline: Annotated[
        F32,
        creation(len(REACHES_CM), SQUARES, SQUARES, unit="cm", start=NEVER),
        "height above which neither solid nor seabed is near",
    ]
    climate: Annotated[
        F64, creation(4), "°C at the surface and at a depth, that depth, 1/e depth of light, cm"
    ]

    plankton: Annotated[F32, habitat("p", 3, unit="cm"), "places of specks"]
    absent: Annotated[
        F32, water("p", unit="s"), "time until an eaten speck is back; negative: it sinks"
    ]
    deflection: Annotated[F32, habitat("p", 2), "of the current by solids, over its speed"]
    seaweed: Annotated[F32, habitat("c", 6, unit="cm"), "bounding box of each cluster: low, high"]

    sky: Annotated[
        F64, habitat(2, start=(12.0, 1.0)), "hour of the day in [0, 24); daylight, 0 at night to 1"
    ]

    submarine: Annotated[F64, written_by("world")(9), "cm, cm/s, unit vector ahead"]

    tackle: Annotated[
        F64,
        creation(5, start=(0, 0, 0, 0, NEVER)),
        "hook: x, y, depth, cm, speed, cm/s, time of its start, s",
    ]
    hook: Annotated[F64, written_by("habitat, directing")(3, unit="cm"), "place of the bait"]
    catch: Annotated[
        I64,
        hooked(2, start=(STOWED, NOBODY), within=(NOBODY, "catch")),
        "state of the hook, STOWED to LANDED, and fish on it, or NOBODY",
    ]

    crest: Annotated[NUMBER, creation(unit="cm", start=NEVER), "of the seabed inside the sea"]

    site_kind: Annotated[U8, creation("s"), "index into SITES"]
    site_place: Annotated[F32, creation("s", 3, unit="cm"), "on the drawn surface, or in its cover"]
    site_normal: Annotated[F32, creation("s", 3), "unit vector out of that surface"]
    site_depth: Annotated[F32, creation("s", unit="cm"), "below what fishes avoid around stone"]
    site_growth: Annotated[I32, creation("s", start=-1), "growth of the reef that it is on, or -1"]
    stones: Annotated[
        F64, creation("q", 11, unit="cm"), "blocks of drawn stone: see `habitat/formations.py`"
    ]
    stock: Annotated[F32, water("s", start=1), "share of the food that is left, in [0, 1]"]


class Seaweed(NamedTuple):
    """Seaweed (Tu §8.2): l leaves in c clusters, each a chain of m nodes from root to tip."""

    first: Annotated[I32, creation("c + 1"), "cluster k: leaves first[k] to first[k + 1] - 1"]
    rest: Annotated[F32, creation("l", "m - 1", unit="cm"), "from node to node, at rest"]
    lean: Annotated[F32, creation("l", "m", 3), "unit vectors of each node's buoyancy"]
    look: Annotated[F32, creation("l", 8), "width, facing, twist, identity, colour, length"]
    kind: Annotated[U8, creation("l"), "index into `habitat.seaweed.KINDS`"]
    cell_cm: Annotated[NUMBER, creation(unit="cm"), "of cells, in rows from the south-west"]
    cell_first: Annotated[I32, creation("cells + 1"), "start of each cell's list in `cell_cluster`"]
    cell_cluster: Annotated[I32, creation("entries"), "clusters that a fish in a cell may touch"]

    node: Annotated[F32, habitat("l", "m", 3, unit="cm"), "places of the nodes, world axes"]
    previous: Annotated[F32, habitat("l", "m", 3, unit="cm"), "one tick ago"]
    velocity: Annotated[F32, habitat("l", "m", 3, unit="cm/s"), "of the nodes, world axes"]


class Odour(NamedTuple):
    """Odours that the water carries: o channels in a grid of cells; empty where nothing smells.

    Cells are counted up, north and east from the lowest south-west one.
    """

    cell_cm: Annotated[NUMBER, creation(unit="cm", start=1), "side of a cell"]
    corner: Annotated[F64, creation(3, unit="cm"), "lowest corner of the first cell: x, y, z"]
    water: Annotated[BOOL, creation("z", "y", "x"), "False where stone or sand fills the cell"]
    flux: Annotated[
        F32,
        creation(2, 3, "z", "y", "x"),
        "velocity through the east, north and upper face, over that of a flow along x and along y",
    ]

    amount: Annotated[F32, habitat("o", "z", "y", "x"), "of each odour, 1/m³"]
    total: Annotated[F64, habitat("o"), "amount of each odour in the whole sea"]


class Reef(NamedTuple):
    """Corals, sponges and anemones: k growths, biggest first."""

    kind: Annotated[U8, creation("k"), "index into `habitat.reef.KINDS`"]
    place: Annotated[F32, creation("k", 3, unit="cm"), "foot, slightly below the ground"]
    axis: Annotated[F32, creation("k", 3), "unit vector of growth"]
    turn: Annotated[F32, creation("k", unit="rad"), "rotation about the axis"]
    radius: Annotated[F32, creation("k", unit="cm"), "size"]
    own: Annotated[F32, creation("k"), "individual variation in [0, 1)"]
    light: Annotated[F32, creation("k"), "share of the sky's light that solids let through"]
    hue: Annotated[F32, creation("k"), "colour in [0, 1), similar to neighbours of its kind"]
    on_rock: Annotated[BOOL, creation("k"), "whether it stands on rock, not on sand"]

    def taken(self, chosen: Any) -> "Reef":
        """Growths chosen by an index, slice or mask."""
        return Reef(*(part[chosen] for part in self))


class Directions(NamedTuple):
    """Progress of the k directions of a scenario among n fishes; all empty without directions."""

    began: Annotated[
        I64, directing("k", unit="tick", start=-1, within=(-1, 2**48 + 1)), "last start"
    ]
    times: Annotated[I32, directing("k", within=(0, 2**31)), "how often it has begun"]
    ready: Annotated[BOOL, directing("k"), "whether its condition held in the last tick"]
    running: Annotated[BOOL, directing("k"), "whether it still acts"]
    ceded: Annotated[U16, directing("k", within=(0, "influences")), "INFLUENCES taken over, bits"]
    stage: Annotated[I32, directing("k", within=(0, MOST)), "next point, or stage of a pair"]
    cast: Annotated[FISH_OR_HULL, directing("k", 2), "fishes it is about, NOBODY or SUBMARINE"]
    current: Annotated[F64, directing("axes", unit="cm/s"), "added to the strength of the current"]
    alive: Annotated[BOOL, directing("n", start=True), "`Fishes.alive` after the last tick"]
    courtship: Annotated[COURTSHIP_STATE, directing("n"), "`Minds.courtship` after the last tick"]


class Submarine:
    """The hull. Angles are heading (left positive) and pitch (up positive)."""

    position: Annotated[F64, submarine(3, unit="cm"), "centre of the hull"]
    velocity: Annotated[F64, submarine(3, unit="cm/s"), "world axes"]
    angles: Annotated[F64, submarine(2, unit="rad"), "heading and pitch"]
    rates: Annotated[F64, submarine(2, unit="rad/s"), "of heading and pitch"]
    previous_position: Annotated[F64, submarine(3, unit="cm"), "one tick ago"]
    previous_angles: Annotated[F64, submarine(2, unit="rad"), "one tick ago"]
    lights: Annotated[BOOL, written_by("the pilot, directing")(1), "whether the lights are on"]

    def __init__(self, **given: Array) -> None:
        """Arrays that are not given start as zeros."""
        vars(self).update(starts(Submarine, given, {}))


@dataclass
class State:
    """The world at a tick. Snapshots and checksums keep the order of these groups."""

    tick: int
    seed: int
    fishes: Fishes
    minds: Minds
    sea: Sea
    seaweed: Seaweed
    odour: Odour
    live: Live
    reef: Reef
    directions: Directions
    submarine: Submarine


GROUPS: dict[str, Any] = {
    field.name: field.type for field in fields(State) if field.type is not int
}


def arrays(state: State) -> Iterator[tuple[str, NDArray[Any], Spec]]:
    """Name such as `fishes.position`, array and declaration of everything in a state, no copies.

    Numbers are arrays without a dimension.
    """
    for part, group in GROUPS.items():
        for name, spec in declared(group).items():
            yield f"{part}.{name}", np.asarray(getattr(getattr(state, part), name)), spec


class Nature(NamedTuple):
    """Constants of perception and behavior (Tu chs. 6, 7)."""

    vision_cm: float  # V_r for an object of standard size
    smell_cm: float  # O_r
    standard_cm: float  # length of a fish of standard size, s^p = 1
    hunger_stimulus: float  # alpha_h
    libido_stimulus: float  # alpha_l
    alarmed: float  # f0: fear above this calls for evasion
    panicked: float  # f1: fear of one predator from which the fish flees
    keen: float  # r: hunger or libido above this calls for eating or mating
    devotion_cm: float  # how much nearer another target must be to be preferred (Tu §7.7.3)
    fatigue_s: float  # time after which a desire has dropped to half (Tu §7.7.2)
    fear_s: float  # time constant with which fear fades
    habituation_s: float  # harmless time near the submarine that halves its D0
    timidity: float  # factor on the collision sensitivity region (Tu §6.6.1)
    submarine_cm: float  # D0 of the submarine for prey: the size of predator that it appears
    curiosity_cm: float  # distance from which the submarine attracts pacifists, 0 for never
    dusk: float  # share of the sea's range of light below which it is dark (Tu §7.3)
    mild: float  # share of the sea's range of temperature below which it is cold
    day_libido: float = 0.1  # share of libido outside dusk
    calm_dread: float = 0.5  # share of D0 that is left for a predator that cruises slowly


class Physics(NamedTuple):
    """Differences of simulated fishes from the recorded ones (Tu §9.2)."""

    unit_mass: float = 1.0  # factor on the mass of every node
    viscosity: float = 1.0  # factor on kappa of every unit
    stiffness: float = 1.0  # factor on the spring constant of every unit
    water_viscosity: float = 1.0  # factor on mu of Tu eq. 4.3, and on the push of the fins
    hydrodynamics: bool = True  # False: no forces of the water
    time_step: float = 1.0  # factor on the 5.5 ms of Tu §4.5.2
    iterations: int = 6  # steps in a tick; 6 keep pace with played-back fishes
    fish: int = -1  # fish that is always simulated first, -1 for none


class Clock(NamedTuple):
    """Time of a tick, and key of its random numbers."""

    seed: int
    tick: int
    dt: float  # s
