"""The hierarchy of desires, memory, inhibition and fatigue, on desires set by hand."""

import numpy as np
import pytest

from subsea.behavior.intention import DWELL_S, MEMORY_S, choose_intention, tiredness
from subsea.behavior.table import BEHAVIORS, TABLE, desires_of
from subsea.state import AVOID, EAT, ESCAPE, LEAVE, MATE, SCHOOL, WANDER

ONE = np.zeros(1, np.int64)


def _row(code, level=None):
    for row, (its_level, behavior, _) in enumerate(desires_of(BEHAVIORS)):
        if behavior == code and level in (None, its_level):
            return row
    raise AssertionError("no such desire")


@pytest.fixture
def mind(tank):
    """Function `choose(desires by code, seconds)` of one fish, and its mind."""
    t = tank()

    def decide(desires, seconds=0.033):
        t.minds.desire[:] = 0.0
        t.minds.desire[_row(WANDER)] = 0.01
        for key, value in desires.items():
            t.minds.desire[_row(*key) if isinstance(key, tuple) else _row(key)] = value
        t.minds.pause[:] = seconds
        choose_intention(ONE, t.minds, t.nature, TABLE.level, TABLE.behavior, TABLE.tires)
        return int(t.minds.intention[0])

    return decide, t.minds


def test_the_codes_are_the_rows_of_the_table():
    names = ("avoid", "escape", "school", "eat", "mate", "leave", "wander")
    assert tuple(b.name for b in BEHAVIORS)[:7] == names
    assert tuple(range(7)) == (AVOID, ESCAPE, SCHOOL, EAT, MATE, LEAVE, WANDER)
    assert (np.diff(TABLE.level) >= 0).all()


@pytest.mark.parametrize(
    ("desires", "wins"),
    [
        ({}, WANDER),
        ({LEAVE: 0.015}, LEAVE),
        ({(SCHOOL, 3): 0.02, LEAVE: 0.015}, SCHOOL),
        ({EAT: 0.3, (SCHOOL, 3): 0.02}, EAT),
        ({EAT: 0.3, MATE: 0.5}, MATE),
        ({EAT: 0.2}, WANDER),  # not more than r
        ({ESCAPE: 0.6, EAT: 1.0}, ESCAPE),
        ({(SCHOOL, 1): 0.6, EAT: 1.0}, SCHOOL),
        ({AVOID: 1.0, ESCAPE: 1.0, EAT: 1.0}, AVOID),
    ],
)
def test_the_hierarchy(mind, desires, wins):
    decide, _ = mind
    assert decide(desires) == wins


def test_of_equal_desires_the_one_that_is_followed_stays(mind):
    decide, _ = mind
    for code, other in ((EAT, MATE), (MATE, EAT)):
        assert decide({code: 0.5}, DWELL_S) == code
        assert decide({code: 0.4, other: 0.4}, DWELL_S) == code


def test_an_interrupted_intention_is_resumed_with_its_target(mind):
    decide, minds = mind
    decide({MATE: 0.5})
    minds.target[0] = 17
    assert decide({AVOID: 1.0, MATE: 0.5}) == AVOID
    minds.target[0] = 3
    assert decide({MATE: 0.4, EAT: 0.45}, DWELL_S) == MATE
    assert minds.target[0] == 17
    assert minds.resumed[0]


def test_a_resumed_intention_inhibits_its_rivals_by_a_fifth_of_itself(mind):
    decide, _ = mind
    decide({MATE: 0.5})
    # Before any interruption it has no such advantage.
    assert decide({MATE: 0.5, EAT: 0.55}, DWELL_S) == EAT
    decide({MATE: 0.5}, DWELL_S)
    decide({AVOID: 1.0, MATE: 0.5})
    assert decide({MATE: 0.5}, DWELL_S) == MATE
    assert decide({MATE: 0.5, EAT: 0.59}, DWELL_S) == MATE
    assert decide({MATE: 0.5, EAT: 0.62}) == EAT


def test_an_intention_without_desire_is_not_resumed(mind):
    decide, minds = mind
    decide({EAT: 0.5})
    decide({ESCAPE: 0.9})
    assert decide({}, DWELL_S) == WANDER
    assert minds.memory[0] == -1
    assert not minds.resumed[0]


def test_memory_is_short(mind):
    decide, _ = mind
    decide({MATE: 0.5})
    for _ in range(3):
        decide({ESCAPE: 0.9}, seconds=MEMORY_S)
    assert decide({MATE: 0.4, EAT: 0.45}, DWELL_S) == EAT


def test_a_desire_tires_and_recovers(mind, tank):
    decide, minds = mind
    np.testing.assert_allclose([tiredness(0, 40), tiredness(40, 40)], [1.0, 0.5])
    fatigue = tank().nature.fatigue_s
    decide({EAT: 0.5})
    assert decide({EAT: 0.6, MATE: 0.4}, fatigue / 4) == EAT
    # Halved after `fatigue_s`.
    assert decide({EAT: 0.6, MATE: 0.4}, fatigue) == MATE
    assert decide({EAT: 0.26, MATE: 0.0}, DWELL_S) == WANDER
    assert decide({EAT: 0.26}, 2 * fatigue) == EAT
    assert minds.fatigue[EAT, 0] == 0.0


def test_time_in_an_intention_is_counted(mind):
    decide, minds = mind
    decide({EAT: 0.5})
    decide({EAT: 0.5}, 1.5)
    decide({EAT: 0.5}, 1.0)
    assert minds.busy[0] == pytest.approx(2.5)
    decide({AVOID: 1.0})
    assert minds.busy[0] == 0.0


def test_a_reaction_lasts_a_while_unless_a_more_urgent_one_interrupts(mind):
    decide, _ = mind
    assert decide({ESCAPE: 0.9}) == ESCAPE
    assert decide({}) == ESCAPE
    assert decide({AVOID: 1.0}) == AVOID
    assert decide({ESCAPE: 0.9}) == ESCAPE  # its cause has gone: another one comes first
    assert decide({}, 0.9 * DWELL_S) == ESCAPE
    assert decide({ESCAPE: 0.9}) == ESCAPE  # its cause is there again
    assert decide({}, 0.5 * DWELL_S) == ESCAPE
    assert decide({EAT: 0.9}, 0.6 * DWELL_S) == EAT


def test_an_intention_that_has_begun_is_seen_through(mind):
    """Desires that change from one turn to the next do not make a fish dither."""
    decide, _ = mind
    assert decide({EAT: 0.5}) == EAT
    for desires in ({MATE: 0.9}, {}, {(SCHOOL, 3): 0.02}, {MATE: 0.6}):
        assert decide(desires, 0.2 * DWELL_S) == EAT
    assert decide({MATE: 0.6}, 0.3 * DWELL_S) == MATE
    assert decide({MATE: 0.6, (SCHOOL, 1): 0.6}) == SCHOOL  # but danger interrupts
