"""A fish's state of mind in one plain sentence."""

import pytest

from subsea.base.language import LANGUAGES, set_language
from subsea.behavior.table import OURS
from subsea.dive.plain_words import HUNTING, PATROLS, SENTENCES, sentence
from subsea.scenario.load import load_scenario
from subsea.state import (
    CIRCLING,
    CURIOUS,
    EAT,
    FEAR,
    HUNGER,
    MATE,
    PATROLLING,
    PREDATOR,
    RUSHING,
    SCHOOL,
    SPAWNING,
    SUBMARINE,
    WANDER,
)
from subsea.world.build import create_world


@pytest.fixture(scope="module")
def made():
    return create_world(load_scenario("mating")[0])


@pytest.fixture
def world(made):
    minds = made.state.minds
    minds.intention[:], minds.courtship[:], minds.partner[:] = WANDER, 0, -1
    minds.mental[:], minds.hunt[:], minds.target[:] = 0.0, PATROLLING, -1
    return made


def test_every_intention_of_ours_has_a_sentence(world):
    assert sorted(SENTENCES) == list(range(len(OURS)))
    for code in SENTENCES:
        world.state.minds.intention[0] = code
        words = sentence(world, 0)
        assert words.startswith("It ") and words.endswith(".") and len(words.split()) <= 12


def test_it_follows_the_mind(world):
    minds = world.state.minds
    minds.intention[0] = SCHOOL
    calm = sentence(world, 0)
    minds.mental[0, FEAR] = 0.9
    assert "danger" in sentence(world, 0) != calm
    minds.intention[0], minds.target[0] = CURIOUS, SUBMARINE
    assert sentence(world, 0) == "It is curious about you."
    minds.intention[0], minds.partner[0] = MATE, 1
    minds.courtship[0] = CIRCLING
    assert "courts" in sentence(world, 0)
    minds.courtship[0] = SPAWNING
    assert "spawns" in sentence(world, 0)


def test_a_predator_hunts_patrols_or_is_full(world):
    minds = world.state.minds
    kind, minds.kind[0] = minds.kind[0], PREDATOR
    minds.intention[0], minds.mental[0, HUNGER] = EAT, 0.8
    assert sentence(world, 0) == PATROLS
    minds.hunt[0] = RUSHING
    assert sentence(world, 0) == HUNTING[RUSHING]
    minds.hunt[0], minds.mental[0, HUNGER] = PATROLLING, 0.0
    assert "full" in sentence(world, 0)
    minds.kind[0] = kind


def test_it_is_in_the_language_of_visitors(world):
    english = sentence(world, 0)
    for code in LANGUAGES:
        set_language(code)
        assert (sentence(world, 0) == english) == (code == "en")
    set_language("en")
