"""Textures whose mipmaps were kept are those whose mipmaps OpenGL has made."""

import numpy as np
import pytest

from subsea.core import disk_cache
from subsea.render.gl import mipmaps
from subsea.render.gl.mipmaps import ALL, kept_texture, mipmapped

SIZE = (12, 8)
LOOKS = """#version 330 core
uniform sampler2D u_texture; uniform float u_level; out vec4 v;
void main() { v = textureLod(u_texture, vec2(0.3, 0.7), u_level); }"""


def texels(planes, kind):
    values = np.random.default_rng(7).uniform(0.0, 255.0, (SIZE[1], SIZE[0], planes))
    return values.astype(kind)


@pytest.fixture
def seen(context):
    """What a shader sees of a texture at each level, and at what would be beyond the last."""
    compiled = context.program(vertex_shader=LOOKS, varyings=["v"])
    out = context.buffer(reserve=16)
    array = context.vertex_array(compiled, [])
    target = context.simple_framebuffer((4, 4))

    def seen(texture):
        values = []
        target.use()
        texture.use(0)
        for level in range(6):
            compiled["u_level"] = float(level)
            array.transform(out, context.POINTS, vertices=1)
            values.append(np.frombuffer(out.read(), np.float32))
        return np.array(values)

    yield seen
    context.detect_framebuffer(0).use()
    for held in (target, array, out, compiled):
        held.release()


@pytest.mark.parametrize("last", [2, ALL])
@pytest.mark.parametrize(
    ("planes", "kind", "srgb"),
    [(1, "f2", False), (2, "f2", False), (3, "f2", False), (4, "f2", False), (4, "u1", False),
     (4, "u1", True)],
)  # fmt: skip
def test_all_levels_are_there_again(
    context, seen, monkeypatch, tmp_path, planes, kind, srgb, last
):  # fmt: skip
    monkeypatch.setattr(disk_cache, "cache_folder", lambda: tmp_path)
    plain = mipmapped(context, texels(planes, kind), last, srgb)
    expected = seen(plain)
    assert len(np.unique(expected[:4, 0])) == min(last, 3) + 1
    for _ in range(2):
        again = kept_texture(context, last, srgb, texels, planes, kind)
        again.filter = plain.filter
        np.testing.assert_array_equal(seen(again), expected)
        assert context.error == "GL_NO_ERROR"
        again.release()
        # What is kept is neither made again nor given to OpenGL to be made smaller.
        monkeypatch.setattr(mipmaps, "mipmapped", None)
    plain.release()


def test_another_driver_makes_its_own(context, monkeypatch, tmp_path):
    monkeypatch.setattr(disk_cache, "cache_folder", lambda: tmp_path)
    kept_texture(context, ALL, False, texels, 1, "u1").release()
    monkeypatch.setattr(context, "_info", context.info | {"GL_RENDERER": "another"})
    kept_texture(context, ALL, False, texels, 1, "u1").release()
    assert len(list(tmp_path.iterdir())) == 2
