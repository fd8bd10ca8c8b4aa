"""Directions of a scenario: when they start, and their influences."""

import re
import tomllib
from importlib.util import module_from_spec, spec_from_file_location

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from subsea.base.errors import UserError
from subsea.base.system import ROOT
from subsea.behavior.hunting import CHEW_S
from subsea.behavior.mental_state import HABITS, set_hunger
from subsea.directing.director import direct, latest
from subsea.scenario.checks import check_scenario
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Hook, Scenario
from subsea.scenario.shoals import Shoals
from subsea.state import (
    EAT,
    FEAR,
    HOOKED,
    HUNGER,
    LANDED,
    LIBIDO,
    LOOPING,
    NO_COURTSHIP,
    NOBODY,
    SCHOOL,
    SINKING,
    SPAWNING,
    STOWED,
    Clock,
)  # fmt: skip
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.placement import Handle, removed
from subsea.world.step import step
from subsea.world.to_scenario import to_scenario
from subsea.world.world import TICK_S
from tests.support.daily import examples, only
from tests.support.directions import directions

SEA = """
title = "A bare sea"
seed = 1
bounds = { radius_cm = 900.0, depth_cm = 500.0 }
water = { fog = [0.006, 0.072, 0.180], visibility_cm = 1500.0, plankton = 30 }
terrain = { dune_height_cm = 30.0, dune_length_cm = 600.0 }
submarine = { position_cm = [-480.0, -60.0, -250.0] }
nature = { submarine_cm = 0.0, curiosity_cm = 0.0 }
[[fish]]
species = "fusilier"
number = 6
position_cm = [-300.0, 0.0, -250.0]
spread_cm = 50.0
heading_deg = 20.0
hunger = 0.0
digestion = 0.0
[[fish]]
species = "blacktip_reef_shark"
number = 1
position_cm = [500.0, 250.0, -250.0]
spread_cm = 20.0
heading_deg = -165.0
hunger = 0.0
digestion = 0.0
[[fish]]
species = "clownfish"
number = 2
size_cm = [9.0, 11.0]
position_cm = [-300.0, 200.0, -250.0]
spread_cm = 100.0
hunger = 0.0
libido = 0.0
"""
SHARK, PAIR = 6, (7, 8)


def scenario_of(folder, *directions):
    """The bare sea with these directions."""
    file = folder / "directed.toml"
    file.write_text(SEA + "".join(f"[[direction]]\n{one}\n" for one in directions))
    return load_scenario(str(file))[0]


def world_of(folder, *directions, **more):
    return create_world(scenario_of(folder, *directions), **more)


def play(world, seconds, order=NEUTRAL):
    for _ in range(round(seconds / TICK_S)):
        step(world, order)


def begun_s(world):
    """When each direction began last, s; -1 for never."""
    began = world.state.directions.began
    return [round(float(tick) * TICK_S, 1) if tick >= 0 else -1 for tick in began]


def test_a_school_follows_a_path_and_is_then_free(tmp_path):
    path = "path_cm = [[-190, 60, -250], [-60, 0, -250]]\nspeed_cm_s = 20"
    world = world_of(tmp_path, f"who = {{ shoal = 0 }}\nfear = 0\n{path}")
    leader, errand = world.state.fishes.position[0], world.state.minds.errand
    nearest = np.inf
    for _ in range(round(40 / TICK_S)):
        step(world, NEUTRAL)
        nearest = min(nearest, float(np.linalg.norm(leader - (-190, 60, -250))))
        if not errand.any():
            break
    assert nearest < 80
    assert np.linalg.norm(leader - (-60, 0, -250)) < 80
    middle = np.median(world.state.fishes.position[:6], axis=0)
    assert np.linalg.norm(middle - leader) < 120
    assert not errand.any()


