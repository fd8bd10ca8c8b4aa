"""The mesh of a projector from what cameras saw of its structured light.

A projector that draws straight lines is a lens; what it shows otherwise, and what the screen lacks
to its ideal shape, is a smooth field of small errors over its pixels. Where no camera saw a part of
the picture, the lens alone goes on and the field fades.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.stage.calibration.optics import PhotoCamera, ProjectorLens, SeenLight, fit_projector
from subsea.stage.calibration.surface import LitSurface, within
from subsea.stage.theatre.channels import ProjectorChannel
from subsea.view.rig import sources_at

CELLS = 48  # of the longer side, over which errors are averaged
SMOOTH = 1.0  # standard deviation of the average, cells
FEWEST = 60  # blocks of a projector that was seen
WORST = 5.0  # median errors beyond which a block is an outlier
NODE_PX = 24  # between nodes of a mesh
STEEPEST_BEND = 0.08


class MeasuredProjector(NamedTuple):
    """The places of the screen that a projector lights."""

    surface: LitSurface  # of its channel
    size: tuple[int, int]
    nodes: Array  # (rows, columns, 2) places of the screen, upper row first; NaN: none
    known: Bools  # (rows, columns) True for nodes that a camera saw
    shown: Array  # (n, 2) pixels of the projector that were seen
    error_px: Array  # (n, 2) of them against the mesh, in pixels of the projector

    @property
    def seen(self) -> bool:
        """True if a camera saw the projector."""
        return len(self.shown) > 0

    @property
    def corners(self) -> tuple[Array, Array]:
        """x (columns,) and y (rows,) of the nodes in pixels from the upper left corner."""
        rows, columns = self.known.shape
        return np.linspace(0.0, self.size[0], columns), np.linspace(0.0, self.size[1], rows)

    @property
    def rms_px(self) -> float:
        """The rms distance of what was seen from the mesh, in pixels of the projector."""
        return float(np.sqrt(np.mean((self.error_px**2).sum(axis=1))))


def measure_projector(
    surface: LitSurface, size: tuple[int, int], seen: Sequence[tuple[SeenLight, PhotoCamera]]
) -> MeasuredProjector | None:
    """The mesh of a projector of `size` pixels from what cameras saw; None: next to nothing."""
    if not seen:
        return None
    points = np.concatenate([surface.meet(camera.place, camera.rays(one.pixels))
                             for one, camera in seen])  # fmt: skip
    shown = np.concatenate([one.shown for one, _ in seen])
    places = surface.places(points)
    kept = np.isfinite(places).all(axis=1)
    if kept.sum() < FEWEST:
        return None
    points, shown, places = points[kept], shown[kept], places[kept]
    lens, error = best_lens(surface, points, shown, size)
    away = np.linalg.norm(error, axis=1)
    kept = away <= WORST * max(float(np.median(away)), 0.2)
    points, shown, places = points[kept], shown[kept], places[kept]
    lens, error = best_lens(surface, points, shown, size)
    x, y = _node_grid(size)
    rows, columns = x.shape
    nodes = np.column_stack([x.ravel(), y.ravel()])
    field = SmoothField(shown, error, size)
    # A place of error e is where the lens alone would show the pixel + e.
    target = lens.straight(nodes) + field.at(nodes)
    found = _places_of(lens, surface, target, _first_places(nodes, shown, places))
    known = field.known(nodes).reshape(rows, columns)
    return MeasuredProjector(
        surface, size, found.reshape(rows, columns, 2), known, shown, error - field.at(shown)
    )


def planned_projector(surface: LitSurface, channel: ProjectorChannel) -> MeasuredProjector:
    """The projector of a channel as its theatre file has it, for one that no camera saw."""
    size = channel.place[2], channel.place[3]
    x, y = _node_grid(size)
    rows, columns = x.shape
    nodes: Array = np.column_stack([x.ravel() / size[0], 1.0 - y.ravel() / size[1]])
    if channel.warp is not None:
        nodes = sources_at(channel.warp, nodes.clip(1e-6, 1.0 - 1e-6))
    none = np.zeros((0, 2))
    known = np.zeros((rows, columns), bool)
    return MeasuredProjector(surface, size, nodes.reshape(rows, columns, 2), known, none, none)


def away_from_plan(measured: MeasuredProjector, channel: ProjectorChannel) -> float:
    """Measure how far its light lies from where the theatre file has it, in its diagonals."""
    surface = measured.surface
    planned = surface.points(planned_projector(surface, channel).nodes.reshape(-1, 2))
    found = surface.points(measured.nodes.reshape(-1, 2))
    diagonal = np.linalg.norm(np.nanmax(planned, axis=0) - np.nanmin(planned, axis=0))
    return float(np.nanmedian(np.linalg.norm(found - planned, axis=1)) / diagonal)


def _node_grid(size: tuple[int, int]) -> tuple[Array, Array]:
    """x and y (rows, columns) of the nodes of a mesh, in pixels from the upper left corner."""
    columns, rows = (max(round(side / NODE_PX), 4) + 1 for side in size)
    x, y = np.meshgrid(np.linspace(0.0, size[0], columns), np.linspace(0.0, size[1], rows))
    return x, y


def best_lens(
    surface: LitSurface, points: Array, shown: Array, size: tuple[int, int]
) -> tuple[ProjectorLens, Array]:
    """The lens that fits best, with its errors (n, 2) in pixels of the projector."""
    from scipy.optimize import minimize_scalar

    few = np.linspace(0, len(points) - 1, min(1500, len(points))).astype(int)

    def cost(bend: float) -> float:
        error = fit_projector(surface, points[few], shown[few], size, bend)[1]
        return float(np.mean(np.minimum((error**2).sum(axis=1), 25.0)))

    bend = minimize_scalar(
        cost, bounds=(-STEEPEST_BEND, STEEPEST_BEND), method="bounded", options={"xatol": 1e-4}
    ).x
    return fit_projector(surface, points, shown, size, float(bend))


class SmoothField:
    """A field over the picture of a projector, averaged over neighbouring blocks."""

    def __init__(self, shown: Array, values: Array, size: tuple[int, int]) -> None:
        """Average `values` (n, k) at pixels `shown` (n, 2)."""
        from scipy.ndimage import gaussian_filter

        self._cell = max(size) / CELLS
        columns, rows = (int(np.ceil(side / self._cell)) for side in size)
        cell = np.clip((shown / self._cell).astype(int), 0, [columns - 1, rows - 1])
        number = cell[:, 1] * columns + cell[:, 0]
        count = np.bincount(number, minlength=rows * columns).astype(float)
        self._filled = count.reshape(rows, columns) > 0
        # Each cell counts alike, however many blocks it has.
        weight = gaussian_filter(self._filled.astype(float), SMOOTH, mode="constant")
        self._fields = []
        for column in values.T:
            mean = np.bincount(number, column, minlength=rows * columns) / np.maximum(count, 1.0)
            total = gaussian_filter(mean.reshape(rows, columns), SMOOTH, mode="constant")
            self._fields.append(total / np.maximum(weight, 0.05))

    def at(self, shown: Array) -> Array:
        """The field (n, k) at pixels (n, 2)."""
        return np.stack([sampled(field, shown / self._cell) for field in self._fields], axis=1)

    def known(self, shown: Array) -> Bools:
        """True (n,) at pixels (n, 2) in or beside a cell with blocks."""
        from scipy.ndimage import binary_dilation

        near = binary_dilation(self._filled)
        rows, columns = near.shape
        x, y = np.clip((shown / self._cell).astype(int), 0, [columns - 1, rows - 1]).T
        return np.asarray(near[y, x])


def sampled(grid: Array, at: Array) -> Array:
    """Values (n,) of a grid (h, w) at points (n, 2) in cells from its upper left corner."""
    from scipy.ndimage import map_coordinates

    rows = [at[:, 1] - 0.5, at[:, 0] - 0.5]
    return np.asarray(map_coordinates(grid, rows, order=1, mode="nearest"))


def _first_places(nodes: Array, shown: Array, places: Array) -> Array:
    """About the places (n, 2) of nodes: a polynomial of the second degree."""
    middle, scale = shown.mean(axis=0), shown.std(axis=0).max()

    def terms(pixels: Array) -> Array:
        x, y = ((pixels - middle) / scale).T
        return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)

    known, *_ = np.linalg.lstsq(terms(shown), places, rcond=None)
    return np.asarray(terms(nodes) @ known)


def _places_of(lens: ProjectorLens, surface: LitSurface, target: Array, start: Array) -> Array:
    """The places (n, 2) that a lens lights with its straight pixels `target` (n, 2).

    Newton's method from `start`; NaN where it does not arrive.
    """
    places, step = start.copy(), 1e-5
    with np.errstate(all="ignore"):
        for _ in range(12):
            here = lens.pixels(surface, places)
            across, up = (
                (lens.pixels(surface, places + offset) - here) / step
                for offset in ([step, 0.0], [0.0, step])
            )
            error = target - here
            area = across[:, 0] * up[:, 1] - across[:, 1] * up[:, 0]
            ds = (error[:, 0] * up[:, 1] - error[:, 1] * up[:, 0]) / area
            dt = (across[:, 0] * error[:, 1] - across[:, 1] * error[:, 0]) / area
            places += np.clip(np.stack([ds, dt], axis=1), -0.25, 0.25)
        off = np.linalg.norm(lens.pixels(surface, places) - target, axis=1)
        places[~(off < 0.05) | ~within(places, 3.0)] = np.nan
    return places
