"""The preprocessor of the shaders."""

import re

import pytest

from subsea.render import shaders
from subsea.resources import resource_names


@pytest.fixture
def folder(monkeypatch, tmp_path):
    (tmp_path / "shaders").mkdir()
    monkeypatch.setattr(shaders, "resource_path", lambda name: tmp_path / name)
    return tmp_path / "shaders"


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
