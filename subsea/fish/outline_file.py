"""Read the side outline of a fish, and make its surface: back, belly, tail, and a width.

An outline is a closed line around body and tail fin, without the other fins. The snout is at the
left, up is up, in any unit. A side view does not show the width: it follows from the mass, or is
that of fishes of this height.
"""

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from subsea.base.arrays import Array
from subsea.base.toml_files import error_at, load_toml
from subsea.fish.surface import Curve, EyePlan, FinPlan, PaddlePlan, SurfacePlan, TailPlan, along

DENSITY = 1.05  # of a fish, g/cm³
FEWEST, MOST = 12, 2000  # points of an outline
ROOTS, HEADS = (0.55, 0.95), (0.05, 0.45)  # where the root of a tail may be, and no waist of a head
WAIST = 1.12  # height of a tail fin over that of its root, at least
NO_TAIL_ROOT = 0.92  # root of the tail of a fish without a tail fin, body lengths
KEPT = 24  # points of a curve
LEAST_HEIGHT = 0.004  # of back and belly beside the axis, body lengths
DIGITS = 4
WIDTH_OVER_HEIGHT, USUAL_WIDTH = 0.75, 0.14  # of fishes: the smaller one counts; body lengths
WIDTHS = (0.02, 0.5)  # greatest width that a mass may give, body lengths ...
ROUNDEST = 1.5  # ... and over the height
# Half width over the greatest one, at places over the root of the tail: that of the shipped fishes.
PROFILE = (
    (0.0, 0.12), (0.036, 0.4), (0.095, 0.66), (0.18, 0.85), (0.33, 1.0), (0.48, 0.97),
    (0.65, 0.78), (0.83, 0.48), (0.95, 0.24), (1.02, 0.12), (1.09, 0.045), (1.2, 0.018),
)  # fmt: skip

Number = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]
Points = list[tuple[Number, Number]]


class OutlinePlan(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The file of an outline."""

    outline: Annotated[Points, msgspec.Meta(min_length=FEWEST, max_length=MOST)]
    dorsal: Annotated[Points, msgspec.Meta(min_length=3, max_length=MOST)] | None = None
    """The free edge of the fin from front to rear, in the unit and axes of the outline."""
    ventral: Annotated[Points, msgspec.Meta(min_length=3, max_length=MOST)] | None = None
    length_cm: Annotated[float, msgspec.Meta(ge=2, le=300)] | None = None
    mass_g: Annotated[float, msgspec.Meta(gt=0, le=1e6)] | None = None


def read_outline(path: Path, length_cm: float | None, mass_g: float | None) -> SurfacePlan:
    """The surface of the fish in a file; a length and a mass replace those of the file.

    UserError with the key for a line that cannot be the outline of a fish.
    """
    plan = load_toml(path, OutlinePlan)
    length, mass = length_cm or plan.length_cm, mass_g or plan.mass_g
    if mass and not length:
        raise error_at(path, "mass_g", "a mass needs a length: give length_cm or --length")
    try:
        return make_surface(plan, length, mass)
    except ValueError as fault:
        raise error_at(path, "outline", str(fault)) from None


def make_surface(
    plan: OutlinePlan, length_cm: float | None = None, mass_g: float | None = None
) -> SurfacePlan:
    """The surface of an outline; ValueError for a line that cannot be the outline of a fish."""
    line = _from_snout(plan.outline)
    scale = 1.0 / float(np.ptp(line[:, 0]))
    corner = np.array([line[0, 0], line[0, 1]])
    line = (line - corner) * scale
    at = np.linspace(0.0, 1.0, 401)[1:-1]
    top, bottom = _extent(line, at)
    tall = top - bottom
    _check_heading(at, tall)
    root, finned = _tail_root(at, tall)
    # Heights count from the line between the snout and the middle of the tail's root.
    slope = float(np.interp(root, at, 0.5 * (top + bottom))) / root

    def place(points: Array) -> Array:
        return np.stack([points[:, 0], points[:, 1] - slope * points[:, 0]], axis=1)

    line = place(line)
    back, belly, edge = _paths(line, root, finned)
    fins: dict[str, Any] = {}
    for name in ("dorsal", "ventral"):
        if points := getattr(plan, name):
            fins[name] = _fin(place((np.array(points) - corner) * scale), name)
    body = float(tall[at < root].max())
    half = 0.5 * min(WIDTH_OVER_HEIGHT * body, USUAL_WIDTH)
    surface = SurfacePlan(
        back=back,
        belly=belly,
        width=_width(root, half),
        tail=TailPlan(begin=round(root, DIGITS), edge=edge),
        pectoral=_paddle(belly),
        eye=_eye(back, belly),
        **fins,
    )
    if length_cm and mass_g:
        wide = _half_width_of(surface, length_cm, mass_g)
        surface = msgspec.structs.replace(surface, width=_width(root, wide))
    return surface


def has_tail_fin(surface: SurfacePlan) -> bool:
    """True if the tail's edge is higher than its root, so that a beat can push the fish."""
    root = np.array([surface.tail.begin])
    tall = float(along(surface.back, root)[0] - along(surface.belly, root)[0])
    return surface.back[-1][1] - surface.belly[-1][1] >= WAIST * tall


def _from_snout(outline: Points) -> Array:
    """The corners (n, 2) from the snout along the back, to the tail and back along the belly."""
    line = np.array(outline, np.float64)
    line = line[np.any(line != np.roll(line, 1, axis=0), axis=1)]
    if len(line) < FEWEST:
        raise ValueError(f"{len(line)} different points, expected {FEWEST} or more")
    if pair := _crossing(line):
        raise ValueError(
            f"the line crosses itself, between points {pair[0]} and {pair[1]}: expected one line "
            "around the fish"
        )
    line = np.roll(line, -int(line[:, 0].argmin()), axis=0)
    x, y = line.T
    if float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) > 0:  # anticlockwise
        line = np.concatenate([line[:1], line[:0:-1]])
    return line


