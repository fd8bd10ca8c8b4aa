"""Drawing corals, sponges and anemones: meshes in place, size, colours and texture of a growth."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.habitat.reef import KINDS, MOUND
from subsea.habitat.terrain import variant_of
from subsea.rendering.gl.id_buffer import CORAL, object_id
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.static_batch import LazyMesh, StaticBatch, bounding_spheres
from subsea.rendering.gl.textures import (
    Texels,
    cell_distance,
    halves,
    in_bytes,
    nearest_of_cells,
    repeating,
    tileable_noise,
)
from subsea.rendering.output.quality import Quality
from subsea.rendering.reef.coral_kinds import forms
from subsea.rendering.reef.coral_mesh import CoralMesh, unit
from subsea.state import Reef

PATCH = 0.12  # brightness of patches of a growth, as a share
DULL = 0.75  # share of the colour of dead skeleton where no light falls
ALGAE = np.array([0.115, 0.10, 0.06])  # that colour, linear
SEPTA = 10  # walls of a polyp's cup
CUPS, PITS = 10, 18  # across a texture
# Ranges of the bytes of the texture of polyps, about 0: slopes, height of cups, depth of pits.
POLYP_SPAN = np.array([4.0, 4.0, 2.0, 2.0])

Colour = tuple[float, float, float]


class CoralLook(NamedTuple):
    """Surface of a kind: linear colours of body and tips, and texture."""

    colours: tuple[tuple[Colour, Colour], ...]
    grain: tuple[float, float, float]  # strength of winding ridges, polyps, pores
    through: float  # translucency of thin parts
    sway_cm: float  # at the tips of a growth of 30 cm


# Most of a reef is brown: its algae are. Accents are rare.
BROWN, UMBER, TAN = (0.20, 0.115, 0.055), (0.13, 0.085, 0.05), (0.34, 0.225, 0.115)
OCHRE, HONEY, CREAM = (0.42, 0.27, 0.085), (0.58, 0.40, 0.17), (0.70, 0.60, 0.43)
OLIVE, KHAKI, SAGE = (0.18, 0.165, 0.06), (0.33, 0.30, 0.135), (0.36, 0.42, 0.25)
GREY, BONE, WHITE = (0.27, 0.25, 0.22), (0.56, 0.51, 0.42), (0.80, 0.76, 0.66)
DUSTY, ROSE, PINK = (0.42, 0.22, 0.20), (0.62, 0.37, 0.34), (0.64, 0.24, 0.30)
MAUVE, LILAC, PLUM = (0.28, 0.18, 0.25), (0.50, 0.40, 0.56), (0.25, 0.085, 0.16)
RUST, ORANGE, RED = (0.40, 0.15, 0.06), (0.72, 0.27, 0.06), (0.45, 0.05, 0.04)
YELLOW, LIME, GREEN = (0.72, 0.50, 0.10), (0.46, 0.50, 0.15), (0.15, 0.24, 0.10)
BLUE, TEAL = (0.22, 0.26, 0.42), (0.12, 0.24, 0.22)

LOOKS = {
    "staghorn": CoralLook(
        ((TAN, WHITE), (BROWN, CREAM), (OCHRE, CREAM), (OLIVE, BONE), ((0.21, 0.18, 0.19), BLUE),
         (TAN, LILAC)),
        (0.0, 0.6, 0.35), 0.1, 0.0,
    ),
    "bush": CoralLook(
        ((DUSTY, ROSE), (TAN, CREAM), (OLIVE, KHAKI), (BROWN, HONEY), (PINK, (0.80, 0.52, 0.50)),
         (KHAKI, CREAM), (MAUVE, LILAC)),
        (0.0, 0.7, 0.2), 0.1, 0.0,
    ),
    "table": CoralLook(
        ((BROWN, CREAM), (OLIVE, KHAKI), (UMBER, TAN), (TAN, BONE), ((0.20, 0.14, 0.16), LILAC)),
        (0.0, 0.7, 0.3), 0.1, 0.0,
    ),
    "brain": CoralLook(
        ((OLIVE, KHAKI), (BROWN, TAN), (OCHRE, HONEY), (GREY, BONE), (GREEN, SAGE),
         (DUSTY, ROSE)),
        (0.65, 0.0, 0.1), 0.0, 0.0,
    ),
    "lettuce": CoralLook(
        ((BROWN, CREAM), (OLIVE, LIME), (TAN, WHITE), (MAUVE, ROSE), (UMBER, HONEY)),
        (0.2, 0.5, 0.3), 0.9, 0.0,
    ),
    "finger": CoralLook(
        ((TAN, CREAM), (OLIVE, SAGE), (DUSTY, ROSE), (GREY, BONE), (OCHRE, HONEY)),
        (0.0, 0.7, 0.15), 0.35, 2.5,
    ),
    "leather": CoralLook(
        ((TAN, CREAM), (OLIVE, KHAKI), (OCHRE, HONEY), (DUSTY, BONE), (SAGE, (0.55, 0.58, 0.38))),
        (0.0, 0.9, 0.1), 0.3, 2.0,
    ),
    "soft": CoralLook(
        ((BONE, DUSTY), (CREAM, RUST), (BONE, ORANGE), (WHITE, PINK), (BONE, PLUM),
         (CREAM, YELLOW)),
        (0.0, 0.4, 0.1), 0.7, 4.0,
    ),
    "fan": CoralLook(
        ((RUST, ORANGE), (PLUM, PINK), (OCHRE, YELLOW), (MAUVE, LILAC), (RED, (0.60, 0.14, 0.08)),
         (TAN, CREAM)),
        (0.0, 0.4, 0.2), 0.5, 5.0,
    ),
    "pipes": CoralLook(
        ((OCHRE, YELLOW), (MAUVE, LILAC), (RUST, ORANGE), (TAN, CREAM), (DUSTY, ROSE),
         (TEAL, (0.30, 0.46, 0.44))),
        (0.0, 0.0, 1.0), 0.25, 0.0,
    ),
    "barrel": CoralLook(
        ((RUST, DUSTY), (BROWN, ROSE), (TAN, CREAM), (MAUVE, BONE)),
        (0.2, 0.0, 1.0), 0.0, 0.0,
    ),
    "anemone": CoralLook(
        ((OCHRE, CREAM), (OLIVE, SAGE), (TAN, WHITE), (BROWN, ROSE), ((0.30, 0.24, 0.20), LILAC)),
        (0.0, 0.1, 0.1), 0.6, 4.5,
    ),
    "rubble": CoralLook(
        ((GREY, BONE), ((0.30, 0.22, 0.20), (0.48, 0.40, 0.36)), (UMBER, GREY)),
        (0.0, 0.3, 0.7), 0.0, 0.0,
    ),
    "mound": CoralLook(
        (((0.15, 0.115, 0.07), (0.30, 0.18, 0.17)), ((0.15, 0.13, 0.07), (0.32, 0.25, 0.13)),
         ((0.16, 0.12, 0.10), (0.25, 0.19, 0.19))),
        (0.3, 0.5, 0.35), 0.0, 0.0,
    ),
}  # fmt: skip


def tints(look: CoralLook, own: Array, hue: Array) -> tuple[Array, Array]:
    """Colours (k, 3) of body and tips: one of the kind's pairs, varied a little."""
    pairs = np.array(look.colours)
    pick = pairs[(hue * len(pairs)).astype(int)]
    # Toward the next pair, so that neighbours of one colour differ.
    other = pairs[((hue * len(pairs)).astype(int) + 1) % len(pairs)]
    share = 0.35 * np.abs(np.sin(own * 419.0))[:, None, None]
    off = np.stack([np.sin(own * f) for f in (911.0, 1327.0, 1741.0)], axis=1)
    bright = 1.0 + 0.2 * np.sin(own * 613.0)
    pick = (pick + share * (other - pick)) * (bright[:, None] * (1.0 + 0.1 * off))[:, None]
    return pick[:, 0], pick[:, 1]


