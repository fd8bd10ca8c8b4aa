"""Marks of line-up over a projector's picture: its grid of points, and the point that is chosen."""

import numpy as np

from subsea.base.arrays import Array
from subsea.stage.theatre.adjusting import PLAIN, moved_places, patch_adjustment
from subsea.stage.theatre.line_up import point_places
from subsea.stage.theatre.theatre_file import Adjustment

AMBER, WHITE, RED = (1.0, 0.6, 0.1), (1.0, 1.0, 1.0), (1.0, 0.15, 0.1)
STEPS = 8  # of a line between two points
FINE = 500.0  # of these lines lie beside each other over the shorter side


def line_up_marks(
    adjustment: Adjustment, size: tuple[int, int], grid: tuple[int, int], point: str
) -> Array:
    """Make triangles (n, 5) of a picture of `size` pixels, as `MarkRenderer.draw` takes them.

    `grid` has the columns and rows of its points; `point` is the name of the chosen one.
    """
    thick = max(min(size) / FINE, 1.0)
    lines = _grid_lines(*grid)
    found = moved_places(adjustment, size, np.concatenate(lines)) * size
    moved_lines = np.split(found, np.cumsum([len(line) for line in lines])[:-1])
    parts = [_bands(line[:-1], line[1:], thick, AMBER) for line in moved_lines]
    if adjustment.edge_mask is not None:
        edge = np.array(adjustment.edge_mask) * [1.0, -1.0] + [0.0, size[1]]
        parts.append(_bands(edge, np.roll(edge, -1, axis=0), thick, RED))
    by_name = point_places(adjustment, size, grid)
    parts.append(_squares(np.array(list(by_name.values())) * size, 4.0 * thick, AMBER))
    if point in by_name:
        middle = np.array([by_name[point]]) * size
        for way in (*np.eye(2), *-np.eye(2)):  # a cross that leaves the point itself free
            ends = middle + 8.0 * thick * way, middle + 60.0 * thick * way
            parts.append(_bands(*ends, 3.0 * thick, RED))
        parts += [_squares(middle, 8.0 * thick, RED), _squares(middle, 5.0 * thick, WHITE)]
    corners = np.concatenate(parts)
    turn = (patch_adjustment(adjustment, size) or PLAIN).turn
    shares = np.column_stack([corners[:, :2] / size, np.ones(len(corners))]) @ turn.T
    return np.column_stack([shares[:, :2], corners[:, 2:]])


def _grid_lines(columns: int, rows: int) -> list[Array]:
    """Places (n, 2) along each line of a grid, in small steps."""
    lines: list[Array] = []
    for count, steps, order in ((rows, columns, 1), (columns, rows, -1)):
        along = np.linspace(0.0, 1.0, STEPS * (steps - 1) + 1)
        lines += [
            np.stack((along, np.full_like(along, at))[::order], axis=-1)
            for at in np.linspace(0.0, 1.0, count)
        ]
    return lines


def _bands(begin: Array, end: Array, thick: float, colour: tuple[float, float, float]) -> Array:
    """Two triangles for each of k thick lines between points (k, 2), pixels: (6 k, 5)."""
    way = end - begin
    length = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
    aside = np.column_stack([-way[:, 1], way[:, 0]]) * (0.5 * thick / length)
    a, b, c, d = begin - aside, end - aside, end + aside, begin + aside
    corners = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 2)
    return np.column_stack([corners, np.tile(colour, (len(corners), 1))])


def _squares(middles: Array, half: float, colour: tuple[float, float, float]) -> Array:
    """Two triangles for each square around points (k, 2), pixels: (6 k, 5)."""
    return _bands(middles - [half, 0.0], middles + [half, 0.0], 2.0 * half, colour)
