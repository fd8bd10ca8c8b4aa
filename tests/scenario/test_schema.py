"""Scenario files: what is wrong is said in one line with file and key."""

import re

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.base.system import resource_names, resource_path
from subsea.fish.species import load_species
from subsea.frame.packet import make_scene, pack
from subsea.geometry.solids import height_at
from subsea.habitat.contact import clearances
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import JERLOV, Water, far_colour
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import cockpit, views_for
from subsea.world.build import create_world
from subsea.world.step import step

PEACEFUL = resource_path("assets/scenarios/peaceful.toml").read_text()
BARE = PEACEFUL.split("\n[[rock]]")[0]  # nothing stands on its seabed


def written(folder, text):
    """A file with that text."""
    file = folder / "mine.toml"
    file.write_text(text)
    return file


def world_of(folder, text):
    return create_world(load_scenario(str(written(folder, text)))[0])


def fault_of(folder, text):
    """The one line with which a scenario is refused, which begins with its file."""
    file = written(folder, text)
    with pytest.raises(UserError) as caught:
        create_world(load_scenario(str(file))[0], source=str(file))
    message = str(caught.value)
    assert re.match(rf"{file}(:\d+)?: ", message)
    assert "\n" not in message
    return message


@pytest.mark.parametrize("name", resource_names("assets/scenarios", ".toml"))
def test_shipped_scenarios_are_valid(name):
    scenario, path, _ = load_scenario(name)
    assert scenario.title
    assert path.stem == name


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("seed = 1", "sead = 1"), ["unknown key `sead`", "did you mean 'seed'"]),
        (("plankton = 1800", "planktn = 1800"), ["`planktn`", "water", "'plankton'"]),
        (("number = 33", "number = -1"), ["at least 0, got -1", "fish[0].number"]),
        (
            ("number = 33", 'number = 33\nkind = "pray"'),
            ["'pray'", "`fish[0].kind`", "'pacifist', 'predator', 'prey'"],
        ),
        (("number = 33", 'number = 33\nlikes = ["shade"]'), ["`fish[0].likes[0]`", "'darkness'"]),
        (("number = 33", "number = 33\nspread = 9.0"), ["`fish[0]`", "'spread_cm'"]),
        (("plankton = 1800", "current = 3"), ["`water`", "'current_cm_s'"]),
        (
            ('species = "fusilier"', 'species = "fuselier"'),
            ["`fish[0].species`", "'fuselier'", "'fusilier'"],
        ),
        (
            ("radius_cm = 1300.0", 'radius_cm = "wide"'),
            ["bounds.radius_cm", "expected a number, got 'wide'"],
        ),
        (("[water]", "[water"), ["not valid TOML"]),
        (
            ("size_cm = [16.0, 23.0]", "size_cm = [23.0, 16.0]"),
            ["`fish[0].size_cm`", "smallest first"],
        ),
        (('title = "Peaceful bay"', ""), ["missing key", "title"]),
        (("radius_cm = 1300.0", "radius_cm = nan"), ["bounds.radius_cm"]),
        (("-330.0]", "inf]"), ["position_cm"]),
        (("-330.0]", "5000.0]"), ["submarine.position_cm", "outside the sea"]),
        (("[-130.0, 40.0, -340.0]", "[-130.0, 4000.0, -340.0]"), ["fish[0].position_cm"]),
        (
            ("[-130.0, 40.0, -340.0]", "[-130.0, 40.0, -340.0]\ntoward_cm = [0.0, 0.0, 9.0]"),
            ["fish[0].toward_cm", "outside the sea"],
        ),
        (("[-130.0, 40.0, -340.0]", "[-130.0, 40.0, -340.0]\nleader_cm = 900.0"), ["leader_cm"]),
        (("seed = 1", "seed = 99999999999999999999999"), ["seed"]),
        (("seed = 7", "seed = 4294967296"), ["terrain.seed"]),
        (("[16.0, 23.0]", "[0.001, 23.0]"), ["fish[0].size_cm"]),
        (("dune_length_cm = 620.0", "dune_length_cm = 0.001"), ["terrain.dune_length_cm"]),
        (("number = 33", "number = 99999"), ["100026 fishes in all"]),
        (('type = "IB"', 'type = "2C"'), ["water.type", "'2C'"]),
        (('type = "IB"', 'type = "IB"\nhour = 25'), ["water.hour", "at most 24"]),
        (('type = "IB"', 'type = "IB"\nhour = -1'), ["water.hour", "at least 0"]),
        (
            ('type = "IB"', 'type = "IB"\nday_minutes = 0.5'),
            ["`water`", "`day_minutes` must be 0, which stops the clock, or at least 1"],
        ),
        (('type = "IB"', 'type = "IB"\nday_minutes = -2'), ["water.day_minutes", "at least 0"]),
        (("fog = [0.007, 0.080, 0.190]", "fog = [0.0, 0.1]"), ["water.fog"]),
        (
            ('type = "IB"\nfog = [0.007, 0.080, 0.190]', ""),
            ["`water`", "expected `fog`, or a `type` of water"],
        ),
    ],
)
def test_a_fault_is_one_line_that_names_file_and_key(tmp_path, change, words):
    assert change[0] in PEACEFUL
    message = fault_of(tmp_path, PEACEFUL.replace(*change))
    assert all(word in message for word in words)


