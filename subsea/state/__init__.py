"""Every array that changes, with shape, dtype, unit and who writes it.

One fish is one index in [0, n). Arrays are plain numpy, so that any kernel may take them.
"""

import hashlib
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array, Ints
from subsea.core.kernels.struct_ref import Kind, by_pointer

NEIGHBOURS = 6  # how many companions a fish attends to
CHOICES = 3  # among how many targets it chooses: K of Tu §6.5.3
NOBODY, SUBMARINE = -1, -2  # where an index of a fish is expected
ANYONE = np.array([0, 2**31 - 1, -1], np.int32)  # who may hunt all, as a row of `Minds.quarry`
HULL_CM = 45.0  # radius of the submarine, with a hand's breadth to spare
KINDS = ("pacifist", "prey", "predator")  # Tu §7.9
PACIFIST, PREY, PREDATOR = range(3)

# Codes of what a fish may intend (Tu fig. 7.4); `behavior/table.py` says what each is.
AVOID, ESCAPE, SCHOOL, EAT, MATE, LEAVE, WANDER = range(7)

# Columns of `likes`: habits (Tu §7.3).
BRIGHTNESS, DARKNESS, COLD, WARMTH = range(4)
# Columns of `mental`.
MENTAL_STATES = ("hunger", "libido", "fear")
HUNGER, LIBIDO, FEAR = range(3)
# Columns of `preference`: motor preferences (Tu §6.5.2).
LEFT, RIGHT, FORWARD, BACKWARD, ASCEND, DESCEND = range(6)
# What a barrier is: the index of a pillar, -1 for none, or one of these; rocks follow the pillars.
SEABED, SURFACE, WALL = -2, -3, -4
# Where a pair stands in its courtship (Tu §7.9.3).
COURTSHIP = ("none", "approaching", "looping", "circling", "ascending", "nuzzling")
NO_COURTSHIP, APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING = range(6)

BAIT = -3  # what an eater of plankton may be after instead of a speck
# What becomes of the hook (Tu §10.1).
STOWED, SINKING, HANGING, HOOKED, LANDED = range(5)

# Columns of `fins`, in the order of the instance record.
SWEEP_LEFT, SWEEP_RIGHT = 0, 1  # rad, of a pectoral fin away from the body
LIFT_LEFT, LIFT_RIGHT = 2, 3  # rad, of a pectoral fin above its rest
MOUTH = 4  # 0 shut to 1 open
DORSAL = 5  # 0 folded to 1 erect, dorsal and ventral fin
TAIL = 6  # how much wider than at rest the tail is spread


class FishesKind(Kind):
    """What compiled kernels call `Fishes`."""


