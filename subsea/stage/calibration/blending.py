"""Blends of projectors whose places on the screen were measured.

Where several projectors light a point of the screen, its light is shared by how far inside each
picture the point lies: by the square of the distance, in pixels of that projector, from those of
its edges that lie within other pictures. The shares of a point add up to one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.stage.calibration.meshes import MeasuredProjector, sampled
from subsea.stage.calibration.surface import LitSurface, within
from subsea.stage.theatre.warp import mesh, rasterized
from subsea.view.meshes import grid_triangles
from subsea.view.rig import Warp

COARSEST, FINE = 4, 240  # pixels of a projector a side for one of its mask; least length of a mask
LEAST = 1e-6  # weight at the very edge of a picture


class InverseMesh(NamedTuple):
    """A map from places of the screen to the picture of a projector."""

    corner: Array  # (2,) place of the lower left corner
    size: Array  # (2,)
    shares: Array  # (h, w, 2) of the picture, from its upper left corner; NaN: nowhere


@dataclass(frozen=True)
class Footprint:
    """The part of the screen that a projector lights, over the pixels of its mask."""

    measured: MeasuredProjector
    points: Array  # (h, w, 3) of the room; NaN: none
    lit: Bools  # (h, w) True on the screen
    weight: Array  # (h, w) of its share
    inverse: InverseMesh
    places: Array  # (h, w, 2) of its channel's screen

    @property
    def seen_share(self) -> float:
        """The share of what it lights that cameras saw."""
        known, lit = self.measured.known, self.lit
        rows, columns = ((np.arange(n) + 0.5) / n for n in lit.shape)
        row = np.round(rows * (known.shape[0] - 1)).astype(int)
        column = np.round(columns * (known.shape[1] - 1)).astype(int)
        return float(known[row][:, column][lit].mean()) if lit.any() else 0.0

    @property
    def part(self) -> tuple[float, float, float, float]:
        """x, y, width, height of the part of the screen that it lights, in shares of it."""
        low, high = self.places[self.lit].min(axis=0), self.places[self.lit].max(axis=0)
        margin = 0.01 * (high - low)
        (x, y), (width, height) = low - margin, high - low + 2.0 * margin
        return float(x), float(y), float(width), float(height)


def mask_size(size: tuple[int, int]) -> tuple[int, int]:
    """The pixels of the mask of a projector of `size` pixels."""
    coarser = min(max(max(size) // FINE, 1), COARSEST)
    return max(size[0] // coarser, 1), max(size[1] // coarser, 1)


def mesh_of(measured: MeasuredProjector, part: tuple[float, float, float, float]) -> Warp:
    """The warp of a projector whose channel shows this part of its screen."""
    x, y = np.meshgrid(*measured.corners)
    shares = np.column_stack([x.ravel() / measured.size[0], 1.0 - y.ravel() / measured.size[1]])
    sources = (measured.nodes.reshape(-1, 2) - part[:2]) / part[2:]
    rows, columns = measured.known.shape
    triangles = grid_triangles(columns, rows)
    kept = np.isfinite(sources).all(axis=1)[triangles].all(axis=1)
    return mesh(shares, np.nan_to_num(sources, nan=-1.0), triangles[kept])


def footprints(
    measured: Sequence[MeasuredProjector], screens: Sequence[LitSurface], groups: Sequence[object]
) -> list[Footprint]:
    """Find the part of the `screens` that each projector lights, and its share of the light.

    Projectors of different `groups`, such as those for one eye, do not blend.
    """
    from scipy.ndimage import binary_erosion, distance_transform_edt

    places = [_mask_places(one) for one in measured]
    points, lit = [], []
    for one, where in zip(measured, places, strict=True):
        flat = where.reshape(-1, 2)
        at = one.surface.points(flat)
        on = np.zeros(len(flat), bool)
        for screen in screens:
            if screen.same(one.surface):
                on |= within(screen.places(at), 1e-6)
        points.append(at.reshape(*where.shape[:2], 3))
        lit.append(on.reshape(where.shape[:2]))
    inner = [_inverse(one) for one in measured]
    prints: list[Footprint] = []
    for k, one in enumerate(measured):
        edge = lit[k] & ~binary_erosion(lit[k])
        blended = np.zeros_like(edge)
        for j, other in enumerate(measured):
            if j != k and groups[j] == groups[k] and other.surface.same(one.surface):
                there = _shares_there(inner[j], other.surface, points[k][edge])
                blended[edge] |= _lit_at(lit[j], there)
        away = np.full(edge.shape, 1e3)
        if blended.any():
            away = distance_transform_edt(~blended)
        weight = np.where(lit[k], np.maximum((away / min(away.shape)) ** 2, LEAST), 0.0)
        prints.append(Footprint(one, points[k], lit[k], weight, inner[k], places[k]))
    return prints


def light_share(prints: Sequence[Footprint], number: int, groups: Sequence[object]) -> Array:
    """The share (h, w) of the light that a projector gives at each pixel of its mask."""
    one = prints[number]
    own = one.weight[one.lit]
    total = own.copy()
    for k, other in enumerate(prints):
        if k != number and _together(prints, groups, k, number):
            there = _shares_there(other.inverse, other.measured.surface, one.points[one.lit])
            total += np.where(_lit_at(other.lit, there), _sample(other.weight, there), 0.0)
    share = np.zeros(one.lit.shape)
    share[one.lit] = own / total
    return share


def overlap_blacks(
    prints: Sequence[Footprint], blacks: Sequence[float], groups: Sequence[object]
) -> list[Array]:
    """The light (h, w) that each projector adds so that black is alike on the whole screen.

    `blacks` are the black levels of the projectors, as shares of their white. Where fewer of them
    shine than elsewhere, they share what is missing as they share the light.
    """
    here = []
    for number, one in enumerate(prints):
        black = np.where(one.lit, blacks[number], 0.0)
        for k, other in enumerate(prints):
            if k != number and _together(prints, groups, k, number):
                there = _shares_there(other.inverse, other.measured.surface, one.points[one.lit])
                black[one.lit] += np.where(_lit_at(other.lit, there), blacks[k], 0.0)
        here.append(black)
    most = max(float(black.max()) for black in here)
    shares = [light_share(prints, number, groups) for number in range(len(prints))]
    return [(most - black) * share for black, share in zip(here, shares, strict=True)]


def _together(prints: Sequence[Footprint], groups: Sequence[object], k: int, number: int) -> bool:
    same = prints[k].measured.surface.same(prints[number].measured.surface)
    return same and groups[k] == groups[number]


def _mask_places(measured: MeasuredProjector) -> Array:
    """The places (h, w, 2) of the screen at the pixels of a projector's mask."""
    width, height = mask_size(measured.size)
    rows, columns = measured.known.shape
    x, y = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    at = np.column_stack([x.ravel() * (columns - 1), y.ravel() * (rows - 1)]) + 0.5
    found = [sampled(measured.nodes[..., k], at) for k in (0, 1)]  # NaN beside a node without
    return np.stack(found, axis=1).reshape(height, width, 2)


