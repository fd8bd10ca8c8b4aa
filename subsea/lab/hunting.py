"""Measures of hunts: patrols, stalks, rushes and catches of each predator of a record.

A rush is found from speed and intention, a stalk is what leads to it. So the same measures hold for
records of any version, and for tracked fishes with targets.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.periodic import shortest
from subsea.lab.measures import headings, runs
from subsea.media.record import STATIONS, Record
from subsea.state import EAT, PREDATOR, PREY

RUSHES_BL_S = 1.3  # speed of a rush: above the fast swim of a shark, 1 L/s
SMOOTH_TICKS = 3  # over which speed is averaged
RESUMED_S = 0.8  # a rush goes on after a pause of less than this
LEAST_RUSH_S = 0.25
STALK_S = 2.0  # before a rush, over which the direction of the approach is averaged
LEAST_STALK_S = 1.0
BELOW_DEG = 5.0  # elevation of the prey from the snout beyond which the approach is from below
BEHIND_DEG = 120.0  # bearing of the hunter from the prey's heading beyond which it is behind
BLIND_DEG, UNDER_DEG = 150.0, 20.0  # bearing and depression of a hunter that is hard to see
SCHOOL_BL, COMPANIONS = 6.0, 2  # at a school: companions within this many lengths of the prey
CLOSE_BL = 1.0  # a rush is at close range if the snout comes within this many lengths of a prey
HIT_S = 1.0  # prey that dies until then was caught by the rush


class Rush(NamedTuple):
    """A rush of one hunter at one prey; L is the length of the hunter."""

    hunter: int
    prey: int
    start_s: float
    duration_s: float
    start_bl: float  # distance from snout to prey at its start, L
    nearest_bl: float  # least distance from the snout to any prey, L
    peak_bl_s: float  # greatest speed, L/s
    below: bool  # the stalk before it came from below ...
    behind: bool  # ... or from behind
    hidden: bool  # it began in the blind angle of the prey, or from well below
    school: bool  # the prey had companions near
    hit: bool

    @property
    def close(self) -> bool:
        """True if the rush came to close range."""
        return self.nearest_bl <= CLOSE_BL


class Hunts(NamedTuple):
    """The hunts of a record."""

    seconds: float
    patrol_share: float  # of the time of all living hunters; NaN without hunters
    patrol_bl_s: float  # median speed on patrol, L/s
    stalks: list[float]  # duration of each approach without a rush, s
    rushes: list[Rush]
    caught_s: list[float]  # times at which prey died
    least_gap_cm: float  # between the bodies of two hunters, negative in an overlap; or infinite


def hunts(record: Record) -> Hunts:
    """Measure all hunts of a record."""
    hunters = np.flatnonzero(record.kind == PREDATOR)
    alive = record.alive[:, hunters]
    calm = alive & (record.intention[:, hunters] != EAT)
    speeds = np.stack([speed_of(record, int(i)) for i in hunters], 1) if len(hunters) else alive
    stalks: list[float] = []
    rushes: list[Rush] = []
    caught: set[int] = set()
    for i, speed in zip(hunters, speeds.T, strict=True):
        stalks += list(_stalks(record, int(i), speed))
        for start, end in _spans(record, int(i), speed):
            rushes.append(_rush(record, int(i), speed[start:end], start, caught))
    prey = record.kind == PREY
    died = np.nonzero(record.alive[:-1, prey] & ~record.alive[1:, prey])[0] + 1
    return Hunts(
        float(record.time[-1] - record.time[0] + record.tick_s),
        float(calm.sum() / alive.sum()) if alive.any() else np.nan,
        float(np.median(speeds[calm])) if calm.any() else np.nan,
        stalks,
        sorted(rushes, key=lambda rush: rush.start_s),
        [float(record.time[t]) for t in died],
        least_gap(record, hunters),
    )


def speed_of(record: Record, i: int) -> Array:
    """Measure the speed (T,) of fish i over a few ticks, L/s."""
    way = np.diff(record.centre[:, i].astype(np.float64), axis=0, prepend=record.centre[:1, i])
    kernel = np.ones(SMOOTH_TICKS) / SMOOTH_TICKS
    smooth = np.stack([np.convolve(way[:, axis], kernel, "same") for axis in range(3)], axis=1)
    return np.asarray(np.linalg.norm(smooth, axis=1) / record.tick_s / record.length[i])


def _spans(record: Record, i: int, speed: Array) -> Iterator[tuple[int, int]]:
    """Find the first tick of each rush of hunter i, and the tick after its last."""
    fast = (speed > RUSHES_BL_S) & (record.intention[:, i] == EAT) & record.alive[:, i]
    found: list[tuple[int, int]] = []
    for start, end in runs(fast):
        if found and (start - found[-1][1]) * record.tick_s < RESUMED_S:
            found[-1] = found[-1][0], end
        else:
            found.append((start, end))
    for start, end in found:
        aims = _target(record, i, start) >= 0
        if aims and (end - start) * record.tick_s >= LEAST_RUSH_S:
            yield start, end


def _target(record: Record, i: int, t: int) -> int:
    """Find the prey that hunter i targets at tick t, or had just before; -1 for none."""
    for k in range(t, max(t - round(0.5 / record.tick_s), 0) - 1, -1):
        j = int(record.target[k, i])
        if 0 <= j < record.position.shape[1] and record.kind[j] == PREY:
            return j
    return -1


def _rush(record: Record, i: int, speed: Array, start: int, caught: set[int]) -> Rush:
    """Describe the rush of hunter i with a `speed` (ticks,) from tick `start`.

    Adds the prey that it caught to `caught`, so that no other rush catches it.
    """
    end = start + len(speed)
    j = _target(record, i, start)
    length, tick_s = float(record.length[i]), record.tick_s
    snout = record.snout[start:end, i]
    prey = np.flatnonzero(record.kind == PREY)
    period = record.period
    ways = shortest(record.position[start:end, prey] - snout[:, None], period)
    gaps = np.linalg.norm(ways, axis=2)
    gaps[~record.alive[start:end, prey]] = np.inf
    before = slice(max(start - round(STALK_S / tick_s), 0), start + 1)
    toward = shortest(record.position[before, j] - record.snout[before, i], period)
    far = np.maximum(np.linalg.norm(toward, axis=1), 1e-6)
    rise = np.degrees(np.arcsin(toward[:, 2] / far)).mean()
    ahead = headings(record.orientation[before, j])
    bearing = np.degrees(np.arccos(np.clip((-toward * ahead).sum(axis=1) / far, -1, 1))).mean()
    lowered = np.degrees(np.arcsin(toward[-1, 2] / far[-1]))
    blind = -toward[-1] @ ahead[-1] < far[-1] * np.cos(np.radians(BLIND_DEG))
    same = np.flatnonzero((record.species == record.species[j]) & record.alive[start])
    same = same[record.kind[same] == PREY]
    ways = shortest(record.position[start, same] - record.position[start, j], period)
    apart = np.linalg.norm(ways, axis=1)
    company = (apart < SCHOOL_BL * record.length[j]).sum() - 1
    last = min(end + round(HIT_S / tick_s), len(record.time) - 1)
    died = {int(j) for j in prey[record.alive[start, prey] & ~record.alive[last, prey]]} - caught
    fed = record.last_meal[last, i] >= record.time[start] - tick_s
    caught |= died if fed else set()
    return Rush(
        i,
        j,
        float(record.time[start]),
        (end - start) * tick_s,
        float(far[-1]) / length,
        float(gaps.min()) / length,
        float(speed.max()),
        bool(rise > BELOW_DEG),
        bool(bearing > BEHIND_DEG),
        bool(blind or lowered > UNDER_DEG),
        bool(company >= COMPANIONS),
        bool(died and fed),
    )


def _stalks(record: Record, i: int, speed: Array) -> Iterator[float]:
    """Find the durations, s, of the approaches of hunter i to one prey after another."""
    target = record.target[:, i]
    stalks = (record.intention[:, i] == EAT) & (target >= 0) & (speed <= RUSHES_BL_S)
    for start, end in runs(stalks & record.alive[:, i]):
        if (end - start) * record.tick_s >= LEAST_STALK_S:
            yield (end - start) * record.tick_s


def least_gap(record: Record, these: Ints) -> float:
    """Measure the least gap between the bodies of two of the fishes `these`, cm.

    A body is a row of spheres along its line from the snout over the middle to the tail, whose
    radius is the mean of half-width and half-height. Overlaps are negative.
    """
    least = np.inf
    beads = {int(i): _beads(record, int(i)) for i in these}
    for a, i in enumerate(these):
        for j in these[a + 1 :]:
            both: Bools = record.alive[:, i] & record.alive[:, j]
            ways = shortest(record.position[:, i] - record.position[:, j], record.period)
            far = np.linalg.norm(ways, axis=1)
            near = np.flatnonzero(both & (far < record.length[i] + record.length[j]))
            if not len(near):
                if both.any():
                    longer = record.length[i] + record.length[j]
                    least = min(least, float(far[both].min() - longer / 2))
                continue
            (p, p_radius), (q, q_radius) = beads[int(i)], beads[int(j)]
            ways = shortest(p[near][:, :, None] - q[near][:, None], record.period)
            gaps = np.linalg.norm(ways, axis=3)
            least = min(least, float((gaps - p_radius[:, None] - q_radius).min()))
    return least


def _beads(record: Record, i: int) -> tuple[Array, Array]:
    """Make the spheres of fish i: their middles (T, STATIONS, 3) and radii (STATIONS,), cm."""
    share = np.clip(record.snout_reach[i] / record.length[i], 0.05, 0.95)
    along = np.linspace(0.0, 1.0, STATIONS)[:, None]
    snout, middle, tail = (
        part[:, None, i] for part in (record.snout, record.position, record.tail)
    )
    ahead = snout + (middle - snout) * along / share
    behind = middle + (tail - middle) * (along - share) / (1.0 - share)
    kind = record.species[i]
    radius = 0.5 * (record.half_width[kind] + record.half_height[kind]) * record.length[i]
    return np.where(along < share, ahead, behind), radius
