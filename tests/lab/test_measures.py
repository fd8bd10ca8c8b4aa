"""Measures of records: bounds, overlaps, minds, attacks and courtships."""

import numpy as np
import pytest

from subsea.habitat.contact import clearances as solid_clearances
from subsea.lab.measures import (
    BARRIERS,
    PERIOD_S,
    captures,
    changes_per_second,
    clearances,
    courtships,
    escapes,
    joined,
    meals,
    outside,
    overlaps,
    predation,
    runs,
    saturated,
    time_budget,
)
from subsea.state import (
    APPROACHING,
    ASCENDING,
    AVOID,
    CIRCLING,
    EAT,
    ESCAPE,
    FEAR,
    HUNGER,
    LOOPING,
    NUZZLING,
    PREDATOR,
    PREY,
    SCHOOL,
    SPAWNING,
    WANDER,
)
from tests.support.records import EAST, LENGTH, NORTH, TICK_S, a_record, row, still


def test_runs_are_the_stretches_of_true_flags():
    assert list(runs(np.array([], bool))) == []
    assert list(runs(np.array([1, 1], bool))) == [(0, 2)]
    assert list(runs(np.array([0, 1, 0, 1, 1], bool))) == [(1, 2), (3, 5)]
    assert list(runs(np.array([0, 0], bool))) == []


PILLARS = np.array([[0.0, 0.0, 30.0, -150.0]])
ROCKS = np.array([[100.0, -300.0, -300.0, 30.0, 60.0, 30.0, np.pi / 2]])
NONE = {"pillars": np.zeros((0, 4)), "rocks": np.zeros((0, 7))}


PLACES = [
    ((480.0, 0.0, -200.0), 500.0 - 488.0, "wall"),  # the snout reaches 8 cm ahead
    ((495.0, 0.0, -200.0), -3.0, "wall"),
    ((-490.0, 0.0, -200.0), -2.0, "wall"),  # the tail 12 cm behind
    ((0.0, 0.0, -5.0), 5.0, "surface"),
    ((0.0, 0.0, -403.0), -3.0, "seabed"),
    ((100.0, -300.0, -390.0), 10.0, "seabed"),
    ((0.0, 70.0, -200.0), 40.0, "pillar"),
    ((0.0, 20.0, -200.0), -10.0, "pillar"),
    ((0.0, 0.0, -140.0), 10.0, "pillar"),  # above its top
    ((30.0, 40.0, -140.0), 17.09, "pillar"),  # beside its top, from the tail at (18, 40)
    ((112.0, -260.0, -300.0), 10.0, "rock"),  # abreast of the shorter half axis, 30 cm
    ((150.0, -300.0, -300.0), -22.0, "rock"),  # the tail, inside the longer one, 60 cm
]


def test_clearance_is_the_least_of_snout_middle_and_tail():
    for place, clearance, barrier in PLACES:
        solids = {"pillars": PILLARS, "rocks": ROCKS} if barrier in ("pillar", "rock") else NONE
        found, which = clearances(a_record(still(2, place), **solids))
        assert found == pytest.approx(clearance, abs=0.1), place
        assert (which == BARRIERS.index(barrier)).all(), place


def test_a_study_measures_the_distances_that_fishes_perceive():
    """Also for oblique points, where a rock's distance has several approximations."""
    rng = np.random.default_rng(3)
    places = rng.uniform((40.0, -380.0, -380.0), (160.0, -220.0, -220.0), (40, 3))
    record = a_record(places[None], rocks=ROCKS)
    found, which = clearances(record)
    bodies = np.stack([record.snout[0], record.position[0], record.tail[0]], axis=1).astype(float)
    no_pillars = np.zeros((0, 4))
    perceived = np.array([solid_clearances(no_pillars, ROCKS, body).min() for body in bodies])
    rock = which[0] == BARRIERS.index("rock")
    assert rock.sum() > 20
    assert found[0, rock] == pytest.approx(perceived[rock], abs=1e-3)
    assert (perceived[~rock] >= found[0, ~rock]).all()


def test_dead_fishes_have_no_clearance():
    record = a_record(still(2, (0, 0, 50)), alive=np.zeros((2, 1), bool))
    assert np.isinf(clearances(record)[0]).all()