def _inverse(measured: MeasuredProjector) -> InverseMesh:
    flat = measured.nodes.reshape(-1, 2)
    known: Bools = np.asarray(np.isfinite(flat).all(axis=1))
    low, high = flat[known].min(axis=0), flat[known].max(axis=0)
    x, y = np.meshgrid(*measured.corners)
    shares = np.column_stack([x.ravel() / measured.size[0], y.ravel() / measured.size[1]])
    rows, columns = measured.known.shape
    triangles = grid_triangles(columns, rows)
    triangles = triangles[known[triangles].all(axis=1)]
    warp = mesh((np.nan_to_num(flat) - low) / (high - low), shares, triangles)
    size = mask_size(measured.size)
    grids = [rasterized(warp, column, size) for column in (*shares.T, np.ones(len(shares)))]
    found = np.where(grids[2][..., None] > 0, np.stack(grids[:2], axis=-1), np.nan)
    return InverseMesh(low, high - low, found)


def _shares_there(inverse: InverseMesh, surface: LitSurface, points: Array) -> Array:
    """Shares (n, 2) of a picture, from its upper left corner, at points (n, 3); NaN: elsewhere."""
    at = (surface.places(points) - inverse.corner) / inverse.size
    rows, columns, _ = inverse.shares.shape
    inside = within(at)
    cells = np.where(inside[:, None], np.column_stack([at[:, 0], 1.0 - at[:, 1]]), 0.0)
    cells *= [columns, rows]
    found = np.stack([sampled(inverse.shares[..., k], cells) for k in (0, 1)], axis=1)
    found[~inside] = np.nan
    return found


def _lit_at(lit: Bools, there: Array) -> Bools:
    """True (n,) where shares (n, 2) of a picture lie on a lit pixel of its mask."""
    rows, columns = lit.shape
    inside = within(there)
    x, y = np.nan_to_num(there).T
    column = np.clip((x * columns).astype(int), 0, columns - 1)
    row = np.clip((y * rows).astype(int), 0, rows - 1)
    return np.asarray(inside & lit[row, column])


def _sample(grid: Array, there: Array) -> Array:
    rows, columns = grid.shape
    return sampled(grid, np.nan_to_num(there) * [columns, rows])
