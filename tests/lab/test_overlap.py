"""Bodies that overlap."""

import numpy as np

from subsea.lab.measures import overlaps
from subsea.state import PREDATOR, PREY
from tests.support.records import EAST, NORTH, a_record, still

OFFSETS = [
    ((0.0, 1.9, 0.0), EAST, True),  # abreast: half-widths add up to 2 cm
    ((0.0, 2.1, 0.0), EAST, False),
    ((0.0, 0.0, 5.9), EAST, True),  # one above the other: half-heights to 6 cm
    ((0.0, 0.0, 6.1), EAST, False),
    ((0.0, 1.2, 4.7), EAST, True),  # (1.2/2)² + (4.7/6)² = 0.97
    ((0.0, 1.3, 4.7), EAST, False),  # 1.04, though far from both half-widths and heights
    ((19.0, 0.0, 0.0), EAST, True),  # snout to tail
    ((27.0, 0.0, 0.0), EAST, False),
    ((8.0, -6.8, 0.0), NORTH, True),  # its snout at 1.2 cm from the other's centre line
    ((0.0, 40.0, 0.0), NORTH, False),
]


def test_bodies_overlap_as_ellipses_do():
    for offset, turn, touches in OFFSETS:
        there = np.array([0.0, 0.0, -200.0])
        record = a_record(still(2, there, there + offset), np.stack([EAST, turn]))
        assert (overlaps(record) == (2 if touches else 0)).all(), offset


def test_a_bent_body_overlaps_along_its_bend():
    """The tail of the first fish swings 8 cm aside, onto the second one."""
    there = still(1, (0, 0, -200), (-2, 7, -200))
    straight = a_record(there)
    bent = straight._replace(tail=straight.tail + np.array([[[0, 8, 0], [0, 0, 0]]], np.float32))
    assert not overlaps(straight).any()
    assert overlaps(bent).all()


def test_courting_and_hunting_fishes_may_touch():
    there = still(1, (0, 0, -200), (0, 1, -200))
    court = a_record(there, partner=np.array([[1, -1]]))
    hunt = a_record(there, kind=np.array([PREDATOR, PREY]))
    assert (overlaps(court) == 1).all()
    assert (overlaps(hunt) == 1).all()
    dead = a_record(there, alive=np.array([[True, False]]))
    assert not overlaps(dead).any()


def test_overlaps_of_many_fishes_equal_those_of_all_pairs():
    rng = np.random.default_rng(5)
    places = rng.uniform(-30, 30, (1, 24, 3)) - (0, 0, 200)
    turns = rng.normal(size=(24, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    together = overlaps(a_record(places, turns))[0]
    alone = np.zeros(24, int)
    for i in range(24):
        for j in range(i):
            pair = [i, j]
            alone[pair] |= overlaps(a_record(places[:, pair], turns[pair]))[0]
    assert (together == alone).all()
    assert 0 < (together > 0).sum() < 24