def test_a_sea_without_fishes_is_a_sea(tmp_path):
    world = world_of(tmp_path, re.sub(r"(?m)^number = \d+", "number = 0", PEACEFUL))
    step(world, NEUTRAL)
    views = views_for("mono", (64, 36), cockpit(world.state.submarine, 1.0))
    assert len(pack(world, views, 1.0).instances) == 0


def test_an_unknown_name_suggests_the_nearest():
    with pytest.raises(UserError, match="did you mean 'peaceful'"):
        load_scenario("peacefull")


def test_species_are_numbered_as_the_scenario_says():
    scenario = load_scenario("peaceful").scenario
    world = create_world(scenario, fish=60)
    assert len(scenario.species) > 5
    assert [load_species(name).name for name in scenario.species] == [
        one.name for one in world.species
    ]


def test_a_shoal_without_sizes_has_those_of_its_species(tmp_path):
    file = written(tmp_path, PEACEFUL.replace("size_cm = [22.0, 32.0]\n", ""))
    world = create_world(load_scenario(str(file))[0], fish=2000)
    kind = [one.name for one in world.species].index("Emperor angelfish")
    lengths = world.state.fishes.length[world.state.fishes.species == kind]
    smallest, largest = load_species("emperor_angelfish").size_cm
    assert smallest <= lengths.min() < smallest + 1
    assert largest - 1 < lengths.max() <= largest


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", None])
def test_binary_files_are_refused(tmp_path, content):
    file = tmp_path / "mine.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(UserError, match="no such file" if content is None else "cannot read"):
        load_scenario(str(file))


def test_a_scenario_may_have_its_nearest_fishes_simulated(tmp_path):
    text = PEACEFUL.replace("-430.0, -60.0, -330.0", "-130.0, 40, -340")
    world = world_of(tmp_path, f"simulated = 2\n{text}")
    for _ in range(120):
        step(world, NEUTRAL)
    assert world.state.fishes.live.sum() == 2


BUSY = (
    BARE.replace("40.0, -340.0]", "40.0, -340.0]\ntoward_cm = [300.0, 300.0, -340.0]")
    + "\n[hook]\nposition_cm = [300.0, -300.0]\ndepth_cm = 340.0\n"
)


STANDS = {
    "pillar[0]": "\n[[pillar]]\nposition_cm = {}\nradius_cm = 60.0\nheight_cm = 500.0\n",
    "rock[0]": "\n[[rock]]\nposition_cm = {}\nsize_cm = [90.0, 90.0, 500.0]\n",
}


@pytest.mark.parametrize("solid", STANDS)
@pytest.mark.parametrize(
    ("place", "key", "expected"),
    [
        ("[-430.0, -150.0]", "submarine.position_cm", "expected at least 45 cm off it"),
        ("[-130.0, 45.0]", "fish[0].position_cm", "expected outside it"),
        ("[300.0, 310.0]", "fish[0].toward_cm", "expected outside it"),
        ("[300.0, -310.0]", "hook", "expected outside it"),
    ],
)
def test_starts_inside_solids_are_refused(tmp_path, solid, place, key, expected):
    """The submarine's hull must be clear of it too."""
    message = fault_of(tmp_path, BUSY + STANDS[solid].format(place))
    assert f": `{key}`" in message
    assert f"`{solid}`" in message
    assert message.endswith(expected)


@pytest.mark.parametrize(
    ("key", "given", "low"),
    [
        ("submarine.position_cm", "[-430.0, -60.0, -330.0]", "[{}, {}, {}]"),
        ("fish[0].position_cm", "[-130.0, 40.0, -340.0]", "[{}, {}, {}]"),
        ("fish[0].toward_cm", "[300.0, 300.0, -340.0]", "[{}, {}, {}]"),
        ("hook", "[300.0, -300.0]\ndepth_cm = 340.0", "[{}, {}]\ndepth_cm = {}"),
    ],
)
def test_starts_below_the_seabed_are_refused(tmp_path, key, given, low):
    scenario = load_scenario(str(written(tmp_path, BUSY)))[0]
    sea = create_world(scenario).state.sea
    z = height_at(sea.heights, sea.half_width, 700.0, 0.0) - 2.0
    assert z > -scenario.bounds.depth_cm  # not yet outside the sea
    assert BUSY.count(given) == 1
    text = BUSY.replace(given, low.format(700.0, 0.0, -z if key == "hook" else z))
    message = fault_of(tmp_path, text)
    assert f": `{key}` (700.0, 0.0, " in message
    assert "lies below the seabed, expected " in message


