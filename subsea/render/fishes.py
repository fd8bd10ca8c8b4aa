"""Fishes: B-spline surfaces from pre-evaluated tables, evaluated in the vertex shader (SMC §7)."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from subsea.frame import INSTANCE_COLUMNS, LEVELS, Batch, Packet, Scene
from subsea.kinematics.spline import DEGREE, basis_at, dense, greville
from subsea.kinematics.surface import (
    DORSAL,
    FIN_U,
    FIN_V,
    LEFT,
    RIGHT,
    VENTRAL,
    PaddlePlan,
    SurfacePlan,
    U,
    V,
    rest_control_points,
)
from subsea.render import paint
from subsea.render.shaders import program, set_uniforms
from subsea.species import Species
from subsea.view.camera import View

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]

SKIN_UNIT = 3  # texture unit
SRGB8_ALPHA8 = 0x8C43  # OpenGL's name for the texels of a skin

BODY, FIN, PECTORAL, PELVIC = range(4)  # parts, as the shaders know them

FINEST_BODY = (17, 41)  # samples in u and v: 2,560 triangles on both halves
FINEST_FIN = (2, 35)
JAWS_AHEAD = 0.02  # body lengths from the snout to the tip of a mouth that it ends in
WING_SPREAD_RAD, WING_BEAT = 0.95, 0.2  # how far a wing stands out, and its share of the beat
PADDLE_SAMPLES = ((7, 6), (4, 3), (2, 2))  # by level

VERTEX_FORMAT = "1f4 3f4 3f4 3f4 3f4 4f4 4f4"
VERTEX_ATTRIBUTES = ("a_base", "a_u", "a_v", "a_du", "a_dv", "a_rest", "a_part")
VERTEX_COLUMNS = 21
INSTANCE_FORMAT = "4f4 4f4 4f4 4f4 3f4/i"
INSTANCE_ATTRIBUTES = ("i_place", "i_turn", "i_pose", "i_pectoral", "i_fins")


class Part(NamedTuple):
    """Vertices and triangles of one patch."""

    vertices: Array  # (n, 21)
    triangles: Ints  # (m, 3)


class Mesh(NamedTuple):
    """Vertices of one species at one level, and the triangles over them."""

    vertices: Array  # (n, 21) float32, columns as VERTEX_FORMAT
    triangles: Ints  # (m, 3) int32, those of the closed body first
    solid: int  # how many those are


def fish_mesh(plan: SurfacePlan, level: int) -> Mesh:
    """The pre-evaluated mesh of a species at a level of detail.

    Level 0 samples every patch finely. Level 1 has one vertex per control point, at that point's
    own parameter, so it lies on the surface and the silhouettes of both agree; level 2 takes
    every second of those. All levels go through the same shader.
    """
    rest = rest_control_points(plan, 1.0, 0.0)
    halves = ((LEFT.start, -1.0), (RIGHT.start, 1.0))
    parts = [
        _surface(rest, start, (U, V), level, FINEST_BODY, BODY, side) for start, side in halves
    ]
    if plan.wing:  # which is painted on both sides
        parts = [side for part in parts for side in _sides(plan, part)]
    solid = len(parts)
    for fin, place, side in ((plan.dorsal, DORSAL, 1.0), (plan.ventral, VENTRAL, -1.0)):
        if fin:
            parts.append(_surface(rest, place.start, (FIN_U, FIN_V), level, FINEST_FIN, FIN, side))
    for side in (-1.0, 1.0):
        for paddle, part in ((plan.pectoral, PECTORAL), (plan.pelvic, PELVIC)):
            if paddle:
                parts.append(_paddle(rest, paddle, level, part, side))
    starts = np.cumsum([0] + [len(part.vertices) for part in parts])
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    if not plan.wing:  # whose snout is closed
        triangles.insert(solid, _lips(parts[0].vertices, starts[1]))
        solid += 1
    return Mesh(
        np.concatenate([part.vertices for part in parts]).astype("f4"),
        np.concatenate(triangles).astype("i4"),
        sum(map(len, triangles[:solid])),
    )


def mesh_level(species: Species, level: int) -> int:
    """The mesh of a species at a level of detail: one finer where a whole wave runs along it.

    Coarse ones would cut its crests, of body and fins at different places.
    """
    return max(level - 1, 0) if species.spine else level


def _sides(plan: SurfacePlan, half: Part) -> tuple[Part, Part]:
    """The upper and the lower side of one half of a body with wings, with their own skins."""
    vertices, triangles = half
    sides = []
    for upper in (True, False):
        copy = vertices.copy()
        copy[:, 14] = paint.unfolded(plan, vertices[:, 15], np.full(len(vertices), upper))
        middle = vertices[triangles, 18].mean(axis=1)
        sides.append(Part(copy, triangles[(middle < 0.5) == upper]))
    return sides[0], sides[1]


def _lips(left: Array, half: int) -> Ints:
    """Triangles between the foremost vertices of both halves; without them a snout is a pipe.

    `left` are the vertices of the left half, those of the right one begin at `half`.
    """
    a = np.flatnonzero(left[:, 19] == 0.0)
    a, b = a[:-1], a[1:]
    return np.concatenate([np.stack([a, a + half, b], 1), np.stack([b, a + half, b + half], 1)])


def _parameters(controls: int, finest: int, level: int) -> Array:
    """Where a patch is evaluated along one of its axes."""
    if level == 0:
        return np.linspace(0.0, 1.0, finest)
    at = greville(controls, _degree(controls))
    if level == 2 and controls > 2:
        last = controls - 1
        at = at[np.round(np.linspace(0, last, last // 2 + 1)).astype(int)]
    return at


def _telling(line: Array, count: int) -> Ints:
    """Indices of the `count` points (n, 3) that show most of a line: both ends, then the farthest.

    So a far fin keeps its tip, which every second point may miss (Ramer, Douglas and Peucker).
    """
    kept = [0, len(line) - 1]
    while len(kept) < count:
        share = np.interp(np.arange(len(line)), kept, np.arange(len(kept)))
        cell = np.minimum(share.astype(int), len(kept) - 2)
        a, b = line[kept][cell], line[kept][cell + 1]
        along = ((line - a) * (b - a)).sum(axis=1) / np.maximum(((b - a) ** 2).sum(axis=1), 1e-12)
        off = np.linalg.norm(line - a - np.clip(along, 0.0, 1.0)[:, None] * (b - a), axis=1)
        off[kept] = -1.0
        kept = sorted([*kept, int(off.argmax())])
    return np.array(kept)


def _degree(controls: int) -> int:
    return min(DEGREE, controls - 1)


def _surface(
    rest: Array, base: int, controls: tuple[int, int], level: int, finest: tuple[int, int],
    part: int, side: float,
) -> Part:  # fmt: skip
    """One patch of u×v control points that begin at `base`."""
    at = [_parameters(*axis, level) for axis in zip(controls, finest, strict=True)]
    if part == FIN and level == 2:
        each = greville(FIN_V)
        edge = dense(basis_at(FIN_V, each), FIN_V) @ rest[base + FIN_V : base + 2 * FIN_V]
        at[1] = each[_telling(edge, len(at[1]))]
    u, v = (basis_at(n, t, _degree(n)) for n, t in zip(controls, at, strict=True))
    rows, columns, stride = len(at[0]), len(at[1]), controls[1]
    k, j = (a.ravel() for a in np.meshgrid(range(rows), range(columns), indexing="ij"))
    out = np.zeros((len(k), VERTEX_COLUMNS))
    out[:, 0] = base + u.first[k] * stride + v.first[j]
    out[:, 1:4], out[:, 4:7] = u.weight[k], v.weight[j]
    out[:, 7:10], out[:, 10:13] = u.slope[k], v.slope[j]
    tap = np.arange(3)
    points = out[:, 0].astype(int)[:, None, None] + tap[:, None] * stride + tap
    weight = u.weight[k][:, :, None] * v.weight[j][:, None, :]
    # A linear patch has a third row of weight zero, which may lie beyond the last point.
    near = rest[np.minimum(points, len(rest) - 1)]
    out[:, 13:16] = np.einsum("nab,nabx->nx", weight, near)
    out[:, 16], out[:, 17] = side, part
    out[:, 18], out[:, 19] = at[0][k], at[1][j]
    out[:, 20] = stride
    triangles = _grid(rows, columns)
    # Counter-clockwise from outside.
    return Part(out, triangles if side < 0 else triangles[:, ::-1])


def _paddle(rest: Array, plan: PaddlePlan, level: int, part: int, side: float) -> Part:
    """A fan on the flank that the shader turns about its root (Tu appendix B).

    Its root is the control point of the flank nearest to where the plan wants it; `a_rest` holds
    how far a vertex lies along and across the fin, `a_u` and `a_v` the directions of both, and
    `a_du` how far it is spread (rad), how much it beats, and how its plane leans outwards.
    """
    rows, columns = PADDLE_SAMPLES[level]
    along, across = (
        a.ravel()
        for a in np.meshgrid(np.linspace(0, 1, rows), np.linspace(-1, 1, columns), indexing="ij")
    )
    patch = RIGHT if side > 0 else LEFT
    root = np.argmin(np.hypot(rest[patch, 0] + plan.at, rest[patch, 1] - plan.height))
    droop = np.radians(plan.droop)
    out = np.zeros((len(along), VERTEX_COLUMNS))
    out[:, 0] = patch.start + root
    out[:, 1:4] = -np.cos(droop), -np.sin(droop), 0.0
    if plan.wing:
        # Its front edge bends back to the tip, its rear one is hollow; its root lies in the body.
        chord = (1.0 - along) ** 1.4 + 0.04
        out[:, 4:7] = 1.0, 0.0, 0.0
        out[:, 7:10] = WING_SPREAD_RAD, WING_BEAT, 0.0
        out[:, 13] = plan.length * (1.15 * along - 0.15)
        out[:, 14] = plan.width * (0.5 - 0.2 * along**2 - chord * (0.5 - 0.5 * across))
    else:
        out[:, 4:7] = -np.sin(droop), np.cos(droop), 0.0
        out[:, 7:10] = 0.0, 1.0, 0.35
        # Narrow at the root, widest at two thirds, rounded at the end.
        out[:, 13] = plan.length * (along - 0.3 * along**2 * across**2)
        out[:, 14] = 0.5 * plan.width * across * (0.25 + 0.75 * np.sin(0.76 * np.pi * along))
    out[:, 16], out[:, 17] = side, part
    out[:, 18], out[:, 19] = along, 0.5 + 0.5 * across
    return Part(out, _grid(rows, columns))


def _grid(rows: int, columns: int) -> Ints:
    """Two triangles per cell of a grid of vertices."""
    k, j = (a.ravel() for a in np.meshgrid(range(rows - 1), range(columns - 1), indexing="ij"))
    a = k * columns + j
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])


class Fishes:
    """Holds the table of control points, a mesh per species and level, and the instances."""

    def __init__(self, context: Any, scene: Scene) -> None:
        self._context = context
        self._program = program(context, "fishes")
        rows, points = scene.control_points.shape[:2]
        table = np.zeros((rows, points, 4), "f4")
        table[..., :3] = scene.control_points
        self._table = context.texture((points, rows), 4, table.tobytes(), dtype="f4")
        self._table.filter = (context.NEAREST, context.NEAREST)
        self._instances = context.buffer(reserve=INSTANCE_COLUMNS * 4)
        with ThreadPoolExecutor() as pool:  # numpy lets go of the interpreter's lock
            skins = pool.map(paint.paint, scene.species)
            self._skins = [_skin(context, texels) for texels in skins]
        self._looks = [
            _look(species, length)
            for species, length in zip(scene.species, scene.recorded_length_cm, strict=True)
        ]
        self._buffers: list[Any] = []
        self._arrays: dict[tuple[int, int], tuple[Any, Mesh]] = {}  # by species and level
        for kind, species in enumerate(scene.species):
            for level in range(len(LEVELS)):
                mesh = fish_mesh(species.surface, mesh_level(species, level))
                vertices = context.buffer(mesh.vertices.tobytes())
                triangles = context.buffer(mesh.triangles.tobytes())
                self._buffers += [vertices, triangles]
                array = context.vertex_array(
                    self._program,
                    [
                        (vertices, VERTEX_FORMAT, *VERTEX_ATTRIBUTES),
                        (self._instances, INSTANCE_FORMAT, *INSTANCE_ATTRIBUTES),
                    ],
                    triangles,
                )
                self._arrays[kind, level] = (array, mesh)

    def upload(self, packet: Packet) -> None:
        """Send instance records, and the control points of fishes that are simulated.

        The old instances are orphaned, never waited for.
        """
        size = max(packet.instances.nbytes, INSTANCE_COLUMNS * 4)
        self._instances.orphan(size)
        if len(packet.instances):
            self._instances.write(packet.instances.tobytes())
        rows, points = packet.live_points.shape[:2]
        if rows:
            texels = np.zeros((rows, points, 4), "f4")
            texels[..., :3] = packet.live_points
            self._table.write(texels.tobytes(), viewport=(0, packet.live_row, points, rows))

    def draw(self, packet: Packet, view: View, uniforms: dict[str, Any]) -> int:
        """Draw all bodies, then all fins, into the bound framebuffer; the number of triangles.

        Fins are translucent and write depth: drawn last, they let every body behind them show.
        """
        self._table.use(0)
        set_uniforms(self._program, u_table=0, u_skin=SKIN_UNIT, **uniforms)
        self._context.enable(moderngl.CULL_FACE)
        for batch in packet.batches:
            array, mesh = self._bound(batch)
            array.render(vertices=3 * mesh.solid, instances=batch.count)
        self._context.disable(moderngl.CULL_FACE)
        total = 0
        for batch in packet.batches:
            array, mesh = self._bound(batch)
            solid = 3 * mesh.solid
            array.render(vertices=mesh.triangles.size - solid, first=solid, instances=batch.count)
            total += len(mesh.triangles) * batch.count
        return total

    def _bound(self, batch: Batch) -> tuple[Any, Mesh]:
        """The vertex array and the mesh of a batch, with its species' uniforms and instances."""
        self._skins[batch.species].use(SKIN_UNIT)
        set_uniforms(self._program, **self._looks[batch.species])
        array, mesh = self._arrays[batch.species, batch.level]
        self._bind_from(array, batch.first)
        return array, mesh

    def _bind_from(self, array: Any, first: int) -> None:
        """Let the instance attributes begin at record `first`; 3.3 core has no base instance."""
        stride = INSTANCE_COLUMNS * 4
        formats = INSTANCE_FORMAT.removesuffix("/i").split()
        for place, (name, kind) in enumerate(zip(INSTANCE_ATTRIBUTES, formats, strict=True)):
            if name in self._program:
                location = self._program[name].location
                offset = first * stride + place * 16
                array.bind(location, "f", self._instances, kind, offset, stride, 1)

    def release(self) -> None:
        """Free every OpenGL object."""
        for array, _ in self._arrays.values():
            array.release()
        for held in (*self._buffers, *self._skins, self._instances, self._table, self._program):
            held.release()