def _crossing(line: Array) -> tuple[int, int] | None:
    """The numbers, from 1, of the first points of two sides that cross; None without."""
    a, b = line, np.roll(line, -1, axis=0)

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.sign(
            (q[:, None, 0] - p[:, None, 0]) * (r[None, :, 1] - p[:, None, 1])
            - (q[:, None, 1] - p[:, None, 1]) * (r[None, :, 0] - p[:, None, 0])
        )

    apart = side(a, b, a) * side(a, b, b)  # of the ends of each side, by the line of another
    crossed = (apart < 0) & (apart.T < 0)
    found = np.argwhere(crossed)
    return (int(found[0, 0]) + 1, int(found[0, 1]) + 1) if len(found) else None


def _extent(line: Array, at: Array) -> tuple[Array, Array]:
    """Greatest and least height (n,) of a closed line at places along the body."""
    a, b = line, np.roll(line, -1, axis=0)
    rise = b[:, 0] - a[:, 0]
    share = (at[:, None] - a[None, :, 0]) / np.where(rise == 0.0, 1.0, rise)[None]
    height = a[None, :, 1] + share * (b[:, 1] - a[:, 1])[None]
    meets = (share >= 0.0) & (share <= 1.0) & (rise != 0.0)[None]
    top, bottom = (np.where(meets, height, fill) for fill in (-np.inf, np.inf))
    return top.max(axis=1), bottom.min(axis=1)


def _check_heading(at: Array, tall: Array) -> None:
    """Refuse a fish whose waist lies before its body: its tail comes first."""
    if not 0.03 <= float(tall.max()) <= 1.0:
        raise ValueError(
            f"the fish is {tall.max():.2g} lengths high, expected 0.03 to 1: is it a side view?"
        )
    before, behind = _waists(tall[::-1])[::-1], _waists(tall)
    head = before[(at >= HEADS[0]) & (at <= HEADS[1])].max()
    tail = behind[(at >= ROOTS[0]) & (at <= ROOTS[1])].max()
    if head >= WAIST and head > tail:
        raise ValueError("the tail comes first: mirror the outline, so that the snout is at left")


def _waists(tall: Array) -> Array:
    """The greatest height (n,) behind each place over the height there."""
    return np.asarray(np.maximum.accumulate(tall[::-1])[::-1] / np.maximum(tall, 1e-9))


def _tail_root(at: Array, tall: Array) -> tuple[float, bool]:
    """The root of the tail fin, and True if there is such a fin."""
    waists = np.where((at >= ROOTS[0]) & (at <= ROOTS[1]), _waists(tall), 0.0)
    place = int(waists.argmax())
    finned = bool(waists[place] >= WAIST)
    return (float(at[place]), True) if finned else (NO_TAIL_ROOT, False)


