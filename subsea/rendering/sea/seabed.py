"""The seabed: the height field in square tiles at three levels of detail, with sand textures."""

from functools import partial
from typing import Any

import numpy as np

from subsea.base.arrays import Array, Bytes, Ints
from subsea.frame.packet import RenderScene
from subsea.habitat.formations import formations
from subsea.habitat.reef import KINDS, MOUND
from subsea.habitat.stone import sun_at, suns_of_day
from subsea.rendering.gl.id_buffer import SEABED
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.static_batch import StaticBatch, StaticMesh
from subsea.rendering.gl.textures import (
    Texels,
    in_bytes,
    nearest_of_cells,
    repeating,
    tileable_noise,
    upload,
)
from subsea.rendering.output.quality import Quality
from subsea.rendering.sea import ground_map
from subsea.state import Reef
from subsea.view.culling import IN_SIGHT

SIZE, FINE_SIZE = 384, 512
RIPPLES = 12  # mean number of ripples across a texture
CHIP_CELLS = 26  # chips of litter across a texture
SHELLS = 0.3  # share of chips that are whole shells
RIBS = 11  # of a shell, on half a turn about its hinge
TRAILS, STEPS = 11, 210  # on a texture of tracks; steps of two texels that each is long
WIDE = 3.2  # half width of a trail, texels

# Ranges of the bytes of the textures.
SPAN = np.array([3.0, 3.0, 3.0, 4.0])
TRACK_SPAN = np.array([9.0, 9.0, 2.0, 1.0])
LITTER_LOW, LITTER_HIGH = np.array([-3.5, -3.5, 0.0, 0.0]), np.array([3.5, 3.5, 1.0, 1.0])


def ripples(seed: int, size: int = SIZE) -> list[Array]:
    """Ripple marks with crests along y: slopes along x and y, height, grain; deviation 1.

    Band-limited noise wanders, forks and ends as ripples do; its phase is skewed, so that one side
    is steep, as from a current along x.
    """
    rng = np.random.default_rng([seed, 0x21])
    k = np.fft.fftfreq(size) * size
    along, across = k[None, :], k[:, None]
    # Both signs: one alone would be no wave but a phase.
    spectrum = np.exp(-(((along - RIPPLES) / 2.0) ** 2) - (across / 3.3) ** 2).astype(complex)
    spectrum *= np.exp(2j * np.pi * rng.uniform(size=(size, size)))
    wave = np.fft.ifft2(spectrum)
    strength, phase = np.abs(wave), np.angle(wave)
    strength = np.clip(strength / np.median(strength), 0.25, 1.3)
    skewed = phase + 0.55 * np.cos(phase)
    height = strength * (np.sin(skewed) + 0.22 * np.sin(2 * skewed - 0.6))
    height += 0.10 * tileable_noise(seed + 1, size, 1.6)
    grain = tileable_noise(seed + 2, size, 0.45)
    return [*_slopes(height), _even(height), grain]


def litter(seed: int) -> list[Array]:
    """Chips of shell and coral: slopes along x and y, tone, and frequency (0 between chips)."""
    x, y, which = nearest_of_cells(seed, FINE_SIZE, CHIP_CELLS)
    rng = np.random.default_rng([seed, 0x11])
    tone, common, turn, long, wide = rng.uniform(size=(5, CHIP_CELLS * CHIP_CELLS))[:, which]
    # Chips at random angles, some long, with irregular outlines.
    rough = [0.09 * tileable_noise(seed + k, FINE_SIZE, 1.5) for k in (1, 2)]
    c, s = np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)
    u = (c * x + s * y + rough[0]) * (1.0 + 1.4 * long)
    v = c * y - s * x + rough[1]
    away = np.maximum(np.hypot(u, v), 0.8 * (np.abs(u) + np.abs(v)))
    size = 0.16 + 0.32 * wide**1.5
    inside = np.clip((size - away) / 0.05, 0.0, 1.0)
    bulge = inside * (1.0 + 1.2 * (tone - 0.5) * (u + v))
    # Shells are fans with ribs about a hinge.
    shell = np.modf(17.0 * common)[0] < SHELLS
    u, v = c * x + s * y + 0.6 * size, c * y - s * x
    far, turn = np.hypot(u, v), np.arctan2(v, u)
    fan = np.clip((1.25 * size * np.cos(0.75 * turn) - far) / 0.04, 0.0, 1.0)
    fan *= np.abs(turn) < 1.4
    ribbed = fan * (1.15 - 0.6 * far / size) * (1.0 + 0.16 * np.cos(2 * RIBS * turn))
    inside, bulge = np.where(shell, fan, inside), np.where(shell, ribbed, bulge)
    tone = np.where(shell, 0.6 + 0.4 * tone, tone)
    return [*_slopes(bulge), tone, common * inside]


