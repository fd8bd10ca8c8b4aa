"""Odours in the water: bait, blood and the alarm substance of wounded prey.

The current carries them through a grid of cells, they spread and decay, and stone stops them. The
scheme is conservative: what leaves a cell through a face enters the next one. Fluxes are upwind
with the limiter of van Leer (J. Comput. Phys. 14:361, 1974), so no amount becomes negative.
"""

import math

import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.geometry.solids import height_at
from subsea.geometry.vector import Vector
from subsea.habitat.contact import is_free
from subsea.kernels import kernel
from subsea.state import ALARM, BAIT_ODOUR, BLOOD, HANGING, ODOURS, SINKING, Odour, Sea, empty

CELL_CM = 125.0  # side of a cell ...
MOST_CELLS = 60_000  # ... unless the sea has more of them: then cells are larger
STEP_TICKS = 8  # between two steps
SPREAD_CM2_S = 40.0, 40.0, 15.0  # turbulent diffusion along x, y and z, at a scale of metres
LIFE_S = np.array([240.0, 120.0, 60.0])  # time in which an odour decays to 1/e
LEAST_TOTAL = 1e-3  # amount of an odour below which it is gone
CATCH = 1.0  # amount of blood, and of alarm substance, of a fish that is eaten
BAIT_PER_S = 0.05  # amount that a bait gives off
M3 = 1e-6  # of a cubic centimetre
SOLVER_STEPS, SOLVED = 400, 1e-4  # of the flow around stones: most steps, and relative residual


def no_odour() -> Odour:
    """Make the odours of a sea in which nothing smells: no arrays."""
    return empty(Odour, o=0, x=0, y=0, z=0)


def make_odour(sea: Sea) -> Odour:
    """Make the clean water of a sea in which odours may be released."""
    cell, corner, size = _grid(sea)
    water = free_cells(sea, cell, corner, size)
    flux = flow_fields(water)
    nz, ny, nx = (int(n) for n in size)
    given = {"cell_cm": cell, "corner": corner, "water": water, "flux": flux}
    return empty(Odour, given=given, o=len(ODOURS), x=nx, y=ny, z=nz)


def _grid(sea: Sea) -> tuple[float, Array, Array]:
    """Lay the grid over a sea: side of a cell, lowest corner (3,), cells along z, y and x.

    An outermost ring of cells lies beyond the sea, where odours are lost.
    """
    deep = max(-float(sea.heights.min()), CELL_CM)
    cell = max(CELL_CM, (4.0 * sea.radius**2 * deep / MOST_CELLS) ** (1.0 / 3.0))
    across, down = math.ceil(2.0 * sea.radius / cell) + 2, math.ceil(deep / cell)
    corner = np.array([-0.5 * across * cell, -0.5 * across * cell, -down * cell])
    return cell, corner, np.array([down, across, across])


@kernel
def free_cells(sea: Sea, cell: float, corner: Array, size: Array) -> Bools:
    """Select the cells (z, y, x) whose middle is water."""
    water = np.zeros((size[0], size[1], size[2]), np.bool_)
    for k in range(size[0]):
        for j in range(size[1]):
            for i in range(size[2]):
                x, y = corner[0] + (i + 0.5) * cell, corner[1] + (j + 0.5) * cell
                z = corner[2] + (k + 0.5) * cell
                above = z > height_at(sea.heights, sea.half_width, x, y)
                water[k, j, i] = above and is_free(sea.pillars, sea.rocks, (x, y, z))
    return water


@kernel
def flow_fields(water: Bools) -> Array:
    """Compute the flows around the solids of a grid, for a unit flow along x and one along y.

    Returns the velocities (2, 3, z, y, x) through the east, north and upper face of each cell. They
    are those of the potential flow: the unit flow less the gradient of a pressure that leaves no
    divergence. The outermost ring has none.
    """
    nz, ny, nx = water.shape
    flux = np.zeros((2, 3, nz, ny, nx), np.float32)
    for way in range(2):
        for k in range(nz):
            for j in range(ny):
                for i in range(nx):
                    east = i + 1 < nx and way == 0
                    north = j + 1 < ny and way == 1
                    if east and water[k, j, i] and water[k, j, i + 1]:
                        flux[way, 0, k, j, i] = 1.0
                    if north and water[k, j, i] and water[k, j + 1, i]:
                        flux[way, 1, k, j, i] = 1.0
        pressure = _pressure(water, flux[way])
        for k in range(nz):
            for j in range(ny):
                for i in range(nx):
                    if not water[k, j, i]:
                        continue
                    here = pressure[k, j, i]
                    if i + 1 < nx and water[k, j, i + 1]:
                        flux[way, 0, k, j, i] -= pressure[k, j, i + 1] - here
                    if j + 1 < ny and water[k, j + 1, i]:
                        flux[way, 1, k, j, i] -= pressure[k, j + 1, i] - here
                    if k + 1 < nz and water[k + 1, j, i]:
                        flux[way, 2, k, j, i] -= pressure[k + 1, j, i] - here
    return flux


