"""The force of the water on a slender body (Lighthill 1960, 1971), on six sections.

Sections are the five rings and the edge of the tail. Section k moves at u_k t + w_k n: t points
to the head, n to the right. Water of mass M_k moves with it along n, its momentum is M_k w_k n.
Relative to the body this water flows to the tail, and leaves at its edge. Per section the force on
the body is

    - d/dt (M w n) + Φ_front - Φ_back - C |w| w n - R |w'| w' - H |v| v y - S |u| u t,

with the flux Φ = m (u w n - w² t / 2) through the planes between sections, where m is the added
mass per length. The last plane is the edge of the tail: its flux is the momentum that is shed.
The other terms are resistive: cross-flow along n and its share that opposes roll, heave along the
dorsal axis y, skin friction along t.
"""

import math
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.biomechanics.body_plan import NODES_AT_STATION, BodyPlan
from subsea.kernels import kernel
from subsea.kernels.lanes import zero_of

DENSITY = 1.0  # of water, g/cm³
SECTIONS = 6
RINGS = SECTIONS - 1


class Sections(NamedTuple):
    """Coefficients of the six sections, the snout's share in the first; g and cm."""

    added: Array  # (6,) g, added mass of each section; zeros without this water
    flux: Array  # (6,) g/cm, added mass per length behind each section, at last at the tail's edge
    cross: Array  # (6,) g/cm, ½ρ C_d times the lateral area
    heave: Array  # (6,) g/cm, ½ρ C_d times the area seen from above
    skin: Array  # (6,) g/cm, ½ρ C_f times the wetted area


NO_SECTIONS = Sections(*np.zeros((5, SECTIONS)))
Kept = tuple[float, ...] | Array
ALL_KEPT: Kept = (1.0,) * RINGS + (0.0,)
"""Share of the flux behind each section that the next one receives: a fish's tail sheds it all.

It is a tuple, so that the compiler knows the number of sections.
"""


def make_sections(plan: BodyPlan) -> Sections:
    """The coefficients of a body, its height and width linear between the stations."""
    if plan.water == "tu":
        return NO_SECTIONS
    height = np.array([0.0, *plan.section_heights])
    width = np.array([0.0, *(2.0 * half for half in plan.half_widths), 0.0])
    return section_coefficients(
        np.diff(plan.stations), height, width, plan.cross_drag, plan.skin_drag
    )


def section_coefficients(
    length: Array, height: Array, width: Array, cross_drag: float, skin_drag: float
) -> Sections:
    """The coefficients of sections between stations ``length`` cm apart.

    ``height`` and ``width`` are those of the body at the stations, from the nose on. The perimeter
    of a section is taken as 2 b + (π - 2) a for its height b and width a, which is exact for a
    circle and for a plate.
    """
    perimeter = 2.0 * height + (np.pi - 2.0) * width
    middle = 0.5 * (height[1:-1] + height[2:])
    per_length = 0.25 * np.pi * DENSITY
    half = 0.5 * DENSITY
    return Sections(
        added=per_length * _spread_squares(height, length),
        flux=per_length * np.append(middle, height[-1]) ** 2,
        cross=half * cross_drag * _spread(height, length),
        heave=half * cross_drag * _spread(width, length),
        skin=half * skin_drag * _spread(perimeter, length),
    )


def inertial_mass(plan: BodyPlan, mass: Array) -> NDArray[np.float64]:
    """Mass (23,) of the nodes with the water that moves aside with them, g; in Tu's water too."""
    added = make_sections(msgspec.structs.replace(plan, water="elongated")).added
    share = np.append(added[:-1] / NODES_AT_STATION[1], added[-1] / NODES_AT_STATION[-1])
    water = np.repeat([0.0, *share], NODES_AT_STATION)
    return np.asarray(mass + water, np.float64)


def _spread(values: Array, length: Array) -> Array:
    """Integrals (6,) of a piecewise linear quantity times the hat function of each section."""
    front, back = values[:-1], values[1:]
    return _gather(length * (front / 3 + back / 6), length * (front / 6 + back / 3))