def test_directions_follow_one_another_and_events(tmp_path):
    world = world_of(
        tmp_path,
        'after = "gate"\nlights = true',
        'name = "gate"\nevent = "passes"\ngate_cm = [-430, -60, -250]\nradius_cm = 30',
        'after = "gate"\ndelay_s = 1.0\ncaption = "She goes."',
        "at_s = 2.0\nevery_s = 0.5\ncaption = 'Again.'",
    )
    play(world, 0.5)
    assert begun_s(world)[:3] == [-1, -1, -1]
    play(world, 5.5, Helm(surge=0.6))
    lit, gate, went, _ = begun_s(world)
    assert 0.5 < gate == lit < 5
    assert went == pytest.approx(gate + 1.0, abs=0.1)
    assert world.state.submarine.lights[0]
    assert world.state.directions.times.tolist()[3] == 9
    assert latest(world.scenario, world.state, "caption") == 3


def test_a_world_restored_amid_directions_continues_equally(tmp_path):
    directions = (
        'name = "go"\nwho = { shoal = 0 }\npath_cm = [[0, 0, -250]]\nfear = 0.9\nover_s = 2.0',
        'after = "go"\ndelay_s = 1.0\ncurrent_cm_s = [20, 0]\nover_s = 2.0',
    )
    one, other = (world_of(tmp_path, *directions) for _ in range(2))
    play(one, 1.7)
    snapshot.restore(other, snapshot.take(one))
    for world in (one, other):
        play(world, 1.5)
    assert snapshot.checksum(one) == snapshot.checksum(other)
    assert one.flowing_cm_s == pytest.approx((20.0, 0.0))
    assert one.current_cm_s == (0.0, 0.0)
    assert one.state.minds.fright[:6] == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("direction", "words"),
    [
        ("at_s = 1.0", "`direction[0]`: nothing happens"),
        ('hunger = 1.0', "`direction[0].who`: missing"),
        ('who = { shoal = 3 }\nhunger = 1.0', "`direction[0].who.shoal`: 3: there is no such"),
        ('who = { fish = 9 }\nhunger = 1.0', "`direction[0].who.fish`: 9: there is no such fish"),
        ('who = { species = "clownfsh" }\nhunger = 1.0', "did you mean 'clownfish'"),
        ('who = { shoal = 0, fish = 1 }\nhunger = 1.0', "expected one of `shoal`, `fish`"),
        ('who = { shoal = 0 }\nhunts = "any"', "`direction[0].hunts`: there is no predator"),
        ('who = { shoal = 2 }\nfear = 1.0', "`direction[0].fear`: there is no prey"),
        ('pair = [0, 7]', "`direction[0].pair`: fish 0 is a prey"),
        ('pair = "nearest"\nwho = { shoal = 0 }', "`direction[0].pair`: there is no pacifist"),
        ('who = { shoal = 0 }\npath_cm = [[0, 0, -700]]', "`direction[0].path_cm[0]`"),
        ('event = "passes"\nlights = true', "`direction[0].gate_cm`"),
        ('hook = "down"', "`direction[0].hook`: expected a table [hook]"),
        ('after = "nobody"\nlights = true', "`direction[0].after`: unknown direction 'nobody'"),
        ('name = "a"\nafter = "a"\nlights = true', "`direction[0].after`: it waits for itself"),
        ('camera = { tour = "round" }', "`direction[0].camera.tour`: unknown tour"),
        ('camera = { position_cm = [0, 0, -200] }', "expected `tour`, `look_at_cm` or `follow`"),
    ],
)  # fmt: skip
def test_errors_in_directions_are_one_line(tmp_path, direction, words):
    with pytest.raises(UserError) as fault:
        scenario_of(tmp_path, direction)
    assert words in str(fault.value)
    assert "directed.toml" in str(fault.value)


