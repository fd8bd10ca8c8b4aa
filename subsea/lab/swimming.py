"""Swimming as realised in a sea: Strouhal number, speeds, pitch and turns of each species.

The path of the tail stands for the beat, the origin of the body for the path of the fish. Samples
are stretches one after another, long enough for the beats of a species.
"""

from collections.abc import Callable, Collection
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bools, Ints
from subsea.lab.measures import headings, runs
from subsea.media.record import Record
from subsea.repertoire.schema import FAMILIES
from subsea.state import EAT, ESCAPE, PREDATOR

BEATS_S = 1.0, 2.0, 4.0, 8.0  # stretches in which a beat is measured: the first long enough
BEATS = 3.0  # of the median stretch that is long enough
LEAST_BEATS = 1.5  # of a stretch: a slower swing looks like the curve of the path
SHORT_S = 0.5  # stretch in which a speed is measured
TURN_S = 1.0  # stretch in which a turn is measured
LEAST_AMPLITUDE = 0.03  # body lengths, peak to peak: below, the tail does not beat
LEAST_SPEED = 0.1  # body lengths a second, for a stride
STRAIGHT_DEG = 15.0  # greatest change of heading while a beat is measured
PITCHED_DEG = 25.0
TURNING_DEG_S = 5.0  # slower changes of heading are recoil
TIGHT_DEG = 20.0  # least change of heading in TURN_S that counts as a turn
LOW_SPEED = 1.5  # body lengths a second: turns below are turns at low speed
HOVER_SPEED = 0.2  # body lengths a second
ROLL_S = 0.5  # stretch in which roll and acceleration are measured
BENT_DEG = 30.0  # angle of the head to the line from the tail, beyond that of a beat
BEND_S = 0.4  # over which a rate of turning is measured beside a bend
BENDING_DEG_S = 60.0  # least rate of a turn in which the bend counts
STEPS = 8  # frequencies of a spectrum for each beat in a stretch
TREND = 3  # coefficients of a curved path: a parabola

Counts = tuple[float, float]  # of something, out of all
Beats = tuple[Array, Array, Array, Array, Array, Array]
"""Strouhal numbers, frequencies, amplitudes, strides, ratios of snout and tail, yaws (k,)."""


class Swimming(NamedTuple):
    """Samples of one species (k,); lengths in body lengths, speeds in lengths a second."""

    strouhal: Array
    frequency: Array  # Hz
    amplitude: Array  # peak to peak
    stride: Array
    snout_over_tail: Array  # ratio of their amplitudes
    yaw: Array  # degrees, peak to peak, of the head with the beat
    speed: Array  # over SHORT_S
    hasty: Array  # speeds of stretches in which a fish flees, or hunts as a predator
    radius: Array  # of turns at low speed
    roll: Array  # degrees to one side of its mean, the greatest in stretches of straight swims
    acceleration: Array  # of the centre of mass, without flights: the greatest in a stretch
    into: Counts  # ticks bent into the turn, of those with a bent body in a turn
    pitched: Counts  # ticks steeper than PITCHED_DEG, of those that do not row
    straight: Counts  # change of heading in straight segments, rad
    idle: Counts  # stretches below the slowest stroke, without those that row or coast
    hovering: Counts  # stretches slower than HOVER_SPEED
    longest_hover_s: float


def swimming(record: Record, slowest: Array) -> dict[str, Swimming]:
    """Measure each species of a record; `slowest` (n,) is the speed of a fish's slowest stroke."""
    found = {}
    for k, name in enumerate(record.species_names):
        those = np.flatnonzero(record.species == k)
        if len(those):
            found[name] = _species(record, those, slowest[those])
    return found