def patches(place: Array, own: float) -> Array:
    """Slow noise (n,) within about ±1 at points (n, 3) of a growth of size 1."""
    phase = 6.2832 * np.array([own, 7.3 * own, 13.7 * own], np.float32)
    ways = np.array([[2.9, 4.1, 1.7], [-3.7, 1.9, 3.3], [6.1, -5.3, 4.7]], np.float32)
    return np.asarray(np.sin(place @ ways.T + phase) @ np.array([0.5, 0.45, 0.3], np.float32))


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
    winding = np.abs(winding / winding.std())
    # Broad walls with a groove along their tops, and broad valleys.
    ridges = (
        1.0 - np.exp(-((winding / 0.85) ** 2)) - 0.22 * np.exp(-(((winding - 1.5) / 0.35) ** 2))
    )
    polyps = np.clip(1.0 - 1.5 * cell_distance(seed, size, 26), 0.0, 1.0) ** 0.8
    pores = tileable_noise(seed + 1, size, 1.0) - 1.3 * np.clip(
        1.0 - 2.2 * cell_distance(seed + 2, size, 40), 0.0, 1.0
    )
    layers = [ridges, polyps - polyps.mean(), 0.4 * pores]
    return [layer - layer.mean() for layer in layers] + [np.zeros((size, size))]


