"""Bodies of fishes in a picture: their triangles, the pixels that they cover, and their motion."""

from typing import NamedTuple

import numpy as np
from PIL import Image, ImageFilter

from subsea.base.arrays import Array, Bools, Ints
from subsea.fish.color_sheet import sheets
from subsea.fish.mesh import DETAILS, fish_mesh
from subsea.fish.species import Species
from subsea.frame.packet import KIND, Packet
from subsea.kernels import kernel
from subsea.lab.dataset.optics import Optics
from subsea.rendering.fish.atlas import side_by_side
from subsea.rendering.fish.fishes import DrawnVertices, FishShape

AROUND = 10  # texels, half of the way from one vertex to the next
SEEN = 0.5  # opacity from which a pixel shows a body and not what is behind it
NEAR_CM = 1.0  # nearer things are not drawn


class Shapes:
    """The vertices of all levels of detail of the species of a world."""

    def __init__(self, species: tuple[Species, ...], length_cm: tuple[float, ...]) -> None:
        """Prepare the shader for all levels."""
        self.skins = Skins(species)
        self._levels = [FishShape(species, length_cm, level) for level in range(len(DETAILS))]
        meshes = [fish_mesh(detail) for detail in DETAILS]
        # Without the back sides of fins, which have the same vertices.
        self.triangles = [mesh.triangles[: mesh.body + mesh.fins] for mesh in meshes]

    def at(self, level: int, instances: Array, control_points: Array) -> "Vertices":
        """Compute the vertices of instances (n, 30)."""
        shape, kinds = self._levels[level], instances[:, KIND].astype(int)
        drawn = shape.at(instances, control_points)
        opacity = np.where(shape.present[kinds], self.skins.opacity(kinds, drawn), np.nan)
        return Vertices(drawn.places.astype(np.float64), opacity)


class Vertices(NamedTuple):
    """The m vertices of n bodies."""

    places: Array  # (n, m, 3) cm, world
    opacity: Array  # (n, m) of the skin, 0 to 1; NaN for fins that the species lacks


class Skins:
    """The opacity of the skins of species, which the fins' edges lack."""

    def __init__(self, species: tuple[Species, ...]) -> None:
        """Paint the skins, or read them from the disk."""
        mean = ImageFilter.BoxBlur(AROUND)
        alphas = [side_by_side([sheet])[..., 3] for sheet in sheets(species)]
        self._mean = [np.asarray(Image.fromarray(one).filter(mean)) for one in alphas]

    def opacity(self, kinds: Ints, drawn: DrawnVertices) -> Array:
        """Look up the mean opacity (n, m) around vertices of fishes of the species `kinds` (n,)."""
        out = np.empty(drawn.skin.shape[:2])
        for kind in np.unique(kinds):
            sheet = self._mean[kind]
            limit = np.array(sheet.shape[::-1])
            place = (drawn.skin[kinds == kind] * limit).astype(np.int64)
            column, row = np.moveaxis(np.clip(place, 0, limit - 1), -1, 0)
            out[kinds == kind] = sheet[row, column] / 255.0
        return out


def levels_of(packet: Packet) -> Ints:
    """The level of detail (n,) of each instance of the first view; specks have the coarsest."""
    levels = np.zeros(len(packet.instances), np.int64)
    for batch in packet.batches[0]:
        levels[batch.first : batch.first + batch.count] = min(batch.level, len(DETAILS) - 1)
    return levels


class Coverage(NamedTuple):
    """The pixels of a picture (h, w) that bodies cover."""

    gap_cm: Array  # (h, w) between the depth that is drawn and that of the nearest triangle
    moved: Array  # (h, w, 6) cm, world: the same place of the skin a tick before and after
    stamp: Ints  # (h, w) for `cover`


def empty_coverage(size: tuple[int, int]) -> Coverage:
    """Make the coverage of a picture before any body."""
    shape = size[::-1]
    return Coverage(
        np.full(shape, np.inf, np.float32), np.full((*shape, 6), np.nan), np.zeros(shape, np.int64)
    )


