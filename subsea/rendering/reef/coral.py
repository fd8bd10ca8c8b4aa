"""Drawing corals, sponges and anemones: meshes in place, size and colours of each growth."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from subsea.core.arrays import Array
from subsea.core.disk_cache import cached
from subsea.frame.packet import Packet
from subsea.habitat.mounds import variant_of
from subsea.habitat.reef import KINDS, MOUND, RUBBLE
from subsea.habitat.stone_shade import SUN
from subsea.rendering.gl.id_buffer import CORAL, object_id
from subsea.rendering.gl.mipmaps import Texels
from subsea.rendering.gl.owner import GpuOwner
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.static_batch import LazyMesh, StaticBatch, StaticMesh, bounding_spheres
from subsea.rendering.gl.textures import cell_distance, halves, repeating, tileable_noise
from subsea.rendering.reef.coral_mesh import CoralMesh, unit
from subsea.rendering.reef.coral_shapes import LEVELS, forms
from subsea.state import Reef

GRAIN_UNIT = 8  # texture unit
TILE_CM = 32.0  # of the grain
MOST_SWAY_CM = 10.0  # as `coral.vert`
FINEST_CM = 15.0  # radius below which growths have no finest level
SATURATION = 1.15
SHADE = 0.8  # share of the light missing under a growth
SHADED = 0.4  # share of the light left where stone hides the whole sky
SHADE_PX = 16.0  # smaller shadows are not drawn
SECTORS = 8  # of a shadow
# Offset of the middle of a shadow over the height of the growth; its width over the radius.
SLANT = 0.4 * np.array(SUN[:2]) / SUN[2]
FOOT = {"mound": 1.05, "fan": 0.3, "table": 0.9}

NOTHING = StaticMesh(np.zeros((0, 4), np.float32), np.zeros((0, 3), np.int32))
Ground = Callable[[Array, Array], Array]  # x and y in cm -> height of the sand in cm
THRESHOLDS_PX = (300.0, 120.0, 50.0, 16.0)  # diameters from which the levels are used
# Position; then words of four bytes: normal and sway; square root of the colour, and translucency;
# strength of the three grains, and light; last the texture position, in half floats.
LAYOUT = "3f4 4f1 4f1 4f1 2f2"
ATTRIBUTES = "a_position a_normal a_colour a_grain a_along"
COLUMNS = 7


class CoralLook(NamedTuple):
    """Surface of a kind: linear colours of body and tips, and texture."""

    colours: tuple[tuple[tuple[float, float, float], tuple[float, float, float]], ...]
    grain: tuple[float, float, float]  # strength of winding ridges, polyps, pores
    through: float  # translucency of thin parts
    sway_cm: float  # at the tips of a growth of 30 cm


OLIVE, TAN, CREAM = (0.20, 0.17, 0.055), (0.36, 0.22, 0.09), (0.78, 0.66, 0.44)
PINK, ROSE, MAGENTA = (0.72, 0.24, 0.34), (0.85, 0.38, 0.42), (0.55, 0.09, 0.26)
VIOLET, LILAC = (0.28, 0.12, 0.50), (0.56, 0.40, 0.80)
ORANGE, RED, YELLOW = (0.82, 0.27, 0.035), (0.55, 0.045, 0.035), (0.84, 0.58, 0.06)
LIME, GREEN, MINT = (0.42, 0.47, 0.11), (0.14, 0.32, 0.10), (0.48, 0.74, 0.50)
BROWN, SKY = (0.25, 0.13, 0.065), (0.42, 0.62, 0.88)

LOOKS = {
    "staghorn": CoralLook(
        ((TAN, CREAM), ((0.42, 0.28, 0.10), YELLOW), (OLIVE, MINT),
         ((0.26, 0.20, 0.36), (0.52, 0.56, 0.74))),
        (0.0, 0.5, 0.5), 0.1, 0.0,
    ),
    "bush": CoralLook(
        ((PINK, ROSE), ((0.42, 0.14, 0.46), LILAC), (LIME, (0.8, 0.85, 0.4)), (TAN, CREAM),
         ((0.70, 0.20, 0.20), (0.95, 0.62, 0.5))),
        (0.0, 0.8, 0.2), 0.1, 0.0,
    ),
    "table": CoralLook(
        ((BROWN, CREAM), (OLIVE, (0.62, 0.60, 0.26)), ((0.30, 0.16, 0.24), (0.66, 0.50, 0.66)),
         ((0.34, 0.20, 0.07), (0.80, 0.60, 0.25))),
        (0.0, 0.7, 0.4), 0.1, 0.0,
    ),
    "brain": CoralLook(
        ((OLIVE, LIME), (TAN, (0.70, 0.46, 0.14)), (GREEN, MINT),
         ((0.50, 0.20, 0.17), (0.72, 0.36, 0.30))),
        (0.8, 0.0, 0.15), 0.0, 0.0,
    ),
    "lettuce": CoralLook(
        (((0.42, 0.20, 0.30), ROSE), (LIME, (0.76, 0.72, 0.36)), (TAN, CREAM),
         ((0.34, 0.18, 0.08), (0.80, 0.52, 0.30))),
        (0.15, 0.4, 0.5), 0.35, 0.0,
    ),
    "finger": CoralLook(
        ((TAN, (0.80, 0.58, 0.28)), (LIME, (0.8, 0.8, 0.36)),
         ((0.45, 0.28, 0.28), (0.78, 0.52, 0.46))),
        (0.0, 0.7, 0.2), 0.35, 2.5,
    ),
    "leather": CoralLook(
        (((0.5, 0.32, 0.14), (0.80, 0.58, 0.30)), ((0.42, 0.40, 0.13), (0.80, 0.78, 0.40)),
         ((0.5, 0.26, 0.28), ROSE)),
        (0.0, 1.0, 0.1), 0.3, 2.0,
    ),
    "soft": CoralLook(
        (((0.80, 0.42, 0.42), MAGENTA), ((0.85, 0.55, 0.36), RED), ((0.84, 0.60, 0.40), ORANGE),
         ((0.62, 0.42, 0.72), (0.36, 0.12, 0.42)), ((0.85, 0.75, 0.55), YELLOW)),
        (0.0, 0.4, 0.1), 0.7, 4.0,
    ),
    "fan": CoralLook(
        ((MAGENTA, (0.75, 0.16, 0.30)), (VIOLET, LILAC), (ORANGE, (0.90, 0.50, 0.10)),
         ((0.60, 0.44, 0.06), YELLOW), (RED, (0.78, 0.13, 0.06))),
        (0.0, 0.4, 0.2), 0.5, 5.0,
    ),
    "pipes": CoralLook(
        ((YELLOW, (0.95, 0.80, 0.25)), (VIOLET, LILAC), ((0.58, 0.16, 0.09), ORANGE),
         ((0.50, 0.17, 0.30), PINK), ((0.16, 0.28, 0.46), SKY)),
        (0.0, 0.0, 1.0), 0.25, 0.0,
    ),
    "barrel": CoralLook(
        (((0.58, 0.20, 0.13), (0.80, 0.42, 0.30)), ((0.48, 0.20, 0.34), (0.78, 0.42, 0.52)),
         ((0.55, 0.34, 0.15), (0.80, 0.60, 0.34))),
        (0.2, 0.0, 1.0), 0.0, 0.0,
    ),
    "anemone": CoralLook(
        (((0.46, 0.34, 0.12), (0.86, 0.80, 0.52)), ((0.34, 0.36, 0.16), (0.62, 0.86, 0.56)),
         ((0.50, 0.26, 0.30), (0.92, 0.55, 0.66)), ((0.40, 0.30, 0.48), (0.80, 0.70, 0.95))),
        (0.0, 0.1, 0.1), 0.6, 4.5,
    ),
    "rubble": CoralLook(
        (((0.36, 0.32, 0.25), (0.52, 0.48, 0.40)), ((0.33, 0.21, 0.21), (0.50, 0.40, 0.36))),
        (0.0, 0.3, 0.8), 0.0, 0.0,
    ),
    "mound": CoralLook(
        (((0.13, 0.10, 0.07), (0.34, 0.18, 0.19)), ((0.13, 0.11, 0.06), (0.34, 0.24, 0.10)),
         ((0.14, 0.09, 0.10), (0.27, 0.18, 0.22))),
        (0.25, 0.5, 1.0), 0.0, 0.0,
    ),
}  # fmt: skip


class CoralRenderer(GpuOwner):
    """Draws the growths in sight, and their shadows."""

    def __init__(
        self, context: Any, reef: Reef, growths: list[list[LazyMesh]], reach_cm: float, sand: Ground
    ) -> None:
        """Upload the `growths` of `bake`; `reach_cm` is the visibility, `sand` the drawn ground."""
        super().__init__()
        # Mounds are always drawn: other growths stand on them.
        self._own = np.where(reef.kind == MOUND, 0.0, reef.own)
        self._grain = self.own(repeating(context, grained, 6))
        programs = ProgramVariants(context, "coral", lambda: object_id(CORAL, self._batch.owners))
        balls = cached(spheres, reef)
        self._batch = self.own(
            StaticBatch(programs, LAYOUT, ATTRIBUTES, growths, reach_cm, THRESHOLDS_PX, balls)
        )
        # Growths on mounds do not darken sand, and the shadow of rubble is negligible.
        gap = reef.place[:, 2] - sand(reef.place[:, 0], reef.place[:, 1])
        shaded = np.flatnonzero(~reef.on_rock & (gap < 3.0) & (reef.kind != RUBBLE))
        self._shaded = self._own[shaded]
        self._shadows = self.own(
            StaticBatch(
                ProgramVariants(context, "shadow"), "3f4 1f4", "a_position a_dark",
                [[shadow(reef.taken(k), sand), NOTHING] for k in shaded],
                reach_cm, (SHADE_PX,),
            )
        )  # fmt: skip

    @property
    def batches(self) -> tuple[StaticBatch, ...]:
        """State that depends on earlier packets."""
        return self._batch, self._shadows

    def choose(self, packet: Packet, detail: float = 1.0, growth: float = 1.0) -> None:
        """Choose what the views of a packet draw; `growth` is the share of growths to draw."""
        views, time_s = packet.views, packet.time_s
        self._batch.choose(views, time_s, detail, self._own <= growth)
        self._shadows.choose(views, time_s, detail, self._shaded <= growth)

    def draw(self, number: int, uniforms: dict[str, Any], as_ids: bool = False) -> int:
        """Draw the chosen growths or their object ids; returns the number of triangles."""
        self._grain.use(GRAIN_UNIT)
        return self._batch.draw(number, uniforms | {"u_grain": GRAIN_UNIT}, as_ids)

    def draw_shadows(self, number: int, uniforms: dict[str, Any]) -> int:
        """Blend shadows over the sand; returns the number of triangles."""
        unlit = {name: value for name, value in uniforms.items() if name != "u_lamps"}
        return self._shadows.draw(number, unlit)


def bake(reef: Reef) -> list[list[LazyMesh]]:
    """The meshes of all growths, level by level."""
    shapes: list[list[LazyMesh]] = [[] for _ in reef.kind]
    variant = variant_of(reef.own)
    groups = np.unique(np.stack([reef.kind, variant], axis=1), axis=0)

    meshes = cached(forms, [(list(KINDS)[kind], int(number)) for kind, number in groups])
    for group, levels in zip(groups, meshes, strict=True):
        chosen = np.flatnonzero((reef.kind == group[0]) & (variant == group[1]))
        placed = _PlacedGrowths(list(KINDS)[group[0]], reef.taken(chosen))
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


class _PlacedGrowths:
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
        tints = _tints(self.look, reef.own.astype(np.float64), reef.hue.astype(np.float64))
        # Square roots, as vertices store them.
        self.body, self.tips = (np.sqrt(np.clip(tint, 0, 1)).astype(np.float32) for tint in tints)
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
        words[..., 16:19] = 255.0 * (body + tip[:, None] * (tips - body)) + 0.5
        words[..., 19] = 255.0 * look.through * (0.35 + 0.65 * tip) + 0.5
        words[..., 20:23] = np.rint(255.0 * np.array(look.grain))
        words[..., 23] = 255.0 * self.light[k] * np.minimum(mesh.light, 1.0) + 0.5
        tiles = mesh.along * (size / TILE_CM)
        tiles += self.own[k]
        out.view(np.float16)[..., 12:14] = tiles
        return out


def shadow(growth: Reef, sand: Ground) -> StaticMesh:
    """The shadow of a growth: a mesh on the sand with the share of light missing."""
    kind = list(KINDS)[int(growth.kind)]
    tall = KINDS[kind].height
    out = np.array([0.6, 0.95, 1.5])[:, None] * FOOT.get(kind, 0.8)
    dark = np.array([0.95, 0.5, 0.0])[:, None] * SHADE
    turn = np.linspace(0.0, 2 * np.pi, SECTORS + 1)
    # Tall growths cast it to the side away from the sun.
    x, y = (
        growth.place[axis] + growth.radius * (out * np.array([np.cos, np.sin][axis](turn)) - slant)
        for axis, slant in enumerate(SLANT * tall)
    )
    vertices = np.stack([x, y, sand(x, y), dark + 0.0 * x], axis=-1).reshape(-1, 4)
    c = SECTORS + 1
    a = (np.arange(2)[:, None] * c + np.arange(SECTORS)).ravel()
    rim = a[1 : SECTORS - 1]
    cells = [np.stack(abc, 1) for abc in ((a, a + c + 1, a + 1), (a, a + c, a + c + 1))]
    cells.append(np.stack([0 * rim, rim, rim + 1], 1))  # the middle
    return StaticMesh(vertices.astype(np.float32), np.concatenate(cells))


def _tints(look: CoralLook, own: Array, hue: Array) -> tuple[Array, Array]:
    """Colours (k, 3) of body and tips: one of the kind's pairs, varied a little."""
    pairs = np.array(look.colours)
    pick = pairs[(hue * len(pairs)).astype(int)]
    off = np.stack([np.sin(own * f) for f in (911.0, 1327.0, 1741.0)], axis=1)
    bright = 1.0 + 0.16 * np.sin(own * 613.0)
    # More saturated, because water weakens colours.
    grey = pick.mean(axis=2, keepdims=True)
    pick = np.maximum(grey + SATURATION * (pick - grey), 0.015)
    pick = pick * (bright[:, None] * (1.0 + 0.12 * off))[:, None]
    return pick[:, 0], pick[:, 1]


def grained(seed: int) -> Texels:
    """The grain as a texture."""
    return halves(grain(seed))


def grain(seed: int) -> list[Array]:
    """Surface texture in three tileable layers (256, 256): ridges, polyps, pores."""
    size = 256
    k = np.fft.fftfreq(size) * size
    wave = np.hypot(k[:, None], k[None, :])
    rng = np.random.default_rng([seed, 0x9A])
    band = np.exp(-(((wave - 8.0) / 1.6) ** 2)) * np.exp(2j * np.pi * rng.uniform(size=wave.shape))
    winding = np.fft.ifft2(band).real
    ridges = np.abs(winding / winding.std())
    polyps = np.clip(1.0 - 1.5 * cell_distance(seed, size, 26), 0.0, 1.0) ** 0.8
    pores = tileable_noise(seed + 1, size, 1.0) - 1.3 * np.clip(
        1.0 - 2.2 * cell_distance(seed + 2, size, 40), 0.0, 1.0
    )
    layers = [np.clip(ridges, 0.0, 1.2) - 0.7, polyps - polyps.mean(), 0.4 * pores]
    return [layer - layer.mean() for layer in layers] + [np.zeros((size, size))]