@by_pointer(FishesKind)
class Fishes(NamedTuple):
    """The fishes of a dive, n of them."""

    # Constant after creation.
    species: Ints  # (n,) uint8, index into the scenario's species
    length: Array  # (n,) float32, cm
    scale: Array  # (n,) float32, length over recorded length: α of SMC eq. 12
    rate: Array  # (n,) float32, recorded rows per tick: larger fishes beat more slowly
    identity: Array  # (n,) float32 in [0, 1), individual variation
    snout: Array  # (n,) float32, cm from the origin of B to the tip of the snout, along x
    girth: Array  # (n, 2) float32, cm, how tall and how wide the body is, fins apart
    oars: NDArray[np.bool_]  # (n,), whether it rows with its pectoral fins (Tu appendix B.2)

    # Written by motor: the body frame, its pose, and both one tick ago.
    position: Array  # (n, 3) float32, cm, world: the origin of B
    orientation: Array  # (n, 4) float32, body to world
    row_a: Ints  # (n,) int32: the pose mixes rows a and b of the library ...
    row_b: Ints  # (n,) int32
    weight: Array  # (n,) float32 in [0, 1): ... with this weight of b
    span: Array  # (n,) float32, frames that lie between a and b: 1 in playback, N in a glide
    previous_position: Array  # (n, 3) float32
    previous_orientation: Array  # (n, 4) float32
    previous_row_a: Ints  # (n,) int32
    previous_row_b: Ints  # (n,) int32
    previous_weight: Array  # (n,) float32
    previous_span: Array  # (n,) float32
    velocity: Array  # (n, 3) float32, cm/s, world, of the body frame
    segment: Ints  # (n,) uint8, code of the segment that row b belongs to
    wanted_segment: Ints  # (n,) uint8, what the secondary controller asks for
    tempo: Array  # (n,) float32, playback rate asked of the segment, about 1
    thrust: Array  # (n,) float32, share of the recorded way: 1 swims, 0 hovers, below 0 retreats
    glide_tempo: Array  # (n,) float32, tempo and ...
    glide_thrust: Array  # (n,) float32, ... thrust with which the present glide began
    steering: Array  # (n, 2) float32, rad/s: yaw and pitch added to the recorded motion
    roll: Array  # (n,) float32, rad, smoothed
    fin_phase: Array  # (n, 2) float32, rad, beat of the left and right pectoral fin
    breath: Array  # (n,) float32, rad, phase of breathing
    fins: Array  # (n, 7) float32, columns SWEEP_LEFT to TAIL
    previous_fins: Array  # (n, 7) float32
    monotony: Array  # (n,) float32, s in the same segment
    recommended: Ints  # (n,) int8, code of the swim recommended against monotony, -1 for none
    live: NDArray[np.bool_]  # (n,), whether it is simulated rather than played back
    stay: Array  # (n,) float32, s since that changed, infinite if it never did

    # Written by habitat at the start of a tick; behavior adds what a fish is sucked or pulled by.
    drift: Array  # (n, 3) float32, cm/s, world: how the water carries the fish

    # Written by behavior: what the motor system is asked for.
    alive: NDArray[np.bool_]  # (n,), False once it was eaten or landed: nobody sees it any more
    goal_direction: Array  # (n, 3) float32, unit vector, world
    goal_speed: Array  # (n,) float32, share of the fast swim's speed, 1 to -1; below 0 retreats
    gape: Array  # (n,) float32 in [0, 1], how far the mouth is to be open
    display: Array  # (n,) float32 in [0, 1], how much it wears its mating colours


class MindsKind(Kind):
    """What compiled kernels call `Minds`."""


