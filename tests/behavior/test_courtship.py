"""The dance: its component behaviors, and whole sequences of fishes that really swim."""

import itertools
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

from subsea.behavior import courtship
from subsea.behavior.chasing import mouth_of
from subsea.behavior.courtship import NUDGES, POINTS, RISE_BL, TOUCH_BL, TURNS
from subsea.ocean import TICK_S, create_world, step
from subsea.scenario import Scenario
from subsea.state import (
    APPROACHING,
    ASCENDING,
    CIRCLING,
    LOOPING,
    MATE,
    NO_COURTSHIP,
    NOBODY,
    NUZZLING,
)
from subsea.submarine.helm import HANDS_OFF
from subsea.world import World

DANCE = [APPROACHING, LOOPING, CIRCLING, ASCENDING, NUZZLING]


def _world(*shoals: dict[str, Any], seed: int = 1) -> World:
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
                "water": {"fog": (0.0, 0.1, 0.2), "visibility_cm": 1500.0},
                "terrain": {"dune_height_cm": 0.0, "dune_length_cm": 600.0},
                "submarine": {"position_cm": (-300.0, -300.0, -330.0)},
            },
            Scenario,
        )
    )  # fmt: skip


def _one(species: str, x: float, y: float, size: float, male: bool) -> dict[str, Any]:
    return {
        "species": species, "position_cm": (x, y, -350.0), "size_cm": (size, size),
        "male_share": float(male),
    }  # fmt: skip


def _swim(world: World, seconds: float) -> Iterator[None]:
    """Each tick of the world; all see all."""
    fishes, minds = world.state.fishes, world.state.minds
    n = len(fishes.species)
    for _ in range(int(seconds / TICK_S)):
        minds.mate[:], minds.mate_distance[:], minds.threat[:] = NOBODY, np.inf, NOBODY
        for i, j in itertools.permutations(range(n), 2):
            far = np.linalg.norm(fishes.position[i] - fishes.position[j])
            possible = minds.male[i] != minds.male[j] and minds.shunned[i] != j
            if possible and far < min(minds.mate_distance[i], 500.0):
                minds.mate[i], minds.mate_distance[i] = j, far
        courting = minds.intention == MATE
        minds.target[courting] = minds.mate[courting]
        step(world, HANDS_OFF)
        yield


def _assert_agreed(world: World) -> None:
    """Nobody courts nobody, and from circling on both of a pair do the same."""
    minds = world.state.minds
    np.testing.assert_array_equal(minds.partner == NOBODY, minds.courtship == NO_COURTSHIP)
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


@pytest.mark.parametrize(("species", "male_cm", "female_cm"), PAIRS)
def test_a_pair_dances_from_approach_to_spawning(species, male_cm, female_cm):
    world = _world(_one(species, 0, 0, male_cm, True), _one(species, 80, 40, female_cm, False))
    fishes, minds = world.state.fishes, world.state.minds
    states, began, counts, touched = [NO_COURTSHIP], {}, {}, []
    for _ in _swim(world, 130.0):
        _assert_agreed(world)
        state = int(minds.courtship[0])
        if states[-1] != state:
            states.append(state)
            began[state] = (world.state.tick * TICK_S, fishes.position[1].copy())
        if state == NO_COURTSHIP and NUZZLING in states:
            break
        counts[state] = minds.courtship_count.copy()
        nudged = state == NUZZLING and minds.courtship_count[0] > len(touched)
        if nudged:
            belly, mouth = courtship.abdomen(fishes, 1), mouth_of(fishes, 0)
            touched.append(np.array(belly) - mouth)
    assert states == [NO_COURTSHIP, *DANCE, NO_COURTSHIP]
    assert 40.0 < began[NO_COURTSHIP][0] - began[APPROACHING][0] < 120.0
    assert counts[LOOPING][0] >= POINTS - 1  # the last one ends the state in the same tick
    assert abs(counts[CIRCLING][1]) == pytest.approx(TURNS, abs=0.05)
    rise = began[NUZZLING][1][2] - began[ASCENDING][1][2]
    assert rise == pytest.approx(RISE_BL * female_cm, rel=0.2)
    assert len(touched) == NUDGES - 1
    for gap in touched:
        # In the tick after the touch, and from below.
        assert np.linalg.norm(gap) < 1.5 * TOUCH_BL * male_cm
    assert minds.last_mating[0] == minds.last_mating[1] > 0
    apart = np.linalg.norm(fishes.position[0] - fishes.position[1])
    for _ in _swim(world, 12.0):
        _assert_agreed(world)
    assert np.linalg.norm(fishes.position[0] - fishes.position[1]) > apart + 0.5 * male_cm


def test_of_two_males_the_smaller_is_rejected_and_turns_to_another():
    world = _world(
        _one("moon_wrasse", -150, -50, 24.0, True),
        _one("moon_wrasse", -150, 50, 18.0, True),
        _one("moon_wrasse", 0, 0, 19.0, False),
        _one("bluecheek_butterflyfish", -30, 190, 18.0, False),
    )
    fishes, minds = world.state.fishes, world.state.minds
    looped, rejected, flirts = False, None, False
    for _ in _swim(world, 90.0):
        _assert_agreed(world)
        looped = looped or (minds.courtship[1] == LOOPING and minds.partner[1] == 2)
        if looped and rejected is None and minds.partner[1] != 2:
            rejected = np.linalg.norm(fishes.position[1] - fishes.position[2])
            assert minds.shunned[1] == 2
        flirts = flirts or (rejected is not None and minds.partner[1] == 3)
        if rejected is not None and flirts and minds.courtship[2] >= CIRCLING:
            break
    assert looped
    assert rejected is not None
    assert flirts
    assert minds.partner[2] == 0
    assert minds.courtship[0] >= CIRCLING
    assert np.linalg.norm(fishes.position[1] - fishes.position[2]) > rejected
