"""Measures over tiny records whose answers are known."""

import numpy as np
import pytest

from subsea.state import (
    APPROACHING,
    ASCENDING,
    AVOID,
    CIRCLING,
    EAT,
    ESCAPE,
    FEAR,
    HUNGER,
    KINDS,
    LOOPING,
    NUZZLING,
    PREDATOR,
    PREY,
    SCHOOL,
    WANDER,
)
from subsea.study import measures
from subsea.study.record import STATIONS, Record

TICK_S = 0.1
LENGTH = 20.0  # cm; the bodies are 2 cm wide and 6 cm high
INTENTIONS = ["avoid", "escape", "school", "eat", "mate", "leave", "wander"]
COURTSHIP = ["none", "approaching", "looping", "circling", "ascending", "nuzzling"]
# Body axes to world: heading along x with the back up, and quarter turns to the left of that.
EAST = np.array([0.5**0.5, 0.5**0.5, 0.0, 0.0])
NORTH = np.array([0.5, 0.5, 0.5, 0.5])


def a_record(position, orientation=EAST, **changed):
    """A record of fishes at `position` (T, n, 3) in a flat sea 10 m wide and 4 m deep."""
    position = np.asarray(position, np.float32)
    ticks, n = position.shape[:2]
    turns = np.broadcast_to(np.asarray(orientation, np.float32), (ticks, n, 4))
    ahead = measures.headings(turns)
    zeros = np.zeros((ticks, n), np.int32)
    mental = np.zeros((ticks, n, 3), np.float32)
    given = {
        "time": TICK_S * np.arange(1, ticks + 1),
        "position": position,
        "orientation": turns,
        "snout": np.float32(position + 0.4 * LENGTH * ahead),
        "tail": np.float32(position - 0.6 * LENGTH * ahead),
        "intention": zeros + WANDER,
        "mental_state": mental,
        "alive": np.ones((ticks, n), bool),
        "leader": zeros - 1,
        "target": zeros - 1,
        "partner": zeros - 1,
        "courtship": zeros,
        "last_meal": np.zeros((ticks, n), np.float32),
        "species": np.zeros(n, np.uint8),
        "kind": np.zeros(n, np.uint8),
        "male": np.zeros(n, bool),
        "length": np.full(n, LENGTH, np.float32),
        "snout_reach": np.full(n, 0.4 * LENGTH, np.float32),
        "half_width": np.full((1, STATIONS), 1.0 / LENGTH, np.float32),
        "half_height": np.full((1, STATIONS), 3.0 / LENGTH, np.float32),
        "heights": np.full((3, 3), -400.0, np.float32),
        "pillars": np.zeros((0, 4)),
        "rocks": np.zeros((0, 7)),
        "plankton": np.full(ticks, 100, np.int32),
        "tick_s": TICK_S,
        "seed": 1,
        "radius_cm": 500.0,
        "half_width_cm": 800.0,
        "alarmed": 0.5,
        "species_names": ["Fish"],
        "intention_names": INTENTIONS,
        "mental_state_names": ["hunger", "libido", "fear"],
        "courtship_names": COURTSHIP,
        "kind_names": list(KINDS),
    }
    return Record(**(given | changed))


def still(ticks, *places):
    return np.broadcast_to(np.array(places, float), (ticks, len(places), 3))


# Bounds and obstacles


@pytest.mark.parametrize(
    ("place", "clearance", "barrier"),
    [
        ((480.0, 0.0, -200.0), 500.0 - 488.0, "wall"),  # the snout reaches 8 cm ahead
        ((495.0, 0.0, -200.0), -3.0, "wall"),
        ((-490.0, 0.0, -200.0), -2.0, "wall"),  # the tail 12 cm behind
        ((0.0, 0.0, -5.0), 5.0, "surface"),
        ((0.0, 0.0, -403.0), -3.0, "seabed"),
        ((0.0, 70.0, -200.0), 40.0, "pillar"),
        ((0.0, 20.0, -200.0), -10.0, "pillar"),
        ((0.0, 0.0, -140.0), 10.0, "pillar"),  # above its top
        ((30.0, 40.0, -140.0), 17.09, "pillar"),  # beside its top, from the tail at (18, 40)
        ((100.0, -300.0, -390.0), 10.0, "seabed"),
        ((112.0, -260.0, -300.0), 10.0, "rock"),  # abreast of the shorter half axis, 30 cm
        ((150.0, -300.0, -300.0), -22.0, "rock"),  # the tail, inside the longer one, 60 cm
    ],
)
def test_clearance_is_the_least_of_snout_middle_and_tail(place, clearance, barrier):
    record = a_record(
        still(2, place),
        pillars=np.array([[0.0, 0.0, 30.0, -150.0]]),
        rocks=np.array([[100.0, -300.0, -300.0, 30.0, 60.0, 30.0, np.pi / 2]]),
    )
    if barrier in ("wall", "surface", "seabed"):
        record = record._replace(pillars=np.zeros((0, 4)))
        record = record._replace(rocks=np.zeros((0, 7)))
    found, which = measures.clearances(record)
    assert found == pytest.approx(clearance, abs=0.1)
    assert (which == measures.BARRIERS.index(barrier)).all()


