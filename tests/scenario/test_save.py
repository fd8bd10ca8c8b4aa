"""Scenarios written: given back as they were, and no byte changed without need."""

import difflib
import typing

import msgspec
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from msgspec import inspect

from subsea.base.errors import UserError
from subsea.base.system import resource_names, resource_path
from subsea.fish.species import species_names
from subsea.scenario import schema as tables
from subsea.scenario.load import load_scenario
from subsea.scenario.save import save_scenario, scenario_text
from subsea.scenario.schema import Pillar, Rock, Scenario
from subsea.scenario.school_rules import MAX_GOALS, Goal, SchoolRules
from subsea.scenario.shoals import shoals_of
from tests.support.daily import examples
from tests.support.directions import directions

NAMES = resource_names("assets/scenarios", ".toml")
replace = msgspec.structs.replace


def drawn(kind):
    """Values of a type as msgspec describes it, within its limits."""
    match kind:
        case inspect.IntType(ge=low, le=high, lt=below):
            return st.integers(low or 0, min(high or 2**32, (below or 2**32) - 1, 40))
        case inspect.FloatType(gt=above, ge=low, le=high):
            least = above if low is None else low
            return st.floats(least, high, exclude_min=low is None, allow_nan=False)
        case inspect.BoolType():
            return st.booleans()
        case inspect.StrType():
            return st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=20)
        case inspect.LiteralType(values=values):
            return st.sampled_from(values)
        case inspect.NoneType():
            return st.none()
        case inspect.UnionType(types=types):
            return st.one_of(*map(drawn, types))
        case inspect.ListType(item_type=item, min_length=low):
            return st.lists(drawn(item), min_size=low or 0, max_size=3)
        case inspect.TupleType(item_types=items):
            return st.tuples(*map(drawn, items))
        case inspect.DictType(key_type=key, value_type=value):
            return st.dictionaries(drawn(key), drawn(value), max_size=3)
        case inspect.StructType(cls=cls):
            return structs(cls)
    raise AssertionError(kind)


def structs(cls):
    fields = {
        field.name: drawn(field.type)
        for field in typing.cast(inspect.StructType, inspect.type_info(cls)).fields
    }
    fields |= OWN.get(cls, {})

    def made(values):
        try:
            return cls(**values)
        except ValueError:
            assume(False)

    return st.fixed_dictionaries(fields).map(made)


# Tables that a scenario needs together to be loaded.
BOUNDS = tables.Bounds(radius_cm=2000.0, depth_cm=600.0)
AXIS = st.floats(-1000.0, 1000.0)
HERE, THERE = st.tuples(AXIS, AXIS), st.tuples(AXIS, AXIS, st.floats(-600.0, 0.0))
MAYBE_HERE, MAYBE_THERE = st.none() | HERE, st.none() | THERE
SIZES = st.none() | st.tuples(st.floats(2.0, 20.0), st.floats(20.0, 300.0))
PLACED = {"position_cm": HERE}
# Any of these fit together in any tables.
RULES = {
    "separation_bl": st.none() | st.floats(0.1, 0.9),
    "attraction_bl": st.none() | st.floats(0.95, 2.0),
    "full_attraction_bl": st.none() | st.floats(2.1, 50.0),
    "goals": st.none() | st.lists(st.deferred(lambda: structs(Goal)), max_size=MAX_GOALS),
}
OWN = {
    Goal: {
        "share": st.floats(0.0, 0.4), "position_cm": st.none(), "heading_deg": st.floats(-180, 180)
    },
    SchoolRules: RULES,
    tables.SchoolTable: RULES | {"species": st.just({})},
    tables.Start: {"position_cm": THERE},
    tables.Shoal: {
        "species": st.sampled_from(species_names()), "position_cm": MAYBE_THERE,
        "toward_cm": MAYBE_THERE, "size_cm": SIZES,
    },
    tables.Hook: PLACED | {"depth_cm": st.floats(1.0, 600.0)},
    tables.SeaweedTable: {"position_cm": MAYBE_HERE},
    tables.ReefTable: {"position_cm": MAYBE_HERE},
    **dict.fromkeys(
        (
            tables.Pillar, tables.Rock, tables.Outcrop, tables.Ridge, tables.Arch, tables.Vent,
            tables.CoralTable, tables.Wreck,
        ),
        PLACED,
    ),
}  # fmt: skip
TOUR = load_scenario("visitors")[0].tour
LISTS = ["pillar", "rock", "outcrop", "arch", "seaweed", "vent", "reef", "wreck"]


