"""Simulate the acyclic segments: escapes, turns from rest and glides, starts and stops.

The muscles bend the body to the inner side and straighten it again. Bending and straightening
alone are nearly reciprocal: both waters turn most of the heading back. A fish holds it with fins
that the hull lacks, spread and swept by its own muscles. They are a couple about the vertical, and
its size is found such that the fish turns by the angle that is wanted. As the body straightens,
the couple also resists further turning. Only turns to the left are simulated: those to the right
are their mirror images.
"""

from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from subsea.base.errors import UserError
from subsea.biomechanics.body import (
    MUSCLES,
    RINGS,
    Body,
    Floats,
    body_frame,
    build_body,
    to_body,
)
from subsea.biomechanics.body_plan import Muscles, SwimPlan
from subsea.biomechanics.controllers import (
    LEFT,
    S_MAX,
    bend_contraction,
    ease,
    swim_contraction,
)
from subsea.biomechanics.fins import brake, couple_force, headings, pectoral_force
from subsea.biomechanics.reactive_water import inertial_mass
from subsea.biomechanics.simulation import (
    STILL,
    BodyState,
    at_rest,
    copy_state,
    is_sound,
    simulate,
)
from subsea.biomechanics.solver import STEPS_PER_TICK, TICK_TU
from subsea.biomechanics.trial import (
    Trial,
    displacement,
    grade_contraction,
    loop_error,
    steady_beat,
)

MIRROR = np.array([0, *(1 + 4 * ring + k for ring in range(RINGS) for k in (1, 0, 3, 2)), 21, 22])
"""The node on the other side of the body for each node."""
UPWARDS = (0.0, 1.0, 0.0)
TOLERANCE_DEG = 0.5
MOST_JERK_BL = 0.1  # largest change of the velocity of a node, body lengths per tick²
MOST_STEP_BL = 0.16  # largest displacement of a node in a tick, body lengths
MOST_SPIN_DEG = 20.0  # of the head in a tick
CLOSE_DEG = 5.0  # a turn that is nearer to its angle is not tried with less bend
LOOP_DEG = 100.0  # error that counts as much as ending a body length off the swim it began in
SLOWER = (1.0, 1.5)  # factors of the times of a turn, if it cannot be as fast
SHARES = (1.0, 0.8, 0.6, 0.4)  # of the bend and the beat
COUPLES = np.concatenate([[0.0], np.geomspace(0.02, 4.0, 24)])  # rad/tu² of a body without drag
MOST_LOST = 3  # greater couples in a row that a body does not bear
YAW_DAMPINGS = (0.6, 1.5, 0.3)  # 1/tu: couples that resist turning over its rate, as tried
MOST_DONE = 0.9  # share of the greatest change of heading at which a turn counts as done
SKETCHED = 0.4  # share of its angle that a sketched turn reaches
SPEED_DEG = 100.0  # error that counts as much as ending at twice the speed ...
MOST_FASTER = 1.3  # ... beyond this ratio to the fastest tick of the swim it began in
LATE_DEG = 2.0  # error that counts as much as a tick after the time to be done
SETTLE_TICKS = 20  # over which it ceases
FIN_AREA = 0.01  # area of a pectoral fin over the square of the body length
COAST_TICKS = 12  # of a glide before a turn
MOST_QUICK_BEATS = 8  # of a start
STARTED = 0.9  # share of the speed of medium at which a start ends
STOP_TICKS = 60
SWAY_DAMPING = 1.0  # 1/tu: how median fins, spread to stop, resist the sway of the body
STRAIGHT_BL = 0.015  # a node nearer to its place at rest is in place, body lengths
BACKING = 0.8  # speed at which the fins sweep forwards to stop, over that of medium
STOPPED = 0.1  # share of the speed of medium at which a fish counts as stopped


class BendingTurn(NamedTuple):
    """A bend to the inner side with a couple, and the beats after it; times in ticks."""

    angle: float  # degrees, of the mean heading
    contraction: float  # of all three muscle segments; less where the body would lose its shape
    bend: float  # until the body is bent
    hold: float
    release: float  # until it is straight again
    counter: float  # contraction of the outer side after the bend, relative to the bend
    beats: int  # swum on
    grade: str  # of these beats
    entry: str = "rest"  # or "glide", or "swim": at medium, with a beat that goes on
    done: float = np.inf  # ticks in which most of it should be done


