"""TOML files: what is wrong with one is a line that begins with file and line and tells the key."""

import pickle

import msgspec
import pytest

from subsea.base.errors import UserError
from subsea.base.toml_files import error_at, load_toml, locate_errors
from subsea.fish.species import Species
from subsea.scenario.checks import check_scenario
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.world.build import create_world

REEF = """\
title = "a reef"
seed = 1
bounds = { radius_cm = 1000.0, depth_cm = 500.0 }
water.fog = [0.0, 0.1, 0.2]
water.visibility_cm = 900.0

[terrain]
dune_height_cm = 0.0
dune_length_cm = 300.0

[submarine]
position_cm = [-300.0, 0.0, -300.0]

[[fish]]
species = "fusilier"
number = 3

[[fish]]
species = "clownfish"
number = 1
likes = [
    "cold",
    "darkness",
]

[[reef]]
number = 0
kinds = { fan = 1.0, brain = 2.0 }

[[tour]]
name = "there"
waypoint = [
    { time_s = 0.0, position_cm = [-300.0, 0.0, -300.0] },
    { time_s = 9.0, position_cm = [-100.0, 0.0, -300.0] },
]

[[tour]]
name = "back"
[[tour.waypoint]]
time_s = 0.0
position_cm = [-100.0, 0.0, -300.0]
[[tour.waypoint]]
time_s = 9.0
position_cm = [-300.0, 0.0, -300.0]

[nature]
alarmed = 0.4
"""


def refused(path, text, changes=()):
    """The one line with which a scenario of that text is refused, without its folder."""
    path.write_text(text)
    with pytest.raises(UserError) as caught:
        create_world(load_scenario(str(path), changes)[0], source=str(path))
    message = str(caught.value)
    assert message.startswith(str(path))
    return message.removeprefix(f"{path.parent}/")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "reef.toml"


def test_the_reef_is_sound(path):
    path.write_text(REEF)
    assert load_scenario(str(path))[0].title == "a reef"


@pytest.mark.parametrize(
    ("change", "line", "words"),
    [
        (("seed = 1", "sead = 1"), 2, "unknown key `sead`; did you mean 'seed'?"),
        (("seed = 1", "seed = -1"), 2, "expected a whole number of at least 0, got -1, at `seed`"),
        (("depth_cm = 500.0", 'depth_cm = "deep"'), 3, "at `bounds.depth_cm`"),  # inline table
        (("depth_cm = 500.0", "deep_cm = 500.0"), 3, "unknown key `deep_cm`, at `bounds`"),
        ((", depth_cm = 500.0", ""), 3, "missing key `depth_cm`, at `bounds`"),
        (("visibility_cm = 900.0", "visibility_cm = 9"), 5, "at `water.visibility_cm`"),  # dotted
        (("fog = [0.0, 0.1, 0.2]", "fog = [0.0, 0.1]"), 4, "at `water.fog`"),
        (("fog = [0.0, 0.1, 0.2]", "fog = [0.0,\n 0.1, 2]"), 5, "at `water.fog[2]`"),
        (("number = 1", "number = 1.5"), 20, "at `fish[1].number`"),
        (("number = 1", "numbr = 1"), 20, "unknown key `numbr`, at `fish[1]`"),
        (("number = 1\n", ""), 18, "missing key `number`, at `fish[1]`"),
        (('"darkness"', '"dark"'), 23, "at `fish[1].likes[1]`; there are: 'brightness'"),
        (("brain = 2.0", "brian = 2.0"), 28, "unknown value 'brian', at `reef[0].kinds`"),
        (("brain = 2.0", "brain = -2.0"), 28, "at `reef[0].kinds.brain`"),
        (("fan = 1.0, brain = 2.0", "fan = 0.0"), 28, "`kinds` must give a weight"),
        (("9.0, position_cm = [-100.0, 0.0,", "9.0, position_cm = [-100.0,"), 34, "waypoint[1]"),
        (("9.0, position_cm = [-100.0", "9.0, position_cm = [-1100.0"), 34, "outside the sea"),
        (("time_s = 9.0\n", "time_s = 0.0\n"), 43, "`tour[1].waypoint[1].time_s` 0: expected more"),
        (('name = "back"', 'name = "there"'), 37, "`tour[1]`: the name 'there' is taken"),
        (('name = "back"', 'name = "back"\nloop = true'), 37, "`tour[1]` is a loop"),
        (("alarmed = 0.4", "panicked = 0.4"), 47, "`alarmed` must be less than `panicked`"),
        (('species = "clownfish"', 'species = "clownfosh"'), 19, "unknown species 'clownfosh'"),
        (("number = 3", "number = 3\nsize_cm = [9.0, 8.0]"), 17, "expected the smallest first"),
        (("[-300.0, 0.0, -300.0]\n\n", "[-300.0, 0.0, 1.0]\n\n"), 12, "`submarine.position_cm` ("),
        (("[-300.0, 0.0, -300.0]\n\n", "[-300.0, 0.0, -499.0]\n\n"), 12, "from the seabed"),
        (("[nature]", "[hook]\nposition_cm = [0, 0]\ndepth_cm = 501\n[nature]"), 46, "`hook`"),
        (("[nature]", "[nature"), 46, "not valid TOML (Expected ']' at the end of a table"),
        (("seed = 1", "seed = 1\nseed = 2"), 3, "not valid TOML (Cannot overwrite a value"),
        (("seed = 1", "seed = 1 2"), 2, "not valid TOML"),
        (("alarmed = 0.4", "alarmed = [0.4"), 47, "not valid TOML"),
    ],
    ids=lambda given: given if isinstance(given, str) else None,
)  # fmt: skip
def test_faults_have_line_and_key(path, change, line, words):
    assert change[0] in REEF
    message = refused(path, REEF.replace(*change))
    assert message.startswith(f"reef.toml:{line}: ")
    assert words in message


