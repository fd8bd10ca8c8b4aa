"""Switch fishes between simulation and playback without a visible change.

Fishes near the viewer are simulated, all others played back (future work in SMC §9.1).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bools, Ints
from subsea.biomechanics.solver import TICK_TU, TIME_UNIT_S
from subsea.fish.species import Species
from subsea.geometry.rotation import matrix
from subsea.geometry.solids import height_at
from subsea.motor.containment import roll_of
from subsea.motor.dynamics import GEARS, BodyTables, Integration, make_bodies, swim_live, under
from subsea.motor.playback import (
    BASE,
    COAST,
    FAST,
    HURRIED,
    LEFT_GRADUAL,
    MEDIUM,
    RIGHT_GRADUAL,
    RIGHT_SHARP,
    TEMPO,
    blends,
)
from subsea.repertoire import SEGMENTS, Repertoire, Segment
from subsea.repertoire.blending import LEVELS, TIGHTEST
from subsea.repertoire.library import Library
from subsea.repertoire.schema import SUBSTITUTES
from subsea.repertoire.transitions import (
    Kinematics,
    gentlest,
    kinematics_of,
    node_velocity,
    rotation_vectors,
    usual_change,
)
from subsea.state import Clock, Fishes, Live, Physics, Sea

REVIEW_TICKS = 10  # interval between choices of fishes
MIN_STAY_S = 4.0  # least time between two changes of a fish
KEEP = 1.25  # factor by which a simulated fish counts as nearer: hysteresis
GENTLE = 1.2  # largest change of a node's velocity over that of a straight swim, to leave ...
MAX_WAIT_TICKS = 75  # ... before about five beats have passed
USUAL, NONE = Physics(), np.zeros(0, np.int32)
EDGE_BL = 0.3  # distance to surface, rim and floor below which a fish leaves the sea
LIVE_LIMITS = (0.4, 2.0)  # strain limits; recorded bodies keep to narrower ones
EXPERIMENT_LIMITS = (0.2, 3.0)  # under unusual physics
HOVERING = 0.2  # thrust below which a fish is played back: muscles cannot retreat
MOST_LIVE = 3  # largest level of bend with which a fish goes live
FASTEST = 2.0  # tempo above which a fish is played back


class Dynamics(NamedTuple):
    """Constants: the bodies of all species, and the kinematics of every recorded row."""

    bodies: BodyTables
    muscular: NDArray[np.bool_]  # (S,) whether a species has muscles and can be simulated
    motion: Kinematics  # R rows
    usual: Array  # (S, n) the largest change of a node's velocity in each segment, cm per frame²
    reach_cm: float  # distance from the viewer beyond which fishes are played back


class LiveWater(NamedTuple):
    """The viewer and the water of simulated fishes."""

    viewer: Array  # (3,) cm
    sea: Sea | None = None  # None: without bounds
    shear: Array | None = None  # (k, 2, 3) cm/s, as in `Integration`; None: the water is uniform


def make_dynamics(
    species: Sequence[Species], repertoires: Sequence[Repertoire], library: Library,
    reach_cm: float,
) -> Dynamics:  # fmt: skip
    """Gather the constants of some species, in the order of the packed library."""
    motions = [
        {name: kinematics_of(r.segments[name]) for name in r.recorded_names()} for r in repertoires
    ]
    every = [motion for row in motions for motion in row.values()] + _bends(library)
    return Dynamics(
        make_bodies(species, library),
        np.array([kind.muscles is not None and kind.form == "fish" for kind in species]),
        Kinematics(*(np.concatenate(tables) for tables in zip(*every, strict=True))),
        np.array([[_usual(row, name) for name in SEGMENTS] for row in motions]),
        reach_cm,
    )


def _bends(library: Library) -> list[Kinematics]:
    """List the kinematics of the rows that blend turns with a straight swim, in their order."""
    cycles = []
    for kind, turn in sorted(np.argwhere(library.veer >= 0), key=lambda at: library.veer[*at]):
        beat = int(library.length[kind, turn])
        for begin in library.veer[kind, turn] + beat * np.arange(TIGHTEST):
            tables = library.rotation, library.translation, library.nodes
            turns, shifts, nodes = (
                table[begin : begin + beat].astype(np.float64) for table in tables
            )
            bend = Segment("turn", "gradual", True, turns, shifts, nodes, None, 0.0, 0.0, 0.0, 0.0)
            cycles.append(kinematics_of(bend))
    return cycles


def _usual(motions: dict[str, Kinematics], name: str) -> float:
    """Return the largest change of a node's velocity in a segment or its substitute."""
    return usual_change(motions[name if name in motions else SUBSTITUTES[name]])


