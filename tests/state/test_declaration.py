"""Declarations of the state: complete, and what is derived from them."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from subsea.scenario.load import load_scenario
from subsea.state import GROUPS, TRAITS, Fishes, Minds, Submarine, arrays, declared, empty
from subsea.state.declaration import F32, I32, NUMBER, creation, motor
from subsea.world.build import create_world


class Group(NamedTuple):
    """Three members of every kind."""

    place: Annotated[F32, motor("n", 3, unit="cm", start=(1.0, 2.0, np.inf)), "where"]
    row: Annotated[I32, motor("n", start=-1, within=(-1, "rows")), "which"]
    width: Annotated[NUMBER, creation(unit="cm", start=4), "how wide"]


def test_an_empty_group_holds_the_start_values_and_what_is_given():
    group = empty(Group, n=2)
    assert group.place.dtype == np.float32
    np.testing.assert_array_equal(group.place, [[1, 2, np.inf]] * 2)
    assert group.row.tolist() == [-1, -1]
    assert group.width == 4.0
    assert type(group.width) is float
    row = np.arange(5)
    assert empty(Group, n=5, given={"row": row}).row is row
    with pytest.raises(TypeError, match="depth"):
        empty(Group, n=2, given={"depth": row})
    with pytest.raises(KeyError, match="n"):
        empty(Group)


def test_a_declaration_says_whether_an_array_is_saved_and_may_be_infinite():
    place, row, width = declared(Group).values()
    assert (place.saved, row.saved, width.saved) == (True, True, False)
    assert (place.may_be_infinite, row.may_be_infinite) == (True, False)
    assert (place.about, place.unit, place.writer) == ("where", "cm", "motor")
    assert (row.within, row.dtype) == ((-1, "rows"), np.int32)


def test_every_array_of_a_world_is_as_declared():
    world = create_world(load_scenario("rendezvous")[0], fish=12, live=2)
    for name, array, spec in arrays(world.state):
        assert array.dtype == spec.dtype, name
        assert array.ndim == len(spec.shape), name
        fixed = [size if isinstance(size, int) else -1 for size in spec.shape]
        assert all(size in (-1, have) for size, have in zip(fixed, array.shape, strict=True)), name
        assert spec.about, name
        if spec.saved and array.dtype.kind in "iu":
            assert spec.within is not None, name
    assert sum(len(declared(group)) for group in GROUPS.values()) == len([*arrays(world.state)])


def test_new_fishes_are_upright_alive_and_alone():
    fishes, minds = empty(Fishes, n=3), empty(Minds, n=3, b=5, d=4)
    assert fishes.orientation.tolist() == [[1, 0, 0, 0]] * 3
    assert fishes.alive.all()
    assert np.isinf(fishes.stay).all()
    assert minds.fatigue.shape == (5, 3)
    assert minds.desire.shape == (4, 3)
    assert (minds.partner == -1).all()
    assert set(TRAITS) < set(Minds._fields)


def test_a_submarine_starts_at_rest_where_it_is_put():
    boat = Submarine(position=np.array([1.0, 2.0, -3.0]))
    assert boat.position.tolist() == [1, 2, -3]
    assert not boat.velocity.any()
    assert not boat.lights[0]
    assert boat.angles is not Submarine(position=boat.position).angles