def test_the_snout_outside_the_wall_counts():
    """The snout reaches 8 cm ahead of a fish that crosses the wall for three of ten ticks."""
    x = np.full((10, 2), 400.0)
    x[4:7, 1] = 497.0
    place = np.stack([x, 0 * x, 0 * x - 200.0], axis=2)
    species = np.array([0, 1], np.uint8)
    names = {"species": species, "species_names": ["a", "b"]}
    first, second = outside(a_record(place, **names))
    assert (first.outside, first.deepest_cm, first.longest_s) == (0, 0.0, 0.0)
    assert (second.species, second.fish_ticks, second.outside) == ("b", 10, 3)
    assert second.deepest_cm == pytest.approx(5.0, abs=0.01)
    assert (second.barrier, second.longest_s) == ("wall", pytest.approx(3 * TICK_S))


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
    places = rng.uniform(-24, 24, (1, 12, 3)) - (0, 0, 200)
    turns = rng.normal(size=(12, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    together = overlaps(a_record(places, turns))[0]
    alone = np.zeros(12, int)
    for i in range(12):
        for j in range(i):
            pair = [i, j]
            alone[pair] |= overlaps(a_record(places[:, pair], turns[pair]))[0]
    assert (together == alone).all()
    assert 0 < (together > 0).sum() < 12


def test_hunger_is_saturated_after_a_minute_if_there_is_food():
    ticks = 2000
    mental = np.zeros((ticks, 3, 3), np.float32)
    mental[100:750, 0, HUNGER] = 1.0  # 65 s
    mental[100:650, 1, HUNGER] = 1.0  # 55 s
    mental[:, 2, HUNGER] = 1.0
    record = a_record(still(ticks, *[(0, 0, -9)] * 3), mental_state=mental,
                      kind=np.array([0, 0, PREDATOR]))  # fmt: skip
    found = saturated(record)
    assert found.sum(axis=0).tolist() == [650, 0, 0]
    barren = record._replace(plankton=np.zeros(ticks, np.int32))
    assert not saturated(barren).any()


def test_time_budget_counts_the_living():
    intention = np.array([[EAT, WANDER], [EAT, WANDER], [SCHOOL, WANDER], [SCHOOL, AVOID]])
    alive = np.array([[1, 1], [1, 1], [1, 1], [1, 0]], bool)
    record = a_record(still(4, (0, 0, -9), (0, 0, -9)), intention=intention, alive=alive,
                      species=np.array([0, 1]), species_names=["A", "B"])  # fmt: skip
    budget = time_budget(record)
    assert budget[0, EAT] == budget[0, SCHOOL] == 0.5
    assert budget[1, WANDER] == 1.0
    assert budget.sum(axis=1) == pytest.approx(1.0)


def test_changes_of_intention_per_second():
    intention = np.full((101, 2), WANDER)
    intention[::2, 0] = EAT
    intention[50:, 1] = SCHOOL
    record = a_record(still(101, (0, 0, -9), (0, 0, -9)), intention=intention)
    assert changes_per_second(record) == pytest.approx([10.0, 0.1])


def test_meals_are_new_times_of_the_last_one():
    eaten = np.array([[0, 3], [0, 3], [0.2, 3], [0.2, 3], [0.4, 3]], np.float32)
    record = a_record(still(5, (0, 0, -9), (0, 0, -9)), last_meal=eaten)
    assert meals(record).sum(axis=0).tolist() == [2, 0]
    held = record.time[:, None] - [6.0, 0.0]  # by a direction; a meal in each tick
    assert meals(record._replace(last_meal=held)).sum(axis=0).tolist() == [0, 4]


def test_escapes_after_fear():
    intention = np.full((60, 2), WANDER)
    intention[20:30, 0] = intention[40:50, 0] = intention[40:50, 1] = ESCAPE
    mental = np.zeros((60, 2, 3), np.float32)
    mental[15:17, 0, FEAR] = 0.8  # 0.5 s before the first; nothing before the others
    mental[25:29, :, FEAR] = 0.8  # 1.1 s before
    record = a_record(still(60, (0, 0, -9), (0, 0, -9)), intention=intention, mental_state=mental)
    assert escapes(record) == (3, 1)


def test_captures_by_company_and_exposure():
    """Four prey abreast, one alone that is caught at 6 s; one of the four is caught at 8 s."""
    places = np.vstack([row(4, 0.8), [[300.0, 0, 0], [0, 300.0, 0]]])
    alive = np.ones((100, 6), bool)
    alive[60:, 4] = False
    alive[80:, 1] = False
    kind = np.array([PREY] * 5 + [PREDATOR])
    record = a_record(still(100, *places - (0, 0, 100)), alive=alive, kind=kind)
    found = captures(record)
    assert found.lost == 2
    assert found.caught == (1, 1)
    assert found.exposed_s == pytest.approx((3 * 10 + 8, 6), abs=0.2)


def a_hunt(gap, dies=None, target=1, ticks=200):
    """A predator with its prey `gap` (ticks,) lengths before its snout."""
    places = np.array(still(ticks, [0, 0, -200.0], [0, 0, -200.0], [0, 300.0, -200.0]))
    places[:, 1, 0] = LENGTH * (0.4 + np.asarray(gap))
    alive = np.ones((ticks, 3), bool)
    if dies is not None:
        alive[dies:, 1] = False
    doing = np.full((ticks, 3), WANDER)
    doing[:, 0] = EAT
    return a_record(
        places, alive=alive, intention=doing, kind=np.array([PREDATOR, PREY, PREY], np.uint8),
        target=np.full((ticks, 3), target),
    )  # fmt: skip


def approaches(*times, ticks=200):
    """Gaps of 5 lengths that fall to half a length for a second at each time, s."""
    time = TICK_S * np.arange(ticks)
    return np.where(np.any([(time >= t) & (time < t + 1) for t in times], axis=0), 0.5, 5.0)


def test_attacks_close_together_are_one():
    assert predation(a_hunt(approaches(2, 10, 15))).attacks == 3
    assert predation(a_hunt(approaches(2, 4.5, 15))).attacks == 2
    assert predation(a_hunt(approaches(2), target=2)).attacks == 0
    assert predation(a_hunt(approaches(2), target=-1)).attacks == 0


def test_prey_that_dies_in_an_attack_was_caught():
    found = predation(a_hunt(approaches(2, 10), dies=108))
    assert (found.attacks, found.captures) == (2, 1)
    seconds = 200 * TICK_S
    assert (found.catches, found.seconds) == ([1], pytest.approx(seconds))
    assert found.rates() == [pytest.approx(PERIOD_S / seconds, abs=0.05)]
    found = predation(a_hunt(approaches(2, 10), dies=70))  # 4 s after the attack
    assert (found.captures, len(found.catches)) == (0, 1)


def test_a_sea_without_predators_has_no_attacks():
    found = predation(a_record(still(20, [0, 0, -200.0])))
    assert found == (0, 0, [], pytest.approx(20 * TICK_S))


def test_parts_of_a_dive_count_as_one():
    """Catches add up, and only those of the first three minutes count."""
    part = predation(a_hunt(approaches(2, 10), dies=108))
    record = a_hunt(approaches(2, 10), dies=108)
    late = predation(record._replace(time=record.time + PERIOD_S))
    assert (late.captures, late.catches) == (1, [0])
    whole = joined([part, part, late])
    assert (whole.attacks, whole.captures, whole.catches) == (6, 3, [2])
    assert whole.seconds == pytest.approx(3 * part.seconds)


COMPLETE = (APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING, SPAWNING)


def courting(states, heading=EAST, ticks=140):
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
    (found,) = courtships(courting(COMPLETE))
    assert found.states == COMPLETE
    assert found.complete and not found.rejected
    assert (found.male, found.partner) == (0, 1)
    assert (found.start, found.duration) == pytest.approx((1.1, 12.0))


def test_the_wrong_order_or_no_end_is_not_complete():
    (found,) = courtships(courting((LOOPING, ASCENDING, CIRCLING, NUZZLING, SPAWNING)))
    assert not found.complete
    (found,) = courtships(courting(COMPLETE, ticks=120))
    assert not found.complete and not found.rejected


@pytest.mark.parametrize("turns", [True, False])
def test_a_rejected_male_turns_away(turns):
    heading = np.tile(EAST, (140, 2, 1))
    if turns:
        heading[65:, 0] = NORTH  # 1.5 s after the end
    (found,) = courtships(courting((APPROACHING, LOOPING), heading))
    assert found.rejected
    assert found.turned_away == turns


def test_shorter_courtships_do_not_count():
    codes = np.zeros((40, 1), int)
    codes[5:14] = LOOPING
    record = a_record(still(40, (0, 0, -9)), courtship=codes, male=np.array([True]))
    assert courtships(record) == []
