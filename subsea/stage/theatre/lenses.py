"""Optics of projectors: their lenses, places for them, meshes, and the spherical mirror of a dome.

In Paul Bourke's projection light leaves the lens, is reflected by a sphere and meets the dome
(paulbourke.net/dome/mirrordome). The mirror stands below the rim at the rear, the projector shines
at it from the front, and the light comes back over the audience.

Points and directions are right, up, ahead of the middle of the eyes, in centimetres. Places are
shares (x, y) of a projector's picture from its lower left corner.
"""

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import dome_shares
from subsea.stage.theatre.warp import mesh, rasterized
from subsea.view.camera import axes_of
from subsea.view.meshes import grid_triangles

SPARE = 1.02  # a picture is larger than the part of the screen that it must light
FAR = 1.5  # of nodes that are kept from the middle of a picture, in pictures
STEEP = 5.0  # largest half width of a picture over its distance
MIRROR_NODES = 97, 73  # columns and rows of the mesh of a mirror
GAMMA = 2.2  # of the projector: brightness is a factor on its values
DIMMEST = 0.15  # brightness of nodes whose light is most concentrated
BEYOND = 0.55  # farthest node from the middle of the dome's square: 1.1 of its rim
LARGEST = 0.35  # radius of a mirror over that of the dome
DEEP = 0.95  # share of the mirror's radius that the picture takes in


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
    seen = np.stack([x * lens.half[0], y * lens.half[1], np.ones_like(x)], axis=1)
    ways = seen @ lens.axes
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))


def aimed(place: Array, points: Array, aspect: float) -> Lens:
    """The lens at `place` (3,) with the smallest picture that takes in points (n, 3).

    Its picture is `aspect` times wider than high. Infinitely large if a point lies behind it.
    """
    way = points - place
    way = way / np.linalg.norm(way, axis=1, keepdims=True)
    aim = way.mean(axis=0)
    for _ in range(4):
        pitch = np.arcsin(aim[1] / np.linalg.norm(aim))
        axes = axes_of(float(np.arctan2(aim[0], aim[2])), float(pitch))
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
    """Nodes (rows, columns, 5) of a mesh: x, y, u, v, brightness, as `parse_bourke` reads them.

    `shares(place, ways)` gives the shares (n, 2) of the picture at which rays (n, 3) from the lens
    arrive, NaN for none.
    """
    x, y = np.meshgrid(np.linspace(0, 1, count[0]), np.linspace(0, 1, count[1]))
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    shown = shares(lens.place, rays(lens, places))
    with np.errstate(invalid="ignore"):
        used = np.asarray((np.abs(shown - 0.5) < FAR).all(axis=1))  # not NaN
    aspect = lens.half[0] / lens.half[1]
    corners = (2.0 * places - 1.0) * [aspect, 1.0]
    nodes = np.column_stack(
        [corners, np.where(used[:, None], shown, 0.0), np.where(used, 1.0, -1.0)]
    )
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


class MirrorSetup(NamedTuple):
    """The lens, the mirror and the mesh; lengths in centimetres from the dome's centre."""

    lens: Lens
    centre: Array  # (3,) of the mirror
    nodes: Array  # (rows, columns, 5) as `parse_bourke` reads them
    lit: float  # share of the dome's area


