"""Drawing corals, sponges and anemones: meshes in place, size and colours of each growth."""

from functools import partial
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.disk_cache import cached
from subsea.frame.packet import Packet
from subsea.habitat.mounds import variant_of
from subsea.habitat.reef import KINDS, MOUND
from subsea.rendering.gl.id_buffer import CORAL, object_id
from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.static_batch import LazyMesh, StaticBatch, bounding_spheres
from subsea.rendering.gl.textures import repeating
from subsea.rendering.output.quality import Quality
from subsea.rendering.reef.coral_looks import (
    ALGAE,
    DULL,
    LOOKS,
    PATCH,
    budded,
    grained,
    patches,
    tints,
)
from subsea.rendering.reef.coral_mesh import CoralMesh, unit
from subsea.rendering.reef.coral_shapes import LEVELS, forms
from subsea.state import Reef

GRAIN_UNIT, POLYPS_UNIT = 8, 9  # texture units
TILE_CM = 32.0  # of the grain
MOST_SWAY_CM = 10.0  # as `coral.vert`
FINEST_CM = 12.0  # radius below which growths have no finest level
SHADED = 0.4  # share of the light left where stone hides the whole sky
FOOT_DARK, FOOT_REACH = 0.55, 0.16  # light missing at the foot; radii over which it returns
CAST_LEVEL = 2  # of shadows on the map of the sun
THRESHOLDS_PX = (300.0, 120.0, 50.0, 16.0)  # diameters from which the levels are used
# Position; then words of four bytes: normal and sway; square root of the colour, and translucency;
# strength of the three grains, and light; last the texture position, in half floats.
LAYOUT = "3f4 4f1 4f1 4f1 2f2"
ATTRIBUTES = "a_position a_normal a_colour a_grain a_along"
COLUMNS = 7


