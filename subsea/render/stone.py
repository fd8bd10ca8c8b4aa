"""Shapes of what stands on the seabed: pillars and rocks as weathered stone, and their shadows.

A shape never leaves the cylinder or ellipsoid that the fishes keep clear of, and lies at most
RELIEF of its size inside.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.habitat.solids import clearances

Array = NDArray[np.floating[Any]]
Ints = NDArray[np.integer[Any]]
Floor = Callable[[Array, Array], Array]  # x and y in cm -> height of the seabed in cm
Carve = Callable[[Array], Array]  # places (n, 3) -> share (n,) of the relief that is gone there

RELIEF = 0.06  # of the radius, or of a rock's half axes: depth of the deepest hollow
BURIED_CM = 25.0  # a shape goes on so far below the sand
CELLS = 32  # on half the girth of the finest shape, at most, and ...
FINEST_CM = 6.5  # ... no cell is smaller
FACES = 45  # broken off a rock
PROBE_CM = 1.5  # over which a slope is taken
STRESS = 2.0  # hollows are lit as if they were so many times as deep

# Columns of a vertex: place, normal, then how it is lit and what grows there.
COLUMNS = 11
SHELTER, TURF, CORALLINE, SPONGE, ABOVE = range(6, 11)

RINGS, SECTORS = 11, 28  # of the mesh of a shadow
SUN = np.array([0.28, 0.17, 0.945])  # as `optics.glsl`
SHADE, CROWD = 0.78, 0.75  # light missing in the sun's shadow, and close to a solid
NOTHING = np.zeros((0, 7))


class Shape(NamedTuple):
    """Vertices and triangles, counter-clockwise from outside."""

    vertices: Array  # (n, COLUMNS) float32, of a shadow (n, 4)
    triangles: Ints  # (m, 3) int32


def pillar_shape(pillar: Array, floor: Floor, level: int = 0) -> Shape:
    """A row of `Sea.pillars` as a column of strata with a worn top."""
    x, y, radius, top = (float(value) for value in pillar)
    cell = max(np.pi * radius / CELLS, FINEST_CM) * 2**level
    columns = max(round(2 * np.pi * radius / cell), 8)
    turn = np.linspace(0.0, 2 * np.pi, columns + 1)
    ground = floor(x + radius * np.cos(turn), y + radius * np.sin(turn))
    foot = min(float(ground.min()), top) - BURIED_CM
    reach, height = _profile(radius, foot, top, cell)
    way = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    base = reach[:, None, None] * way + height[:, None, None] * up
    run, rise = np.gradient(reach), np.gradient(height)
    outward = rise[:, None, None] * way - run[:, None, None] * up
    base = base.reshape(-1, 3) + (x, y, 0.0)
    outward = _unit(outward.reshape(-1, 3))
    deep = np.full(len(base), RELIEF * radius)
    # All of a top's middle is one point.
    vertices = _weathered(base, outward, -deep[:, None] * outward, _strata(radius, pillar), floor)
    return Shape(vertices, _grid(len(reach), columns + 1))


def rock_shape(rock: Array, floor: Floor, level: int = 0) -> Shape:
    """A row of `Sea.rocks` as a boulder with broken faces."""
    half = np.asarray(rock[3:6], np.float64)
    cells = max(int(min(1.57 * half.max() / FINEST_CM, CELLS / 2)) // 2**level, 4)
    points, triangles = _cube_sphere(cells)
    c, s = np.cos(rock[6]), np.sin(rock[6])
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    outward = _unit(points / half @ turn.T)
    stem = half * points @ turn.T
    vertices = _weathered(
        stem + rock[:3], outward, -RELIEF * stem, _broken(rock, half, turn), floor
    )
    # What lies deep in the sand is never seen.
    shown = vertices[:, ABOVE] > -BURIED_CM
    return Shape(vertices, triangles[shown[triangles].any(axis=1)])


def shadow(pillars: Array, rocks: Array, floor: Floor) -> Shape:
    """The sand about one solid, as its place and the share of light that is missing there.

    One of `pillars` (k, 4) and `rocks` (k, 7) has one row, the other none.
    """
    if len(pillars):
        x0, y0, reach, top = pillars[0]
    else:
        x0, y0, reach = rocks[0, 0], rocks[0, 1], rocks[0, 3:5].max()
        top = rocks[0, 2] + rocks[0, 5]
    height = float(np.clip(top - floor(x0, y0), 0.0, 400.0))
    wide = reach + 30.0 + 0.3 * height
    # From its middle: the shadow lies aside, so a hole would show beside the foot.
    radius, turn = wide * np.linspace(0.0, 1.0, RINGS), np.linspace(0.0, 2 * np.pi, SECTORS + 1)
    x = x0 + radius[:, None] * np.cos(turn) - 0.15 * height * SUN[0] / SUN[2]
    y = y0 + radius[:, None] * np.sin(turn) - 0.15 * height * SUN[1] / SUN[2]
    places = np.stack([x, y, floor(x, y)], axis=2).reshape(-1, 3)

    def gap(at: Array) -> Array:
        return clearances(pillars, rocks, at)

    # How widely the sun's rays miss the solid on their way decides how soft its shadow is.
    lit = np.ones(len(places))
    for along in np.linspace(4.0, 1.2 * height + 20.0, 28):
        lit = np.minimum(lit, np.clip(0.5 + gap(places + along * SUN) / (0.3 * along + 6.0), 0, 1))
    crowd = np.exp(-np.maximum(gap(places), 0.0) / (0.2 * reach + 5.0))
    dark = 1.0 - (1.0 - SHADE * (1.0 - lit)) * (1.0 - CROWD * crowd)
    rim = np.clip((1.0 - np.repeat(radius / wide, SECTORS + 1)) / 0.3, 0.0, 1.0)
    vertices = np.column_stack([places, dark * rim]).astype("f4")
    return Shape(vertices, _grid(RINGS, SECTORS + 1)[:, ::-1])


def _profile(radius: float, foot: float, top: float, cell: float) -> tuple[Array, Array]:
    """Distance from the axis and height of the rows of a pillar, from its foot to its middle.

    The shoulder is an ellipse: it lies inside the cylinder's edge, but not far.
    """
    drop = min(0.3 * radius, 0.5 * (top - foot))
    wide = min(0.35 * radius, 2.0 * drop)
    side = np.linspace(foot, top - drop, max(round((top - drop - foot) / cell), 2) + 1)
    bend = np.linspace(0.0, np.pi / 2, max(round(1.5 * wide / cell), 3) + 1)[1:]
    # A superellipse hugs the edge more closely than an ellipse.
    out = radius - wide + wide * np.cos(bend) ** 0.7
    up = top - drop + drop * np.sin(bend) ** 0.7
    inner = np.linspace(radius - wide, 0.0, max(round((radius - wide) / cell), 2) + 1)[1:]
    reach = np.concatenate([np.full(len(side), radius), out, inner])
    return reach, np.concatenate([side, up, np.full(len(inner), top)])


def _strata(radius: float, pillar: Array) -> Carve:
    """Ledges that lie nearly level, worn by the water, and lumps that grew on them."""
    warp, lumps = _fractal(pillar, 2.2 * radius, 2), _fractal(pillar, 0.9 * radius, 4)

    def carve(places: Array) -> Array:
        layer = places[:, 2] / (0.55 * radius + 6.0) + 0.8 * warp(places)
        ledge = np.abs(2.0 * (layer - np.floor(layer)) - 1.0) ** 3
        return np.clip(0.38 + 0.34 * lumps(places) + 0.38 * ledge, 0.0, 1.0)

    return carve


def _broken(rock: Array, half: Array, turn: Array) -> Carve:
    """Faces that broke off, and a rough grain."""
    rng = np.random.default_rng([_key(rock), 0xFA])
    faces = _unit(rng.normal(size=(FACES, 3)))
    where = rng.uniform(0.943, 0.962, FACES)
    grain = _fractal(rock, 0.7 * float(half.min()), 4)

    def carve(places: Array) -> Array:
        unit = (places - rock[:3]) @ turn / half
        along = np.maximum(unit @ faces.T / np.linalg.norm(unit, axis=1)[:, None], 1e-6)
        broken = np.maximum(1.0 - where / along, 0.0).max(axis=1)
        return np.clip(0.1 + 0.85 * broken / RELIEF + 0.18 * grain(places), 0.0, 1.0)

    return carve


def _weathered(base: Array, outward: Array, inward: Array, carve: Carve, floor: Floor) -> Array:
    """Vertices (n, COLUMNS) of a surface whose hollows reach `inward` (n, 3) at their deepest."""
    gone = carve(base)
    place = base + gone[:, None] * inward
    deep = -(inward * outward).sum(axis=1)
    slope = np.stack(
        [(carve(base + PROBE_CM * axis) - gone) / PROBE_CM for axis in np.eye(3)], axis=1
    )
    slope *= -STRESS * deep[:, None]  # of the height over the base
    slope -= (slope * outward).sum(axis=1)[:, None] * outward
    normal = _unit(outward - slope)
    out = np.zeros((len(base), COLUMNS), np.float32)
    out[:, 0:3], out[:, 3:6] = place, normal
    out[:, SHELTER] = gone
    # What grows is the same for all stone of a sea: patches run on from one to the next.
    bent = place + 25.0 * np.stack([_fractal(np.array([k]), 80.0, 2)(place) for k in (4, 5, 6)], 1)
    for column, seed, patch_cm in ((TURF, 1, 170.0), (CORALLINE, 2, 120.0), (SPONGE, 3, 55.0)):
        out[:, column] = _fractal(np.array([seed]), patch_cm, 4)(bent)
    out[:, ABOVE] = place[:, 2] - floor(place[:, 0], place[:, 1])
    return out


def _fractal(key: Array, longest_cm: float, octaves: int) -> Carve:
    """Smooth noise about 0, seldom beyond ±1, from the longest wave down by halves."""
    rng = np.random.default_rng([_key(key), 0xF2, octaves])
    number = 7
    size = 2.0 ** -np.repeat(np.arange(octaves), number)
    wave = _unit(rng.normal(size=(octaves * number, 3)))
    wave *= (2 * np.pi / longest_cm / size * rng.uniform(0.7, 1.4, len(size)))[:, None]
    phase = rng.uniform(0, 2 * np.pi, len(size))
    share = size / np.sqrt((size**2).sum() / 2)

    def noise(places: Array) -> Array:
        return np.asarray(0.55 * np.sin(places @ wave.T + phase) @ share)

    return noise


def _key(solid: Array) -> int:
    """A number that a solid's row decides."""
    return int(np.abs(np.round(100 * np.asarray(solid, np.float64)) @ np.arange(1, len(solid) + 1)))


def _unit(rows: Array) -> Array:
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)


def _grid(rows: int, columns: int) -> Ints:
    """Two triangles (n, 3) per cell of a grid; counter-clockwise where rows go up from outside."""
    k, j = (a.ravel() for a in np.meshgrid(range(rows - 1), range(columns - 1), indexing="ij"))
    a = k * columns + j
    b, c, d = a + 1, a + columns, a + columns + 1
    return np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype("i4")


def _cube_sphere(cells: int) -> tuple[Array, Ints]:
    """A sphere of even cells: points (n, 3) and triangles, from the six faces of a cube."""
    across = np.tan(np.linspace(-np.pi / 4, np.pi / 4, cells + 1))
    u, v = (a.ravel() for a in np.meshgrid(across, across))
    face = np.stack([u, v, np.ones_like(u)], axis=1)
    points: list[Array] = []
    triangles: list[Ints] = []
    for axis in range(3):
        for side in (1.0, -1.0):
            turned = np.roll(face * (1.0, side, side), axis + 1, axis=1)
            triangles.append(_grid(cells + 1, cells + 1) + len(points) * len(face))
            points.append(turned)
    return _unit(np.concatenate(points)), np.concatenate(triangles)