def polyps(seed: int) -> list[Array]:
    """Polyps at arm's length in four tileable layers (256, 256), each with mean 0.

    Slopes along x and y, deviation 1, and height of cups with septa between wall and middle; depth
    of the pits of a sponge.
    """
    size = 256
    x, y, which = nearest_of_cells(seed, size, CUPS)
    rng = np.random.default_rng([seed, 0xC1])
    wide, turn, tall = rng.uniform(size=(3, CUPS * CUPS))[:, which]
    far = np.hypot(x, y) / (0.7 + 0.5 * wide)
    wall = np.exp(-(((far - 0.36) / 0.13) ** 2))
    cup = np.exp(-((far / 0.30) ** 4))
    septa = np.cos(SEPTA * np.arctan2(y, x) + 6.2832 * turn) * np.clip(far / 0.12, 0.0, 1.0)
    height = (0.7 + 0.6 * tall) * (wall + 0.35 * cup * septa * np.clip(1.6 - 2.5 * far, 0.0, 1.0))
    height += 0.5 * np.exp(-((far / 0.09) ** 2)) - 0.45 * cup
    height += 0.06 * tileable_noise(seed + 3, size, 0.9)
    slopes = [np.roll(height, -1, axis) - np.roll(height, 1, axis) for axis in (1, 0)]
    mean = np.sqrt((slopes[0] ** 2 + slopes[1] ** 2).mean() / 2)
    pits = -(np.clip(1.0 - 2.4 * cell_distance(seed + 4, size, PITS), 0.0, 1.0) ** 0.7)
    pits += 0.22 * tileable_noise(seed + 5, size, 1.2)
    layers = [slopes[0] / mean, slopes[1] / mean, height, pits]
    return [layer - layer.mean() for layer in layers]


def budded(seed: int) -> Texels:
    """Polyps as a texture."""
    return in_bytes(polyps(seed), -POLYP_SPAN, POLYP_SPAN)


