"""Schools as measured in nature: order, spacing, room, bearings and splits."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.lab.schools import School, schools, split_periods
from subsea.lab.series import SAMPLE_S, headings
from subsea.media.record import Record
from subsea.state import AVOID, SCHOOL

BEARINGS = 8  # sectors of 45 degrees from straight ahead to straight behind, both sides alike


class Schooling(NamedTuple):
    """Measures of one school while it cruises; NaN where it never does."""

    leader: int  # fish that the school is known by
    fishes: int
    polarisation: float  # median
    nearest_bl: float  # median distance to the nearest neighbour
    height_bl: float  # median difference in depth to that neighbour
    room_bl3: float  # median volume per fish, body lengths cubed
    ahead_bl: float  # median distance by which the foremost fish leads the second
    bearing: Array  # (BEARINGS,) shares of nearest neighbours by bearing, of equal solid angles
    time: Array  # (k,) s, of the samples of ...
    together: Array  # (k,) ... the share in the largest connected part ...
    calm: Bools  # (k,) ... and whether no fish is alarmed
    end: float  # s

    @property
    def split_s(self) -> Array:
        """Durations of the periods in which it was in parts."""
        return self._durations(self.together)

    @property
    def calm_split_s(self) -> Array:
        """The same while no fish is alarmed: predators split schools."""
        return self._durations(np.where(self.calm, self.together, 1.0))

    def _durations(self, together: Array) -> Array:
        return np.array([one[2] for one in split_periods(self.time, together, self.end)])


def schooling(record: Record) -> list[Schooling]:
    """Measure every school of at least three fishes.

    The volume is that of the ellipsoid with the second moments of the school (4/3 π √(125 det C)
    for the covariance C), exact for fishes that fill an ellipsoid evenly. Sectors of bearings are
    equal in solid angle, so that neighbours at random give equal shares.
    """
    return [_measured(record, school) for school in schools(record)]


def _measured(record: Record, school: School) -> Schooling:
    every = max(round(SAMPLE_S / record.tick_s), 1)
    ticks = np.searchsorted(record.time, school.time[school.cruises.astype(bool)])
    rows, bearing = [], np.zeros(BEARINGS)
    for t in ticks[:: max(round(1.0 / (every * record.tick_s)), 1)]:  # once a second
        those = record.alive[t] & (record.leader[t] == school.leader)
        those[school.leader] = record.alive[t, school.leader]
        members = np.flatnonzero(those & np.isin(record.intention[t], (SCHOOL, AVOID)))
        if len(members) >= 3:
            rows.append(_shape(record, t, members, bearing))
    height, room, ahead = np.median(rows, axis=0) if rows else [np.nan] * 3
    cruising = school.polarisation[school.cruises.astype(bool)]
    return Schooling(
        school.leader,
        int(school.members.max()),
        float(np.median(cruising)) if len(cruising) else np.nan,
        float(np.median(school.distances)) if len(school.distances) else np.nan,
        float(height),
        float(room),
        float(ahead),
        bearing / max(bearing.sum(), 1.0),
        school.time,
        school.together,
        school.calm.astype(bool),
        float(record.time[-1]),
    )


def joined(parts: Sequence[Schooling]) -> list[Schooling]:
    """The schools of a dive that was recorded in parts: medians of medians, and all splits."""
    schools: dict[int, list[Schooling]] = {}
    for one in parts:
        schools.setdefault(one.leader, []).append(one)
    return [_joined(those) for those in schools.values()]


def _joined(parts: Sequence[Schooling]) -> Schooling:
    return Schooling(
        parts[0].leader,
        max(one.fishes for one in parts),
        _median([one.polarisation for one in parts]),
        _median([one.nearest_bl for one in parts]),
        _median([one.height_bl for one in parts]),
        _median([one.room_bl3 for one in parts]),
        _median([one.ahead_bl for one in parts]),
        np.mean([one.bearing for one in parts], axis=0),
        np.concatenate([one.time for one in parts]),
        np.concatenate([one.together for one in parts]),
        np.concatenate([one.calm for one in parts]),
        parts[-1].end,
    )


def _median(values: Sequence[float]) -> float:
    """The median of the values that are not NaN; NaN without any."""
    there = [value for value in values if not np.isnan(value)]
    return float(np.median(there)) if there else np.nan


def _shape(record: Record, t: int, members: Ints, bearing: Array) -> tuple[float, float, float]:
    """Height to the nearest, room per fish and lead of the foremost; adds to `bearing`."""
    place = record.position[t, members].astype(np.float64)
    length = record.length[members].astype(np.float64)
    ahead = headings(record.orientation[t, members])
    gap = place[None] - place[:, None]  # from a fish (row) to another (column)
    far = np.linalg.norm(gap, axis=2) / (0.5 * (length[:, None] + length))
    np.fill_diagonal(far, np.inf)
    nearest = far.argmin(axis=1)
    toward = gap[np.arange(len(members)), nearest]
    size = np.maximum(np.linalg.norm(toward, axis=1), 1e-6)
    cosine = (toward * ahead).sum(axis=1) / size
    # Solid angle is even in the cosine.
    np.add.at(bearing, np.clip((1.0 - cosine) / 2 * BEARINGS, 0, BEARINGS - 1).astype(int), 1.0)
    height = float(np.median(np.abs(toward[:, 2]) / length))
    spread = np.linalg.det(np.cov((place / length.mean()).T))
    room = 4 / 3 * np.pi * np.sqrt(125.0 * max(spread, 0.0)) / len(members)
    along = np.sort(place @ ahead.mean(axis=0)) / max(
        float(np.linalg.norm(ahead.mean(axis=0))), 0.1
    )
    return height, float(room), float(along[-1] - along[-2]) / float(length.mean())
