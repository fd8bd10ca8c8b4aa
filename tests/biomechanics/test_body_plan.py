import math
from pathlib import Path

import msgspec
import pytest

from subsea.biomechanics.body_plan import BodyPlan, SwimPlan, TurnPlan
from subsea.core.errors import UserError
from subsea.core.resources import resource_path
from subsea.core.toml_files import load_toml
from subsea.fish.species import Species


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
    ("key", "value", "words"),
    [
        ("tail_half_height", 0.0, "> 0.0"),
        ("tail_half_height", 15.0, "tail_half_height = 15; expected"),
        ("half_widths", [0.4, 0.9, 1e-3, 0.8, 0.7], r"half_widths\[2\] = 0.001; expected"),
        ("half_heights", [0.5, 1.1, 30.0, 1.4, 1.2], r"half_heights\[2\] = 30; expected"),
        ("half_heights", [0.5, 1.1, math.inf, 1.4, 1.2], "= inf; expected"),
        ("half_heights", [0.5, 1.1, math.nan, 1.4, 1.2], "> 0.0"),
        ("stations", [0, 2.1, 2.2, 10.6, 14.4, 17.5, 20.5], r"stations\[2\] is 0.1 cm behind"),
        ("stations", [0, 10, 20, 30, 40, 50, 200], r"stations\[6\] = 200; expected 10 to 40 cm"),
        ("masses", [1.0] * 6, "length 7"),
        ("masses", [1.1, 6.6, 250_000.0, 6.6, 1.1, 1.1, 0.2], "sum of masses = 1.00006e"),
        ("masses", [1e-3] * 7, "sum of masses = 0.023; expected"),
        ("viscosity", -1.0, "> 0.0"),
        ("muscle_stiffness", math.inf, "<= 100000"),
        ("stations", [0, 2.1, math.nan, 10.6, 14.4, 17.5, 20.5], "increase"),
        ("colour", 1, "unknown field"),
    ],
)
def test_impossible_bodies_are_refused(
    fusilier: Species, key: str, value: object, words: str
) -> None:
    with pytest.raises(msgspec.ValidationError, match=words):
        msgspec.convert(msgspec.to_builtins(fusilier.body) | {key: value}, BodyPlan)


@pytest.mark.parametrize(
    ("key", "value"),
    [("contraction", [0.7, 0.4]), ("slow", 1.2), ("slow", 0.6), ("ticks_per_beat", 2)],
)
def test_impossible_gaits_are_refused(fusilier: Species, key: str, value: object) -> None:
    with pytest.raises(msgspec.ValidationError, match=key if value != 0.6 else "less than medium"):
        msgspec.convert(msgspec.to_builtins(fusilier.swim) | {key: value}, SwimPlan)


def test_a_steering_map_must_increase(fusilier: Species) -> None:
    table = msgspec.to_builtins(fusilier.turn)
    table["steering"] = table["steering"][::-1]
    with pytest.raises(msgspec.ValidationError, match="must increase"):
        msgspec.convert(table, TurnPlan)


def test_a_sharp_turn_lies_within_the_steering_map(fusilier: Species) -> None:
    table = msgspec.to_builtins(fusilier.turn)
    table |= {"sharp": 80.0, "steering": table["steering"][:3]}
    with pytest.raises(msgspec.ValidationError, match="ends at 60 degrees"):
        msgspec.convert(table, TurnPlan)


def test_mass_and_volume_of_a_box_with_pyramids_at_its_ends(fusilier: Species) -> None:
    box = msgspec.structs.replace(
        fusilier.body,
        stations=(0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0),
        half_widths=(1.0,) * 5,
        half_heights=(2.0,) * 5,
        masses=(1.0,) + (4.0,) * 5 + (2.0,),
    )
    assert box.hull_volume == pytest.approx(8 * (12 + 1.5 + 1.5))
    assert box.mass == 1 + 20 * 4 + 4


@pytest.mark.parametrize(
    ("line", "other", "words"),
    [
        ("1.1, 0.165]", "1.1, -0.165]", "body.masses"),
        ("1.1, 0.165]", "1.1, 0.05]", "masses[6] = 0.05 g is too light for the stiffness"),
        ("muscle_stiffness = 28.0", "muscle_stiffness = 2800.0", "too light for the stiffness"),
        ("viscosity = 0.1", "viscosity = 10.0", "too light for the stiffness"),
        ("half_widths = [0.47", "half_widths = [0.0", "body.half_widths"),
        ("half_widths = [0.47", "half_widths = [47.0", "half_widths[0] = 47"),
    ],
)
def test_an_absurd_body_in_a_file_is_one_line(
    tmp_path: Path, line: str, other: str, words: str
) -> None:
    text = resource_path("assets/species/fusilier.toml").read_text()
    assert line in text
    file = tmp_path / "mine.toml"
    file.write_text(text.replace(line, other))
    with pytest.raises(UserError) as caught:
        load_toml(file, Species)
    assert str(file) in str(caught.value)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
