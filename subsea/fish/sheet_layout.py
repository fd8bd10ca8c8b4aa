"""The layout of a skin sheet (texture): its regions, and body and fins in them."""

from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.fish.raster import single
from subsea.fish.surface import SUNK, Curve, FinPlan, SurfacePlan, along, points_along

Sheet = TypeVar("Sheet", Array, NDArray[np.uint8])


class SheetRegion(NamedTuple):
    """A rectangle in fractions of the sheet's width and height, from the lower left corner."""

    left: float
    bottom: float
    right: float
    top: float


SIZE = (1024, 640)  # texels
BODY = SheetRegion(0.0, 0.0, 1.0, 0.8)
DORSAL = SheetRegion(0.0, 0.8, 1.0, 0.9)  # right: along the base; up: from root to edge
VENTRAL = SheetRegion(0.0, 0.9, 0.5, 1.0)
PECTORAL = SheetRegion(0.5, 0.9, 0.75, 1.0)  # right: from root to end; up: across
PELVIC = SheetRegion(0.75, 0.9, 1.0, 1.0)
SNOUT, EDGE = -0.03, 1.05  # distances from the snout at the left and right border, without wings
MARGIN = 0.02  # above and below the body, body lengths
SLENDER = 0.1  # depth in body lengths below which the head is also shorter


def half_height(surface: SurfacePlan) -> float:
    """Height of the upper border of the body region above the axis; the lower is opposite."""
    wide = surface.wing.span if surface.wing else 0.0
    return MARGIN + max(
        wide, *(abs(y) for curve in (surface.back, surface.belly) for _, y in curve)
    )


def borders(surface: SurfacePlan) -> tuple[float, float]:
    """Distances from the snout at the left and right border; a ray's tail is cut off."""
    return SNOUT, surface.tail.begin + 0.05 if surface.wing else EDGE


def unfold(surface: SurfacePlan, right: Array, upper: Array) -> Array:
    """Height on the sheet of points at `right` of the spine of a fish with wings."""
    return np.asarray(np.where(upper, 1.0, -1.0) * (half_height(surface) - np.abs(right)))


def head_size(surface: SurfacePlan) -> float:
    """Scale of gill cover and jaws: 1 for most fishes, less for eels."""
    return min(1.0, surface.depth / SLENDER)


def eye_height(surface: SurfacePlan) -> float:
    """Height of the eye on the sheet."""
    eye = surface.eye
    return half_height(surface) - eye.height if surface.wing else eye.height


def crop(sheet: Sheet, region: SheetRegion) -> Sheet:
    """A view of the sheet (4, h, w) within a region."""
    _, height, width = sheet.shape
    rows = slice(round(region.bottom * height), round(region.top * height))
    return sheet[:, rows, round(region.left * width) : round(region.right * width)]


def fin_points(plan: FinPlan, ridge: Curve, share: Array, up: Array) -> tuple[Array, Array]:
    """Distances from the snout and heights, from the root in the body to the edge."""
    share = share.clip(0.0, 1.0)
    base = plan.base[0] + (plan.base[1] - plan.base[0]) * share
    edge = points_along(plan.edge, share)
    root = SUNK * along(ridge, base)
    return single(base + up * (edge[:, 0] - base)), single(root + up * (edge[:, 1] - root))
