"""Draw a USD stage through its own camera, as a map of what each pixel shows."""

from typing import Any

import moderngl
import numpy as np
from pxr import Usd, UsdGeom

VERTEX = """#version 330
uniform mat4 u_whole; in vec3 a_place; in float a_label; flat out float v_label;
void main() { v_label = a_label; gl_Position = u_whole * vec4(a_place, 1.0); }
"""
FRAGMENT = """#version 330
flat in float v_label; out float f_label;
void main() { f_label = v_label; }
"""


def meshes_of(stage: Any, frame: int) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Path, world points (n, 3) in metres and triangles (m, 3) of all visible meshes."""
    cache = UsdGeom.XformCache(frame)
    found = []
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()):
        mesh = UsdGeom.Mesh(prim)
        if not mesh or mesh.ComputeVisibility(frame) == UsdGeom.Tokens.invisible:
            continue
        whole = np.array(cache.GetLocalToWorldTransform(prim))
        points = np.array(mesh.GetPointsAttr().Get(frame), float) @ whole[:3, :3] + whole[3, :3]
        triangles = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
        found.append((str(prim.GetPath()), points, triangles))
    return found


def label_map(
    context: Any, stage: Any, camera: str, frame: int, size: tuple[int, int], labels: Any
) -> np.ndarray:
    """The mesh in each pixel (h, w), top row first: `labels(path)` of it, 0 for nothing."""
    frustum = UsdGeom.Camera(stage.GetPrimAtPath(camera)).GetCamera(frame).frustum
    view, projection = (
        np.array(one) for one in (frustum.ComputeViewMatrix(), frustum.ComputeProjectionMatrix())
    )
    place, label = [], []
    for path, points, triangles in meshes_of(stage, frame):
        corners = points[triangles.ravel()]
        place.append(corners.astype("f4"))
        label.append(np.full(len(corners), labels(path), "f4"))
    program = context.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
    program["u_whole"].write((view @ projection).astype("f4").tobytes())
    array = context.vertex_array(
        program,
        [
            (context.buffer(np.concatenate(place).tobytes()), "3f4", "a_place"),
            (context.buffer(np.concatenate(label).tobytes()), "1f4", "a_label"),
        ],
    )
    texture, depth = context.texture(size, 1, dtype="f4"), context.depth_renderbuffer(size)
    target = context.framebuffer([texture], depth)
    target.use()
    target.clear()
    context.enable(moderngl.DEPTH_TEST)
    array.render()
    shown = np.frombuffer(texture.read(), np.float32).reshape(size[1], size[0])
    return np.asarray(shown[::-1])
