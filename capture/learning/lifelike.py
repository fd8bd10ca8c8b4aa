"""The loss of a body and its gait against those of real fishes.

A lifelike gait has the tail amplitude, Strouhal number, stride and body wave of steadily swimming
fishes. Its grades differ by frequency rather than amplitude (Bainbridge 1958): the tail beats about
as far at each of them.
"""

from typing import NamedTuple

import numpy as np

from capture.inspection.gait import muscle_work
from capture.inspection.kinematics import published_envelope
from capture.inspection.targets import Range, at_least, at_most
from capture.learning.fitness import (
    DISTURBANCE,
    PENALTY,
    UNSOUND,
    excess,
    starting,
    surviving,
)
from subsea.base.errors import UserError
from subsea.biomechanics.body import (
    LOWER_TAIL,
    MUSCLE_LEFT,
    RINGS,
    UPPER_TAIL,
    Body,
    Floats,
    body_frame,
)
from subsea.biomechanics.body_plan import SwimPlan
from subsea.biomechanics.controllers import LEFT, S_MAX, bend_contraction, ease
from subsea.biomechanics.fins import (
    MIN_DISTANCE,
    UP,
    contraction_step,
    headings,
    rolling,
    snout_bend,
    straightness,
)
from subsea.biomechanics.simulation import BodyState, at_rest, copy_state, is_sound
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.biomechanics.together import Bout, Course, swim_course
from subsea.biomechanics.trial import beat_contraction, displacement, loop_error

STATIONS = [[0], *([1 + 4 * k, 2 + 4 * k, 3 + 4 * k, 4 + 4 * k] for k in range(RINGS))]
STATIONS.append([UPPER_TAIL, LOWER_TAIL])
BEHIND = 0.4  # L from the snout: from here on the amplitude of a fish's wave grows
WARM_UP, MEASURED = 40, 5  # beats of a candidate at each grade
POOR = 20.0  # loss of a fast gait that is far from a fish's

# Aims lie within the published ranges, because what is recorded differs a little from a trial.
EVERY = {
    "snout_over_tail": Range(0.09, 0.22),
    "wavelength": Range(0.9, 1.2),
    "yaw": at_most(8.0),
    "roll": at_most(1.7),
    "snout": at_most(4.0),
    "growth": at_least(1.0),
    "bend": at_most(25.0),  # that of the envelope at a wavelength of 0.95 L and joints 0.15 L apart
    "contraction_step": at_most(S_MAX),
    "closure": at_most(1e-3),
    "settled": at_least(5.0),
    "drift": at_most(1.0),
    "aside": at_most(0.02),
}
LIMITS = {  # Taylor et al. 2003; Eloy 2012; Bainbridge 1958: slower fishes beat less wide
    "fast": EVERY
    | {
        "strouhal": Range(0.26, 0.35),
        "stride": Range(0.6, 0.78),
        "tail": Range(0.17, 0.22),
        "envelope": at_most(0.019),
        "growth": at_least(1.1),
        "wavelength": Range(0.9, 1.08),
    },
    "medium": EVERY
    | {"strouhal": Range(0.25, 0.36), "stride": Range(0.45, 0.66), "tail": Range(0.14, 0.19)},
    "slow": EVERY
    | {"strouhal": Range(0.25, 0.37), "stride": Range(0.35, 0.56), "tail": Range(0.1, 0.16)},
    "burst": EVERY | {"strouhal": Range(0.22, 0.4), "tail": Range(0.12, 0.23)},
}
RATIOS = {"medium": Range(0.62, 0.72), "slow": Range(0.38, 0.52), "burst": at_least(1.12)}
"""Speeds over that of fast."""
TURN = at_least(20.0)  # degrees, of a body that bends by BEND from rest and straightens
BEND, BEND_TICKS = 0.35, (10.0, 4.0, 12.0, 14.0)  # contraction; ticks to bend, hold, release, rest
RADIUS = at_most(1.0)  # L, of the circle of a body bent by PROBE
PROBE, PROBE_TICKS, PROBE_BEATS = (0.3, 0.3), 10, 4  # contraction, ticks to it, and beats
HARD = {"strouhal": Range(0.22, 0.42), "tail": Range(0.15, 0.25), "stride": at_least(0.45)}
ENVELOPE_WEIGHT = 20.0  # of the mean deviation in L, of fast
ECONOMY, HASTE = 0.05, 0.5  # of ln(cost), and of -ln(speed), of fast


