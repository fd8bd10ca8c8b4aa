"""Species files, and the conformance of every species that is shipped."""

import numpy as np
import pytest

from subsea.core.errors import UserError
from subsea.core.resources import resource_path
from subsea.core.toml_files import load_toml
from subsea.fish.species import Species, load_species, species_names
from subsea.fish.surface import rest_control_points
from subsea.repertoire import SEGMENTS, read_repertoire


def test_an_unknown_species_suggests_the_nearest():
    with pytest.raises(UserError, match="did you mean 'fusilier'"):
        load_species("fusileer")


@pytest.fixture(params=species_names())
def name(request):
    return request.param


@pytest.fixture
def repertoire(name):
    return read_repertoire(resource_path("repertoires") / f"{name}.h5")


def test_it_has_every_segment(name, repertoire):
    assert repertoire.species == name
    assert set(SEGMENTS) <= set(repertoire.segments)


def test_grades_are_ordered(repertoire):
    slow, medium, fast = (repertoire.segments[f"swim_{g}"] for g in ("slow", "medium", "fast"))
    assert 1.4 * slow.speed_cm_s <= medium.speed_cm_s
    assert 1.4 * medium.speed_cm_s <= fast.speed_cm_s


@pytest.mark.parametrize("grade", ["gradual", "sharp"])
def test_left_turns_left_and_right_is_its_mirror(repertoire, grade):
    left, right = (repertoire.segments[f"turn_{side}_{grade}"] for side in ("left", "right"))
    assert left.turn_deg > 2
    # The frame's origin, ½(n5 + n7), is not its own mirror image, so small gaps remain.
    assert right.turn_deg == pytest.approx(-left.turn_deg, abs=0.5)
    assert right.speed_cm_s == pytest.approx(left.speed_cm_s, rel=1e-2)
    assert len(right.nodes) == len(left.nodes)


def test_cycles_close(repertoire):
    for segment in repertoire.segments.values():
        if segment.cyclic:
            assert segment.loop_error_bl < 1e-3


def test_the_recorded_skin_wraps_the_nodes(name, repertoire):
    """Control points stay within a plausible distance of the body, in every frame."""
    rest = rest_control_points(
        load_species(name).surface, repertoire.body_length_cm, repertoire.rest_nodes[0, 0]
    )
    reach = np.linalg.norm(rest, axis=1).max()
    for segment in repertoire.segments.values():
        if segment.control_points is not None:
            far = np.linalg.norm(segment.control_points, axis=2).max()
            assert far < 1.35 * reach


FUSILIER = resource_path("assets/species/fusilier.toml").read_text()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("back = [[0.0, 0.007], [0.02, 0.03]", "back = [[0.0, 0.007], [0.0, 0.03]"), "back"),
        (("gloss = 0.55", "gloss = 0.5\nmouth = [[0.1, 0.0], [0.1, 0.1]]"), "mouth"),
        (("gloss = 0.55", "gloss = 0.5\ngills = 8"), "skin.gills"),
        (
            (
                "[skin.cape]",
                "[skin.stripes]\ncolour = [0, 0, 0]\nspacing = 0.1\nshare = 0.5\n"
                "begin = 0.5\nend = 0.4\n[skin.cape]",
            ),
            "stripes must end",
        ),
        (("[0.84, 0.033], [0.88, 0.05]", "[0.84, 0.033], [1.88, 0.05]"), "surface.back"),
        (("[1.0, 1.0]] }", "[0.9, 1.0]] }"), "from 0 or -1 to 1"),
        (("size_cm = [16.0, 24.0]", "size_cm = [24.0, 16.0]"), "smallest length first"),
        (("base = [0.29, 0.74]", "base = [0.74, 0.29]"), "front to rear"),
        (("begin = 0.84", "begin = 0.0"), "tail must begin"),
        (("[0.4, -0.12]", "[0.4, 0.2]"), "above the belly"),
        (("[0.02, 0.03], [0.06", "[0.02, nan], [0.06"), "back"),
    ],
)
def test_an_absurd_outline_is_one_line(tmp_path, change, words):
    assert change[0] in FUSILIER
    file = tmp_path / "mine.toml"
    file.write_text(FUSILIER.replace(*change))
    with pytest.raises(UserError) as caught:
        load_toml(file, Species)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


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


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("radius = [0.0024, 0.0062]", "radius = [0.0062, 0.0024]"), "radius"),
        (("radius = [0.0024, 0.0062]", "radius = [0.0024, 0.02]"), "half the spacing"),
        (("chord = [0.07, 0.3]", "chord = [0.3, 0.07]"), "chord"),
        (("chord_lag = 0.22", "chord_lag = 0.0"), "chord_lag"),
        (("[skin.dorsal]", "[skin.ventral]"), "skin.dorsal"),
        (("sharp_beats = 3", "sharp_beats = 2"), "sharp_beats"),
    ],
)
def test_an_absurd_ray_is_one_line(tmp_path, change, words):
    text = resource_path("assets/species/spotted_eagle_ray.toml").read_text()
    assert change[0] in text
    with pytest.raises(UserError) as caught:
        _load(tmp_path, text.replace(*change))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