@kernel
def cover(
    pixels: Array, corners: Array, triangles: Ints, others: Array, values: Ints,
    seen: tuple[Ints, Array], coverage: tuple[Array, Array, Ints], mark: int,
) -> Ints:  # fmt: skip
    """Enter bodies into a coverage; returns how many pixels of each are hidden (n,).

    `pixels` (n, m, 2) are the vertices in the picture, `corners` (n, m, 2) their depths, cm or NaN,
    and opacities, `others` (n, m, 6) the vertices a tick before and after, `values` (n,) the
    identities, `seen` the maps of identity and depth (h, w). `mark` is a number that no call before
    had, and the next n.
    """
    identity, depth = seen
    gap, moved, stamp = coverage
    high, wide = identity.shape
    hidden = np.zeros(len(values), np.int64)
    for i in range(len(values)):
        for k in range(len(triangles)):
            a, b, c = triangles[k]
            za, zb, zc = corners[i, a, 0], corners[i, b, 0], corners[i, c, 0]
            if not (za > 0.0 and zb > 0.0 and zc > 0.0):
                continue
            ax, ay = pixels[i, a, 0], pixels[i, a, 1]
            bx, by = pixels[i, b, 0] - ax, pixels[i, b, 1] - ay
            cx, cy = pixels[i, c, 0] - ax, pixels[i, c, 1] - ay
            area = bx * cy - cx * by
            if abs(area) < 1e-12:
                continue
            left = max(int(np.ceil(ax + min(0.0, bx, cx))), 0)
            right = min(int(np.floor(ax + max(0.0, bx, cx))), wide - 1)
            top = max(int(np.ceil(ay + min(0.0, by, cy))), 0)
            bottom = min(int(np.floor(ay + max(0.0, by, cy))), high - 1)
            for y in range(top, bottom + 1):
                for x in range(left, right + 1):
                    own = identity[y, x] == values[i]
                    if not own and stamp[y, x] == mark + i:
                        continue
                    px, py = x - ax, y - ay
                    s = (px * cy - cx * py) / area
                    t = (bx * py - px * by) / area
                    if s < 0.0 or t < 0.0 or s + t > 1.0:
                        continue
                    wa, wb, wc = (1.0 - s - t) / za, s / zb, t / zc
                    z = 1.0 / (wa + wb + wc)
                    if own:
                        off = abs(z - depth[y, x])
                        if off < gap[y, x]:
                            gap[y, x] = off
                            for q in range(6):
                                moved[y, x, q] = z * (
                                    wa * others[i, a, q] + wb * others[i, b, q]
                                    + wc * others[i, c, q]
                                )  # fmt: skip
                    elif depth[y, x] < z:
                        opacity = wa * corners[i, a, 1] + wb * corners[i, b, 1]
                        if z * (opacity + wc * corners[i, c, 1]) < SEEN:
                            continue
                        stamp[y, x] = mark + i
                        hidden[i] += 1
    return hidden


def whole_boxes(optics: Optics, points: Array, opacity: Array, triangles: Ints) -> Array:
    """Boxes (n, 4) of whole bodies: left, upper, right, lower edge in pixels; NaN out of sight.

    `points` (n, m, 3) are the vertices in the axes of the camera, `opacity` (n, m) is NaN for those
    that are not there. Boxes end at the picture's edge.
    """
    near = NEAR_CM + (0.0 if optics.port is None else optics.port.front_cm)
    edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
    a, b = edges.T
    shown: Bools = np.greater_equal(opacity, SEEN)
    # The ends of edges along which the skin fades, at the place where it no longer shows.
    fades = shown[:, a] != shown[:, b]
    who, edge = np.nonzero(fades & ~np.isnan(opacity[:, a] + opacity[:, b]))
    from_, to = (opacity[who, side[edge]] for side in (a, b))
    share = ((SEEN - from_) / (to - from_))[:, None]
    ends = (1.0 - share) * points[who, a[edge]] + share * points[who, b[edge]]
    low, high = np.full((len(points), 2), np.inf), np.full((len(points), 2), -np.inf)

    def enter(who: Ints, places: Array) -> None:
        pixels = optics.project(places)
        np.minimum.at(low, who, pixels)
        np.maximum.at(high, who, pixels)

    ahead = points[..., 2] > near
    for rows, places in ((np.nonzero(shown & ahead)[0], points[shown & ahead]), (who, ends)):
        front = places[:, 2] > near
        enter(rows[front], places[front])
    # Where a body reaches behind the camera, it ends at the nearest plane that is drawn.
    cut = np.flatnonzero((shown & ahead).any(axis=1) & (shown & ~ahead).any(axis=1))
    for i in cut:
        both = shown[i, a] & shown[i, b] & (ahead[i, a] != ahead[i, b])
        p, q = points[i, a[both]], points[i, b[both]]
        share = (near * (1.0 + 1e-9) - p[:, 2]) / (q[:, 2] - p[:, 2])
        enter(np.full(len(p), i), p + share[:, None] * (q - p))
    limit = np.array(optics.size) - 0.5
    inside = np.all([*(low < limit).T, *(high > -0.5).T], axis=0)
    boxes = np.concatenate([np.clip(low, -0.5, limit), np.clip(high, -0.5, limit)], axis=1)
    return np.where(inside.reshape(-1, 1), boxes, np.nan)
