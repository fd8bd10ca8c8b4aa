"""Wave, beat and path of recorded motion, as biologists measure them.

Lengths in body lengths L unless stated; a cycle is a whole number of beats.
"""

from typing import NamedTuple

import numpy as np

from capture.inspection.simulated import replay
from capture.inspection.top_view import above, lateral_offset, midline, path_direction
from subsea.base.arrays import Array
from subsea.biomechanics.body import Floats, body_frame, to_world
from subsea.biomechanics.fins import headings, rolling, snout_bend
from subsea.biomechanics.manoeuvres import BENT_DEG, MOST_DONE, body_bend, ticks_to
from subsea.fish.surface import V
from subsea.repertoire import Repertoire, Segment

FINER = 16  # times as many samples, by a Fourier series, for exact extremes


class BodyWave(NamedTuple):
    """The lateral motion of a body in steady swimming."""

    stations: Floats  # (m,) behind the snout
    envelope: Floats  # (m,) half amplitude
    wavelength: float
    frequency: float  # Hz of the recorded fish
    amplitude: float  # peak to peak, of the last station


def published_envelope(wave: str, at: Array) -> Floats:
    """Half amplitude of the published wave of a kind at stations (m,).

    Carangiform: Borazjani and Sotiropoulos (2008). Anguilliform: 0.1 exp(α (x - 1)) with the middle
    of α, 1 to 2.
    """
    if wave == "anguilliform":
        return np.asarray(0.1 * np.exp(1.5 * (at - 1.0)))
    return np.asarray(0.02 - 0.08 * at + 0.16 * at**2)


def published_limits(wave: str, at: Array) -> tuple[Floats, Floats]:
    """Lowest and highest published half amplitudes at stations (m,); they differ for eels."""
    if wave == "anguilliform":
        return np.asarray(0.1 * np.exp(2.0 * (at - 1.0))), np.asarray(0.1 * np.exp(at - 1.0))
    middle = published_envelope(wave, at)
    return middle, middle


def envelope_deviation(wave: str, found: BodyWave) -> tuple[float, float]:
    """Greatest distance of an envelope from the published one, and its station."""
    low, high = published_limits(wave, found.stations)
    off = np.maximum(np.maximum(low - found.envelope, found.envelope - high), 0.0)
    worst = int(off.argmax())
    return float(off[worst]), float(found.stations[worst])


def body_wave(segment: Segment, repertoire: Repertoire) -> BodyWave:
    """The wave of a cyclic segment: of its midline, or of the back of a spine-driven fish.

    Few nodes of a spine-driven fish follow its wave.
    """
    length = repertoire.body_length_cm
    if repertoire.source == "spine" and segment.control_points is not None:
        back = segment.control_points[:, :V] / length
        steps = np.linalg.norm(np.diff(back, axis=1), axis=2).mean(axis=0)
        way = np.concatenate([[0.0], np.cumsum(steps)])
        origin, rotation = body_frame(replay(segment, np.zeros(3), np.eye(3), 1))
        played = above(to_world(back, origin / length, rotation)) / path_direction(segment)
        aside = np.asarray(-played.imag)
        return travelling_wave(aside, way / way[-1], repertoire.tick_s)
    rest = midline(repertoire.rest_nodes)[:, 0]
    stations = (rest[0] - rest) / length
    return travelling_wave(lateral_offset(segment) / length, stations, repertoire.tick_s)


def travelling_wave(lateral: Floats, stations: Floats, tick_s: float) -> BodyWave:
    """The wave of lateral offsets (t, m) over one cycle, sampled every tick at stations (m,).

    The beat is the strongest harmonic of the last station; the wavelength follows from the phase of
    that harmonic along the body, weighted by amplitude.
    """
    ticks = len(lateral)
    series = np.fft.rfft(lateral - lateral.mean(axis=0), axis=0)
    harmonic = 1 + int(np.abs(series[1:, -1]).argmax())
    beat = series[harmonic]
    phase = np.unwrap(np.angle(beat))
    weight = np.abs(beat)
    slope = np.polyfit(stations, phase, 1, w=weight)[0]
    fine = np.fft.irfft(series, FINER * ticks, axis=0) * FINER
    half = 0.5 * np.ptp(fine, axis=0)
    return BodyWave(
        stations=stations,
        envelope=np.asarray(half),
        wavelength=float(2 * np.pi / max(abs(slope), 1e-9)),
        frequency=harmonic / (ticks * tick_s),
        amplitude=float(2 * half[-1]),
    )


class Posture(NamedTuple):
    """Measures of the body in a steady swim, beside its wave."""

    snout_over_tail: float  # ratio of their amplitudes
    yaw: float  # degrees, peak to peak, of the head
    snout: float  # degrees, bend of the snout alone
    roll: float  # degrees to one side


