"""Tube and barrel sponges, and anemones."""

from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.reef.coral_branches import pointed
from subsea.rendering.reef.coral_mesh import (
    UP,
    CoralMesh,
    Rng,
    bumps,
    capped,
    joined,
    tubes,
    turned,
    unit,
)


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
    number, rings, sides = 8, (7, 5, 3, 2)[level], (14, 8, 5, 4)[level]
    turn = 2.39996 * np.arange(number) + rng.uniform(-0.4, 0.4, number)
    out = 0.17 * np.sqrt(np.arange(number) + 0.2)
    foot = np.stack([out * np.cos(turn), out * np.sin(turn), 0 * turn - 0.05], axis=1)
    high = (1.0 - 0.085 * np.arange(number)) * rng.uniform(0.75, 1.1, number) * 1.7
    lean = foot * (0.75, 0.75, 0.0) + rng.normal(0.0, 0.09, (number, 3)) * (1, 1, 0)
    wide = rng.uniform(0.85, 1.2, number) * 0.15
    wobble = rng.uniform(0.0, 6.28, (2, number))
    if level == 3:
        foot, high, lean, wide, wobble = foot[:5], high[:5], lean[:5], 1.2 * wide[:5], wobble[:, :5]
    s = np.linspace(0.0, 1.0, rings)[None, :]
    path = foot[:, None] + s[..., None] ** 1.5 * lean[:, None] + (high[:, None] * s)[..., None] * UP
    path[..., 0] += 0.05 * np.sin(4.0 * s + wobble[0][:, None]) * s
    path[..., 1] += 0.05 * np.sin(4.0 * s + wobble[1][:, None]) * s
    radius = wide[:, None] * (
        0.8 + 0.35 * s - 0.1 * s**4 + 0.07 * np.sin(9.0 * s + wobble[1][:, None])
    )
    return _hollow(path, radius, sides, max(rings // 2, 1), 0.32)


def barrel(rng: Rng, level: int) -> CoralMesh:
    """A barrel sponge: a ribbed, lopsided vessel with a deep hollow."""
    columns, rings = ((66, 12), (30, 7), (14, 4), (8, 3))[level]
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
    number = (96, 60, 30, 14)[level]
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
    rings = (6, 4, 3, 2)[level]
    s = np.linspace(0.0, 1.0, rings)[None, :, None]
    path = root[:, None] + length[:, None, None] * (
        s * way[:, None] + s**2 * (sags[:, None] * (0.8 * flat - 0.45 * UP))[:, None]
    )
    radius = (0.05, 0.06, 0.085, 0.12)[level] * (
        1.0 - 0.35 * np.sin(np.pi * s[..., 0] ** 1.3) + 0.25 * s[..., 0] ** 6
    ) + 0 * path[..., 0]
    path, radius = capped(path, radius) if level == 0 else pointed(path, radius)
    s = np.concatenate([s[0, :, 0], np.ones(path.shape[1] - rings)])
    tip, light = np.clip((s - 0.62) / 0.3, 0.0, 1.0), 0.2 + 0.8 * s**0.8
    crown = tubes(path, radius, 5 if level == 0 else 3, tip=tip, light=light, sway=s**1.3)
    columns = (16, 12, 8, 6)[level]
    r = np.array([0.42, 0.36, 0.5, 0.3, 0.0])[:, None] + np.zeros(columns + 1)
    h = np.array([-0.05, 0.06, 0.19, 0.19, 0.14])[:, None] + np.zeros(columns + 1)
    foot = turned(r, h, light=np.array([0.35, 0.5, 0.5, 0.3, 0.3])[:, None])
    return joined(foot, crown)
