"""Schools as measured in nature: order, states, spacing, shape, bearings, rhythm and splits."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.periodic import gathered, nearest_image, shortest
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.lab.measures import SAMPLE_S, headings, runs
from subsea.lab.rhythm import Rhythm, rhythm
from subsea.media.record import Record
from subsea.state import AVOID, ESCAPE, FEAR, PICK, SCHOOL

LINK_BL = 4.0  # fishes of a school within this distance are connected
WHOLE = 0.9  # least connected share of a whole school
SPLIT_S = 0.5  # minimum duration of a split
DISORDER = 0.5  # polarisation below which Etroplus schools are for 20 to 37% of the time


class School(NamedTuple):
    """The school of one leader, sampled k times."""

    leader: int
    time: Array  # (k,) s
    members: Ints  # (k,) fishes alive
    calm: Bools  # (k,), whether none of them is alarmed
    cruises: Bools  # (k,), whether at least half of them school, and none is alarmed
    polarisation: Array  # (k,) length of the mean heading of those that school
    rotation: Array  # (k,) how much they circle their middle, seen from above: 0 to 1
    course: Array  # (k,) rad, direction of their mean heading, left of the x axis
    nearest: Array  # (k,) median distance to the nearest of the school, body lengths
    together: Array  # (k,) share of those that school in the largest connected part
    extent: Array  # (k,) root of the mean squared distance from their middle, body lengths
    distances: Array  # every such distance while it cruises, body lengths


class Split(NamedTuple):
    """A period in which a school was in parts."""

    leader: int
    start: float  # s
    duration: float  # s
    rejoined: bool  # else the record ended
    apart: float  # largest share outside the largest part


def schools(record: Record) -> list[School]:
    """Measure the shape of every school of at least three fishes, five times a second.

    Counts the leader and the fishes that currently school, pick plankton, avoid something or
    escape; the others pursue intentions of their own.
    """
    every = max(round(SAMPLE_S / record.tick_s), 1)
    followed = record.leader[::every]
    leaders = [int(k) for k in np.unique(followed) if k >= 0]
    return [school for leader in leaders if len((school := _school(record, leader, every)).time)]


def _school(record: Record, leader: int, every: int) -> School:
    rows: list[tuple[float, int, bool, bool, float, float, float, float, float, float]] = []
    distances: list[Array] = []
    for t in range(0, len(record.time), every):
        those = record.alive[t] & (record.leader[t] == leader)
        those[leader] = record.alive[t, leader]
        members = np.flatnonzero(those)
        doing = record.intention[t, members]
        led = members == leader
        schooling = members[np.isin(doing, (SCHOOL, PICK, AVOID, ESCAPE)) | led]
        if len(members) < 3 or len(schooling) < 2:
            continue
        calm = bool(record.mental_state[t, members, FEAR].max() <= record.alarmed)
        cruises = calm and bool(2 * (np.isin(doing, (SCHOOL, PICK)) | led).sum() >= len(members))
        ahead = headings(record.orientation[t, schooling])
        place = gathered(record.position[t, schooling], record.period)
        mean = ahead.mean(axis=0)
        lengths = record.length[schooling]
        nearest, together = spread(place.astype(np.float64), lengths, LINK_BL, record.period)
        if cruises:
            distances.append(nearest)
        rows.append((
            float(record.time[t]), len(members), calm, cruises, float(np.linalg.norm(mean)),
            rotation_of(place.astype(np.float64), ahead), float(np.arctan2(mean[1], mean[0])),
            float(np.median(nearest)), together,
            float(np.linalg.norm(place.std(axis=0)) / record.length[schooling].mean()),
        ))  # fmt: skip
    columns = [np.array(column) for column in zip(*rows, strict=True)] or [np.zeros(0)] * 10
    fields = dict(zip(School._fields[1:11], columns, strict=True))
    nearby = np.concatenate(distances) if distances else np.zeros(0)
    return School(leader=leader, **fields, distances=nearby)


def rotation_of(place: Array, ahead: Array) -> float:
    """Measure how much m fishes at places (m, 3) with headings (m, 3) circle their middle.

    It is the mean over the fishes of the sine between the way from the middle and the heading, both
    seen from above: 1 for a ring that turns one way (Tunstrøm et al. 2013).
    """
    out = (place - place.mean(axis=0))[:, :2]
    across = out[:, 0] * ahead[:, 1] - out[:, 1] * ahead[:, 0]
    sizes = np.linalg.norm(out, axis=1) * np.linalg.norm(ahead[:, :2], axis=1)
    return float(abs((across / np.maximum(sizes, 1e-9)).mean()))


# Order and disorder of the three states (Tunstrøm et al. 2013).
HIGH, LOW = 0.65, 0.35


def states(school: School) -> dict[str, float]:
    """Measure the shares of the samples in which a school is polarised, mills or is a swarm.

    In the rest of the samples it is between the states, and not alarmed in any.
    """
    calm = school.calm
    order, turning = school.polarisation[calm], school.rotation[calm]
    if not len(order):
        return {"polarised": 0.0, "milling": 0.0, "swarm": 0.0}
    return {
        "polarised": float(((order > HIGH) & (turning < LOW)).mean()),
        "milling": float(((order < LOW) & (turning > HIGH)).mean()),
        "swarm": float(((order < LOW) & (turning < LOW)).mean()),
    }


@kernel
def spread(position: Array, length: Array, link: float, period: Array) -> tuple[Array, float]:
    """Measure distances to the nearest (m,), body lengths, and the share of the largest part.

    A pair's body length is the mean of both. In a box, nearest images count.
    """
    m = len(length)
    order = np.argsort(position[:, 0], kind="mergesort")
    nearest = np.full(m, np.inf)
    part = np.arange(m)
    longest = length.max()
    for a in range(m):
        i = order[a]
        for side in (1, -1):
            b = a + side
            while 0 <= b < m:
                j = order[b]
                along = abs(position[j, 0] - position[i, 0]) / longest
                if along > link and along > nearest[i] and period[0] <= 0.0:
                    break
                here = vector(position[i])
                gap = norm(minus(nearest_image(vector(position[j]), here, period), here))
                distance = gap / (0.5 * (length[i] + length[j]))
                nearest[i] = min(nearest[i], distance)
                if distance <= link:
                    x, y = _root(part, i), _root(part, j)
                    part[max(x, y)] = min(x, y)
                b += side
    count = np.zeros(m, np.int64)
    for i in range(m):
        count[_root(part, i)] += 1
    return nearest, count.max() / m


@kernel
def _root(part: Ints, i: int) -> int:
    while part[i] != i:
        part[i] = part[part[i]]
        i = part[i]
    return i


def splits(school: School, end: float) -> list[Split]:
    """Find periods in which less than nine tenths of a school were connected.

    Shorter ones than half a second do not count. `end` is the time of the last tick, s.
    """
    return [
        Split(
            school.leader,
            float(school.time[first]),
            duration,
            after < len(school.time),
            float(1.0 - school.together[first:after].min()),
        )
        for first, after, duration in split_periods(school.time, school.together, end)
    ]


def split_periods(time: Array, together: Array, end: float) -> list[tuple[int, int, float]]:
    """Find the first sample, the sample after the last, and the duration, s, of each split.

    A split ends at the latest with the school: it has no sample while it has too few fishes.
    """
    found = []
    if len(time) > 1:
        end = min(end, float(time[-1] + np.median(np.diff(time))))
    for first, after in runs(together < WHOLE):
        duration = float((time[after] if after < len(time) else end) - time[first])
        if duration >= SPLIT_S:
            found.append((first, after, duration))
    return found


BEARINGS = 8  # sectors of equal solid angle from ahead to behind, both sides alike
SECTORS = 18  # of 10 degrees from ahead to behind seen from above, both sides alike
OBLIQUE = (3, 4, 5, 12, 13, 14)  # sectors about 45 and 135 degrees ...
ABREAST = (8, 9)  # ... and about 90 degrees
FILED = 0.5  # least polarisation of a school that has a length and a width
LEAST_ROOM = 10  # fishes of a school whose room is measured: the volume of fewer is too uncertain


class Schooling(NamedTuple):
    """Measures of one school while it cruises; NaN where it never does."""

    leader: int  # fish that the school is known by
    fishes: int
    polarisation: float  # median
    disorder: float  # share of the time with a polarisation below DISORDER
    rotation: float  # median
    states: Array  # (3,) shares of polarised, milling and swarm
    nearest_bl: float  # median distance to the nearest neighbour ...
    near_bl: float  # ... and its 5th percentile
    height_bl: float  # median difference in depth to that neighbour
    room_bl3: float  # median volume per fish, body lengths cubed
    ahead_bl: float  # median distance by which the foremost fish leads the second
    longer: float  # median of length over width, of a school on its way
    flatter: float  # median of length over height
    bearing: Array  # (BEARINGS,) shares of nearest neighbours by bearing, of equal solid angles
    sector: Array  # (SECTORS,) shares of nearest neighbours by bearing from above
    rhythm: Rhythm  # of its fishes
    time: Array  # (k,) s, of the samples of ...
    together: Array  # (k,) ... the share in the largest connected part ...
    calm: Bools  # (k,) ... and whether no fish is alarmed
    end: float  # s

    @property
    def oblique(self) -> float:
        """Density of nearest neighbours about 45° and 135° over that about 90°; NaN if unknown."""
        abreast = self.sector[list(ABREAST)].mean()
        if not self.sector.sum():
            return float("nan")
        return float(self.sector[list(OBLIQUE)].mean() / max(abreast, 1e-9))

    @property
    def split_s(self) -> Array:
        """Durations of its splits."""
        return self._durations(self.together)

    @property
    def calm_split_s(self) -> Array:
        """Durations of its splits without alarm: predators split schools."""
        return self._durations(np.where(self.calm, self.together, 1.0))

    def _durations(self, together: Array) -> Array:
        return np.array([one[2] for one in split_periods(self.time, together, self.end)])


MEDIANS = (
    "polarisation", "disorder", "rotation", "nearest_bl", "near_bl", "height_bl", "room_bl3",
    "ahead_bl", "longer", "flatter",
)  # fmt: skip
"""Measures whose median over the parts of a record is that of the whole, nearly."""


def schooling(record: Record) -> list[Schooling]:
    """Measure every school of at least three fishes.

    Sectors of bearings are equal in solid angle, so that neighbours at random give equal shares.
    """
    return [_measured(record, school) for school in schools(record)]


def _measured(record: Record, school: School) -> Schooling:
    every = max(round(SAMPLE_S / record.tick_s), 1)
    cruises = school.cruises.astype(bool)
    ticks = np.searchsorted(record.time, school.time[cruises])
    rows, bearing, sector = [], np.zeros(BEARINGS), np.zeros(SECTORS)
    for t in ticks[:: max(round(1.0 / (every * record.tick_s)), 1)]:  # once a second
        those = record.alive[t] & (record.leader[t] == school.leader)
        those[school.leader] = record.alive[t, school.leader]
        members = np.flatnonzero(those & np.isin(record.intention[t], (SCHOOL, PICK, AVOID)))
        if len(members) >= 3:
            rows.append(_shape(record, t, members, bearing, sector))
    height, room, ahead, longer, flatter = (
        (_median(column) for column in zip(*rows, strict=True)) if rows else [np.nan] * 5
    )
    order = school.polarisation[cruises]
    near = school.distances
    return Schooling(
        school.leader,
        int(school.members.max()),
        float(np.median(order)) if len(order) else np.nan,
        float((order < DISORDER).mean()) if len(order) else np.nan,
        float(np.median(school.rotation[cruises])) if len(order) else np.nan,
        np.array([*states(school._replace(calm=school.calm.astype(bool))).values()]),
        float(np.median(near)) if len(near) else np.nan,
        float(np.percentile(near, 5)) if len(near) else np.nan,
        height,
        room,
        ahead,
        longer,
        flatter,
        bearing / max(bearing.sum(), 1.0),
        sector / max(sector.sum(), 1.0),
        _rhythm(record, school.leader),
        school.time,
        school.together,
        school.calm.astype(bool),
        float(record.time[-1]),
    )


def _rhythm(record: Record, leader: int) -> Rhythm:
    """Measure the rhythm of the fishes of one school while they school or pick without alarm."""
    followed = (record.leader == leader).any(axis=0)
    followed[leader] = True
    those = np.flatnonzero(followed)
    calm = record.alive[:, those] & np.isin(record.intention[:, those], (SCHOOL, PICK))
    calm &= record.mental_state[:, those, FEAR] <= record.alarmed
    return rhythm(record, those, calm)


def joined(parts: Sequence[Schooling]) -> list[Schooling]:
    """Join the schools of a dive that was recorded in parts: medians of medians, and all splits."""
    schools: dict[int, list[Schooling]] = {}
    for one in parts:
        schools.setdefault(one.leader, []).append(one)
    return [_joined(those) for those in schools.values()]


def _joined(parts: Sequence[Schooling]) -> Schooling:
    columns = {name: [getattr(one, name) for one in parts] for name in Schooling._fields}
    joint: dict[str, Any] = {name: _median(columns[name]) for name in MEDIANS}
    joint |= {name: np.concatenate(columns[name]) for name in ("time", "together", "calm")}
    joint |= {name: np.mean(columns[name], axis=0) for name in ("bearing", "sector", "states")}
    joint["rhythm"] = Rhythm(*map(_median, zip(*columns["rhythm"], strict=True)))
    return parts[-1]._replace(fishes=max(columns["fishes"]), **joint)


def _median(values: Sequence[float]) -> float:
    """Compute the median of the values that are not NaN; NaN without any."""
    there = [value for value in values if not np.isnan(value)]
    return float(np.median(there)) if there else np.nan


def _shape(
    record: Record, t: int, members: Ints, bearing: Array, sector: Array
) -> tuple[float, float, float, float, float]:
    """Measure height to the nearest, room per fish, lead of the foremost, and the school's shape.

    The shape is its length over its width and over its height, NaN for a school without a way.
    Adds to `bearing` and `sector`.
    """
    place = record.position[t, members].astype(np.float64)
    length = record.length[members].astype(np.float64)
    ahead = headings(record.orientation[t, members])
    gap = shortest(place[None] - place[:, None], record.period)  # from a fish (row) to another
    place = gathered(place, record.period)
    far = np.linalg.norm(gap, axis=2) / (0.5 * (length[:, None] + length))
    np.fill_diagonal(far, np.inf)
    nearest = far.argmin(axis=1)
    toward = gap[np.arange(len(members)), nearest]
    size = np.maximum(np.linalg.norm(toward, axis=1), 1e-6)
    cosine = (toward * ahead).sum(axis=1) / size
    # Solid angle is even in the cosine.
    np.add.at(bearing, np.clip((1.0 - cosine) / 2 * BEARINGS, 0, BEARINGS - 1).astype(int), 1.0)
    across = ahead[:, 0] * toward[:, 1] - ahead[:, 1] * toward[:, 0]
    aside = np.arctan2(np.abs(across), (toward * ahead)[:, :2].sum(axis=1)) / np.pi
    np.add.at(sector, np.clip(aside * SECTORS, 0, SECTORS - 1).astype(int), 1.0)
    height = float(np.median(np.abs(toward[:, 2]) / length))
    room = room_of(place / length.mean())
    along = np.sort(place @ ahead.mean(axis=0)) / max(
        float(np.linalg.norm(ahead.mean(axis=0))), 0.1
    )
    lead = float(along[-1] - along[-2]) / float(length.mean())
    return height, room, lead, *proportions(place, ahead)


def room_of(place: Array) -> float:
    """Measure the volume per fish of a school at places (m, 3), body lengths, in their cube.

    The school is measured as a whole, with its hollows and without bias by stragglers (Pitcher and
    Partridge 1979): as twice the ellipsoid around its middle that has the proportions of its
    covariance and holds half of the fishes. This is exact for fishes that fill an ellipsoid evenly.
    NaN for fewer than LEAST_ROOM fishes, or all in one plane.
    """
    if len(place) < LEAST_ROOM:
        return np.nan
    out = place - place.mean(axis=0)
    covariance = np.cov(out.T)
    spread = float(np.linalg.det(covariance))
    if spread <= 1e-12:
        return np.nan
    far = float(np.median((out @ np.linalg.inv(covariance) * out).sum(axis=1)))
    return 2 * 4 / 3 * np.pi * float(np.sqrt(far**3 * spread)) / len(place)


def proportions(place: Array, ahead: Array) -> tuple[float, float]:
    """Measure the length of a school over its width and over its height, by standard deviations.

    Length is along the mean heading seen from above. `place` and `ahead` are (m, 3). NaN where
    the headings have no common direction.
    """
    way = ahead[:, :2].mean(axis=0)
    order = float(np.linalg.norm(way))
    if order < FILED:
        return np.nan, np.nan
    along, across = place[:, :2] @ way / order, place[:, :2] @ [-way[1], way[0]] / order
    length = float(along.std())
    return length / max(float(across.std()), 1e-6), length / max(float(place[:, 2].std()), 1e-6)
