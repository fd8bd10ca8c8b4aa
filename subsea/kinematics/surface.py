"""The drawn surface of a fish at rest: 426 control points from its outline (SMC §7.2).

Two halves of 9×21 control points, left then right: u runs from the dorsal ridge over the flank
to the ventral ridge, v from the snout to the tail's edge. The last columns are the tail fin.
Then the dorsal and the ventral fin, 2×12 each: first the row in the body, then the free edge.
"""

from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

U, V = 9, 21
FIN_U, FIN_V = 2, 12
LEFT, RIGHT = slice(0, U * V), slice(U * V, 2 * U * V)
DORSAL = slice(2 * U * V, 2 * U * V + FIN_U * FIN_V)
VENTRAL = slice(2 * U * V + FIN_U * FIN_V, 2 * U * V + 2 * FIN_U * FIN_V)
CONTROL_POINTS = VENTRAL.stop

TAIL_COLUMNS = 5  # of the 21: the tail fin
ROOT_DEPTH = 0.75  # the fins' lower rows are sunk to this share of the body's height

Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Extent = Annotated[float, msgspec.Meta(ge=-1, le=1)]
Curve = Annotated[list[tuple[Share, Extent]], msgspec.Meta(min_length=2)]

# A cross-section from ridge to ridge: shares of height and half-width. Flat at the ridges, so
# that the two halves meet without an edge, and a little wide at the flank, which the B-spline
# draws in.
SECTION_HEIGHT = np.array([1.0, 1.0, 0.86, 0.5, 0.0, -0.5, -0.86, -1.0, -1.0])
SECTION_WIDTH = np.array([0.0, 0.36, 0.72, 0.98, 1.07, 0.98, 0.72, 0.36, 0.0])


class TailPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The tail fin, in body lengths."""

    begin: Share  # distance of its root from the snout
    half_height: Annotated[float, msgspec.Meta(gt=0, le=1)]  # at its edge
    fork: Extent  # how far the middle of the edge lies before the tips; negative: rounded
    spread: Share = 0.5  # how early it widens, 0 late to 1 at once


class FinPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A dorsal or ventral fin: its edge above the body's ridge, in body lengths."""

    begin: Share
    end: Share
    height: Curve  # (share of the fin's base, height)
    lean: Extent = 0.05  # how far the edge lies behind the base


class PectoralPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The pectoral fins, in body lengths."""

    at: Share  # distance of the root from the snout
    height: Extent  # of the root, share of the body's half-height
    length: Share
    width: Share


class EyePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The eyes, in body lengths."""

    at: Share  # distance from the snout
    height: Extent  # above the axis
    radius: Share


class SurfacePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The outline of a species; every curve is (distance from the snout, value)."""

    back: Curve  # height of the dorsal ridge above the axis
    belly: Curve  # height of the ventral ridge, negative
    width: Curve  # half-width
    tail: TailPlan
    dorsal: FinPlan
    ventral: FinPlan
    pectoral: PectoralPlan
    eye: EyePlan


def rest_control_points(plan: SurfacePlan, body_length_cm: float, snout_x_cm: float) -> Array:
    """Control points (426, 3) at rest in body axes, cm: x anterior, y dorsal, z right.

    `snout_x_cm` is the x of the foremost point, that of node 0 at rest.
    """
    points = np.empty((CONTROL_POINTS, 3))
    half = _right_half(plan)
    points[RIGHT] = half.reshape(-1, 3)
    points[LEFT] = (half * (1, 1, -1)).reshape(-1, 3)
    points[DORSAL] = _fin(plan.dorsal, plan.back, 1.0)
    points[VENTRAL] = _fin(plan.ventral, plan.belly, -1.0)
    points *= body_length_cm
    points[:, 0] = snout_x_cm - points[:, 0]
    return points


def _at(curve: Curve, s: Array) -> Array:
    """A curve at distances s: linear between its points, which the B-spline smooths."""
    knots = np.array(curve)
    return np.asarray(np.interp(s, knots[:, 0], knots[:, 1]))


def _right_half(plan: SurfacePlan) -> Array:
    """(9, 21, 3): distance from the snout, height, and right, in body lengths."""
    tail = plan.tail
    body = V - TAIL_COLUMNS
    # Columns crowd toward the snout, where the outline bends most.
    s = np.concatenate([[0.0], tail.begin * np.linspace(0.0, 1.0, body - 1) ** 1.35])
    top, bottom, width = _at(plan.back, s), _at(plan.belly, s), _at(plan.width, s)
    # Column 0 is the tip; column 1 lies over it, full width, which makes the snout round.
    middle, radius = (top + bottom) / 2, (top - bottom) / 2
    radius[0], width[0] = 0.0, 0.0
    half = np.empty((U, V, 3))
    half[:, :body, 0] = s
    half[:, :body, 1] = middle + SECTION_HEIGHT[:, None] * radius
    half[:, :body, 2] = SECTION_WIDTH[:, None] * width
    eta = np.linspace(1.0, -1.0, U)
    thin = width[-1]
    for k in range(1, TAIL_COLUMNS + 1):
        t = k / TAIL_COLUMNS
        rise = t ** (2.0 - 1.5 * tail.spread)
        height = radius[-1] + (tail.half_height - radius[-1]) * rise
        edge = 1.0 - tail.fork * (1.0 - np.abs(eta) ** 1.4) - tail.begin
        half[:, body + k - 1, 0] = tail.begin + edge * t
        half[:, body + k - 1, 1] = middle[-1] * (1 - t) + eta * height
        half[:, body + k - 1, 2] = thin * (1 - t) ** 2 * SECTION_WIDTH + 0.0008 * (1 - eta**2)
    return half


def _fin(plan: FinPlan, ridge: Curve, side: float) -> Array:
    """(24, 3): the row sunk in the body, then the free edge."""
    share = np.linspace(0.0, 1.0, FIN_V)
    s = plan.begin + (plan.end - plan.begin) * share
    base = _at(ridge, s)
    edge = base + side * _at(plan.height, share)
    rows = np.zeros((FIN_U, FIN_V, 3))
    rows[0, :, 0], rows[0, :, 1] = s, ROOT_DEPTH * base
    rows[1, :, 0], rows[1, :, 1] = s + plan.lean * share, edge
    return rows.reshape(-1, 3)
