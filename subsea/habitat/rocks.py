"""The rocks of a scenario: single ones, and those of outcrops, ridges, arches and wrecks.

All are rows of `state.Sea.rocks` (k, 7): x, y, z and half axes a, b, c in cm, yaw in rad. They
never move, so a world lists once which are near each square cell of the seabed.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.vector import Vector
from subsea.kernels import kernel
from subsea.scenario.schema import Arch, Outcrop, Ridge, Rock, Scenario, Wreck

Floor = Callable[[float, float], float]  # x and y in cm -> height of the seabed in cm

STRIDE = 0.62  # distance of the rocks of a ridge over its width
GOLDEN = np.pi * (3.0 - 5.0**0.5)  # rad, from one rock of an outcrop to the next


def rock_rows(scenario: Scenario, floor: Floor) -> tuple[Array, list[str]]:
    """All rocks (k, 7), and the scenario table that each belongs to."""
    parts = [(f"`rock[{k}]`", single(rock, floor)) for k, rock in enumerate(scenario.rock)]
    parts += [(f"`outcrop[{k}]`", outcrop(one, floor)) for k, one in enumerate(scenario.outcrop)]
    parts += [(f"`ridge[{k}]`", ridge(one, floor)) for k, one in enumerate(scenario.ridge)]
    parts += [(f"`arch[{k}]`", arch(one, floor)) for k, one in enumerate(scenario.arch)]
    parts += [(f"`wreck[{k}]`", wreck(one, floor)) for k, one in enumerate(scenario.wreck)]
    rows = np.concatenate([np.zeros((0, 7))] + [part for _, part in parts])
    return rows, [name for name, part in parts for _ in part]


def single(rock: Rock, floor: Floor) -> Array:
    """One rock (1, 7)."""
    (x, y), (a, b, c) = rock.position_cm, rock.size_cm
    middle = c * (1.0 - 2.0 * rock.sunk) if rock.height_cm is None else rock.height_cm
    return np.array([[x, y, floor(x, y) + middle, a, b, c, np.radians(rock.yaw_deg)]])


def outcrop(one: Outcrop, floor: Floor) -> Array:
    """A knoll (k, 7): a large rock in the middle with smaller ones around and on it.

    All lie within its ellipse and below its height, and overlap the first.
    """
    rng = np.random.default_rng([one.seed, 0x0C])
    x, y = one.position_cm
    size = np.array(one.size_cm)
    yaw, turn = np.radians(one.yaw_deg), rng.uniform(0, 2 * np.pi)
    rows = [(0.0, 0.0, 0.12 * size[2], 0.66 * size[0], 0.66 * size[1], 0.80 * size[2], 0.0)]
    for k in range(1, one.rocks):
        turn += GOLDEN + rng.uniform(-0.3, 0.3)
        high = k % 3 == 0
        half = size * rng.uniform(0.26, 0.44, 3) * (0.85 if high else 1.0)
        # A rotated ellipsoid must still fit.
        away = rng.uniform(0.15, 0.35) if high else rng.uniform(0.80, 1.0)
        room = np.maximum(size[:2] - half[:2].max(), 0.0)
        low, top = (0.35, 1.0) if high else (0.0, 0.55)
        middle = rng.uniform(low, top) * (size[2] - half[2])
        spot = away * room * (np.cos(turn), np.sin(turn))
        rows.append((*spot, middle, *half, rng.uniform(-0.6, 0.6)))
    out = np.array(rows)
    out[:, :2] = _turned(out[:, :2], yaw) + (x, y)
    out[:, 2] += floor(x, y)
    out[:, 6] += yaw
    return out


def _turned(plan: Array, yaw: float) -> Array:
    """Turn points (n, 2) by ``yaw``, rad, not by BLAS, whose bits differ by processor."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = plan.T
    return np.stack([c * x - s * y, s * x + c * y], axis=1)


