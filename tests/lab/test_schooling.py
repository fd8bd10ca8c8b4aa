"""Schools as measured in nature."""

import numpy as np
import pytest

from subsea.lab.schooling import BEARINGS, joined, schooling
from subsea.state import SCHOOL
from tests.support.records import LENGTH, a_record


def a_school(places, ticks=31):
    n = len(places)
    leader = np.zeros((ticks, n), np.int32)
    leader[:, 0] = -1
    still = np.broadcast_to(places * LENGTH - (0, 0, 200.0), (ticks, n, 3))
    return a_record(still, leader=leader, intention=np.full((ticks, n), SCHOOL))


def test_a_ball_of_fishes_has_the_room_of_a_ball():
    rng = np.random.default_rng(3)
    ball = rng.normal(size=(400, 3))
    ball *= (rng.uniform(0, 1, 400) ** (1 / 3) / np.linalg.norm(ball, axis=1))[:, None] * 3.0
    (found,) = schooling(a_school(ball, ticks=3))
    assert found.fishes == 400
    assert found.room_bl3 == pytest.approx(4 / 3 * np.pi * 27 / 400, rel=0.1)
    assert found.bearing == pytest.approx(1 / BEARINGS, abs=0.05)
    assert found.polarisation == pytest.approx(1.0)


def test_files_have_their_neighbours_ahead_and_behind():
    """Two files at different depths: the nearest is in the same file; the first leads by 2 L."""
    x = np.array([0.0, 0.8, 1.6, 2.4, 4.4])
    places = np.concatenate(
        [np.stack([x, 0 * x, 0 * x], 1), np.stack([x - 3, 0 * x, 2 + 0 * x], 1)]
    )
    (found,) = schooling(a_school(places))
    assert found.nearest_bl == pytest.approx(0.8, rel=1e-4)
    assert found.height_bl == 0.0
    assert found.ahead_bl == pytest.approx(2.0, rel=1e-4)
    assert found.bearing[0] + found.bearing[-1] == pytest.approx(1.0)
    assert found.split_s.shape == (0,)


def test_a_split_may_last_from_one_part_of_a_record_to_the_next():
    """Two recorded parts, with the school in halves from the end of one into the other."""
    (whole,) = schooling(a_school(np.eye(4, 3)))
    time = np.arange(0.0, 20.0, 0.5)
    split = np.where((time >= 8.0) & (time < 13.0), 0.5, 1.0)
    parts = [
        whole._replace(time=time[part], together=split[part], calm=(time >= 11.5)[part],
                       end=float(time[part][-1]), fishes=n, polarisation=p)
        for part, n, p in ((slice(0, 20), 4, 0.9), (slice(20, 40), 5, np.nan))
    ]  # fmt: skip
    (found,) = joined(parts)
    assert found.split_s.tolist() == [5.0]
    assert found.calm_split_s.tolist() == [1.5]
    assert (found.fishes, found.polarisation) == (5, 0.9)
    assert [one.leader for one in joined([*parts, whole._replace(leader=9)])] == [whole.leader, 9]
