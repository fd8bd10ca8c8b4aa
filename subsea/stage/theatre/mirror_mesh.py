"""A projector, a convex mirror and a dome: Paul Bourke's spherical mirror projection.

Light leaves the lens, is reflected by a sphere and meets the dome (paulbourke.net/dome/mirrordome).
The mirror stands below the rim at the rear, the projector shines at it from the front, and the
light comes back over the audience.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.stage.theatre.lenses import Lens, warp_nodes
from subsea.stage.theatre.warp import mesh, rasterized
from subsea.view.camera import axes_of

NODES = 97, 73  # columns and rows of the mesh
GAMMA = 2.2  # of the projector: brightness is a factor on its values
DIMMEST = 0.15  # brightness of nodes whose light is most concentrated
BEYOND = 1.1  # nodes beyond the rim that are kept, in radii of the fisheye
LARGEST = 0.35  # radius of a mirror over that of the dome
DEEP = 0.95  # share of the mirror's radius that the picture takes in


class MirrorSetup(NamedTuple):
    """The lens, the mirror and the mesh; lengths in centimetres from the dome's centre."""

    lens: Lens
    centre: Array  # (3,) of the mirror
    nodes: Array  # (rows, columns, 5) as `bourke` reads them
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
        return fisheye(traced(start, ways, centre, mirror, radius)[2], tilt)

    nodes = _with_brightness(warp_nodes(lens, NODES, shares))
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


def fisheye(points: Array, tilt: float) -> Array:
    """Shares (n, 2) of an equidistant fisheye of 180° for points (n, 3) on a dome about 0.

    NaN for points far below its rim. The front is below, as in `surround.directions`.
    """
    right, behind, middle = axes_of(0.0, math.pi / 2.0 - tilt)
    ways = points / np.linalg.norm(points, axis=1, keepdims=True)
    with np.errstate(invalid="ignore"):
        away = np.arccos(np.clip(ways @ middle, -1.0, 1.0)) / (math.pi / 2.0)
        aside = np.stack([ways @ right, ways @ behind], axis=1)
        aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-12)
        return np.where((away <= BEYOND)[:, None], 0.5 + 0.5 * away[:, None] * aside, np.nan)


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
    found = nodes.copy()
    found[..., 4] = np.where(nodes[..., 4] > 0, np.maximum(light, DIMMEST), -1.0)
    return found


def _lit_share(nodes: Array) -> float:
    """The share of the dome's area that a mesh lights."""
    rows, columns = nodes.shape[:2]
    k = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    triangles = np.concatenate(
        [np.stack([k, k + columns, k + 1], 1), np.stack([k + 1, k + columns, k + columns + 1], 1)]
    )
    flat = nodes.reshape(-1, 5)
    triangles = triangles[(flat[triangles, 4] > 0).all(axis=1)]
    seen = mesh(flat[:, 2:4], flat[:, 2:4], triangles)
    side = 200
    found = rasterized(seen, np.ones(len(flat)), (side, side)) > 0
    x, y = np.meshgrid((np.arange(side) + 0.5) / side, (np.arange(side) + 0.5) / side)
    away = np.hypot(x - 0.5, y - 0.5) * 2.0
    weight = np.where(away <= 1.0, np.sinc(away / 2.0), 0.0)
    return float((weight * found).sum() / weight.sum())
