"""Read the scaffold of a flat fish: points, edges and muscles (KS I.B).

The plane is seen from above, x ahead and y to the left. Units are cm, g and tu (0.1 s).
"""

from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError, nearest
from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml, locate_errors
from subsea.biomechanics.body import Floats

Ints = NDArray[np.int64]
Length = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]
Size = Annotated[float, msgspec.Meta(ge=0, le=1000)]
Material = Annotated[float, msgspec.Meta(ge=1e-6, le=1e6)]
Edge = tuple[str, str]
Edges = Annotated[list[Edge], msgspec.Meta(min_length=1, max_length=400)]

KS_FISH = resource_path("assets/flat_fish.toml")
"""The scaffold of the documentation: a fusilier from above."""
SAME = 1e-6  # relative: two points of this distance coincide


class Point(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A point mass."""

    name: str
    x: Length  # cm, ahead
    y: Length  # cm, to the left
    mass: Material  # g
    half_height: Size  # cm, of the fish above and below the point


class Springs(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """Edges of one material; the natural length of each is its length at rest."""

    stiffness: Material  # g/tu²
    viscosity: Material  # g/tu
    edges: Edges  # the names of their ends


class Scaffold(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The content of a scaffold's file."""

    drag: Size  # of the water, g/(cm² tu)
    points: Annotated[list[Point], msgspec.Meta(min_length=3, max_length=100)]
    muscles: Springs
    springs: Annotated[list[Springs], msgspec.Meta(max_length=20)] = []


class FlatBody(NamedTuple):
    """A scaffold of point masses and viscoelastic units in the plane; arrays for kernels."""

    rest: Floats  # (n, 2) cm
    mass: Floats  # (n,) g
    units: Ints  # (s, 2) nodes; muscles come first
    length: Floats  # (s,) cm at rest
    stiffness: Floats  # (s,) g/tu²
    viscosity: Floats  # (s,) g/tu
    hull: Ints  # (e, 2) nodes, anticlockwise: outside is to the right
    height: Floats  # (e,) cm, of the fish at this edge
    triangles: Ints  # (t, 3) of the scaffold, anticlockwise
    mirror: Ints  # (m,) for each muscle that on the other side
    drag: float  # g/(cm² tu)

    @property
    def long(self) -> float:
        """Body length, cm."""
        return float(np.ptp(self.rest[:, 0]))

    def at_rest(self, stretch: float = 1.0) -> Floats:
        """The state (2, n, 2) of a body that does not move, longer by a factor."""
        return np.stack([stretch * self.rest, np.zeros_like(self.rest)])


def read_scaffold(path: Path = KS_FISH) -> FlatBody:
    """Read a scaffold and build its body; a UserError names the file, the line and the key."""
    content = load_toml(path, Scaffold)
    with locate_errors(content, path):
        return build_flat_body(content)


def build_flat_body(content: Scaffold) -> FlatBody:
    """Build the arrays of a scaffold; a UserError names the key of a fault."""
    points = content.points
    for k, point in enumerate(points):
        if any(point.name == other.name for other in points[:k]):
            message = f"`points[{k}]`: another point is named {point.name!r}; rename one"
            raise UserError(message, key=f"points[{k}]")
    rest = np.array([(point.x, point.y) for point in points])
    if np.ptp(rest[:, 0]) < 1.0:
        raise UserError("`points`: expected a body at least 1 cm long along x", key="points")
    groups = [content.muscles, *content.springs]
    keys = ["muscles", *(f"springs[{k}]" for k in range(len(content.springs)))]
    units = list(_units(content, groups, keys, rest))
    many = [len(group.edges) for group in groups]
    triangles = _triangles(units, rest)
    for k, point in enumerate(points):
        if not any(k in corners for corners in triangles):
            message = f"`points[{k}]`: no triangle of edges joins {point.name!r} to others"
            raise UserError(f"{message}; add edges or remove it", key=f"points[{k}]")
    hull = np.array(_hull(triangles))
    ends = np.array(units)
    half_height = np.array([point.half_height for point in points])
    return FlatBody(
        rest,
        np.array([point.mass for point in points]),
        ends,
        np.linalg.norm(rest[ends[:, 1]] - rest[ends[:, 0]], axis=1),
        np.repeat([group.stiffness for group in groups], many),
        np.repeat([group.viscosity for group in groups], many),
        hull,
        half_height[hull].sum(axis=1),
        np.array(triangles),
        _mirror(rest[ends[: many[0]]].mean(axis=1), np.ptp(rest[:, 0])),
        content.drag,
    )


def _units(
    content: Scaffold, groups: list[Springs], keys: list[str], rest: Floats
) -> Iterator[tuple[int, int]]:
    """Check the edges and yield the numbers of their ends."""
    names, seen = [point.name for point in content.points], set()
    for key, group in zip(keys, groups, strict=True):
        for k, edge in enumerate(group.edges):
            place = f"{key}.edges[{k}]"
            for name in edge:
                if name not in names:
                    message = f"`{place}`: no point {name!r}{nearest(name, names)}"
                    raise UserError(message, key=place)
            first, second = (names.index(name) for name in edge)
            if np.hypot(*(rest[first] - rest[second])) < SAME * np.ptp(rest[:, 0]):
                message = f"`{place}`: expected two points at different places"
                raise UserError(message, key=place)
            if frozenset(edge) in seen:
                message = f"`{place}`: {' and '.join(edge)} are joined already; remove one edge"
                raise UserError(message, key=place)
            seen.add(frozenset(edge))
            yield first, second


def _triangles(units: list[tuple[int, int]], rest: Floats) -> list[tuple[int, int, int]]:
    """Find the anticlockwise triangles between edges.

    An edge that crosses an earlier one pulls, but bounds no triangle.
    """
    kept: list[tuple[int, int]] = []
    for edge in units:
        if not any(_cross(rest[[*edge, *other]]) for other in kept):
            kept.append(edge)
    joined = {frozenset(edge) for edge in kept}
    found = []
    for corners in combinations(range(len(rest)), 3):
        if all(frozenset(pair) in joined for pair in combinations(corners, 2)):
            a, b, c = corners
            area = _side(rest[a], rest[b], rest[c])
            ordered = (a, b, c) if area > 0 else (a, c, b)
            if area and not any(_inside(point, rest[list(ordered)]) for point in rest):
                found.append(ordered)
    return found


def _side(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the signed area of a triangle: positive if c lies to the left of a to b."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _cross(ends: Floats) -> bool:
    """True if the edges from ends 0 to 1 and from 2 to 3 (4, 2) cross between their ends."""
    a, b, c, d = ends
    return _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0


def _inside(point: Floats, corners: Floats) -> bool:
    """True if a point is within a triangle, whose corners (3, 2) are anticlockwise."""
    return all(_side(corners[k - 1], corners[k], point) > 0 for k in range(3))


def _hull(triangles: list[tuple[int, int, int]]) -> list[tuple[int, int]]:
    """Walk anticlockwise around the triangles, from the first point of the file that is outside."""
    sides = Counter((t[k - 1], t[k]) for t in triangles for k in range(3))
    outside = [(a, b) for a, b in sides if (b, a) not in sides]
    after = dict(outside)
    edges = [(first := min(after), after[first])]
    while edges[-1][1] in after and edges[-1][1] != first and len(edges) <= len(outside):
        edges.append((edges[-1][1], after[edges[-1][1]]))
    if len(edges) != len(outside):
        missed = next((a for a, b in outside if (a, b) not in edges), first)
        message = f"`points[{missed}]`: expected triangles of edges that fill one outline"
        raise UserError(f"{message}, without holes", key=f"points[{missed}]")
    return edges


def _mirror(middles: Floats, long: float) -> Ints:
    """For each muscle find the one on the other side, by its middle (m, 2)."""
    apart = np.linalg.norm(middles[:, None] * [1.0, -1.0] - middles, axis=2)
    for k, distance in enumerate(apart.min(axis=1)):
        if distance > SAME * long:
            place = f"muscles.edges[{k}]"
            raise UserError(f"`{place}`: expected a muscle on the other side of y = 0", key=place)
    return np.asarray(apart.argmin(axis=1))
