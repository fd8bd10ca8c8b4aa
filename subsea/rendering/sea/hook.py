"""The fishing hook: a bent wire with a worm, on its line."""

from typing import Any

import moderngl
import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.frame.packet import Packet
from subsea.rendering.gl.context import GpuOwner
from subsea.rendering.gl.id_buffer import HOOK
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.output.quality import Quality

METAL, BAIT, LINE = range(3)
SIDES = 10
BEND_CM, SHANK_CM, POINT_CM, WIRE_CM = 1.3, 4.2, 1.6, 0.16
WORM_CM = 0.42
LINE_CM = 0.05  # where that is less than a pixel, the shader draws a pixel and fades it
TOP_CM = 80.0  # height of the upper end of the line above the surface


class HookRenderer(GpuOwner):
    """Draws the hook of a packet."""

    def __init__(self, context: Any, quality: Quality) -> None:
        super().__init__()
        mesh = shape()
        self._count = len(mesh[1])
        self._programs = self.own(ProgramVariants(context, "hook", HOOK, quality.defines))
        vertices, triangles = self.own_buffers(context, mesh[0].astype("f4"), mesh[1].astype("i4"))
        names = "a_middle", "a_normal", "a_radius", "a_kind"
        self._array = self._programs.array([(vertices, "3f4 3f4 1f4 1f4", *names)], triangles)

    def draw(
        self, packet: Packet, number: int, uniforms: dict[str, Any], as_ids: bool = False
    ) -> int:
        """Draw it, or its object id, if it is in the water; returns the number of triangles."""
        if packet.hook is None:
            return 0
        place = tuple(float(x) for x in packet.hook)
        values = {"u_hook": place, "u_top": TOP_CM, "u_bait": packet.bait}
        self._programs.ready(self._array, as_ids, **uniforms, **values).render(moderngl.TRIANGLES)
        return self._count


def shape() -> tuple[Array, Ints]:
    """Vertices (n, 8) and triangles (m, 3) of hook, bait and line, cm, with the bend as origin.

    Columns are the point on the centre line, normal, radius and part. The upper end of the line is
    at height 1; the shader moves it above the surface.
    """
    bend = np.linspace(np.pi, 2 * np.pi, 17)
    arc = BEND_CM * np.stack([np.cos(bend), 0 * bend, np.sin(bend) + 1], axis=1)
    eye, point = arc[0] + (0, 0, SHANK_CM), arc[-1] + (0, 0, POINT_CM)
    barb = point + (-0.45, 0, -0.75)
    ring = np.linspace(-0.5 * np.pi, 1.5 * np.pi, 13)
    loop = eye + 0.35 * np.stack([np.cos(ring), 0 * ring, np.sin(ring) + 1], axis=1)
    wire = np.concatenate([loop[::-1], arc, [point]])
    thick = np.full(len(wire), WIRE_CM)
    thick[:13], thick[-1] = 0.7 * WIRE_CM, 0.02
    worm = arc[1:-1] + np.array([0, 0, -0.03])
    bulge = WORM_CM * (1 + 0.16 * np.sin(np.arange(len(worm)) * 2.2))
    bulge[[0, -1]] = 0.03
    bulge[[1, -2]] *= 0.75
    line = np.array([loop[6], loop[6] + (0, 0, 1)])
    parts = [
        _tube(wire, thick, METAL),
        _tube(np.array([point, barb]), np.array([0.02, 0.1]), METAL),
        _tube(worm, bulge, BAIT),
        _tube(line, np.full(2, LINE_CM), LINE),
    ]
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    vertices = np.concatenate([vertices for vertices, _ in parts])
    triangles = np.concatenate(
        [triangles + start for (_, triangles), start in zip(parts, starts, strict=False)]
    )
    return vertices, triangles


def _tube(path: Array, radius: Array, kind: int) -> tuple[Array, Ints]:
    """Vertices and triangles of a tube along a path (n, 3) in the plane y = 0, of radii (n,)."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    aside = np.stack([along[:, 2], 0 * along[:, 0], -along[:, 0]], axis=1)
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    normal = np.cos(angle)[:, None] * aside[:, None] + np.sin(angle)[:, None] * (0.0, 1.0, 0.0)
    n = len(path)
    vertices = np.empty((n, SIDES, 8))
    vertices[..., :3], vertices[..., 3:6] = path[:, None], normal
    vertices[..., 6], vertices[..., 7] = radius[:, None], kind
    row, side = np.divmod(np.arange((n - 1) * SIDES), SIDES)
    a, b = row * SIDES + side, row * SIDES + (side + 1) % SIDES
    c, d = a + SIDES, b + SIDES
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    return vertices.reshape(-1, 8), triangles
