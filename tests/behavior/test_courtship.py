"""Courtship: its component behaviors, and whole sequences with swimming fishes."""

from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

from subsea.behavior.chasing import mouth_of
from subsea.behavior.courtship import POINTS, RISE_BL, TURNS
from subsea.behavior.laying import LAYS_S, nest_of
from subsea.behavior.manoeuvring import abdomen_of
from subsea.behavior.nuzzling import NUDGES, TOUCH_BL
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.state import (
    APPROACHING,
    ASCENDING,
    CIRCLING,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    NUZZLING,
    SPAWNING,
)
from subsea.submarine.vessel import NEUTRAL
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.world import TICK_S, World
from tests.support.daily import only

DANCE = [APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING, SPAWNING]


def _world(*shoals: dict[str, Any], seed: int = 1, **tables: Any) -> World:
    """A bay without plankton; every shoal is of one fish, which is keen and not hungry."""
    fish = [
        {"number": 1, "spread_cm": 1.0, "libido": 1.0, "hunger": 0.0, "digestion": 0.0} | shoal
        for shoal in shoals
    ]
    return create_world(
        msgspec.convert(
            {
                "title": "A bay", "seed": seed, "fish": fish,
                "bounds": {"radius_cm": 1000.0, "depth_cm": 600.0},
                "water": {"fog": (0.0, 0.1, 0.2), "visibility_cm": 1500.0, "hour": 17.5},
                "terrain": {"dune_height_cm": 0.0, "dune_length_cm": 600.0},
                "submarine": {"position_cm": (-300.0, -300.0, -330.0)},
                **tables,
            },
            Scenario,
        )
    )  # fmt: skip


def _one(species: str, x: float, y: float, size: float, male: bool) -> dict[str, Any]:
    """A fish that heads for the females' place, as not every female looks back."""
    return {
        "species": species, "position_cm": (x, y, -350.0), "size_cm": (size, size),
        "male_share": float(male), "heading_deg": float(np.degrees(np.arctan2(-y, -x))),
    }  # fmt: skip


def _swim(world: World, seconds: float) -> Iterator[None]:
    """Yield the world after each tick."""
    for _ in range(int(seconds / TICK_S)):
        step(world, NEUTRAL)
        yield


def _assert_agreed(world: World) -> None:
    """No fish courts itself, and from circling on both of a pair are in the same state."""
    minds = world.state.minds
    assert ((minds.partner == NOBODY) == (minds.courtship == NO_COURTSHIP)).all()
    for i in np.flatnonzero(minds.courtship >= CIRCLING):
        j = minds.partner[i]
        assert minds.partner[j] == i
        assert minds.courtship[j] == minds.courtship[i]


PAIRS = [
    ("emperor_angelfish", 30.0, 25.0),
    ("clownfish", 9.0, 8.0),
    ("bluecheek_butterflyfish", 20.0, 18.0),
    ("blue_tang", 25.0, 20.0),
    ("moon_wrasse", 22.0, 18.0),
]


@pytest.mark.parametrize(("species", "male_cm", "female_cm"), only(PAIRS[:1], PAIRS))
def test_a_pair_dances_from_approach_to_spawning(species, male_cm, female_cm):
    world = _world(_one(species, -80, -40, male_cm, True), _one(species, 0, 0, female_cm, False))
    fishes, minds = world.state.fishes, world.state.minds
    states, began, counts, touched = [NO_COURTSHIP], {}, {}, []
    gaps = {state: [] for state in (CIRCLING, ASCENDING, NUZZLING, SPAWNING)}
    mouths, length = [], 0.5 * (male_cm + female_cm)
    for _ in _swim(world, 130.0):
        _assert_agreed(world)
        state = int(minds.courtship[0])
        if states[-1] != state:
            states.append(state)
            began[state] = (world.state.tick * TICK_S, fishes.position[1].copy())
        if state == NO_COURTSHIP and NUZZLING in states:
            break
        if state in gaps:
            gaps[state].append(np.linalg.norm(fishes.position[0] - fishes.position[1]) / length)
        if state == NUZZLING:
            mouths.append(np.linalg.norm(np.array(abdomen_of(fishes, 1)) - mouth_of(fishes, 0)))
        counts[state] = minds.courtship_count.copy()
        nudged = state == NUZZLING and minds.courtship_count[0] > len(touched)
        if nudged:
            belly, mouth = abdomen_of(fishes, 1), mouth_of(fishes, 0)
            touched.append(np.array(belly) - mouth)
    assert states == [NO_COURTSHIP, *DANCE, NO_COURTSHIP]
    assert 15.0 < began[NO_COURTSHIP][0] - began[APPROACHING][0] < 60.0
    assert counts[LOOPING][0] >= POINTS - 1  # the last one ends the state in the same tick
    assert abs(counts[CIRCLING][1]) == pytest.approx(TURNS, abs=0.05)
    rise = began[NUZZLING][1][2] - began[ASCENDING][1][2]
    assert rise == pytest.approx(RISE_BL * female_cm, rel=0.2)
    for state, apart in gaps.items():
        assert np.median(apart) < (1.1 if state < NUZZLING else 0.9), state
    assert 0.1 < np.median(mouths) / male_cm < 0.4
    rushed, released = began[SPAWNING], began[NO_COURTSHIP]
    assert 1.0 < released[0] - rushed[0] < 3.0
    assert released[1][2] - rushed[1][2] > 1.2 * female_cm
    assert len(touched) == NUDGES - 1
    for gap in touched:
        # In the tick after the touch, and from below.
        assert np.linalg.norm(gap) < 1.5 * TOUCH_BL * male_cm
    assert minds.last_mating[0] == minds.last_mating[1] > 0
    apart = np.linalg.norm(fishes.position[0] - fishes.position[1])
    for _ in _swim(world, 12.0):
        _assert_agreed(world)
    assert np.linalg.norm(fishes.position[0] - fishes.position[1]) > apart + 0.5 * male_cm


