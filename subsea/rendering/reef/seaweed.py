"""Drawing seaweed: ribbons bent along the chains of leaves in the vertex shader."""

from functools import cache
from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.frame.in_sight import LEAF_TEXELS
from subsea.frame.packet import Packet
from subsea.habitat.seaweed import KINDS
from subsea.kernels import kernel
from subsea.rendering.gl.context import GpuOwner, replace_data
from subsea.rendering.gl.feedback import VertexFeedback
from subsea.rendering.gl.id_buffer import SEAWEED
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.shaders import TEXTURE_UNITS
from subsea.rendering.output.quality import Quality

LUSH, FINE, COARSE = (19, 5), (13, 3), (7, 2)  # vertices along and across a leaf
GRASS = KINDS.index("grass")

# Numbers of the fronds drawn on a chain of each kind: near and far for close-ups, near and far
# without. Those of kelp are stipes, their blades, and the fronds of the canopy.
KELP_STIPES, KELP_BLADES, KELP_CANOPY = range(3), range(3, 51), range(51, 59)
FRONDS = {
    "ribbon": ([0], [0], [0], [0]),
    "kelp": (
        [*KELP_STIPES, *KELP_BLADES, *KELP_CANOPY],
        # Blades grow on the stipe with their number modulo 3.
        [0, *KELP_BLADES[::6], *KELP_BLADES[3::12], *KELP_CANOPY[::4]],
        [0, 1, *KELP_BLADES[::3], KELP_BLADES[1], *KELP_CANOPY[::4]],
        [0, *KELP_BLADES[::6], KELP_CANOPY[0]],
    ),
    "grass": ([*range(10)], [0, 2, 4], [*range(7)], [0, 2, 4]),
    "red": ([*range(16)], [0, *range(1, 12, 2)], [*range(12)], [0, *range(1, 12, 2)]),
}


def _table(level: int) -> Ints:
    """For kernels: a row for each kind of its fronds, and 1 for those that far leaves lack."""
    most = max(len(own[level]) for own in FRONDS.values()) + 1
    table = np.full((len(FRONDS), most, 2), -1)
    for row, own in zip(table, FRONDS.values(), strict=True):
        row[: len(own[level])] = [(k, k not in own[level | 1]) for k in own[level]]
    return table


FRONDS_AT = [_table(level) for level in range(4)]