@by_pointer(MindsKind)
class Minds(NamedTuple):
    """What the n fishes sense, feel and want (Tu chs. 6, 7)."""

    # Constant but for a panel (`constants.py`): habits (Tu §7.3) and temper (Tu §7.4).
    kind: Ints  # (n,) uint8, code in KINDS
    male: NDArray[np.bool_]  # (n,)
    likes: NDArray[np.bool_]  # (n, 4), columns BRIGHTNESS to WARMTH; both of a pair: does not care
    schools: NDArray[np.bool_]  # (n,), whether it likes schooling
    appetite: Array  # (n,) float32, n^a, meals that fill it: larger for larger fishes
    digestion: Array  # (n,) float32, p0, 1/s
    libido_rate: Array  # (n,) float32, p1, 1/s
    dread: Array  # (n,) float32, D0, cm: a predator at this distance is all the fear there is

    # Written by perception, of the fishes whose turn it is.
    neighbour: Ints  # (n, NEIGHBOURS) int32, companions of its species, nearest first, or NOBODY
    leader_place: Array  # (n, 3) float32, cm, where the leader was when last seen ...
    leader_seen: Array  # (n,) float32, s, world time, ... and when that was
    threat: Ints  # (n,) int32, the fish with which it is most in danger to collide, or NOBODY
    barrier: Ints  # (n,) int32, what stands in its way: pillar, rock, SEABED, SURFACE, WALL, or -1
    predators: Ints  # (n, CHOICES) int32, those in sight, most dangerous first, or NOBODY
    predator: Ints  # (n,) int32, the most dangerous one in sight, SUBMARINE, or NOBODY
    menace: Array  # (n,) float32, F^m of that one, in [0, 1]
    menaces: Array  # (n,) float32, sum of F^i over all in sight, at most 1
    food: (
        Ints  # (n,) int32, nearest speck of plankton perceived; of a predator: nearest prey; or -1
    )
    foods: Ints  # (n, CHOICES) int32, best specks perceived, nearest first; prey by cost; or -1
    food_distance: Array  # (n,) float32, cm, infinite if there is none
    mate: Ints  # (n,) int32, nearest possible mate in sight, or NOBODY
    mates: Ints  # (n, CHOICES) int32, those in sight, of its species first, nearest first
    mate_distance: Array  # (n,) float32, cm, infinite if there is none
    light: Array  # (n,) float32 in [0, 1], ambient brightness
    temperature: Array  # (n,) float32, degrees C
    target: Ints  # (n,) int32, what the intention is about: a fish, of eaters of plankton a speck
    preference: Array  # (n, 6) float32, motor preferences, columns LEFT to DESCEND

    # Written by behavior.
    mental: Array  # (n, 3) float32 in [0, 1], columns HUNGER, LIBIDO, FEAR
    eaten: Array  # (n,) float32, n^e, meals since the last complete digestion
    last_meal: Array  # (n,) float32, s, world time
    last_mating: Array  # (n,) float32, s, world time
    desire: Array  # (d, n) float32, strength of each row of `behavior/table.py`'s desires
    intention: Ints  # (n,) uint8, code, AVOID to WANDER and on
    busy: Array  # (n,) float32, s for which it has had this intention, or has reacted
    fatigue: Array  # (b, n) float32, s for which each behavior was active, less those it was not
    pause: Array  # (n,) float32, s since the fish last thought
    memory: Ints  # (n,) int8, an interrupted intention, -1 for none (Tu §7.7.1)
    memory_target: Ints  # (n,) int32, and what that was about
    resumed: NDArray[np.bool_]  # (n,), whether the present intention came from memory
    urge: Array  # (n, 3) float32, world: where the routine wants to go; length does not matter
    waypoint: Array  # (n, 3) float32, cm, where a wandering fish is bound
    patience: Array  # (n,) float32, s until a wandering fish changes its mind
    leader: Ints  # (n,) int32, whom a schooling fish follows, NOBODY for a leader or a loner
    leads: NDArray[np.bool_]  # (n,), whether others follow it
    partner: Ints  # (n,) int32, with whom it courts, or NOBODY; mutual from CIRCLING on
    courtship: Ints  # (n,) uint8, code in COURTSHIP
    courtship_time: Array  # (n,) float32, s in this state
    courtship_count: Array  # (n,) float32, what the state counts: points reached, turns, nudges
    courtship_mark: Array  # (n,) float32, and from where it does: see `behavior/courtship.py`
    alone: Array  # (n,) float32, s for which the partner has minded something or somebody else
    shunned: Ints  # (n,) int32, whom it doesn't court for a while, or NOBODY: who turned it down,
    # or with whom it has just spawned; perception leaves that fish out of `mate` and `target`
    shunning: Array  # (n,) float32, s until it forgets that

    # Written by directing: what a direction has put into its mind; without any, as they begin.
    errand: Array  # (n,) float32, share of its fastest speed with which it is bound for its
    # waypoint before it is curious, in company or content; 0 for none
    fright: Array  # (n,) float32, fear that it has whatever it sees, below 0: what it sees decides
    fancy: Ints  # (n,) int8, habits in place of its own: the bits of columns of `likes`, or -1
    quarry: Ints  # (n, 3) int32, whom it may hunt: the first fish, who is behind the last; and of
    # which species these must be, -1 for any
    betrothed: Ints  # (n,) int32, who alone may court it and be courted by it, or NOBODY