def test_a_shark_hunts_only_its_quarry_and_then_rests(tmp_path):
    world = world_of(
        tmp_path,
        'name = "hunt"\nat_s = 0.5\nwho = { fish = 6 }\nhunts = { fish = 2 }',
        'after = "hunt"\ndelay_s = 12.0\nwho = { shoal = 1 }\nrests = true',
        'event = "hunting"\nof = { species = "blacktip_reef_shark" }\ncaption = "It hunts."',
    )
    minds, fishes = world.state.minds, world.state.fishes
    targets = set()
    gaps = [float(np.linalg.norm(fishes.position[SHARK] - fishes.position[2]))]
    for tick in range(round(12.4 / TICK_S)):
        step(world, NEUTRAL)
        assert tick * TICK_S > 0.5 or minds.intention[SHARK] != EAT
        if minds.intention[SHARK] == EAT:
            targets.add(int(minds.target[SHARK]))
        gaps.append(float(np.linalg.norm(fishes.position[SHARK] - fishes.position[2])))
    # It was 900 cm away, out of reach of its senses; once near, it may be lost for a moment.
    assert targets - {NOBODY} == {2}
    assert min(gaps) < gaps[0] - 300  # its quarry may get away again
    assert world.state.directions.cast[2].tolist() == [SHARK, 2]
    play(world, 3.0 + CHEW_S)  # it chews a last catch
    assert minds.intention[SHARK] != EAT
    assert minds.food[SHARK] == -1


def test_a_pair_is_brought_together_to_court(tmp_path):
    place = (-100.0, 150.0, -240.0)
    world = world_of(
        tmp_path,
        f'name = "pair"\npair = "nearest"\nwho = {{ shoal = 2 }}\nplace_cm = {list(place)}',
        'event = "courting"\nof = { shoal = 2 }\nafter = "pair"\nlights = true',
    )  # fmt: skip
    fishes, minds, log = world.state.fishes, world.state.minds, world.state.directions
    for _ in range(round(60 / TICK_S)):
        step(world, NEUTRAL)
        if log.times[1]:
            break
    assert log.times[1] == 1
    he, she = log.cast[1]
    assert {he, she} == set(PAIR)
    assert minds.male[he]
    assert not minds.male[she]
    assert (minds.courtship[list(PAIR)] == LOOPING).all()
    assert np.linalg.norm(fishes.position[list(PAIR)] - place, axis=1).max() < 120
    assert minds.betrothed[list(PAIR)].tolist() == [PAIR[1], PAIR[0]]


def test_a_hook_is_lowered_and_raised(tmp_path):
    hook = "\n[hook]\nposition_cm = [200, 0]\ndepth_cm = 200\nspeed_cm_s = 100\n"
    world = world_of(
        tmp_path,
        'name = "down"\nat_s = 0.5\nhook = "down"' + hook,
        'after = "down"\ndelay_s = 1.0\nhook = "up"',
        'at_s = 4.0\nhook = "down"',
    )
    sea = world.state.sea
    play(world, 0.4)
    assert sea.catch[0] == STOWED
    play(world, 1.0)
    assert sea.catch[0] == SINKING
    assert -100 < sea.hook[2] < -60
    play(world, 2.4)
    assert sea.catch[0] == LANDED
    play(world, 0.5)
    assert sea.catch[0] == SINKING


def test_hunger_and_fear_are_eased_held_and_released(tmp_path):
    world = world_of(
        tmp_path,
        "who = { shoal = 0 }\nfear = 0.8\nover_s = 1.0\nfor_s = 0.5",
        "at_s = 0.5\nwho = { shoal = 2 }\nhunger = 0.6\nlibido = 0.4\nover_s = 1.0",
    )
    minds = world.state.minds
    play(world, 0.5)
    assert minds.mental[0, FEAR] == pytest.approx(0.4, abs=0.1)
    play(world, 0.8)
    assert minds.mental[0, FEAR] == pytest.approx(0.8)
    assert minds.intention[1] == SCHOOL
    play(world, 0.7)
    assert minds.mental[0, FEAR] == minds.menaces[0] < 0.5
    assert minds.mental[PAIR[0], HUNGER] == pytest.approx(0.6, abs=0.05)
    assert minds.mental[PAIR[0], LIBIDO] == pytest.approx(0.4, abs=0.05)