def _paths(
    line: Array, root: float, finned: bool
) -> tuple[Curve, Curve, list[tuple[float, float]]]:
    """The curves of back and belly, and the edge of the tail."""
    rear = np.flatnonzero(line[:, 0] > root)
    if not finned:
        rearmost = int(line[:, 0].argmax())
        back, belly = line[: rearmost + 1], np.concatenate([line[:1], line[: rearmost - 1 : -1]])
        return _curve(back, 1.0), _curve(belly, -1.0), [(0.0, 1.0), (1.0, 0.998)]
    upper = int(rear[line[rear, 1].argmax()])
    lower = int(rear[line[rear, 1].argmin()])
    if upper >= lower:
        raise ValueError("the upper tip of the tail lies below the lower one")
    high, low = line[upper, 1], line[lower, 1]
    path = line[upper : lower + 1][::-1]
    share = (path[:, 1] - 0.5 * (high + low)) / (0.5 * (high - low))
    kept = [0]
    for k in range(1, len(share) - 1):  # an edge that turns back cannot be drawn
        if share[kept[-1]] + 0.02 < share[k] < 0.98:
            kept.append(k)
    kept = [kept[round(k)] for k in np.linspace(0, len(kept) - 1, min(len(kept), KEPT))]
    edge = [
        (round(float(share[k]), DIGITS), round(max(float(path[k, 0]), root + 0.01), DIGITS))
        for k in (*kept, len(share) - 1)
    ]
    edge[0], edge[-1] = (-1.0, edge[0][1]), (1.0, edge[-1][1])
    back, belly = line[: upper + 1], np.concatenate([line[:1], line[: lower - 1 : -1]])
    return _curve(back, 1.0), _curve(belly, -1.0), edge


def _curve(points: Array, side: float) -> Curve:
    """Points from front to rear on one side of the axis; at most KEPT of them."""
    forward = [0]
    for k in range(1, len(points)):
        if points[k, 0] >= points[forward[-1], 0] + 1e-3:
            forward.append(k)
    if forward[-1] != len(points) - 1:  # the tip stays
        while len(forward) > 1 and points[forward[-1], 0] > points[-1, 0] - 1e-3:
            forward.pop()
        forward.append(len(points) - 1)
    x, y = points[forward].T
    if len(x) > KEPT:
        places = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, KEPT))
        places = x[0] + (x[-1] - x[0]) * places
        x, y = places, np.interp(places, x, y)
    y = side * np.maximum(side * y, LEAST_HEIGHT)
    return [(round(float(a), DIGITS), round(float(b), DIGITS)) for a, b in zip(x, y, strict=True)]


def _fin(points: Array, name: str) -> FinPlan:
    """A fin from the points of its free edge."""
    chosen = points[np.round(np.linspace(0, len(points) - 1, min(len(points), KEPT))).astype(int)]
    if not (0.0 <= chosen[0, 0] < chosen[-1, 0] <= 1.0):
        raise ValueError(f"the {name} fin must run from front to rear, within the outline")
    edge = [(round(float(a), DIGITS), round(float(b), DIGITS)) for a, b in chosen]
    return FinPlan(base=(edge[0][0], edge[-1][0]), edge=edge)


def _width(root: float, half: float) -> Curve:
    """The half width along the body, at most ``half``."""
    places = [min(place * root, 1.0) for place, _ in PROFILE]
    points = [
        (round(place, DIGITS), round(half * share, DIGITS))
        for place, (_, share) in zip(places, PROFILE, strict=True)
    ]
    inside = [point for point, after in pairwise(points) if point[0] < after[0]]
    return [*inside, (1.0, points[-1][1])]


def _half_width_of(surface: SurfacePlan, length_cm: float, mass_g: float) -> float:
    """The greatest half width of a fish of a mass; ValueError beyond what fishes have."""
    at = (np.arange(400) + 0.5) / 400
    tall = along(surface.back, at) - along(surface.belly, at)
    slices = np.pi / 2 * tall * along(_width(surface.tail.begin, 1.0), at)
    grams = DENSITY * float(slices.mean()) * length_cm**3  # for each body length of half width
    low, high = 0.5 * WIDTHS[0], 0.5 * min(WIDTHS[1], ROUNDEST * surface.depth)
    half = mass_g / grams
    if not low <= half <= high:
        raise ValueError(
            f"a fish of {length_cm:g} cm with this outline cannot weigh {mass_g:g} g; "
            f"expected {low * grams:.3g} to {high * grams:.3g} g"
        )
    return half


def _paddle(belly: Curve) -> PaddlePlan:
    """Plain pectoral fins, low on the flanks behind the head."""
    at = 0.28
    height = round(0.25 * float(along(belly, np.array([at]))[0]), DIGITS)
    return PaddlePlan(at=at, height=height, length=0.12, width=0.06, droop=15.0)


def _eye(back: Curve, belly: Curve) -> EyePlan:
    """An eye on the upper half of the head."""
    at = np.array([0.09])
    high, low = float(along(back, at)[0]), float(along(belly, at)[0])
    radius = round(float(np.clip(0.14 * (high - low), 0.008, 0.03)), DIGITS)
    return EyePlan(at=0.09, height=round(0.4 * high, DIGITS), radius=radius)