def swim(
    fishes: Fishes, library: Library, dynamics: Dynamics, live: Live,
    around: LiveWater, clock: Clock, physics: Physics = USUAL,
) -> Ints:  # fmt: skip
    """Advance all simulated fishes by a tick, before playback moves the others.

    Fishes near the viewer are simulated. Returns fishes whose bodies diverged (Tu §9.2), which
    are played back from their last sound pose. Under unusual physics fishes that leave the
    sea are played back too.
    """
    if not len(live.fish) or not len(fishes.live):
        return NONE
    fishes.stay[:] += np.float32(clock.dt)
    _free(fishes, live, len(library.entry))
    if clock.tick % REVIEW_TICKS == 0:
        _review(fishes, library, dynamics, live, around.viewer, physics.fish)
    simulated = (live.fish >= 0) & fishes.live[live.fish]
    for hasty in np.flatnonzero(simulated & ~steady(fishes, library)[live.fish]):
        way = way_back(fishes, library, dynamics, live, int(hasty))
        to_playback(fishes, library, live, int(hasty), way)
    for slot in np.flatnonzero(live.waiting):
        _try_to_leave(fishes, library, dynamics, live, int(slot))
    bodies = under(dynamics.bodies, physics)
    limits = LIVE_LIMITS if physics == USUAL else EXPERIMENT_LIMITS
    shear = around.shear if around.shear is not None else np.zeros((len(live.fish), 2, 3))
    steps = float(physics.time_step), int(physics.iterations)
    integration = Integration(clock.dt, *steps, limits, shear)
    sound = swim_live(fishes, library, bodies, live, integration)
    burst = live.fish[~sound].copy()
    for slot in np.flatnonzero(~sound):
        way = way_back(fishes, library, dynamics, live, int(slot))
        to_playback(fishes, library, live, int(slot), way)
    if around.sea is not None and physics != USUAL:
        for lost in _astray(fishes, live, around.sea):
            way = way_back(fishes, library, dynamics, live, lost)
            to_playback(fishes, library, live, lost, way)
    return burst


def _astray(fishes: Fishes, live: Live, sea: Sea) -> list[int]:
    """Move fishes that were leaving the sea back inside, and return their slots."""
    slots = []
    for slot, i in enumerate(live.fish):
        if i < 0 or not fishes.live[i]:
            continue
        x, y, z = fishes.position[i]
        room, rim = EDGE_BL * fishes.length[i], math.hypot(x, y)
        low = height_at(sea.floor, sea.half_width, x, y) + room
        if rim > sea.radius - room or not low < z < -room:
            inward = min((sea.radius - room) / max(rim, 1e-6), 1.0)
            fishes.position[i] = inward * x, inward * y, min(max(z, low), -room)
            slots.append(slot)
    return slots


def _free(fishes: Fishes, live: Live, rows: int) -> None:
    """Free the slots whose rows no pose uses."""
    i = live.fish
    needed = fishes.live[i] | (fishes.row_a[i] >= rows) | (fishes.previous_row_a[i] >= rows)
    live.fish[(i >= 0) & ~needed] = -1


def _review(
    fishes: Fishes, library: Library, dynamics: Dynamics, live: Live, viewer: Array, first: int
) -> None:
    """Choose the fishes nearest to the viewer for the slots; fish `first` before all."""
    distance = np.linalg.norm(fishes.position - viewer, axis=1)
    distance[fishes.live] /= KEEP
    if 0 <= first < len(distance):
        distance[first] = 0.0
    distance[~steady(fishes, library)] = np.inf
    distance[~dynamics.muscular[fishes.species] | ~fishes.alive] = np.inf
    nearest = np.argsort(distance, kind="stable")[: len(live.fish)]
    chosen = np.zeros(len(distance), np.bool_)
    chosen[nearest] = (distance[nearest] <= dynamics.reach_cm) & (distance[nearest] < np.inf)
    settled = fishes.stay > MIN_STAY_S
    for slot, i in enumerate(live.fish):
        if i >= 0 and fishes.live[i] and not chosen[i] and settled[i]:
            live.waiting[slot] = max(live.waiting[slot], 1)
    free = [int(slot) for slot in np.flatnonzero(live.fish < 0)]
    waiting = chosen & settled & ~fishes.live & ~np.isin(np.arange(len(chosen)), live.fish)
    for i in nearest:
        if free and waiting[i] and may_go_live(fishes, library, int(i)):
            to_live(fishes, library, dynamics, live, free.pop(0), int(i))