def test_a_later_direction_takes_over_from_one_of_its_kind(tmp_path):
    world = world_of(
        tmp_path,
        "who = { shoal = 0 }\npath_cm = [[0, 300, -250], [0, -300, -250]]\nloop = true\nfear = 0",
        "at_s = 1.0\nwho = { shoal = 2 }\npath_cm = [[0, 0, -250]]\nlikes = ['cold']",
        "at_s = 2.0\nwho = { species = 'fusilier' }\npath_cm = [[200, 0, -250]]",
        "at_s = 1.2\nwho = { shoal = 2 }\nlikes = ['warmth']\nfor_s = 0.5",
        "at_s = 2.0\nwho = { shoal = 2 }\nlikes = ['darkness']",
        "at_s = 2.2\nwho = { shoal = 2 }\npath_cm = [[0, 90, -250]]",
    )
    minds, log, pair = world.state.minds, world.state.directions, list(PAIR)
    play(world, 1.5)
    assert log.running.tolist() == [True, True, False, True, False, False]
    assert set(minds.fancy[pair]) == {1 << HABITS.index("warmth")}
    play(world, 0.4)  # the likes that took over are done, the path is not
    assert log.running.tolist() == [True, True, False, False, False, False]
    assert set(minds.fancy[pair]) == {-1}
    assert minds.errand[pair].any()
    play(world, 0.6)  # the end of a path leaves later likes alone
    assert log.running.tolist() == [False, False, True, False, True, True]
    assert minds.waypoint[0].tolist() == [200, 0, -250]
    assert (minds.fright < 0).all()
    assert set(minds.fancy[pair]) == {1 << HABITS.index("darkness")}


ANY = Shoals(["fusilier", "blacktip_reef_shark", "clownfish"], [6, 1, 2],
             ["prey"] * 6 + ["predator"] + ["pacifist"] * 2)  # fmt: skip
WITHIN = st.tuples(st.floats(-500, 500), st.floats(-500, 500), st.floats(-420, -60))


@settings(max_examples=examples(4), suppress_health_check=list(HealthCheck))
@given(st.data())
def test_any_directions_leave_the_world_valid_and_repeatable(tmp_path, data):
    """Two runs are equal, one restored from a snapshot; all is finite and in bounds."""
    bare = scenario_of(tmp_path)
    hook = Hook(position_cm=(100.0, 0.0), depth_cm=200.0)
    chosen = data.draw(directions(ANY, [], True, WITHIN))
    scenario = replace(bare, direction=chosen, hook=hook)
    check_scenario(scenario)
    one, other = create_world(scenario), create_world(scenario)
    play(one, 1.5)
    between = snapshot.take(one)
    play(one, 1.5)
    play(other, 0.1)
    snapshot.restore(other, between)
    play(other, 1.5)
    assert snapshot.checksum(one) == snapshot.checksum(other)
    for name, array in snapshot.changing(one).items():
        assert snapshot.may_be_infinite(name) or np.isfinite(array).all(), name
    position = one.state.fishes.position
    assert np.hypot(position[:, 0], position[:, 1]).max() < scenario.bounds.radius_cm
    assert position[one.state.fishes.alive, 2].max() < 0.0
    assert to_scenario(one) == scenario  # directions do not change the exported scenario


@pytest.mark.nightly
@pytest.mark.parametrize("seed", only([7], [3, 7]))
def test_a_pair_courts_in_front_while_a_shark_hunts_a_school_behind(seed):
    spec = spec_from_file_location("figures", ROOT / "docs/rendezvous_figures.py")
    figures = module_from_spec(spec)
    spec.loader.exec_module(figures)
    found = figures.rendezvous(seed, enough=True)
    assert found["so"], found


def test_a_direction_can_be_set_on_the_command_line():
    scenario = load_scenario("rendezvous", ["direction.0.at_s=5"]).scenario
    assert scenario.direction[0].at_s == 5.0
    with pytest.raises(UserError, match="direction"):
        load_scenario("rendezvous", ["direction.0.at_s=-1"])


def test_directions_work_with_any_number_of_fishes():
    nearest = ["direction.11.pair=nearest", "direction.11.who.shoal=0"]
    for number in (0, 1, 20):
        world = create_world(load_scenario("rendezvous", nearest)[0], fish=number)
        play(world, 0.5)
        assert world.state.directions.times[0] == 1


