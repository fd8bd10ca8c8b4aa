"""Bodies in lanes bout as each does alone, bit for bit."""

import hashlib

import numpy as np
import pytest

from subsea.biomechanics.body import MUSCLES, build_body
from subsea.biomechanics.reactive_water import NO_SECTIONS
from subsea.biomechanics.simulation import at_rest, copy_state, is_sound, simulate
from subsea.biomechanics.solver import STEPS_PER_TICK
from subsea.biomechanics.together import Bout, simulate_many, swim_course, swim_together
from subsea.fish.species import load_species
from subsea.kernels.lanes import LANES

SPECIES = ("fusilier", "emperor_angelfish", "blacktip_reef_shark")
GOLDEN = {
    "slender": "b1536911c8c263ba5158c7e5be26a8072df76897991d186e8e19b76be9299ca9",
    "tu": "535487fccfe3781c4d1792cb3f64b7f9fe76194707b46b01c8b56826e01f5ac6",
}
"""Digests of nodes that one body at a time swam to before bodies shared lanes.

They need no sine, whose last bit differs between processors.
"""


def body_of(name, water="slender"):
    body = build_body(load_species(name).muscles.body)
    return body if water == "slender" else body._replace(drag=0.8, sections=NO_SECTIONS)


def random_bout(seed, ticks, water="slender"):
    """A disturbed body of some species under random contractions."""
    random = np.random.default_rng(seed)
    body = body_of(SPECIES[seed % len(SPECIES)], water)
    state = at_rest(body)
    state.v[:] = random.normal(0.0, 0.3, state.v.shape)
    return Bout(body, state, random.uniform(0.0, 0.4, (STEPS_PER_TICK * ticks, MUSCLES)))


def copy_bout(bout):
    return bout._replace(state=copy_state(bout.state))


def check_alike(bouts):
    """Assert that the bodies bout alike in lanes and one by one; return their frames."""
    alone = [copy_bout(bout) for bout in bouts]
    together = simulate_many(bouts)
    for one, bout, frames in zip(alone, bouts, together, strict=True):
        assert frames.tobytes() == simulate(*one).tobytes()
        for array, expected in zip(bout.state, one.state, strict=True):
            assert array.tobytes() == expected.tobytes()
    return together


@pytest.mark.parametrize("water", GOLDEN)
def test_one_body_swims_as_it_did_before_lanes(water):
    digest = hashlib.sha256()
    for seed in range(3):
        bout = random_bout(seed, 20, water)
        digest.update(simulate(*bout).tobytes() + bout.state.v.tobytes())
    assert digest.hexdigest() == GOLDEN[water]


@pytest.mark.parametrize("number", [1, 2, LANES - 1, LANES, LANES + 1, 2 * LANES + 3])
def test_any_number_of_species_and_durations_swim_alike(number):
    check_alike([random_bout(seed, 1 + seed * 7 % 5) for seed in range(number)])


def test_both_kinds_of_water_swim_alike():
    """They never share lanes."""
    kinds = [("slender", "tu")[seed % 2] for seed in range(7)]
    check_alike([random_bout(seed, 3, water) for seed, water in enumerate(kinds)])


def test_a_body_that_bursts_leaves_its_neighbours_alone():
    bouts = [random_bout(seed, 4) for seed in range(LANES)]
    bouts[2].state.v[:] *= 1e3
    bouts[5].state.v[3] = np.nan
    alone = [copy_bout(bout) for bout in bouts]
    together = simulate_many(bouts)
    for k, (one, frames) in enumerate(zip(alone, together, strict=True)):
        if k in (2, 5):
            assert not is_sound(bouts[k].state)
        else:
            assert frames.tobytes() == simulate(*one).tobytes()
            assert is_sound(bouts[k].state)


def wander(seed, rounds):
    """A course of some bouts, which returns where the snout was after each."""
    bout, seen = random_bout(seed, 2), []
    for _ in range(rounds):
        frames = yield bout
        seen.append(frames[-1, 0].tolist())
    return seen


def test_courses_of_different_lengths_find_what_each_finds_alone():
    rounds = [3, 0, 1, 5, 2, 2, 4, 1, 3, 1]
    found = swim_together([wander(seed, number) for seed, number in enumerate(rounds)])
    assert [len(seen) for seen in found] == rounds
    assert found == [swim_course(wander(seed, number)) for seed, number in enumerate(rounds)]


def test_contractions_of_another_shape_are_a_value_error():
    bouts = [random_bout(seed, 2) for seed in range(2)]
    bouts[1] = bouts[1]._replace(contraction=np.zeros((7, MUSCLES)))
    with pytest.raises(ValueError, match=r"is not \(6 T, 12\)"):
        simulate_many(bouts)
