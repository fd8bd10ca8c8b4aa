"""Rules of a program: followed by fishes, checked, and named in what they make."""

import pickle
from functools import partial

import h5py
import numba
import numpy as np
import pytest

import subsea
from subsea.behavior.intention import APPETITE, EASE
from subsea.lab.functions import digest_of
from subsea.lab.rules import PARTS, SENSED, Rules
from subsea.media.record import read_origin
from subsea.state import SCHOOL
from tests.support.scenes import BARE

NORTH = np.array([0.0, 1.0, 0.0])


def north(who, pace=0.4):
    """Send fishes north."""
    return np.tile(NORTH, (len(who), 1)), pace


def to_the_middle(who, position):
    return position[who].mean(axis=0) - position[who]


@numba.njit
def compiled_to_the_middle(who, position):
    middle = np.zeros(3)
    for i in who:
        middle += position[i] / len(who)
    way = np.empty((len(who), 3))
    for k, i in enumerate(who):
        way[k] = middle - position[i]
    return way


def bare(*behaviors, **given):
    return subsea.load(str(BARE), seed=3, fish=6, behaviors=behaviors, **given)


def always(function, **given):
    """A behavior that comes before all of ours."""
    return subsea.rule("mine", function, desire=1.0, level="collision", **given)


def test_fishes_follow_a_rule_in_place_of_all_of_ours():
    world = bare(always(north))
    world.step(40)
    names = world.names["minds.intention"]
    assert {names[code] for code in world.minds.intention} == {"mine"}
    assert world.fishes.goal_speed == pytest.approx(0.4)
    assert (world.fishes.goal_direction @ NORTH).min() > 0.95
    assert (world.fishes.velocity @ NORTH).min() > 0.0


def test_a_rule_in_place_of_ours_is_wanted_as_ours_is():
    ours, mine = bare(), bare(subsea.rule("school", north))
    for world in (ours, mine):
        world.step(1)
    assert (mine.minds.intention == ours.minds.intention).all()
    schooling = mine.minds.intention == SCHOOL
    assert schooling.any()
    assert mine.fishes.goal_speed[schooling] == pytest.approx(0.4)
    assert (mine.fishes.goal_speed[~schooling] == ours.fishes.goal_speed[~schooling]).all()


@pytest.mark.nightly
def test_plain_and_compiled_rules_are_the_same():
    plain, fast = bare(always(to_the_middle)), bare(always(compiled_to_the_middle))
    for world in (plain, fast):
        world.step(10)
    assert plain.fishes.position == pytest.approx(fast.fishes.position, abs=1e-3)
    assert plain.fishes.goal_speed == pytest.approx(0.5)


def test_a_desire_is_a_number_or_a_function_on_a_level():
    def hungry(who, mental):
        return mental[who, 0]

    one = subsea.rule("mine", north, desire=hungry, level="appetite")
    [(level, wish)] = one.desires
    world = bare(one)
    world.step(1)
    assert level == APPETITE
    row = world.internal.table.desires.index(wish)
    assert world.minds.desire[row] == pytest.approx(world.minds.mental[:, 0])
    assert subsea.rule("mine", north, desire=0.3).desires[0][0] == EASE


def test_values_are_bound_and_random_numbers_depend_on_seed_and_tick_only():
    drawn = []

    def wander(who, random, tick, dt, seed, heading, length=20.0, amount=0.1):
        drawn.append((tick, random.normal()))
        assert (dt, seed, length, len(heading)) == (0.033, 3, 20.0, 6)
        return heading[who] + amount * random.normal(size=(len(who), 3))

    for _ in range(2):
        bare(always(partial(wander, amount=0.5))).step(2)
    assert drawn[:2] == drawn[2:] and drawn[0][0] == 0 and drawn[0][1] != drawn[1][1]


def test_a_sense_writes_what_perception_does():
    def dim(who, light):
        return 0.1 * light[who]

    def lonely(who, neighbour):
        return np.full(neighbour[who].shape, -1)

    senses = [subsea.sense("light", dim), subsea.sense("neighbour", lonely)]
    dark, bright = bare(senses=senses), bare()
    for world in (dark, bright):
        world.step(1)
    assert dark.minds.light == pytest.approx(0.1 * bright.minds.light)
    assert (dark.minds.neighbour == -1).all() and (bright.minds.neighbour >= 0).any()
    assert "leader" not in SENSED and "food" not in SENSED  # not of perception; not one meaning


def nan(who, heading):
    way = heading[who].copy()
    way[-1, 1] = np.nan
    return way


def flat(who, heading):
    return heading[who][:, :2]


def fails(who, position):
    return position[who] / len({}.popitem())


def hasty(who, heading):
    return heading[who], np.full(len(who), 1.5)


def writes(who, position):
    position[who] = 0.0


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (nan, r"rule nan: returned directions \[.* nan .*\] for fish 5, expected finite numbers"),
        (flat, r"rule flat: returned directions of shape \(6, 2\), expected \(6, 3\), a row"),
        (fails, r"rule fails: raised KeyError: .* \(line \d+ of fails\)"),
        (hasty, r"rule hasty: returned a speed 1\.5 for fish 0, expected -1 to 1"),
        (writes, "rule writes: raised ValueError: assignment destination is read-only"),
        (lambda who: "north", "rule <lambda>: returned directions north, expected numbers"),
        (lambda who: None, r"rule <lambda>: returned directions of shape \(\), expected \(6, 3\)"),
    ],
)
def test_a_rule_that_fails_is_one_line_that_names_it(function, words):
    world = bare(always(function))
    with pytest.raises(subsea.UserError, match=f"^behavior 'mine', {words}") as raised:
        world.step(1)
    assert "\n" not in str(raised.value)


