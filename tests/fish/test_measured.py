"""The table of measured fishes: complete, and strict."""

import pytest

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.fish import measured
from subsea.fish.measured import ITSELF, MeasuredRange, load_measured, measured_species
from subsea.fish.species import load_species, shipped_species

RANGES = ("slow", "cruise", "burst")


def test_every_shipped_species_has_sourced_speeds_in_order():
    table = load_measured()
    assert sorted(table.species) == shipped_species()
    for name, facts in table.species.items():
        species = load_species(name)
        lows = [getattr(facts, key).range[0] for key in RANGES]
        assert lows == sorted(lows)
        assert (facts.gait in ("eel", "ray")) == (species.spine is not None)
        for key in facts.__struct_fields__:
            value = getattr(facts, key)
            if isinstance(value, MeasuredRange):
                assert value.of not in ("", species.scientific_name), f"{name}: {ITSELF}"
    elsewhere = {"borazjani_2008", "lighthill_1971", "tunstrom_2013"}
    assert not set(table.sources) - used(table) - elsewhere


def used(table):
    """The sources that ranges name."""
    groups = [*table.species.values(), table.posture, table.coasting, table.schools]
    groups += [table.predation, table.minds, table.budget]
    values = [getattr(group, key) for group in groups for key in group.__struct_fields__]
    return {value.source for value in values if isinstance(value, MeasuredRange)}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('source = "webb_keyes_1982"', 'source = "webb_keyes"', "unknown source"),
        ("range = [0.3, 0.6]", "range = [0.6, 0.3]", "smaller number first"),
        ("range = [0.3, 0.6]", "range = [0.3]", "expected a list"),
        ('gait = "ram"', 'gait = "run"', "unknown value 'run'"),
        ("slow = ", "slowly = ", "slowly"),
    ],
)
def test_a_fault_is_one_line_with_its_place(tmp_path, old, new, told):
    text = (resource_path("assets") / measured.FILE).read_text()
    assert old in text
    path = tmp_path / measured.FILE
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(UserError, match=told) as fault:
        load_measured(path)
    assert fault.value.line and "\n" not in str(fault.value)


def test_an_unknown_species_is_named_with_the_nearest():
    with pytest.raises(UserError, match="did you mean 'fusilier'"):
        measured_species(load_measured(), "fusiler")
