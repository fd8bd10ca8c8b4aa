"""Bodies that swim by commands of muscles and fins: their state, step and observation.

Bodies swim in lanes (`kernels.lanes`), eight at a time. A single one swims by the same source.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.biomechanics.body import (
    MUSCLES,
    NODES,
    RING_LEFT,
    UNITS,
    Floats,
    Material,
    axes_of,
    build_body,
    origin_of,
)
from subsea.biomechanics.body_plan import Muscles
from subsea.biomechanics.controllers import S_MAX
from subsea.biomechanics.fins import EDGE_ON
from subsea.biomechanics.reactive_water import ALL_KEPT, SECTIONS, sections_of
from subsea.biomechanics.solver import (
    STEP,
    STEPS_PER_TICK,
    TICK_S,
    Chain,
    Solver,
    advance_solver,
    make_workspace,
)
from subsea.geometry.vector import Vector, dot, minus, plus, store, times, vector
from subsea.kernels import kernel
from subsea.kernels.lanes import LANES, as_lanes, gather, room, take_lane, zero_of
from subsea.kernels.struct_ref import Kind, by_pointer
from subsea.motor.dynamics import BEND_EASE, FIN_AREA, SCULL_SPEED

MAX_CONTRACTION = 0.6  # of a muscle's rest length, as in species files
STRAIN_LIMITS = (0.5, 1.7)
"""Limits of length over rest length, beyond which a body has burst.