def test_faults_of_other_functions_name_them_too():
    world = bare(subsea.rule("mine", north, desire=lambda who: np.full(len(who), 2.0)))
    with pytest.raises(subsea.UserError, match=r"desire of 'mine', rule <lambda>: .* 2 for fish 0"):
        world.step(1)
    world = bare(senses=[subsea.sense("threat", lambda who: np.full(len(who), 6))])
    with pytest.raises(subsea.UserError, match=r"sense 'threat', .* an index 6 .* -1 to 5"):
        world.step(1)


def test_rules_of_no_use_are_refused_when_they_are_made():
    with pytest.raises(subsea.UserError, match=r"unknown parameter 'postion'; .*'position'"):
        subsea.rule("school", lambda who, postion: postion)
    with pytest.raises(subsea.UserError, match="sense 'leader': no sense may write it"):
        subsea.sense("leader", north)
    with pytest.raises(subsea.UserError, match="unknown level 'urgent'; expected one of collision"):
        subsea.rule("mine", north, desire=1.0, level="urgent")
    with pytest.raises(subsea.UserError, match=r"desire 1\.5, expected 0 to 1"):
        subsea.rule("mine", north, desire=1.5)
    with pytest.raises(subsea.UserError, match="rule max: the names of its parameters are unknown"):
        subsea.rule("mine", max)
    with pytest.raises(TypeError, match="behavior 'mine': expected a function, got 3"):
        subsea.rule("mine", 3)
    with pytest.raises(TypeError, match=r"behaviors: expected what subsea\.rule.*got <function"):
        bare(north)
    with pytest.raises(TypeError, match=r"senses: expected what subsea\.sense.*got 3"):
        bare(senses=[3])
    with pytest.raises(subsea.UserError, match="behavior 'mine' needs a desire"):
        bare(subsea.rule("mine", north))
    assert not {"who", "heading", "tick", "seed", "dt", "random"} & set(PARTS)


def dash(world):
    """Steer fish 0 ahead from the fourth tick on, and a submarine before it."""
    if world.tick < 3:
        return subsea.Helm(surge=1.0) if world.tick else None
    return subsea.TeleopCommand(0, speed=1.0)


def test_a_simulation_has_rules_and_orders_and_says_so(tmp_path):
    mine = subsea.rule("mine", north, desire=0.5)
    given = {"behaviors": [mine], "orders": dash}
    path = subsea.simulate(str(BARE), tmp_path / "a.h5", seconds=0.2, seed=3, fish=6, **given)
    world = bare(mine)
    with subsea.record(world, tmp_path / "b.h5") as other:
        for _ in range(6):
            order = dash(world)
            world.step(1) if order is None else world.step(1, order)
    with h5py.File(path) as file, h5py.File(other) as by_hand:
        found = list(file.attrs["moved_by"].astype(str))
        assert (file["fish/position"][:] == by_hand["fish/position"][:]).all()
        assert (file["submarine/position"][:] == by_hand["submarine/position"][:]).all()
    assert found[:2] == ["a helm of the submarine", f"behavior mine: {mine.routine.description}"]
    assert found[2:] == ["minds", f"orders: {__name__}.dash sha256 {digest_of(dash)[:16]}",
                         "teleop commands"]  # fmt: skip
    assert read_origin(path).moved_by == tuple(found)  # so it is compared with its like
    assert mine.routine.description.startswith(f"{__name__}.north sha256 ")


def test_a_rule_that_fails_late_keeps_the_ticks_so_far(tmp_path):
    def breaks(world):
        return subsea.Helm(surge=2.0) if world.tick == 4 else None

    words = r"orders breaks, tick 4: order: surge 2\.0, .*run\.h5: 4 ticks of 6 fishes kept"
    with pytest.raises(subsea.UserError, match=words):
        subsea.simulate(str(BARE), tmp_path / "run.h5", seconds=1, fish=6, orders=breaks)
    assert len(subsea.open_record(tmp_path / "run.h5").time) == 4


def test_a_sweep_makes_runs_again_whose_rule_has_changed(tmp_path):
    def runs(**rules):
        table = subsea.sweep(
            str(BARE), tmp_path / "sweep", seeds=[1], seconds=0.1, fish=4, jobs=1, **rules
        )
        assert table.is_file()
        journal = tmp_path / "sweep/runs/journal.jsonl"
        return journal.read_text().splitlines()

    slow = subsea.rule("mine", partial(north, pace=0.2), desire=1.0)
    quick = subsea.rule("mine", partial(north, pace=0.9), desire=1.0)
    assert [len(runs()), len(runs(behaviors=[slow])), len(runs(behaviors=[slow]))] == [1, 2, 2]
    assert len(runs(behaviors=[quick])) == 3
    with pytest.raises(subsea.UserError, match="sweep: other processes cannot import these rules"):
        subsea.sweep(
            str(BARE), tmp_path / "two", seeds=[1], seconds=0.1, jobs=2, orders=lambda world: None
        )
    assert not Rules(behaviors=[quick], orders=dash).stay
    always_north = subsea.rule("mine", north, desire=1.0)
    assert pickle.loads(pickle.dumps(always_north)) == always_north
    with pytest.raises(TypeError, match="unexpected keyword argument 'behaviours'"):
        subsea.simulate(str(BARE), tmp_path / "run.h5", seconds=1, behaviours=[quick])


def test_a_hash_is_of_the_text_and_of_the_values():
    def made(number):
        return lambda who: number

    assert digest_of(north) == digest_of(partial(north))
    assert len({digest_of(one) for one in (north, partial(north, pace=1.0), dash, nan)}) == 4
    assert digest_of(made(1)) != digest_of(made(2))
    assert digest_of(compiled_to_the_middle) != digest_of(to_the_middle)