@kernel
def outflow(flux: Array, k: int, j: int, i: int) -> float:
    """Sum the velocities `flux` (3, z, y, x) out of a cell inside the outermost ring."""
    total = float(flux[0, k, j, i]) - float(flux[0, k, j, i - 1])
    total += float(flux[1, k, j, i]) - float(flux[1, k, j - 1, i])
    total += float(flux[2, k, j, i])
    return total - (float(flux[2, k - 1, j, i]) if k > 0 else 0.0)


@kernel
def _pressure(water: Bools, flux: Array) -> Array:
    """Solve for the pressure (z, y, x) whose gradient has the divergence of `flux`.

    Conjugate gradients. The pressure is zero in the outermost ring, and no flow enters a solid.
    """
    nz, ny, nx = water.shape
    pressure, residual = np.zeros((nz, ny, nx)), np.zeros((nz, ny, nx))
    power = 0.0
    for k in range(nz):
        for j in range(1, ny - 1):
            for i in range(1, nx - 1):
                if water[k, j, i]:
                    residual[k, j, i] = -outflow(flux, k, j, i)
                    power += residual[k, j, i] ** 2
    first, way, image = power, residual.copy(), np.zeros((nz, ny, nx))
    for _ in range(SOLVER_STEPS):
        if power <= SOLVED * SOLVED * first or power == 0.0:
            break
        steep = 0.0
        for k in range(nz):
            for j in range(1, ny - 1):
                for i in range(1, nx - 1):
                    if water[k, j, i]:
                        image[k, j, i] = _laplacian(water, way, k, j, i)
                        steep += image[k, j, i] * way[k, j, i]
        share, power_before, power = power / steep, power, 0.0
        for k in range(nz):
            for j in range(1, ny - 1):
                for i in range(1, nx - 1):
                    if water[k, j, i]:
                        pressure[k, j, i] += share * way[k, j, i]
                        residual[k, j, i] -= share * image[k, j, i]
                        power += residual[k, j, i] ** 2
        for k in range(nz):
            for j in range(1, ny - 1):
                for i in range(1, nx - 1):
                    if water[k, j, i]:
                        way[k, j, i] = residual[k, j, i] + power / power_before * way[k, j, i]
    return pressure


@kernel
def _laplacian(water: Bools, p: Array, k: int, j: int, i: int) -> float:
    """Sum the differences of p at a cell from that of its neighbours of water."""
    total, here = 0.0, p[k, j, i]
    if water[k, j, i - 1]:
        total += here - p[k, j, i - 1]
    if water[k, j, i + 1]:
        total += here - p[k, j, i + 1]
    if water[k, j - 1, i]:
        total += here - p[k, j - 1, i]
    if water[k, j + 1, i]:
        total += here - p[k, j + 1, i]
    if k > 0 and water[k - 1, j, i]:
        total += here - p[k - 1, j, i]
    if k + 1 < water.shape[0] and water[k + 1, j, i]:
        total += here - p[k + 1, j, i]
    return total


@kernel
def release(odour: Odour, channel: int, amount: float, place: Vector) -> None:
    """Add an amount of an odour to the cell at a place, cm, or to the nearest one of water."""
    nz, ny, nx = odour.water.shape
    x = (place[0] - odour.corner[0]) / odour.cell_cm
    y = (place[1] - odour.corner[1]) / odour.cell_cm
    z = (place[2] - odour.corner[2]) / odour.cell_cm
    i, j, k = int(np.floor(x)), int(np.floor(y)), int(np.floor(z))
    best, least = (-1, -1, -1), np.inf
    for c in range(max(k - 1, 0), min(k + 2, nz)):
        for b in range(max(j - 1, 0), min(j + 2, ny)):
            for a in range(max(i - 1, 0), min(i + 2, nx)):
                far = (a + 0.5 - x) ** 2 + (b + 0.5 - y) ** 2 + (c + 0.5 - z) ** 2
                if odour.water[c, b, a] and far < least:
                    best, least = (c, b, a), far
    if best[0] >= 0:
        volume = odour.cell_cm**3 * M3
        odour.amount[channel, best[0], best[1], best[2]] += np.float32(amount / volume)
        odour.total[channel] += amount


