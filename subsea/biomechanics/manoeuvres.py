"""Simulate the acyclic segments: escapes, turns from rest and glides, starts and stops.

The muscles bend the body to the inner side, hold it bent and straighten it again, while the tail
beats on. Nothing else turns the fish. How far, how long and how fast it bends is searched, such
that it turns by the angle that is wanted. Only turns to the left are simulated: those to the right
are their mirror images.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from subsea.base.errors import UserError
from subsea.biomechanics.body import (
    LOWER_TAIL,
    MUSCLE_LEFT,
    MUSCLE_SEGMENT,
    MUSCLES,
    RINGS,
    UPPER_TAIL,
    Body,
    Floats,
    body_frame,
    build_body,
    to_body,
)
from subsea.biomechanics.body_plan import MAX_CONTRACTION, Muscles, SwimPlan
from subsea.biomechanics.controllers import S_MAX, ease, swim_contraction
from subsea.biomechanics.fins import brake, headings, pectoral_force
from subsea.biomechanics.simulation import (
    STILL,
    BodyState,
    at_rest,
    copy_state,
    is_sound,
    simulate,
)
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.biomechanics.trial import (
    Trial,
    displacement,
    grade_contraction,
    loop_error,
    steady_beat,
)

MIRROR = np.array([0, *(1 + 4 * ring + k for ring in range(RINGS) for k in (1, 0, 3, 2)), 21, 22])
"""The node on the other side of the body for each node."""
SLOPE = 1.5  # greatest rate of `ease` over its mean one
BENT_DEG = 25.0  # bend of the body beyond that of a beat: from here on it counts
FOLDED_DEG = 85.0  # bend beyond which a body of a calm turn is folded
MOST_ACCELERATION_BL = 0.0035  # of the centre of mass in a calm turn, body lengths per tick²
MOST_JERK_BL = 0.08  # change of the velocity of a node, body lengths per tick²
MOST_STEP_BL = 0.15  # displacement of a node in a tick, body lengths
MOST_SPIN_DEG = 16.0  # of the head in a tick
LOOP_BL = 0.02  # distance from the pose of the swim in which a turn ends
SPEEDS = (0.8, 1.25)  # at the end of a turn from a swim, over that of the swim
MOST_DONE = 0.9  # share of the angle at which a turn counts as done
FIRST, SAMPLES, ELITES, ROUNDS, SKETCHED_ROUNDS = 240, 24, 6, 25, 2
"""Bends in rounds of the search, those that the next round is drawn around, and rounds."""
HASTE = 0.36  # loss of a tick more of an escape; a degree short is a third
UNSOUND = 1e4  # least loss of a bend in which the body loses its shape
SMOOTHING = 0.2  # share of the last round in what the next one is drawn from
FIN_AREA = 0.01  # area of a pectoral fin over the square of the body length
COAST_TICKS = 12  # of a glide before a turn
MOST_QUICK_BEATS = 8  # of a start
STARTED = 0.9  # share of the speed of medium at which a start ends
STOP_TICKS = 60
SWAY_DAMPING = 1.0  # 1/tu: how median fins, spread to stop, resist the sway of the body
STRAIGHT_BL = 0.015  # a node nearer to its place at rest is in place, body lengths
BACKING = 0.8  # speed at which the fins sweep forwards to stop, over that of medium
STOPPED = 0.1  # share of the speed of medium at which a fish counts as stopped


class Bend(NamedTuple):
    """Course of the bend in a turn; contractions are fractions of a rest length, times ticks."""

    front: float  # contraction of the foremost muscle segment on the inner side ...
    middle: float
    rear: float
    bend: float  # ticks until it is bent
    hold: float
    release: float  # until it is straight again
    beat: float  # share of the beat that goes on while it is bent
    counter: float  # contraction of the outer side after the bend, relative to the bend
    follow: float  # share of the bend that stays until a beat before the end


class TurnAim(NamedTuple):
    """Aim of a turn, and the box in which its bend is searched."""

    angle: float  # degrees, of the mean heading
    entry: str  # "rest", "glide", or "swim": at medium, with a beat that goes on
    grade: str  # of the beats after the bend
    beats: int
    calm: bool = True
    least: Bend = Bend(0.0, 0.05, 0.0, 3.0, 0.0, 5.0, 0.0, 0.0, 0.0)
    most: Bend = Bend(0.5, 0.6, 0.6, 16.0, 22.0, 26.0, 1.0, 0.0, 0.7)


QUICKEST = Bend(0.6, 0.6, 0.6, 12.0, 18.0, 16.0, 1.0, 1.0, 0.8)
TURNS = {
    "cstart_left_moderate": TurnAim(70.0, "rest", "burst", 3, calm=False, most=QUICKEST),
    "cstart_left_wide": TurnAim(120.0, "rest", "burst", 3, calm=False, most=QUICKEST),
    "turn_left_rest": TurnAim(90.0, "rest", "medium", 2),
    "turn_left_sharp": TurnAim(90.0, "swim", "medium", 2),
    "turn_left_glide": TurnAim(90.0, "glide", "medium", 2),
}


def manoeuvre(motion: Muscles, name: str) -> Trial:
    """Simulate an acyclic segment; UserError where the body loses its shape."""
    body, swim = build_body(motion.body), motion.swim
    if name == "swim_start":
        return _start(body, swim)
    if name == "swim_stop":
        return _stop(body, swim)
    return _turn(motion, name)


def sketched_turn(motion: Muscles, name: str) -> Trial:
    """Try a turn with few bends: a fast sketch of what `manoeuvre` searches."""
    return _turn(motion, name, SKETCHED_ROUNDS)


def _turn(motion: Muscles, name: str, rounds: int = ROUNDS) -> Trial:
    left = name.replace("_right_", "_left_")
    trial = _left_turn(motion, left, rounds)
    return trial if name == left else mirrored(trial)


@lru_cache(maxsize=8)
def _left_turn(motion: Muscles, left: str, rounds: int) -> Trial:
    """Search a turn to the left, once for both sides; nobody changes its state."""
    return Turner(motion, left).search(rounds)


def mirrored(trial: Trial) -> Trial:
    """The trial of a fish in a mirror along its plane of symmetry."""
    flip = np.array([1.0, 1.0, -1.0])
    x, v = (values[MIRROR] * flip for values in (trial.state.x, trial.state.v))
    state = BodyState(x, v, trial.state.watch.copy())
    return trial._replace(frames=trial.frames[:, MIRROR] * flip, state=state)


class Turner:
    """A fish that turns to the left: the bend of its turn is searched."""

    def __init__(self, motion: Muscles, left: str) -> None:
        """Swim, coast or rest up to the beginning of the turn with the name ``left``."""
        turn = TURNS[left]
        if left == "turn_left_sharp":
            turn = turn._replace(angle=motion.turn.sharp)
        self.turn, self.body = turn, build_body(motion.body)
        grade = turn.grade if turn.grade in motion.swim.grades else "fast"
        self._swim = motion.swim.at(grade)
        self._amplitude = motion.swim.amplitude(grade)
        self._length = motion.body.length
        self._start, self._pace = at_rest(self.body), 0.0  # cm a tick
        if turn.entry != "rest":
            beat = grade_contraction(motion.swim, "medium")
            steady = steady_beat(self.body, beat)
            self._start = steady.state
            self._pace = float(np.linalg.norm(displacement(steady.frames)))
            self._pace /= len(steady.frames) - 1
            if turn.entry == "glide":
                simulate(self.body, self._start, _fading(beat, COAST_TICKS))

    def search(self, rounds: int) -> Trial:
        """Find the best bend by the cross-entropy method; UserError if none keeps the shape.

        Each round draws bends from a normal distribution, and the best of them make the next one.
        """
        low, high = np.array(self.turn.least), np.array(self.turn.most)
        rng = np.random.default_rng(1)
        middle, spread = np.full(len(low), 0.5), np.full(len(low), 0.3)
        best, least = middle, np.inf
        for number in range(rounds):
            size = SAMPLES if number else FIRST, len(low)
            points = middle + spread * rng.normal(size=size)
            points = np.clip(points, 0.0, 1.0)
            if number:
                points[0] = best
            losses = [self._loss(Bend(*(low + point * (high - low)))) for point in points]
            order = np.argsort(losses, kind="stable")[:ELITES]
            if losses[order[0]] < least:
                best, least = points[order[0]], losses[order[0]]
            elite = points[order]
            middle = SMOOTHING * middle + (1.0 - SMOOTHING) * elite.mean(axis=0)
            spread = SMOOTHING * spread + (1.0 - SMOOTHING) * np.maximum(elite.std(axis=0), 0.01)
        if least >= UNSOUND:
            raise UserError(f"the body loses its shape in a turn of {self.turn.angle:g} degrees")
        return self.swim(Bend(*(low + best * (high - low))))

    def swim(self, bend: Bend) -> Trial:
        """Simulate the turn with a bend, and the beats after it."""
        state = copy_state(self._start)
        state.watch[:] = at_rest(self.body).watch
        frames = simulate(self.body, state, self._contraction(bend))
        return Trial(np.concatenate([self._start.x[None], frames]), state, bend=tuple(bend))

    def _contraction(self, bend: Bend) -> Floats:
        """Contractions (6 T, 12) of the whole turn, which ends at phase 0 of the beat."""
        beat = self._swim.ticks_per_beat
        swims = self.turn.entry == "swim"
        ticks = int(np.ceil(bend.bend + bend.hold + bend.release)) + self.turn.beats * beat
        if swims:  # the first and the last frame are at the same phase
            ticks = int(np.ceil(ticks / beat)) * beat
        at = np.arange(ticks * STEPS_PER_TICK) / STEPS_PER_TICK
        released, half = bend.bend + bend.hold, 0.5 * bend.release
        inner = ease(at / bend.bend) - (1.0 - bend.follow) * ease((at - released) / bend.release)
        inner -= bend.follow * ease((at - ticks + 1.5 * beat) / (0.75 * beat))
        outer = ease((at - released) / half) - ease((at - released - half) / half)
        fastest = S_MAX * STEPS_PER_TICK / (SLOPE * self.body.length[:MUSCLES])  # a tick
        size, left = np.array(bend[:3])[MUSCLE_SEGMENT], MUSCLE_LEFT > 0
        contraction = np.outer(inner, np.minimum(size, bend.bend * fastest) * left)
        contraction += np.outer(outer, np.minimum(bend.counter * size, half * fastest) * ~left)
        share = ease((at - released - half) / bend.release)
        share = 1.0 - (1.0 - bend.beat) * inner if swims else share
        phase = 2.0 * np.pi * (at - ticks) / beat
        contraction += swim_contraction(self._swim, phase, self._amplitude * share)
        return np.minimum(contraction, MAX_CONTRACTION)

    def _loss(self, bend: Bend) -> float:
        """Measure the lack of a turn: beyond `UNSOUND` where the body loses its shape."""
        turn, length, trial = self.turn, self._length, self.swim(bend)
        if not is_sound(trial.state):
            return UNSOUND * (1.0 + sum(bend[:3]))  # gentler bends are nearer to sound ones
        frames, beat = trial.frames, self._swim.ticks_per_beat
        heading = headings(frames) - headings(frames[:1])
        final = float(heading[-beat:].mean())
        done = ticks_to(heading, MOST_DONE * max(final, 1.0))
        bends = body_bend(frames)
        against = int((bends[: done + 3] < -BENT_DEG).sum())
        way, change = (np.linalg.norm(np.diff(frames, n, axis=0), axis=2).max() for n in (1, 2))
        spin = float(np.abs(np.diff(heading)).max())
        loss = abs(turn.angle - final) / 3.0 + 2.0 * against
        loss += (0.15 if turn.calm else HASTE) * done
        loss += 30.0 * max(change / length - MOST_JERK_BL, 0.0)
        loss += 20.0 * max(way / length - MOST_STEP_BL, 0.0) + 0.5 * max(spin - MOST_SPIN_DEG, 0.0)
        if turn.calm:
            centre = np.einsum("n,tnx->tx", self.body.mass, frames) / self.body.mass.sum()
            push = np.linalg.norm(np.diff(centre, 2, axis=0), axis=1).max() / length
            loss += 2.0 * max(push / MOST_ACCELERATION_BL - 1.0, 0.0)
            loss += 0.1 * max(float(np.abs(bends).max()) - FOLDED_DEG, 0.0)
        if turn.entry == "swim":
            speed = float(np.linalg.norm(displacement(frames[-beat - 1 :]))) / (beat * self._pace)
            loss += 40.0 * max(loop_error(frames) / length - LOOP_BL, 0.0)
            loss += 8.0 * max(SPEEDS[0] - speed, speed - SPEEDS[1], 0.0)
        return float(loss)


def body_bend(frames: Floats) -> Floats:
    """Angle (T,) of the fore-body to the left of the rear, degrees, for nodes (T, 23, 3).

    The fore-body leads from the third ring to the nose, the rear from the tail to that ring.
    """
    middle = frames[:, 9:13].mean(axis=1)
    fore, rear = frames[:, 0] - middle, middle - frames[:, [UPPER_TAIL, LOWER_TAIL]].mean(axis=1)
    angle = np.arctan2(-fore[:, 2], fore[:, 0]) - np.arctan2(-rear[:, 2], rear[:, 0])
    return np.asarray(np.degrees(np.angle(np.exp(1j * angle))))


def ticks_to(heading: Floats, angle: float) -> int:
    """Ticks until the heading has changed by an angle, degrees; all of them if it never does."""
    return int(np.searchsorted(np.maximum.accumulate(heading), angle))


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