def mirror_setup(
    radius: float, mirror: float, throw: float, aspect: float, tilt: float = 0.0
) -> MirrorSetup:
    """The setup for a dome of a `radius`, tilted to the front by `tilt` rad, and its mesh.

    `throw` is the ratio of the lens, `aspect` the width of its picture over the height. A UserError
    if mirror or lens do not fit into the dome.
    """
    if mirror > LARGEST * radius:
        raise UserError(
            f"--mirror {mirror:g} is too large for a dome of {radius:g} cm, expected "
            f"{LARGEST * radius:.0f} or less"
        )
    # The picture takes in the upper half of the mirror.
    wide = max(2.0 * DEEP * mirror, DEEP * mirror * aspect)
    far = throw * wide
    room = 2.0 * radius - 2.5 * mirror
    if far > room:
        raise UserError(
            f"--throw {throw:g} puts the lens {far:.0f} cm from the mirror, out of the dome; "
            f"expected {room / wide:.2f} or less"
        )
    turned = axes_of(0.0, -tilt)
    centre = np.array([0.0, -mirror, 1.2 * mirror - radius])
    target = centre + [0.0, 0.5 * DEEP * mirror, 0.0]
    place = target + [0.0, -0.4 * mirror, far]
    way = target - place
    axes = axes_of(math.pi, math.asin(way[1] / float(np.linalg.norm(way))))
    half = 0.5 / throw, 0.5 / throw / aspect
    lens = Lens(place @ turned, axes @ turned, half)
    centre = centre @ turned

    def shares(start: Array, ways: Array) -> Array:
        shown = dome_shares(traced(start, ways, centre, mirror, radius)[2], math.degrees(tilt))
        far = np.linalg.norm(shown - 0.5, axis=1) > BEYOND
        return np.where(far[:, None], np.nan, shown)

    nodes = _with_brightness(warp_nodes(lens, MIRROR_NODES, shares))
    return MirrorSetup(lens, centre, nodes, _lit_share(nodes))


def traced(
    start: Array, ways: Array, centre: Array, mirror: float, radius: float
) -> tuple[Array, Array, Array]:
    """Points (n, 3) on the mirror, reflected directions, and points on the dome about 0.

    `ways` (n, 3) are unit directions from `start` (3,); NaN where light passes the mirror by.
    """
    away = start - centre
    b = ways @ away
    with np.errstate(invalid="ignore"):
        reach = -b - np.sqrt(b * b - (away @ away - mirror**2))
    met = start + np.where(reach > 0.0, reach, np.nan)[:, None] * ways
    normal = (met - centre) / mirror
    back = ways - 2.0 * (ways * normal).sum(axis=1, keepdims=True) * normal
    c = (met * back).sum(axis=1)
    reach = -c + np.sqrt(c * c + radius**2 - (met * met).sum(axis=1))
    return met, back, met + reach[:, None] * back


def _with_brightness(nodes: Array) -> Array:
    """Nodes with the brightness that makes the dome evenly bright.

    Light is as strong as the solid angle of the dome over the area of the picture is small.
    """
    u, v = np.moveaxis(np.where(nodes[..., 4:] > 0, nodes[..., 2:4], np.nan), -1, 0)
    away = np.hypot(u - 0.5, v - 0.5) * math.pi
    with np.errstate(invalid="ignore"):
        (u_down, u_across), (v_down, v_across) = np.gradient(u), np.gradient(v)
        area = np.abs(u_across * v_down - u_down * v_across) * np.sinc(away / math.pi)
    known = area[np.isfinite(area) & (away <= math.pi / 2.0)]
    brightest = float(np.quantile(known, 0.9)) if len(known) else 1.0
    light = np.clip(np.nan_to_num(area, nan=brightest) / brightest, 0.0, 1.0) ** (1.0 / GAMMA)
    bright = nodes.copy()
    bright[..., 4] = np.where(nodes[..., 4] > 0, np.maximum(light, DIMMEST), -1.0)
    return bright


def _lit_share(nodes: Array) -> float:
    """The share of the dome's area that a mesh lights."""
    flat = nodes.reshape(-1, 5)
    triangles = grid_triangles(nodes.shape[1], nodes.shape[0])
    triangles = triangles[(flat[triangles, 4] > 0).all(axis=1)]
    seen = mesh(flat[:, 2:4], flat[:, 2:4], triangles)
    side = 200
    lit = rasterized(seen, np.ones(len(flat)), (side, side)) > 0
    x, y = np.meshgrid((np.arange(side) + 0.5) / side, (np.arange(side) + 0.5) / side)
    away = np.hypot(x - 0.5, y - 0.5) * 2.0
    weight = np.where(away <= 1.0, np.sinc(away / 2.0), 0.0)
    return float((weight * lit).sum() / weight.sum())
