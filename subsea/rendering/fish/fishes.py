"""Fishes: B-spline surfaces from pre-evaluated tables, evaluated in the vertex shader (SMC §7).

All species are drawn by the same calls: their skins share one atlas, other constants of species are
in one uniform block, and each instance has the index of its species.
"""

from collections.abc import Sequence
from functools import cache
from itertools import accumulate
from math import cos, radians, sin
from operator import is_
from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.base.arrays import Array, Bytes, Ints
from subsea.base.disk_cache import cached
from subsea.fish import sheet_layout
from subsea.fish.color_sheet import sheets
from subsea.fish.face import GILL, jaws
from subsea.fish.mesh import (
    DETAILS,
    VERTEX_ATTRIBUTES,
    VERTEX_FORMAT,
    Mesh,
    fish_mesh,
    root_offset,
    species_vertices,
)
from subsea.fish.species import CourtshipColours, FinSkin, Species
from subsea.fish.surface import PaddlePlan
from subsea.frame.packet import INSTANCE_COLUMNS, ROW_A, ROW_B, Batch, Packet, RenderScene
from subsea.rendering.fish import speck as fish_speck
from subsea.rendering.fish.atlas import COARSEST, FRAMES, cell, frame, make_atlas, side_by_side
from subsea.rendering.fish.speck import Speck, dot, places, speck
from subsea.rendering.gl.context import GpuOwner, replace_data
from subsea.rendering.gl.feedback import VertexFeedback
from subsea.rendering.gl.id_buffer import FISH, object_id
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.shaders import (
    BLOCKS,
    TEXTURE_UNITS,
    required_defines,
    set_uniforms,
)
from subsea.rendering.gl.textures import table
from subsea.rendering.output.quality import PRESETS, Quality

FINE = 2  # levels whose fins are drawn after all bodies
# Defines of program variants, see `shaders/fishes.frag` and `shaders/show.glsl`.
SPECK, DOT, OWN_IDS, CAST = ("SPECK",), ("SPECK", "DOT"), ("OWN_IDS",), ("CAST",)
NO_TRIANGLE = np.zeros((1, 3), np.int32)
NOBODY = np.zeros((1, INSTANCE_COLUMNS), np.float32)

AT_ONCE = 128  # instances of a `FishShape`
TABLE_ROWS = 4096  # of the table of control points, as in shaders/fishes.glsl

TEETH = 24.0  # of a predator, on half the circumference of its body

INSTANCE_FORMAT = "4f4 4f4 4f4 4f4 3f4 4f4 3f4 4f4"
INSTANCE_ATTRIBUTES = (
    "i_place", "i_turn", "i_pose", "i_pectoral", "i_fins", "i_wave", "i_bend", "i_show",
)  # fmt: skip