def may_go_live(fishes: Fishes, library: Library, i: int) -> bool:
    """True if fish i is inside a cyclic segment and nearly straight, with known velocities."""
    cyclic = library.cyclic[fishes.species[i], fishes.segment[i]]
    if abs(library.level[fishes.row_a[i]]) > MOST_LIVE:
        return False
    row = _row_of_beat(fishes, library, i)
    inside = 0 <= row < library.length[fishes.species[i], fishes.segment[i]]
    return bool(cyclic and inside and fishes.span[i] == 1.0 and steady(fishes, library)[i])


def _row_of_beat(fishes: Fishes, library: Library, i: int) -> int:
    """Return the present row of fish i in its segment; in a bend, of equal phase in the swim."""
    kind, segment, row = int(fishes.species[i]), int(fishes.segment[i]), int(fishes.row_a[i])
    if row < len(library.straight) and library.level[row]:
        segment, row = int(BASE[segment]), int(library.straight[row])
    return row - int(library.first[kind, segment])


def steady(fishes: Fishes, library: Library) -> Bools:
    """Select fishes (n,) that may be simulated: they swim or turn at a usual speed.

    Fishes that burst, row, stop or escape are played back.
    """
    asked = np.stack([fishes.segment, fishes.wanted_segment])
    usual = ((asked <= RIGHT_SHARP) | (BASE[asked] == COAST)).all(axis=0)
    speeds = library.speed[fishes.species]
    present = np.take_along_axis(speeds, fishes.segment[:, None].astype(np.intp), axis=1)[:, 0]
    hurried = fishes.tempo > FASTEST * np.maximum(1.0, speeds[:, FAST] / present)
    hurried |= fishes.goal_speed > HURRIED
    return np.asarray(usual & ~hurried & (fishes.thrust >= HOVERING))


def to_live(
    fishes: Fishes, library: Library, dynamics: Dynamics, live: Live, slot: int, i: int
) -> None:
    """Hand fish i from playback to a free slot of the simulation.

    Its nodes take the present pose (SMC eq. 12 at the recorded size), and the velocities of the
    recorded rows at the fish's tempo, thrust and turning rate.
    """
    bodies, motion = dynamics.bodies, dynamics.motion
    kind, segment = int(fishes.species[i]), int(fishes.segment[i])
    a, b, w = int(fishes.row_a[i]), int(fishes.row_b[i]), float(fishes.weight[i])
    tempo, rate = float(fishes.tempo[i]), float(fishes.rate[i])
    nodes, arriving, leaving = (
        (1.0 - w) * table[a] + w * table[b]
        for table in (motion.nodes, motion.arriving, motion.leaving)
    )
    velocity = 0.5 * (arriving + leaving)
    velocity += (float(fishes.thrust[i]) - 1.0) * motion.shift[b]
    R = matrix(fishes.orientation[i].astype(np.float64))
    x = _turned(nodes, R)
    yaw, pitch = fishes.steering[i].astype(np.float64) * TIME_UNIT_S / rate
    spin = np.array([0.0, 0.0, yaw]) + pitch * R[:, 2]
    live.fish[slot], live.waiting[slot] = i, 0
    live.x[slot] = x
    live.v[slot] = _turned(tempo * velocity, R) / TICK_TU + np.cross(spin, x)
    level = int(library.level[a])
    begin = math.pi if segment == RIGHT_GRADUAL and not level else 0.0  # a mirror image
    row = _row_of_beat(fishes, library, i) + 1
    blended = blends(library, kind, segment)
    speed = library.speed[kind, MEDIUM if blended else segment]
    speeds = bodies.speed[kind]
    pace = float(np.interp(speed, speeds, bodies.pace[kind]))
    beats = (row + w) * pace / bodies.beat[kind]
    live.phase[slot] = (begin + 2.0 * math.pi * beats) % (2.0 * math.pi)
    live.gear[slot] = 0.0 if BASE[segment] == COAST else np.interp(speed, speeds, GEARS)
    live.tempo[slot] = tempo * pace
    share = bodies.turn_rate[kind, segment] / bodies.turn_rate[kind, LEFT_GRADUAL]
    share = level / LEVELS if level else share
    live.bend[slot] = bodies.bend[kind] * min(max(share, -1.0), 1.0)
    live.speed[slot] = library.speed[kind, segment] * tempo * float(fishes.thrust[i])
    sway = (1.0 - w) * library.sway[a] + w * library.sway[b]
    live.course[slot] = math.atan2(R[1, 0], R[0, 0]) - sway
    # The present pose is the first row of the slot; the next tick writes the other.
    first = 2 * slot
    live.nodes[first], live.nodes[first + 1] = nodes, nodes
    live.rotation[first], live.translation[first] = library.rotation[b], library.translation[b]
    live.sway[first] = sway
    fishes.row_a[i] = len(library.entry) + first
    fishes.row_b[i] = len(library.entry) + first + 1
    fishes.weight[i], fishes.span[i] = 0.0, 1.0
    fishes.live[i], fishes.stay[i] = True, 0.0