def ridge(one: Ridge, floor: Floor) -> Array:
    """A ridge (k, 7): large rocks along a winding line, others on its crest and at its foot.

    Each stands on the seabed below it. The crest is uneven, and comes down toward both ends.
    """
    rng = np.random.default_rng([one.seed, 0x21D6E])
    wide, high, yaw = one.width_cm, one.height_cm, np.radians(one.yaw_deg)
    number = max(int(np.ceil(one.length_cm / (STRIDE * wide))), 2)
    phase = rng.uniform(0, 2 * np.pi, 2)
    rows = []
    for along in np.linspace(-0.5, 0.5, number):
        bend = (
            0.28 * wide * (np.sin(7.0 * along + phase[0]) + 0.5 * np.sin(17.0 * along + phase[1]))
        )
        # The crest of the ridge here.
        top = high * (1.0 - 0.55 * (2.0 * along) ** 4) * rng.uniform(0.72, 1.0)
        a, b = wide * rng.uniform((0.48, 0.34), (0.62, 0.44))
        x = along * (one.length_cm - wide) + 0.08 * wide * rng.normal()
        rows.append((x, bend, 0.2 * top, a, b, 0.8 * top, rng.uniform(-0.35, 0.35)))
        # By turns a block on the crest, which may overhang, and boulders at the foot.
        side = float(rng.choice((-1.0, 1.0)))
        if len(rows) % 3 == 1:
            size = wide * rng.uniform((0.24, 0.22, 0.13), (0.36, 0.30, 0.2))
            size[2] = min(size[2], 0.35 * top)
            place = x + 0.2 * wide * rng.normal(), bend + side * 0.16 * wide, top - 0.7 * size[2]
        else:
            size = wide * rng.uniform((0.16, 0.14, 0.1), (0.3, 0.24, 0.2))
            place = x + 0.3 * wide * rng.normal(), bend + side * (b + 0.4 * size[1]), 0.3 * size[2]
        rows.append((*place, *size, rng.uniform(-0.8, 0.8)))
    out = np.array(rows)
    out[:, :2] = _turned(out[:, :2], yaw) + one.position_cm
    out[:, 2] += [floor(x, y) for x, y in out[:, :2]]
    out[:, 6] += yaw
    return out


def arch(one: Arch, floor: Floor) -> Array:
    """An arch (k, 7): rocks stacked up a leg, along the bow and down the other leg.

    Others lean on them from outside. The half ellipse of span and height between the legs is
    free.
    """
    rng = np.random.default_rng([one.seed, 0xA7])
    thick, yaw = one.thickness_cm, np.radians(one.yaw_deg)
    half, high = 0.5 * one.span_cm, one.height_cm
    line = np.linspace(0.0, np.pi, 400)
    steps = np.hypot(*np.diff([(half + thick) * np.cos(line), (high + thick) * np.sin(line)]))
    along = np.concatenate([[0.0], np.cumsum(steps)])
    number = max(int(np.ceil(along[-1] / (0.58 * thick))), 5)
    turns = list(np.interp(np.linspace(0.0, along[-1], number), along, line))
    rows = [_of_arch(t, 0.0, half, high, thick, rng) for t in turns]
    # Buttresses at the feet and blocks on the shoulders.
    for t in (0.1, 0.4, 0.9, 1.35, np.pi - 1.0, np.pi - 0.5, np.pi - 0.1):
        t, foot = t + rng.uniform(-0.12, 0.12), (1.0 - np.sin(t)) ** 2
        aside = rng.uniform(0.12, 0.3) + 0.35 * foot
        rows.append(_of_arch(t, aside, half, high, rng.uniform(0.8, 1.1) * thick, rng))
    out = np.array(rows)
    out[:, :2] = _turned(out[:, :2], yaw) + one.position_cm
    # Legs reach down to the sand.
    ground = floor(*one.position_cm)
    lower = np.array([min(floor(x, y) - ground, 0.0) for x, y in out[:, :2]])
    share = np.clip(1.0 - out[:, 2] / (0.6 * high), 0.0, 1.0)
    out[:, 2] += ground + share * lower
    out[:, 6] += yaw
    return out


def _of_arch(
    t: float, out: float, half: float, high: float, thick: float, rng: np.random.Generator
) -> list[float]:
    """A rock at the angle t of the opening's ellipse, `out` thicknesses outside of it."""
    up = np.sin(t)
    size = 0.5 * thick * rng.uniform(0.92, 1.25, 3)
    a = size[0] * (1.0 + 0.5 * up**6) * (1.0 + 0.3 * (1.0 - up) ** 2)
    b = 1.25 * size[1] * (1.0 + 0.3 * (1.0 - up) ** 2)
    c = size[2] * (1.0 + 0.5 * (1.0 - up) ** 2)
    # Its inner side just touches the opening.
    slope = np.array([np.cos(t) / half, up / high])
    slope /= np.linalg.norm(slope)
    reach = np.hypot(a * slope[0], c * slope[1]) + (0.03 + out) * thick
    x, z = half * np.cos(t) + reach * slope[0], high * up + reach * slope[1]
    across = rng.uniform(-0.22, 0.22) * thick * (1.0 + 2.0 * out)
    return [x, across, z, a, b, c, rng.uniform(-0.15, 0.15)]