class SeaKind(Kind):
    """What compiled kernels call `Sea`."""


@by_pointer(SeaKind)
class Sea(NamedTuple):
    """Everything around the fishes that they may perceive."""

    # Constant.
    heights: Array  # (m, m) float32, cm, of the seabed: row i along y, column j along x
    floor: Array  # (m, m) float32, cm, kept clear of: the seabed and all that grows on it
    half_width: float  # cm, the height field spans [-w, w] in x and y
    radius: float  # cm, of the cylinder that bounds the sea
    pillars: Array  # (k, 4) float64: x, y, radius, height of the top, cm; from the seabed up
    rocks: (
        Array  # (k, 7) float64: centre x, y, z and half axes a, b, c of an ellipsoid, cm; its yaw
    )
    climate: (
        Array  # (4,) float64: C at the surface, C at the depth, cm of that depth, cm of 1/e light
    )

    # Written by habitat.
    plankton: Array  # (p, 3) float32, cm
    absent: Array  # (p,) float32, s until a speck that was eaten is there again, 0: it is there
    seaweed: Array  # (c, 6) float32, cm: lowest and highest corner of each cluster's bounding box

    # Written by submarine, before the tick.
    submarine: Array  # (9,) float64: place, cm, velocity, cm/s, and the unit vector of its gaze

    # The hook on its line; without any it never comes, and these are never written.
    # Constant: x, y, depth, cm, speed, cm/s, and s when it comes ...
    tackle: Array = np.array([0.0, 0.0, 0.0, 0.0, np.inf])  # (5,) float64
    # ... where the bait is, written by habitat ...
    hook: Array = np.zeros(3)  # (3,) float64, cm
    # ... and what has become of it, STOWED to LANDED, by habitat and, of the bite, by behavior,
    # which also enters whom it caught, or NOBODY.
    catch: Ints = np.array([STOWED, NOBODY])  # (2,) int64

    crest: float = np.inf  # cm, constant: no part of the seabed inside the sea is higher


class Seaweed(NamedTuple):
    """Seaweed (Tu §8.2): l leaves in c clusters, each a chain of m nodes from root to tip."""

    # Constant.
    first: Ints  # (c + 1,) int32, the leaves of cluster k are those from first[k] to first[k + 1]
    rest: Array  # (l, m - 1) float32, cm from node to node, less and less toward the tip
    lean: Array  # (l, m, 3) float32, unit vectors: where each node's buoyancy drives it
    look: (
        Array  # (l, 8) float32: width, cm; how it faces and twists, rad; own number; colour; length
    )
    kind: Ints  # (l,) uint8, index into `habitat.seaweed.KINDS`
    cell_cm: float  # side of square cells over the sea, row by row from its south-west corner
    cell_first: Ints  # (g² + 1,) int32, where in `cell_cluster` each cell's list begins
    cell_cluster: Ints  # int32, clusters that a fish in a cell may touch

    # Written by habitat.
    node: Array  # (l, m, 3) float32, cm, world
    previous: Array  # (l, m, 3) float32, one tick ago
    velocity: Array  # (l, m, 3) float32, cm/s


class Reef(NamedTuple):
    """Corals, sponges and anemones: k growths, biggest first. Constant."""

    kind: Ints  # (k,) uint8, index into `habitat.reef.KINDS`
    place: Array  # (k, 3) float32, cm, of the foot, a little in the ground
    axis: Array  # (k, 3) float32, unit vector along which it grows
    turn: Array  # (k,) float32, rad, about that
    radius: Array  # (k,) float32, cm
    own: Array  # (k,) float32 in [0, 1), its own number
    light: Array  # (k,) float32, share of the sky's light that stone lets through
    hue: Array  # (k,) float32 in [0, 1), of which colour it is: much as its neighbours of its kind
    on_rock: NDArray[np.bool_]  # (k,), else it stands on the sand

    def taken(self, chosen: Any) -> "Reef":
        """Some of them, or one."""
        return Reef(*(part[chosen] for part in self))


