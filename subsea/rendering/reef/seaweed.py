"""Drawing seaweed: ribbons bent along the chains of leaves in the vertex shader."""

from typing import Any

import moderngl
import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.frame.packet import LEAF_TEXELS, Packet
from subsea.rendering.gl.id_buffer import SEAWEED
from subsea.rendering.gl.owner import GpuOwner, replace_data
from subsea.rendering.gl.programs import ProgramVariants

LEAVES_UNIT = 5  # texture unit
FINE, COARSE = (13, 3), (7, 2)  # vertices along and across a leaf

# Numbers of the fronds drawn on a chain of each kind: near, far.
FRONDS = {
    "ribbon": ([0], [0]),
    "kelp": ([*range(25)], [0, *range(1, 25, 2)]),
    "grass": ([*range(7)], [0, 2, 4]),
    "red": ([*range(12)], [0, *range(1, 12, 2)]),
}


class SeaweedRenderer(GpuOwner):
    """Draws fronds as instances of two ribbons; a texture holds the leaves, a row each."""

    def __init__(self, context: Any) -> None:
        super().__init__()
        self._context = context
        self._programs = self.own(ProgramVariants(context, "seaweed", SEAWEED))
        self._ribbons = []
        for size in (FINE, COARSE):
            mesh = ribbon(*size)
            places, triangles = self.own_buffers(context, *mesh)
            fronds = self.own(context.buffer(reserve=8, dynamic=True))
            layout = [(places, "2f4", "a_place"), (fronds, "2f4/i", "a_frond")]
            array = self._programs.array(layout, triangles)
            self._ribbons.append((array, len(mesh[1]), fronds))
        self._starts = [[0], [0]]  # of the fronds of each view, and the end
        self._sized = self.own(GpuOwner())
        self._reserve(64)

    def _reserve(self, rows: int) -> None:
        """Make a larger texture."""
        self._sized.release()
        self._leaves = self._sized.own(self._context.texture((LEAF_TEXELS, rows), 4, dtype="f4"))
        self._leaves.filter = moderngl.NEAREST, moderngl.NEAREST

    def upload(self, packet: Packet) -> None:
        """Upload the leaves in sight, and the fronds on them."""
        number = len(packet.leaves)
        if number > self._leaves.height:
            self._reserve(2 * number)
        if number:
            texels = np.ascontiguousarray(packet.leaves, "f4")
            self._leaves.write(texels, viewport=(0, 0, LEAF_TEXELS, number))
        ends = (0, packet.fine_leaves), (packet.fine_leaves, number)
        for level, (first, end) in enumerate(ends):
            fronds = fronds_of(packet.leaves[first:end], level)
            fronds[:, 0] += first
            if packet.leaves_seen is None:
                fronds = np.tile(fronds, (len(packet.views), 1))
                lengths = [len(fronds) // len(packet.views)] * len(packet.views)
            else:
                seen = packet.leaves_seen[:, fronds[:, 0].astype(int)]
                lengths = seen.sum(axis=1)
                fronds = fronds[np.nonzero(seen)[1]]
            self._starts[level] = np.cumsum([0, *lengths]).tolist()
            if len(fronds):
                replace_data(self._ribbons[level][2], np.ascontiguousarray(fronds))

    def draw(
        self, packet: Packet, number: int, uniforms: dict[str, Any], as_ids: bool = False
    ) -> int:
        """Draw the fronds of a view or their object ids; returns the number of triangles."""
        self._leaves.use(LEAVES_UNIT)
        total = 0
        for (array, triangles, fronds), starts in zip(self._ribbons, self._starts, strict=True):
            first, end = starts[number : number + 2]
            if end > first:
                array = self._programs.ready(array, as_ids, u_leaves=LEAVES_UNIT, **uniforms)
                at = array.program["a_frond"].location
                array.bind(at, "f", fronds, "2f4", 8 * first, 8, 1)
                array.render(moderngl.TRIANGLES, instances=end - first)
                total += triangles * (end - first)
        return total


def fronds_of(leaves: Array, level: int) -> Array:
    """Leaf and number (m, 2) float32 of the fronds on leaves (k, LEAF_TEXELS, 4)."""
    kind = leaves[:, 0, 3].astype(int)
    parts = [np.zeros((0, 2), np.float32)]
    for number, fronds in enumerate(FRONDS.values()):
        rows = np.flatnonzero(kind == number)
        if not len(rows):
            continue
        own = fronds[level]
        parts.append(np.stack([np.repeat(rows, len(own)), np.tile(own, len(rows))], axis=1))
    return np.concatenate(parts).astype(np.float32)


def ribbon(along: int, across: int) -> tuple[Array, Ints]:
    """Vertices (n, 2), [0, 1] along a leaf and [-1, 1] across, and triangles (m, 3)."""
    t, u = np.meshgrid(np.linspace(0, 1, along), np.linspace(-1, 1, across), indexing="ij")
    k, j = (a.ravel() for a in np.meshgrid(range(along - 1), range(across - 1), indexing="ij"))
    a = k * across + j
    b, c, d = a + 1, a + across, a + across + 1
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    return np.stack([t.ravel(), u.ravel()], 1).astype("f4"), triangles.astype("i4")