def tracks(seed: int) -> list[Array]:
    """Trails of snails, worms and crabs: slopes along x and y, deviation 1, height, and 0.

    Snails plough a furrow between two walls, worms leave a ridge, crabs two rows of holes.
    """
    rng = np.random.default_rng([seed, 0x7A])
    height = np.zeros((FINE_SIZE, FINE_SIZE))
    reach = int(4 * WIDE)
    box = np.arange(-reach, reach + 1)
    for trail in range(TRAILS):
        along, start, *bends = np.arange(STEPS), *rng.uniform(0.0, 2 * np.pi, 4)
        turn = start + 0.9 * np.sin(along / 31.0 + bends[0]) + 0.5 * np.sin(along / 13.0 + bends[1])
        turn += 0.012 * (bends[2] - np.pi) * along
        way = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        path = rng.uniform(0.0, FINE_SIZE, 2) + np.cumsum(2.0 * way, axis=0)
        distance = np.full_like(height, np.inf)
        crab, wide = trail % 3 == 2, WIDE * rng.uniform(0.6, 1.1)
        if crab:
            left = np.where(along // 2 % 2 == 0, 1.0, -1.0)[:, None]
            path = (path + left * 1.5 * wide * way[:, ::-1] * (-1.0, 1.0))[::2]
        for column, row in path:
            i, j = int(row), int(column)
            away = np.hypot((i + box - row)[:, None], (j + box - column)[None, :])
            at = np.ix_((i + box) % FINE_SIZE, (j + box) % FINE_SIZE)
            distance[at] = np.minimum(distance[at], away)
        d = distance / wide
        wall = 0.6 * np.exp(-(((d - 1.5) / 0.5) ** 2))
        profile = np.exp(-(d**2)) if trail % 3 == 1 else wall - np.exp(-(d**2))
        if crab:
            profile = 0.5 * wall - 0.9 * np.exp(-((d / 0.7) ** 2))
        height += np.where(np.abs(profile) > np.abs(height), profile - height, 0.0)
    return [*_slopes(height), height, np.zeros_like(height)]


def rippled(seed: int) -> Texels:
    """Ripple marks as a texture."""
    return in_bytes(ripples(seed), -SPAN, SPAN)


def tracked(seed: int) -> Texels:
    """Tracks as a texture."""
    return in_bytes(tracks(seed), -TRACK_SPAN, TRACK_SPAN)


def littered(seed: int) -> Texels:
    """Litter as a texture."""
    return in_bytes(litter(seed), LITTER_LOW, LITTER_HIGH)


def _slopes(height: Array) -> tuple[Array, Array]:
    """Slopes along x and y with a joint deviation of 1."""
    x, y = (np.roll(height, -1, axis) - np.roll(height, 1, axis) for axis in (1, 0))
    size = float(np.sqrt((x**2 + y**2).mean()))
    return x / size, y / size


def _even(values: Array) -> Array:
    return np.asarray((values - values.mean()) / values.std())


CELLS = 12  # of a side of a tile; coarser levels use every second and fourth
LEVELS_PX = (640.0, 210.0)  # diameters of a tile from which its levels are used
APRON_CM = 120.0  # width of cells outside the height field, which continue its edge into the fog
SKIRT_CM = 9.0  # hides gaps between tiles of different levels
ON_SAND_CM = 3.0  # height of the foot of a growth, up to which it stands on the sand
# Radius on which a growth stands, over its own.
FOOT, FEET = 0.7, {"mound": 1.0, "brain": 0.9, "table": 0.35, "fan": 0.2, "rubble": 0.6}


class SeabedRenderer(StaticBatch):
    """Draws the tiles in sight."""

    def __init__(
        self, context: Any, scene: RenderScene, ground: ground_map.GroundMap, quality: Quality
    ) -> None:
        """Cut `scene.terrain` (SMC §6.2) into tiles; `ground` is its `surroundings`."""
        moving = {"MOVING_SUN": 1} if scene.water.day_minutes else {}
        programs = ProgramVariants(context, "seabed", SEABED, quality.defines, **moving)
        items = tiles(*surface(scene.terrain, scene.terrain_half_width_cm))
        reach_cm = IN_SIGHT * scene.water.visibility_cm
        super().__init__(programs, "3f4 2f4", "a_position a_slope", items, reach_cm, LEVELS_PX)
        self.textures = {
            "u_ground": self.own(upload(context, ground.light)),
            "u_ripples": self.own(repeating(context, rippled, 3)),
            "u_litter": self.own(repeating(context, littered, 4)),
            "u_tracks": self.own(repeating(context, tracked, 8)),
        }
        if moving:
            for k, name in enumerate(("u_early_suns", "u_late_suns")):
                self.textures[name] = self.own(upload(context, _quarter(ground.suns, k)))
        self.uniforms = {
            "u_map": (*ground.corner, *ground.size),
            "u_flow": flow_of(scene.water.current_cm_s),
        }
        self._ground, self._sun = ground, sun_at(scene.water.hour)[0]
        self._suns = suns_of_day(bool(moving))
        self._standing, self._own = standing(scene.reef, scene.terrain, scene.terrain_half_width_cm)
        self._growing = -1  # number of growths whose light the map takes

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on: sand is darker about the growths that are drawn."""
        shown = self._standing[self._own <= quality.growth]
        if len(shown) != self._growing:
            light, suns = ground_map.with_growths(self._ground, shown, self._sun, self._suns)
            self.textures["u_ground"].write(light.tobytes())
            for k, name in enumerate(("u_early_suns", "u_late_suns")):
                if name in self.textures:
                    self.textures[name].write(_quarter(suns, k).tobytes())
            self._growing = len(shown)


def _quarter(suns: Bytes, k: int) -> Bytes:
    """The first four of eight suns (rows, columns, 8), or the last."""
    return np.ascontiguousarray(suns[..., 4 * k : 4 * k + 4])


def surroundings(
    terrain: Array,
    half_width_cm: float,
    pillars: Array,
    rocks: Array,
    hour: float,
    reef: Reef,
    moving: bool = False,
) -> ground_map.GroundMap:
    """The ground map of the stones of a `RenderScene` at an hour, with room for its growths.

    With `moving` also for all suns of a day.
    """
    floor = partial(drawn_height, terrain, half_width_cm)
    growths = standing(reef, terrain, half_width_cm)[0]
    stones, suns = formations(pillars, rocks), suns_of_day(moving)
    return ground_map.ground_map(stones, floor, sun_at(hour)[0], growths, suns)


def flow_of(current_cm_s: tuple[float, float]) -> tuple[float, float]:
    """Unit vector along a current, along x if there is none: ripples lie across it."""
    speed = float(np.hypot(*current_cm_s))
    return (current_cm_s[0] / speed, current_cm_s[1] / speed) if speed > 0.0 else (1.0, 0.0)


def standing(reef: Reef, terrain: Array, half_width_cm: float) -> tuple[Array, Array]:
    """Growths (k, 5) on the sand, as `ground_map.with_growths` reads them, and their `own`.

    Mounds have an `own` of 0, as they are always drawn.
    """
    x, y = reef.place[:, 0], reef.place[:, 1]
    gap = reef.place[:, 2] - drawn_height(terrain, half_width_cm, x, y)
    on = ~reef.on_rock & (gap < ON_SAND_CM)
    names = list(KINDS)
    tall = np.array([KINDS[name].height for name in names])[reef.kind] * reef.radius
    foot = np.array([FEET.get(name, FOOT) for name in names])[reef.kind]
    growths = np.stack([x, y, reef.radius, np.maximum(tall * reef.axis[:, 2], 1.0), foot], axis=1)
    own = np.where(reef.kind == MOUND, 0.0, reef.own)
    return growths[on].astype(np.float64), own[on]


def drawn_height(heights: Array, half_width: float, x: Array, y: Array) -> Array:
    """Height of the finest triangles at points x, y of any shape, cm."""
    last = len(heights) - 1
    u = np.clip((x + half_width) / (2 * half_width) * last, 0, last)
    v = np.clip((y + half_width) / (2 * half_width) * last, 0, last)
    j, i = np.minimum(u.astype(int), last - 1), np.minimum(v.astype(int), last - 1)
    u, v = u - j, v - i
    east, north = heights[i, j + 1], heights[i + 1, j]
    near = heights[i, j] + u * (east - heights[i, j]) + v * (north - heights[i, j])
    corner = heights[i + 1, j + 1]
    far = corner + (1 - u) * (north - corner) + (1 - v) * (east - corner)
    return np.asarray(np.where(u + v <= 1.0, near, far))


def terrain_within(
    heights: Array, half_width: float, low: Array, high: Array
) -> tuple[list[int], Array]:
    """The part of `heights` that `drawn_height` reads within a box, and its first row and column.

    `low` and `high` are corners of the box, cm; their third coordinates are not used.
    """
    last = len(heights) - 1
    scale = last / (2 * half_width)
    first = np.clip(np.floor((low[:2] + half_width) * scale), 0, last - 1).astype(int)
    end = np.clip(np.floor((high[:2] + half_width) * scale), 0, last - 1).astype(int) + 2
    return first.tolist(), heights[first[1] : end[1], first[0] : end[0]].copy()


def surface(heights: Array, half_width: float) -> tuple[Array, Array]:
    """Positions (m, m, 3), cm, and slopes (m, m, 2) with an apron; m - 1 divides by CELLS."""
    before = CELLS
    after = CELLS + (1 - len(heights)) % CELLS
    axis = np.concatenate(
        [
            -half_width - APRON_CM * np.arange(before, 0, -1),
            np.linspace(-half_width, half_width, len(heights)),
            half_width + APRON_CM * np.arange(1, after + 1),
        ]
    )
    z = np.pad(heights.astype(np.float64), (before, after), mode="edge")
    x, y = np.meshgrid(axis, axis)
    slope_y, slope_x = np.gradient(z, axis, axis)
    return np.stack([x, y, z], axis=2), np.stack([slope_x, slope_y], axis=2)


def tiles(positions: Array, slopes: Array) -> list[list[StaticMesh]]:
    """The levels of each tile, finest first; vertices (n, 5) are position and slope."""
    vertices = np.concatenate([positions, slopes], axis=2).astype(np.float32)
    meshes = [_mesh(CELLS // step) for step in (1, 2, 4)]
    items = []
    for i in range(0, len(vertices) - 1, CELLS):
        for j in range(0, len(vertices) - 1, CELLS):
            tile = vertices[i : i + CELLS + 1, j : j + CELLS + 1]
            levels = []
            for step, (rim, triangles) in zip((1, 2, 4), meshes, strict=True):
                top = tile[::step, ::step].reshape(-1, 5)
                skirt = top[rim]
                skirt[:, 2] -= SKIRT_CM
                levels.append(StaticMesh(np.concatenate([top, skirt]), triangles))
            items.append(levels)
    return items


def _mesh(cells: int) -> tuple[Ints, Ints]:
    """Rim (r,) of a tile of cells², and triangles (m, 3) of the tile and its skirt."""
    side = cells + 1
    i, j = (k.ravel() for k in np.meshgrid(range(cells), range(cells), indexing="ij"))
    a = i * side + j
    inner = np.stack([a, a + 1, a + side, a + side, a + 1, a + side + 1], axis=1).reshape(-1, 3)
    grid = np.arange(side * side).reshape(side, side)
    rim = np.concatenate([grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]])
    below = side * side + np.arange(len(rim))
    there, deep = np.roll(rim, -1), np.roll(below, -1)
    skirt = np.stack([rim, below, there, there, below, deep], axis=1).reshape(-1, 3)
    return rim, np.concatenate([inner, skirt]).astype(np.int32)
