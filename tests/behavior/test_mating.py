"""Choice of a mate, rivalry, and the end of courtships."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.behavior import courtship, mating
from subsea.behavior.courtship import ALONE_S, LIMIT_S, POINTS, preferred
from subsea.behavior.nuzzling import NUDGES
from subsea.behavior.spawning import RUSH_S
from subsea.state import (
    APPROACHING,
    ASCENDING,
    AVOID,
    CIRCLING,
    EAT,
    LIBIDO,
    LOOPING,
    MATE,
    NO_COURTSHIP,
    NOBODY,
    NUZZLING,
    PREDATOR,
    PREY,
    SPAWNING,
)

FEMALE = 0


def _bay(tank, n=2, **nature):
    """Fish 0 is a female that heads along x; the others are males, 60 cm and more before her."""
    t = tank(n, **nature)
    t.minds.male[1:] = True
    t.minds.intention[:] = MATE
    t.minds.mental[:, LIBIDO] = 0.9
    for i in range(1, n):
        t.fishes.position[i] = 60.0 * i, 10.0 * i, -300.0
    t.minds.target[1:] = FEMALE
    t.minds.target[FEMALE] = 1
    t.minds.last_mating[:] = -1e3
    t.minds.mate[1:] = FEMALE
    t.minds.mate[FEMALE] = 1
    return t


def _pair(t, i, state):
    """Put fishes 0 and i in this state of their courtship."""
    for one, other in ((FEMALE, i), (i, FEMALE)):
        t.minds.partner[one], t.minds.courtship[one] = other, state


def _review(t, seconds=0.033):
    t.minds.pause[:] = seconds
    mating.end_courtships(np.arange(len(t.fishes.species)), t.fishes, t.minds)


def _free(t, *who):
    return all(t.minds.partner[i] == NOBODY and t.minds.courtship[i] == NO_COURTSHIP for i in who)


def test_desire_is_libido_above_the_threshold_of_pacifists_with_somebody_to_court(tank):
    t = _bay(tank, 7).at(3000)
    t.minds.mental[:, LIBIDO] = 0.6, 0.2, 0.6, 0.6, 0.6, 0.6, 0.6
    t.minds.last_mating[6] = 3000 * 0.033 - mating.REST_S + 1.0
    t.minds.kind[2], t.minds.kind[3] = PREY, PREDATOR
    t.minds.mate[4] = NOBODY
    t.minds.shunned[5] = FEMALE
    np.testing.assert_allclose(t.desire(mating.desire), [0.6, 0, 0, 0, 0, 0, 0])


def test_a_courting_fish_goes_on_with_less_libido_and_no_mate_in_sight(tank):
    t = _bay(tank)
    _pair(t, 1, CIRCLING)
    t.minds.mate[:] = NOBODY
    t.minds.mental[:, LIBIDO] = 0.2, 0.1
    desire = t.desire(mating.desire)
    assert desire[0] > t.nature.keen
    assert desire[1] == 0


def test_a_pair_that_spawns_sees_it_through(tank):
    t = _bay(tank)
    t.minds.mental[:, LIBIDO] = 0.0
    _pair(t, 1, SPAWNING)
    assert t.desire(mating.desire).tolist() == [1.0, 1.0]


def test_a_male_takes_up_with_his_target_and_swims_to_her(tank):
    t = _bay(tank)
    t.run(mating.act)
    assert t.minds.partner[1] == FEMALE
    assert t.minds.courtship[1] == APPROACHING
    toward = courtship.stage(t.fishes, 1, FEMALE) - t.fishes.position[1]
    assert t.minds.urge[1] @ toward > 0
    assert t.minds.partner[FEMALE] == NOBODY, "he has not shown off yet"


@pytest.mark.parametrize("why", ["dead", "male", "shunned", "prey", "taken", "nobody"])
def test_unsuitable_fishes_are_not_courted(tank, why):
    t = _bay(tank, 3)
    if why == "dead":
        t.fishes.alive[FEMALE] = False
    elif why == "male":
        t.minds.male[FEMALE] = True
    elif why == "shunned":
        t.minds.shunned[1] = FEMALE
    elif why == "taken":
        t.minds.partner[FEMALE], t.minds.courtship[FEMALE] = 2, CIRCLING
    elif why == "prey":
        t.minds.kind[FEMALE] = PREY
    else:
        t.minds.target[1] = NOBODY
    t.run(mating.act, 1)
    assert _free(t, 1)
    assert np.isfinite(t.minds.urge[1]).all()


def test_a_female_that_does_not_mate_is_followed_and_then_left(tank):
    t = _bay(tank)
    t.minds.intention[FEMALE] = EAT
    t.fishes.position[1] = t.fishes.position[FEMALE] + (30.0, 0.0, 0.0)
    t.run(mating.act, 1)
    assert t.minds.courtship[1] == APPROACHING, "near enough, but she would not look"
    assert t.minds.urge[1, 0] < 0
    assert t.fishes.goal_speed[1] < 0.5
    for _ in range(int(ALONE_S[APPROACHING])):
        assert t.minds.partner[1] == FEMALE
        _review(t, 1.0)
    _review(t, 1.0)
    assert _free(t, 1)
    assert t.minds.shunned[1] == FEMALE


def test_a_female_follows_only_a_male_that_does_not_mate(tank):
    t = _bay(tank)
    t.minds.intention[1] = EAT
    t.run(mating.act, FEMALE)
    assert t.minds.urge[FEMALE] @ (t.fishes.position[1] - t.fishes.position[FEMALE]) > 0
    t.minds.intention[1] = MATE
    t.minds.waypoint[FEMALE] = -500.0, 0.0, -300.0
    t.minds.patience[:] = 10.0
    t.run(mating.act, FEMALE)
    assert t.minds.urge[FEMALE, 0] < 0, "she goes her way: it is for him to come"


@given(
    own=st.tuples(st.booleans(), st.booleans()),
    sizes=st.tuples(st.floats(5.0, 50.0), st.floats(5.0, 50.0)),
)
def test_a_female_prefers_her_species_then_size(tank, own, sizes):
    t = _bay(tank, 3)
    t.fishes.species[1:] = [0 if same else 1 for same in own]
    t.fishes.length[1:] = sizes
    better = preferred(t.fishes, FEMALE, 1, np.int32(2))
    if own[0] != own[1]:
        assert better == own[0]
    else:
        assert better == (sizes[0] > 1.05 * np.float32(sizes[1]))
    assert not (better and preferred(t.fishes, FEMALE, 2, np.int32(1)))


def test_before_her_head_he_begins_to_loop_and_she_looks_on(tank):
    t = _bay(tank)
    t.fishes.position[1] = 35.0, 0.0, -295.0
    t.run(mating.act)
    assert t.minds.courtship[1] == LOOPING
    t.run(mating.act)
    assert (t.minds.courtship == LOOPING).all()
    assert t.minds.partner[FEMALE] == 1
    t.run(mating.act)
    assert t.fishes.goal_speed[FEMALE] == 0.0, "she hovers"


def test_she_bobs_her_head_and_keeps_her_heading(tank):
    t = _bay(tank)
    _pair(t, 1, LOOPING)
    slopes = []
    for tick in range(200):
        t.at(tick).run(mating.act)
        urge = t.minds.urge[FEMALE]
        assert np.arctan2(urge[1], urge[0]) == pytest.approx(0.0, abs=1e-6)
        slopes.append(urge[2] / np.hypot(urge[0], urge[1]))
    assert min(slopes) < -0.3
    assert max(slopes) > 0.3


def test_a_larger_rival_wins_her_and_the_first_turns_away(tank):
    t = _bay(tank, 3)
    t.fishes.length[1:] = 18.0, 24.0
    _pair(t, 1, LOOPING)
    t.minds.partner[2], t.minds.courtship[2] = FEMALE, LOOPING
    t.run(mating.act)
    assert t.minds.partner[FEMALE] == 1, "the rival has not impressed her yet"
    t.minds.courtship_count[2] = 1
    t.run(mating.act)
    assert t.minds.partner[FEMALE] == 2
    for _ in range(int(ALONE_S[LOOPING]) + 1):
        assert t.minds.partner[1] == FEMALE, "he goes on looping for a while"
        _review(t, 1.0)
    assert _free(t, 1)
    assert t.minds.shunned[1] == FEMALE
    away = t.fishes.position[1] - t.fishes.position[FEMALE]
    assert (t.minds.waypoint[1] - t.fishes.position[1]) @ away > 0
    assert t.minds.partner[2] == FEMALE
    assert t.minds.partner[FEMALE] == 2


def test_a_smaller_rival_or_one_that_comes_too_late_does_not_win_her(tank):
    for state, lengths in ((LOOPING, (24.0, 18.0)), (CIRCLING, (18.0, 24.0))):
        t = _bay(tank, 3)
        t.fishes.length[1:] = lengths
        _pair(t, 1, state)
        t.minds.partner[2], t.minds.courtship[2], t.minds.courtship_count[2] = FEMALE, LOOPING, 9
        for _ in range(3 if state == LOOPING else 1):
            t.run(mating.act)
        assert t.minds.partner[FEMALE] == 1
        assert t.minds.courtship[2] == LOOPING, "only the favoured male circles"
    _review(t)
    assert _free(t, 2)
    assert t.minds.partner[1] == FEMALE


def test_shunning_ends_after_a_while(tank):
    t = _bay(tank)
    t.minds.shunned[1], t.minds.shunning[1] = FEMALE, mating.SHUN_S
    _review(t, mating.SHUN_S - 1.0)
    assert t.minds.shunned[1] == FEMALE
    _review(t, 2.0)
    assert t.minds.shunned[1] == NOBODY
    t.run(mating.act, 1)
    assert t.minds.partner[1] == FEMALE


@pytest.mark.parametrize("state", [LOOPING, CIRCLING, ASCENDING, NUZZLING, SPAWNING])
@pytest.mark.parametrize("why", ["death", "lost", "hunger", "too long", "turned away"])
def test_no_pair_is_left_dangling_or_stuck(tank, state, why):
    t = _bay(tank)
    _pair(t, 1, state)
    if why == "death":
        t.fishes.alive[1] = False
    elif why == "lost":
        t.fishes.position[1] = 400.0, 0.0, -300.0
    elif why == "hunger":
        t.minds.intention[1] = EAT
    elif why == "too long":
        t.minds.courtship_time[:] = LIMIT_S[state]
    else:
        t.minds.partner[1], t.minds.courtship[1] = NOBODY, NO_COURTSHIP
    # Only the female thinks; the courtship must end without the male.
    for _ in range(int(ALONE_S[state]) + 2):
        t.minds.pause[:] = 1.0
        mating.end_courtships(np.array([FEMALE]), t.fishes, t.minds)
    assert _free(t, FEMALE, 1)
    assert t.minds.shunned[FEMALE] == 1


def test_a_short_interruption_does_not_end_a_courtship(tank):
    t = _bay(tank)
    _pair(t, 1, CIRCLING)
    t.minds.intention[1] = AVOID
    for _ in range(5):
        _review(t, 1.0)
    t.minds.intention[1] = MATE
    _review(t, 1.0)
    assert t.minds.alone[1] == t.minds.alone[FEMALE] == 0
    assert t.minds.partner[1] == FEMALE
    assert t.minds.courtship[FEMALE] == CIRCLING


def test_after_the_last_nudge_both_rush_up_side_by_side(tank):
    t = _bay(tank)
    t.fishes.position[1] = 0.0, 5.0, -300.0
    _pair(t, 1, NUZZLING)
    t.minds.courtship_count[1] = NUDGES
    t.run(mating.act)
    assert (t.minds.courtship == SPAWNING).all()
    t.run(mating.act)
    for urge in t.minds.urge:
        assert urge[2] > 0.7 * np.linalg.norm(urge)
    np.testing.assert_allclose(t.minds.urge[1], t.minds.urge[FEMALE])
    assert (t.fishes.goal_speed >= 1.0).all()
    t.fishes.position[1] = 30.0, 5.0, -300.0
    t.run(mating.act)
    assert t.fishes.goal_speed[1] < 0.7, "the one ahead waits"


def test_after_the_rush_both_have_mated_part_and_return_to_the_depth(tank):
    t = _bay(tank).at(3000)
    _pair(t, 1, SPAWNING)
    t.minds.courtship_time[:] = RUSH_S + 0.1
    t.minds.courtship_mark[:] = -340.0
    t.minds.ardent[:] = True
    t.run(mating.act)
    assert not t.minds.ardent.any()
    assert (t.minds.waypoint[:, 2] < -340.0).all()
    assert _free(t, FEMALE, 1)
    np.testing.assert_allclose(t.minds.last_mating, 3000 * 0.033, rtol=1e-6)
    assert t.minds.shunned.tolist() == [1, FEMALE]
    gap = t.fishes.position[1] - t.fishes.position[FEMALE]
    assert (t.minds.waypoint[1] - t.minds.waypoint[FEMALE]) @ gap > 0


def test_progress_takes_fatigue_away(tank):
    t = _bay(tank)
    _pair(t, 1, LOOPING)
    t.minds.fatigue[MATE] = 30.0
    t.minds.courtship_count[1] = POINTS
    t.run(mating.act)
    assert (t.minds.courtship == CIRCLING).all()
    assert (t.minds.fatigue[MATE] == 0).all()
