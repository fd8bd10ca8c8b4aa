"""Schools: shape, spacing and splits."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.geometry.vector import minus, norm, vector
from subsea.kernels import kernel
from subsea.lab.series import SAMPLE_S, headings, runs
from subsea.media.record import Record
from subsea.state import AVOID, ESCAPE, FEAR, SCHOOL

LINK_BL = 4.0  # fishes of a school within this distance are connected
WHOLE = 0.9  # least connected share of a whole school
SPLIT_S = 0.5  # minimum duration of a split


class School(NamedTuple):
    """The school of one leader, sampled k times."""

    leader: int
    time: Array  # (k,) s
    members: Ints  # (k,) fishes alive
    calm: Bools  # (k,), whether none of them is alarmed
    cruises: Bools  # (k,), whether at least half of them school, and none is alarmed
    polarisation: Array  # (k,) length of the mean heading of those that school
    nearest: Array  # (k,) median distance to the nearest of the school, body lengths
    distances: Array  # every such distance while it cruises, body lengths
    together: Array  # (k,) share of those that school in the largest connected part


class Split(NamedTuple):
    """A period in which a school was in parts."""

    leader: int
    start: float  # s
    duration: float  # s
    rejoined: bool  # else the record ended
    apart: float  # largest share outside the largest part


def schools(record: Record) -> list[School]:
    """The shape of every school of at least three fishes, five times a second.

    Counts the leader and the fishes that currently school, avoid something or escape; the others
    pursue intentions of their own.
    """
    every = max(round(SAMPLE_S / record.tick_s), 1)
    followed = record.leader[::every]
    leaders = [int(k) for k in np.unique(followed) if k >= 0]
    return [school for leader in leaders if len((school := _school(record, leader, every)).time)]


def _school(record: Record, leader: int, every: int) -> School:
    rows: list[tuple[float, int, bool, bool, float, float, float]] = []
    distances: list[Array] = []
    for t in range(0, len(record.time), every):
        those = record.alive[t] & (record.leader[t] == leader)
        those[leader] = record.alive[t, leader]
        members = np.flatnonzero(those)
        doing = record.intention[t, members]
        led = members == leader
        schooling = members[np.isin(doing, (SCHOOL, AVOID, ESCAPE)) | led]
        if len(members) < 3 or len(schooling) < 2:
            continue
        calm = bool(record.mental_state[t, members, FEAR].max() <= record.alarmed)
        cruises = calm and bool(2 * ((doing == SCHOOL) | led).sum() >= len(members))
        polarisation = float(
            np.linalg.norm(headings(record.orientation[t, schooling]).mean(axis=0))
        )
        nearest, together = _spread(
            record.position[t, schooling].astype(np.float64), record.length[schooling], LINK_BL
        )
        if cruises:
            distances.append(nearest)
        rows.append((
            float(record.time[t]), len(members), calm, cruises, polarisation,
            float(np.median(nearest)), together,
        ))  # fmt: skip
    columns = [np.array(column) for column in zip(*rows, strict=True)] or [np.zeros(0)] * 7
    return School(
        leader=leader,
        time=columns[0],
        members=columns[1],
        calm=columns[2],
        cruises=columns[3],
        polarisation=columns[4],
        nearest=columns[5],
        distances=np.concatenate(distances) if distances else np.zeros(0),
        together=columns[6],
    )


@kernel
def _spread(position: Array, length: Array, link: float) -> tuple[Array, float]:
    """Distance to the nearest (m,) in body lengths, and the share of the largest connected part.

    A pair's body length is the mean of both.
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
                if along > link and along > nearest[i]:
                    break
                gap = norm(minus(vector(position[j]), vector(position[i])))
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
    """Periods in which less than nine tenths of a school were connected.

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
    """First sample, sample after the last, and duration, s, of each split; see `splits`.

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
