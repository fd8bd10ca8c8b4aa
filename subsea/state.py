"""Every array that changes, with shape, dtype, unit and who writes it.

One fish is one index in [0, n). Arrays are plain numpy, so that any kernel may take them.
"""

import hashlib
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

NEIGHBOURS = 6  # how many companions a fish attends to

INTENTIONS = ("wander", "school", "avoid")
WANDER, SCHOOL, AVOID = range(3)

# Columns of `fins`, in the order of the instance record.
SWEEP_LEFT, SWEEP_RIGHT = 0, 1  # rad, of a pectoral fin away from the body
LIFT_LEFT, LIFT_RIGHT = 2, 3  # rad, of a pectoral fin above its rest
MOUTH = 4  # 0 shut to 1 open
DORSAL = 5  # 0 folded to 1 erect, dorsal and ventral fin
TAIL = 6  # how much wider than at rest the tail is spread


class Fishes(NamedTuple):
    """The fishes of a dive, n of them."""

    # Constant after creation.
    species: Ints  # (n,) uint8, index into the scenario's species
    length: Array  # (n,) float32, cm
    scale: Array  # (n,) float32, length over recorded length: α of SMC eq. 12
    rate: Array  # (n,) float32, recorded rows per tick: larger fishes beat more slowly
    identity: Array  # (n,) float32 in [0, 1), individual variation
    leader: Ints  # (n,) int32, whom a schooling fish follows, -1 for none
    leads: NDArray[np.bool_]  # (n,), whether others follow it
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

    # Written by perception.
    neighbour: Ints  # (n, NEIGHBOURS) int32, nearest first, -1 for none

    # Written by behavior: what the motor system is asked for.
    intention: Ints  # (n,) uint8, code in INTENTIONS
    waypoint: Array  # (n, 3) float32, cm, where a wandering fish is bound
    patience: Array  # (n,) float32, s until a wandering fish changes its mind
    goal_direction: Array  # (n, 3) float32, unit vector, world
    goal_speed: Array  # (n,) float32, share of the fast swim's speed, 1 to -1; below 0 retreats


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


@dataclass
class State:
    """The world at a tick."""

    tick: int
    seed: int
    fishes: Fishes
    plankton: Array  # (p, 3) float32, cm; written by habitat
    submarine: Submarine
    live: Live


def empty_fishes(n: int) -> Fishes:
    """Arrays for n fishes, all zero but for unit quaternions, spans of one frame and stays."""

    def zeros(dtype: type, *shape: int) -> NDArray[Any]:
        return np.zeros((n, *shape), dtype)

    f, i, u = np.float32, np.int32, np.uint8
    upright = zeros(f, 4)
    upright[:, 0] = 1.0
    return Fishes(
        species=zeros(u), length=zeros(f), scale=zeros(f) + 1, rate=zeros(f) + 1,
        identity=zeros(f), leader=zeros(i) - 1, leads=zeros(np.bool_), oars=zeros(np.bool_),
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
        neighbour=zeros(i, NEIGHBOURS) - 1,
        intention=zeros(u), waypoint=zeros(f, 3), patience=zeros(f),
        goal_direction=zeros(f, 3), goal_speed=zeros(f),
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
    arrays = [*state.fishes, *state.live, state.plankton, *vars(state.submarine).values()]
    for values in arrays:
        sha.update(np.ascontiguousarray(values).tobytes())
    return sha.hexdigest()