TURNS = {
    "cstart_left_moderate": BendingTurn(70.0, 0.34, 4.0, 1.0, 5.0, 0.6, 2, "burst", done=29),
    "cstart_left_wide": BendingTurn(135.0, 0.38, 4.0, 4.0, 6.0, 0.6, 2, "burst", done=32),
    "turn_left_rest": BendingTurn(100.0, 0.22, 8.0, 8.0, 12.0, 0.0, 1, "slow", done=28),
    "turn_left_sharp": BendingTurn(90.0, 0.18, 6.0, 6.0, 10.0, 0.0, 1, "medium", "swim"),
    "turn_left_glide": BendingTurn(90.0, 0.18, 8.0, 8.0, 12.0, 0.0, 1, "medium", "glide"),
}


def manoeuvre(motion: Muscles, name: str) -> Trial:
    """Simulate an acyclic segment; UserError where the body loses its shape."""
    body, swim = build_body(motion.body), motion.swim
    if name == "swim_start":
        return _start(body, swim)
    if name == "swim_stop":
        return _stop(body, swim)
    left = name.replace("_right_", "_left_")
    trial = _left_turn(motion, left)
    return trial if name == left else mirrored(trial)


@lru_cache(maxsize=8)
def _left_turn(motion: Muscles, left: str) -> Trial:
    """Search a turn to the left, once for both sides; nobody changes its state."""
    body, swim = build_body(motion.body), motion.swim
    turn, start = TURNS[left], at_rest(body)
    if left == "turn_left_sharp":
        turn = turn._replace(angle=motion.turn.sharp)
    if turn.entry != "rest":
        start = _swimming(body, swim, turn.entry)
    return turn_from(Turner(body, inertial_mass(motion.body, body.mass), swim), turn, start)


def sketched_turn(motion: Muscles, name: str) -> Trial:
    """Try a sharp turn with few couples: a fast sketch of what `manoeuvre` searches.

    Returns the first turn of more than `SKETCHED` of its angle, else the widest. The search finds
    one that is at least as near to its angle. UserError where the body loses its shape.
    """
    body, swim = build_body(motion.body), motion.swim
    turn = TURNS["turn_left_sharp"]._replace(angle=motion.turn.sharp)
    fish = Turner(body, inertial_mass(motion.body, body.mass), swim)
    start = _swimming(body, swim, "swim")
    best, widest = None, -np.inf
    for share, couple in product(SHARES, COUPLES[::4]):
        controls = _turn_controls(body, swim, turn, share, YAW_DAMPINGS[0])
        trial = _with_couple(fish, start, controls._replace(couple=couple * controls.couple))
        if not (is_sound(trial.state) and _is_smooth(trial.frames, motion.body.length)):
            continue
        turned = mean_heading(trial.frames, 1)
        if turned > widest:
            best, widest = trial._replace(couple=couple), turned
        if turned > SKETCHED * turn.angle:
            break
    if best is None:
        raise UserError(f"the body loses its shape in a turn of {turn.angle:g} degrees")
    return mirrored(best) if "right" in name else best


def mirrored(trial: Trial) -> Trial:
    """The trial of a fish in a mirror along its plane of symmetry."""
    flip = np.array([1.0, 1.0, -1.0])
    x, v = (values[MIRROR] * flip for values in (trial.state.x, trial.state.v))
    state = BodyState(x, v, trial.state.watch.copy())
    return trial._replace(frames=trial.frames[:, MIRROR] * flip, state=state)


class Turner(NamedTuple):
    """A fish that turns."""

    body: Body
    inertia: Floats  # (23,) g, of the nodes with the water that moves aside with them
    swim: SwimPlan


