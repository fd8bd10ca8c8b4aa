"""Senses: food, prey, mates, predators, water; against closed forms and all pairs."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from subsea.habitat.day import in_daylight
from subsea.perception.foraging import (
    COMPANY_CM,
    SCHOOL_COST,
    STEEPEST,
    TURN_COST,
    WARNED_COST,
)
from subsea.perception.predators import FELT_BL
from subsea.perception.senses import fish_due, sense
from subsea.perception.vision import SUBMARINE_CM, eye_of, sees_fish, sees_point, sight
from subsea.state import (
    CIRCLING,
    ESCAPE,
    LIBIDO,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    PACIFIST,
    PREDATOR,
    PREY,
    SCHOOL,
    SUBMARINE,
)
from subsea.state.habits import MOONLIGHT

SEEDS = st.integers(0, 2**32 - 1)
EYE = np.array([7.0, 0.0, -300.0])


def test_light_fades_and_water_cools_with_depth(tank):
    t = tank(3)
    t.fishes.position[:, 2] = -1e-3, -300.0, -900.0
    t.run(sense)
    np.testing.assert_allclose(t.minds.light, np.exp([0.0, -300 / 700, -900 / 700]), rtol=1e-4)
    np.testing.assert_allclose(t.minds.temperature, [27.0, 24.0, 21.0], rtol=1e-4)


def test_by_night_it_is_dark_and_fishes_see_less_far(tank):
    t = tank(2)
    t.sea.sky[1] = 0.0
    t.run(sense)
    assert (t.minds.light > 0.0).all() and (t.minds.light <= MOONLIGHT).all()
    night, day = in_daylight(t.nature, 0.0), in_daylight(t.nature, 1.0)
    assert day == t.nature
    assert 0.3 < night.vision_cm / day.vision_cm < 0.6
    assert night._replace(vision_cm=day.vision_cm) == day


def test_a_pair_that_circles_far_away_thinks_in_every_tick(tank):
    t = tank(2)
    t.minds.courtship[1] = CIRCLING
    due = [
        fish_due(t.fishes, t.minds, t.sea, 2000.0, t.clock._replace(tick=k)) for k in range(1, 9)
    ]
    assert [1 in who for who in due] == [True] * 8
    assert sum(0 in who for who in due) == 1


def test_only_fishes_that_think_perceive(tank):
    t = tank(3)
    t.minds.kind[:] = PREY
    t.sea.submarine[:3] = 300.0, 0.0, -300.0
    t.run(sense, 1)
    assert list(t.minds.light > 0) == [False, True, False]
    assert list(t.minds.predator) == [NOBODY, SUBMARINE, NOBODY]
    assert list(t.minds.neighbour[:, 0] != NOBODY) == [False, True, False]


def test_a_fish_alone_among_the_dead_perceives_nobody(tank):
    t = tank(3)
    t.minds.kind[:] = PREY, PREDATOR, PACIFIST
    t.fishes.alive[1:] = False
    t.run(sense, 0)
    for found in (t.minds.neighbour[0, 0], t.minds.threat[0], t.minds.predator[0], t.minds.mate[0]):
        assert found == NOBODY
    before = [array.copy() for array in t.minds]
    sense(np.zeros(0, np.int64), *t)  # no fish thinks: nothing is written
    for array, kept in zip(t.minds, before, strict=True):
        np.testing.assert_array_equal(array, kept)


def test_the_nearest_specks_are_smelled_even_behind_and_out_of_sight(tank):
    t = tank(specks=5, pillars=[(60.0, 0.0, 20.0, -100.0)])
    t.sea.plankton[:] = EYE + np.array(
        [[100, 0, 0], [-40, 0, 0], [0, 0, 70.0], [5, 0, 0], [601, 0, 0]]
    )
    t.sea.absent[3] = 10.0
    t.run(sense)
    assert list(t.minds.foods[0]) == [1, 2, 0]
    assert t.minds.food[0] == 1
    assert t.minds.food_distance[0] == pytest.approx(40.0)
    t.sea.absent[:4] = 1.0
    t.run(sense)
    assert t.minds.food[0] == -1
    assert t.minds.food_distance[0] == np.inf


def test_a_fish_that_keeps_to_the_ground_minds_only_low_specks(tank):
    """The ground is 300 cm below it; it cruises at most 250 cm above the ground."""
    t = tank(2, specks=3)
    t.sea.plankton[:] = EYE + np.array([[10, 0, 0], [0, 0, -60.0], [40, 0, 0]])
    t.minds.cruise_height[0] = 100.0, 250.0
    t.run(sense)
    assert t.minds.foods[0].tolist() == [1, -1, -1]
    assert (t.minds.food[0], t.minds.food_distance[0]) == (1, pytest.approx(60.0))
    assert t.minds.foods[1].tolist() == [0, 2, 1]
    t.sea.plankton[1] = EYE
    t.run(sense)
    assert t.minds.food[0] == -1
    assert t.minds.food_distance[0] == np.inf


def _crowd(tank, seed, kinds):
    """Fishes of several kinds and sizes, and a pillar that hides some from others."""
    rng = np.random.default_rng(seed)
    n = 30
    t = tank(n, pillars=[(0.0, 0.0, 60.0, -250.0)])
    t.minds.kind[:] = rng.choice(kinds, n)
    t.minds.male[:] = rng.uniform(0, 1, n) < 0.5
    t.minds.intention[:] = rng.integers(0, 7, n)
    t.fishes.species[:] = rng.integers(0, 2, n)
    t.fishes.length[:] = rng.uniform(8, 60, n)
    t.fishes.alive[:] = rng.uniform(0, 1, n) < 0.9
    t.fishes.position[:] = rng.uniform((-700, -700, -550), (700, 700, -50), (n, 3))
    turn = rng.normal(size=(n, 4))
    t.fishes.orientation[:] = turn / np.linalg.norm(turn, axis=1)[:, None]
    return t


def _all(t, i, kind):
    """Living other fishes of a kind: vector from the eye of i, and True if i sees it."""
    bodies, scene = t.fishes, t.sea
    eye = np.array(eye_of(bodies, i))
    for j in np.flatnonzero(t.fishes.alive & (t.minds.kind == kind)):
        if j != i:
            seen = sees_fish(bodies, i, j, scene, t.nature)
            yield j, t.fishes.position[j].astype(float) - eye, seen


@given(SEEDS)
def test_possible_mates_are_the_nearest_visible_of_the_other_sex(tank, seed):
    t = _crowd(tank, seed, [PACIFIST, PACIFIST, PREY])
    n = len(t.fishes.species)
    rng = np.random.default_rng(seed)
    t.minds.shunned[:] = rng.integers(-1, n, n)
    t.minds.courtship[:] = rng.choice([NO_COURTSHIP, LOOPING, CIRCLING], n)
    t.minds.partner[:] = rng.integers(0, n, n)
    t.minds.mental[:, LIBIDO] = 1.0
    t.run(sense)

    def possible(i, j):
        """Mates: other sex, not shunned, not taken, strangers only of similar size.

        To a female, a male is taken if he courts another.
        """
        states = (LOOPING, NO_COURTSHIP) if t.minds.male[i] else ()
        taken = t.minds.courtship[j] not in states and t.minds.partner[j] not in (i, NOBODY)
        alike = 0.5 < t.fishes.length[i] / t.fishes.length[j] < 2.0
        known = t.fishes.species[i] == t.fishes.species[j]
        other = t.minds.male[i] != t.minds.male[j]
        return other and t.minds.shunned[i] != j and not taken and (known or alike)

    for i in np.flatnonzero(t.fishes.alive):
        able = []
        if t.minds.kind[i] == PACIFIST:
            able = [
                (t.fishes.species[j] != t.fishes.species[i], np.linalg.norm(gap), j)
                for j, gap, seen in _all(t, i, PACIFIST)
                if seen and possible(i, j)
            ]
        best = [j for _, _, j in sorted(able)[:3]]
        assert list(t.minds.mates[i]) == best + [NOBODY] * (3 - len(best))
        assert t.minds.mate[i] == t.minds.mates[i, 0]
        if best:
            assert t.minds.mate_distance[i] == pytest.approx(sorted(able)[0][1], rel=1e-4)
        else:
            assert t.minds.mate_distance[i] == np.inf


def test_without_libido_only_near_mates_are_perceived(tank):
    t = tank(2)
    t.minds.male[0] = True
    for libido, gap, seen in ((0.1, 38, True), (0.1, 42, False), (0.3, 42, True)):
        t.fishes.position[1] = EYE + (gap, 0.0, 0.0)
        t.minds.mental[:, LIBIDO] = libido
        t.run(sense, 0)
        assert (t.minds.mate[0] == 1) == seen


@given(SEEDS)
def test_prey_are_ranked_by_their_cost(tank, seed):
    t = _crowd(tank, seed, [PREDATOR, PREY, PREY])
    t.minds.leads[:] = t.minds.intention == SCHOOL
    t.minds.missed[:] = np.roll(np.arange(len(t.minds.kind)), 1)
    t.run(sense)
    near = t.minds.neighbour[:, 0]
    gaps = np.linalg.norm(t.fishes.position[near] - t.fishes.position, axis=1)
    schools = t.minds.leads & (near >= 0) & (gaps < COMPANY_CM)
    for i in np.flatnonzero(t.fishes.alive & (t.minds.kind == PREDATOR)):
        x = np.subtract(eye_of(t.fishes, i), t.fishes.position[i]) / t.fishes.snout[i]
        able = []
        for j, gap, seen in _all(t, i, PREY):
            d = np.linalg.norm(gap)
            turn = np.arccos(np.clip(gap @ x / d, -1, 1))
            way = max(d, abs(gap[2]) / STEEPEST)
            cost = way * (1 + 0.5 * schools[j] + 0.2 * turn / np.pi)
            cost *= WARNED_COST if t.minds.missed[i] == j else 1.0
            flees = t.minds.intention[j] == ESCAPE and t.minds.target[i] != j
            cost *= WARNED_COST if flees else 1.0
            if seen or d <= t.nature.smell_cm:
                able.append((cost, d, j))
        best = [j for _, _, j in sorted(able)[:3]]
        assert list(t.minds.foods[i]) == best + [-1] * (3 - len(best))
        nearest = min(((d, j) for _, d, j in able), default=(np.inf, -1))
        assert t.minds.food[i] == nearest[1]
        assert t.minds.food_distance[i] == pytest.approx(nearest[0], rel=1e-4)
    assert (SCHOOL_COST, TURN_COST) == (0.5, 0.2)


@given(SEEDS, st.booleans())
def test_fear_is_of_visible_predators(tank, seed, company):
    t = _crowd(tank, seed, [PREDATOR, PREY, PREY, PACIFIST])
    if company:
        t.sea.submarine[:3] = 200.0, 300.0, -300.0
    t.run(sense)
    bodies, scene = t.fishes, t.sea
    paces = np.linalg.norm(bodies.velocity - bodies.drift, axis=1) / bodies.length
    for i in np.flatnonzero(t.fishes.alive):
        if t.minds.kind[i] != PREY:
            assert t.minds.predator[i] == NOBODY
            assert t.minds.menaces[i] == t.minds.menace[i] == 0.0
            continue
        threat = 0.5 + 0.5 * np.clip((paces - 0.6) / 0.4, 0.0, 1.0)
        fears = [
            (200.0 * threat[j] / np.linalg.norm(gap), j)
            for j, gap, seen in _all(t, i, PREDATOR)
            if seen or np.linalg.norm(gap) < FELT_BL * t.fishes.length[j]
        ]
        hull = tuple(t.sea.submarine[:3])
        if sees_point(bodies, i, scene, hull, sight(SUBMARINE_CM, t.nature)):
            away = np.linalg.norm(np.subtract(hull, eye_of(bodies, i)))
            fears.append((t.nature.submarine_cm / away, SUBMARINE))
        assert t.minds.menaces[i] == pytest.approx(min(sum(f for f, _ in fears), 1.0), rel=1e-4)
        most = max(fears, default=(0.0, NOBODY))
        assert t.minds.predator[i] == most[1]
        assert t.minds.menace[i] == pytest.approx(min(most[0], 1.0), rel=1e-4)
    # Examples without a threat in sight show the zeros; most must have one.
    assume((t.minds.predator[t.fishes.alive & (t.minds.kind == PREY)] != NOBODY).any())


def test_coward_and_bold(tank):
    t = tank(2)
    t.minds.kind[:] = PREY, PREDATOR
    t.fishes.position[1, 0], t.fishes.velocity[1, 0] = 407.0, 20.0
    t.run(sense, 0)
    assert t.minds.menace[0] == pytest.approx(0.5)
    t.minds.dread[0] = 500.0
    t.run(sense, 0)
    assert t.minds.menace[0] == 1.0


@pytest.mark.parametrize(
    ("speed", "drift", "calm", "fear"),
    [(0.0, 0.0, 0.5, 0.25), (12.0, 0.0, 0.5, 0.25), (16.0, 0.0, 0.5, 0.375), (20.0, 0.0, 0.5, 0.5),
     (20.0, 20.0, 0.5, 0.25), (0.0, 0.0, 1.0, 0.5), (0.0, 0.0, 0.0, 0.0), (60.0, 0.0, 0.0, 0.5)],
)  # fmt: skip
def test_a_predator_that_cruises_is_feared_less(tank, speed, drift, calm, fear):
    t = tank(2, calm_dread=calm)
    t.minds.kind[:] = PREY, PREDATOR
    t.fishes.position[1, 0] = 407.0
    t.fishes.velocity[1, 0], t.fishes.drift[1, 0] = speed, drift
    t.run(sense, 0)
    assert t.minds.menace[0] == pytest.approx(fear)


def test_a_large_predator_is_seen_in_advance(tank):
    """V_r times the size of the object (Tu §6.3.1)."""
    t = tank(2)
    t.minds.kind[:] = PREY, PREDATOR
    t.fishes.position[1, 0] = 900.0
    t.run(sense, 0)
    assert t.minds.predator[0] == NOBODY
    t.fishes.length[1] = 120.0
    t.run(sense, 0)
    assert t.minds.predator[0] == 1