@st.composite
def scenarios(draw):
    """Any scenario that can be loaded; its tours those of the lagoon."""
    values = {
        field.name: draw(drawn(field.type))
        for field in inspect.type_info(Scenario).fields
        if field.name not in ("bounds", "tour", "individual", "direction")
    }
    of_species = {values["fish"][0].species: draw(structs(SchoolRules))}
    values["school"] = replace(values["school"], species=of_species)
    fishes = sum(shoal.number for shoal in values["fish"])
    several = st.lists(structs(tables.IndividualTable), max_size=3, unique_by=lambda one: one.fish)
    individuals = [one for one in draw(several) if one.fish < fishes]
    tours = draw(st.sampled_from([[], TOUR])) if follows(values["fish"]) else []
    scenario = Scenario(**values, bounds=BOUNDS, individual=individuals, tour=tours)
    names, hook = [tour.name for tour in tours], scenario.hook is not None
    directed = draw(directions(shoals_of(scenario), names, hook, THERE))
    return replace(scenario, direction=directed)


def follows(shoals):
    wanted = {point.follow for tour in TOUR for point in tour.waypoint} - {None}
    return wanted <= {shoal.species for shoal in shoals}


FEW = settings(
    max_examples=examples(8),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)


@FEW
@given(scenarios())
def test_saved_scenarios_load_equally(tmp_path, scenario):
    path = tmp_path / "mine.toml"
    save_scenario(scenario, path)
    assert load_scenario(str(path))[0] == scenario


@pytest.mark.nightly
@FEW
@given(scenarios(), st.sampled_from(NAMES))
def test_scenarios_saved_over_a_file_with_comments_load_equally(tmp_path, scenario, name):
    path = tmp_path / "mine.toml"
    like = resource_path(f"assets/scenarios/{name}.toml")
    save_scenario(scenario, path, like)
    assert load_scenario(str(path))[0] == scenario
    assert path.read_text().startswith(like.read_text().splitlines()[0])


@pytest.mark.parametrize("name", NAMES)
def test_an_unchanged_scenario_keeps_every_byte(tmp_path, name):
    scenario, like, _ = load_scenario(name)
    save_scenario(scenario, tmp_path / "mine.toml", like)
    assert (tmp_path / "mine.toml").read_bytes() == like.read_bytes()
    windows = like.read_bytes().replace(b"\n", b"\r\n")
    (tmp_path / "windows.toml").write_bytes(windows)
    save_scenario(scenario, tmp_path / "mine.toml", tmp_path / "windows.toml")
    assert (tmp_path / "mine.toml").read_bytes() == windows


def differing(scenario, like):
    """Lines that are taken away from and added to the file `like`."""
    old, new = like.read_text().splitlines(), scenario_text(scenario, like).splitlines()
    lines = [line for line in difflib.ndiff(old, new) if line[0] in "+-"]
    return [[line[2:] for line in lines if line[0] == sign] for sign in "-+"]


def test_one_changed_number_is_one_line():
    scenario, like, _ = load_scenario("peaceful")
    school, *others = scenario.fish
    assert differing(replace(scenario, fish=[replace(school, number=20), *others]), like) == [
        ["number = 33"], ["number = 20"],
    ]  # fmt: skip
    assert differing(replace(scenario, fish=[replace(school, digestion=0.5), *others]), like) == [
        ["digestion = 0.002  # 1/s: in a school a fish feeds only on what is in its way"],
        ["digestion = 0.5  # 1/s: in a school a fish feeds only on what is in its way"],
    ]
    reef = [replace(scenario.reef[0], rock=0.9), *scenario.reef[1:]]
    old, new = differing(replace(scenario, reef=reef), like)
    assert len(old) <= 1
    assert new == ["rock = 0.9"]
    moved = [*scenario.arch[:-1], replace(scenario.arch[-1], position_cm=(91.5, -10.0))]
    assert differing(replace(scenario, arch=moved), like) == [
        ["position_cm = [90.0, -10.0]"], ["position_cm = [91.5, -10.0]"],
    ]  # fmt: skip
    assert differing(replace(scenario, seed=5), like) == [["seed = 1"], ["seed = 5"]]
    assert differing(replace(scenario, simulated=3), like) == [[], ["simulated = 3"]]
    nature = replace(scenario.nature, keen=0.4)
    assert differing(replace(scenario, nature=nature), like) == [
        [], ["", "[nature]", "keen = 0.4"],
    ]  # fmt: skip
    tour = scenario.tour[0]
    points = [*tour.waypoint[:-1], replace(tour.waypoint[-1], time_s=1000.5)]
    old, new = differing(replace(scenario, tour=[replace(tour, waypoint=points)]), like)
    assert len(old) == len(new) == 1
    assert "time_s = 1000.5" in new[0]


