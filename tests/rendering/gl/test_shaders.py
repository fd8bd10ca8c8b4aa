"""The preprocessor of the shaders."""

import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from subsea.base.system import resource_names
from subsea.frame import in_sight
from subsea.habitat import plankton as vents
from subsea.habitat import seaweed
from subsea.rendering.gl import shaders
from subsea.rendering.reef import coral, rocks
from subsea.rendering.reef.seaweed import FRONDS, KELP_BLADES, KELP_CANOPY, KELP_STIPES
from subsea.rendering.sea import seabed
from subsea.scenario import schema


@pytest.fixture
def folder(monkeypatch, tmp_path):
    (tmp_path / "shaders").mkdir()
    monkeypatch.setattr(shaders, "resource_path", lambda name: tmp_path / name)
    return tmp_path / "shaders"


def test_a_file_is_read_once_for_all_programs(monkeypatch):
    text = shaders.source("fishes.vert", SPECIES=2)
    monkeypatch.setattr(Path, "read_text", None)
    assert shaders.source("fishes.vert", SPECIES=3) == text.replace("SPECIES 2\n", "SPECIES 3\n")


def test_a_file_is_included_once_and_lines_stay_true(folder):
    (folder / "a.glsl").write_text("float a;\n")
    (folder / "b.glsl").write_text('#include "a.glsl"\nfloat b;\n')
    (folder / "c.frag").write_text('#include "a.glsl"\n#include "b.glsl"\nfloat c;\n')
    lines = shaders.source("c.frag").splitlines()
    assert lines[0] == "#version 330 core"
    assert [line for line in lines if line.startswith("float")] == [f"float {x};" for x in "abc"]
    assert lines[lines.index("float c;") - 1] == "#line 3 0"


def test_an_error_names_the_line_of_the_file(folder, context):
    (folder / "bad.glsl").write_text("float fine;\nfloat wrong = nothing;\n")
    (folder / "bad.vert").write_text("void main() { gl_Position = vec4(0.0); }\n")
    (folder / "bad.frag").write_text('// one\n#include "bad.glsl"\nvoid main() {}\n')
    with pytest.raises(Exception, match=r":2\(") as caught:
        shaders.program(context, "bad")
    assert "nothing" in str(caught.value)


def test_every_uniform_is_read_somewhere():
    """A uniform that no shader uses is a leftover."""
    for suffix in (".vert", ".frag"):
        for name in resource_names("shaders", suffix):
            text = shaders.resource_path(f"shaders/{name}{suffix}").read_text(encoding="utf-8")
            for uniform in re.findall(r"^uniform \w+ (\w+);", text, re.MULTILINE):
                assert len(re.findall(rf"\b{uniform}\b", text)) > 1, f"{name}{suffix}: {uniform}"


def test_no_step_goes_down():
    """OpenGL leaves `smoothstep` undefined for a first edge above the second."""
    for suffix in (".vert", ".frag", ".glsl"):
        for name in resource_names("shaders", suffix):
            text = shaders.resource_path(f"shaders/{name}{suffix}").read_text(encoding="utf-8")
            for low, high in re.findall(r"\bsmoothstep\(([-\w.]+), ([-\w.]+),", text):
                down = high == f"-{low}"
                with suppress(ValueError):  # a name
                    down = float(low) >= float(high)
                assert not down, f"{name}{suffix}: smoothstep({low}, {high}, …)"


def numbers(name, pattern):
    """The numbers at each match in a shader, one row per match; at least one match.

    In a pattern, # stands for a number, and a blank for any number of blanks.
    """
    text = shaders.resource_path(f"shaders/{name}").read_text(encoding="utf-8")
    found = re.findall(pattern.replace(" ", r"\s*").replace("#", r"(-?\d+\.?\d*)"), text)
    assert found, f"{name}: {pattern}"
    return np.array(found, float).reshape(len(found), -1)


def test_shader_and_vertices_agree_on_the_sway_of_corals():
    np.testing.assert_array_equal(
        numbers("coral.vert", "MOST_SWAY_CM = # ;"), [[coral.MOST_SWAY_CM]]
    )


def test_textures_are_read_with_the_spans_with_which_they_were_written():
    (relief,) = numbers("relief.glsl", r"RELIEF_SPAN = vec4\( # , # , # , # \)")
    # Slopes are written by the tile and read for the depth that the relief is drawn with.
    np.testing.assert_allclose(relief, 2.0 * rocks.RELIEF_SPAN * (1.0, 0.05, 0.05, 1.0))
    for scale, low in numbers("seabed.frag", r"# \* texture\(u_ripples, .*\) - # ;"):
        assert scale == 2.0 * low
        np.testing.assert_array_equal(seabed.SPAN[:3], low)  # grain is drawn paler than its range
    (litter,) = numbers("seabed.frag", r"# \* bits\.xy - #")
    low, high = seabed.LITTER_LOW[:2], seabed.LITTER_HIGH[:2]
    np.testing.assert_array_equal([high - low, -low], np.repeat(litter[:, None], 2, axis=1))


def test_bubbles_are_no_slower_than_their_slots_expect():
    ((least, more),) = numbers("bubbles.vert", r"a_vent\.w \* \( # \+ # \* chance")
    assert (least, least + more) == (vents.SLOWEST, 1.0)


def test_seaweed_has_the_same_kinds_nodes_and_fronds_everywhere():
    kinds = numbers("seaweed.vert", "const int RIBBON = # , KELP = # , GRASS = # , RED = # ;")
    names = schema.SeaweedTable.__annotations__["kind"].__args__
    assert seaweed.KINDS == names == tuple(FRONDS) == ("ribbon", "kelp", "grass", "red")
    np.testing.assert_array_equal(kinds, [range(len(names))])
    assert numbers("seaweed.vert", "LAST = # ;") == in_sight.LEAF_NODES - 1 == seaweed.NODES - 1
    ((stipes, blades, canopy, branches),) = numbers(
        "seaweed.vert", "STIPES = # , BLADES = # , CANOPY = # , BRANCHES = # ;"
    )
    assert [stipes, blades, canopy] == [len(own) for own in (KELP_STIPES, KELP_BLADES, KELP_CANOPY)]
    assert FRONDS["kelp"][0] == [*range(int(stipes + blades + canopy))]
    assert branches == max(FRONDS["red"][0])  # besides the stem, which is number 0
    for own in FRONDS.values():  # a frond never vanishes from one level to the next
        assert set(own[0]) >= set(own[1])
        assert set(own[2]) >= set(own[3])
    ((short, more),) = numbers("seaweed.vert", r"CANOPY_LENGTH = vec2\( # , # \) ;")
    assert short + more == in_sight.BLADE