def _skin(context: Any, texels: NDArray[np.uint8]) -> Any:
    """A painted skin as a mipmapped sRGB texture."""
    texture = context.texture(paint.SIZE, 4, texels.tobytes(), internal_format=SRGB8_ALPHA8)
    texture.build_mipmaps()
    texture.repeat_x = texture.repeat_y = False
    return texture


def _look(species: Species, length_cm: float) -> dict[str, Any]:
    """The uniforms that change with the species."""
    surface, skin = species.surface, species.skin
    paddles = skin.paddles
    top = paint.half_height(surface)
    front, rear = paint.borders(surface)
    return {
        "u_length": length_cm,
        "u_skin_box": (front, -top, rear, top),
        "u_paddle": (*paddles.colour, paddles.opacity) if paddles else (0.0,) * 4,
        "u_paddle_rim": (*(paddles.rim or paddles.colour), paddles.rim_width)
        if paddles
        else (0.0,) * 4,
        "u_gloss": skin.gloss,
        "u_scales": skin.scales,
        "u_rays": skin.rays,
        "u_eye_spot": (surface.eye.at, paint.eye_height(surface), surface.eye.radius),
        "u_stiff": float(surface.stiff_fins),
        # A jaw that lies beneath the snout does not show when it drops.
        "u_head": paint.head_size(surface) if skin.mouth[0][0] < JAWS_AHEAD else 1e-3,
        "u_tail_begin": surface.tail.begin,
    }
