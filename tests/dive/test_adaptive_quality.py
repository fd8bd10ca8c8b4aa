"""Automatic quality settles, does not oscillate, and recovers, on synthetic frames."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from subsea.dive.adaptive_quality import (
    BRIEF,
    LONG,
    QUICK,
    TOO_SLOW,
    paced,
    resumed,
    start,
    target_for,
)
from subsea.rendering.output.quality import LADDER, PRESETS
from tests.support.daily import examples

TARGET_MS = 20.0
LOW, HIGH = LADDER.index(PRESETS["low"]), len(LADDER) - 1
ULTRA = 1.02  # its cost over that of the preset before


def costs(low_ms, fixed, medium, high):
    """Frame time at every rung: a fixed share, the rest by pixels; then the presets."""
    scale = np.array([rung.scale for rung in LADDER[: LOW + 1]])
    scaled = low_ms * (fixed + (1 - fixed) * scale**2)
    return np.array([*scaled, *(low_ms * np.cumprod([medium, high, ULTRA]))])


COST = costs(9.0, 0.3, 1.4, 1.5)


def run(pace, cost, frames, seed, noise=0.05, spikes=0.02):
    """The pace after a number of frames, and the rung at each."""
    rng = np.random.default_rng(seed)
    rungs = []
    for _ in range(frames):
        ms = cost[pace.rung] * np.exp(noise * rng.standard_normal())
        if rng.uniform() < spikes:
            ms *= 10.0
        pace = paced(pace, ms, TARGET_MS)
        rungs.append(pace.rung)
    return pace, np.array(rungs)


def turns(rungs):
    """Number of changes of direction among the steps."""
    steps = np.diff(rungs)
    steps = steps[steps != 0]
    return int((np.diff(np.sign(steps)) != 0).sum())


machines = st.builds(
    costs,
    low_ms=st.floats(2.0, 100.0),
    fixed=st.floats(0.1, 0.9),
    medium=st.floats(1.02, 3.0),
    high=st.floats(1.02, 3.0),
)


@pytest.mark.nightly
@given(cost=machines, begin=st.sampled_from([0, LOW, HIGH]), seed=st.integers(0, 2**31))
@example(cost=costs(9.4, 0.5, 2.4, 1.1), begin=LOW, seed=1)  # medium looks affordable, and is not
def test_the_quality_settles_at_the_target(cost, begin, seed):
    pace, rungs = run(start(begin), cost, 4000, seed)
    assert (np.abs(np.diff(rungs)) <= 1).all()
    assert turns(rungs) <= 3
    rest = np.diff(rungs[-1500:])
    assert np.abs(rest).sum() <= 1  # exactly at the limit noise may still cause one step down
    assert cost[pace.rung] < (TOO_SLOW + 0.05) * TARGET_MS or pace.rung == 0
    if pace.rung < HIGH:  # the frame time left no room
        assert cost[pace.rung] * max(pace.ratios[pace.rung], 1.0) > (QUICK - 0.06) * TARGET_MS


@pytest.mark.nightly
@settings(max_examples=examples(8))
@given(cost=machines, seed=st.integers(0, 2**31))
@example(cost=costs(20.0, 0.625, 2.0, 2.0), seed=0)  # the next rung looks unaffordable, and is not
def test_the_quality_recovers_after_a_load(cost, seed):
    before, _ = run(start(LOW), cost, 2000, seed)
    loaded, _ = run(before, 3.0 * cost, 1500, seed + 1)
    assert loaded.rung <= before.rung
    after, rungs = run(loaded, cost, 6000, seed + 2)
    assert turns(rungs) <= 3
    # Unless the next rung is expected to leave no room.
    expected = cost[after.rung] * max(after.ratios[min(after.rung, HIGH - 1)], 1.0)
    assert after.rung >= before.rung or expected > (QUICK - 0.06) * TARGET_MS


def test_the_quality_recovers_fully_if_the_target_allows():
    cost = COST
    before, _ = run(start(LOW), cost, 2000, 1)
    loaded, _ = run(before, 4.0 * cost, 1500, 2)
    after, _ = run(loaded, cost, 6000, 3)
    assert (before.rung, after.rung) == (LOW + 1, LOW + 1)
    assert loaded.rung < LOW


def test_a_load_does_not_delay_a_rung_that_was_fast_enough():
    """It is tried again without extra delay, since it was not itself too slow."""
    risen, rungs = run(start(LOW), COST, 2000, 1, noise=0.0, spikes=0.0)
    assert rungs[-1] == LOW + 1
    loaded, _ = run(risen, 2.5 * COST, 60, 2, noise=0.0, spikes=0.0)
    assert loaded.rung < risen.rung
    assert loaded.patience == risen.patience


def test_other_frames_do_not_count():
    pace, _ = run(start(LOW), COST, 50, 1)
    again = resumed(pace)
    assert (again.rung, again.ratios, again.patience) == (pace.rung, pace.ratios, pace.patience)
    for _ in range(BRIEF):  # still settling, and too few for a median
        again = paced(again, 5 * TARGET_MS, TARGET_MS)
    assert again.rung == pace.rung


def test_an_oscillating_load_causes_ever_fewer_steps():
    cost = costs(7.0, 0.3, 1.5, 1.8)
    pace, steps = start(HIGH), []
    for k in range(60):
        pace, rungs = run(pace, cost * (1.0 if k % 2 else 1.5), 400, k)
        steps.append(np.abs(np.diff(rungs)).sum())
    assert sum(steps[-20:]) < sum(steps[:20]) / 2 or sum(steps) <= 4


@pytest.mark.parametrize("rung", [0, LOW, HIGH])
def test_one_long_frame_changes_nothing(rung):
    pace = start(rung)
    for k in range(5 * LONG):
        pace = paced(pace, 0.95 * TARGET_MS if k % BRIEF else 5000.0, TARGET_MS)
        assert pace.rung == rung


def test_slow_frames_lead_down_to_the_lowest_rung():
    pace = start(HIGH)
    for _ in range(30):
        pace = paced(pace, 3 * TARGET_MS, TARGET_MS)
    assert pace.rung == HIGH - 1
    for _ in range(1000):
        pace = paced(pace, 3 * TARGET_MS, TARGET_MS)
    assert pace.rung == 0


def test_the_target_follows_the_renderer():
    assert target_for("llvmpipe (LLVM 15.0.6, 256 bits)") == 50.0
    assert target_for("AMD Radeon RX 6600") == pytest.approx(1000 / 60)


def test_an_exact_canvas_uses_only_presets():
    for exact in (True, False):
        pace = start(LOW, exact)
        for _ in range(400):
            pace = paced(pace, 900.0, 50.0)
        assert (pace.rung == LOW) == exact