@pytest.mark.nightly
@pytest.mark.parametrize("seed", only([1], [1, 2, 3]))
def test_clownfish_lay_on_stone_beside_their_anemone(seed):
    reef = {
        "position_cm": (0.0, 0.0),
        "number": 14,
        "spread_cm": 60.0,
        "kinds": {"anemone": 1.0, "rubble": 1.0},
    }
    pair = [
        _one("clownfish", x, 0.0, size, male)
        | {"position_cm": (x, 0.0, -560.0), "libido_rate": 0.01}
        for x, size, male in ((-25.0, 8.0, True), (5.0, 9.0, False))
    ]
    world = _world(*pair, seed=seed, reef=[reef])
    fishes, minds, sea = world.state.fishes, world.state.minds, world.state.sea
    states, gaps, apart = [NO_COURTSHIP], [], []
    for _ in _swim(world, 150.0):
        _assert_agreed(world)
        if minds.courtship[0] != states[-1]:
            states.append(int(minds.courtship[0]))
        if states[-1] == SPAWNING:
            nest = sea.site_place[nest_of(minds, 1, sea)]
            gaps.append(np.linalg.norm(fishes.position - nest, axis=1) / fishes.length)
            apart.append(np.linalg.norm(fishes.position[0] - fishes.position[1]))
        elif SPAWNING in states:
            break
    assert states[-4:] == [LOOPING, CIRCLING, SPAWNING, NO_COURTSHIP]
    last = np.array(gaps)[-round(LAYS_S / TICK_S) :]
    assert (np.median(last, axis=0) < 0.7).all(), "over the nest"
    assert len(gaps) > len(last)
    assert np.median(apart[-len(last) :]) < 1.2 * fishes.length[1], "he follows close behind"
    assert (minds.last_mating > 0.0).all()


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [1, 2])
def test_the_film_plays_by_itself(seed):
    # As in Tu §10.5: two males compete for a female; behind them two angelfish spawn.
    world = create_world(load_scenario("mating")[0], seed)
    fishes, minds = world.state.fishes, world.state.minds
    female, large, small, butterfly, angel, angel_mate = range(6)
    large_s, angel_s, small_s = ([NO_COURTSHIP] for _ in range(3))
    looped_for, flirts, apart, farthest = set(), False, None, 0.0
    for _ in _swim(world, 150.0):
        _assert_agreed(world)
        for fish, states in ((large, large_s), (angel, angel_s), (small, small_s)):
            if minds.courtship[fish] != states[-1]:
                states.append(int(minds.courtship[fish]))
        if minds.courtship[small] == LOOPING:
            looped_for.add(int(minds.partner[small]))
        gap = np.linalg.norm(fishes.position[small] - fishes.position[female])
        if looped_for and minds.partner[small] != female:
            apart = gap if apart is None else apart
            farthest = max(farthest, gap)
            flirts = flirts or minds.partner[small] == butterfly
        if large_s[-1] == angel_s[-1] == NO_COURTSHIP and len(large_s) > 2 < len(angel_s):
            break
    assert large_s == [NO_COURTSHIP, *DANCE, NO_COURTSHIP]
    assert angel_s == [NO_COURTSHIP, *DANCE, NO_COURTSHIP]
    assert minds.last_mating[large] == minds.last_mating[female] > 0
    assert minds.last_mating[angel] == minds.last_mating[angel_mate] > 0
    # His display failed; he turned away and tried another female.
    assert small_s[:3] == [NO_COURTSHIP, APPROACHING, LOOPING]
    assert small_s[3] in (NO_COURTSHIP, APPROACHING)
    assert female in looped_for
    assert farthest > apart + 3 * fishes.length[small]
    assert flirts
