"""The mass-spring-damper fish at rest: 23 nodes, 91 viscoelastic units (Tu §4.2, figs. 4.2, 4.6).

Node 0 is the nose, followed by five rings of four nodes from the upper left on clockwise as seen
from behind; nodes 21 and 22 are the upper and lower tail tips.

The body-centred coordinate system B of a fish (SMC eqs. 1-5).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.biomechanics.body_plan import NODES_AT_STATION, BodyPlan
from subsea.biomechanics.reactive_water import Sections, make_sections
from subsea.geometry.vector import Vector, cross, minus, plus, times, unit, vector
from subsea.kernels import kernel


def body_frame(nodes: Array) -> tuple[Array, Array]:
    """Origin (…, 3) and rotation (…, 3, 3) of B for world nodes (…, 23, 3).

    Columns of the rotation are x anterior, y dorsal, z right lateral. SMC eqs. 1 to 3 take one
    edge and one diagonal of the second ring. Here all four nodes count: the ring of a bent body is
    a trapezium, whose upper edge alone rolls and heaves with each beat. The y axis is normalised,
    which SMC eq. 3 as printed omits.
    """
    nose, ring = nodes[..., 0, :], nodes[..., 5:9, :]
    origin = ring.mean(axis=-2)
    left = ring[..., 0, :] - ring[..., 1, :] + ring[..., 3, :] - ring[..., 2, :]
    x = _unit(nose - origin)
    y = _unit(np.cross(x, left))
    z = np.cross(x, y)
    return origin, np.stack([x, y, z], axis=-1)


@kernel
def origin_of(x: Array) -> Vector:
    """Compute the origin of B for nodes (23, 3): as `body_frame`, compiled."""
    upper, lower = plus(vector(x[5]), vector(x[6])), plus(vector(x[7]), vector(x[8]))
    return times(0.25, plus(upper, lower))


@kernel
def axes_of(x: Array, origin: Vector) -> tuple[Vector, Vector, Vector]:
    """Compute the axes ahead, up and right of B for nodes (23, 3): as `body_frame`, compiled."""
    ahead = unit(minus(vector(x[0]), origin))
    left, right = plus(vector(x[5]), vector(x[8])), plus(vector(x[6]), vector(x[7]))
    up = unit(cross(ahead, minus(left, right)))
    return ahead, up, cross(ahead, up)


def to_body(points: Array, origin: Array, rotation: Array) -> Array:
    """World points (…, n, 3) in body axes (SMC eqs. 8 and 9)."""
    return np.asarray((points - origin[..., None, :]) @ rotation)


def to_world(points: Array, origin: Array, rotation: Array) -> Array:
    """Body points (…, n, 3) in world axes (SMC eqs. 12 and 13 without the scale)."""
    return np.asarray(origin[..., None, :] + points @ np.swapaxes(rotation, -1, -2))


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NODES = 23
RINGS = 5
MUSCLES = 12
UPPER_TAIL, LOWER_TAIL = 21, 22

# Side of the body for each position in a ring: +1 left, -1 right; +1 upper, -1 lower.
RING_LEFT = np.array([1.0, -1.0, -1.0, 1.0])
RING_UP = np.array([1.0, 1.0, -1.0, -1.0])
MUSCLE_LEFT = np.tile(RING_LEFT, 3)
MUSCLE_SEGMENT = np.repeat(np.arange(3), 4)


def _ring(number: int) -> list[int]:
    return [1 + 4 * number + place for place in range(4)]


Pairs = list[tuple[int, int]]


def connect(rings: int, segments: int) -> tuple[Pairs, Pairs, Pairs]:
    """List the muscle, cross and remaining units of a chain of rings as pairs of nodes (i < j).

    The foremost ``segments`` between rings have muscles.
    """
    muscle: Pairs = []
    cross: Pairs = []
    other = [(0, node) for node in _ring(0)]
    tips = 4 * rings + 1, 4 * rings + 2
    for number in range(rings):
        a, b, c, d = _ring(number)
        other += [(a, b), (b, c), (c, d), (a, d)]
        cross += [(a, c), (b, d)]
    for number in range(rings - 1):
        front, back = _ring(number), _ring(number + 1)
        lengthwise = list(zip(front, back, strict=True))
        (muscle if number < segments else other).extend(lengthwise)
        for place in range(4):
            beside = (place + 1) % 4
            cross += [(front[place], back[beside]), (front[beside], back[place])]
    other += [(node, tip) for node in _ring(rings - 1) for tip in tips]
    other.append(tips)
    return muscle, cross, other


def _faces() -> tuple[list[tuple[int, int, int]], list[float]]:
    """Triangulate the hull, corners anticlockwise seen from outside, with their weights.

    A quadrilateral uses the triangles of both diagonals at half weight: a single diagonal is not
    mirror symmetric and slowly rolls the fish.
    """
    triangles: list[tuple[int, int, int]] = []
    weights: list[float] = []

    def add_quad(a: int, b: int, c: int, d: int) -> None:
        triangles.extend([(a, b, c), (a, c, d), (b, c, d), (b, d, a)])
        weights.extend([0.5] * 4)

    first = _ring(0)
    for place in range(4):
        triangles.append((0, first[place], first[(place + 1) % 4]))
        weights.append(1.0)
    for number in range(RINGS - 1):
        front, back = _ring(number), _ring(number + 1)
        for place in range(4):
            beside = (place + 1) % 4
            add_quad(front[place], back[place], back[beside], front[beside])
    a, b, c, d = _ring(4)
    add_quad(d, LOWER_TAIL, UPPER_TAIL, a)
    add_quad(b, UPPER_TAIL, LOWER_TAIL, c)
    triangles += [(a, UPPER_TAIL, b), (c, LOWER_TAIL, d)]
    weights += [1.0, 1.0]
    return triangles, weights


# The hindmost section of a fish is passive: muscles are i -> i + 4 for 1 <= i <= 12 only.
_MUSCLE, _CROSS, _OTHER = connect(RINGS, 3)
UNITS: Ints = np.array(_MUSCLE + _CROSS + _OTHER)
"""Node pairs (91, 2): the 12 muscles, 42 cross units and 37 others, in this order."""
KINDS: Ints = np.repeat(np.arange(3), [len(_MUSCLE), len(_CROSS), len(_OTHER)])
"""0 muscle, 1 cross, 2 other, for each unit (91,)."""
TRIANGLES: Ints = np.array(_faces()[0])
"""Hull triangles (78, 3), corners anticlockwise from outside."""
TRIANGLE_WEIGHTS: Floats = np.array(_faces()[1])  # share of each triangle in the water force (78,)

HALF_BANDWIDTH = int((UNITS[:, 1] - UNITS[:, 0]).max())
"""Greatest difference of node numbers in a unit, 7: half the bandwidth of the matrix."""


class Material(NamedTuple):
    """Body arrays that the solver needs, in cm, g and tu."""

    mass: Floats  # (23,)
    length: Floats  # (91,) rest length of the units
    stiffness: Floats  # (91,)
    viscosity: Floats  # (91,)
    drag: float  # µ of Tu eq. 4.3
    sections: Sections  # of the elongated-body water, zeros under Tu's


class Body(NamedTuple):
    """A body at rest and its material, arrays in cm, g and tu."""

    rest: Floats  # (23, 3) nodes at rest in body axes
    mass: Floats  # (23,)
    length: Floats  # (91,) rest length of the units
    stiffness: Floats  # (91,)
    viscosity: Floats  # (91,)
    drag: float  # µ of Tu eq. 4.3
    sections: Sections  # of the elongated-body water, zeros under Tu's

    @property
    def material(self) -> Material:
        """The body without its shape."""
        return Material(*self[1:])


def rest_nodes(plan: BodyPlan, back: float = 1.0) -> Floats:
    """Nodes at rest (23, 3), cm, in body axes: x anterior, y dorsal, z right lateral.

    The origin is the middle of the second ring, as for the body frame (SMC eq. 1).
    ``back`` scales the height of everything above the midline; 1 is a symmetric body.
    """
    nodes = np.zeros((NODES, 3))
    nodes[:, 0] = plan.stations[2] - np.repeat(plan.stations, NODES_AT_STATION)
    nodes[1:21, 1] = np.outer(plan.half_heights, RING_UP).ravel()
    nodes[1:21, 2] = np.outer(plan.half_widths, -RING_LEFT).ravel()
    nodes[UPPER_TAIL:, 1] = plan.tail_half_height, -plan.tail_half_height
    nodes[:, 1] *= np.where(nodes[:, 1] > 0, back, 1.0)
    return nodes


def build_body(plan: BodyPlan, back: float = 1.0) -> Body:
    """Arrays of the body that a plan describes; ``back`` as in :func:`rest_nodes`."""
    nodes = rest_nodes(plan, back)
    kinds = np.array([plan.muscle_stiffness, plan.cross_stiffness, plan.other_stiffness])
    return Body(
        rest=nodes,
        mass=np.repeat(plan.masses, NODES_AT_STATION).astype(np.float64),
        length=np.linalg.norm(nodes[UNITS[:, 1]] - nodes[UNITS[:, 0]], axis=1),
        stiffness=kinds[KINDS],
        viscosity=np.full(len(UNITS), plan.viscosity),
        drag=plan.water_drag,
        sections=make_sections(plan),
    )