class Wave(NamedTuple):
    """Measures of a steady gait; L is the body length."""

    strouhal: float
    stride: float  # L/beat
    tail: float  # L, peak to peak
    envelope: float  # L, greatest deviation of the half amplitude from the published one
    deviation: float  # L, its mean size
    growth: float  # least ratio of the half amplitudes of neighbouring stations behind BEHIND
    bend: float  # degrees, greatest angle between neighbouring sections behind BEHIND
    wavelength: float  # L
    snout: float  # degrees, bend of the snout alone
    snout_over_tail: float  # ratio of their amplitudes
    yaw: float  # degrees, peak to peak, of the head
    roll: float  # degrees, to one side
    contraction_step: float  # cm a step
    closure: float  # L
    settled: float  # -log10 of closure / L, which grows beat by beat where a gait is stable
    drift: float  # degrees of heading over the measured beats
    aside: float  # L meanwhile
    cost: float  # J/(kg m)


def measuring(body: Body, swim: SwimPlan, amplitude: float, state: BodyState) -> Course[Wave]:
    """Measure MEASURED more beats of ``state``, which changes."""
    beat, ticks = beat_contraction(swim, amplitude), swim.ticks_per_beat
    start = state.x[None].copy()
    frames = np.concatenate([start, (yield Bout(body, state, np.tile(beat, (MEASURED, 1))))])
    last = frames[-ticks - 1 :]
    length = float(np.ptp(body.rest[:, 0]))
    at = np.array([body.rest[0, 0] - body.rest[nodes, 0].mean() for nodes in STATIONS]) / length
    chord = displacement(last)
    way = float(chord @ body_frame(last)[1][:, :, 0].mean(axis=0))
    way = float(np.copysign(max(abs(way), MIN_DISTANCE), way))
    across = lateral(last) / length
    half = np.ptp(across, axis=0) / 2
    off = np.abs(half - published_envelope("carangiform", at))
    drift, aside = straightness(frames, ticks)
    work = muscle_work(body, copy_state(state), beat)
    return Wave(
        strouhal=2 * half[-1] * length / abs(way),
        stride=way / length,
        tail=2 * half[-1],
        envelope=off.max(),
        deviation=off.mean(),
        growth=(half[1:] / np.maximum(half[:-1], 1e-6))[at[:-1] >= BEHIND].min(),
        bend=rear_bend(last, at),
        wavelength=wavelength(across, at),
        snout=snout_bend(last),
        snout_over_tail=half[0] / max(half[-1], 1e-6),
        yaw=float(np.ptp(headings(last))),
        roll=rolling(last),
        contraction_step=contraction_step(body, beat),
        closure=loop_error(last) / length,
        settled=-float(np.log10(max(loop_error(last) / length, 1e-12))),
        drift=drift,
        aside=aside / length,
        cost=work / (float(body.mass.sum()) * abs(way)),
    )


def lateral(beat: Floats) -> Floats:
    """Place of nose, rings and tail (T, 7) across the path of one beat (T + 1, 23, 3), cm."""
    chord = displacement(beat)
    aside = np.cross(UP, chord / max(float(np.linalg.norm(chord)), MIN_DISTANCE))
    across = np.stack([beat[:, nodes].mean(axis=1) @ aside for nodes in STATIONS], axis=1)
    drift = np.linspace(0.0, across[-1] - across[0], len(across))
    return np.asarray((across - drift)[1:])


def rear_bend(beat: Floats, at: Floats) -> float:
    """Greatest angle between neighbouring sections that meet behind BEHIND, degrees."""
    middles = np.stack([beat[:, nodes].mean(axis=1) for nodes in STATIONS], axis=1)
    sections = np.diff(middles, axis=1)
    a, b = sections[:, :-1], sections[:, 1:]
    sine = np.linalg.norm(np.cross(a, b), axis=2)
    angles = np.degrees(np.arctan2(sine, (a * b).sum(axis=2)))
    return float(angles[:, at[1:-1] >= BEHIND].max())


def wavelength(across: Floats, at: Floats) -> float:
    """Length of the body wave, L: from the phases of the beat at stations ``at``, by amplitude.

    ``across`` (T, 7) is their lateral place in one beat. Infinite for a standing wave. As in
    `capture.inspection.kinematics.travelling_wave`, so that validation finds the same.
    """
    beat = np.fft.rfft(across, axis=0)[1]
    slope = float(np.polyfit(at, np.unwrap(np.angle(beat)), 1, w=np.abs(beat))[0])
    return 2 * np.pi / -slope if slope < 0 else np.inf


def wave_loss(
    body: Body, swim: SwimPlan, grade: str, seed: int, fast: float | None = None
) -> float:
    """Penalties of the gait of a grade, also for its speed over that of grade fast.

    ``fast`` is that speed in L a tick, None at grade fast itself. ``seed`` disturbs the start. A
    body that loses its shape has UNSOUND or more.
    """
    return swim_course(wave_course(body, swim, grade, seed, fast))