def test_the_dead_are_nowhere():
    record = a_record(still(2, (0, 0, 50)), alive=np.zeros((2, 1), bool))
    assert np.isinf(measures.clearances(record)[0]).all()


# Bodies that overlap


@pytest.mark.parametrize(
    ("offset", "turn", "touches"),
    [
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
    ],
)
def test_bodies_overlap_as_ellipses_do(offset, turn, touches):
    there = np.array([0.0, 0.0, -200.0])
    record = a_record(still(2, there, there + offset), np.stack([EAST, turn]))
    assert (measures.overlaps(record) == (2 if touches else 0)).all()


def test_a_bent_body_is_where_it_bends():
    """The tail of the first fish swings 8 cm aside, to where the second one is."""
    there = still(1, (0, 0, -200), (-2, 7, -200))
    straight = a_record(there)
    bent = straight._replace(tail=straight.tail + np.array([[[0, 8, 0], [0, 0, 0]]], np.float32))
    assert not measures.overlaps(straight).any()
    assert measures.overlaps(bent).all()


def test_whom_touching_is_granted():
    there = still(1, (0, 0, -200), (0, 1, -200))
    court = a_record(there, partner=np.array([[1, -1]]))
    hunt = a_record(there, kind=np.array([PREDATOR, PREY]))
    assert (measures.overlaps(court) == 1).all()
    assert (measures.overlaps(hunt) == 1).all()
    dead = a_record(there, alive=np.array([[True, False]]))
    assert not measures.overlaps(dead).any()