class SeaweedRenderer(GpuOwner):
    """Draws fronds as instances of ribbons; a texture holds the leaves, a row each."""

    def __init__(self, context: Any, quality: Quality) -> None:
        super().__init__()
        self._context = context
        self.adapt(quality)
        self._programs = self.own(ProgramVariants(context, "seaweed", SEAWEED, quality.defines))
        self._ribbons = []
        for size in (LUSH, FINE, COARSE):
            mesh = ribbon(*size)
            places, triangles = self.own_buffers(context, *mesh)
            fronds = self.own(context.buffer(reserve=12, dynamic=True))
            layout = [(places, "2f4", "a_place"), (fronds, "3f4/i", "a_frond")]
            array = self._programs.array(layout, triangles)
            self._ribbons.append((array, len(mesh[1]), fronds))
        self._starts = [[0], [0], [0]]  # of the fronds of each view, and the end
        self._sized = self.own(GpuOwner())
        self._reserve(64)

    def _reserve(self, rows: int) -> None:
        """Make a larger texture."""
        self._sized.release()
        self._leaves = self._sized.own(self._context.texture((LEAF_TEXELS, rows), 4, dtype="f4"))
        self._leaves.filter = moderngl.NEAREST, moderngl.NEAREST

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on."""
        self._lush = quality.close_up

    def upload(self, packet: Packet) -> None:
        """Upload the leaves in sight, and the fronds on them."""
        number = len(packet.leaves)
        if number > self._leaves.height:
            self._reserve(2 * number)
        if number:
            texels = np.ascontiguousarray(packet.leaves, "f4")
            self._leaves.write(texels, viewport=(0, 0, LEAF_TEXELS, number))
        seen = packet.leaves_seen
        if seen is None:
            seen = np.ones((len(packet.views), number), np.bool_)
        near, far = (0, packet.fine_leaves), (packet.fine_leaves, number)
        ends = (near, (0, 0), far) if self._lush else ((0, 0), near, far)
        tables = (0, 2, 1 if self._lush else 3)
        for level, ((first, end), table) in enumerate(zip(ends, tables, strict=True)):
            if first == end:
                self._starts[level] = [0] * (len(packet.views) + 1)
                continue
            fronds, starts = fronds_of(packet.leaves, seen, first, end, FRONDS_AT[table])
            self._starts[level] = starts.tolist()
            if len(fronds):
                replace_data(self._ribbons[level][2], fronds)

    def draw(
        self, packet: Packet, number: int, uniforms: dict[str, Any], as_ids: bool = False
    ) -> int:
        """Draw the fronds of a view or their object ids; returns the number of triangles."""
        self._leaves.use(TEXTURE_UNITS["u_leaves"])
        total = 0
        for (array, triangles, fronds), starts in zip(self._ribbons, self._starts, strict=True):
            first, end = starts[number : number + 2]
            if end > first:
                array = self._programs.ready(array, as_ids, **uniforms)
                at = array.program["a_frond"].location
                array.bind(at, "f", fronds, "3f4", 12 * first, 12, 1)
                array.render(moderngl.TRIANGLES, instances=end - first)
                total += triangles * (end - first)
        return total


class BentFronds(NamedTuple):
    """Vertices of F fronds as the vertex shader computes them, float32, and their triangles."""

    kind: Ints  # (F,)
    places: Array  # (F, v, 3) cm, world
    normals: Array  # (F, v, 3)
    colours: Array  # (F, v, 3) linear, as at the middle of the frond
    along: Array  # (F, v) share of its length
    leaf: Ints  # (F,) row of `leaves` on which it grows ...
    chain: Array  # (F, v) ... and where on the chain of that leaf, 0 at the root to 1 at the tip
    triangles: Ints  # (m, 3) of each


def bent_fronds(leaves: Array, coarse: bool, eye: Array, time_s: float) -> BentFronds:
    """Compute the near fronds on leaves (k, 10, 4), which are texels of a packet.

    Stems are ribbons that face `eye` (3,), in cm. UserError without OpenGL.
    """
    ribbons, triangles = ribbon(*(COARSE if coarse else FINE))
    seen = np.ones((1, len(leaves)), np.bool_)
    fronds, _ = fronds_of(leaves, seen, 0, len(leaves), FRONDS_AT[2])
    kind = leaves[fronds[:, 0].astype(int), 0, 3].astype(int)
    if not len(fronds):
        nothing = np.zeros((0, len(ribbons), 3), np.float32)
        none = nothing[..., 0]
        return BentFronds(kind, nothing, nothing, nothing, none, kind, none, triangles)
    still = np.eye(4, dtype="f4").tobytes()
    places, normals, colours, shares = _bending().run(
        [(ribbons, "2f4", "a_place"), (fronds, "3f4/i", "a_frond")],
        (len(fronds), len(ribbons)),
        {"u_leaves": leaves},
        u_eye=tuple(map(float, eye)), u_time=float(time_s),
        # A large picture: no frond is widened to a pixel.
        u_view_projection=still, u_projection=still, u_size=(1e9, 1e9),
    )  # fmt: skip
    along, _, own, high = np.moveaxis(shares, 2, 0)
    # A blade of grass ends below the tip of its leaf.
    chain = np.where((kind == GRASS)[:, None], along * (0.5 + 0.5 * own), high)
    leaf = fronds[:, 0].astype(int)
    return BentFronds(kind, places, normals, colours, along, leaf, chain, triangles)


@cache
def _bending() -> VertexFeedback:
    return VertexFeedback("seaweed", {"v_world": 3, "v_normal": 3, "v_colour": 3, "v_place": 4})


@kernel
def fronds_of(leaves: Array, seen: Bools, first: int, end: int, fronds: Ints) -> tuple[Array, Ints]:
    """Fronds (m, 3) float32 that each view sees, and the bounds of views.

    A frond is its leaf, its number, and 1 if it is drawn only near.

    They grow on the `leaves` from `first` to `end` that a view has `seen` (v, k), kind by kind.
    `fronds` is one of FRONDS_AT.
    """
    views, kinds, most, _ = len(seen), *fronds.shape
    out = np.empty((views * max(end - first, 0) * most, 3), np.float32)
    bounds = np.zeros(views + 1, np.int64)
    place = 0
    for v in range(views):
        for kind in range(kinds):
            for k in range(first, end):
                if not seen[v, k] or leaves[k, 0, 3] != kind:
                    continue
                for i in range(most):
                    if fronds[kind, i, 0] < 0:
                        break
                    out[place, 0] = k
                    out[place, 1], out[place, 2] = fronds[kind, i, 0], fronds[kind, i, 1]
                    place += 1
        bounds[v + 1] = place
    return out[:place], bounds


def ribbon(along: int, across: int) -> tuple[Array, Ints]:
    """Vertices (n, 2), [0, 1] along a leaf and [-1, 1] across, and triangles (m, 3)."""
    t, u = np.meshgrid(np.linspace(0, 1, along), np.linspace(-1, 1, across), indexing="ij")
    k, j = (a.ravel() for a in np.meshgrid(range(along - 1), range(across - 1), indexing="ij"))
    a = k * across + j
    b, c, d = a + 1, a + across, a + across + 1
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    return np.stack([t.ravel(), u.ravel()], 1).astype("f4"), triangles.astype("i4")