def _spread_squares(values: Array, length: Array) -> Array:
    """The same of the square of a piecewise linear quantity."""
    a, b = values[:-1], values[1:]
    both = a * b / 6
    return _gather(length * (a**2 / 4 + both + b**2 / 12), length * (a**2 / 12 + both + b**2 / 4))


def _gather(front: Array, back: Array) -> Array:
    """Sum the shares of the six intervals at their ends; the snout's go to the first ring."""
    shares = back.copy()
    shares[:-1] += front[1:]
    shares[0] += front[0]
    return shares


@kernel
def sections_of(rows: Array) -> Sections:
    """Name the rows (5, 6) of a table of coefficients."""
    return Sections(rows[0], rows[1], rows[2], rows[3], rows[4])


@kernel
def section_frames(x: Array, tangent: Array, normal: Array) -> None:
    """Write the unit vectors t and n (6, 3) of the sections of a body with nodes x (23, 3)."""
    rings = tangent.shape[0] - 1
    for k in range(rings + 1):
        fx, fy, fz = _middle(x, k - 1, rings)
        bx, by, bz = _middle(x, min(k + 1, rings), rings)
        tx, ty, tz = fx - bx, fy - by, fz - bz
        scale = 1.0 / math.sqrt(tx * tx + ty * ty + tz * tz)
        tx, ty, tz = tx * scale, ty * scale, tz * scale
        a = 1 + 4 * k
        if k < rings:
            dx = x[a, 0] + x[a + 1, 0] - x[a + 2, 0] - x[a + 3, 0]
            dy = x[a, 1] + x[a + 1, 1] - x[a + 2, 1] - x[a + 3, 1]
            dz = x[a, 2] + x[a + 1, 2] - x[a + 2, 2] - x[a + 3, 2]
        else:
            b = a + 1
            dx, dy, dz = x[a, 0] - x[b, 0], x[a, 1] - x[b, 1], x[a, 2] - x[b, 2]
        nx, ny, nz = ty * dz - tz * dy, tz * dx - tx * dz, tx * dy - ty * dx
        scale = 1.0 / math.sqrt(nx * nx + ny * ny + nz * nz)
        tangent[k, 0], tangent[k, 1], tangent[k, 2] = tx, ty, tz
        normal[k, 0], normal[k, 1], normal[k, 2] = nx * scale, ny * scale, nz * scale


@kernel
def _middle(x: Array, k: int, rings: int) -> tuple[float, float, float]:
    """Mean of the nodes of section k: a ring, the tail's edge, or the snout for -1."""
    if k < 0:
        return x[0, 0], x[0, 1], x[0, 2]
    a = 1 + 4 * k
    if k == rings:
        b = a + 1
        return 0.5 * (x[a, 0] + x[b, 0]), 0.5 * (x[a, 1] + x[b, 1]), 0.5 * (x[a, 2] + x[b, 2])
    return (
        0.25 * (x[a, 0] + x[a + 1, 0] + x[a + 2, 0] + x[a + 3, 0]),
        0.25 * (x[a, 1] + x[a + 1, 1] + x[a + 2, 1] + x[a + 3, 1]),
        0.25 * (x[a, 2] + x[a + 1, 2] + x[a + 2, 2] + x[a + 3, 2]),
    )


