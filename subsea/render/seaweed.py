"""Seaweed: ribbons along the chains of its leaves, bent in the vertex shader."""

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame import LEAF_TEXELS, Packet
from subsea.render.shaders import program, set_uniforms
from subsea.view.camera import View

Array = NDArray[np.floating[Any]]

LEAVES_UNIT = 5  # texture unit
FINE, COARSE = (13, 3), (7, 2)  # samples along a leaf and across it


class Seaweed:
    """Holds two ribbons, and the texture of the leaves in sight: one row each."""

    def __init__(self, context: Any) -> None:
        """Make the ribbons; the leaves come with each packet."""
        self._context = context
        self._program = program(context, "seaweed")
        self._held = [self._program]
        self._ribbons = []
        for size in (FINE, COARSE):
            places, triangles = ribbon(*size)
            buffers = [context.buffer(part.tobytes()) for part in (places, triangles)]
            layout = [(buffers[0], "2f4", "a_place")]
            array = context.vertex_array(self._program, layout, buffers[1])
            self._ribbons.append((array, len(triangles)))
            self._held += [array, *buffers]
        self._rows = 0
        self._leaves = self._texture(64)

    def _texture(self, rows: int) -> Any:
        texture = self._context.texture((LEAF_TEXELS, rows), 4, dtype="f4")
        texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self._rows = rows
        return texture

    def upload(self, packet: Packet) -> None:
        """Send the leaves in sight."""
        number = len(packet.leaves)
        if number > self._rows:
            self._leaves.release()
            self._leaves = self._texture(2 * number)
        if number:
            self._leaves.write(
                np.ascontiguousarray(packet.leaves, "f4"), viewport=(0, 0, LEAF_TEXELS, number)
            )

    def draw(self, packet: Packet, view: View, uniforms: dict[str, Any]) -> int:
        """Draw all leaves, the near ones finely; the number of triangles."""
        set_uniforms(self._program, u_leaves=LEAVES_UNIT, **uniforms)
        self._leaves.use(LEAVES_UNIT)
        fine, number = packet.fine_leaves, len(packet.leaves)
        total = 0
        for (array, triangles), first, count in zip(
            self._ribbons, (0, fine), (fine, number - fine), strict=True
        ):
            if count:
                set_uniforms(self._program, u_first=first)
                array.render(moderngl.TRIANGLES, instances=count)
                total += triangles * count
        return total

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (*self._held, self._leaves):
            held.release()


def ribbon(along: int, across: int) -> tuple[Array, NDArray[np.integer[Any]]]:
    """Places (n, 2) in [0, 1] along a leaf and [-1, 1] across it, and triangles (m, 3)."""
    t, u = np.meshgrid(np.linspace(0, 1, along), np.linspace(-1, 1, across), indexing="ij")
    k, j = (a.ravel() for a in np.meshgrid(range(along - 1), range(across - 1), indexing="ij"))
    a = k * across + j
    b, c, d = a + 1, a + across, a + across + 1
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    return np.stack([t.ravel(), u.ravel()], 1).astype("f4"), triangles.astype("i4")
