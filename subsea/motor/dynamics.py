"""Simulated fishes: the muscle-driven body under command of the secondary controller.

The body swims at the size and pace of the recorded fish, in the frame of the water. Muscles and
fins follow the segment, tempo, thrust and steering that the controller asks of playback. As in
recorded sharp turns, a couple stands for the fins that hold heading and pitch.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.biomechanics.body import (
    MUSCLE_LEFT,
    MUSCLE_SEGMENT,
    MUSCLES,
    NODES,
    Body,
    Material,
    axes_of,
    build_body,
    origin_of,
)
from subsea.biomechanics.body_plan import GRADES, Muscles
from subsea.biomechanics.fins import ROLL_GAIN, STEEPEST, couple_force
from subsea.biomechanics.reactive_water import inertial_mass, sections_of
from subsea.biomechanics.solver import STEP, TICK_S, TICK_TU, advance
from subsea.fish.species import Species
from subsea.geometry.rotation import (
    Quaternion,
    conjugate,
    fraction,
    multiply,
    normalised,
    of_axes,
    quaternion,
    rotate,
    x_axis,
)
from subsea.geometry.vector import (
    ZERO,
    Vector,
    cross,
    dot,
    plus,
    store,
    times,
    vector,
)
from subsea.kernels import kernel
from subsea.motor.controller import own_speed
from subsea.motor.playback import BASE, COAST, LEFT_GRADUAL, TEMPO, TURNS, blends
from subsea.repertoire import SEGMENTS
from subsea.repertoire.library import Library
from subsea.state import Fishes, Live, Physics

MAX_RATE = 8  # recorded frames per tick, of a fish with 1/64 of the recorded length
UPWARDS = (0.0, 0.0, 1.0)
LEAP_BL = 1.0  # displacement per tick, at the pace of its size, that means divergence
FIN_AREA = 0.01  # of each pectoral fin, over the squared body length
BEND_EASE = 1.0 / 16.0  # share of the full bend that may change in a tick
MOST_BEND = 0.6  # share of the full bend: fins add the rest, as quick bends strain the body
TURN_GAIN = 0.5  # 1/tu: the couple of the fins over the error of the turning rate ...
MOST_COUPLE = 0.25  # rad/tu²: ... and its limit
RIGHTING = 0.15  # 1/tu: rate at which fins and a swim bladder that the hull lacks right a fish
GEAR_EASE = 3.0 / 14.0  # grades by which the beat may change in a tick
ROLL_LEAD = 0.7  # radians of the roll oscillation by which the fins lead; less overshoots
SCULL_SPEED = 1.2  # cm/tu: the fins of a slower fish beat, and meet the water at this speed
TEMPO_EASE = 0.025  # change of the tempo per tick toward the recorded one
SPEED_GAIN = 2.0  # on the speed error, as fins and bends slow the fish
TOO_FAST = 0.03  # share of excess speed above which the fins brake
HARDEST_BRAKE = 2.0  # times the pectoral area: a stopping fish spreads its other fins too
BRAKE_GAIN = 5.0  # braking share of the fin area per share of excess speed
SPEED_TIME = 21.0  # ticks over which the speed is smoothed: a beat and a half
COURSE_TIME = 21.0  # likewise the heading, in recorded frames


GEARS = np.arange(4.0)  # still, slow, medium and fast, between which a live fish beats


class BodyTables(NamedTuple):
    """Constants of the simulation for S species; cm, g, tu and radians."""

    mass: Array  # (S, 23)
    length: Array  # (S, 91) rest length of the units
    stiffness: Array  # (S, 91)
    viscosity: Array  # (S, 91)
    drag: Array  # (S,)
    sections: Array  # (S, 5, 6) fields of `Sections`
    beat: Array  # (S,) ticks in a beat at grade fast
    speed: Array  # (S, 4) cm/s: standing still and the three swims, at the recorded tempo ...
    contraction: Array  # (S, 4, 2) ... and of the two swimming segments that make them ...
    lag: Array  # (S, 4) ... and the lag of the posterior one ...
    pace: Array  # (S, 4) ... and the frequencies of the beat, relative to fast
    bend: Array  # (S, 2) contractions of the two turning segments in a gradual turn: the full bend
    turn_rate: Array  # (S, n) rad/s, mean turning rate of each segment, left positive
    inertia: Array  # (S, 23) mass of the nodes with the water that moves aside with them
    fin_area: Array  # (S,) of each pectoral fin
    roll_lead: Array  # (S,) tu by which the fins look ahead of a roll


def make_bodies(species: Sequence[Species], library: Library) -> BodyTables:
    """The tables of these species, in the order of the packed library.

    Spine-driven species have no body to simulate and get rows of zeros, which nothing reads.
    """
    rates = library.turn / (library.length * TICK_S)
    rows = [
        _body(one.muscles, speed, rate) if one.muscles else NO_BODY
        for one, speed, rate in zip(species, library.speed, rates, strict=True)
    ]
    return BodyTables(*(np.array(column, np.float64) for column in zip(*rows, strict=True)))


_ROW = (23, 91, 91, 91, 1, (5, 6), 1, 4, (4, 2), 4, 4, 2, len(SEGMENTS), 23, 1, 1)
NO_BODY = tuple(np.zeros(n) if n != 1 else 0.0 for n in _ROW)
"""A row of `BodyTables` without content."""


def under(bodies: BodyTables, physics: Physics) -> BodyTables:
    """The tables under other physics (Tu §9.2)."""
    if physics == Physics():
        return bodies
    water = physics.water_viscosity if physics.hydrodynamics else 0.0
    lead = math.sqrt(physics.unit_mass / water) if water > 0.0 else 1.0
    return bodies._replace(
        mass=bodies.mass * physics.unit_mass,
        stiffness=bodies.stiffness * physics.stiffness,
        viscosity=bodies.viscosity * physics.viscosity,
        drag=bodies.drag * water,
        sections=bodies.sections * water,
        fin_area=bodies.fin_area * water,
        roll_lead=bodies.roll_lead * lead,
    )


def _body(muscles: Muscles, speed: Array, turn_rate: Array) -> tuple[Any, ...]:
    body, swim = build_body(muscles.body), muscles.swim
    gaits = [swim.at(grade) for grade in GRADES[:3]]
    paces = [swim.ticks_per_beat / gait.ticks_per_beat for gait in gaits]
    contractions = [
        np.multiply(swim.amplitude(grade), gait.contraction)
        for grade, gait in zip(GRADES, gaits, strict=False)
    ]
    fin_area = FIN_AREA * muscles.body.length**2
    return (
        body.mass, body.length, body.stiffness, body.viscosity, body.drag, np.array(body.sections),
        swim.ticks_per_beat, (0.0, *speed[:3]), np.array([(0.0, 0.0), *contractions]),
        (gaits[0].lag, *(gait.lag for gait in gaits)), (paces[0], *paces),
        muscles.turn.gradual, turn_rate, inertial_mass(muscles.body, body.mass),
        fin_area, _roll_lead(body, fin_area),
    )  # fmt: skip


def _roll_lead(body: Body, fin_area: float) -> float:
    """Time (tu) of :data:`ROLL_LEAD` radians of the swing that fins of this area make about x."""
    y, z = body.rest[:, 1], body.rest[:, 2]
    inertia = body.mass @ (y**2 + z**2)
    arm = np.abs(z[1:13]).mean()
    stiffness = ROLL_GAIN * 2.0 * fin_area * SCULL_SPEED**2 * arm
    return float(ROLL_LEAD / math.sqrt(stiffness / inertia))


class Integration(NamedTuple):
    """Integration parameters of a tick."""

    dt: float  # s, a tick
    time_step: float  # factor on the step of 5.5 ms, as in `state.Physics`
    iterations: int  # steps in a tick of a fish of the recorded size
    strain: tuple[float, float]  # limits of a unit's length over its rest length


@kernel
def swim_live(
    fishes: Fishes, library: Library, bodies: BodyTables, live: Live, integration: Integration
) -> Bools:
    """Advance every simulated fish by one tick; return which slots' bodies (k,) stayed sound.

    A body is sound while its strain stays within the limits. One that is not keeps the state of
    the last tick, so that playback can take over from there. The pose goes to the slot's other
    row, with the increments that lead to it, per recorded frame: a glide reads them like
    recorded ones.
    """
    dt, time_step, iterations, (least, most) = integration
    sound = np.ones(len(live.fish), np.bool_)
    muscles = np.empty((MAX_RATE * iterations, MUSCLES))
    time = STEP * time_step * iterations  # length of a tick for a fish of the recorded size
    pace = time / TICK_TU
    for slot in range(len(live.fish)):
        i = live.fish[slot]
        if i < 0 or not fishes.live[i]:
            continue
        kind = fishes.species[i]
        rate = float(fishes.rate[i])
        _keep_speed(fishes, library, live, slot)
        _ease_muscles(fishes, library, bodies, live, slot)
        steps = min(math.ceil(iterations * rate - 1e-6), len(muscles))
        step = time * rate / steps
        beat = 2.0 * np.pi / (bodies.beat[kind] * TICK_TU) * live.tempo[slot]
        for n in range(steps):
            contract(bodies, kind, live.phase[slot], live.gear[slot], live.bend[slot], muscles[n])
            live.phase[slot] = (live.phase[slot] + beat * step) % (2.0 * np.pi)
        x, v = live.x[slot].copy(), live.v[slot].copy()
        yaw = turning_rate(fishes, library, bodies, i)
        lift = float(fishes.steering[i, 1]) / rate
        brake = _brake(fishes, library, live, slot)
        watch = np.array([np.inf, 0.0, np.inf])
        material = Material(
            bodies.mass[kind], bodies.length[kind], bodies.stiffness[kind],
            bodies.viscosity[kind], bodies.drag[kind], sections_of(bodies.sections[kind]),
        )  # fmt: skip
        inertia = bodies.inertia[kind]
        # The fins follow the body at every recorded frame: more rarely they would overshoot.
        for begin in range(0, steps, iterations):
            force = fin_force(bodies, kind, x, v, brake)
            q, _ = frame_of(x)
            along, across = x_axis(q), rotate(q, (0.0, 0.0, 1.0))
            righting = RIGHTING * across[2] * rotate(q, (0.0, 1.0, 0.0))[2]
            force += _turning_force(inertia, x, v, UPWARDS, yaw * TICK_S / TICK_TU, TURN_GAIN)
            force += _turning_force(inertia, x, v, across, lift * TICK_S / TICK_TU, TURN_GAIN)
            force += _turning_force(bodies.mass[kind], x, v, along, righting, TURN_GAIN)
            part = muscles[begin : min(begin + iterations, steps)]
            advance(x, v, material, part, np.zeros(3), force, step, watch)
        sound[slot] = least <= watch[0] and watch[1] <= most and watch[2] > 0.0
        leap = LEAP_BL * rate * library.recorded_length[kind]
        sound[slot] &= np.isfinite(x).all() and np.abs(x - live.x[slot]).max() < leap
        if sound[slot]:
            live.x[slot], live.v[slot] = x, v
            _settle(fishes, live, slot, len(library.entry), dt, pace)
            _follow_course(fishes, live, slot, len(library.entry), yaw * rate * dt)
    return sound


@kernel
def _keep_speed(fishes: Fishes, library: Library, live: Live, slot: int) -> None:
    """Begin the wanted segment at the tempo of the present speed."""
    i = live.fish[slot]
    now, wanted = fishes.segment[i], fishes.wanted_segment[i]
    fishes.segment[i] = wanted
    if BASE[now] == BASE[wanted]:
        return
    tempo = live.speed[slot] / own_speed(fishes, library, i)
    fishes.tempo[i] = min(max(tempo, TEMPO[0]), TEMPO[1])


@kernel
def _ease_muscles(
    fishes: Fishes, library: Library, bodies: BodyTables, live: Live, slot: int
) -> None:
    """Ease gear, tempo and bend toward the speed and the turning rate of playback.

    The tempo is that of the beat relative to grade fast: those of the grades, and between them.
    """
    i = live.fish[slot]
    kind = fishes.species[i]
    yaw = turning_rate(fishes, library, bodies, i)
    coasts = BASE[fishes.wanted_segment[i]] == COAST
    share = fishes.bend[i] if coasts else yaw / bodies.turn_rate[kind, LEFT_GRADUAL]
    # A fish that is to be played back straightens, as every segment is begun.
    share = min(max(share, -MOST_BEND), MOST_BEND) if live.waiting[slot] == 0 else 0.0
    for k in range(2):
        ease = BEND_EASE * bodies.bend[kind, k]
        gap = share * bodies.bend[kind, k] - live.bend[slot, k]
        live.bend[slot, k] += min(max(gap, -ease), ease)
    speed = _wanted_speed(fishes, library, i)
    speed += SPEED_GAIN * (speed - live.speed[slot])
    if coasts:
        speed = 0.0
    # A bent body keeps its shape at the beat of a gradual turn, which is that of medium.
    medium, fast = bodies.speed[kind, 2], bodies.speed[kind, 3]
    speed = min(speed, fast + abs(share) * (medium - fast))
    gap = np.interp(speed, bodies.speed[kind], GEARS) - live.gear[slot]
    live.gear[slot] += min(max(gap, -GEAR_EASE), GEAR_EASE)
    tempo = np.interp(speed, bodies.speed[kind], bodies.pace[kind])
    live.tempo[slot] += min(max(tempo - live.tempo[slot], -TEMPO_EASE), TEMPO_EASE)


@kernel
def turning_rate(fishes: Fishes, library: Library, bodies: BodyTables, i: int) -> float:
    """The turning rate, rad/s to the left at the recorded pace, that the controller asks of fish i.

    That of the segment or of its bend, and of the steering.
    """
    kind, wanted = fishes.species[i], fishes.wanted_segment[i]
    if blends(library, kind, wanted):
        left = TURNS[BASE[wanted], 0]
        return float(bodies.turn_rate[kind, left] * fishes.bend[i] * fishes.tempo[i])
    return float(bodies.turn_rate[kind, wanted] + fishes.steering[i, 0] / fishes.rate[i])


@kernel
def _turning_force(
    inertia: Array, at: Array, v: Array, axis: Vector, rate: float, gain: float
) -> Array:
    """Force (23, 3) on the nodes that turns a body about `axis` at `rate`, rad/tu; gain in 1/tu."""
    if inertia[0] == 0.0:
        return np.zeros((NODES, 3))
    couple = gain * (rate - roll_rate(at, v, inertia, axis))
    return couple_force(at, inertia, axis, min(max(couple, -MOST_COUPLE), MOST_COUPLE))


@kernel
def _wanted_speed(fishes: Fishes, library: Library, i: int) -> float:
    """The speed of playback, cm/s, at the recorded size and pace."""
    own = own_speed(fishes, library, i)
    return float(own * fishes.tempo[i] * max(fishes.thrust[i], 0.0))


@kernel
def _brake(fishes: Fishes, library: Library, live: Live, slot: int) -> float:
    """Braking fin area of a fish that is too fast, over the pectoral area."""
    wanted = _wanted_speed(fishes, library, live.fish[slot])
    excess = live.speed[slot] / max(wanted, 1e-3) - 1.0
    return float(min(max(BRAKE_GAIN * (excess - TOO_FAST), 0.0), HARDEST_BRAKE))


@kernel
def contract(
    bodies: BodyTables, kind: int, phase: float, gear: float, bend: Array, out: Array
) -> None:
    """Write the muscles' rest lengths (12,) at a phase of the beat, in cm (Tu §4.6.1).

    The gear is 0 for still, and 1 to 3 for slow, medium and fast. As the sum of
    `biomechanics.controllers.swim_contraction` and `bend_contraction`; `bend` (2,) is positive to
    the left.
    """
    lower = min(int(gear), len(GEARS) - 2)
    weight = gear - lower
    table, lags = bodies.contraction[kind], bodies.lag[kind]
    lag = (1.0 - weight) * lags[lower] + weight * lags[lower + 1]
    for m in range(MUSCLES):
        part, side, share = MUSCLE_SEGMENT[m], MUSCLE_LEFT[m], 0.0
        if part > 0:
            size = (1.0 - weight) * table[lower, part - 1] + weight * table[lower + 1, part - 1]
            wave = math.sin(phase - (lag if part == 2 else 0.0)) * side
            share = size * (1.0 + wave) / 2.0
        if part < 2:
            share += max(bend[part] * side, 0.0)
        out[m] = bodies.length[kind, m] * (1.0 - share)


@kernel
def fin_force(bodies: BodyTables, kind: int, at: Array, v: Array, brake: float) -> Array:
    """Force (23, 3) of the pectoral fins on nodes at `at` (cm) that move at v (cm/tu): Tu §4.6.2.

    As `biomechanics.fins.balance` and `pectoral_force` do, they right a roll; `brake` times their
    area also stands against the way. A slow fish rows with them, so that water passes them all the
    same.
    """
    area = bodies.fin_area[kind]
    q, _ = frame_of(at)
    x, y = x_axis(q), rotate(q, (0.0, 1.0, 0.0))
    u = (v[1:13, 0].mean(), v[1:13, 1].mean(), v[1:13, 2].mean())
    ahead = dot(u, x)
    row = max(SCULL_SPEED - ahead, 0.0)
    w = plus(u, times(row, x))
    speed = math.sqrt(dot(w, w))
    lean = rotate(q, (0.0, 0.0, 1.0))[2]
    swing = -y[2] * roll_rate(at, v, bodies.mass[kind], x)
    roll = ROLL_GAIN * (lean + bodies.roll_lead[kind] * swing)
    force = np.zeros((NODES, 3))
    for node in range(1, 13):
        tilt = MUSCLE_LEFT[node - 1] * roll
        tilt = min(max(tilt, -STEEPEST), STEEPEST)
        c, s = -math.sin(tilt), math.cos(tilt)  # of π/2, edge-on, and the tilt
        push = -area / 6.0 * speed * dot(w, plus(times(c, x), times(s, y)))
        # The forward stroke of rowing costs what the backward stroke gains.
        along = push * c * min(max(ahead / SCULL_SPEED, 0.0), 1.0)
        along -= area / 6.0 * brake * max(ahead, 0.0) ** 2
        for axis in range(3):
            force[node, axis] = push * s * y[axis] + along * x[axis]
    return force


@kernel
def roll_rate(at: Array, v: Array, mass: Array, axis: Vector) -> float:
    """Rate (rad/tu) at which a body rolls about `axis`: angular momentum over inertia.

    `at` and v (23, 3) are positions and velocities of the nodes. Frame B sways with the head in
    every beat; the momentum of the body does not.
    """
    momentum, inertia, total = 0.0, 0.0, 0.0
    middle, drift = ZERO, ZERO
    for node in range(NODES):
        m, r, w = mass[node], vector(at[node]), vector(v[node])
        arm = cross(axis, r)
        momentum += m * dot(arm, w)
        inertia += m * dot(arm, arm)
        middle, drift = plus(middle, times(m, r)), plus(drift, times(m, w))
        total += m
    arm = cross(axis, middle)
    return (momentum - dot(arm, drift) / total) / (inertia - dot(arm, arm) / total)


@kernel
def _settle(fishes: Fishes, live: Live, slot: int, rows: int, dt: float, pace: float) -> None:
    """Read body frame and pose from the nodes and write them as playback does.

    The rows of the slots follow the `rows` recorded ones; the body lives `pace` times as fast as
    others.
    """
    i = live.fish[slot]
    x = live.x[slot]
    q, o = frame_of(x)
    for axis in range(3):
        fishes.previous_position[i, axis] = fishes.position[i, axis]
        place = fishes.position[i, axis] + fishes.scale[i] * o[axis] + fishes.drift[i, axis] * dt
        fishes.velocity[i, axis] = (place - fishes.position[i, axis]) / dt
        fishes.position[i, axis] = place
        for node in range(NODES):
            x[node, axis] -= o[axis]
    before = normalised(quaternion(fishes.orientation[i]))
    back = conjugate(before)
    frames = float(fishes.rate[i]) * pace  # recorded frames per tick
    turned = fraction(normalised(multiply(back, q)), 1.0 / frames)
    shift = rotate(back, o)
    fishes.previous_row_a[i], fishes.previous_row_b[i] = fishes.row_a[i], fishes.row_b[i]
    fishes.previous_weight[i], fishes.previous_span[i] = fishes.weight[i], fishes.span[i]
    fishes.row_a[i], fishes.row_b[i] = fishes.row_b[i], fishes.row_a[i]
    row = fishes.row_a[i] - rows
    store(fishes.previous_orientation[i], before)
    store(fishes.orientation[i], q)
    store(live.rotation[row], turned)
    for axis in range(3):
        live.translation[row, axis] = shift[axis] / frames
    inverse = conjugate(q)
    for node in range(NODES):
        store(live.nodes[row, node], rotate(inverse, vector(x[node])))
    ahead = shift[0] / (frames * TICK_S)
    live.speed[slot] += (ahead - live.speed[slot]) / SPEED_TIME


@kernel
def _follow_course(fishes: Fishes, live: Live, slot: int, rows: int, turn: float) -> None:
    """Smooth the heading, which is to turn by `turn`, rad, in this tick: the head sways."""
    i = live.fish[slot]
    x = x_axis(fishes.orientation[i])
    ahead = math.atan2(x[1], x[0]) - live.course[slot] - turn
    ahead = math.atan2(math.sin(ahead), math.cos(ahead))
    share = min(float(fishes.rate[i]) / COURSE_TIME, 1.0)
    live.course[slot] += turn + share * ahead
    live.sway[fishes.row_a[i] - rows] = (1.0 - share) * ahead


@kernel
def frame_of(x: Array) -> tuple[Quaternion, Vector]:
    """Orientation and origin of B for nodes (23, 3): `biomechanics.body_frame`, compiled."""
    o = origin_of(x)
    return of_axes(*axes_of(x, o)), o