def turn_from(fish: Turner, turn: BendingTurn, start: BodyState) -> Trial:
    """Turn left by ``turn.angle``: a search for the couple, and then for its nearest value.

    Where the body would lose its shape it bends and beats less. Returns the sound turn that is
    nearest to the angle, and in time.
    """
    # From swimming, the first and the last frame are at the same phase of the beat.
    swims = turn.entry == "swim"
    beat = 1 if swims else fish.swim.at(turn.grade).ticks_per_beat
    best, least = None, np.inf
    length = float(np.ptp(fish.body.rest[:, 0]))
    usual = _fastest_tick(fish) if swims else 0.0

    def attempt(couple: float) -> float:
        """The angle that is missing, degrees; NaN where the body loses its shape."""
        nonlocal best, least
        trial = _with_couple(fish, start, controls._replace(couple=couple * controls.couple))
        if not (is_sound(trial.state) and _is_smooth(trial.frames, length)):
            return np.nan
        missing = turn.angle - mean_heading(trial.frames, beat)
        error = abs(missing) + LATE_DEG * max(0.0, ticks_to_turn(trial.frames) - turn.done)
        if swims:
            faster = float(np.linalg.norm(displacement(trial.frames[-2:]))) / usual - MOST_FASTER
            error += LOOP_DEG * loop_error(trial.frames) / length + SPEED_DEG * max(faster, 0.0)
        if error < least:
            best, least = trial._replace(couple=couple), error
        return missing

    counters = dict.fromkeys((turn.counter, 0.0))
    for slow, counter, damping, share in product(SLOWER, counters, YAW_DAMPINGS, SHARES):
        milder = turn._replace(hold=slow * turn.hold, release=slow * turn.release, counter=counter)
        controls = _turn_controls(fish.body, fish.swim, milder, share, damping)
        below, lost = 0.0, 0
        for couple in COUPLES:
            missing = attempt(couple)
            lost = lost + 1 if np.isnan(missing) else 0
            if lost == MOST_LOST:
                break
            if missing < 0.0:
                low, high = below, couple
                while not abs(missing) <= TOLERANCE_DEG and high - low > 1e-4:
                    middle = 0.5 * (low + high)
                    missing = attempt(middle)
                    low, high = (middle, high) if missing > 0.0 else (low, middle)
                break
            below = couple
        if least < CLOSE_DEG:
            break
    if best is None:
        raise UserError(f"the body loses its shape in a turn of {turn.angle:g} degrees")
    return best


def _fastest_tick(fish: Turner) -> float:
    """The longest way in a tick of the medium swim, cm."""
    frames = steady_beat(fish.body, grade_contraction(fish.swim, "medium")).frames
    ways = [np.linalg.norm(displacement(frames[k : k + 2])) for k in range(len(frames) - 1)]
    return float(max(ways))


def _is_smooth(frames: Floats, length: float) -> bool:
    """True if no node leaps, and neither a node nor the snout is jerked."""
    way, change = (np.linalg.norm(np.diff(frames, n, axis=0), axis=2).max() for n in (1, 2))
    spin = np.abs(np.diff(headings(frames))).max()
    smooth = way <= MOST_STEP_BL * length and change <= MOST_JERK_BL * length
    return bool(smooth and spin <= MOST_SPIN_DEG)


def mean_heading(frames: Floats, beat: int) -> float:
    """Mean heading over the last ``beat`` ticks relative to the first frame, degrees."""
    heading = headings(frames)
    return float(heading[-beat:].mean() - heading[0])


def ticks_to_turn(frames: Floats) -> int:
    """Ticks until most of the greatest change of heading is done."""
    change = np.maximum.accumulate(np.abs(headings(frames) - headings(frames[:1])))
    return int(np.searchsorted(change, MOST_DONE * change[-1]))


class Controls(NamedTuple):
    """Muscles and fins in a turn of T ticks."""

    contraction: Floats  # (6 T, 12)
    couple: Floats  # (T,) rad/tu², about the vertical through the centre of mass
    damping: Floats  # (T,) 1/tu, of the couple that resists turning


def _turn_controls(
    body: Body, swim: SwimPlan, turn: BendingTurn, share: float, resistance: float
) -> Controls:
    """Controls with a couple of at most 1, and one that resists turning."""
    swim = swim.at(turn.grade)
    amplitude = share * swim.amplitude(turn.grade)
    turning = turn.bend + turn.hold + turn.release
    ticks = int(np.ceil(turning)) + turn.beats * swim.ticks_per_beat
    if turn.entry == "swim":
        ticks = int(np.ceil(ticks / swim.ticks_per_beat)) * swim.ticks_per_beat
    at = np.arange(ticks * STEPS_PER_TICK) / STEPS_PER_TICK
    fastest = S_MAX * STEPS_PER_TICK * turn.bend / body.length[:MUSCLES].max()
    size = share * min(turn.contraction, fastest)
    released = turn.bend + turn.hold
    inner = np.clip(at / turn.bend, 0.0, 1.0) - ease((at - released) / turn.release)
    half = 0.5 * turn.release
    outer = ease((at - released) / half) - ease((at - released - half) / half)
    contraction = _bend(size, LEFT, inner) + _bend(turn.counter * size, -LEFT, outer)
    begin = released + half
    fade = amplitude * (ease((at - begin) / turn.release) if turn.entry != "swim" else 1.0)
    phase = 2.0 * np.pi * (at - ticks) / swim.ticks_per_beat  # ends at phase 0
    contraction += swim_contraction(swim, phase, fade)
    middle = (np.arange(ticks) + 0.5) / turning
    couple = np.where(middle < 1.0, np.sin(np.pi * middle) ** 2, 0.0)
    begun, left = np.arange(ticks) - released, ticks - np.arange(ticks)
    damping = resistance * ease(begun / turn.release) * ease(left / SETTLE_TICKS)
    return Controls(contraction, couple, damping)


