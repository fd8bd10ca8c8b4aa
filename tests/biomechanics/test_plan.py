import msgspec
import pytest

from subsea.biomechanics.plan import BodyPlan, SwimPlan, TurnPlan
from subsea.species import Species


def test_the_length_is_that_of_the_last_station(species: Species) -> None:
    assert species.body.length == species.body.stations[-1]


@pytest.mark.parametrize(
    "stations",
    [[1, 2, 3, 4, 5, 6, 7], [0, 2, 2, 4, 5, 6, 7], [0, 2, 3, 4, 6, 5, 7]],
)
def test_stations_that_do_not_run_backwards_from_the_nose_are_refused(
    fusilier: Species, stations: list[float]
) -> None:
    table = msgspec.to_builtins(fusilier.body) | {"stations": stations}
    with pytest.raises(msgspec.ValidationError, match="increase from nose to tail"):
        msgspec.convert(table, BodyPlan)


@pytest.mark.parametrize(
    ("key", "value"),
    [("tail_half_height", 0.0), ("viscosity", -1.0), ("masses", [1.0] * 6), ("colour", 1)],
)
def test_impossible_bodies_are_refused(fusilier: Species, key: str, value: object) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(msgspec.to_builtins(fusilier.body) | {key: value}, BodyPlan)


@pytest.mark.parametrize(
    ("key", "value"), [("contraction", [0.7, 0.4]), ("slow", 1.2), ("ticks_per_beat", 2)]
)
def test_impossible_gaits_are_refused(fusilier: Species, key: str, value: object) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(msgspec.to_builtins(fusilier.swim) | {key: value}, SwimPlan)


def test_a_steering_map_must_increase(fusilier: Species) -> None:
    table = msgspec.to_builtins(fusilier.turn)
    table["steering"] = table["steering"][::-1]
    with pytest.raises(msgspec.ValidationError, match="must increase"):
        msgspec.convert(table, TurnPlan)