def test_overlaps_among_many_are_those_of_each_pair_alone():
    rng = np.random.default_rng(5)
    places = rng.uniform(-30, 30, (1, 24, 3)) - (0, 0, 200)
    turns = rng.normal(size=(24, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    together = measures.overlaps(a_record(places, turns))[0]
    alone = np.zeros(24, int)
    for i in range(24):
        for j in range(i):
            pair = [i, j]
            alone[pair] |= measures.overlaps(a_record(places[:, pair], turns[pair]))[0]
    assert (together == alone).all()
    assert 0 < (together > 0).sum() < 24


# Minds


def test_hunger_is_saturated_after_a_minute_of_it_where_there_is_food():
    ticks = 2000
    mental = np.zeros((ticks, 3, 3), np.float32)
    mental[100:750, 0, HUNGER] = 1.0  # 65 s
    mental[100:650, 1, HUNGER] = 1.0  # 55 s
    mental[:, 2, HUNGER] = 1.0
    record = a_record(still(ticks, *[(0, 0, -9)] * 3), mental_state=mental,
                      kind=np.array([0, 0, PREDATOR]))  # fmt: skip
    found = measures.saturated(record)
    assert found.sum(axis=0).tolist() == [650, 0, 0]
    barren = record._replace(plankton=np.zeros(ticks, np.int32))
    assert not measures.saturated(barren).any()


def test_time_budget_counts_the_living():
    intention = np.array([[EAT, WANDER], [EAT, WANDER], [SCHOOL, WANDER], [SCHOOL, AVOID]])
    alive = np.array([[1, 1], [1, 1], [1, 1], [1, 0]], bool)
    record = a_record(still(4, (0, 0, -9), (0, 0, -9)), intention=intention, alive=alive,
                      species=np.array([0, 1]), species_names=["A", "B"])  # fmt: skip
    budget = measures.time_budget(record)
    assert budget[0, EAT] == budget[0, SCHOOL] == 0.5
    assert budget[1, WANDER] == 1.0
    assert budget.sum(axis=1) == pytest.approx(1.0)


def test_changes_of_intention_per_second():
    intention = np.full((101, 2), WANDER)
    intention[::2, 0] = EAT
    intention[50:, 1] = SCHOOL
    record = a_record(still(101, (0, 0, -9), (0, 0, -9)), intention=intention)
    assert measures.changes_per_second(record) == pytest.approx([10.0, 0.1])


def test_meals_are_new_times_of_the_last_one():
    eaten = np.array([[0, 3], [0, 3], [0.2, 3], [0.2, 3], [0.4, 3]], np.float32)
    record = a_record(still(5, (0, 0, -9), (0, 0, -9)), last_meal=eaten)
    assert measures.meals(record).sum(axis=0).tolist() == [2, 0]


# Schools


def a_school(offsets, ticks=41, intention=None, **changed):
    """Fishes of which the first leads, at `offsets` (n, 3) or (T, n, 3) from the middle, cm."""
    places = np.broadcast_to(np.array(offsets, float), (ticks, *np.shape(offsets)[-2:]))
    n = places.shape[1]
    leader = np.zeros((ticks, n), np.int32)
    leader[:, 0] = -1
    doing = np.full((ticks, n), SCHOOL)
    doing[:, 0] = WANDER
    return a_record(
        places - (0, 0, 200), leader=leader, intention=doing if intention is None else intention,
        **changed,
    )  # fmt: skip


def row(n, apart_bl):
    return np.array([[k * apart_bl * LENGTH, 0, 0] for k in range(n)])


def test_a_school_in_a_row():
    (school,) = measures.schools(a_school(row(5, 1.2)))
    assert school.leader == 0
    assert (school.members == 5).all()
    assert school.cruises.all()
    assert school.polarisation == pytest.approx(1.0)
    assert school.distances == pytest.approx(1.2)
    assert (school.together == 1.0).all()
    assert len(school.time) == 21  # five times a second


def test_polarisation_is_the_length_of_the_mean_heading():
    turns = np.stack([EAST, EAST, NORTH, NORTH])
    (school,) = measures.schools(a_school(row(4, 1.0), orientation=turns))
    assert school.polarisation == pytest.approx(0.5**0.5)


def test_a_body_length_is_that_of_both():
    (school,) = measures.schools(a_school(row(3, 1.0), length=np.array([40.0, 20.0, 20.0])))
    assert school.distances.reshape(-1, 3)[0] == pytest.approx([2 / 3, 2 / 3, 1.0])


def test_who_is_about_something_else_does_not_count():
    places = np.vstack([row(4, 1.0), [[300.0, 0, 0]]])
    doing = np.tile([WANDER, SCHOOL, SCHOOL, SCHOOL, EAT], (41, 1))
    (school,) = measures.schools(a_school(places, intention=doing))
    assert (school.together == 1.0).all()
    assert (school.members == 5).all()
    (school,) = measures.schools(a_school(places))
    assert (school.together == 0.8).all()


def test_an_alarmed_school_does_not_cruise():
    mental = np.zeros((41, 5, 3), np.float32)
    mental[20:, 3, FEAR] = 0.6
    (school,) = measures.schools(a_school(row(5, 1.0), mental_state=mental))
    assert school.cruises.sum() == 10
    assert len(school.distances) == 50


def test_nearest_and_connected_parts_are_those_of_all_pairs():
    rng = np.random.default_rng(2)
    for _ in range(20):
        places = rng.uniform(-150, 150, (12, 3)) * (1, 1, 0.3)
        length = rng.uniform(10, 30, 12)
        (school,) = measures.schools(a_school(places, ticks=1, length=length))
        gap = np.linalg.norm(places[:, None] - places, axis=2)
        gap /= 0.5 * (length[:, None] + length)
        linked = np.linalg.matrix_power((gap <= measures.LINK_BL).astype(float), 12) > 0
        np.fill_diagonal(gap, np.inf)
        assert school.distances == pytest.approx(gap.min(axis=1), rel=1e-5)
        assert school.together == pytest.approx(linked.sum(axis=1).max() / 12)


def test_a_split_lasts_until_nine_tenths_hang_together():
    """Three of ten are far away from 2 s to 6 s, and again at the end."""
    places = np.tile(row(10, 0.5), (101, 1, 1))
    places[20:60, 7:, 1] = 200.0
    places[80:, 7:, 1] = 200.0
    record = a_school(places, ticks=101)
    (school,) = measures.schools(record)
    first, last = measures.splits(school, float(record.time[-1]))
    assert (first.start, first.lasted) == pytest.approx((2.1, 4.0))
    assert first.apart == pytest.approx(0.3)
    assert (first.rejoined, last.rejoined) == (True, False)
    assert last.lasted == pytest.approx(2.0)


def test_one_of_ten_is_no_split():
    places = row(10, 0.5)
    places[9, 1] = 200.0
    (school,) = measures.schools(a_school(places))
    assert measures.splits(school, 4.1) == []


# Fear and captures


def test_escapes_after_fear():
    intention = np.full((60, 2), WANDER)
    intention[20:30, 0] = intention[40:50, 0] = intention[40:50, 1] = ESCAPE
    mental = np.zeros((60, 2, 3), np.float32)
    mental[15:17, 0, FEAR] = 0.8  # 0.5 s before the first; nothing before the others
    mental[25:29, :, FEAR] = 0.8  # 1.1 s before
    record = a_record(still(60, (0, 0, -9), (0, 0, -9)), intention=intention, mental_state=mental)
    assert measures.escapes(record) == (3, 1)


def test_captures_by_company_and_exposure():
    """Four prey abreast, one alone that is caught at 6 s; one of the four is caught at 8 s."""
    places = np.vstack([row(4, 0.8), [[300.0, 0, 0], [0, 300.0, 0]]])
    alive = np.ones((100, 6), bool)
    alive[60:, 4] = False
    alive[80:, 1] = False
    kind = np.array([PREY] * 5 + [PREDATOR])
    record = a_record(still(100, *places - (0, 0, 100)), alive=alive, kind=kind)
    found = measures.captures(record)
    assert found.lost == 2
    assert found.caught == (1, 1)
    assert found.exposed_s == pytest.approx((3 * 10 + 8, 6), abs=0.2)


# Courtship


def courting(states, heading=EAST, ticks=120):
    """A male that goes through `states`, each for two seconds from 1 s on."""
    codes = np.zeros((ticks, 2), int)
    for k, state in enumerate(states):
        codes[10 + 20 * k : 30 + 20 * k, 0] = state
    partner = np.full((ticks, 2), -1)
    partner[30:, 0] = 1
    return a_record(
        still(ticks, (0, 0, -9), (50, 0, -9)), heading, courtship=codes, partner=partner,
        male=np.array([True, False]),
    )  # fmt: skip


def test_a_complete_courtship_has_its_states_in_order():
    states = (APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING)
    (found,) = measures.courtships(courting(states))
    assert found.states == states
    assert found.complete and not found.rejected
    assert (found.male, found.partner) == (0, 1)
    assert (found.start, found.lasted) == pytest.approx((1.1, 10.0))


def test_the_wrong_order_or_no_end_is_not_complete():
    (found,) = measures.courtships(courting((LOOPING, ASCENDING, CIRCLING, NUZZLING)))
    assert not found.complete
    states = (APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING)
    (found,) = measures.courtships(courting(states, ticks=100))
    assert not found.complete and not found.rejected


@pytest.mark.parametrize("turns", [True, False])
def test_a_rejected_male_turns_away(turns):
    heading = np.tile(EAST, (120, 2, 1))
    if turns:
        heading[65:, 0] = NORTH  # 1.5 s after the end
    (found,) = measures.courtships(courting((APPROACHING, LOOPING), heading))
    assert found.rejected
    assert found.turned_away == turns


def test_what_is_shorter_than_a_second_is_no_courtship():
    codes = np.zeros((40, 1), int)
    codes[5:14] = LOOPING
    record = a_record(still(40, (0, 0, -9)), courtship=codes, male=np.array([True]))
    assert measures.courtships(record) == []


@pytest.mark.parametrize(
    ("flags", "expected"),
    [([], []), ([1, 1], [(0, 2)]), ([0, 1, 0, 1, 1], [(1, 2), (3, 5)]), ([0, 0], [])],
)
def test_runs(flags, expected):
    assert list(measures.runs(np.array(flags, bool))) == expected