@kernel
def carry_odours(odour: Odour, radius: float, flow: Array, dt: float) -> None:
    """Carry, spread and decay all odours for `dt` s in a uniform current `flow` (3,), cm/s.

    What reaches the edge of the sea, a cylinder of `radius` cm, is lost.
    """
    for channel in range(len(odour.total)):
        if odour.total[channel] > 0.0:
            amount = odour.amount[channel]
            _carry(odour, amount, flow, dt)
            left = math.exp(-dt / LIFE_S[channel])
            odour.total[channel] = _decay(odour, amount, radius, left)


@kernel
def _carry(odour: Odour, amount: Array, flow: Array, dt: float) -> None:
    """Move what the current and diffusion carry through each face in `dt` s."""
    nz, ny, nx = amount.shape
    change = np.zeros((nz, ny, nx), np.float32)
    share = dt / odour.cell_cm
    for axis in range(3):
        c, b, a = int(axis == 2), int(axis == 1), int(axis == 0)  # the step to the next cell
        spread = SPREAD_CM2_S[axis] / odour.cell_cm
        for k in range(nz - c):
            for j in range(ny - b):
                for i in range(nx - a):
                    low, high = amount[k, j, i], amount[k + c, j + b, i + a]
                    if low == 0.0 and high == 0.0:
                        continue
                    if not odour.water[k, j, i] or not odour.water[k + c, j + b, i + a]:
                        continue
                    speed = flow[0] * odour.flux[0, axis, k, j, i]
                    speed += flow[1] * odour.flux[1, axis, k, j, i]
                    if speed >= 0.0:
                        inside = k >= c and j >= b and i >= a
                        before = amount[k - c, j - b, i - a] if inside else low
                        carried = _upwind(before, low, high, speed * share)
                    else:
                        inside = k + 2 * c < nz and j + 2 * b < ny and i + 2 * a < nx
                        before = amount[k + 2 * c, j + 2 * b, i + 2 * a] if inside else high
                        carried = _upwind(before, high, low, -speed * share)
                    moved = np.float32(share * (speed * carried - spread * (high - low)))
                    change[k, j, i] -= moved
                    change[k + c, j + b, i + a] += moved
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                amount[k, j, i] = max(amount[k, j, i] + change[k, j, i], np.float32(0.0))


@kernel
def _upwind(before: float, here: float, ahead: float, courant: float) -> float:
    """The amount that the current carries out of a cell toward the next, limited by van Leer."""
    rise, steep = ahead - here, here - before
    if rise * steep <= 0.0:
        return here
    return here + (1.0 - courant) * rise * steep / (rise + steep)


@kernel
def _decay(odour: Odour, amount: Array, radius: float, left: float) -> float:
    """Leave the share `left` of an odour, none outside of the sea; returns the total amount."""
    nz, ny, nx = amount.shape
    total = 0.0
    for k in range(nz):
        for j in range(ny):
            y = odour.corner[1] + (j + 0.5) * odour.cell_cm
            for i in range(nx):
                x = odour.corner[0] + (i + 0.5) * odour.cell_cm
                within = x * x + y * y < radius * radius
                amount[k, j, i] *= np.float32(left if within else 0.0)
                total += amount[k, j, i]
    total *= odour.cell_cm**3 * M3
    if total < LEAST_TOTAL:
        amount[:] = 0.0
        return 0.0
    return total


def release_bait(odour: Odour, sea: Sea, dt: float) -> None:
    """Let a bait that hangs in the water smell for `dt` s."""
    if len(odour.total) and sea.catch[0] in (SINKING, HANGING):
        x, y, z = (float(p) for p in sea.hook)
        release(odour, BAIT_ODOUR, BAIT_PER_S * dt, (x, y, z))


def release_catches(odour: Odour, places: Array) -> None:
    """Release blood and alarm substance where fishes are eaten: `places` (k, 3), cm."""
    if not len(odour.total):
        return
    for place in places:
        x, y, z = (float(p) for p in place)
        release(odour, BLOOD, CATCH, (x, y, z))
        release(odour, ALARM, CATCH, (x, y, z))
