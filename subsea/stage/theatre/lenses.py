"""Lenses of projectors: rays through their pictures, and places for them.

Points and directions are right, up, ahead of the middle of the eyes, in centimetres. Places are
shares (x, y) of a projector's picture from its lower left corner.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.view.camera import axes_of

SPARE = 1.02  # a picture is larger than the part of the screen that it must light
FAR = 1.5  # of nodes that are kept from the middle of a picture, in pictures
STEEP = 5.0  # largest half width of a picture over its distance


class Lens(NamedTuple):
    """A lens that projects a picture without distortion."""

    place: Array  # (3,)
    axes: Array  # (3, 3) rows: right, up, ahead
    half: tuple[float, float]  # half the width and height of the picture at unit distance

    @property
    def throw(self) -> float:
        """The throw ratio: distance over the width of the picture."""
        return 0.5 / self.half[0]


def rays(lens: Lens, places: Array) -> Array:
    """Unit directions (n, 3) of the light at places (n, 2) of the picture."""
    x, y = (2.0 * np.asarray(places, np.float64) - 1.0).T
    own = np.stack([x * lens.half[0], y * lens.half[1], np.ones_like(x)], axis=1)
    found = own @ lens.axes
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def aimed(place: Array, points: Array, aspect: float) -> Lens:
    """The lens at `place` (3,) with the smallest picture that takes in points (n, 3).

    Its picture is `aspect` times wider than high. Infinitely large if a point lies behind it.
    """
    way = points - place
    way = way / np.linalg.norm(way, axis=1, keepdims=True)
    aim = way.mean(axis=0)
    for _ in range(4):
        axes = axes_of(float(np.arctan2(aim[0], aim[2])), float(np.arcsin(_unit(aim)[1])))
        seen = way @ axes.T
        if seen[:, 2].min() < 0.05:
            return Lens(place, axes, (np.inf, np.inf))
        slopes = seen[:, :2] / seen[:, 2:]
        low, high = slopes.min(axis=0), slopes.max(axis=0)
        aim = np.array([*(low + high) / 2.0, 1.0]) @ axes
    reach = SPARE * np.abs(slopes).max(axis=0)
    half = float(max(reach[0], reach[1] * aspect))
    return Lens(place, axes, (half, half / aspect))


def placed(places: Iterable[Array], points: Array, aspect: float, throw: float, what: str) -> Lens:
    """A lens that lights all points (n, 3): at the first of `places`, (3,) each, where it can.

    With a `throw` ratio of 0 it stands at the last place, with the largest ratio that fits there. A
    UserError about `what` if the lens lights too little from everywhere.
    """
    lens = None
    longest = 0.0
    for place in places:
        lens = aimed(place, points, aspect)
        if lens.half[0] > STEEP:
            continue
        longest = max(longest, lens.throw)
        if throw and lens.throw >= throw:
            return lens._replace(half=(0.5 / throw, 0.5 / throw / aspect))
    if throw or lens is None or lens.half[0] > STEEP:
        expected = f"{longest:.2f} or less, or more projectors" if longest else "more projectors"
        raise UserError(f"--throw {throw:g} lights too little of {what}, expected {expected}")
    return lens


def warp_nodes(
    lens: Lens, count: tuple[int, int], shares: Callable[[Array, Array], Array]
) -> Array:
    """Nodes (rows, columns, 5) of a mesh: x, y, u, v, brightness, as `bourke` has them.

    `shares(place, ways)` gives the shares (n, 2) of the picture at which rays (n, 3) from the lens
    arrive, NaN for none.
    """
    x, y = np.meshgrid(np.linspace(0, 1, count[0]), np.linspace(0, 1, count[1]))
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    shown = shares(lens.place, rays(lens, places))
    with np.errstate(invalid="ignore"):
        used = np.asarray((np.abs(shown - 0.5) < FAR).all(axis=1))  # not NaN
    aspect = lens.half[0] / lens.half[1]
    own = (2.0 * places - 1.0) * [aspect, 1.0]
    nodes = np.column_stack([own, np.where(used[:, None], shown, 0.0), np.where(used, 1.0, -1.0)])
    return np.asarray(nodes.reshape(count[1], count[0], 5))


def nodes_text(nodes: Array) -> str:
    """The text of a rectangular mesh file of nodes (rows, columns, 5)."""
    rows = [" ".join(f"{number:.6f}" for number in node) for node in nodes.reshape(-1, 5)]
    return "\n".join(["2", f"{nodes.shape[1]} {nodes.shape[0]}", *rows, ""])


def on_sphere(place: Array, ways: Array, radius: float) -> Array:
    """Points (n, 3) where rays (n, 3) from a place (3,) inside of a sphere about 0 meet it."""
    b = ways @ place
    reach = -b + np.sqrt(b * b + radius**2 - place @ place)
    return np.asarray(place + reach[:, None] * ways)


def on_cylinder(place: Array, ways: Array, radius: float) -> Array:
    """Points (n, 3) where rays (n, 3) leave an upright cylinder about 0; NaN if they do not."""
    flat, start = ways[:, [0, 2]], place[[0, 2]]
    a, b = (flat**2).sum(axis=1), flat @ start
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = (-b + np.sqrt(b * b - a * (start @ start - radius**2))) / a
    return np.asarray(place + reach[:, None] * ways)


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
