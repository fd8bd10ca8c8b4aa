"""Shapes of corals, sponges and anemones: meshes of size 1 at five or six levels of detail.

The number of a variant seeds it, so its levels are of one growth: coarser ones leave small parts
out and make the others thicker.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.base.disk_cache import cached
from subsea.habitat.reef import KINDS
from subsea.habitat.terrain import HEIGHT, dome, outline
from subsea.rendering.reef.coral_mesh import (
    UP,
    Branches,
    CoralMesh,
    Rng,
    bumps,
    capped,
    fitted,
    grow_offshoots,
    grow_stems,
    joined,
    out_share,
    plates,
    pointed,
    single,
    thicket_light,
    together,
    tubes,
    turned,
    unit,
    welded,
)


def staghorn(rng: Rng, level: int) -> CoralMesh:
    """Antlers: stems, boughs on them, and twigs with pale ends."""
    stems = grow_stems(rng, 7, 1.5, 0.5, 0.062)
    boughs = grow_offshoots(rng, stems, 3, 0.8, 0.35, 0.8, 0.45)
    twigs = grow_offshoots(rng, boughs, 3, 0.75, 0.4, 0.72, 0.3)
    if level == 0:
        return together(stems, boughs, twigs).tubes(4, 8, True, pale=0.45)
    if level == 1:
        return together(stems, boughs, twigs).tubes(2, 5, False, 1.1, pale=0.45)
    if level == 2:
        few = twigs.taken(np.arange(0, len(twigs.length), 2))
        return together(boughs, few).tubes(2, 3, False, 1.5, pale=0.2)
    few = twigs.taken(np.arange(0, len(twigs.length), 5))
    few = few._replace(
        start=0.4 * few.start, way=unit(few.start + 0.4 * few.way), length=0.75 + 0 * few.length
    )
    return few.spikes(0.0, 3.2, pale=0.3) if level == 4 else few.tubes(2, 3, False, 2.2, pale=0.3)


def bush(rng: Rng, level: int) -> CoralMesh:
    """A cushion of short fingers, each with a knobbly pale head."""
    number = 72
    k = np.arange(number) + 0.5
    z = 1.0 - 0.98 * k / number
    turn = k * 2.39996 + rng.uniform(-0.35, 0.35, number)
    r = np.sqrt(1.0 - z * z)
    way = unit(
        np.stack([r * np.cos(turn), r * np.sin(turn), 0.9 * z + 0.12], axis=1)
        + rng.normal(0, 0.1, (number, 3))
    )
    far = 1.0 + 0.3 * bumps(rng, way, 1.7) + rng.uniform(-0.1, 0.1, number)
    thick = rng.uniform(0.8, 1.2, number)
    fingers = Branches(
        0.3 * way, way, far - 0.35, 0.1 * rng.normal(size=(number, 3)) + 0.12 * UP,
        thick[:, None] * np.array([0.07, 0.105]), np.zeros(number),
    )  # fmt: skip
    if level == 0:
        return fingers.tubes(2, 8, True, pale=0.4, dark=0.12)
    if level == 1:
        return fingers.tubes(2, 5, False, 1.1, pale=0.4, dark=0.12)
    few = fingers.taken(np.arange(0, number, 2 if level == 2 else 6))
    if level == 4:
        return few.spikes(0.85, 2.7, pale=0.0, dark=0.3)
    return few.tubes(2, 3, False, 1.5 if level == 2 else 2.5, pale=0.25, dark=0.15)


def finger(rng: Rng, level: int) -> CoralMesh:
    """Soft fingers with round ends on a lobed foot."""
    stems = grow_stems(rng, 9, 1.1, 0.55, 0.13)
    knobs = grow_offshoots(rng, stems, 3, 0.7, 0.5, 0.85, 0.4)
    both = together(stems, knobs)
    if level == 0:
        return both.tubes(5, 10, True, pale=0.3, sway=0.5, dark=0.25)
    if level == 1:
        return both.tubes(2, 5, True, pale=0.1, sway=0.5, dark=0.25)
    few = knobs.taken(np.arange(0, len(knobs.length), (2, 3, 5)[level - 2]))
    few = few._replace(length=few.length + 0.2, start=few.start - 0.2 * few.way)
    sides, thicker = ((4, 1.25), (3, 1.25), (3, 1.6))[level - 2]
    return few.tubes(2, sides, False, thicker, pale=0.1, sway=0.5, dark=0.25)


def soft(rng: Rng, level: int) -> CoralMesh:
    """A soft tree: pale swollen trunk and boughs, and bunches of bright polyps on them."""
    trunk = grow_stems(rng, 1, 0.2, 0.7, 0.13)
    trunk = trunk._replace(
        start=np.array([[0.0, 0.0, -0.05]]), bend=0.15 * rng.normal(size=(1, 3)) * (1, 1, 0)
    )
    boughs = grow_offshoots(rng, trunk, 11, 1.3, 0.15, 0.62, 0.12)
    boughs = boughs._replace(length=rng.uniform(0.5, 0.75, 11) * (1.2 - 0.05 * np.arange(11)))
    twigs = grow_offshoots(rng, boughs, 4, 1.0, 0.25, 0.6, 0.45)
    twigs = twigs._replace(length=0.55 * twigs.length)
    bunches, per = len(twigs.length), 9
    ends = twigs.at(np.ones((bunches, 1)))
    heads = (
        ends
        + 0.13 * unit(rng.normal(size=(bunches, per, 3))) * rng.uniform(0.5, 1.2, (bunches, per, 1))
    ).reshape(-1, 3)
    size = rng.uniform(0.042, 0.075, len(heads))
    if level == 0:
        parts = (trunk, 7), (together(boughs, twigs), 5)  # most twigs are under buds
        stem = joined(
            *(one.tubes(3, sides, False, sway=0.7, pale=1.5, dark=0.5) for one, sides in parts)
        )
    else:
        few = boughs.taken(np.arange(0, 11, (1, 1, 2, 6)[level - 1]))
        sides = 4 if level == 1 else 3
        stem = together(trunk, few).tubes(2, sides, False, sway=0.7, pale=1.5)
    step, larger = ((1, 1.0), (2, 1.4), (9, 2.7), (25, 4.2), (40, 4.6))[level]
    heads, size = heads[::step], larger * size[::step]
    # Spindles that stand out from their bunch.
    out = unit(unit(heads - np.array([0.0, 0.0, 0.6])) + 0.5 * rng.normal(size=heads.shape))
    # From pole to pole; near ones are round.
    shares = np.array([0.0, 0.25, 0.7, 1.0] if level == 0 else [0.0, 0.48, 1.0])
    wide = np.array([0.0, 0.66, 0.6, 0.0] if level == 0 else [0.0, 0.75, 0.0])
    path = heads[:, None] + (size[:, None] * (2.4 * shares - 0.9))[..., None] * out[:, None]
    radius = size[:, None] * wide
    bulbs = tubes(
        path, radius, (5, 4, 3, 3, 3)[level], tip=0.8 + 0.2 * shares,
        light=thicket_light(path, 0.45), sway=0.7 * out_share(path),
    )  # fmt: skip
    return joined(stem, bulbs)


def fan(rng: Rng, level: int) -> CoralMesh:
    """A flat fan of twigs that fork repeatedly in one plane, across the current."""
    start = np.array([[-0.02, -0.05], [0.0, -0.05], [0.02, -0.05]])
    angle = np.array([-0.75, 0.05, 0.7])
    length, number, twigs = 0.26, 3, []
    widths = (0.04, 0.032, 0.026, 0.022, 0.019, 0.017, 0.015, 0.014, 0.013)
    lean = rng.normal(0.0, 0.12)
    for order, width in enumerate(widths):
        way = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        run = length * rng.uniform(0.75, 1.25, number)[:, None]
        end = start + run * way
        same = np.tile([width, widths[min(order + 1, 8)], order], (number, 1))
        twigs.append(np.column_stack([start, end, same]))
        rough = 0.9 + 0.07 * rng.normal(size=number)
        inside = np.hypot(end[:, 0] - lean, (end[:, 1] - 0.85) / 0.95) < rough
        fork = 1 + (rng.uniform(size=number) < (1.0 if order < 2 else 0.62))
        keep = inside | (order < 4)
        start, angle, fork = end[keep], angle[keep], fork[keep]
        spread = (0.42 if order < 3 else 0.34) * rng.uniform(0.6, 1.4, len(angle))
        side = np.where(rng.uniform(size=len(angle)) < 0.5, -1.0, 1.0)
        start = np.concatenate([start, start[fork == 2]])
        bent = angle + side * np.where(fork == 2, spread, 0.4 * spread)
        angle = 0.93 * np.concatenate([bent, (angle - side * spread)[fork == 2]])
        number, length = len(angle), 0.86 * length if order < 3 else 0.93 * length
    rows = np.concatenate(twigs)
    orders = (9, 7, 5, 4, 3)[level]
    rows = rows[rows[:, 6] < orders]
    if level:  # thicker, because fewer
        rows[:, 4:6] *= (1.0, 1.4, 2.4, 3.4, 3.7)[level]
    if level > 2:  # the last twigs are spikes
        rows[rows[:, 6] == orders - 1, 4:6] *= (1.4, 0.0)
    share = np.array([0.0, 1.0])[None, :, None]
    flat = rows[:, None, 0:2] + share * (rows[:, None, 2:4] - rows[:, None, 0:2])
    warp = 0.09 * np.sin(2.2 * flat[..., 0] + rng.uniform(0, 6)) * flat[..., 1]
    path = np.stack([flat[..., 0], warp, flat[..., 1]], axis=-1)
    radius = rows[:, 4:5] + share[..., 0] * (rows[:, 5:6] - rows[:, 4:5])
    tip = np.clip((path[..., 2] - 0.2) / 1.2, 0.0, 1.0)
    return tubes(
        path, radius, 4 if level == 0 else 3, tip=tip, light=0.75 + 0.25 * tip, sway=out_share(path)
    )


def rubble(rng: Rng, level: int) -> CoralMesh:
    """Dead, broken branches lying about."""
    number = (22, 14, 8, 4, 3)[level]
    turn, far = rng.uniform(0, 2 * np.pi, 22), np.sqrt(rng.uniform(0, 1, 22)) * 0.8
    at = np.stack([far * np.cos(turn), far * np.sin(turn), 0.02 + rng.uniform(0, 0.03, 22)], axis=1)
    lie = rng.uniform(0, 2 * np.pi, 22)
    way = np.stack([np.cos(lie), np.sin(lie), rng.normal(0.0, 0.25, 22)], axis=1)
    size = rng.uniform(0.025, 0.055, 22)
    long = rng.uniform(0.12, 0.4, 22)
    sticks = Branches(
        at - 0.5 * long[:, None] * way, unit(way), long,
        0.15 * rng.normal(size=(22, 3)) * (1, 1, 0.3),
        size[:, None] * np.array([1.0, 0.7]), np.zeros(22),
    ).taken(np.arange(number))  # fmt: skip
    return sticks.tubes(
        2, 4 if level == 0 else 3, False, (1.0, 1.2, 1.5, 2.0, 2.2)[level], pale=0.3, dark=0.7
    )


def table(rng: Rng, level: int) -> CoralMesh:
    """Flat plates on a short stem, one above another, with a finely branched rim."""
    columns = (120, 40, 18, 10, 7)[level]
    parts = []
    for tier in range(1 + int(rng.integers(0, 3))):
        wide = 1.0 if tier == 0 else rng.uniform(0.45, 0.7)
        off = np.zeros(2) if tier == 0 else rng.uniform(-0.35, 0.35, 2)
        z = 0.62 if tier == 0 else 0.62 + 0.2 * tier
        parts.append(_plate(rng, level, columns, wide, off, z))
    return joined(*parts)


def _plate(rng: Rng, level: int, columns: int, wide: float, off: Array, z: float) -> CoralMesh:
    turn = np.linspace(0.0, 2 * np.pi, columns + 1)
    lobes = 1.0 + 0.0 * turn
    for wave in (1, 2, 3, 5, 8):
        lobes += rng.uniform(0.0, 0.3 / wave) * np.sin(wave * turn + rng.uniform(0, 6.28))
    seed = int(rng.integers(2**31))
    jag = np.random.default_rng(seed).uniform(0.0, 1.0, columns + 1)
    jag[-1] = jag[0]
    jag = (
        1.0
        + (0.03, 0.02, 0.0, 0.0, 0.0)[level] * (np.arange(columns + 1) % 2 - 0.5)
        + 0.045 * (jag - 0.5)
    )
    # Stem up, under the plate outward, round the rim, and inward on the top.
    r = np.array([0.2, 0.13, 0.2, 0.55, 0.96, 1.0, 0.9, 0.5, 0.0])
    h = np.array([-0.62, -0.3, -0.13, -0.075, -0.03, 0.0, 0.025, 0.0, -0.02])
    light = np.array([0.25, 0.2, 0.25, 0.4, 0.6, 1.0, 0.95, 0.8, 0.7])
    pale = np.array([0.0, 0.0, 0.0, 0.1, 0.8, 1.0, 0.45, 0.1, 0.0])
    if level >= 2:
        keep = [0, 1, 3, 5, 6, 8] if level == 2 else [1, 5, 6, 8]
        r, h, light, pale = r[keep], h[keep], light[keep], pale[keep]
        light = 0.5 + 0.5 * light  # a dark underside would draw a line about the plate
    outer = (r > 0.3)[:, None]
    reach = wide * r[:, None] * np.where(outer, lobes * np.where((r > 0.9)[:, None], jag, 1.0), 1.0)
    tilt = rng.normal(0.0, 0.07, 2)
    rise = np.where(h < -0.2, h * z / 0.62, h)[:, None] + 0.0 * reach
    x, y = reach * np.cos(turn), reach * np.sin(turn)
    wave = 0.06 * bumps(rng, np.stack([x, y, 0 * x], axis=-1), 0.9) * r[:, None]
    rise = rise + np.where(
        h[:, None] > -0.2, tilt[0] * x + tilt[1] * y + 0.1 * reach**2 + wave, 0.0
    )
    mesh = turned(reach, rise + z, light=light[:, None], tip=pale[:, None])
    shift = np.append(off, 0.0) * np.clip(mesh.place[:, 2:] / z, 0.0, 1.0)
    mesh = mesh._replace(place=mesh.place + shift)
    number = (300, 60, 0, 0, 0)[level]
    if not number:
        return mesh
    # Branchlets stand all over the top, closest together at the rim.
    fine = np.random.default_rng(seed)
    out, way = fine.uniform(0.05, 1.0, number) ** 0.4 * 0.98, fine.uniform(0.0, 2 * np.pi, number)
    rim = wide * np.interp(way, turn, lobes) * out
    x, y = rim * np.cos(way), rim * np.sin(way)
    base = np.stack(
        [x, y, z - 0.015 + tilt[0] * x + tilt[1] * y + 0.1 * rim**2], axis=1
    ) + np.append(off, 0.0)
    high = fine.uniform(0.03, 0.075, number) * wide**0.5
    far = 1.3 * out**3
    lean = np.stack([far * np.cos(way), far * np.sin(way), np.ones(number)], axis=1)
    path = base[:, None] + np.array([-0.02, 1.0])[:, None] * (high[:, None] * lean)[:, None]
    size = 0.026 * fine.uniform(0.8, 1.3, (number, 1)) * np.array([1.0, 0.0])
    twigs = tubes(path, size, 3, tip=np.array([0.1, 0.7]), light=np.array([0.7, 1.0]))
    return joined(mesh, twigs)


def brain(rng: Rng, level: int) -> CoralMesh:
    """A lumpy dome that overhangs its foot a little; its ridges are texture."""
    columns, rings = ((46, 23), (20, 10), (10, 5), (7, 4), (6, 4))[level]
    down = np.linspace(np.radians(112.0), 0.0, rings)[:, None]
    turn = np.linspace(0.0, 2 * np.pi, columns + 1)
    down = down + 0 * turn
    way = np.stack(
        [np.sin(down) * np.cos(turn), np.sin(down) * np.sin(turn), np.cos(down)], axis=-1
    )
    swell = (
        1.0
        + 0.1 * bumps(rng, way, 2.6)
        + 0.1 * bumps(rng, way, 1.1, 1)
        + 0.1 * np.sin(down) ** 2 * np.cos(2 * turn + rng.uniform(0, 6))
    )
    reach, height = swell * np.sin(down), swell * np.cos(down) * 0.8
    light = np.clip(0.25 + 0.9 * (np.cos(down) + 0.25), 0.2, 1.0)
    mesh = turned(reach, height + 0.22, light=light, tip=np.clip(np.cos(down), 0, 1) * 0.5)
    flat = np.stack([down * np.cos(turn), down * np.sin(turn)], axis=-1)
    return mesh._replace(along=flat.reshape(-1, 2))


def lettuce(rng: Rng, level: int) -> CoralMesh:
    """A ruffled plate wound about itself, wider and lower with each turn."""
    c, r = ((130, 8), (52, 4), (22, 2), (11, 2), (9, 2))[level]
    far = np.linspace(0.0, 1.0, c)[None, None, :]
    out = np.linspace(0.0, 1.0, r)[None, :, None]
    turn = far**0.8 * rng.uniform(4.2, 5.2) * np.pi
    noise = sum(
        rng.uniform(0.5, 1.0) / k**0.5 * np.sin(k * turn + rng.uniform(0, 6.28))
        for k in (1.3, 2.1, 3.4)
    )
    fold = np.sin(5.0 * turn * (1.0 - 0.35 * far) + noise)
    fold = fold if level < 2 else 0.0 * fold  # too narrow for so few columns: they would be spikes
    foot = 0.05 + 0.28 * far
    rim = (0.2 + 0.72 * far) * (1.0 + 0.1 * noise) + 0.05 * fold
    reach = foot + (rim - foot) * out**1.3 + 0.04 * fold * out
    height = (0.95 - 0.6 * far + 0.1 * noise + 0.06 * fold) * (out - 0.3 * out**2) - 0.05
    top = np.stack([reach * np.cos(turn), reach * np.sin(turn), height], axis=-1)
    pale = np.clip((out - 0.7) / 0.3, 0.0, 1.0)
    return plates(top, 0.06, tip=pale, light=0.6 + 0.4 * out**1.5, below=0.9)


def leather(rng: Rng, level: int) -> CoralMesh:
    """A stalk with a cap whose rim is folded."""
    columns = (72, 32, 14, 8, 6)[level]
    turn = np.linspace(0.0, 2 * np.pi, columns + 1)
    r = np.array([0.42, 0.3, 0.34, 0.7, 0.98, 1.0, 0.8, 0.45, 0.0])
    h = np.array([0.0, 0.2, 0.42, 0.5, 0.6, 0.68, 0.66, 0.6, 0.55])
    light = np.array([0.3, 0.35, 0.3, 0.45, 0.75, 1.0, 1.0, 0.9, 0.8])
    if level >= 2:
        keep = [0, 2, 3, 5, 6, 7, 8] if level == 2 else [0, 2, 4, 5, 6, 8]
        r, h, light = r[keep], h[keep], light[keep]
    fold = np.sin(6 * turn + 1.2 * np.sin(turn + rng.uniform(0, 6)) + rng.uniform(0, 6))
    fold = fold + 0.5 * np.sin(3 * turn + rng.uniform(0, 6))
    rim = np.clip((r - 0.35) / 0.65, 0.0, 1.0)[:, None]
    oval = 1.0 + 0.14 * np.cos(2 * turn + rng.uniform(0, 6)) + 0.08 * np.cos(3 * turn)
    reach = r[:, None] * (1.0 + rim * (oval - 1.0) - 0.12 * rim**2 * np.abs(fold))
    height = h[:, None] + 0.15 * rim**2 * fold
    tip, sway = rim * (h[:, None] > 0.57), 0.35 * h[:, None]
    return turned(reach, height, light=light[:, None], tip=tip, sway=sway)


def mound(rng: Rng, level: int, variant: int = 0) -> CoralMesh:
    """Dead reef: the worn, crusted dome of `habitat.mounds`."""
    columns, rings = ((52, 20), (20, 9), (11, 5), (7, 4), (6, 4))[level]
    turn = np.linspace(0.0, 2 * np.pi, columns + 1)
    down = np.linspace(np.radians(118.0), 0.0, rings)[:, None] + 0 * turn
    out = outline(variant, turn) * np.sin(down)
    flat = np.stack([out * np.cos(turn), out * np.sin(turn)], axis=-1)
    height = np.where(down < 0.5 * np.pi, dome(variant, flat), HEIGHT * np.cos(down))
    way = np.concatenate([flat, np.cos(down)[..., None]], axis=-1)
    light = np.clip(0.75 + 0.3 * bumps(rng, way, 0.9, 3) + 0.5 * np.cos(down), 0.25, 1.0)
    crust = np.clip(0.4 + 0.9 * bumps(rng, way, 0.7, 2), 0.0, 1.0)
    mesh = turned(out, height, light=light, tip=crust)
    flat = np.stack([down * np.cos(turn), down * np.sin(turn)], axis=-1)
    return mesh._replace(along=flat.reshape(-1, 2))


def _hollow(
    path: Array, radius: Array, sides: int, deep: int, thick: float, **given: Any
) -> CoralMesh:
    """Tubes with walls `thick` times the radius, hollow by `deep` rings."""
    r = radius.shape[1]
    back = np.arange(r - 1, r - 1 - deep, -1)
    way = unit(np.gradient(path, axis=1))
    rings = np.concatenate([np.arange(r), [r - 1], back, back[-1:]])
    inner = np.concatenate([np.ones(r), [1.0 - 0.5 * thick], np.full(deep, 1.0 - thick), [0.0]])
    lift = np.concatenate([np.zeros(r), [0.25 * thick], np.zeros(deep + 1)])
    rim = radius[:, -1:, None] * lift[:, None] * way[:, -1:]
    light = np.concatenate([np.linspace(0.45, 1.0, r), [1.0], np.linspace(0.6, 0.1, deep), [0.05]])
    tip = np.concatenate([np.linspace(-0.6, 0.6, r), [1.0], np.linspace(0.6, 0.0, deep), [0.0]])
    tip = np.clip(tip, 0.0, 1.0)
    path, radius = path[:, rings] + rim, radius[:, rings] * inner
    return tubes(path, radius, sides, way=way[:, rings], light=light, tip=tip)


def pipes(rng: Rng, level: int) -> CoralMesh:
    """A cluster of tube sponges of different heights that lean apart."""
    number, rings, sides = 8, (7, 5, 3, 2, 2)[level], (14, 10, 7, 4, 3)[level]
    turn = 2.39996 * np.arange(number) + rng.uniform(-0.4, 0.4, number)
    out = 0.17 * np.sqrt(np.arange(number) + 0.2)
    foot = np.stack([out * np.cos(turn), out * np.sin(turn), 0 * turn - 0.05], axis=1)
    high = (1.0 - 0.085 * np.arange(number)) * rng.uniform(0.75, 1.1, number) * 1.7
    lean = foot * (0.75, 0.75, 0.0) + rng.normal(0.0, 0.09, (number, 3)) * (1, 1, 0)
    wide = rng.uniform(0.85, 1.2, number) * 0.15
    wobble = rng.uniform(0.0, 6.28, (2, number))
    s = np.linspace(0.0, 1.0, rings)[None, :]
    path = foot[:, None] + s[..., None] ** 1.5 * lean[:, None] + (high[:, None] * s)[..., None] * UP
    path[..., 0] += 0.05 * np.sin(4.0 * s + wobble[0][:, None]) * s
    path[..., 1] += 0.05 * np.sin(4.0 * s + wobble[1][:, None]) * s
    radius = wide[:, None] * (
        0.8 + 0.35 * s - 0.1 * s**4 + 0.07 * np.sin(9.0 * s + wobble[1][:, None])
    )
    if level < 3:
        return _hollow(path, radius, sides, max(rings // 2, 1), 0.32)
    # A dark lid stands for the hollow.
    path, radius = pointed(path, radius)
    shut = path[:, [0, 1, 1]] - 0.1 * (path[:, [0, 1, 2]] - path[:, [0, 1, 1]])
    way = unit(np.gradient(path, axis=1))
    light, tip = np.array([0.45, 1.0, 0.2]), np.array([0.0, 0.6, 0.0])
    return tubes(shut, radius, sides, way=way, tip=tip, light=light)


def barrel(rng: Rng, level: int) -> CoralMesh:
    """A barrel sponge: a ribbed, lopsided vessel with a deep hollow."""
    columns, rings = ((66, 12), (30, 7), (14, 4), (8, 3), (6, 3))[level]
    turn = np.linspace(0.0, 2 * np.pi, columns + 1)
    s = np.linspace(0.0, 1.0, rings)[:, None]
    belly = 0.55 + 0.62 * np.sin(np.pi * (0.12 + 0.62 * s)) ** 1.2 - 0.1 * s
    ribs = np.abs(np.sin(5.5 * turn + 0.8 * np.sin(2 * turn + rng.uniform(0, 6)) + 0.5 * s))
    way = np.stack([np.cos(turn) + 0 * s, np.sin(turn) + 0 * s, 2 * s + 0 * turn], axis=-1)
    lump = 0.1 * bumps(rng, way, 1.6)
    keel = (
        1.0
        + (0.2 if level < 2 else 0.06) * (ribs**0.7 - 0.6) * np.sin(np.pi * (0.1 + 0.85 * s))
        + lump
    )
    outer, high = belly * keel, 1.55 * s + 0.1 * lump * s + 0 * turn
    rim = 0.06 * np.sin(3 * turn + rng.uniform(0, 6)) + 0.05 * np.sin(7 * turn)
    high = high + rim * s**3
    inside = (0.86 * belly + 0.1 * lump)[::-1]
    dive = np.linspace(0.02, 0.75, rings)[:, None]
    inside = np.concatenate([inside[:-1] * (1.0 - 0.25 * dive[:-1]), 0.0 * inside[-1:]])
    down = (high[-1:] - 1.3 * dive)[:rings]
    light = np.concatenate([0.35 + 0.65 * s**0.6, 0.75 * (1.0 - dive) ** 2.2 + 0.04])
    rib_tips = np.clip(ribs * (0.4 + 0.4 * s), 0, 1)
    tip = np.concatenate([rib_tips, np.linspace(1.0, 0.1, rings)[:, None] + 0 * turn])
    reach, height = np.concatenate([outer, inside]), np.concatenate([high, down])
    return turned(reach, height, light=light, tip=tip)


def anemone(rng: Rng, level: int) -> CoralMesh:
    """A crown of tentacles on a disc; they wave and have pale, swollen ends."""
    number = (96, 60, 30, 14, 11)[level]
    fine = np.random.default_rng(int(rng.integers(2**31)))
    k = np.arange(96) + 0.5
    out, turn = np.sqrt(k / 96), k * 2.39996
    length = (0.62 - 0.12 * (1.0 - out)) * fine.uniform(0.75, 1.15, 96)
    ways, sags = fine.normal(0.0, 0.3, (96, 3)), fine.uniform(0.15, 0.75, 96)
    pick = np.arange(number) * 96 // number
    out, turn, length, ways, sags = out[pick], turn[pick], length[pick], ways[pick], sags[pick]
    lobes = (
        1.0
        + 0.16 * np.sin(3 * turn + rng.uniform(0, 6))
        + 0.1 * np.sin(5 * turn + rng.uniform(0, 6))
    )
    flat = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    root = flat * (0.45 * out * lobes)[:, None] + UP * (0.16 + 0.05 * out[:, None])
    way = unit(
        flat * (0.15 + 1.25 * out[:, None] ** 1.5) + UP * (1.15 - 0.65 * out[:, None]) + ways
    )
    rings = (6, 4, 3, 2, 2)[level]
    s = np.linspace(0.0, 1.0, rings)[None, :, None]
    path = root[:, None] + length[:, None, None] * (
        s * way[:, None] + s**2 * (sags[:, None] * (0.8 * flat - 0.45 * UP))[:, None]
    )
    radius = (0.05, 0.06, 0.085, 0.12, 0.13)[level] * (
        1.0 - 0.35 * np.sin(np.pi * s[..., 0] ** 1.3) + 0.25 * s[..., 0] ** 6
    ) + 0 * path[..., 0]
    path, radius = capped(path, radius) if level == 0 else pointed(path, radius)
    if level == 4:
        radius[:, 0] = 0.0
    s = np.concatenate([s[0, :, 0], np.ones(path.shape[1] - rings)])
    tip, light = np.clip((s - 0.62) / 0.3, 0.0, 1.0), 0.2 + 0.8 * s**0.8
    crown = tubes(path, radius, 5 if level == 0 else 3, tip=tip, light=light, sway=s**1.3)
    columns = (16, 12, 8, 6, 5)[level]
    r = np.array([0.42, 0.36, 0.5, 0.3, 0.0])[:, None] + np.zeros(columns + 1)
    h = np.array([-0.05, 0.06, 0.19, 0.19, 0.14])[:, None] + np.zeros(columns + 1)
    foot = turned(r, h, light=np.array([0.35, 0.5, 0.5, 0.3, 0.3])[:, None])
    return joined(foot, crown)


LEVELS = 6
LUMPS = ("bush", "finger", "soft", "fan", "pipes", "anemone")  # others lack the last level: a lump
WELDED = 2  # the level from which on vertices are welded
TUBES = (*LUMPS, "staghorn", "rubble")  # too thin to show what welding does to their textures
SHAPES: dict[str, Callable[[Rng, int], CoralMesh]] = {
    "staghorn": staghorn, "bush": bush, "table": table, "brain": brain, "lettuce": lettuce,
    "finger": finger, "leather": leather, "soft": soft, "fan": fan, "pipes": pipes,
    "barrel": barrel, "anemone": anemone, "rubble": rubble,
    "mound": mound,
}  # fmt: skip


def lump(kind: str, variant: int, mesh: CoralMesh) -> CoralMesh:
    """A few triangles as wide at each height, and as ragged, as a mesh."""
    x, y, z = mesh.place.T
    flat, top, columns = (0.1 if kind == "fan" else 1.0), z.max(), 5
    ragged = np.random.default_rng([2, variant]).uniform(0.6, 1.0, columns + 1)
    ragged[-1] = ragged[0]
    share = np.array([0.0, 0.55, 1.0])
    height = top * share
    wide = [np.hypot(x, y)[np.abs(z - h) < 0.3 * top].max(initial=0.1) for h in height[:2]]
    reach = np.array([*wide, 0.0])[:, None] * ragged
    rise = height[:, None] * (1.0 + 0.25 * (ragged - 1.0))
    rise[1] += 0.4 * top * (ragged[::-1] - 0.8)
    rise[2] = rise[2].mean()
    light = np.array([0.32, 0.78, 0.74])[:, None]
    tip = np.array([0.1, 0.6, 0.5])[:, None] * ragged
    out = turned(reach, np.maximum(rise, 0.0), tip=tip, light=light)
    return out._replace(place=out.place * (1.0, flat, 1.0))


def forms(wanted: Sequence[tuple[str, int]]) -> list[list[CoralMesh]]:
    """Make all levels of kinds and variants, finest first, or read them from the disk cache."""
    with ThreadPoolExecutor() as pool:  # numpy releases the GIL
        return list(pool.map(lambda one: cached(growth_levels, *one), wanted))


def growth_levels(kind: str, variant: int) -> list[CoralMesh]:
    """Make all levels of one variant of a kind, finest first, in single precision."""
    number = LEVELS if kind in LUMPS else LEVELS - 1
    return [single(shape(kind, variant, level)) for level in range(number)]


@cache
def shape(kind: str, variant: int, level: int) -> CoralMesh:
    """One variant of a kind at one level, with the proportions of `habitat.reef.KINDS`."""
    rng = np.random.default_rng([variant, 0xC0, list(SHAPES).index(kind)])
    if kind == "mound":  # not fitted: other growths stand on this surface
        mesh = mound(rng, level, variant)
    elif level == LEVELS - 1:
        mesh = fitted(lump(kind, variant, shape(kind, variant, level - 2)), KINDS[kind].height)
    else:
        mesh = fitted(SHAPES[kind](rng, level), KINDS[kind].height)
    return mesh if level < WELDED else welded(mesh, kind in TUBES)
