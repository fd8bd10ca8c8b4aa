"""The buffer of a view: every program reads each member from its place."""

import numpy as np
import pytest

from subsea.base.system import resource_path
from subsea.rendering.gl import shaders
from subsea.rendering.gl.shaders import set_uniforms

MATRICES = ("u_view", "u_projection", "u_view_projection", "u_inverse")
VECTORS = ("u_balance", "u_far", "u_broad", "u_narrow")
AT = np.array([1.0, 2.0, 3.0, 4.0])


@pytest.fixture
def read(context):
    """Values of the view -> what a program reads: rows of four by member."""
    outputs = [f"v{k}" for k in range(9)]
    values = [f"{name} * vec4(1.0, 2.0, 3.0, 4.0)" for name in MATRICES]
    values += ["vec4(u_eye, u_time)", *(f"vec4({name}, u_own)" for name in VECTORS)]
    lines = [f"{out} = {value};" for out, value in zip(outputs, values, strict=True)]
    declared = "".join(f"out vec4 {out};\n" for out in outputs)
    text = resource_path("shaders/view.glsl").read_text()
    body = f"{text}uniform float u_own;\n{declared}void main() {{ {' '.join(lines)} }}"
    compiled = context.program(vertex_shader=f"#version 330 core\n{body}", varyings=outputs)
    array, found = context.vertex_array(compiled, []), context.buffer(reserve=9 * 16)
    target = context.simple_framebuffer((4, 4))

    def rows(**given):
        target.use()
        set_uniforms(compiled, u_own=7.0, **given)
        array.transform(found, context.POINTS, vertices=1)
        return np.frombuffer(found.read(), np.float32).reshape(9, 4)

    yield rows
    for owned in (target, array, found, compiled):
        owned.release()


def _values(seed):
    rng = np.random.default_rng(seed)
    matrices = {name: rng.normal(size=(4, 4)).astype(np.float32) for name in MATRICES}
    vectors = {name: tuple(rng.normal(size=3).tolist()) for name in ("u_eye", *VECTORS)}
    expected = [matrix @ AT for matrix in matrices.values()]
    expected += [[*vectors["u_eye"], 12.5], *([*vectors[name], 7.0] for name in VECTORS)]
    columns = {name: matrix.T.tobytes() for name, matrix in matrices.items()}
    return columns | vectors | {"u_time": 12.5}, expected


def test_each_member_is_read_from_its_place(read):
    values, expected = _values(1)
    np.testing.assert_allclose(read(**values), expected, rtol=1e-5, atol=1e-5)


def test_a_packed_view_is_the_same_and_replaces_the_last(read):
    for seed in (2, 3, 2):
        values, expected = _values(seed)
        packed = shaders.view_block(values)
        np.testing.assert_allclose(read(view=packed), expected, rtol=1e-5, atol=1e-5)


def test_missing_members_are_zero(read):
    read(**_values(4)[0])
    assert (read(u_time=2.0)[:4] == 0.0).all()