@pytest.mark.parametrize(
    ("direction", "line", "words"),
    [
        ("at_s = 1.0\nend = true\nlighst = true", 53, "unknown key `lighst`, at `direction[1]`"),
        ("camera = { follow = { shoal = 9 } }", 51, "`direction[1].camera.follow.shoal`: 9: there"),
        ("camera = { tour = 'there', behind = true }", 51, "`behind` is for `follow` without"),
        ("\n\nafter = 'second'\nend = true", 53, "[1].after`: unknown direction 'second'"),
        ("camera = { follow = 'them' }", 51,
         "unknown value 'them', at `direction[1].camera.follow`; there are: 'cast'"),
        ("camera = { follow = { shoel = 0 } }", 51,
         "unknown key `shoel`, at `direction[1].camera.follow`; did you mean 'shoal'?"),
        ("hook = 'down'", 51, "expected a table [hook]"),
        ("who = { shoal = 0 }\nhunger = nan", 52, "at least 0, got nan, at `direction[1].hunger`"),
        ("at_s = 1.0\ndelay_s = 2.0\nend = true", 52, "or a later `at_s`"),
        ("camera = { position_cm = [0.0, 0.0, -490.0], look_at_cm = [0.0, 9.0, -400.0] }", 51,
         "seabed"),
    ],
)  # fmt: skip
def test_faults_of_directions_have_lines(path, direction, line, words):
    first = "[[direction]]\nname = 'first'\nend = true\n"
    text = REEF.replace("[nature]", f"{first}\n[[direction]]\n{direction}\n\n[nature]")
    message = refused(path, text)
    assert message.startswith(f"reef.toml:{line}: ")
    assert words in message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (REEF.replace('title = "a reef"\n', ""), "missing key `title`"),  # nowhere in the file
        (REEF.replace("number = 3", "number = 100000"), "100001 fishes in all"),  # of several
        ("", "missing key"),
        (f"a = {'[' * 5000}", "not valid TOML"),
    ],
)
def test_faults_of_the_whole_file_have_no_line(path, text, words):
    assert refused(path, text).startswith(f"reef.toml: {words}")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a." * 20_000 + "a = 1", "reef.toml:1: not valid TOML (tables within tables"),
        ("x = 1\n[a" + ".'b'" * 40 + "]", "reef.toml:2: not valid TOML (tables within tables"),
        ("seed = " + "9" * 5000, "reef.toml: not valid TOML (a number of too many digits)"),
        ("#" * 2**21, "reef.toml: larger than 1 MiB"),
        ('"two\\nlines\\u001b[2J" = 1', "reef.toml: unknown key `two?lines?[2J`"),
        ("k" * 100_000 + " = 1", "reef.toml:1: unknown key `kkk"),
    ],
)
def test_hostile_files_are_one_short_line(path, text, words):
    said = refused(path, text)
    assert said.startswith(words)
    assert len(said) < 1100
    assert said.isprintable()


def test_hostile_changes_are_one_line(path):
    for value in ("9" * 5000, "[" * 5000, "[" * 200):
        assert refused(path, REEF, [f"seed={value}"]).startswith("reef.toml --set seed=")
    with pytest.raises(UserError, match=r"^--set fish\.9999"):
        load_toml(path, Scenario, [f"fish.{'9' * 5000}.x=1"])
    for parts in (33, 20_000):
        with pytest.raises(
            UserError, match=rf"^--set a\.a\.a…: a key of {parts} parts, expected 32"
        ):
            load_toml(path, Scenario, [f"{'.'.join('a' * parts)}=1"])
    with pytest.raises(UserError, match=r"^--set title=\\udcff: not text in the encoding"):
        load_toml(path, Scenario, ["title=\udcff"])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            "fish.0.number=x",
            "reef.toml --set fish.0.number=x: expected a whole number, got 'x', at `fish",
        ),
        ("fish.0.nmber=1", "reef.toml --set fish.0.nmber=1: unknown key `nmber`, at `fish[0]`"),
        ("fish.2.number=1", "reef.toml --set fish.2.number=1: missing key `species`, at `fish[2]`"),
        ("fish.0.species=clownfosh", "reef.toml --set fish.0.species=clownfosh: `fish[0].sp"),
        ("nature.alarmed=0.9", "reef.toml --set nature.alarmed=0.9: `alarmed` must be less than"),
        ("submarine.position_cm=[0,0,-499]", "reef.toml: `submarine.position_cm` (0.0, 0.0,"),
    ],
)  # fmt: skip
def test_faults_of_changes_have_no_line(path, change, said):
    assert refused(path, REEF, [change]).startswith(said)