@kernel
def add_section_forces(
    v: Array,
    water: Array,
    sections: Sections,
    kept: Kept,
    step: float,
    axes: Array,
    load: Array,
    resistance: Array,
) -> None:
    """Add the explicit forces to ``load``; write the implicit ``resistance`` (6,) along n, g/tu.

    ``axes`` (3, 6, 3) are the tangents, the normals and the normals one step ago. The last and
    v (23, 3), cm/tu, the velocities since then, are the momentum that the water has. The implicit
    part, :func:`couple_sections`, gives it the momentum of the new velocities. So body and water
    exchange exactly what the one loses and the other gains. ``kept`` is the share of the flux
    behind each section that reaches the next one.
    """
    tangent, normal, before = axes[0], axes[1], axes[2]
    rings = len(kept) - 1
    zero = zero_of(v)
    px, py, pz = zero, zero, zero  # flux through the plane before this section
    fx, fy, fz = zero, zero, zero  # flux per added mass at the section before
    for k in range(rings + 1):
        vx, vy, vz = _middle(v, k, rings)
        vx, vy, vz = vx - water[0], vy - water[1], vz - water[2]
        tx, ty, tz = tangent[k, 0], tangent[k, 1], tangent[k, 2]
        nx, ny, nz = normal[k, 0], normal[k, 1], normal[k, 2]
        ox, oy, oz = before[k, 0], before[k, 1], before[k, 2]
        u = vx * tx + vy * ty + vz * tz
        w = vx * nx + vy * ny + vz * nz
        qx = u * w * nx - 0.5 * w * w * tx
        qy = u * w * ny - 0.5 * w * w * ty
        qz = u * w * nz - 0.5 * w * w * tz
        if k > 0:
            plane = 0.5 * sections.flux[k - 1]
            sx, sy, sz = plane * (fx + qx), plane * (fy + qy), plane * (fz + qz)
            # Momentum that leaves the section in front enters this one.
            _push(load, k - 1, rings, px - sx, py - sy, pz - sz)
            part = kept[k - 1]
            px, py, pz = part * sx, part * sy, part * sz
        fx, fy, fz = qx, qy, qz
        gx, gy, gz = zero, zero, zero
        if k == rings:  # shed at the edge of the tail
            edge = sections.flux[k]
            gx, gy, gz = px - edge * qx, py - edge * qy, pz - edge * qz
        momentum = sections.added[k] / step * (vx * ox + vy * oy + vz * oz)
        drag = -sections.skin[k] * abs(u) * u
        resistance[k] = sections.added[k] / step + sections.cross[k] * abs(w)
        still = resistance[k] * (water[0] * nx + water[1] * ny + water[2] * nz)
        # Dorsal axis: n × t.
        yx, yy, yz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
        rise = vx * yx + vy * yy + vz * yz
        lift = -sections.heave[k] * abs(rise) * rise
        gx += momentum * ox + drag * tx + still * nx + lift * yx
        gy += momentum * oy + drag * ty + still * ny + lift * yy
        gz += momentum * oz + drag * tz + still * nz + lift * yz
        _push(load, k, rings, gx, gy, gz)
        if k < rings:
            a = 1 + 4 * k
            roll = zero  # speed of the upper half along n over that of the section
            for axis in range(3):
                upper = v[a, axis] + v[a + 1, axis] - v[a + 2, axis] - v[a + 3, axis]
                roll += 0.25 * upper * normal[k, axis]
            push = -0.25 * sections.cross[k] * abs(roll) * roll
            for axis in range(3):
                load[a, axis] += push * normal[k, axis]
                load[a + 1, axis] += push * normal[k, axis]
                load[a + 2, axis] -= push * normal[k, axis]
                load[a + 3, axis] -= push * normal[k, axis]


@kernel
def _push(load: Array, k: int, rings: int, fx: float, fy: float, fz: float) -> None:
    """Share a force on section k among its nodes."""
    first, count = 1 + 4 * k, 4 if k < rings else 2
    share = 1.0 / count
    for node in range(first, first + count):
        load[node, 0] += share * fx
        load[node, 1] += share * fy
        load[node, 2] += share * fz


@kernel
def section_means(columns: Array) -> None:
    """Write the columns c_k (30, 6) that average the nodes of the sections."""
    rings = columns.shape[1] - 1
    for node in range(len(columns)):
        for k in range(rings + 1):
            columns[node, k] = 0.0
    for k in range(rings):
        for node in range(1 + 4 * k, 5 + 4 * k):
            columns[node, k] = 0.25
    columns[1 + 4 * rings, rings] = 0.5
    columns[2 + 4 * rings, rings] = 0.5
