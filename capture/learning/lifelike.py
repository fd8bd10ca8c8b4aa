"""The loss of a body and its gait against those of real fishes.

A lifelike gait has the tail amplitude, Strouhal number, stride and body wave of steadily swimming
fishes, and its grades differ by frequency rather than amplitude (Bainbridge 1958).

Fit the amplitudes of the grades, so that the tail beats about as far at each of them.
"""

from typing import NamedTuple

import msgspec
import numpy as np

from capture.inspection.gait import muscle_work, swim_beats
from capture.inspection.kinematics import published_envelope
from capture.inspection.targets import Range, at_least, at_most
from capture.learning.fitness import (
    DISTURBANCE,
    PENALTY,
    UNSOUND,
    beats_survived,
    excess,
    start_swimming,
)
from subsea.base.errors import UserError
from subsea.biomechanics.body import LOWER_TAIL, RINGS, UPPER_TAIL, Body, Floats, body_frame
from subsea.biomechanics.body_plan import MAX_CONTRACTION, SwimPlan
from subsea.biomechanics.controllers import LEFT, S_MAX, bend_contraction, ease
from subsea.biomechanics.fins import (
    MIN_DISTANCE,
    UP,
    contraction_step,
    headings,
    snout_bend,
    straightness,
)
from subsea.biomechanics.simulation import BodyState, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.biomechanics.trial import beat_contraction, displacement, loop_error

STATIONS = [[0], *([1 + 4 * k, 2 + 4 * k, 3 + 4 * k, 4 + 4 * k] for k in range(RINGS))]
STATIONS.append([UPPER_TAIL, LOWER_TAIL])
BEHIND = 0.4  # L from the snout: from here on the amplitude of a fish's wave grows
WARM_UP, MEASURED = 30, 5  # beats of a candidate at each grade
TRIED, HALF = ("burst", "slow"), 0.5
"""Grades of a candidate besides fast, those that differ most from it, and an amplitude of fast."""
RATIOS = (at_least(1.15), at_most(0.5), at_most(0.7))  # of their speeds over that of fast
POOR, OTHERS_MOST = 15.0, 10.0
"""Loss of a fast gait whose other grades are not tried, and the greatest of another grade."""

# Aims lie within the published ranges, because what is recorded differs a little from a trial.
LIMITS = {
    "strouhal": Range(0.26, 0.35),  # Taylor et al. 2003; Eloy 2012
    "stride": Range(0.62, 0.78),
    "tail": Range(0.18, 0.22),  # Bainbridge 1958
    "envelope": at_most(0.019),
    "growth": at_least(1.1),
    "bend": at_most(25.0),  # that of the envelope at a wavelength of 0.95 L and joints 0.15 L apart
    "wavelength": Range(0.9, 1.08),
    "snout": at_most(5.0),
    "contraction_step": at_most(S_MAX),
    "closure": at_most(1e-3),
    "drift": at_most(1.0),
    "aside": at_most(0.02),
}
RADIUS = at_most(1.0)  # L, of the circle of a body bent by PROBE
PROBE, PROBE_TICKS, PROBE_BEATS = (0.3, 0.3), 10, 4  # contraction, ticks to it, and beats
SLOWEST = at_least(0.2)  # stride of any grade
HARD = {"strouhal": Range(0.22, 0.42), "tail": Range(0.15, 0.25), "stride": at_least(0.45)}
ENVELOPE_WEIGHT = 20.0  # of the mean deviation in L
ECONOMY, HASTE = 0.05, 0.5  # of ln(cost), and of -ln(speed)


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
    snout: float  # degrees
    contraction_step: float  # cm a step
    closure: float  # L
    drift: float  # degrees of heading over the measured beats
    aside: float  # L meanwhile
    cost: float  # J/(kg m)


def measure_wave(body: Body, swim: SwimPlan, amplitude: float, state: BodyState) -> Wave:
    """Measure MEASURED more beats of ``state``, which changes."""
    beat, ticks = beat_contraction(swim, amplitude), swim.ticks_per_beat
    frames = swim_beats(body, state, beat, MEASURED)
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
        contraction_step=contraction_step(body, beat),
        closure=loop_error(last) / length,
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


def wave_loss(body: Body, swim: SwimPlan, seed: int) -> float:
    """Penalties of the gait at fast, and at the other grades, which must be sound and straight.

    ``seed`` disturbs the start. A body that loses its shape has UNSOUND or more. Gaits beyond
    POOR are not tried at other grades and pay what these can cost.
    """
    rng = np.random.default_rng(seed)
    others = [(swim.at(grade), swim.amplitude(grade)) for grade in TRIED]
    trials = [(swim, 1.0), *others, (swim, HALF)]
    loss, speed = 0.0, 0.0
    for number, (gear, amplitude) in enumerate(trials):
        wave, state, survived = swim_and_measure(body, gear, amplitude, DISTURBANCE, rng)
        if wave is None:
            return UNSOUND + len(trials) - number - survived
        if number == 0:
            speed = wave.stride / swim.ticks_per_beat
            loss = _fast_loss(wave) - HASTE * float(np.log(max(speed, 1e-4)))
            if loss > POOR:
                return min(loss + OTHERS_MOST * (len(trials) - 1), UNSOUND - 1.0)
        else:
            ratio = wave.stride / gear.ticks_per_beat / max(speed, 1e-6)
            loss += _other_loss(wave, ratio, RATIOS[number - 1])
    loss += PENALTY * excess(turning_radius(body, swim, state), RADIUS)
    return min(loss, UNSOUND - 1.0)