def posture(segment: Segment, wave: BodyWave) -> Posture:
    """The posture of a cyclic segment, whose `wave` is known."""
    frames = replay(segment, np.zeros(3), np.eye(3), 2)[-len(segment.nodes) - 1 :]
    heading = headings(frames)
    heading = heading - np.linspace(0.0, heading[-1] - heading[0], len(heading))
    return Posture(
        snout_over_tail=float(wave.envelope[0] / max(wave.envelope[-1], 1e-9)),
        yaw=float(np.ptp(heading)),
        snout=snout_bend(frames),
        roll=rolling(frames),
    )


class Turning(NamedTuple):
    """Measures of the body in a turn."""

    net: float  # degrees, of the course over the last beat, or of a whole cycle
    into: float  # share of the bent ticks whose bend is into the turn; NaN if it is never bent
    acceleration: float  # the greatest, of the middle of the body, L/tick²
    aside: float  # the greatest speed across the body, L/tick


def turning(segment: Segment, length: float, left: bool, beat: int) -> Turning:
    """The motion of a turn to the left or right, with beats of `beat` ticks after it."""
    frames = replay(segment, np.zeros(3), np.eye(3), 2 if segment.cyclic else 1)
    side = 1.0 if left else -1.0
    heading = side * headings(frames)
    net = abs(segment.turn_deg) if segment.cyclic else float(heading[-beat:].mean())
    bend = side * body_bend(frames)
    done = len(frames) if segment.cyclic else ticks_to(heading, MOST_DONE * net)
    bent = bend[: done + 3]
    bent = bent[np.abs(bent) > BENT_DEG]
    middle = frames.mean(axis=1) / length
    velocity = np.diff(middle, axis=0)
    across = body_frame(frames[:-1])[1][..., 2]
    return Turning(
        net=net,
        into=float((bent > 0).mean()) if len(bent) else float("nan"),
        acceleration=float(np.linalg.norm(np.diff(velocity, axis=0), axis=1).max()),
        aside=float(np.abs((velocity * across).sum(axis=1)).max()),
    )


def wing_amplitude(segment: Segment, length: float) -> float:
    """Vertical sweep of the wing's tip, peak to peak; NaN for a segment without control points."""
    points = segment.control_points
    if points is None:
        return float("nan")
    tip = int(np.abs(points[0, :, 2]).argmax())
    return float(np.ptp(points[:, tip, 1]) / length)


def turn_path(segment: Segment) -> tuple[Floats, Floats]:
    """Middle of the body (t, 2), cm, and heading (t,), rad, of a segment from above.

    Of a cycle the middle of two cycles, so that the beat does not count as a turn.
    """
    frames = replay(segment, np.zeros(3), np.eye(3), 2 if segment.cyclic else 1)
    middle = above(frames).mean(axis=-1)
    forward = body_frame(frames)[1][..., 0]
    heading = np.unwrap(np.angle(above(forward)))
    if segment.cyclic:
        half = len(frames) // 2
        middle, heading = middle[half - 1 :: half], heading[half - 1 :: half]
    return np.stack([middle.real, middle.imag], axis=-1), np.asarray(heading)


def path_radius(middle: Floats, heading: Floats) -> float:
    """Radius of a turn, in the unit of `middle` (t, 2): arc length over change of heading (t,).

    Taken between one and nine tenths of the change; NaN for a path that does not turn.
    """
    change = heading - heading[0]
    whole = change[-1]
    if abs(whole) < 1e-6:
        return float("nan")
    share = np.maximum.accumulate(change / whole)
    first, last = np.searchsorted(share, [0.1, 0.9])
    if len(share) == 2:
        first, last = 0, 1
    last = max(last, first + 1)
    arc = np.linalg.norm(np.diff(middle[first : last + 1], axis=0), axis=1).sum()
    if len(share) == 2:  # the chord of one cycle
        half = 0.5 * abs(whole)
        arc *= half / np.sin(half)
    return float(arc / abs(heading[last] - heading[first]))


def turning_radius(segment: Segment, length: float) -> float:
    """Radius of the path of a turn."""
    return path_radius(*turn_path(segment)) / length


def escape(segment: Segment, tick_s: float) -> float:
    """Duration, s, of the first bend of a C-start: until the head has turned nine tenths."""
    frames = replay(segment, np.zeros(3), np.eye(3), 1)
    head = above(frames[:, 0] - frames[:, 5:9].mean(axis=1))
    angle = np.abs(np.degrees(np.unwrap(np.angle(head))))  # it began along the x axis
    return (1 + ticks_to(angle, (MOST_DONE - 1e-9) * float(angle.max()))) * tick_s