class Nature(NamedTuple):
    """Constants of perception and behavior that a scenario may change (Tu chs. 6, 7)."""

    vision_cm: float  # V_r for an object of standard size
    smell_cm: float  # O_r
    standard_cm: float  # a fish so long has the standard size, s^p = 1
    hunger_stimulus: float  # alpha_h
    libido_stimulus: float  # alpha_l
    alarmed: float  # f0: more fear than that calls for evasion
    panicked: float  # f1: a predator as fearful as that is fled from
    keen: float  # r: more hunger or libido than that calls for eating or mating
    devotion_cm: float  # so much nearer must another target be to be preferred (Tu §7.7.3)
    fatigue_s: float  # after so long a desire has tired to half (Tu §7.7.2)
    timidity: float  # size of the collision sensitivity region over the usual one (Tu §6.6.1)
    submarine_cm: float  # D0 of the submarine for prey: how large a predator it is
    curiosity_cm: float  # from how far pacifists are drawn to the submarine, 0 for never


class Physics(NamedTuple):
    """How the fishes that are simulated differ from those that were recorded (Tu §9.2)."""

    unit_mass: float = 1.0  # factor on the mass of every node
    viscosity: float = 1.0  # factor on kappa of every unit
    stiffness: float = 1.0  # factor on the spring constant of every unit
    water_viscosity: float = 1.0  # factor on mu of Tu eq. 4.3, and on what the fins are pushed with
    hydrodynamics: bool = True  # else the water does nothing to them
    time_step: float = 1.0  # factor on the 5.5 ms of Tu §4.5.2
    iterations: int = 6  # such steps in a tick: of 6 the fish lives as fast as the others
    fish: int = -1  # this one is simulated before all others, wherever it is; -1 for none


class Clock(NamedTuple):
    """The moment, and what random numbers are keyed with."""

    seed: int
    tick: int
    dt: float  # s


class Directions(NamedTuple):
    """What has become of the k directions of a scenario (`direction.py`) among n fishes.

    Written by directing. Without directions all of these are empty.
    """

    began: Ints  # (k,) int64, tick in which it began last, -1 if it never did
    times: Ints  # (k,) int32, how often it has begun
    ready: NDArray[np.bool_]  # (k,), whether all that it says of when was so in the last tick
    running: NDArray[np.bool_]  # (k,), whether it still moves anything
    ceded: Ints  # (k,) uint16, bits of INFLUENCES that others took from it since it began
    stage: Ints  # (k,) int32, for which point of its path they are bound
    cast: Ints  # (k, 2) int32, the fishes that it is about, NOBODY or the SUBMARINE: see there
    current: Array  # (2,) float64, cm/s, what is added to the strength of the current
    alive: NDArray[np.bool_]  # (n,), who was, and ...
    courtship: Ints  # (n,) uint8, ... how courtships stood at the beginning of the last tick


class Live(NamedTuple):
    """k slots for fishes that are simulated, at the size and pace of the recorded fish.

    Each slot owns two rows behind the recorded ones of the library, for the present pose and the
    next. A fish keeps its slot until the glide back to playback has left the slot's rows.
    Written by motor.
    """

    fish: Ints  # (k,) int32, index of the fish, -1 for a free slot
    waiting: Ints  # (k,) int32, ticks for which the fish has looked for a moment to leave, 0 stays
    x: Array  # (k, 23, 3) float64, cm: nodes about the origin of B, world axes
    v: Array  # (k, 23, 3) float64, cm/tu, against the water
    phase: Array  # (k,) float64, rad, of the beat
    tempo: Array  # (k,) float64, of the beat, 1 is the recorded one
    amplitude: Array  # (k,) float64, of the beat, 1 is grade fast
    bend: Array  # (k, 2) float64, contractions of the two turning segments, left positive
    speed: Array  # (k,) float64, cm/s, smoothed, along x: of the recorded fish
    rotation: Array  # (2 k, 4) float32, the library's rows: how B came there, per frame ...
    translation: Array  # (2 k, 3) float32, cm
    nodes: Array  # (2 k, 23, 3) float32, cm, body axes: ... and the pose