def _species(record: Record, those: Ints, slowest: Array) -> Swimming:
    length = record.length[those].astype(np.float64)
    alive = record.alive[:, those]
    place = record.position[:, those].astype(np.float64) / length[:, None]
    forward = headings(record.orientation[:, those])
    course = np.unwrap(np.arctan2(forward[..., 1], forward[..., 0]), axis=0)
    tail = record.tail[:, those].astype(np.float64) / length[:, None]
    straight = [name for name in record.segment_names if name.startswith("swim")]
    swims = alive & _plays(record, {*straight} - {"swim_coast"})[:, those]
    nose = record.snout[:, those].astype(np.float64) / length[:, None]
    paths = Paths(tail[..., :2], place[..., :2], nose[..., :2], course)
    beat = _beats(paths, swims, record.tick_s)
    centre = record.centre[:, those].astype(np.float64) / length[:, None]
    doing, predator = record.intention[:, those], record.kind[those] == PREDATOR
    hurried = (doing == ESCAPE) | ((doing == EAT) & predator)
    escapes = [name for name in record.segment_names if name.startswith("cstart")]
    calm = alive & ~hurried & ~_plays(record, escapes)[:, those]
    rows = _plays(record, ["row_forward", *FAMILIES["row_forward"]])[:, those]
    still = rows | _plays(record, ["swim_coast", *FAMILIES["swim_coast"]])[:, those]
    speed, short = _speeds(place, alive, record.tick_s)
    every = _ticks(SHORT_S, record.tick_s)
    strokes = short & ~still[every // 2 :: every][: len(short)]
    hasty = short & hurried[every // 2 :: every][: len(short)]
    hover = short & (speed < HOVER_SPEED)
    steep = np.abs(np.degrees(np.arcsin(np.clip(forward[..., 2], -1.0, 1.0)))) > PITCHED_DEG
    return Swimming(
        *beat,
        speed=speed[short],
        hasty=speed[hasty],
        radius=_radii(place, course, alive, record.tick_s),
        roll=_rolls(record.orientation[:, those], swims, record.tick_s),
        acceleration=_accelerations(centre, calm, record.tick_s),
        into=_into(tail - place, forward, course, calm, record.tick_s),
        pitched=(float((steep & alive & ~rows).sum()), float((alive & ~rows).sum())),
        straight=_straight(record, course, alive, those),
        idle=(float((strokes & (speed < slowest)).sum()), float(strokes.sum())),
        hovering=(float(hover.sum()), float(short.sum())),
        longest_hover_s=SHORT_S * max(
            (end - start for i in range(len(those)) for start, end in runs(hover[:, i])), default=0
        ),
    )  # fmt: skip


def _plays(record: Record, names: Collection[str]) -> Bools:
    """Flag (T, n) where a fish swims by one of these segments."""
    return np.array([name in names for name in record.segment_names])[record.segment]


def _ticks(seconds: float, tick_s: float) -> int:
    return max(round(seconds / tick_s), 2)


def _stretches(values: NDArray[Any], ticks: int) -> NDArray[Any]:
    """Cut values (T, …) into stretches (k, ticks, …) one after another."""
    number = len(values) // ticks
    return values[: number * ticks].reshape(number, ticks, *values.shape[1:])


class Paths(NamedTuple):
    """Paths of fishes from above (T, n, 2), body lengths, and their headings."""

    tail: Array
    origin: Array  # of the body
    nose: Array
    course: Array  # (T, n) rad

    def stretches(self, ticks: int) -> "Paths":
        """Cut them into stretches (k, ticks, …) one after another."""
        return Paths(*(_stretches(values, ticks) for values in self))


def _beats(paths: Paths, alive: Bools, tick_s: float) -> Beats:
    """Measure the beats of a species, in the shortest stretches that hold `BEATS` of them.

    `alive` (T, n) is true where a fish swims with its tail.
    """
    found: Beats = (np.zeros(0),) * 6
    for seconds in BEATS_S:
        ticks = _ticks(seconds, tick_s)
        longer = _beats_in(paths, alive, tick_s, ticks)
        if len(longer[0]):
            found = longer
            if np.median(found[1]) * seconds >= BEATS:
                break
    return found


def _beats_in(paths: Paths, alive: Bools, tick_s: float, ticks: int) -> Beats:
    """Measure the beats in stretches that go straight.

    The beat is that of the tail beside the body, so that a bent course does not count as one. Its
    amplitude is that of the tail's path at this frequency: the course wanders more slowly.
    """
    if len(alive) < ticks:
        return (np.zeros(0),) * 6
    there, cut = _stretches(alive, ticks).all(axis=1), paths.stretches(ticks)
    turned = np.abs(np.diff(cut.course[:, [0, -1]], axis=1))[:, 0]
    steady = there & (turned < np.radians(STRAIGHT_DEG))
    middle = cut.course.mean(axis=1, keepdims=True)

    def aside(path: Array) -> Array:
        """Path (m, ticks) across the mean course: recoil must not count as a beat of its own."""
        across = path[..., 1] * np.cos(middle) - path[..., 0] * np.sin(middle)
        return np.asarray(across.swapaxes(1, 2)[steady])

    frequency = beat_of(aside(cut.tail - cut.origin), tick_s)[0]
    tail, nose, yaw = (
        amplitude_at(path, frequency, tick_s)
        for path in (aside(cut.tail), aside(cut.nose), cut.course.swapaxes(1, 2)[steady])
    )
    way = np.diff(cut.origin[:, [0, -1]], axis=1)[:, 0]
    speed = np.linalg.norm(way, axis=-1)[steady] / ((ticks - 1) * tick_s)
    beats = (tail >= LEAST_AMPLITUDE) & (speed > LEAST_SPEED)
    beats &= frequency * ticks * tick_s >= LEAST_BEATS
    f, a, u, head, sway = (v[beats] for v in (frequency, tail, speed, nose, yaw))
    return f * a / u, f, a, u / f, head / a, np.degrees(sway)


def amplitude_at(aside: Array, frequency: Array, tick_s: float) -> Array:
    """Measure the peak-to-peak amplitude (m,) of the sine at given frequencies, beside a parabola.

    The sine (m,) is the one that fits lateral paths (m, t) best.
    """
    ticks = aside.shape[-1]
    trend = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, ticks), TREND))[0]
    phase = 2 * np.pi * tick_s * np.arange(ticks) * frequency[:, None]
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=-1)  # (m, t, 2)
    free = waves - trend @ (trend.T @ waves)
    rest = aside - (aside @ trend) @ trend.T
    parts = np.linalg.pinv(free) @ rest[..., None]
    return np.asarray(2.0 * np.linalg.norm(parts[..., 0], axis=-1))


