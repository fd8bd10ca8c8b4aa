"""The fronds in numpy against those of the vertex shader."""

from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np
import pytest

from subsea.export.seaweed_mesh import FEW, frond_meshes
from subsea.frame.in_sight import LEAF_NODES, LEAF_TEXELS
from subsea.habitat.seaweed import KINDS
from subsea.rendering.gl.context import headless_context
from subsea.rendering.gl.shaders import set_uniforms, source
from subsea.rendering.reef.seaweed import COARSE, FINE, FRONDS_AT, fronds_of, ribbon

EYE, TIME_S = np.array([40.0, -220.0, -180.0]), 3.7


@pytest.fixture(scope="module")
def context() -> Iterator[Any]:
    context = headless_context()
    with context:
        yield context
    context.release()


def leaves_of(kind: int) -> np.ndarray:
    """Three bent and twisted leaves; the last one reaches the surface."""
    t = np.linspace(0.0, 1.0, LEAF_NODES)
    out = np.zeros((3, LEAF_TEXELS, 4), np.float32)
    for k, (depth, height) in enumerate(((-300.0, 90.0), (-280.0, 160.0), (-260.0, 240.0))):
        bend = np.stack([30.0 * t**2, 12.0 * np.sin(3.0 * t + k), height * t], axis=1)
        out[k, :LEAF_NODES, :3] = (60.0 * k, 20.0 * k, depth) + bend
        out[k, LEAF_NODES] = 5.0 + k, 0.7 * k, 0.8, 0.13 + 0.29 * k
        out[k, LEAF_NODES + 1] = 0.14, 0.155, 0.03, height
    out[:, 0, 3] = kind
    return out


def drawn(context: Any, leaves: np.ndarray, coarse: bool) -> tuple[np.ndarray, np.ndarray]:
    """World positions and normals (F · v, 3) of all fronds, from the shader."""
    program = context.program(
        vertex_shader=source("seaweed.vert"), varyings=("v_world", "v_normal")
    )
    place, _ = ribbon(*(COARSE if coarse else FINE))
    seen = np.ones((1, len(leaves)), np.bool_)
    fronds, _ = fronds_of(leaves, seen, 0, len(leaves), FRONDS_AT[FEW])
    texture = context.texture((LEAF_TEXELS, len(leaves)), 4, leaves.tobytes(), dtype="f4")
    texture.use(0)
    array = context.vertex_array(
        program,
        [
            (context.buffer(place.tobytes()), "2f4", "a_place"),
            (context.buffer(fronds.tobytes()), "3f4/i", "a_frond"),
        ],
        skip_errors=True,
    )
    still = np.eye(4, dtype="f4").tobytes()
    set_uniforms(
        program, u_leaves=0, u_eye=tuple(EYE), u_time=TIME_S, u_view_projection=still,
        u_projection=still, u_size=(1e9, 1e9),
    )  # fmt: skip
    out = context.buffer(reserve=len(fronds) * len(place) * 24)
    target = context.simple_framebuffer((1, 1))
    target.use()
    array.transform(out, moderngl.POINTS, vertices=len(place), instances=len(fronds))
    result = np.frombuffer(out.read(), np.float32).reshape(-1, 6)
    return result[:, :3], result[:, 3:]


@pytest.mark.parametrize("coarse", [False, True])
@pytest.mark.parametrize("kind", range(len(KINDS)), ids=KINDS)
def test_fronds_are_where_the_shader_bends_them(context: Any, kind: int, coarse: bool) -> None:
    leaves = leaves_of(kind)
    points, normals = drawn(context, leaves, coarse)
    (mesh,) = frond_meshes(leaves, coarse, EYE, TIME_S)
    assert mesh.kind == KINDS[kind]
    count = len(ribbon(*(COARSE if coarse else FINE))[0])
    shown = np.ptp(points.reshape(-1, count, 3), axis=1).max(axis=1) > 0.05
    shown = np.repeat(shown, count)  # a canopy that is not there is a point
    assert shown.any() and len(mesh.points) == shown.sum()
    np.testing.assert_allclose(mesh.points, points[shown], atol=0.02)
    tilted = (mesh.normals * normals[shown]).sum(axis=1)
    assert np.quantile(tilted, 0.01) > 0.999


def test_triangles_face_their_normals_and_colours_are_light(context: Any) -> None:
    leaves = np.concatenate([leaves_of(kind) for kind in range(len(KINDS))])
    meshes = frond_meshes(leaves, True, EYE, TIME_S)
    assert [mesh.kind for mesh in meshes] == list(KINDS)
    for mesh in meshes:
        a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
        facing = (np.cross(b - a, c - a) * mesh.normals[mesh.triangles].sum(axis=1)).sum(axis=1)
        assert (facing >= 0.0).all()
        assert (mesh.colors >= 0.0).all() and mesh.colors.max() < 1.0
