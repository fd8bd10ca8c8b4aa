"""Simulated fishes: the muscle-driven body under command of the secondary controller.

The body swims at the size and pace of the recorded fish, in the frame of the water at its origin.
Water that flows otherwise along the body turns and bends it (Tu §8.1). Muscles and fins follow the
segment, tempo, thrust and steering that the controller asks of playback. Muscles alone turn the
fish; a couple, as strong as the lift of its pectoral fins, pitches it.
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
from subsea.biomechanics.body_plan import GRADES, MAX_CONTRACTION, Muscles
from subsea.biomechanics.fins import ROLL_GAIN, STEEPEST, couple_force
from subsea.biomechanics.reactive_water import inertial_mass, sections_of
from subsea.biomechanics.solver import STEP, TICK_S, TICK_TU, TIME_UNIT_S, advance
from subsea.fish.species import Species
from subsea.fish.surface import SurfacePlan, along
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
    minus,
    plus,
    store,
    times,
    vector,
)
from subsea.kernels import kernel
from subsea.motor.controller import own_speed
from subsea.motor.playback import (
    BASE,
    COAST,
    LEFT_GRADUAL,
    LEFT_SHARP,
    MEDIUM,
    RIGHT_SHARP,
    TEMPO,
    TURNS,
    blends,
)
from subsea.repertoire import SEGMENTS
from subsea.repertoire.blending import LEVELS
from subsea.repertoire.library import Library
from subsea.state import DORSAL, PELVIC, Fishes, Live, Physics

MAX_RATE = 8  # recorded frames per tick, of a fish with 1/64 of the recorded length
LEAP_BL = 1.0  # displacement of a body per tick, at the pace of its size, that means divergence
FIN_AREA = 0.01  # of each pectoral fin, over the squared body length
LAST_RING = (17, 18, 19, 20)  # nodes of the ring before the tail
MEDIAN_NODES, PELVIC_NODES = (9, 17), (5, 13)  # first and end node of the rings with these fins
PADDLE_SHAPE = 0.7  # area of a pelvic fin over length and width
BEND_EASE = 1.0 / LEVELS  # share of the full bend per recorded frame, as in playback ...
STILL_EASE = 1.0 / 21.0  # ... and in a coast, where a quick bend makes the body swing for long
MOST_BEND = 0.4  # contraction in sharp turns
SHARP_SHARE = 1.3  # turning rate in the midst of a sharp turn over its mean, with straight ends
SLOWEST_TURN = 0.4  # least speed over that of a gradual turn: a slower fish does not bend further
PITCH_GAIN = 0.5  # 1/tu: the couple of the fins over the error of the pitching rate
GEAR_EASE = 3.0 / 14.0  # grades by which the beat may change in a tick
ROLL_LEAD = 0.7  # radians of the roll oscillation by which the fins lead; less overshoots
SCULL_SPEED = 1.2  # cm/tu: the fins of a slower fish beat, and meet the water at this speed
TEMPO_EASE = 0.025  # change of the tempo per tick toward the recorded one
SPEED_GAIN = 2.0  # gain on the speed error, as fins and bends slow the fish
TOO_FAST = 0.03  # share of excess speed above which the fins brake
HARDEST_BRAKE = 2.0  # times the pectoral area: a stopping fish spreads its other fins too
BRAKE_GAIN = 5.0  # braking share of the fin area per share of excess speed
SPEED_TIME = 21.0  # ticks over which the speed is smoothed: a beat and a half
COURSE_TIMES = 8.0, 21.0  # likewise the heading, in recorded frames, in a coast and in a beat
BEATS = 0.5  # gear from which a fish beats rather than coasts
FIRST_STROKE = np.radians(30.0)  # phase of a beat that turns a fish to the left, if it is short


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
    pitching: Array  # (S,) rad/cm², couple of the fins' greatest lift over the squared speed
    median_area: Array  # (S,) of dorsal and ventral fin, erect ...
    pelvic_area: Array  # (S,) ... and of both pelvic fins, spread


def make_bodies(species: Sequence[Species], library: Library) -> BodyTables:
    """Make the tables of some species, in the order of the packed library.

    Spine-driven species have no body to simulate and get rows of zeros, which nothing reads.
    """
    rates = library.turn / (library.length * TICK_S)
    rows = [
        _body(one.muscles, one.surface, speed, rate) if one.muscles else NO_BODY
        for one, speed, rate in zip(species, library.speed, rates, strict=True)
    ]
    return BodyTables(*(np.array(column, np.float64) for column in zip(*rows, strict=True)))


_ROW = (23, 91, 91, 91, 1, (5, 6), 1, 4, (4, 2), 4, 4, 2, len(SEGMENTS), 23, 1, 1, 1, 1, 1)
NO_BODY = tuple(np.zeros(n) if n != 1 else 0.0 for n in _ROW)
"""A row of `BodyTables` without content."""


def under(bodies: BodyTables, physics: Physics) -> BodyTables:
    """Change the tables to other physics (Tu §9.2)."""
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
        pitching=bodies.pitching * water,
        roll_lead=bodies.roll_lead * lead,
        median_area=bodies.median_area * water,
        pelvic_area=bodies.pelvic_area * water,
    )


def _body(
    muscles: Muscles, surface: SurfacePlan, speed: Array, turn_rate: Array
) -> tuple[Any, ...]:
    body, swim = build_body(muscles.body), muscles.swim
    gaits = [swim.at(grade) for grade in GRADES[:3]]
    paces = [swim.ticks_per_beat / gait.ticks_per_beat for gait in gaits]
    contractions = [
        np.multiply(swim.amplitude(grade), gait.contraction)
        for grade, gait in zip(GRADES, gaits, strict=False)
    ]
    fin_area, inertia = FIN_AREA * muscles.body.length**2, inertial_mass(muscles.body, body.mass)
    areas = muscles.body.length**2 * _spread_areas(surface)
    return (
        body.mass, body.length, body.stiffness, body.viscosity, body.drag, np.array(body.sections),
        swim.ticks_per_beat, (0.0, *speed[:3]), np.array([(0.0, 0.0), *contractions]),
        (gaits[0].lag, *(gait.lag for gait in gaits)), (paces[0], *paces),
        muscles.turn.gradual, turn_rate, inertia,
        fin_area, _roll_lead(body, fin_area), _pitching(body, inertia, fin_area), *areas,
    )  # fmt: skip


def _spread_areas(plan: SurfacePlan) -> Array:
    """Measure the area (2,) of median and of pelvic fins, over the squared body length.

    Sums here and below do not use BLAS, whose bits differ by processor.
    """
    median = 0.0
    for fin, ridge in ((plan.dorsal, plan.back), (plan.ventral, plan.belly)):
        if fin:
            base = np.linspace(fin.base[1], fin.base[0], 9)
            x, y = np.concatenate([fin.edge, np.stack([base, along(ridge, base)], axis=1)]).T
            median += abs((x * np.roll(y, 1) - y * np.roll(x, 1)).sum()) / 2.0
    pelvic = 2.0 * PADDLE_SHAPE * plan.pelvic.length * plan.pelvic.width if plan.pelvic else 0.0
    return np.array([median, pelvic])


def _roll_lead(body: Body, fin_area: float) -> float:
    """Compute the time, tu, of :data:`ROLL_LEAD` radians of the roll that such fins make."""
    y, z = body.rest[:, 1], body.rest[:, 2]
    inertia = (body.mass * (y**2 + z**2)).sum()
    arm = np.abs(z[1:13]).mean()
    stiffness = ROLL_GAIN * 2.0 * fin_area * SCULL_SPEED**2 * arm
    return float(ROLL_LEAD / math.sqrt(stiffness / inertia))


def _pitching(body: Body, inertia: Array, fin_area: float) -> float:
    """Compute the couple, rad/tu², of both fins at STEEPEST in water that passes at 1 cm/tu."""
    arm = body.rest - (inertia[:, None] * body.rest).sum(axis=0) / inertia.sum()
    lift = 2.0 * fin_area * math.sin(STEEPEST) * math.cos(STEEPEST)
    swing = (inertia * (arm[:, 0] ** 2 + arm[:, 1] ** 2)).sum()
    return float(lift * abs(arm[1:13, 0].mean()) / swing)


class Integration(NamedTuple):
    """Integration parameters of a tick."""

    dt: float  # s, a tick
    time_step: float  # factor on the step of 5.5 ms, as in `state.Physics`
    iterations: int  # steps in a tick of a fish of the recorded size
    strain: tuple[float, float]  # limits of a unit's length over its rest length
    shear: Array  # (k, 2, 3) cm/s, of the water at snout and tail over that at the origin


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
    dt, time_step, iterations, (least, most), shear = integration
    sound = np.ones(len(live.fish), np.bool_)
    muscles = np.empty((MAX_RATE * iterations, MUSCLES))
    time = STEP * time_step * iterations  # length of a tick for a fish of the recorded size
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
            if live.gear[slot] > 0.0:
                live.phase[slot] = (live.phase[slot] + beat * step) % (2.0 * np.pi)
        x, v = live.x[slot].copy(), live.v[slot].copy()
        lift = float(fishes.steering[i, 1]) / rate
        brake = _brake(fishes, library, live, slot)
        watch = np.array([np.inf, 0.0, np.inf])
        material = Material(
            bodies.mass[kind], bodies.length[kind], bodies.stiffness[kind],
            bodies.viscosity[kind], bodies.drag[kind], sections_of(bodies.sections[kind]),
        )  # fmt: skip
        tips = shear[slot] * (TIME_UNIT_S / (float(fishes.scale[i]) * rate))
        water = np.zeros((NODES, 3))
        # The fins follow the body at every recorded frame: more rarely they would overshoot.
        for begin in range(0, steps, iterations):
            # In the frame of the water around each node, the water is still.
            flow_along(x, tips, water)
            v -= water
            force = fin_force(bodies, kind, x, v, brake)
            force += pitching_force(bodies, kind, x, v, lift * TICK_S / TICK_TU)
            median, pelvic = fishes.fins[i, DORSAL], fishes.fins[i, PELVIC]
            force += spread_force(bodies, kind, x, v, median, pelvic)
            part = muscles[begin : min(begin + iterations, steps)]
            advance(x, v, material, part, np.zeros(3), force, step, watch)
            v += water
            x += step * len(part) * water
        sound[slot] = least <= watch[0] and watch[1] <= most and watch[2] > 0.0
        leap = LEAP_BL * rate * library.recorded_length[kind]
        sound[slot] &= np.isfinite(x).all() and np.abs(x - live.x[slot]).max() < leap
        if sound[slot]:
            before, after = mean_of(bodies.mass[kind], live.x[slot]), mean_of(bodies.mass[kind], x)
            # Sines of C libraries differ by processor in their last bit: float32 drops it. Arrays
            # that are assigned as a whole take seconds to compile.
            for n, k in np.ndindex(x.shape):
                live.x[slot, n, k], live.v[slot, n, k] = np.float32(x[n, k]), np.float32(v[n, k])
            _settle(fishes, live, slot, len(library.entry), dt, time / TICK_TU)
            for axis in range(3):
                # Not of the origin, which sways with the beat: a coast would end at once.
                way = fishes.scale[i] * (after[axis] - before[axis])
                fishes.velocity[i, axis] = way / dt + fishes.drift[i, axis]
            segment = TURNS[COAST if live.gear[slot] < BEATS else MEDIUM, 0]
            turn = bodies.turn_rate[kind, segment] / library.speed[kind, segment]
            turn *= live.speed[slot] * live.bend[slot, 0] / bodies.bend[kind, 0]
            _follow_course(fishes, live, slot, len(library.entry), turn * rate * dt)
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
    wanted = fishes.wanted_segment[i]
    # One that is to be played back keeps a steady beat, from which a recorded one can follow.
    coasts = BASE[wanted] == COAST and live.waiting[slot] == 0
    share = bodies.turn_rate[kind, wanted] / bodies.turn_rate[kind, LEFT_GRADUAL]
    if wanted in (LEFT_SHARP, RIGHT_SHARP):
        share *= SHARP_SHARE
    if blends(library, kind, wanted):
        share = float(fishes.bend[i]) * float(fishes.tempo[i])
    share /= _turning_share(library, live, slot, kind)
    if coasts:
        share = float(fishes.bend[i])
    most = MOST_BEND / bodies.bend[kind].max()
    # A fish that is to be played back straightens, as every segment is begun.
    share = min(max(share, -most), most) if live.waiting[slot] == 0 else 0.0
    for k in range(2):
        ease = (STILL_EASE if coasts else BEND_EASE) * fishes.rate[i] * bodies.bend[kind, k]
        gap = share * bodies.bend[kind, k] - live.bend[slot, k]
        live.bend[slot, k] += min(max(gap, -ease), ease)
    speed = _wanted_speed(fishes, library, i)
    speed += SPEED_GAIN * (speed - live.speed[slot])
    if coasts:
        speed = 0.0
    # A bent body keeps its shape at the beat of a gradual turn, which is that of medium.
    medium, fast = bodies.speed[kind, 2], bodies.speed[kind, 3]
    speed = min(speed, fast + min(abs(share), 1.0) * (medium - fast))
    gap = np.interp(speed, bodies.speed[kind], GEARS) - live.gear[slot]
    if live.gear[slot] == 0.0 and gap > 0.0:
        # A few strokes turn a fish a little, by the side of the first: it takes that of its goal.
        goal = fishes.goal_direction[i]
        aside = _wrapped(math.atan2(goal[1], goal[0]) - live.course[slot])
        live.phase[slot] = FIRST_STROKE + (0.0 if aside > 0.0 else np.pi)
    live.gear[slot] += min(max(gap, -GEAR_EASE), GEAR_EASE)
    tempo = np.interp(speed, bodies.speed[kind], bodies.pace[kind])
    live.tempo[slot] += min(max(tempo - live.tempo[slot], -TEMPO_EASE), TEMPO_EASE)


@kernel
def _turning_share(library: Library, live: Live, slot: int, kind: int) -> float:
    """Turning rate of a bent fish over the recorded one: on the same circle, as its speed."""
    return max(live.speed[slot] / library.speed[kind, LEFT_GRADUAL], SLOWEST_TURN)


@kernel
def pitching_force(bodies: BodyTables, kind: int, at: Array, v: Array, rate: float) -> Array:
    """Force (23, 3) of the fins on the nodes that pitches the body at `rate`, rad/tu."""
    q, _ = frame_of(at)
    across, inertia = rotate(q, (0.0, 0.0, 1.0)), bodies.inertia[kind]
    u = (v[1:13, 0].mean(), v[1:13, 1].mean(), v[1:13, 2].mean())
    most = bodies.pitching[kind] * max(dot(u, u), SCULL_SPEED**2)
    couple = PITCH_GAIN * (rate - roll_rate(at, v, inertia, across))
    return couple_force(at, inertia, across, min(max(couple, -most), most))


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
        out[m] = bodies.length[kind, m] * (1.0 - min(share, MAX_CONTRACTION))


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
def spread_force(
    bodies: BodyTables, kind: int, at: Array, v: Array, median: float, pelvic: float
) -> Array:
    """Force (23, 3) of spread median fins, which resist sway and yaw, and drag of pelvic fins.

    `median` and `pelvic` are shares of their areas. Only the way of the whole body counts: the
    water's forces on the scaffold hold those of fins that beat with it.
    """
    force, mass = np.zeros((NODES, 3)), bodies.mass[kind]
    q, _ = frame_of(at)
    x, up, right = x_axis(q), rotate(q, (0.0, 1.0, 0.0)), rotate(q, (0.0, 0.0, 1.0))
    middle, drift = mean_of(mass, at), mean_of(mass, v)
    yaw = roll_rate(at, v, mass, up)
    first, end = MEDIAN_NODES
    for node in range(first, end):
        arm = plus(vector(at[node]), times(-1.0, middle))
        aside = dot(plus(drift, times(yaw, cross(up, arm))), right)
        push = -bodies.median_area[kind] * median / (end - first) * abs(aside) * aside
        for axis in range(3):
            force[node, axis] += push * right[axis]
    first, end = PELVIC_NODES
    drag = bodies.pelvic_area[kind] * pelvic / (end - first) * max(dot(drift, x), 0.0) ** 2
    for node in range(first, end):
        for axis in range(3):
            force[node, axis] -= drag * x[axis]
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
def flow_along(x: Array, tips: Array, out: Array) -> None:
    """Write the velocity (23, 3) of the water at nodes x over that at their origin, cm/tu.

    It is `tips` (2, 3) at snout and tail, and a parabola between. Only what crosses the body
    counts; its slope turns the nodes together and does not strain them.
    """
    q, o = frame_of(x)
    ahead = x_axis(q)
    front, back = _across(vector(tips[0]), ahead), _across(vector(tips[1]), ahead)
    snout, tail = dot(minus(vector(x[0]), o), ahead), dot(minus(vector(x[21]), o), ahead)
    scale = 1.0 / (snout * tail * (tail - snout))
    slope = minus(times(scale * tail * tail, front), times(scale * snout * snout, back))
    arch = minus(times(scale * snout, back), times(scale * tail, front))
    spin = cross(ahead, slope)
    for node in range(NODES):
        arm = minus(vector(x[node]), o)
        s = dot(arm, ahead)
        store(out[node], plus(cross(spin, arm), times(s * s, arch)))


@kernel
def _across(w: Vector, axis: Vector) -> Vector:
    """The part of w across a unit vector."""
    return minus(w, times(dot(w, axis), axis))


@kernel
def mean_of(mass: Array, x: Array) -> Vector:
    """Compute the mean of x (23, 3), such as positions or velocities of nodes, by their masses."""
    mean = ZERO
    for node in range(NODES):
        mean = plus(mean, times(mass[node], vector(x[node])))
    return times(1.0 / mass.sum(), mean)


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
    """Smooth the heading of a body that turns by `turn`, rad, in this tick.

    The head sways with the beat and points inwards in a bend. The fish goes where its body points,
    from the last ring to the nose.
    """
    i = live.fish[slot]
    x, nodes = x_axis(fishes.orientation[i]), live.x[slot]
    ahead, left = 0.0, 0.0
    for node in LAST_RING:
        ahead, left = ahead + nodes[0, 0] - nodes[node, 0], left + nodes[0, 1] - nodes[node, 1]
    still, beating = COURSE_TIMES
    time = still + (beating - still) * min(live.gear[slot], 1.0)
    gap = _wrapped(math.atan2(left, ahead) - live.course[slot] - turn)
    live.course[slot] = np.float32(live.course[slot] + turn + min(fishes.rate[i] / time, 1.0) * gap)
    live.sway[fishes.row_a[i] - rows] = _wrapped(math.atan2(x[1], x[0]) - live.course[slot])


@kernel
def _wrapped(angle: float) -> float:
    """The angle between -π and π."""
    return math.atan2(math.sin(angle), math.cos(angle))


@kernel
def frame_of(x: Array) -> tuple[Quaternion, Vector]:
    """Orientation and origin of B for nodes (23, 3): `biomechanics.body_frame`, compiled."""
    o = origin_of(x)
    return of_axes(*axes_of(x, o)), o