def beat_of(aside: Array, tick_s: float) -> tuple[Array, Array]:
    """Measure frequency, Hz, and peak-to-peak amplitude of lateral paths (m, t) of a beat or more.

    The frequency is that of the sine that fits best together with a parabola, the curved path of a
    turn: a parabola that is taken off first also takes a part of a slow beat.
    """
    ticks = aside.shape[-1]
    step = 1.0 / (STEPS * ticks * tick_s)
    frequencies = np.arange(STEPS, STEPS * ticks // 2) * step  # from a beat to Nyquist's
    trend = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, ticks), TREND))[0]
    phase = 2 * np.pi * tick_s * np.arange(ticks) * frequencies[:, None]
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=-1)  # (f, t, 2)
    waves = np.linalg.qr(waves - trend @ (trend.T @ waves))[0]
    rest = aside - (aside @ trend) @ trend.T
    power = sum((rest @ waves[..., k].T) ** 2 for k in (0, 1))
    peak = power[:, 1:-1].argmax(axis=-1) + 1
    row = np.arange(len(power))
    before, at, after = (power[row, peak + k] for k in (-1, 0, 1))
    curve = np.minimum(before - 2 * at + after, -1e-30)
    shift = np.clip(0.5 * (before - after) / curve, -0.5, 0.5)
    frequency = frequencies[peak] + shift * step
    return frequency, amplitude_at(aside, frequency, tick_s)


def _rolls(orientation: Array, alive: Bools, tick_s: float) -> Array:
    """Measure the greatest roll (k,) beside its mean in stretches of ROLL_S, degrees.

    `orientation` (T, n, 4) are unit quaternions.
    """
    _, x, y, _ = np.moveaxis(orientation.astype(np.float64), -1, 0)
    right = 1.0 - 2.0 * (x**2 + y**2)  # height of the fish's right side
    aside = np.degrees(np.arcsin(np.clip(right, -1.0, 1.0)))
    return _greatest(lambda part: 0.5 * np.ptp(part, axis=1), aside, alive, _ticks(ROLL_S, tick_s))


def _accelerations(centre: Array, calm: Bools, tick_s: float) -> Array:
    """Measure the greatest acceleration (k,) in stretches of ROLL_S, body lengths a second²."""
    pull = np.linalg.norm(np.diff(centre, 2, axis=0), axis=-1) / tick_s**2
    return _greatest(lambda part: part.max(axis=1), pull, calm[1:-1], _ticks(ROLL_S, tick_s))