def _turned(rows: Array, R: Array) -> Array:
    """Turn vectors (n, 3) by a rotation; not by BLAS, whose bits differ by processor."""
    return np.asarray((rows[:, None] * R).sum(axis=2))


def _try_to_leave(
    fishes: Fishes, library: Library, dynamics: Dynamics, live: Live, slot: int
) -> None:
    """Return to playback if the glide is gentle, or after a long wait."""
    way = way_back(fishes, library, dynamics, live, slot)
    # Not of the swim that it returns to: a slow one may be smoother than any glide.
    usual = dynamics.usual[fishes.species[live.fish[slot]], : FAST + 1].max()
    live.waiting[slot] += 1
    if way.change <= GENTLE * usual or live.waiting[slot] > MAX_WAIT_TICKS:
        to_playback(fishes, library, live, slot, way)


class WayBack(NamedTuple):
    """A glide from a simulated pose to a recorded row."""

    segment: int
    row: int
    frames: int
    change: float  # of any node's velocity at the ends of the glide, cm per frame²


def way_back(
    fishes: Fishes, library: Library, dynamics: Dynamics, live: Live, slot: int
) -> WayBack:
    """Find the gentlest glide from the pose of a slot to a row of a straight swim."""
    i = live.fish[slot]
    kind, rows = fishes.species[i], len(library.entry)
    here, before = fishes.row_a[i] - rows, fishes.row_b[i] - rows
    nodes = live.nodes[[here]].astype(np.float64)
    shift = live.translation[[here]].astype(np.float64)
    spin = rotation_vectors(live.rotation[[here]].astype(np.float64))
    deformation = (nodes - live.nodes[[before]]) / float(fishes.rate[i])
    arriving = node_velocity(deformation, shift, spin, nodes)
    segments = zip(library.first[kind, : FAST + 1], library.length[kind], strict=False)
    goals = np.concatenate([first + np.arange(n) for first, n in segments])
    present = Kinematics(nodes, shift, spin, arriving, arriving)
    row, frames, change = gentlest(present, 0, dynamics.motion, goals)
    segment = int(np.flatnonzero(library.first[kind, : FAST + 1] <= row).max())
    return WayBack(segment, int(row), int(frames), float(change))


def to_playback(fishes: Fishes, library: Library, live: Live, slot: int, way: WayBack) -> None:
    """Hand the fish of a slot back to playback, with a glide to a recorded row.

    The glide keeps the speed, as between segments. The slot stays taken until it ends.
    """
    i = int(live.fish[slot])
    fishes.row_b[i], fishes.span[i], fishes.weight[i] = way.row, way.frames, 0.0
    fishes.segment[i] = way.segment
    fishes.glide_tempo[i], fishes.glide_thrust[i] = 1.0, 1.0
    recorded = float(library.speed[fishes.species[i], way.segment])
    exact = max(float(live.speed[slot]), 0.0) / recorded
    fishes.tempo[i] = min(max(exact, TEMPO[0]), TEMPO[1])
    fishes.thrust[i] = exact / fishes.tempo[i]
    fishes.roll[i] = roll_of(tuple(fishes.orientation[i].astype(np.float64)))
    fishes.live[i], fishes.stay[i], live.waiting[slot] = False, 0.0, 0
