"""From the adjustment of a theatre file, in pixels, to that of a patch, in shares; and back."""

from typing import TypeVar

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.stage.theatre.theatre_file import Adjustment, Corners
from subsea.view.adjustment import (
    UNMOVED,
    PatchAdjustment,
    folds,
    homography,
    is_convex,
    moved,
)

UNIT = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
ANTICLOCKWISE = ("lower_left", "lower_right", "upper_right", "upper_left")  # as `UNIT`
PLAIN = PatchAdjustment()
T = TypeVar("T", bound=Adjustment)
_MIRRORS = {
    None: UNMOVED,
    "horizontal": np.array([[-1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "vertical": np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]]),
}
_QUARTER = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [0.0, 0.0, 1.0]])  # clockwise


def upright(adjustment: Adjustment, size: tuple[int, int]) -> tuple[int, int]:
    """Return width and height of the picture in a rectangle of `size` pixels."""
    return size[::-1] if adjustment.rotate in (90, 270) else size


def patch_adjustment(adjustment: Adjustment, size: tuple[int, int]) -> PatchAdjustment | None:
    """Turn an adjustment of a picture of `size` pixels into that of its patch; None: as it is.

    A UserError if corners cross or points fold the picture.
    """
    corners = UNIT + _corner_shifts(adjustment.corners_px, size)
    if not is_convex(corners):
        raise UserError("`corners_px`: the moved corners cross, expected a convex picture")
    turn = np.linalg.matrix_power(_QUARTER, adjustment.rotate // 90) @ _MIRRORS[adjustment.flip]
    made = PLAIN._replace(
        corners=homography(corners),
        points=_point_shifts(adjustment, size),
        turn=turn,
        edge=None if adjustment.edge_mask is None else _edge(adjustment.edge_mask, size, turn),
        edge_soft_px=adjustment.edge_soft_px,
        gain=adjustment.gain,
    )
    if folds(made):
        raise UserError("`points_px`: the moved points fold the picture, expected smaller shifts")
    weakens = made.edge is not None or made.gain != PLAIN.gain
    return made if made.moves or weakens else None


def moved_places(adjustment: Adjustment, size: tuple[int, int], places: Array) -> Array:
    """Find where places (n, 2) of the picture lie after line-up, before it is turned: (n, 2).

    All are shares of a picture of `size` pixels from its lower left corner.
    """
    made = patch_adjustment(adjustment, size) or PLAIN
    lit = moved(made._replace(turn=UNMOVED), places)
    return np.asarray(lit[:, :2] / lit[:, 2:])


def in_larger_pixels(adjustment: T, times: int) -> T:
    """Count all pixels of an adjustment in pixels that are `times` as large."""

    def less(pair: tuple[float, float]) -> tuple[float, float]:
        return pair[0] / times, pair[1] / times

    if times == 1:
        return adjustment
    corners, points, edge = adjustment.corners_px, adjustment.points_px, adjustment.edge_mask
    if corners is not None:
        corners = Corners(**{name: less(getattr(corners, name)) for name in ANTICLOCKWISE})
    return msgspec.structs.replace(
        adjustment,
        corners_px=corners,
        points_px=points and [[less(pair) for pair in row] for row in points],
        edge_mask=edge and [less(pair) for pair in edge],
        edge_soft_px=max(adjustment.edge_soft_px / times, 1.0),
    )


def tidy(adjustment: Adjustment) -> Adjustment:
    """Leave out corners and points that are not moved."""
    corners, points = adjustment.corners_px, adjustment.points_px
    return msgspec.structs.replace(
        adjustment,
        corners_px=None if corners == Corners() else corners,
        points_px=points if points and np.any(points) else None,
    )


def _corner_shifts(corners: Corners | None, size: tuple[int, int]) -> Array:
    """Shifts (4, 2) of the corners in shares, in the order of `UNIT`."""
    if corners is None:
        return np.zeros((4, 2))
    return _shares([getattr(corners, name) for name in ANTICLOCKWISE], size)


def _point_shifts(adjustment: Adjustment, size: tuple[int, int]) -> Array | None:
    """Shifts (rows, columns, 2) of the points in shares, the lowest row first; None: no shift."""
    if adjustment.points_px is None:
        return None
    if len({len(row) for row in adjustment.points_px}) > 1:
        raise UserError("`points_px`: its rows have different lengths, expected a grid")
    points = _shares(adjustment.points_px, size)[::-1]
    return points if points.any() else None


def _shares(pixels: object, size: tuple[int, int]) -> Array:
    """Pixels right and down as shares right and up."""
    return np.asarray(pixels, np.float64) / size * [1.0, -1.0]


def _edge(polygon: list[tuple[float, float]], size: tuple[int, int], turn: Array) -> Array:
    """A polygon in pixels from the upper left corner, as shares (k, 2) of the turned rectangle."""
    places = _shares(polygon, size) + [0.0, 1.0]
    return np.asarray((np.column_stack([places, np.ones(len(places))]) @ turn.T)[:, :2])
