"""Branches that fork and bend, the parts of many kinds of coral."""

from typing import Any, NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.reef.coral_mesh import UP, CoralMesh, Rng, capped, cross, tubes, unit


class Branches(NamedTuple):
    """b branches, each bent evenly along its length."""

    start: Array  # (b, 3)
    way: Array  # (b, 3) unit, at the root
    length: Array  # (b,)
    bend: Array  # (b, 3), offset of the end over the length
    radius: Array  # (b, 2), at root and end
    order: Array  # (b,) 0 for stems, 1 for branches on them, ...

    def at(self, share: Array) -> Array:
        """Points (b, k, 3) at shares (b, k) of the length."""
        s = share[..., None]
        run = s * self.way[:, None] + s * s * self.bend[:, None]
        return np.asarray(self.start[:, None] + self.length[:, None, None] * run)

    def taken(self, chosen: Any) -> "Branches":
        """The chosen branches."""
        return Branches(*(part[chosen] for part in self))

    def tubes(
        self,
        rings: int,
        sides: int,
        cap: bool,
        thicker: float = 1.0,
        pale: float = 0.6,
        sway: float = 0.0,
        dark: float = 0.4,
    ) -> CoralMesh:
        """All branches as tubes, with round ends if `cap`.

        Branches of the last order get paler from the share `pale` of their length on; `dark` is
        the light in the middle of the growth, `sway` the share of the full sway at its outside.
        """
        share = np.tile(np.linspace(0.0, 1.0, rings), (len(self.length), 1))
        path = self.at(share)
        radius: Array = thicker * (self.radius[:, :1] + share * np.diff(self.radius))
        path, radius = capped(path, radius) if cap else pointed(path, radius)
        share = np.pad(share, ((0, 0), (0, path.shape[1] - rings)), constant_values=1.0)
        last = (self.order == self.order.max())[:, None]
        tip = np.where(last, np.clip((share - pale) / (1.0 - pale), 0.0, 1.0) ** 1.5, 0.0)
        light = thicket_light(path, dark)
        return tubes(path, radius, sides, tip=tip, light=light, sway=sway * out_share(path))


def pointed(path: Array, radius: Array) -> tuple[Array, Array]:
    """Paths and radii with blunt points: one more ring each, of radius 0."""
    end = unit(path[:, -1:] - path[:, -2:-1]) * radius[:, -1:, None]
    path = np.concatenate([path, path[:, -1:] + 0.5 * end], axis=1)
    return path, np.concatenate([radius, 0.0 * radius[:, -1:]], axis=1)


def out_share(path: Array) -> Array:
    """Distance of points from the root of a growth, as 0 to 1."""
    far = np.linalg.norm(path, axis=-1)
    return np.asarray(np.clip(far / far.max(), 0.0, 1.0) ** 1.5)


def thicket_light(path: Array, dark: float) -> Array:
    """Light at points of a thicket: `dark` in the middle, 1 outside."""
    return dark + (1.0 - dark) * out_share(path)


def grow_offshoots(
    rng: Rng,
    parents: Branches,
    number: int,
    spread: float,
    rise: float,
    shrink: float,
    first: float,
) -> Branches:
    """Grow `number` branches on each parent, from the share `first` of its length to its end."""
    p, n = len(parents.length), len(parents.length) * number
    share = (
        first + (1.0 - first) * (np.arange(number) + rng.uniform(0.2, 1.0, (p, number))) / number
    )
    share[:, -1] = 1.0
    start = parents.at(share).reshape(n, 3)
    along = unit(parents.way[:, None] + 2 * share[..., None] * parents.bend[:, None]).reshape(n, 3)
    aside = unit(cross(along, rng.normal(size=(n, 3))))
    way = unit(along + spread * rng.uniform(0.6, 1.4, (n, 1)) * aside + rise * UP)
    radius = parents.radius[:, None, :1] + share[..., None] * np.diff(parents.radius)[:, None]
    radius = 0.88 * radius.reshape(n, 1) * np.array([1.0, shrink])
    length = np.repeat(parents.length, number) * rng.uniform(0.55, 1.0, n) * shrink**0.5
    bend = 0.35 * rise * UP + 0.15 * rng.normal(size=(n, 3))
    return Branches(start, way, length, bend, radius, np.repeat(parents.order + 1, number))


def grow_stems(rng: Rng, number: int, lean: float, length: float, radius: float) -> Branches:
    """Grow `number` stems from one foot, which lean outward."""
    turn = 2 * np.pi * (np.arange(number) + rng.uniform(-0.4, 0.4, number)) / number
    out = lean * np.sqrt((np.arange(number) + 0.4) / number) * rng.uniform(0.7, 1.2, number)
    way = unit(np.stack([out * np.cos(turn), out * np.sin(turn), np.ones(number)], axis=1))
    start = 0.12 * way * (1, 1, 0) - 0.06 * UP
    return Branches(
        start, way, length * rng.uniform(0.7, 1.1, number),
        0.3 * UP + 0.12 * rng.normal(size=(number, 3)),
        np.tile([radius, 0.8 * radius], (number, 1)), np.zeros(number),
    )  # fmt: skip


def together(*parts: Branches) -> Branches:
    """Join branches."""
    return Branches(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))