def turning_radius(body: Body, swim: SwimPlan, state: BodyState) -> float:
    """Radius in L of the circle of a body that is held bent by PROBE and beats at HALF.

    NaN where it loses its shape. ``state`` of a body that swims so, at phase 0, changes.
    """
    beat = beat_contraction(swim, HALF)
    steps = np.arange(PROBE_BEATS * len(beat))
    bend = bend_contraction(PROBE, LEFT, ease(steps / (PROBE_TICKS * STEPS_PER_TICK)))
    frames = simulate(body, state, np.tile(beat, (PROBE_BEATS, 1)) + bend)
    if not is_sound(state):
        return np.nan
    last = frames[-swim.ticks_per_beat - 1 :]
    heading = np.radians(headings(last))
    way = np.linalg.norm(displacement(last)) / float(np.ptp(body.rest[:, 0]))
    return float(way / max(heading[-1] - heading[0], 1e-3))


def swim_and_measure(
    body: Body, swim: SwimPlan, amplitude: float, rms: float, rng: np.random.Generator
) -> tuple[Wave | None, BodyState, float]:
    """Swim from a disturbed start; measures, final state, and share of beats in good shape.

    The measures are None for a body that lost its shape.
    """
    beat = beat_contraction(swim, amplitude)
    state = start_swimming(body, beat, rms, rng)
    beats = WARM_UP - 1
    survived = beats_survived(body, state, beat, beats) if is_sound(state) else 0
    if survived < beats:
        return None, state, survived / (beats + MEASURED)
    wave = measure_wave(body, swim, amplitude, state)
    if not is_sound(state):
        return None, state, beats / (beats + MEASURED)
    return wave, state, 1.0


def _fast_loss(wave: Wave) -> float:
    off = [excess(getattr(wave, name), limit) for name, limit in LIMITS.items()]
    hard = [excess(getattr(wave, name), limit) for name, limit in HARD.items()]
    if wave.stride < 0:
        hard.append(2.0)
    loss = PENALTY * (sum(off) + 2 * sum(hard)) + ENVELOPE_WEIGHT * wave.deviation
    return float(loss + ECONOMY * np.log(np.clip(wave.cost, 1e-3, 1e3)))


def _other_loss(wave: Wave, ratio: float, limit: Range) -> float:
    """Penalties of another grade: it swims straight, in a closed loop and at another speed.

    ``ratio`` is its speed over that of fast, with its ``limit``.
    """
    steady = {name: LIMITS[name] for name in ("drift", "aside", "closure", "snout")}
    loss = sum(excess(getattr(wave, name), limit) for name, limit in steady.items())
    loss += excess(wave.stride, SLOWEST) + excess(ratio, limit)
    return float(min(PENALTY / 2 * loss, OTHERS_MOST))


def missed_aims(wave: Wave) -> list[str]:
    """The aims that a gait misses, as text."""
    return [
        f"{name} {getattr(wave, name):.3g} (aim {limit.text('')})"
        for name, limit in LIMITS.items()
        if not limit.holds(getattr(wave, name))
    ]


TAIL = {"slow": 0.8, "medium": 0.9, "burst": 1.0}  # amplitude of the tail over that at fast
ROUNDS, NEAR = 5, 0.02  # of the fit, and share by which a grade may miss its amplitude


def with_amplitudes(body: Body, swim: SwimPlan) -> SwimPlan:
    """The plan with amplitudes that move the tail as TAIL says, within what muscles can do.

    UserError where the body loses its shape.
    """
    aim = _wave(body, swim, "fast").tail
    found = {}
    for grade in (grade for grade in swim.grades if grade != "fast"):
        most = _greatest(body, swim, grade)
        amplitude = min(swim.amplitude(grade), most)
        for _ in range(ROUNDS):
            gear = msgspec.structs.replace(swim, **{grade: amplitude})
            ratio = TAIL[grade] * aim / _wave(body, gear, grade).tail
            better = round(min(most, amplitude * float(np.clip(ratio, 0.5, 2.0))), 3)
            if abs(ratio - 1.0) <= NEAR or better == amplitude:
                break
            amplitude = better
        found[grade] = amplitude
    return msgspec.structs.replace(swim, **found)


def grade_waves(body: Body, swim: SwimPlan) -> dict[str, Wave]:
    """Measures of every grade; UserError where the body loses its shape."""
    return {grade: _wave(body, swim, grade) for grade in swim.grades}


def _wave(body: Body, swim: SwimPlan, grade: str) -> Wave:
    """Measures of a grade, swum from rest."""
    rng = np.random.default_rng(0)
    wave, _, _ = swim_and_measure(body, swim.at(grade), swim.amplitude(grade), 0.0, rng)
    if wave is None:
        raise UserError(f"it loses its shape at grade {grade}")
    return wave


def _greatest(body: Body, swim: SwimPlan, grade: str) -> float:
    """The greatest amplitude of a grade: by speed and share of contraction, and that of fast."""
    step = contraction_step(body, beat_contraction(swim.at(grade), 1.0))
    share = MAX_CONTRACTION / max(*swim.contraction, 1e-3)
    most = min(S_MAX / max(step, 1e-6), share, 1.0)
    return float(np.floor(1000 * most) / 1000)