@pytest.mark.parametrize(
    ("direction", "words"),
    [
        (
            "who = { shoal = 0 }\npath_cm = [[0, 0, -100], [0, 0, -499]]",
            "path_cm[1]` (0.0, 0.0, -4",
        ),
        ("pair = [7, 8]\nplace_cm = [0, 0, -499]", "`direction[0].place_cm` (0.0, 0.0, -4"),
    ],
)
def test_places_below_the_seabed_are_refused(tmp_path, direction, words):
    with pytest.raises(UserError) as fault:
        world_of(tmp_path, direction)
    assert words in str(fault.value)
    assert "below the seabed" in str(fault.value)


def test_removing_fishes_removes_their_directions(tmp_path):
    scenario = scenario_of(
        tmp_path,
        "pair = [7, 8]",
        'name = "it"\nwho = { fish = 6 }\nrests = true',
        'after = "it"\nlights = true',
        "who = { shoal = 2 }\nhunger = 1.0",
    )
    left = removed(scenario, Handle("fish", 1, (0, 0, 0), None, None)).direction
    assert [one.pair for one in left] == [(6, 7), None]
    assert left[1].who.shoal == 1


def test_events_are_noticed_with_the_fishes_they_are_about(tmp_path):
    events = ("eaten", "caught", "sated", "fleeing", "spawned")
    of = ("shoal = 0", "fish = 7", "shoal = 1", "shoal = 0", "species = 'clownfish'")
    world = world_of(
        tmp_path,
        *(f'name = "{event}"\nevent = "{event}"\nof = {{ {whose} }}\nonce = false'
          for event, whose in zip(events, of, strict=True)),
        'name = "few"\nfewer_than = 6\nof = { shoal = 0 }',
        'name = "later"\nat_s = 0.3\nevent = "fleeing"',
    )  # fmt: skip
    state, log = world.state, world.state.directions
    minds, fishes, sea = state.minds, state.fishes, state.sea

    def now():
        """Counts of events after another tick."""
        direct(world.script, state, world.nature, (0.0, 0.0), Clock(1, state.tick, TICK_S))
        state.tick += 1
        return dict(zip((*events, "few", "later"), log.times.tolist(), strict=True))

    set_hunger(minds, np.array([SHARK]), 1.0, 0.0)
    assert set(now().values()) == {0}
    fishes.alive[3] = False
    minds.last_meal[SHARK] = TICK_S
    assert now() == dict.fromkeys(now(), 0) | {"eaten": 1, "few": 1}
    assert log.cast[0].tolist() == [3, SHARK]
    sea.catch[:] = HOOKED, 7
    assert now()["caught"] == 1
    set_hunger(minds, np.array([SHARK]), 0.0, 0.2)
    minds.mental[4, FEAR], minds.predator[4] = 0.9, SHARK
    then = now()
    assert (then["sated"], then["fleeing"], then["later"]) == (1, 1, 0)
    assert log.cast[3].tolist() == [4, SHARK]
    assert now() == then  # it continues, but is not a new event
    minds.mental[4, FEAR] = 0.0
    now()
    minds.mental[4, FEAR] = 0.9
    assert now()["fleeing"] == 2
    minds.courtship[list(PAIR)] = SPAWNING
    now()
    minds.courtship[list(PAIR)] = NO_COURTSHIP
    minds.shunned[list(PAIR)] = PAIR[::-1]
    minds.last_mating[list(PAIR)] = (state.tick - 1) * TICK_S
    last = now()
    assert (last["spawned"], last["later"], last["eaten"]) == (1, 1, 1)
    assert set(log.cast[4].tolist()) == set(PAIR)
    assert minds.male[log.cast[4, 0]]


def test_examples_in_documents_are_valid():
    """The rendezvous accepts each example as directions."""
    text = (ROOT / "docs" / "how-to" / "directing.md").read_text()
    examples = re.findall(r"```toml\n(\[\[direction\]\].*?)```", text, re.DOTALL)
    assert len(examples) >= 3
    content = tomllib.loads((ROOT / "assets/scenarios/rendezvous.toml").read_text())
    content["hook"] = {"position_cm": [0, 0], "depth_cm": 100.0}
    for example in examples:
        shown = tomllib.loads(example)["direction"]
        names = {one.get("name") for one in shown}
        others = [one for one in content["direction"] if one.get("name") not in names]
        scenario = msgspec.convert(content | {"direction": others + shown}, Scenario)
        check_scenario(scenario)
