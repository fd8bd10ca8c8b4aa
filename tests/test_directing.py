"""Directions: what is to happen, and when."""

import numpy as np
import pytest

from subsea import snapshot
from subsea.directing import latest
from subsea.errors import UserError
from subsea.ocean import TICK_S, create_world, step
from subsea.scenario import load_scenario
from subsea.submarine.helm import HANDS_OFF, Helm

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
heading_deg = 0.0
hunger = 0.0
digestion = 0.0
[[fish]]
species = "blacktip_reef_shark"
number = 1
position_cm = [600.0, 300.0, -250.0]
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
    """The bare sea with these `[[direction]]`."""
    file = folder / "directed.toml"
    file.write_text(SEA + "".join(f"[[direction]]\n{one}\n" for one in directions))
    return load_scenario(str(file))[0]


def world_of(folder, *directions, **more):
    return create_world(scenario_of(folder, *directions), **more)


def play(world, seconds, order=HANDS_OFF):
    for _ in range(round(seconds / TICK_S)):
        step(world, order)


def begun_s(world):
    """When each direction began last, s; -1 for never."""
    began = world.state.directions.began
    return [round(float(tick) * TICK_S, 1) if tick >= 0 else -1 for tick in began]


def test_a_school_follows_the_path_of_its_leader_and_then_its_own_ways(tmp_path):
    world = world_of(
        tmp_path,
        'who = { shoal = 0 }\nspeed_cm_s = 20.0\npath_cm = [[-150, 120, -250], [0, 0, -250]]',
    )  # fmt: skip
    leader, directions = world.state.fishes.position[0], world.state.directions
    nearest = np.inf
    for _ in range(round(40 / TICK_S)):
        step(world, HANDS_OFF)
        nearest = min(nearest, float(np.linalg.norm(leader - (-150, 120, -250))))
        if not directions.running[0]:
            break
    assert nearest < 80
    assert np.linalg.norm(leader - (0, 0, -250)) < 80
    middle = np.median(world.state.fishes.position[:6], axis=0)
    assert np.linalg.norm(middle - leader) < 120
    assert not world.state.minds.errand.any()


def test_directions_follow_one_another_and_what_happens(tmp_path):
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


def test_a_snapshot_amid_directions_goes_on_alike(tmp_path):
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
        ('who = { shoal = 0 }\npath_cm = [[0, 0, -700]]', "`direction[0].path_cm[0]`"),
        ('event = "passes"\nlights = true', "`direction[0].gate_cm`"),
        ('hook = "down"', "`direction[0].hook`: expected a table [hook]"),
        ('after = "nobody"\nlights = true', "`direction[0].after`: unknown direction 'nobody'"),
        ('name = "a"\nafter = "a"\nlights = true', "`direction[0].after`: it waits for itself"),
        ('camera = { tour = "round" }', "`direction[0].camera.tour`: unknown tour"),
        ('camera = { position_cm = [0, 0, -200] }', "expected `tour`, `look_at_cm` or `follow`"),
    ],
)  # fmt: skip
def test_a_faulty_direction_is_one_line(tmp_path, direction, words):
    with pytest.raises(UserError) as fault:
        scenario_of(tmp_path, direction)
    assert words in str(fault.value)
    assert "directed.toml" in str(fault.value)
    assert "\n" not in str(fault.value)