def test_a_pillar_stays_below_the_surface(tmp_path):
    pillar = "\n[[pillar]]\nposition_cm = [500.0, 500.0]\nradius_cm = 60.0\nheight_cm = {}\n"
    message = fault_of(tmp_path, BARE + pillar.format(800.0))
    assert "`pillar[0].height_cm` 800 reaches above the surface" in message
    most = re.search(r"expected at most (\d+) there", message)
    world_of(tmp_path, BARE + pillar.format(most[1]))


VENT = "\n[[vent]]\nposition_cm = {}\n"
HOOK = "[hook]\nposition_cm = [0.0, 0.0]\n"


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[[reef]]\nposition_cm = [0.0, 0.0]\nspread_cm = 1e-200", ["reef[0].spread_cm", "0.001"]),
        ("[[outcrop]]\nposition_cm = [0.0, 0.0]\nsize_cm = [5e-324, 9.0, 9.0]", ["size_cm"]),
        ("[[reef]]\nkinds = { fan = 0 }", ["`kinds` must give a weight above 0 to one of them"]),
        ("[[reef]]\nkinds = { fern = 1 }", ["kinds`; its keys are: "]),
        ("[[outcrop]]\nposition_cm = [0.0, 0.0]\nsize_cm = [50.0, 50.0, 50.0]\nrocks = 200\n" * 2,
         ["rocks in all, those of outcrops"]),
        ("[[arch]]\nposition_cm = [0.0, 0.0]\nspan_cm = 100.0\nheight_cm = 200.0", [".span_cm`"]),
        (HOOK + "depth_cm = 900.0", ["`hook`", "outside the sea"]),
        (HOOK, ["hook", "depth_cm"]),
        (HOOK + "depth_cm = 9.0\nsped_cm_s = 1.0", ["`sped_cm_s`", "'speed_cm_s'"]),
        (HOOK + "depth_cm = 9.0\nspeed = 1.0", ["`hook`", "did you mean 'speed_cm_s'?"]),
        *((VENT.format("[0.0, 0.0]") + f"{key} = {value}", [key, "vent["])
          for key, value in (("rate_per_s", 0.0), ("rate_per_s", 1e4), ("size_cm", 30.0),
                             ("depth", 1))),
    ],
)  # fmt: skip
def test_invalid_tables_are_refused(tmp_path, table, words):
    message = fault_of(tmp_path, f"{BARE}\n{table}\n")
    assert all(word in message for word in words)


@pytest.mark.parametrize(("stands", "table"), [*STANDS.items(), ("vent[0]", VENT)])
def test_solids_outside_the_sea_are_refused(tmp_path, stands, table):
    message = fault_of(tmp_path, BARE + table.format("[1000.0, 1000.0]"))
    assert f": `{stands}.position_cm` (1000.0, 1000.0) lies outside the sea" in message
    assert message.endswith("expected at most 1300 cm from the middle")


def test_the_renderer_receives_vents(tmp_path):
    text = BARE + VENT.format("[30.0, -40.0]") + "rate_per_s = 3.0\n"
    world = world_of(tmp_path, text)
    np.testing.assert_array_equal(make_scene(world).vents, [[30.0, -40.0, 3.0, 1.2]])


def test_fishes_placed_inside_solids_are_moved_out(tmp_path):
    solids = STANDS["pillar[0]"].format("[-60.0, 150.0]") + STANDS["rock[0]"].format("[0, -80.0]")
    world, bare = world_of(tmp_path, BARE + solids), world_of(tmp_path, BARE)
    sea, fishes = world.state.sea, world.state.fishes
    far = clearances(sea.pillars, sea.rocks, fishes.position.astype(float))
    assert (far > 0.5 * fishes.length).all()
    before = clearances(sea.pillars, sea.rocks, bare.state.fishes.position.astype(float))
    assert (before < 0.0).sum() >= 3


def test_a_school_has_the_given_leader_and_destination(tmp_path):
    place = "position_cm = [-130.0, 40.0, -340.0]"
    given = place + "\nleader_cm = 31.0\ntoward_cm = [500.0, 0.0, -300.0]"
    world = world_of(tmp_path, BARE.replace(place, given))
    fishes, minds = world.state.fishes, world.state.minds
    assert fishes.length[0] == 31.0
    assert fishes.length[1:33].max() <= 23.0
    assert fishes.position[0] == pytest.approx([-130.0, 40.0, -340.0])
    for _ in range(30):
        step(world, NEUTRAL)
    assert minds.waypoint[0] == pytest.approx([500.0, 0.0, -300.0])