# Of a wreck, over its length, its width and the height of its sides.
PLATES = 10  # of each side
SHEER = 0.35  # rise of the sides toward bow and stern, over their height
LEAST_CM = 22.0  # least half thickness: thinner ones are lost in what is drawn far away
MAST_AT, MAST_WIDE = 0.22, 0.016  # place and half thickness of the mast, over the length


def wreck(one: Wreck, floor: Floor) -> Array:
    """A wreck (k, 7): plates along both sides, a keel, decks fore and aft, a stem and a mast.

    Broken plates are low, and ribs stand where they were. The hold amidships is open. All parts
    stand on the plane of the seabed under the wreck, and reach into it.
    """
    rng = np.random.default_rng([one.seed, 0x5817])
    half, wide, high = 0.5 * one.length_cm, 0.5 * one.width_cm, one.height_cm
    thick = max(0.055 * one.width_cm, LEAST_CM)
    rows: list[tuple[float, ...]] = []
    places = np.linspace(-0.9, 0.86, PLATES)
    long = 0.8 * half * (places[1] - places[0])
    for side in (-1.0, 1.0):
        for along in places:
            beam = _beam(along) * wide
            turn = side * np.arctan2((_beam(along + 0.05) - _beam(along - 0.05)) * wide, 0.1 * half)
            top = high * (1.0 + SHEER * along**2)
            gone = abs(along) < 0.75 and rng.uniform() < one.broken
            up = top * (rng.uniform(0.3, 0.55) if gone else rng.uniform(0.94, 1.0))
            aside = side * (beam - thick)
            rows.append((along * half, aside, 0.35 * up, long, thick, 0.65 * up, turn))
            if gone:  # a rib that leans on the broken plate
                up = top * rng.uniform(0.7, 0.95)
                rib = 0.8 * thick, thick, 0.55 * up
                rows.append((along * half, aside - 0.5 * side * thick, 0.45 * up, *rib, turn))
    for along in np.arange(-0.85, 0.9, 0.14):  # the keel, buried
        keel = 0.13 * half, 0.8 * _beam(along) * wide, 0.16 * high
        rows.append((along * half, 0.0, 0.0, *keel, 0.0))
    for along, share, size in ((-0.72, 0.74, 0.26), (0.62, 0.72, 0.24)):  # decks aft and fore
        flat = size * half, 0.86 * _beam(along) * wide, max(0.09 * high, LEAST_CM)
        rows.append((along * half, 0.0, share * high, *flat, 0.0))
    house = 0.15 * half, 0.52 * wide, 0.42 * high
    rows.append((-0.74 * half, 0.0, 1.05 * high, *house, 0.0))
    stem = 0.06 * half, thick, 0.72 * high * (1.0 + SHEER)
    rows.append((0.97 * half, 0.0, 0.32 * high, *stem, 0.0))
    for step in range(3):  # the bowsprit
        spar = half * (1.02 + 0.07 * step), 0.0, high * (1.0 + SHEER) * (0.92 + 0.09 * step)
        rows.append((*spar, 0.06 * half, 0.8 * thick, 0.8 * thick, 0.0))
    if one.mast_cm > high:
        pole = max(MAST_WIDE * one.length_cm, LEAST_CM)
        section = 0.5 * one.mast_cm
        rows += [
            (MAST_AT * half, 0.0, k * section, pole, pole, 0.62 * section, 0.0) for k in (0.4, 1.38)
        ]
        yard = pole, 0.95 * wide, 0.8 * pole
        rows.append((MAST_AT * half, 0.0, 0.74 * one.mast_cm, *yard, rng.uniform(-0.3, 0.3)))
        fallen = 0.42 * half, pole, pole  # the other mast lies over the side
        lies = rng.choice((-1.0, 1.0))
        rows.append((-0.25 * half, 0.7 * lies * wide, 0.6 * high, *fallen, lies * 0.9))
    out = np.array(rows)
    yaw, (x, y) = np.radians(one.yaw_deg), one.position_cm
    bow = np.array([np.cos(yaw), np.sin(yaw)])
    ends = [floor(*(np.array([x, y]) + share * half * bow)) for share in (-0.7, 0.7)]
    out[:, 2] += np.interp(out[:, 0] / half, (-0.7, 0.7), ends)
    out[:, :2] = _turned(out[:, :2], yaw) + (x, y)
    out[:, 6] += yaw
    return out


def _beam(along: float) -> float:
    """Half width of a hull, over the largest, from its stern at -1 to its bow at 1."""
    end = min(abs(along), 1.0)
    return float(1.0 - end**2.4 if along > 0.0 else 1.0 - 0.45 * end**3)


