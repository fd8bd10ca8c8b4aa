"""Kinds with one closed surface: plates, domes, folds and mounds."""

import numpy as np

from subsea.base.arrays import Array
from subsea.habitat.mounds import HEIGHT, dome, outline
from subsea.rendering.reef.coral_mesh import (
    CoralMesh,
    Rng,
    bumps,
    joined,
    plates,
    tubes,
    turned,
)


def table(rng: Rng, level: int) -> CoralMesh:
    """Flat plates on a short stem, one above another, with a finely branched rim."""
    columns = (120, 40, 18, 10)[level]
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
        + (0.03, 0.02, 0.0, 0.0)[level] * (np.arange(columns + 1) % 2 - 0.5)
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
    number = (300, 60, 0, 0)[level]
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
    columns, rings = ((46, 23), (20, 10), (10, 5), (7, 4))[level]
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
    c, r = ((130, 8), (52, 4), (22, 2), (11, 2))[level]
    far = np.linspace(0.0, 1.0, c)[None, None, :]
    out = np.linspace(0.0, 1.0, r)[None, :, None]
    turn = far**0.8 * rng.uniform(4.2, 5.2) * np.pi
    noise = sum(
        rng.uniform(0.5, 1.0) / k**0.5 * np.sin(k * turn + rng.uniform(0, 6.28))
        for k in (1.3, 2.1, 3.4)
    )
    fold = np.sin(5.0 * turn * (1.0 - 0.35 * far) + noise)
    foot = 0.05 + 0.28 * far
    rim = (0.2 + 0.72 * far) * (1.0 + 0.1 * noise) + 0.05 * fold
    reach = foot + (rim - foot) * out**1.3 + 0.04 * fold * out
    height = (0.95 - 0.6 * far + 0.1 * noise + 0.06 * fold) * (out - 0.3 * out**2) - 0.05
    top = np.stack([reach * np.cos(turn), reach * np.sin(turn), height], axis=-1)
    pale = np.clip((out - 0.7) / 0.3, 0.0, 1.0)
    return plates(top, 0.06, tip=pale, light=0.22 + 0.78 * out**1.5)


def leather(rng: Rng, level: int) -> CoralMesh:
    """A stalk with a cap whose rim is folded."""
    columns = (72, 32, 14, 8)[level]
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
    columns, rings = ((52, 20), (20, 9), (11, 5), (7, 4))[level]
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