@pytest.mark.parametrize(
    ("settings", "value"),
    [
        (["fish.0.number=20"], lambda s: s.fish[0].number == 20),
        (["nature.keen=0.3"], lambda s: s.nature.keen == 0.3),
        (["fish.1.species = clownfish"], lambda s: s.fish[1].species == "clownfish"),
        (["title=A = B"], lambda s: s.title == "A = B"),
        (["water.current_cm_s=[5, -6.5]"], lambda s: s.water.current_cm_s == (5.0, -6.5)),
        (["physics.hydrodynamics=false"], lambda s: not s.physics.hydrodynamics),
        (["hook.position_cm.1=3", "hook.position_cm.0=2"], None),
        (
            ["hook.position_cm=[1, 2]", "hook.depth_cm=300"],
            lambda s: s.hook.bait_cm == (1.0, 2.0, -300.0),
        ),
        (
            ["individual.0.fish=3", "individual.0.male=true", "individual.1.fish=9"],
            lambda s: [one.fish for one in s.individual] == [3, 9] and s.individual[0].male,
        ),
    ],
)
def test_every_key_can_be_set_from_outside(settings, value):
    if value is None:
        with pytest.raises(UserError):
            load_scenario("peaceful", settings)
        return
    scenario, path, _ = load_scenario("peaceful", settings)
    assert value(scenario)
    assert path == load_scenario("peaceful")[1]


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("fish.0.numbr=20", ["--set fish.0.numbr=20", "`numbr`", "did you mean 'number'"]),
        ("fish.0.number=-3", ["--set fish.0.number=-3", "fish[0].number", "at least 0"]),
        ("fish.0.number=many", ["--set fish.0.number=many", "fish[0].number", "a whole number"]),
        ("natur.keen=0.3", ["`natur`", "did you mean 'nature'"]),
        ("nature.keen", ["--set nature.keen", "expected KEY=VALUE"]),
        ("nature..keen=1", ["expected KEY=VALUE"]),
        ("fish.first.number=2", ["`fish` is a list", "0 to 7"]),
        ("fish.9.number=2", ["`fish` is a list", "0 to 7"]),
        ("title.x.y=2", ["`title` is not a table"]),
        ("fish.0.species=fuselier", ["--set", "`fish[0].species`", "'fusilier'"]),
        ("nature.fear_s=0", ["--set nature.fear_s=0", "nature.fear_s", "at least 0.001"]),
        ("nature.habituation_s=long", ["nature.habituation_s", "expected a number"]),
        ("physics.time_step=0", ["physics.time_step", "at least 0.05"]),
        ("individual.0.fish=60", ["`individual[0].fish` 60", "expected 0 to 59"]),
    ],
)
def test_a_faulty_setting_is_one_line(setting, words):
    with pytest.raises(UserError) as caught:
        load_scenario("peaceful", [setting])
    message = str(caught.value)
    assert "\n" not in message
    assert all(word in message for word in words), message


def test_an_individual_has_one_table(tmp_path):
    message = fault_of(tmp_path, PEACEFUL + 2 * "\n[[individual]]\nfish = 4\n")
    assert "`individual[1].fish` 4: has a table already" in message


@pytest.mark.parametrize(
    ("keys", "led"),
    [("", False), ("\nleader_cm = 31.0", True), ('\nschool = "leader"', True),
     ('\nleader_cm = 31.0\nschool = "neighbours"', False)],
)  # fmt: skip
def test_a_school_follows_a_leader_if_the_scenario_says_so(tmp_path, keys, led):
    place = "position_cm = [-130.0, 40.0, -340.0]"
    minds = world_of(tmp_path, BARE.replace(place, place + keys)).state.minds
    assert minds.led[:33].all() == led
    assert not minds.led[33:].any()


def test_water_looks_as_its_type_unless_the_scenario_says_otherwise():
    plain = Water(type="1C")
    assert plain.visibility_cm == JERLOV["1C"].visibility_cm
    assert plain.far == far_colour("1C")
    own = Water(type="1C", fog=(0.0, 0.1, 0.2), visibility_cm=900.0)
    assert (own.far, own.visibility_cm) == ((0.0, 0.1, 0.2), 900.0)


def test_distant_water_is_blue_offshore_and_green_at_the_coast():
    for name in ("I", "IB", "II", "III"):
        red, green, blue = far_colour(name)
        assert red < green < blue
    for name in ("1C", "3C", "5C", "9C"):
        red, green, blue = far_colour(name)
        assert green > max(red, blue)