CELL_CM = 200.0
FEW = 8  # rocks that are faster gone through than looked up
FELT_CM = 200.0  # gap from a rock within which it changes the current
# Columns of `RockCells.near` behind the seven of a rock.
COSINE, SINE, WIDE, WIDE_SQUARE, TALL_SQUARE, FELT, LISTED = range(7, 14)


class RockCells(NamedTuple):
    """The rocks near each of columns x rows square cells, which cover all places near a rock."""

    west: float  # cm, of the first column
    south: float  # cm, of the first row
    columns: int
    rows: int
    first: Ints  # (cells + 1,) where the rocks of each cell begin in `near`
    near: Array  # (m, 13) rows of `Sea.rocks`, of each cell in their order; all if they are few.
    # The other columns are cosine and sine of the yaw, and what `is_felt` needs.


@kernel
def rock_cells(rocks: Array, reach: float) -> RockCells:
    """List the `rocks` (k, 7) that are within `reach` cm of each cell, level and by their boxes."""
    if len(rocks) <= FEW:
        few = np.empty((len(rocks), LISTED))
        for k in range(len(rocks)):
            _list_rock(few[k], rocks[k])
        return RockCells(0.0, 0.0, 0, 0, np.zeros(1, np.int64), few)
    west, south, east, north = math.inf, math.inf, -math.inf, -math.inf
    for k in range(len(rocks)):
        far = max(rocks[k, 3], rocks[k, 4]) + reach
        west, east = min(west, rocks[k, 0] - far), max(east, rocks[k, 0] + far)
        south, north = min(south, rocks[k, 1] - far), max(north, rocks[k, 1] + far)
    columns = int((east - west) / CELL_CM) + 1
    rows = int((north - south) / CELL_CM) + 1
    first = np.zeros(columns * rows + 1, np.int64)
    box = np.empty((len(rocks), 4), np.int64)
    for k in range(len(rocks)):
        far = max(rocks[k, 3], rocks[k, 4]) + reach
        box[k, 0] = int((rocks[k, 0] - far - west) / CELL_CM)
        box[k, 1] = int((rocks[k, 0] + far - west) / CELL_CM)
        box[k, 2] = int((rocks[k, 1] - far - south) / CELL_CM)
        box[k, 3] = int((rocks[k, 1] + far - south) / CELL_CM)
        for row in range(box[k, 2], box[k, 3] + 1):
            for column in range(box[k, 0], box[k, 1] + 1):
                first[row * columns + column + 1] += 1
    for cell in range(columns * rows):
        first[cell + 1] += first[cell]
    near, filled = np.empty((first[-1], LISTED)), first[:-1].copy()
    for k in range(len(rocks)):
        for row in range(box[k, 2], box[k, 3] + 1):
            for column in range(box[k, 0], box[k, 1] + 1):
                slot = filled[row * columns + column]
                _list_rock(near[slot], rocks[k])
                filled[row * columns + column] += 1
    return RockCells(west, south, columns, rows, first, near)


@kernel
def _list_rock(row: Array, rock: Array) -> None:
    """Write a rock (7,) and what follows from it to `row` (13,)."""
    for item in range(7):
        row[item] = rock[item]
    row[COSINE], row[SINE] = math.cos(rock[6]), math.sin(rock[6])
    size = 1.0 + FELT_CM / min(rock[3], rock[4], rock[5])
    wide = max(rock[3], rock[4])
    wide_square, tall_square = wide * wide, rock[5] * rock[5]
    row[WIDE], row[WIDE_SQUARE], row[TALL_SQUARE] = wide, wide_square, tall_square
    row[FELT] = 1.000001 * size * size * wide_square * tall_square


@kernel
def is_felt(row: Array, p: Vector) -> bool:
    """True if a listed rock (13,) may change the current at p: `far_from_rock`, prepared."""
    x, y, z = p[0] - row[0], p[1] - row[1], p[2] - row[2]
    return bool((x * x + y * y) * row[TALL_SQUARE] + z * z * row[WIDE_SQUARE] <= row[FELT])


@kernel
def rocks_near(cells: RockCells, p: Vector) -> Array:
    """Rows (j, 13) of the rocks at p: all within the reach of the cells, and some farther."""
    if cells.columns == 0:
        return cells.near
    x, y = (p[0] - cells.west) / CELL_CM, (p[1] - cells.south) / CELL_CM
    if x < 0.0 or y < 0.0 or x >= cells.columns or y >= cells.rows:
        return cells.near[:0]
    cell = int(y) * cells.columns + int(x)
    return cells.near[cells.first[cell] : cells.first[cell + 1]]