class FishRenderer(GpuOwner):
    """Draws instances from a table of control points, a mesh per level and an atlas of skins."""

    def __init__(
        self,
        context: Any,
        scene: RenderScene,
        skins: list[Bytes] | None = None,
        quality: Quality = PRESETS["medium"],
    ) -> None:
        """Upload the species of a scene, with their own skins or `skins` as `paint` makes them."""
        super().__init__()
        self._context = context
        self._of = scene.species, scene.recorded_length_cm, scene.control_points
        self._table = self.own(table(context, row_table(scene.control_points)))
        self._instances = self.own(context.buffer(reserve=INSTANCE_COLUMNS * 4))
        self._skins = self.own(
            make_atlas(context, sheets(scene.species) if skins is None else skins)
        )
        looks = _looks(scene.species, scene.recorded_length_cm)
        self._looks = self.own(context.buffer(looks.tobytes()))
        self._meshes = [fish_mesh(detail) for detail in DETAILS]
        vertices, triangles, self._first = joined(self._meshes)
        self._vertices = self.own(
            table(context, cached(level_vertices, scene.species, self._meshes))
        )
        self._specks = [speck(), dot()]
        specks, speck_triangles, self._first_speck = joined(self._specks)
        self._places = self.own(table(context, speck_places(scene.species, self._specks)))
        # The programs of fishes and of specks, with their vertex arrays.
        self._forms = []
        for name, columns, indices, layout in (
            ("fishes", vertices, triangles, (VERTEX_FORMAT, *VERTEX_ATTRIBUTES)),
            ("fish_speck", specks, speck_triangles, fish_speck.LAYOUT),
        ):
            constants = {"SPECIES": len(scene.species), "COARSEST": COARSEST}
            first = _defines(SPECK if name == "fish_speck" else (), quality.defines)
            variants = self.own(ProgramVariants(context, name, None, first, **constants))
            buffers = self.own_buffers(context, columns, indices)
            self._forms.append((variants, variants.array([(buffers[0], *layout)], buffers[1])))
        # By vertex array: location, format and offset of each attribute of instances.
        self._attributes: dict[Any, list[tuple[int, str, int]]] = {}
        # Drivers that build programs at their first draw do it with the first picture: the last
        # triangle of each array has no area.
        # Separate programs for distant and for fading fishes, because discarding pixels is slow.
        plain = (), ("DISTANT",), ("FADING",), ("DISTANT", "FADING")
        self._cold = {self._made(own, quality.defines): len(triangles) - 1 for own in plain}
        for own in (SPECK, DOT):
            self._cold[self._made(own, quality.defines)] = len(speck_triangles) - 1

    def fits(self, scene: RenderScene) -> bool:
        """True if a scene has the same species and recorded motion."""
        species, lengths, points = self._of
        same = len(species) == len(scene.species) and all(map(is_, species, scene.species))
        same = same and lengths == scene.recorded_length_cm
        return same and (
            points is scene.control_points or np.array_equal(points, scene.control_points)
        )

    def upload(self, packet: Packet) -> None:
        """Upload the instances, and the control points of simulated fishes."""
        # Never empty: the first call of a program reads one instance.
        records = packet.instances if len(packet.instances) else NOBODY
        replace_data(self._instances, np.ascontiguousarray(records))
        if not len(packet.live_points):
            return
        texels = _texels(packet.live_points)
        points, first = texels.shape[1], packet.live_row
        while len(texels):  # at once, but for rows of the next block
            block, row = divmod(first, TABLE_ROWS)
            part = texels[: TABLE_ROWS - row]
            self._table.write(part.tobytes(), viewport=(points * block, row, points, len(part)))
            texels, first = texels[len(part) :], first + len(part)

    def update(
        self, species: tuple[Species, ...], length_cm: tuple[float, ...],
        skins: list[Bytes] | None = None,
    ) -> None:  # fmt: skip
        """Replace the shapes, and the skins if given, of all species."""
        self._looks.write(_looks(species, length_cm).tobytes())
        self._vertices.write(level_vertices(species, self._meshes).tobytes())
        self._places.write(speck_places(species, self._specks).tobytes())
        if skins is not None:
            self._skins.write(side_by_side(skins))
            self._skins.build_mipmaps(max_level=COARSEST)

    def draw(
        self, packet: Packet, number: int, uniforms: dict[str, Any], as_ids: bool = False
    ) -> int:
        """Draw the fishes of a view or their object ids; returns the number of triangles.

        Coarse levels come first, each in one call, with fins of two sides. Of fine levels all
        bodies come before all fins, which are translucent but write depth.
        """
        self._bind()
        batches = packet.batches[number]
        defines = required_defines(uniforms, as_ids) + OWN_IDS * as_ids
        values = uniforms | {"u_object_id": object_id(FISH)}
        for array in {*self._cold, *(self._variant(batch, defines) for batch in batches)}:
            set_uniforms(array.program, **values)
        while self._cold:
            array, nothing = self._cold.popitem()
            self._render(array, nothing, 1, 0, 1)
        total = 0
        fine = []
        self._context.enable(moderngl.CULL_FACE)
        for batch in batches:
            if batch.level >= len(DETAILS):
                number = batch.level - len(DETAILS)
                first, triangles = self._first_speck[number], len(self._specks[number].triangles)
            else:
                mesh, first = self._meshes[batch.level], self._first[batch.level]
                triangles = len(mesh.triangles)
                if batch.level < FINE and not batch.fading:
                    triangles = mesh.body
                    fine.append(batch)
            self._render(self._variant(batch, defines), first, triangles, batch.first, batch.count)
            total += triangles * batch.count
        self._context.disable(moderngl.CULL_FACE)
        if fine:  # consecutive batches with the same fins
            mesh, first = self._meshes[0], self._first[0] + self._meshes[0].body
            count = sum(batch.count for batch in fine)
            self._render(
                self._made((), defines), first, mesh.fins, min(b.first for b in fine), count
            )
            total += mesh.fins * count
        return total

    def cast(self, number: int, uniforms: dict[str, Any]) -> None:
        """Draw the first `number` instances as specks into the depth map in use."""
        self._bind()
        array = self._made(SPECK, CAST)
        set_uniforms(array.program, u_without=-1.0, **uniforms)
        self._render(array, 0, len(self._specks[0].triangles), 0, number)

    def _bind(self) -> None:
        self._table.use(TEXTURE_UNITS["u_table"])
        self._skins.use(TEXTURE_UNITS["u_skins"])
        self._vertices.use(TEXTURE_UNITS["u_vertices"])
        self._places.use(TEXTURE_UNITS["u_places"])
        self._looks.bind_to_uniform_block(BLOCKS["Looks"])

    def _variant(self, batch: Batch, defines: tuple[str, ...]) -> Any:
        if batch.level >= len(DETAILS):
            return self._made((SPECK, DOT)[batch.level - len(DETAILS)], defines)
        own = ("DISTANT",) * (batch.level >= FINE) + ("FADING",) * batch.fading
        return self._made(own, defines)

    def _made(self, own: tuple[str, ...], defines: tuple[str, ...]) -> Any:
        """Return the vertex array for these defines, made with its program when first needed."""
        variants, array = self._forms[own[:1] == SPECK]
        array = variants.variant(array, _defines(own, defines))
        if array not in self._attributes:
            formats, compiled = INSTANCE_FORMAT.split(), array.program
            offsets = accumulate((4 * int(kind[0]) for kind in formats), initial=0)
            self._attributes[array] = [
                (compiled[name].location, kind, offset)
                for name, kind, offset in zip(INSTANCE_ATTRIBUTES, formats, offsets, strict=False)
                if name in compiled
            ]
        return array

    def _render(self, array: Any, first: int, triangles: int, record: int, count: int) -> None:
        """Draw `triangles` from the `first` on, for `count` instances from `record` on.

        OpenGL 3.3 has no base instance, so the instance attributes are bound with an offset.
        """
        stride = INSTANCE_COLUMNS * 4
        for location, kind, offset in self._attributes[array]:
            at = record * stride + offset
            array.bind(location, "f", self._instances, kind, at, stride, 1)
        array.render(vertices=3 * triangles, first=3 * first, instances=count)