def test_faults_of_the_file_have_a_line_despite_changes(path):
    for change, words in (
        (("seed = 1", "sead = 1"), "reef.toml:2 --set fish.0.number=4: "),
        (("number = 1", "number = 1.5"), "reef.toml:20: expected a whole number, got 1.5"),
        (('"clownfish"', '"clownfosh"'), "reef.toml:19: `fish[1].species`"),
    ):
        message = refused(path, REEF.replace(*change), ["fish.0.number=4"])
        assert message.startswith(words)


def test_a_changed_scenario_has_no_wrong_line(path):
    path.write_text(REEF)
    scenario = load_scenario(str(path)).scenario
    moved = msgspec.structs.replace(scenario.submarine, position_cm=(0.0, 0.0, 9.0))
    changed = msgspec.structs.replace(scenario, submarine=moved)
    for source, shown in ((path, r"reef\.toml: `submarine"), ("the sea", "^the sea: `submarine")):
        with pytest.raises(UserError, match=shown), locate_errors(changed, source):
            check_scenario(changed)
    path.unlink()
    with pytest.raises(UserError, match=r"reef\.toml: `submarine"), locate_errors(changed, path):
        check_scenario(changed)


def test_errors_have_their_location_as_data(path):
    path.write_text(REEF.replace("number = 1", "number = 1.5"))
    with pytest.raises(UserError) as caught:
        load_toml(path, Scenario, ["seed=3"])
    error = caught.value
    assert (error.file, error.line, error.key) == (path, 20, "fish[1].number")
    assert str(error) == f"{path}:20: {error.message}"
    path.write_text(REEF)
    with pytest.raises(UserError) as caught:
        load_scenario(str(path), ["fish.1.species=clownfosh"])
    error = caught.value
    assert (error.file, error.line, error.key) == (path, None, "fish[1].species")
    assert error.changes == ("fish.1.species=clownfosh",)
    again = pickle.loads(pickle.dumps(error))  # as it comes from another process
    assert (str(again), again.key, again.file) == (str(error), error.key, error.file)
    with pytest.raises(UserError, match=r"^elsewhere\.toml: wrong$"), locate_errors(Scenario, path):
        raise UserError("wrong", file="elsewhere.toml", key="seed")  # is left as it is


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("size_cm = [16.0, 24.0]", "size_cm = [24.0, 16.0]"), "size_cm"),
        (("iris = ", "iriss = "), "unknown key `iriss`, at `skin`"),
    ],
)
def test_faults_of_species_have_lines(tmp_path, change, words):
    from subsea.base.system import resource_path

    text = resource_path("assets/species/fusilier.toml").read_text()
    assert change[0] in text
    path = tmp_path / "fusilier.toml"
    path.write_text(text.replace(*change))
    line = text[: text.index(change[0])].count("\n") + 1
    with pytest.raises(UserError, match=rf"fusilier\.toml:{line}: .*{words}"):
        load_toml(path, Species)


def test_faults_in_tables_with_arbitrary_keys_have_lines(path):
    path.write_text("[sizes]\na = 1\nb = 2\n'c d' = 'x'\n")
    with pytest.raises(UserError, match=r"reef\.toml:4: .* at `sizes\.c d`"):
        load_toml(path, Sizes)
    path.write_text("[sizes]\n'[...]' = 1\n'a.[...].`' = 'x'\n")
    with pytest.raises(UserError, match=r"reef\.toml:3: .* at `sizes\.a\.\[\.\.\.\]\.``"):
        load_toml(path, Sizes)
    path.write_text("[sizes]\na = 1\nb = 2\n'c d' = 'x'\n")
    assert [error_at(path, key, "").line for key in ("sizes.b", "sizes.z", "other")] == [3, 1, None]


class Sizes(msgspec.Struct):
    sizes: dict[str, int]


def test_valid_files_are_not_searched_for_lines(path, monkeypatch):
    monkeypatch.setattr("subsea.base.toml_files.key_lines", lambda text: pytest.fail("not needed"))
    path.write_text(REEF)
    assert load_toml(path, Scenario).seed == 1
    assert load_scenario(str(path))[0].seed == 1