TILE_CM = 32.0  # of the grain
MOST_SWAY_CM = 10.0  # as `coral.vert`
FINEST_CM = 12.0  # radius below which growths have no finest level
SHADED = 0.4  # share of the light left where stone hides the whole sky
FOOT_DARK, FOOT_REACH = 0.55, 0.16  # light missing at the foot; radii over which it returns
CAST_LEVEL = 2  # of shadows on the map of the sun
THRESHOLDS_PX = (300.0, 120.0, 50.0, 28.0, 16.0)  # diameters from which the levels are used
# Position; then words of four bytes: normal and sway; square root of the colour, and translucency;
# strength of the three grains, and light; last the texture position, in half floats.
LAYOUT = "3f4 4f1 4f1 4f1 2f2"
ATTRIBUTES = "a_position a_normal a_colour a_grain a_along"
COLUMNS = 7


class CoralRenderer(StaticBatch):
    """Draws the growths in sight."""

    def __init__(
        self,
        context: Any,
        reef: Reef,
        growths: list[list[LazyMesh]],
        balls: Array,
        reach_cm: float,
        quality: Quality,
    ) -> None:
        """Upload the `growths` of `bake` in their `spheres`; `reach_cm` is the visibility."""
        programs = ProgramVariants(
            context, "coral", lambda: object_id(CORAL, self.owners), quality.defines
        )
        super().__init__(programs, LAYOUT, ATTRIBUTES, growths, reach_cm, THRESHOLDS_PX, balls)
        # Mounds are always drawn: other growths stand on them.
        self._own = np.where(reef.kind == MOUND, 0.0, reef.own)
        self._growth, self._shown = 1.0, self._own <= 1.0  # the last share, and what it shows
        self.textures = {
            "u_grain": self.own(repeating(context, grained, 6)),
            "u_polyps": self.own(repeating(context, budded, 7)),
        }

    def shown(self, growth: float) -> Bools:
        """Return True for each growth that is drawn if `growth` is the share of them to draw."""
        if growth != self._growth:
            self._growth, self._shown = growth, self._own <= growth
        return self._shown


def bake(reef: Reef) -> list[list[LazyMesh]]:
    """The meshes of all growths, level by level."""
    return _baked(reef, PlacedGrowths.vertices)


def _baked(
    reef: Reef, columns: "Callable[[PlacedGrowths, CoralMesh, int], Array]"
) -> list[list[LazyMesh]]:
    """The meshes of all growths, with these columns of vertices."""
    shapes: list[list[LazyMesh]] = [[] for _ in reef.kind]
    variant = variant_of(reef.own)
    groups = np.unique(np.stack([reef.kind, variant], axis=1), axis=0)

    meshes = forms([(list(KINDS)[kind], int(number)) for kind, number in groups])
    for group, levels in zip(groups, meshes, strict=True):
        chosen = np.flatnonzero((reef.kind == group[0]) & (variant == group[1]))
        placed = PlacedGrowths(list(KINDS)[group[0]], reef.taken(chosen))
        for number, k in enumerate(chosen.tolist()):
            # No eye comes near enough to a small one to need the finest level.
            small = int(reef.radius[k] < FINEST_CM)
            own = [
                LazyMesh(partial(columns, placed, mesh, number), len(mesh.tip), mesh.triangles)
                for mesh in levels[small:]
            ]
            shapes[k] = own[:small] + own
    return shapes


def spheres(reef: Reef) -> Array:
    """The bounding spheres (k, 4) of all growths."""
    return bounding_spheres(_baked(reef, PlacedGrowths.places))


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

    def places(self, mesh: CoralMesh, k: int) -> Array:
        """Places (n, 3) of the vertices of growth k, cm."""
        return np.asarray(mesh.place @ self.axes[k] + self.place[k])

    def vertices(self, mesh: CoralMesh, k: int) -> Array:
        """Vertices (n, COLUMNS) of growth k in world coordinates and its own colours."""
        tip, size, look = mesh.tip, self.radius[k], self.look
        normal = mesh.normal @ self.slants[k]
        normal *= (127.5 / np.sqrt(np.einsum("ni,ni->n", normal, normal)))[:, None]
        body, tips = self.body[k], self.tips[k]
        out = np.empty((len(tip), COLUMNS), np.float32)
        out[:, :3] = self.places(mesh, k)
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