class CoralRenderer(GpuOwner):
    """Draws the growths in sight."""

    def __init__(
        self,
        context: Any,
        reef: Reef,
        growths: list[list[LazyMesh]],
        reach_cm: float,
        quality: Quality,
    ) -> None:
        """Upload the `growths` of `bake`; `reach_cm` is the visibility."""
        super().__init__()
        self.adapt(quality)
        # Mounds are always drawn: other growths stand on them.
        self._own = np.where(reef.kind == MOUND, 0.0, reef.own)
        self._grain = self.own(repeating(context, grained, 6))
        self._polyps = self.own(repeating(context, budded, 7))
        programs = ProgramVariants(
            context, "coral", lambda: object_id(CORAL, self._batch.owners), self._wants
        )
        balls = cached(spheres, reef)
        self._batch = self.own(
            StaticBatch(programs, LAYOUT, ATTRIBUTES, growths, reach_cm, THRESHOLDS_PX, balls)
        )

    @property
    def batches(self) -> tuple[StaticBatch, ...]:
        """State that depends on earlier packets."""
        return (self._batch,)

    def choose(self, packet: Packet, detail: float = 1.0, growth: float = 1.0) -> None:
        """Choose what the views of a packet draw; `growth` is the share of growths to draw."""
        self._batch.choose(packet.views, packet.time_s, detail, self._own <= growth)

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on."""
        self._wants = quality.close_up_defines

    def draw(self, number: int, uniforms: dict[str, Any], as_ids: bool = False) -> int:
        """Draw the chosen growths or their object ids; returns the number of triangles."""
        self._grain.use(GRAIN_UNIT)
        self._polyps.use(POLYPS_UNIT)
        units = {"u_grain": GRAIN_UNIT, "u_polyps": POLYPS_UNIT}
        wants = () if as_ids else self._wants
        return self._batch.draw(number, uniforms | units, as_ids, wants)

    def cast(self, compiled: Any) -> None:
        """Draw all growths with a program that reads positions alone."""
        self._batch.cast(compiled, CAST_LEVEL)


def bake(reef: Reef) -> list[list[LazyMesh]]:
    """The meshes of all growths, level by level."""
    shapes: list[list[LazyMesh]] = [[] for _ in reef.kind]
    variant = variant_of(reef.own)
    groups = np.unique(np.stack([reef.kind, variant], axis=1), axis=0)

    meshes = cached(forms, [(list(KINDS)[kind], int(number)) for kind, number in groups])
    for group, levels in zip(groups, meshes, strict=True):
        chosen = np.flatnonzero((reef.kind == group[0]) & (variant == group[1]))
        placed = PlacedGrowths(list(KINDS)[group[0]], reef.taken(chosen))
        for number, k in enumerate(chosen.tolist()):
            # No eye comes near enough to a small one to need the finest level.
            shapes[k] = [
                LazyMesh(partial(placed.vertices, mesh, number), len(mesh.tip), mesh.triangles)
                for mesh in levels[int(reef.radius[k] < FINEST_CM) :]
            ]
    return [own if len(own) == LEVELS else [own[0], *own] for own in shapes]


def spheres(reef: Reef) -> Array:
    """The bounding spheres (k, 4) of all growths."""
    return bounding_spheres(bake(reef))


class PlacedGrowths:
    """k growths of one kind and variant: their axes, sizes and colours."""

    def __init__(self, kind: str, reef: Reef) -> None:
        self.look = LOOKS[kind]
        up = reef.axis.astype(np.float64)
        cos, sin = np.cos(reef.turn), np.sin(reef.turn)
        flat = np.stack([cos, sin, 0.0 * cos], axis=1)
        east = unit(flat - (flat * up).sum(axis=1, keepdims=True) * up)
        axes = np.stack([east, np.cross(up, east), up], axis=1)
        # Each is stretched differently, except for mounds, on which others stand.
        uneven = 0.0 if kind == "mound" else 0.08
        stretch = (
            1.0 - uneven + uneven * np.sin(np.outer(reef.own, (731.0, 1153.0, 1597.0)))[:, :, None]
        )
        self.axes = (reef.radius[:, None, None] * stretch * axes).astype(np.float32)
        self.slants = (axes / stretch).astype(np.float32)
        both = tints(self.look, reef.own.astype(np.float64), reef.hue.astype(np.float64))
        # Square roots, as vertices store them.
        self.body, self.tips = (np.sqrt(np.clip(tint, 0, 1)).astype(np.float32) for tint in both)
        self.place, self.radius, self.own = reef.place, reef.radius, reef.own
        self.light = SHADED + (1.0 - SHADED) * reef.light

    def vertices(self, mesh: CoralMesh, k: int) -> Array:
        """Vertices (n, COLUMNS) of growth k in world coordinates and its own colours."""
        tip, size, look = mesh.tip, self.radius[k], self.look
        normal = mesh.normal @ self.slants[k]
        normal *= (127.5 / np.sqrt(np.einsum("ni,ni->n", normal, normal)))[:, None]
        body, tips = self.body[k], self.tips[k]
        out = np.empty((len(tip), COLUMNS), np.float32)
        np.matmul(mesh.place, self.axes[k], out=out[:, :3])
        out[:, :3] += self.place[k]
        words = out.view(np.uint8)
        words[..., 12:15] = normal + 128.0
        most = 255.0 * look.sway_cm / 30.0 / MOST_SWAY_CM
        words[..., 15] = np.minimum(most * size * mesh.sway + 0.5, 255.0)
        colour = body + tip[:, None] * (tips - body)
        colour *= 1.0 + PATCH * patches(mesh.place, float(self.own[k]))[:, None]
        # Parts in the dark are dead and overgrown.
        dead = DULL * np.clip(1.3 - 2.2 * mesh.light - tip, 0.0, 1.0)[:, None]
        colour += dead * (np.sqrt(ALGAE, dtype=np.float32) - colour)
        words[..., 16:19] = 255.0 * np.clip(colour, 0.0, 1.0) + 0.5
        words[..., 19] = 255.0 * look.through * (0.35 + 0.65 * tip) + 0.5
        words[..., 20:23] = np.rint(255.0 * np.array(look.grain))
        light = np.minimum(mesh.light, 1.0) * contact(mesh.place[:, 2])
        words[..., 23] = 255.0 * self.light[k] * light + 0.5
        tiles = mesh.along * (size / TILE_CM)
        tiles += self.own[k]
        out.view(np.float16)[..., 12:14] = tiles
        return out


def contact(above: Array) -> Array:
    """The light (n,) that the ground leaves to the foot of a growth; `above` is in its radii."""
    return np.asarray(1.0 - FOOT_DARK * np.exp(-np.maximum(above, 0.0) / FOOT_REACH))