@dataclass
class Submarine:
    """The vessel; written by submarine. Angles are heading (left positive) and pitch (up)."""

    position: Array  # (3,) cm
    velocity: Array = field(default_factory=lambda: np.zeros(3))  # (3,) cm/s, world
    angles: Array = field(default_factory=lambda: np.zeros(2))  # (2,) rad
    rates: Array = field(default_factory=lambda: np.zeros(2))  # (2,) rad/s
    previous_position: Array = field(default_factory=lambda: np.zeros(3))
    previous_angles: Array = field(default_factory=lambda: np.zeros(2))
    # (1,) bool, whether they are on; written by whoever has the helm, between ticks
    lights: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(1, np.bool_))


@dataclass
class State:
    """The world at a tick."""

    tick: int
    seed: int
    fishes: Fishes
    minds: Minds
    sea: Sea
    seaweed: Seaweed
    reef: Reef
    submarine: Submarine
    live: Live
    directions: Directions


def empty_directions(k: int, n: int) -> Directions:
    """Of k directions none of which has begun, among n fishes."""
    n = n if k else 0
    return Directions(
        began=np.full(k, -1, np.int64), times=np.zeros(k, np.int32), ready=np.zeros(k, np.bool_),
        running=np.zeros(k, np.bool_), ceded=np.zeros(k, np.uint16), stage=np.zeros(k, np.int32),
        cast=np.full((k, 2), NOBODY, np.int32), current=np.zeros(2 if k else 0),
        alive=np.ones(n, np.bool_), courtship=np.zeros(n, np.uint8),
    )  # fmt: skip


def empty_reef() -> Reef:
    """Of no growths."""
    zeros, f = np.zeros, np.float32
    return Reef(
        kind=zeros(0, np.uint8), place=zeros((0, 3), f), axis=zeros((0, 3), f), turn=zeros(0, f),
        radius=zeros(0, f), own=zeros(0, f), light=zeros(0, f), hue=zeros(0, f),
        on_rock=zeros(0, np.bool_),
    )  # fmt: skip


def empty_fishes(n: int) -> Fishes:
    """Arrays for n fishes, all zero but for unit quaternions, spans of one frame and stays."""

    def zeros(dtype: type, *shape: int) -> NDArray[Any]:
        return np.zeros((n, *shape), dtype)

    f, i, u = np.float32, np.int32, np.uint8
    upright = zeros(f, 4)
    upright[:, 0] = 1.0
    return Fishes(
        species=zeros(u), length=zeros(f), scale=zeros(f) + 1, rate=zeros(f) + 1,
        identity=zeros(f), snout=zeros(f), girth=zeros(f, 2), oars=zeros(np.bool_),
        position=zeros(f, 3), orientation=upright.copy(),
        row_a=zeros(i), row_b=zeros(i), weight=zeros(f), span=zeros(f) + 1,
        previous_position=zeros(f, 3), previous_orientation=upright.copy(),
        previous_row_a=zeros(i), previous_row_b=zeros(i), previous_weight=zeros(f),
        previous_span=zeros(f) + 1,
        velocity=zeros(f, 3), segment=zeros(u), wanted_segment=zeros(u),
        tempo=zeros(f) + 1, thrust=zeros(f) + 1,
        glide_tempo=zeros(f) + 1, glide_thrust=zeros(f) + 1,
        steering=zeros(f, 2), roll=zeros(f), fin_phase=zeros(f, 2),
        breath=zeros(f), fins=zeros(f, 7), previous_fins=zeros(f, 7),
        monotony=zeros(f), recommended=zeros(np.int8) - np.int8(1),
        live=zeros(np.bool_), stay=zeros(f) + np.float32(np.inf),
        drift=zeros(f, 3), alive=~zeros(np.bool_),
        goal_direction=zeros(f, 3), goal_speed=zeros(f), gape=zeros(f),
        display=zeros(f),
    )  # fmt: skip