def wave_course(
    body: Body, swim: SwimPlan, grade: str, seed: int, fast: float | None = None
) -> Course[float]:
    """As `wave_loss`, as a course."""
    gait, rng = swim.at(grade), np.random.default_rng(seed)
    wave, state, survived = yield from swimming(body, gait, 1.0, DISTURBANCE, rng)
    if wave is None:
        return UNSOUND + 1.0 - survived
    missed = _missed(wave, LIMITS[grade])
    speed = wave.stride / gait.ticks_per_beat
    if fast is not None:
        loss = PENALTY * (missed + 2 * excess(speed / fast, RATIOS[grade]))
        if grade == "medium":
            loss += PENALTY * excess((yield from turning_radius(body, gait, state)), RADIUS)
    else:
        missed += 2 * _missed(wave, HARD) + 4.0 * (wave.stride < 0)
        missed += excess((yield from bent_turn(body)), TURN)
        loss = PENALTY * missed + ENVELOPE_WEIGHT * wave.deviation
        loss += ECONOMY * float(np.log(np.clip(wave.cost, 1e-3, 1e3)))
        loss -= HASTE * float(np.log(max(speed, 1e-4)))
    return float(min(loss, UNSOUND - 1.0))


def _missed(wave: Wave, limits: dict[str, Range]) -> float:
    return sum(excess(getattr(wave, name), limit) for name, limit in limits.items())


def bent_turn(body: Body) -> Course[float]:
    """Degrees by which a body at rest turns that bends to one side and straightens again.

    NaN where it loses its shape.
    """
    bend, hold, release, _ = BEND_TICKS
    at = np.arange(int(sum(BEND_TICKS)) * STEPS_PER_TICK) / STEPS_PER_TICK
    share = ease(at / bend) - ease((at - bend - hold) / release)
    state = at_rest(body)
    frames = yield Bout(body, state, BEND * np.outer(share, MUSCLE_LEFT > 0))
    heading = headings(frames)
    return float(heading[-1] - heading[0]) if is_sound(state) else np.nan


def turning_radius(body: Body, swim: SwimPlan, state: BodyState) -> Course[float]:
    """Radius in L of the circle of a body that is held bent by PROBE and beats on.

    NaN where it loses its shape. ``state`` of a body that swims so, at phase 0, changes.
    """
    beat = beat_contraction(swim, 1.0)
    steps = np.arange(PROBE_BEATS * len(beat))
    bend = bend_contraction(PROBE, LEFT, ease(steps / (PROBE_TICKS * STEPS_PER_TICK)))
    frames = yield Bout(body, state, np.tile(beat, (PROBE_BEATS, 1)) + bend)
    if not is_sound(state):
        return np.nan
    last = frames[-swim.ticks_per_beat - 1 :]
    heading = np.radians(headings(last))
    way = np.linalg.norm(displacement(last)) / float(np.ptp(body.rest[:, 0]))
    return float(way / max(heading[-1] - heading[0], 1e-3))


def swimming(
    body: Body, swim: SwimPlan, amplitude: float, rms: float, rng: np.random.Generator
) -> Course[tuple[Wave | None, BodyState, float]]:
    """Swim from a disturbed start; measures, final state, and share of beats in good shape.

    The measures are None for a body that lost its shape.
    """
    beat = beat_contraction(swim, amplitude)
    state = yield from starting(body, beat, rms, rng)
    beats, survived = WARM_UP - 1, 0
    if is_sound(state):
        survived = yield from surviving(body, state, beat, beats)
    if survived == beats:
        wave = yield from measuring(body, swim, amplitude, state)
        if is_sound(state):
            return wave, state, 1.0
    return None, state, survived / (beats + MEASURED)


def missed_aims(waves: dict[str, Wave]) -> list[str]:
    """The aims that the gaits of the grades miss, as text."""
    return [
        f"{grade}: {name} {getattr(wave, name):.3g} (aim {limit.text('')})"
        for grade, wave in waves.items()
        for name, limit in LIMITS[grade].items()
        if not limit.holds(getattr(wave, name))
    ]


def grade_waves(body: Body, swim: SwimPlan) -> dict[str, Wave]:
    """Measures of every grade; UserError where the body loses its shape."""
    return {grade: _wave(body, swim, grade) for grade in swim.grades}


def _wave(body: Body, swim: SwimPlan, grade: str) -> Wave:
    """Measures of a grade, swum from rest."""
    rng = np.random.default_rng(0)
    course = swimming(body, swim.at(grade), swim.amplitude(grade), 0.0, rng)
    wave, _, _ = swim_course(course)
    if wave is None:
        raise UserError(f"it loses its shape at grade {grade}")
    return wave