They are wider than those of a recorded gait. Bodies that twelve random muscles keep within them
return to their shape when they relax; about half of the others stay folded.
"""
FINS = 2  # left, right
ACTIONS = MUSCLES + 2 * FINS  # contractions, angles of the fins, sweeps of the fins
ANGLES, SWEEPS = slice(MUSCLES, MUSCLES + FINS), slice(MUSCLES + FINS, ACTIONS)
FIN_TURN = np.pi / 2  # greatest angle of a fin from edge-on: broadside
FIN_SWEEP = 0.05  # greatest distance of a fin from its middle position, body lengths
POSE_UNIT = 0.1  # body lengths: displacement of a node from rest that is observed as 1
OBSERVED = 2 * 3 * NODES + 3 + ACTIONS + 3
BOUND = 10.0  # observations are clipped to ±BOUND
TU_PER_S = 10.0
J_PER_KG = 1e-2  # a cm²/tu²

_SIDE = np.tile(RING_LEFT, 3)  # +1 left, -1 right: of nodes 1 to 12, which carry the fins
_LOW, _HIGH = STRAIN_LIMITS


class SwimBodiesKind(Kind):
    """Numba type of the arrays of bodies."""


@by_pointer(SwimBodiesKind)
class SwimBodies(NamedTuple):
    """State of n bodies of one species in still water, and the constants of the species.

    Units are cm, g and tu (0.1 s). World axes are those of a body at rest: x ahead, y up, z right.
    """

    x: Array  # (n, 23, 3) nodes
    v: Array  # (n, 23, 3) their velocities
    command: Array  # (n, 16) contractions, fin angles from edge-on (rad), fin sweeps (cm)
    goal: Array  # (n, 3) direction of length 1, or place
    moved: Array  # (n, 3) displacement of the centre of mass in the last step
    toward: Array  # (n,) distance toward the goal in the last step, body lengths
    work: Array  # (n,) of muscles and sweeping fins in the last step, J/kg
    total_toward: Array  # (n,) in this episode, as the next two
    total_work: Array  # (n,)
    total_seconds: Array  # (n,)
    sound: Bools  # (n,) whether the body kept its shape in the last step
    observed: Array  # (n, 160) float32
    strength: Array  # (12,) greatest contraction of each muscle, a fraction of its rest length
    quickness: Array  # (12,) greatest change of the contraction in a step
    rest: Array  # (23, 3)
    mass: Floats  # (23,)
    length: Floats  # (91,)
    stiffness: Floats  # (91,)
    viscosity: Floats  # (91,)
    drag: float
    sections: Array  # (5, 6) fields of `Sections`
    body_length: float
    fin_area: float
    reach: float  # of a goal that is a place, cm: observed as 1; 0 if the goal is a direction


def make_bodies(muscles: Muscles, number: int, reach: float = 0.0) -> SwimBodies:
    """Make ``number`` bodies at rest at the origin; ``reach`` as in :class:`SwimBodies`.

    Each muscle segment contracts as far as the controllers of the species ever do, and changes as
    fast: the front one as in a turn, the others by S_MAX (Tu §4.6.1).
    """
    body = build_body(muscles.body)
    bend = max((row.contraction for row in muscles.turn.steering), key=sum)
    swim = muscles.swim.contraction
    strength = np.repeat(np.minimum([bend[0], swim[0] + bend[1], swim[1]], MAX_CONTRACTION), 4)
    quickness = S_MAX / body.length[:MUSCLES]
    quickness[:4] = np.minimum(quickness[:4], BEND_EASE * bend[0] / STEPS_PER_TICK)
    return SwimBodies(
        x=np.tile(body.rest, (number, 1, 1)),
        v=np.zeros((number, NODES, 3)),
        command=np.zeros((number, ACTIONS)),
        goal=np.tile([1.0, 0.0, 0.0], (number, 1)),
        moved=np.zeros((number, 3)),
        toward=np.zeros(number),
        work=np.zeros(number),
        total_toward=np.zeros(number),
        total_work=np.zeros(number),
        total_seconds=np.zeros(number),
        sound=np.ones(number, np.bool_),
        observed=np.zeros((number, OBSERVED), np.float32),
        strength=strength,
        quickness=quickness,
        rest=body.rest,
        mass=body.mass,
        length=body.length,
        stiffness=body.stiffness,
        viscosity=body.viscosity,
        drag=float(body.drag),
        sections=np.array(body.sections),
        body_length=float(muscles.body.length),
        fin_area=float(FIN_AREA * muscles.body.length**2),
        reach=float(reach),
    )


@kernel
def swim(who: Ints, bodies: SwimBodies, actions: Array, ticks: int) -> None:
    """Advance the bodies ``who`` by ``ticks`` ticks under ``actions`` (n, 16), and observe them.

    A body that loses its shape keeps the state it had before.
    """
    begin, count = 0, len(who)
    while count - begin > 1:  # eight lanes take as long as 1.4 single bodies
        swim_together(who[begin : begin + LANES], bodies, actions, ticks)
        begin += LANES
    if begin < count:
        swim_alone(who[begin], bodies, actions, ticks)


@kernel
def swim_together(who: Ints, bodies: SwimBodies, actions: Array, ticks: int) -> None:
    """Advance the bodies ``who``, at most LANES, in lanes; as `swim`."""
    x, v = gather(bodies.x, who), gather(bodies.v, who)
    command, action = gather(bodies.command, who), gather(actions, who)
    watch, work = np.empty((3, LANES)), np.empty((1, LANES))
    as_lanes(work)[0] = follow_actions(
        bodies, as_lanes(x), as_lanes(v), as_lanes(command), as_lanes(action), as_lanes(watch),
        ticks,
    )  # fmt: skip
    own_x, own_v = np.empty((NODES, 3)), np.empty((NODES, 3))
    own_command, own_watch = np.empty(ACTIONS), np.empty(3)
    for k in range(len(who)):
        take_lane(x, k, own_x)
        take_lane(v, k, own_v)
        take_lane(command, k, own_command)
        take_lane(watch, k, own_watch)
        settle(bodies, who[k], own_x, own_v, own_command, own_watch, work[0, k], ticks)


@kernel
def swim_alone(i: int, bodies: SwimBodies, actions: Array, ticks: int) -> None:
    """Advance body ``i``; as `swim`."""
    x, v, command = bodies.x[i].copy(), bodies.v[i].copy(), bodies.command[i].copy()
    action, watch = np.empty(ACTIONS), np.empty(3)
    for k in range(ACTIONS):
        action[k] = actions[i, k]
    work = follow_actions(bodies, x, v, command, action, watch, ticks)
    settle(bodies, i, x, v, command, watch, work, ticks)


@kernel
def follow_actions(
    bodies: SwimBodies,
    x: Array,
    v: Array,
    command: Array,
    action: Array,
    watch: Array,
    ticks: int,
) -> float:
    """Advance x and v (23, 3) and ``command`` (16,) of a body, or of lanes, by an action (16,).

    Writes ``watch`` (3,) as `solver.advance` and returns the work, g cm²/tu².
    """
    material = Material(
        bodies.mass, bodies.length, bodies.stiffness, bodies.viscosity, bodies.drag,
        sections_of(bodies.sections),
    )  # fmt: skip
    solver = Solver(Chain(material, UNITS, ALL_KEPT), make_workspace(x, SECTIONS))
    muscles, before, rowing = room((1, MUSCLES), x), room((MUSCLES,), x), room((FINS,), x)
    force, water = room((NODES, 3), x), np.zeros(3)
    for node in range(NODES):
        for axis in range(3):
            force[node, axis] = 0.0
    watch[0], watch[1], watch[2] = np.inf, 0.0, np.inf
    work = zero_of(x)
    left = ticks * STEPS_PER_TICK
    measure_muscles(x, before)
    for _ in range(ticks):
        row_fins(bodies, action, command, rowing)
        work += STEP * STEPS_PER_TICK * add_fins(bodies, x, v, command, rowing, force)
        for _ in range(STEPS_PER_TICK):
            contract(bodies, action, command, left, muscles[0])
            left -= 1
            advance_solver(x, v, solver, muscles, water, force, STEP, watch)
            work += muscle_work(x, bodies.stiffness, muscles[0], before)
    return work


@kernel
def settle(
    bodies: SwimBodies,
    i: int,
    x: Array,
    v: Array,
    command: Array,
    watch: Array,
    work: float,
    ticks: int,
) -> None:
    """Give body ``i`` the state to which it swam, unless it lost its shape, and observe it."""
    bodies.sound[i] = (
        np.isfinite(x).all() and watch[0] >= _LOW and watch[1] <= _HIGH and watch[2] > 0.0
    )
    bodies.total_seconds[i] += ticks * TICK_S
    if bodies.sound[i]:
        moved = minus(centre(x, bodies.mass), centre(bodies.x[i], bodies.mass))
        store(bodies.moved[i], moved)
        bodies.toward[i] = approach(bodies, i, x, moved)
        bodies.work[i] = J_PER_KG / bodies.mass.sum() * work
        bodies.total_toward[i] += bodies.toward[i]
        bodies.total_work[i] += bodies.work[i]
        bodies.x[i], bodies.v[i], bodies.command[i] = x, v, command
    else:
        bodies.moved[i] = 0.0
        bodies.toward[i] = 0.0
        bodies.work[i] = 0.0
    observe_one(bodies, i)


@kernel
def approach(bodies: SwimBodies, i: int, x: Array, moved: Vector) -> float:
    """Measure body lengths toward its goal that body ``i`` gains by a step to nodes ``x``."""
    goal = vector(bodies.goal[i])
    if bodies.reach == 0.0:
        return dot(moved, goal) / bodies.body_length
    before, after = minus(goal, origin_of(bodies.x[i])), minus(goal, origin_of(x))
    return (math.sqrt(dot(before, before)) - math.sqrt(dot(after, after))) / bodies.body_length


@kernel
def observe(who: Ints, bodies: SwimBodies) -> None:
    """Write the observations of the bodies ``who``."""
    for i in who:
        observe_one(bodies, i)


@kernel
def observe_one(bodies: SwimBodies, i: int) -> None:
    """Write the observation (160,) of body ``i``; docs/how-to/environments.md lists its parts."""
    x, v, out = bodies.x[i], bodies.v[i], bodies.observed[i]
    o = origin_of(x)
    ahead, up, right = axes_of(x, o)
    n = 0
    scale = 1.0 / (POSE_UNIT * bodies.body_length)
    for node in range(NODES):
        p = minus(vector_at(x, node), o)
        out[n] = bounded(scale * (dot(p, ahead) - bodies.rest[node, 0]))
        out[n + 1] = bounded(scale * (dot(p, up) - bodies.rest[node, 1]))
        out[n + 2] = bounded(scale * (dot(p, right) - bodies.rest[node, 2]))
        n += 3
    scale = TU_PER_S / bodies.body_length
    for node in range(NODES):
        u = vector_at(v, node)
        out[n] = bounded(scale * dot(u, ahead))
        out[n + 1] = bounded(scale * dot(u, up))
        out[n + 2] = bounded(scale * dot(u, right))
        n += 3
    out[n], out[n + 1], out[n + 2] = ahead[1], up[1], right[1]
    n += 3
    for k in range(ACTIONS):
        value = bodies.command[i, k]
        if k < MUSCLES:
            out[n] = 2.0 * value / bodies.strength[k] - 1.0
        elif k < MUSCLES + FINS:
            out[n] = value / FIN_TURN
        else:
            out[n] = value / (FIN_SWEEP * bodies.body_length)
        n += 1
    goal = vector(bodies.goal[i])
    if bodies.reach > 0.0:
        goal = times(1.0 / bodies.reach, minus(goal, o))
    out[n], out[n + 1] = bounded(dot(goal, ahead)), bounded(dot(goal, up))
    out[n + 2] = bounded(dot(goal, right))


@kernel
def vector_at(rows: Array, k: int) -> Vector:
    """Row k of an array (n, 3). A slice of the array would count a reference, twice."""
    return rows[k, 0], rows[k, 1], rows[k, 2]


@kernel
def bounded(value: float) -> float:
    """Clip a value to the bounds of the observation space."""
    return min(max(value, -BOUND), BOUND)


@kernel
def centre(x: Array, mass: Array) -> Vector:
    """Compute the centre of mass of nodes (23, 3)."""
    total, middle = 0.0, (0.0, 0.0, 0.0)
    for node in range(NODES):
        total += mass[node]
        middle = plus(middle, times(mass[node], vector_at(x, node)))
    return times(1.0 / total, middle)


@kernel
def contract(bodies: SwimBodies, action: Array, command: Array, left: int, muscles: Array) -> None:
    """Contract the muscles by one of the ``left`` steps to the action; write rest lengths (12,)."""
    for m in range(MUSCLES):
        share = min(max(action[m], -1.0), 1.0)
        gap = (0.5 * bodies.strength[m] * (1.0 + share) - command[m]) / left
        most = bodies.quickness[m]
        command[m] += min(max(gap, -most), most)
        muscles[m] = bodies.length[m] * (1.0 - command[m])


@kernel
def row_fins(bodies: SwimBodies, action: Array, command: Array, rowing: Array) -> None:
    """Set angles and sweeps of the fins for a tick; write their speeds (2,) along the body."""
    reach, most = FIN_SWEEP * bodies.body_length, SCULL_SPEED * STEP * STEPS_PER_TICK
    for fin in range(FINS):
        angle = MUSCLES + fin
        sweep = angle + FINS
        command[angle] = FIN_TURN * min(max(action[angle], -1.0), 1.0)
        gap = reach * min(max(action[sweep], -1.0), 1.0) - command[sweep]
        gap = min(max(gap, -most), most)
        command[sweep] += gap
        rowing[fin] = gap / (STEP * STEPS_PER_TICK)


@kernel
def add_fins(
    bodies: SwimBodies, x: Array, v: Array, command: Array, rowing: Array, force: Array
) -> float:
    """Write the force (23, 3) of the fins; return the power of sweeping them, g cm²/tu³.

    It is that of `biomechanics.fins.pectoral_force`, with a rowing speed of each fin.
    """
    ahead, up, _ = axes_of(x, origin_of(x))
    zero = zero_of(x)
    flow = (zero, zero, zero)
    for node in range(1, 13):
        flow = plus(flow, times(1.0 / 12.0, vector_at(v, node)))
    power = zero
    for fin in range(FINS):
        angle = EDGE_ON + command[MUSCLES + fin]
        u = plus(flow, times(rowing[fin], ahead))
        normal = plus(times(math.cos(angle), ahead), times(math.sin(angle), up))
        push = times(-bodies.fin_area * math.sqrt(dot(u, u)) * dot(normal, u), normal)
        power -= dot(push, ahead) * rowing[fin]
        for node in range(1, 13):
            if (_SIDE[node - 1] > 0.0) == (fin == 0):
                share = times(1.0 / 6.0, push)
                force[node, 0], force[node, 1], force[node, 2] = share
    return power


@kernel
def measure_muscles(x: Array, out: Array) -> None:
    """Write the lengths (12,) of the muscles."""
    for m in range(MUSCLES):
        r = minus(vector_at(x, UNITS[m, 1]), vector_at(x, UNITS[m, 0]))
        out[m] = math.sqrt(dot(r, r))


@kernel
def muscle_work(x: Array, stiffness: Array, rest: Array, before: Array) -> float:
    """Measure the work of the muscles since lengths ``before`` (12,), which become the new ones.

    It is tension × shortening, as in `capture.inspection.gait.tension_work`.
    """
    work = zero_of(x)
    for m in range(MUSCLES):
        r = minus(vector_at(x, UNITS[m, 1]), vector_at(x, UNITS[m, 0]))
        now = math.sqrt(dot(r, r))
        work -= stiffness[m] * (0.5 * (now + before[m]) - rest[m]) * (now - before[m])
        before[m] = now
    return work