def empty_minds(n: int, behaviors: int, desires: int) -> Minds:
    """Minds of n fishes that perceive nothing, want nothing and wander.

    They know so many behaviors, to which so many desires lead.
    """

    def zeros(dtype: type, *shape: int) -> NDArray[Any]:
        return np.zeros((n, *shape), dtype)

    f, i, u, b = np.float32, np.int32, np.uint8, np.bool_
    never = np.float32(np.inf)
    return Minds(
        kind=zeros(u), male=zeros(b), likes=zeros(b, 4), schools=zeros(b), appetite=zeros(f) + 1,
        digestion=zeros(f), libido_rate=zeros(f), dread=zeros(f),
        neighbour=zeros(i, NEIGHBOURS) + NOBODY,
        leader_place=zeros(f, 3), leader_seen=zeros(f) - never,
        threat=zeros(i) + NOBODY, barrier=zeros(i) - 1,
        predator=zeros(i) + NOBODY, menace=zeros(f), menaces=zeros(f),
        predators=zeros(i, CHOICES) + NOBODY, foods=zeros(i, CHOICES) - 1,
        mates=zeros(i, CHOICES) + NOBODY,
        food=zeros(i) - 1, food_distance=zeros(f) + never,
        mate=zeros(i) + NOBODY, mate_distance=zeros(f) + never,
        light=zeros(f), temperature=zeros(f), target=zeros(i) - 1, preference=zeros(f, 6),
        mental=zeros(f, 3), eaten=zeros(f), last_meal=zeros(f), last_mating=zeros(f),
        desire=np.zeros((desires, n), f), intention=zeros(u) + u(WANDER), busy=zeros(f),
        fatigue=np.zeros((behaviors, n), f), pause=zeros(f),
        memory=zeros(np.int8) - np.int8(1), memory_target=zeros(i) - 1, resumed=zeros(b),
        urge=zeros(f, 3), waypoint=zeros(f, 3), patience=zeros(f),
        leader=zeros(i) + NOBODY, leads=zeros(b),
        partner=zeros(i) + NOBODY, courtship=zeros(u), courtship_time=zeros(f),
        courtship_count=zeros(f), courtship_mark=zeros(f), alone=zeros(f),
        shunned=zeros(i) + NOBODY, shunning=zeros(f),
        errand=zeros(f), fright=zeros(f) - f(1), fancy=zeros(np.int8) - np.int8(1),
        quarry=zeros(i, 3) + ANYONE, betrothed=zeros(i) + NOBODY,
    )  # fmt: skip


def empty_live(rotation: Array, translation: Array, nodes: Array) -> Live:
    """Free slots, one for each pair of the rows given: the last ones of the library's tables."""
    k = len(nodes) // 2
    return Live(
        fish=np.full(k, -1, np.int32), waiting=np.zeros(k, np.int32),
        x=np.zeros((k, 23, 3)), v=np.zeros((k, 23, 3)),
        phase=np.zeros(k), tempo=np.ones(k), amplitude=np.zeros(k), bend=np.zeros((k, 2)),
        speed=np.zeros(k),
        rotation=rotation, translation=translation, nodes=nodes,
    )  # fmt: skip


def digest(state: State) -> str:
    """A SHA-256 over every array: equal digests are equal worlds."""
    sha = hashlib.sha256(f"{state.tick},{state.seed}".encode())
    parts = (
        state.fishes, state.minds, state.sea, state.seaweed, state.live, state.directions,
        vars(state.submarine).values(),
    )  # fmt: skip
    for values in (array for part in parts for array in part):
        sha.update(np.ascontiguousarray(values).tobytes())
    return sha.hexdigest()