def _defines(own: tuple[str, ...], defines: tuple[str, ...]) -> tuple[str, ...]:
    """Join the defines of a level and of a picture; coarse levels lack details of close-ups."""
    coarse = own[:1] == SPECK or "DISTANT" in own
    return own + tuple(define for define in defines if not (coarse and define == "CLOSE_UP"))


def _texels(points: Array) -> Array:
    """Control points (rows, n, 3) as texels (rows, n, 4)."""
    return np.pad(np.asarray(points, np.float32), ((0, 0), (0, 0), (0, 1)))


def row_table(points: Array) -> Array:
    """Lay control points (rows, n, 3) out as texels, with blocks of TABLE_ROWS rows side by side.

    `table_place` of fishes.glsl finds a row there. Everything is written once: a table of a hundred
    megabytes takes ten times as long to pad and turn.
    """
    rows, count, _ = points.shape
    texels = np.zeros((min(rows, TABLE_ROWS), -(-rows // TABLE_ROWS), count, 4), np.float32)
    for block in range(texels.shape[1]):
        part = points[TABLE_ROWS * block : TABLE_ROWS * (block + 1)]
        texels[: len(part), block, :, :3] = part
    return texels.reshape(len(texels), -1, 4)


OUTPUTS = {"v_world": 3, "v_normal": 3, "v_skin": 2, "v_tone": 4}  # widths of DrawnVertices


class DrawnVertices(NamedTuple):
    """Vertices of T fishes as the vertex shader computes them, float32."""

    places: Array  # (T, n, 3) cm, world
    normals: Array  # (T, n, 3)
    skin: Array  # (T, n, 2) texture coordinates on the skin of the species
    tone: Array  # (T, n, 4) factors of red, green and blue, and of saturation


class ShapePoints(NamedTuple):
    """Vertices whose places on a fish are computed."""

    vertices: Array  # (n, 16) float32, columns as VERTEX_FORMAT
    own: Array  # (species, n, 4) as of `species_vertices`


def level_points(species: tuple[Species, ...], level: int) -> ShapePoints:
    """Collect the vertices of a level of detail."""
    mesh, detail = fish_mesh(DETAILS[level]), DETAILS[level]
    own = [species_vertices(one.surface, mesh, detail) for one in species]
    return ShapePoints(mesh.vertices, np.array(own))


class FishShape:
    """Computes vertices of fishes by `shaders/fishes.vert`."""

    def __init__(
        self, species: tuple[Species, ...], length_cm: tuple[float, ...], level: int | ShapePoints
    ) -> None:
        """Prepare species of these recorded lengths; UserError without OpenGL.

        The vertices are those of a level of detail, or any given ones.
        """
        points = level_points(species, level) if isinstance(level, int) else level
        self._vertices, self._own = points.vertices, points.own
        self.present = points.own[:, :, 2] >= 0.0  # (species, n) False for parts that one lacks
        rows = [
            row
            for pair in zip(species, length_cm, strict=True)
            for row in look(*pair, (0.0, 0.0, 1.0, 1.0))
        ]
        self._looks = np.array([*rows, *map(frame, FRAMES)], "f4")
        self._shader = _shape_shader(len(species))

    def at(self, instances: Array, control_points: Array) -> DrawnVertices:
        """Compute all vertices of instances (T, 30) from control points (rows, 426, 3)."""
        parts = [
            self._part(instances[first : first + AT_ONCE], control_points)
            for first in range(0, len(instances), AT_ONCE)
        ]
        if not parts:
            shape = 0, len(self._vertices)
            return DrawnVertices(*(np.zeros((*shape, width), "f4") for width in OUTPUTS.values()))
        return DrawnVertices(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _part(self, instances: Array, control_points: Array) -> list[Array]:
        instances = np.array(instances, "f4")
        used, row = np.unique(instances[:, [ROW_A, ROW_B]].astype(int), return_inverse=True)
        instances[:, [ROW_A, ROW_B]] = row.reshape(-1, 2)
        return self._shader.run(
            [
                (self._vertices, VERTEX_FORMAT, *VERTEX_ATTRIBUTES),
                (instances, f"{INSTANCE_FORMAT}/i", *INSTANCE_ATTRIBUTES),
            ],
            (len(instances), len(self._vertices)),
            {"u_table": _texels(control_points[used]), "u_vertices": self._own},
            {"Looks": self._looks},
        )


@cache
def _shape_shader(kinds: int) -> VertexFeedback:
    return VertexFeedback("fishes", OUTPUTS, SPECIES=kinds)


def joined(meshes: Sequence[Mesh | Speck]) -> tuple[Array, Ints, list[int]]:
    """Vertices, triangles (the last without area) and first triangles of all levels."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    first = np.cumsum([0] + [len(those) for those in triangles])[:-1]
    return (
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([*triangles, NO_TRIANGLE]).astype("i4"),
        first.tolist(),
    )


def level_vertices(species: tuple[Species, ...], meshes: list[Mesh]) -> Array:
    """Data that differ between species at the vertices of all levels, (species, n, 4) float32."""
    return np.array(
        [
            np.concatenate(
                [
                    species_vertices(kind.surface, *pair)
                    for pair in zip(meshes, DETAILS, strict=True)
                ]
            )
            for kind in species
        ],
        "f4",
    )


def speck_places(species: tuple[Species, ...], shapes: list[Speck]) -> Array:
    """As `speck.places` of some shapes, (species, n, 4) float32, but places on the atlas."""
    out = np.zeros((len(species), sum(len(shape.points) for shape in shapes), 4), "f4")
    for k, one in enumerate(species):
        left, bottom, width, height = cell(k, len(species))
        out[k] = np.concatenate([places(one.surface, shape) for shape in shapes])
        out[k, :, :2] = (left, bottom) + out[k, :, :2] * (width, height)
    return out


def _looks(species: tuple[Species, ...], length_cm: tuple[float, ...]) -> Array:
    """The uniform block: constants of each species, and the frames of a skin."""
    rows = [
        row
        for k, one in enumerate(zip(species, length_cm, strict=True))
        for row in look(*one, cell(k, len(species)))
    ]
    return np.array([*rows, *map(frame, FRAMES)], "f4")


def look(
    species: Species, length_cm: float, place: tuple[float, float, float, float]
) -> list[tuple[float, ...]]:
    """Constants of a species of recorded length, as in `fishes.glsl`; `place` is its `cell`."""
    surface, skin = species.surface, species.skin
    top = sheet_layout.half_height(surface)
    front, rear = sheet_layout.borders(surface)
    gape, soft = jaws(species)
    teeth = TEETH if species.kind == "predator" else 0.0
    gill = GILL * sheet_layout.head_size(surface) if skin.gills == 1 else 0.0
    vary, show = skin.variation, skin.display or CourtshipColours(of=(0, 0, 0), to=(0, 0, 0))
    edge = surface.back[-1][1] - surface.belly[-1][1]
    tall = edge / (1.0 - surface.tail.begin)
    shift = [to - of for to, of in zip(show.to, show.of, strict=True)]
    return [
        place,
        (front, -top, rear, top),
        (surface.eye.at, sheet_layout.eye_height(surface), surface.eye.radius, gill),
        (skin.gloss, skin.scales, skin.silver, float(surface.stiff_fins)),
        (length_cm, surface.tail.begin, show.brightness, vary.torn),
        (vary.hue, vary.saturation, vary.brightness, vary.pattern),
        (*skin.mouth[0], *skin.mouth[1]),
        (gape, soft, teeth, vary.scarred),
        (*show.of, show.reach**-2),
        (*shift, show.saturation),
        _stand(surface.pectoral),
        _stand(surface.pelvic),
        (_spiny(skin.dorsal), _spiny(skin.ventral), min(tall, 1.0), 0.0),
        (*root_offset(surface, surface.pectoral).tolist(), 0.0),
        (*root_offset(surface, surface.pelvic).tolist(), 0.0),
    ]


def _spiny(fin: FinSkin | None) -> float:
    """Return the share of a fin's base that has spines, in front of the soft rays."""
    return fin.spines / max(fin.spines + fin.soft_rays, 1) if fin else 0.0


def _stand(plan: PaddlePlan | None) -> tuple[float, ...]:
    """Cosine and sine of the droop of a paired fin; last 1 for a wing, else 0."""
    if plan is None:
        return (0.0,) * 4
    droop = radians(plan.droop)
    return cos(droop), sin(droop), float(plan.wing), 0.0