def _bend(size: float, side: float, share: Floats) -> Floats:
    """Contractions of all three muscle segments on one side."""
    front = bend_contraction((size, size), side, share)
    front[:, 8:] = front[:, 4:8]
    return front


def _with_couple(fish: Turner, start: BodyState, controls: Controls) -> Trial:
    """Simulate a turn; where the body loses its shape, the last frame is repeated."""
    state, inertia = copy_state(start), fish.inertia
    frames = [state.x.copy()]
    rate = 0.0  # rad/tu
    for tick, push, damping in zip(
        _ticks(controls.contraction), controls.couple, controls.damping, strict=True
    ):
        force = couple_force(state.x, inertia, UPWARDS, float(push - damping * rate))
        frames.extend(simulate(fish.body, state, tick, force=force))
        if not is_sound(state):
            frames += [state.x.copy()] * (len(controls.couple) + 1 - len(frames))
            break
        rate = float(np.radians(np.diff(headings(np.array(frames[-2:])))[0])) / TICK_TU
    return Trial(np.array(frames), state)


def _ticks(contraction: Floats) -> list[Floats]:
    return np.split(contraction, len(contraction) // STEPS_PER_TICK)


def _swimming(body: Body, swim: SwimPlan, entry: str) -> BodyState:
    """The state of a fish that swims at grade medium, or coasts from there with a straight body."""
    beat = grade_contraction(swim, "medium")
    state = steady_beat(body, beat).state
    if entry == "glide":
        simulate(body, state, _fading(beat, COAST_TICKS))
    return state


def _fading(beat: Floats, ticks: int) -> Floats:
    """Contractions (6 T, 12) of a beat that is repeated and fades in three quarters of the time."""
    steps = ticks * STEPS_PER_TICK
    fade = 1.0 - ease(np.arange(1, steps + 1) / (0.75 * steps))
    return np.asarray(fade[:, None] * np.resize(beat, (steps, MUSCLES)))


def _start(body: Body, swim: SwimPlan) -> Trial:
    """Swim off from rest with quick beats, then at grade medium, to phase 0."""
    beat, quick = (grade_contraction(swim, grade) for grade in ("medium", "fast"))
    usual = np.linalg.norm(displacement(steady_beat(body, beat).frames))
    ticks = len(beat) // STEPS_PER_TICK
    best: Trial | None = None
    for number in range(MOST_QUICK_BEATS + 1):
        contraction = np.concatenate([*[quick] * number, beat, beat])
        fade = ease(np.arange(len(contraction)) / len(quick))[:, None]
        state = at_rest(body)
        frames = np.concatenate([body.rest[None], simulate(body, state, fade * contraction)])
        if not is_sound(state):
            break
        best = Trial(frames, state)
        if np.linalg.norm(displacement(frames[-ticks - 1 :])) > STARTED * usual:
            break
    if best is None:
        raise UserError("the body lost its shape in a start")
    return best


def _stop(body: Body, swim: SwimPlan) -> Trial:
    """Stop beating at phase 0 of medium, glide, and row backwards with both pectoral fins."""
    trial = steady_beat(body, grade_contraction(swim, "medium"))
    state = trial.state
    speed = float(np.linalg.norm(body.mass @ state.v) / body.mass.sum())
    frames = [state.x.copy()]
    frames.extend(simulate(body, state, _fading(grade_contraction(swim, "medium"), COAST_TICKS)))
    length, mass = float(np.ptp(body.rest[:, 0])), body.mass[:, None]
    relaxed = np.zeros((STEPS_PER_TICK, MUSCLES))
    moving = True
    for _ in range(STOP_TICKS):
        force = SWAY_DAMPING * mass * (body.mass @ state.v / body.mass.sum() - state.v)
        if moving:
            force += pectoral_force(state, FIN_AREA * length**2, *brake(), STILL, BACKING * speed)
        frames.extend(simulate(body, state, relaxed, force=force))
        moving &= bool(np.linalg.norm(body.mass @ state.v) >= STOPPED * speed * body.mass.sum())
        if not moving and _bent(body, frames[-1]) < STRAIGHT_BL * length:
            break
    if not is_sound(state):
        raise UserError("the body lost its shape in a stop")
    return Trial(np.array(frames), state, trial.warm_up_beats)


def _bent(body: Body, x: Floats) -> float:
    """The largest distance of a node of x (23, 3) from its place in the body at rest, cm."""
    return float(np.linalg.norm(to_body(x, *body_frame(x)) - body.rest, axis=1).max())
