"""Parameters that panels edit: saving, restoring, and their effect."""

import numpy as np
import pytest

from subsea.scenario.load import load_scenario
from subsea.state import TRAITS
from subsea.submarine.vessel import NEUTRAL
from subsea.world import snapshot
from subsea.world.build import create_world
from subsea.world.step import step
from subsea.world.to_scenario import equal_tunables, get_tunables, set_tunables


def made():
    return create_world(load_scenario("mating")[0])


def stepped(world, ticks):
    for _ in range(ticks):
        step(world, NEUTRAL)
    return snapshot.checksum(world)


def change_all(world):
    """Change every parameter."""
    world.nature = world.nature._replace(keen=0.05, vision_cm=200.0)
    world.current_cm_s = (80.0, -20.0)
    for name in TRAITS:
        values = getattr(world.state.minds, name)
        if values.dtype == np.bool_:
            values[...] = ~values
        elif name == "kind":
            values[...] = (values + 1) % 2
        else:
            values[...] *= 1.5


@pytest.mark.nightly
def test_a_world_with_restored_parameters_continues_as_before():
    world, twin = made(), made()
    stepped(world, 40), stepped(twin, 40)
    then, bytes_then = get_tunables(world), snapshot.take(world)
    change_all(world)
    assert stepped(world, 30) != stepped(twin, 30)
    for name in TRAITS:
        assert (getattr(world.state.minds, name) != then.traits[name]).any(), name
    set_tunables(world, then)
    snapshot.restore(world, bytes_then)
    assert stepped(world, 30) == snapshot.checksum(twin)
    assert equal_tunables(get_tunables(world), then)


def test_each_parameter_counts_as_a_difference():
    world = made()
    before = get_tunables(world)
    assert equal_tunables(before, get_tunables(world))
    for change in (
        {"nature": world.nature._replace(keen=0.1)},
        {"current_cm_s": (1.0, 0.0)},
        {"physics": world.physics._replace(stiffness=2.0)},
        *({"traits": before.traits | {name: before.traits[name] + 1}} for name in TRAITS[4:]),
        *({"traits": before.traits | {name: before.traits[name] ^ 1}} for name in TRAITS[:4]),
    ):
        assert not equal_tunables(before, before._replace(**change)), change


def test_the_current_changes_at_once():
    world = made()
    stepped(world, 60)
    drifts = []
    for current in ((0.0, 0.0), (40.0, 0.0), (0.0, -40.0)):
        world.current_cm_s = current
        step(world, NEUTRAL)
        drifts.append(world.state.fishes.drift.mean(axis=0))
    still, east, south = drifts
    assert abs(still).max() == 0.0
    assert east[0] > 20.0 * abs(east[1])
    assert south[1] < -20.0 * abs(south[0])
