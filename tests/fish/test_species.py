"""Species files and their faults."""

import pytest

from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml
from subsea.fish.species import Species, load_species


def test_an_unknown_species_suggests_the_nearest():
    with pytest.raises(UserError, match="did you mean 'fusilier'"):
        load_species("fusileer")


FUSILIER = resource_path("assets/species/fusilier.toml").read_text()


FAULTS = {
    "blue_tang": [
        ('eats = ["turf"]', 'eats = ["grass"]', "life.eats[0]"),
        ("hides = true", "hides = 2", "life.hides"),
        ("hides = true", "territory_cm = 0.0", "life.territory_cm"),
        ("hides = true", "territory_cm = 60.0", "territory_cm needs home_cm"),
        ("hides = true", "sleeps = true", "sleeps"),
    ],
    "fusilier": [
        ("back = [[0.0, 0.007], [0.02, 0.03]", "back = [[0.0, 0.007], [0.0, 0.03]", "back"),
        ("gloss = 0.55", "gloss = 0.5\nmouth = [[0.1, 0.0], [0.1, 0.1]]", "mouth"),
        ("gloss = 0.55", "gloss = 0.5\ngills = 8", "skin.gills"),
        ("gloss = 0.55", "gloss = 0.5\nmouth = [[0, 0], [1e-300, 0]]", "mouth"),
        ("height = 0.014, r", "height = 0.3, r", "`height` of the eye is 0.3, expected -0.0"),
        ("at = 0.085, h", "at = 0.9, h", "eye is 0.9, expected at most 0.5, on the head"),
        ("radius = 0.024", "radius = 1e-6", "`radius` of the eye is 1e-06, expected 0.001 to 0.25"),
        (
            "[skin.cape]",
            "[skin.stripes]\ncolour = [0, 0, 0]\nspacing = 0.1\nshare = 0.5\n"
            "begin = 0.5\nend = 0.4\n[skin.cape]",
            "stripes must end",
        ),
        ("[0.84, 0.033], [0.88, 0.05]", "[0.84, 0.033], [1.88, 0.05]", "surface.back"),
        ("[1.0, 1.0]] }", "[0.9, 1.0]] }", "from 0 or -1 to 1"),
        ("size_cm = [16.0, 24.0]", "size_cm = [24.0, 16.0]", "smallest length first"),
        ("base = [0.29, 0.74]", "base = [0.74, 0.29]", "front to rear"),
        ("begin = 0.84", "begin = 0.0", "tail must begin"),
        ("[0.4, -0.12]", "[0.4, 0.2]", "above the belly"),
        ("[0.02, 0.03], [0.06", "[0.02, nan], [0.06", "back"),
        ("1.4, 0.748]", "1.4, -0.748]", "body.masses"),
        ("1.4, 0.748]", "1.4, 0.1]", "masses[6] = 0.1 g is too light for the stiffness"),
        ("muscle_stiffness = 98.6", "muscle_stiffness = 2580.0", "too light for the stiffness"),
        ("viscosity = 0.222", "viscosity = 6.24", "too light for the stiffness"),
        ("half_widths = [0.53", "half_widths = [0.0", "body.half_widths"),
        ("half_widths = [0.53", "half_widths = [47.0", "half_widths[0] = 47"),
        ("spans = [3.11", "spans = [31.1", "spans[0] = 15.55; expected 0.103 to 9.22 cm"),
    ],
    "spotted_eagle_ray": [
        ("at = 0.064", "at = 0.3", "`at` of the eye is 0.3, expected at most 0.16, on the head"),
        ("height = 0.0295", "height = -0.3", "`height` of the eye"),
        ("radius = [0.0024, 0.0062]", "radius = [0.0062, 0.0024]", "radius"),
        ("radius = [0.0024, 0.0062]", "radius = [0.0024, 0.02]", "half the spacing"),
        ("chord = [0.07, 0.3]", "chord = [0.3, 0.07]", "chord"),
        ("chord_lag = 0.22", "chord_lag = 0.0", "chord_lag"),
        ("[skin.dorsal]", "[skin.ventral]", "skin.dorsal"),
        ("amplitude = 0.92,", "amplitude = 0.92, slip = 0.5,", "a slip or none"),
        ("tip_lag = 0.6", "tip_lag = 6.0", "tip_lag"),
        ("cruise_height = [0.45, 1.0]", "cruise_height = [1.0, 0.45]", "lowest height first"),
        ("cruise_height = [0.45, 1.0]", "cruise_height = [0.0, 1.0]", "cruise_height[0]"),
        ("cruise_height = [0.45, 1.0]", "cruise_height = [0.45, 51.0]", "cruise_height[1]"),
    ],
}


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_in_a_species_file_is_one_line(tmp_path, name):
    text = resource_path(f"assets/species/{name}.toml").read_text()
    for old, new, words in FAULTS[name]:
        assert old in text
        with pytest.raises(UserError) as caught:
            _load(tmp_path, text.replace(old, new))
        message = str(caught.value)
        assert message.startswith(str(tmp_path)) and words in message and "\n" not in message, old


SPINE = """
[spine]
length = 80.0
centre = 0.4
slow = { ticks_per_beat = 40, amplitude = 0.6, slip = 0.5 }
medium = { ticks_per_beat = 30, amplitude = 0.8, slip = 0.55 }
fast = { ticks_per_beat = 20, amplitude = 1.0, slip = 0.6 }
turn = { gradual = 20.0, sharp = 60.0, sharp_beats = 6 }

[spine.swing]
angle = 40.0
inflections = [0.15, 0.5, 0.85]
flexibility = [[0.0, 0.2], [1.0, 1.0]]

"""
SURFACE_ON = FUSILIER[FUSILIER.index("[surface]") :]
HEADER = FUSILIER[: FUSILIER.index("# Found")]


def _load(tmp_path, text):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    return load_toml(file, Species)


def test_a_species_is_moved_by_its_muscles_or_by_its_spine(tmp_path):
    fish = _load(tmp_path, FUSILIER)
    assert fish.muscles == (fish.body, fish.swim, fish.turn)
    assert fish.length_cm == fish.body.length
    eel = _load(tmp_path, HEADER + SPINE + SURFACE_ON)
    assert eel.muscles is None
    assert eel.length_cm == 80.0


@pytest.mark.parametrize(
    "head",
    [HEADER, FUSILIER[: FUSILIER.index("[swim]")], FUSILIER[: FUSILIER.index("[surface]")] + SPINE],
)
def test_two_movers_or_none_are_one_line(tmp_path, head):
    with pytest.raises(UserError, match=r"\[body\], \[swim\] and \[turn\], or \[spine\] alone"):
        _load(tmp_path, head + SURFACE_ON)