def test_added_and_removed_tables_change_only_their_lines():
    scenario, like, _ = load_scenario("peaceful")
    fewer = [*scenario.rock[:1], *scenario.rock[2:]]
    old, new = differing(replace(scenario, rock=fewer), like)
    assert new == []
    assert old.count("[[rock]]") == 1
    assert len(old) <= 6
    rock = Rock(position_cm=(12.5, 3.0), size_cm=(20.0, 30.0, 10.0))
    old, new = differing(replace(scenario, rock=[*scenario.rock, rock]), like)
    assert old == []
    assert sorted(new) == sorted(
        ["[[rock]]", "position_cm = [12.5, 3.0]", "size_cm = [20.0, 30.0, 10.0]", ""]
    )
    pillar = Pillar(position_cm=(5.0, 5.0), radius_cm=20.0, height_cm=80.0)
    old, new = differing(replace(scenario, pillar=[pillar]), like)
    assert old == []
    assert len(new) == 5


def test_a_file_from_scratch_reads_well():
    scenario = load_scenario("preying").scenario
    text = scenario_text(replace(scenario, tour=TOUR[:0], reef=[], seaweed=[], rock=[]))
    head = (
        'title = "Preying"\ndescription = "A hungry reef shark hunts in the channels of a reef."\n'
    )
    assert text.startswith(f"{head}seed = 2\nsimulated = 6\n\n[bounds]\nradius_cm = ")
    headers = [line for line in text.splitlines() if line.startswith("[")]
    order = [field.name for field in msgspec.structs.fields(Scenario)]
    keys = [header.strip("[]") for header in headers]
    assert keys == sorted(keys, key=order.index)
    assert "male_share" not in text  # as by default
    assert "\n\n\n" not in text


@pytest.mark.parametrize(
    "text",
    [
        "title = 'A'\nseed = 1\nbounds = { radius_cm = 900, depth_cm = 500 }\n"
        "water.fog = [0, 0, 0]\nwater.visibility_cm = 900\n"
        "fish = [{ species = 'fusilier', number = 3 }]\n"
        "[terrain]\ndune_height_cm = 0\ndune_length_cm = 90\n"
        "[submarine]\nposition_cm = [\n    0.0,  # here\n    0.0,\n    -200.0,\n]",
        "seed = 1\n[[fish]]\nspecies = 'fusilier'\nnumber = 3\n[title_]\n",
        "not a scenario [",
    ],
)
def test_files_in_other_notations_are_edited_or_rewritten(tmp_path, text):
    like, path = tmp_path / "like.toml", tmp_path / "mine.toml"
    like.write_text(text)
    scenario = load_scenario(str(like))[0] if "bounds" in text else load_scenario("preying")[0]
    shoal = replace(scenario.fish[0], number=7)
    start = replace(scenario.submarine, position_cm=(1.0, 2.0, -150.0))
    for change in (
        {"fish": [shoal, *scenario.fish[1:]]}, {"fish": [shoal, *scenario.fish]},
        {"submarine": start, "water": replace(scenario.water, plankton=9)},
    ):  # fmt: skip
        changed = replace(scenario, **change)
        save_scenario(changed, path, like)
        assert load_scenario(str(path))[0] == changed
    assert ("# here" in path.read_text()) == ("bounds" in text)


def test_a_scenario_that_cannot_be_loaded_is_not_written(tmp_path):
    scenario = load_scenario("preying").scenario
    path = tmp_path / "mine.toml"
    path.write_text("what was there\n")
    for wrong, words in (
        (replace(scenario, fish=[replace(scenario.fish[0], number=-1)]), "number"),
        (replace(scenario, fish=[replace(scenario.fish[0], species="shrak")]), "shrak"),
        (replace(scenario, submarine=replace(scenario.submarine, position_cm=(9e4, 0.0, 0.0))),
         "submarine.position_cm"),
    ):  # fmt: skip
        with pytest.raises(UserError, match=words):
            save_scenario(wrong, path)
    assert path.read_text() == "what was there\n"
    with pytest.raises(UserError, match="cannot write"):
        save_scenario(scenario, tmp_path / "mine.toml" / "below.toml")
    assert [file.name for file in tmp_path.iterdir()] == ["mine.toml"]
