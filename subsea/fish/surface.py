"""The drawn surface of a fish at rest: 426 control points from its outline (SMC §7.2).

Two halves of 9×21 control points, left then right: u runs from the dorsal ridge over the flank
to the ventral ridge, v from the snout to the tail's edge. The last columns are the tail fin.
Then the dorsal and the ventral fin, 2×12 each: first the row in the body, then the free edge.
The surface, not its control mesh, meets the outline.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.fish.skinning import CouplingMethod
from subsea.geometry.curves import greville, through

U, V = 9, 21
FIN_U, FIN_V = 2, 12
LEFT, RIGHT = slice(0, U * V), slice(U * V, 2 * U * V)
DORSAL = slice(2 * U * V, 2 * U * V + FIN_U * FIN_V)
VENTRAL = slice(2 * U * V + FIN_U * FIN_V, 2 * U * V + 2 * FIN_U * FIN_V)
CONTROL_POINTS = VENTRAL.stop

TAIL_COLUMNS = 6  # of the 21: the tail fin
TIP_COLUMN = 9  # of the 15 on the body: the one that runs to the tip of a wing
WING_ROWS = np.array([0.0, 0.16, 0.42, 0.72])  # of the span, on either side
CROWDING = 0.6  # columns crowd toward snout and tail, where the outline bends most
SUNK = 0.82  # the fins' lower rows lie at this share of the ridge's height

# A quadratic spline touches this polygon around a half-circle at the middle of each edge. Its
# first edge is level, so the two halves meet without a crease.
_ANGLES = np.pi * (np.arange(U - 2) + 0.5) / (U - 2)
_REACH = 1.0 / np.cos(0.5 * np.pi / (U - 2))
SECTION_HEIGHT = np.concatenate([[1.0], _REACH * np.cos(_ANGLES), [-1.0]])
SECTION_WIDTH = np.concatenate([[0.0], _REACH * np.sin(_ANGLES), [0.0]])

Share = Annotated[float, msgspec.Meta(ge=0, le=1)]
Extent = Annotated[float, msgspec.Meta(ge=-1, le=1)]
Curve = Annotated[list[tuple[Share, Extent]], msgspec.Meta(min_length=2)]


class TailPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The tail fin. Its upper and lower edges belong to the curves of back and belly."""

    begin: Share  # distance of its root from the snout, in body lengths
    edge: Annotated[list[tuple[Extent, Share]], msgspec.Meta(min_length=2)]
    """(fraction of the half-height, distance from the snout) from 0 or -1, the lower tip, to 1."""

    def __post_init__(self) -> None:
        """Refuse a fin that does not lie behind its root, or lacks a part."""
        _increasing("edge", self.edge)
        if self.begin < 0.3 or min(x for _, x in self.edge) <= self.begin:
            raise ValueError("the tail must begin behind 0.3 and its edge behind that")
        if self.edge[0][0] not in (0, -1) or self.edge[-1][0] != 1:
            raise ValueError("the edge of the tail must run from 0 or -1 to 1")

    def edge_at(self, share: Array) -> Array:
        """Distance of the trailing edge from the snout at fractions of the half-height, -1 to 1."""
        return along(self.edge, share if self.edge[0][0] < 0 else np.abs(share))


class FinPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A dorsal or ventral fin, in body lengths."""

    base: tuple[Share, Share]  # begin and end, distance from the snout
    edge: Curve  # the free edge from front to rear: (distance from the snout, height)

    def __post_init__(self) -> None:
        """Refuse a base that runs forwards."""
        if self.base[0] >= self.base[1]:
            raise ValueError("the base of a fin must run from front to rear")
        if any(a == b for a, b in pairwise(self.edge)):
            raise ValueError("two neighbouring points of a fin's edge are the same")


class PaddlePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A pair of fins on the flanks, in body lengths."""

    at: Share  # distance of the root from the snout
    height: Extent  # of the root above the axis
    length: Share
    width: Share  # of the free end
    droop: Annotated[float, msgspec.Meta(ge=-90, le=90)]  # degrees below tailward
    wing: bool = False  # pointed and stiff with a level base, as in sharks


class EyePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The eyes, in body lengths."""

    at: Share  # distance from the snout
    height: Extent  # above the axis; of a body with wings, distance from the spine on top
    radius: Share


class WingPlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A flat body with wings, such as a ray's, in body lengths."""

    outline: Annotated[list[tuple[Share, Share]], msgspec.Meta(min_length=5)]
    """(behind the snout, right) from the snout over the tip to the root of the tail."""
    thickness: Curve  # (distance from the spine over the half span, fraction of the height)

    def __post_init__(self) -> None:
        """Refuse an outline without a tip or with a point twice."""
        if not 1 < self.tip < len(self.outline) - 2:
            raise ValueError("the outline must have its tip inside, two points or more from an end")
        if any(a == b for a, b in pairwise(self.outline)):
            raise ValueError("two neighbouring points of the outline are the same")
        _increasing("thickness", self.thickness)

    @property
    def tip(self) -> int:
        """Return the index of the point of the outline that is farthest aside."""
        return int(np.argmax([right for _, right in self.outline]))

    @property
    def span(self) -> float:
        """From the spine to the tip."""
        return self.outline[self.tip][1]


class SurfacePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The shape of a species in body lengths; curves are (distance from the snout, value)."""

    coupling: CouplingMethod = "sections"
    back: Curve  # height of the dorsal ridge above the axis, on to the tail's upper tip
    belly: Curve  # height of the ventral ridge, negative
    width: Curve  # half-width, of a body with wings that of its trunk
    wing: WingPlan | None = None
    tail: TailPlan
    dorsal: FinPlan | None = None
    ventral: FinPlan | None = None
    pectoral: PaddlePlan | None = None
    pelvic: PaddlePlan | None = None
    eye: EyePlan
    stiff_fins: bool = False  # dorsal, ventral and tail fin neither fold nor spread, as in sharks

    def __post_init__(self) -> None:
        """Refuse outlines that run forwards, and a belly above the back."""
        for name in ("back", "belly", "width"):
            _increasing(name, getattr(self, name))
        at = np.linspace(0.02, self.tail.begin, 50)
        if (along(self.back, at) <= along(self.belly, at)).any():
            raise ValueError("the back must lie above the belly")

    @property
    def depth(self) -> float:
        """The greatest height of the body without fins, in body lengths."""
        at = np.linspace(0.0, self.tail.begin, 100)
        return float((along(self.back, at) - along(self.belly, at)).max())


def _increasing(name: str, curve: Curve) -> None:
    if any(b[0] <= a[0] for a, b in pairwise(curve)):
        raise ValueError(f"the points of {name} must follow one another from front to rear")


def rest_control_points(plan: SurfacePlan, body_length_cm: float, snout_x_cm: float) -> Array:
    """Control points (426, 3) at rest in body axes, cm: x anterior, y dorsal, z right.

    `snout_x_cm` is the x of the foremost point, that of node 0 at rest.
    """
    points = fit_control_points(rest_surface(plan)) * body_length_cm
    points[:, 0] = snout_x_cm - points[:, 0]
    return points


def rest_surface(plan: SurfacePlan) -> Array:
    """Points (426, 3) of the surface at rest, where each control point weighs most, body lengths.

    They are (distance from the snout, height, right).
    """
    points = np.empty((CONTROL_POINTS, 3))
    half = _right_half(plan)
    points[RIGHT] = half.reshape(-1, 3)
    points[LEFT] = (half * (1, 1, -1)).reshape(-1, 3)
    points[DORSAL] = _fin(plan.dorsal, plan.back)
    points[VENTRAL] = _fin(plan.ventral, plan.belly)
    return points


def fit_control_points(points: Array) -> Array:
    """Control points (…, 426, 3) of surfaces through the points (…, 426, 3), along the rows.

    Across the body they are control points already.
    """
    out = np.empty(points.shape)
    for part, columns in ((LEFT, V), (RIGHT, V), (DORSAL, FIN_V), (VENTRAL, FIN_V)):
        rows = points[..., part, :].reshape(*points.shape[:-2], -1, columns, 3)
        solved = np.moveaxis(through(np.moveaxis(rows, -2, 0)), 0, -2)
        out[..., part, :] = solved.reshape(*points.shape[:-2], -1, 3)
    return out


def along(curve: Curve | Array, at: Array) -> Array:
    """Values of a curve at `at`: the monotone C1 cubic of Fritsch and Butland."""
    x, y = np.asarray(curve, np.float64).T
    gap = np.diff(x)
    slope = np.diff(y) / gap
    before, after = slope[:-1], slope[1:]
    same = before * after > 0
    a, b = gap[:-1] + 2 * gap[1:], 2 * gap[:-1] + gap[1:]
    mean = (a + b) * before * after / np.where(same, a * after + b * before, 1.0)
    tangent = np.concatenate([slope[:1], np.where(same, mean, 0.0), slope[-1:]])
    cell = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(gap) - 1)
    h = gap[cell]
    t = np.clip((at - x[cell]) / h, 0.0, 1.0)
    return np.asarray(
        y[cell]
        + t * h * tangent[cell]
        + t**2 * (3 * slope[cell] - 2 * tangent[cell] - tangent[cell + 1]) * h
        + t**3 * (tangent[cell] + tangent[cell + 1] - 2 * slope[cell]) * h
    )


def _right_half(plan: SurfacePlan) -> Array:
    """(9, 21, 3): distance from the snout, height, and right, in body lengths."""
    begin, body = plan.tail.begin, V - TAIL_COLUMNS
    t = np.clip(greville(V) / greville(V)[body - 1], 0.0, 1.0)
    fin = np.clip(np.arange(V) - body + 1, 0, None) / TAIL_COLUMNS  # 0 on the body, 1 at the edge
    even = np.linspace(1.0, -1.0, U)[:, None]
    edge = plan.tail.edge_at(even)
    tip, lower_tip = edge[0, 0], edge[-1, 0]
    crowded = (1 - CROWDING) * t + CROWDING * (1 - np.cos(np.pi * t)) / 2
    ridge = begin * crowded + (tip - begin) * fin
    top, bottom = along(plan.back, ridge), along(plan.belly, ridge + fin * (lower_tip - tip))
    middle, radius = (top + bottom) / 2, (top - bottom) / 2
    # A fin is flat: there the rows spread evenly from edge to edge.
    section = SECTION_HEIGHT[:, None]
    height = section + np.minimum(2.0 * fin, 1.0) * (even - section)
    half = np.empty((U, V, 3))
    half[..., 0] = ridge + fin * (edge - tip)
    half[..., 1] = middle + height * radius
    half[..., 2] = SECTION_WIDTH[:, None] * along(plan.width, ridge)
    if plan.wing:
        half[:, :body] = _wing(plan.wing, ridge[:body], top[:body], bottom[:body])
    return half


def _wing(plan: WingPlan, ridge: Array, top: Array, bottom: Array) -> Array:
    """(9, 15, 3): rows from the spine over the wing's edge to the keel, columns along the chord.

    Each column is straight from the ridge to the outline; column TIP_COLUMN ends at the tip.
    """
    front, rear = plan.outline[: plan.tip + 1], plan.outline[plan.tip :]
    columns = np.arange(len(ridge))
    before = (columns[: TIP_COLUMN + 1] / TIP_COLUMN) ** 1.25  # more of them at the head
    behind = (columns[TIP_COLUMN:] - TIP_COLUMN) / (columns[-1] - TIP_COLUMN)
    edge = np.concatenate([points_along(front, before)[:-1], points_along(rear, behind)])
    # The spline passes inside the edge's control points, which lie farther out.
    out = (1.0 - 0.25 * WING_ROWS[-1]) / 0.75
    reach = np.concatenate([WING_ROWS, [out], WING_ROWS[::-1]])[:, None]
    half = np.empty((U, len(ridge), 3))
    half[..., 0] = ridge + reach * (edge[:, 0] - ridge)
    half[..., 2] = reach * edge[:, 1]
    thick = along(plan.thickness, np.minimum(half[..., 2] / plan.span, 1.0))
    thick[[0, 1, -2, -1]] = 1.0  # level at the ridge, so that both halves meet without a crease
    half[..., 1] = thick * np.where(np.arange(U)[:, None] < U // 2, top, bottom)
    half[U // 2, :, 1] = 0.0
    return half


def points_along(points: Sequence[tuple[float, float]], share: Array) -> Array:
    """Points (n, 2) of a smooth curve through `points`, at fractions of its length."""
    corner = np.asarray(points)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corner, axis=0).T))])
    way /= way[-1]
    return np.stack([along(np.stack([way, axis], 1), share) for axis in corner.T], axis=1)


def _fin(plan: FinPlan | None, ridge: Curve) -> Array:
    """(24, 3): the row sunk in the body, then the free edge; one point without a fin."""
    share = greville(FIN_V)
    if plan is None:
        return np.tile((0.5, 0.0, 0.0), (FIN_U * FIN_V, 1))
    base = plan.base[0] + (plan.base[1] - plan.base[0]) * share
    rows = np.zeros((FIN_U, FIN_V, 3))
    rows[0, :, 0], rows[0, :, 1] = base, SUNK * along(ridge, base)
    rows[1, :, :2] = points_along(plan.edge, share)
    return rows.reshape(-1, 3)