def _greatest(measure: Callable[[Array], Array], values: Array, there: Bools, ticks: int) -> Array:
    """A measure of each stretch of `values` (T, n) in which a fish is `there` all the time."""
    whole = _stretches(there, ticks).all(axis=1)
    return np.asarray(measure(_stretches(values, ticks))[whole])


def _into(behind: Array, forward: Array, course: Array, calm: Bools, tick_s: float) -> Counts:
    """Count ticks with a bent body in a turn, and of these those bent into the turn.

    `behind` (T, n, 3) leads from the origin of the body to its tail. The head of a body that bends
    to the left points to the left of the line from its tail.
    """
    line, ahead = -(behind[..., 0] + 1j * behind[..., 1]), forward[..., 0] + 1j * forward[..., 1]
    bend = np.degrees(np.angle(ahead * np.conj(line)))
    half = _ticks(BEND_S, tick_s) // 2
    rate = np.zeros_like(course)
    rate[half:-half] = np.degrees(course[2 * half :] - course[: -2 * half]) / (2 * half * tick_s)
    bent = calm & (np.abs(bend) > BENT_DEG) & (np.abs(rate) > BENDING_DEG_S)
    return float((bent & (bend * rate > 0.0)).sum()), float(bent.sum())


def _speeds(place: Array, alive: Bools, tick_s: float) -> tuple[Array, Bools]:
    """Measure speeds (k, n) over stretches of SHORT_S, and flag living fishes."""
    ticks = _ticks(SHORT_S, tick_s)
    ends = place[::ticks]
    speed = np.linalg.norm(np.diff(ends, axis=0), axis=-1) / (ticks * tick_s)
    return speed, alive[::ticks][1:]


def _radii(place: Array, course: Array, alive: Bools, tick_s: float) -> Array:
    """Measure the radius of each turn at low speed, where its path is most curved.

    Published radii are those of single turns. In a turn the heading changes by at least
    `TIGHT_DEG` in the `TURN_S` around each tick.
    """
    half = _ticks(TURN_S, tick_s) // 2
    way = np.linalg.norm(place[half:] - place[:-half], axis=-1)
    way = way[:-half] + way[half:]
    turned = np.abs(course[2 * half :] - course[: -2 * half])
    slow = (way > 0.0) & (way < LOW_SPEED * 2 * half * tick_s)
    turns = alive[2 * half :] & slow & (turned > np.radians(TIGHT_DEG))
    radius = way / np.where(turns, turned, 1.0)
    least = [
        radius[start:end, i].min()
        for i in range(radius.shape[1])
        for start, end in runs(turns[:, i])
    ]
    return np.array(least)


def _straight(record: Record, course: Array, alive: Bools, those: Ints) -> Counts:
    """Measure change of heading in straight swims and in all, rad, without the sway of the beat.

    Changes are taken over `TURN_S` and count as straight if no tick among them is of a turn.
    Fishes that row turn by their fins, with a straight body.
    """
    ticks = _ticks(TURN_S, record.tick_s)
    if len(course) <= ticks:
        return 0.0, 0.0
    turns = ~np.array([name.startswith("swim") for name in record.segment_names])
    count = np.cumsum(turns[record.segment[:, those]], axis=0, dtype=np.int64)
    rate = np.abs(course[ticks:] - course[:-ticks]) / ticks  # smoothed, each tick
    rate[rate < np.radians(TURNING_DEG_S) * record.tick_s] = 0.0
    rate *= alive[ticks // 2 :][: len(rate)]
    straight = (count[ticks:] == count[:-ticks]) & ~turns[record.segment[:-ticks, those]]
    return float(rate[straight].sum()), float(rate.sum())


def joined(parts: list[Swimming]) -> Swimming:
    """Join the samples of several records of one species."""
    fields = {}
    for name, field in Swimming.__annotations__.items():
        values = [getattr(part, name) for part in parts]
        if field is float:
            fields[name] = max(values)
        elif field is Counts:
            fields[name] = tuple(np.sum(values, axis=0).tolist())
        else:
            fields[name] = np.concatenate(values)
    return Swimming(**fields)
