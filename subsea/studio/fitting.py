"""Fit deformable meshes to the fish in a photograph automatically (Tu §5.2.1).

Segmentation and alignment of the species' shape alternate. Then the meshes snap to the outline of
the segmented fish, and to edges of the photograph near it. Needs the extra `skin` (OpenCV).
"""

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np

from subsea.base.arrays import Array, Bools, Bytes
from subsea.base.errors import UserError
from subsea.fish.surface import SurfacePlan
from subsea.studio.deformable_mesh import (
    DEFAULT,
    EdgeField,
    FishMeshes,
    edge_field,
    relax,
    set_rest_shape,
    transform,
)
from subsea.studio.lift import mesh_mask
from subsea.studio.photograph import (
    Photograph,
    downscale,
    eye_near,
    grab_cut,
    initial_masks,
    largest_region,
)
from subsea.studio.side_view import (
    centred_matrix,
    make_fish_meshes,
    outline,
    side_view,
    subdivide,
    to_picture,
)

COMPARE_SIDE = 128  # pixels of the longer side for comparing shapes
UNIT = 200.0  # pixels of a body length of the shape that is compared
BLUR = 2.5  # pixels by which both shapes are blurred
TILTS = np.radians([-60, -40, -20, 0, 20, 40, 60])  # starts of the search
TILT_COST = 0.04  # loss of likeness at a tilt of 90°: fishes are upright
DEPTH_COST = 0.25  # loss of likeness for the squared log of flatter or deeper than the species
SMALLEST, LARGEST = 0.003, 0.75  # fractions of the picture that a fish may fill
GOOD_LIKENESS = 0.955  # above it no other guess is tried
GUESS_SIZES = 0.95, 0.6  # of the largest fish that has room
BLANK = 1.0  # deviation of the colours, of 255, below which a picture is empty
EYE_WEIGHT = 0.25  # of the contrast of an eye against the likeness of shapes
EYE_CONTRAST = 0.12  # least contrast of an eye
EYE_OFFSET = 2.2  # greatest distance of an eye from its expected position, radii
BORDER_ANCHOR = 1.0  # λ of the anchors that hold the border meanwhile
LEAST_LIKENESS = 0.55  # below it no fish was found
ROUNDS = 2  # of segmenting again from a rough position
# Body lengths inside which all, and outside which nothing is fish, by stage.
WIDE, CLOSER, HELD = (0.12, 0.16), (0.05, 0.07), (None, 0.02)
COARSE_BLURS = 0.03, 0.015, 0.008  # body lengths, one after the other
EDGE_RANGE = 0.008  # body lengths from the segmented fish in which the photograph's edges count
EDGE_BLUR = 0.005  # of these edges, body lengths


class FishFit(NamedTuple):
    """A fish that was found in a photograph."""

    meshes: FishMeshes  # over the photograph
    mask: Bools  # (h, w) the segmented fish
    likeness: float  # of the species' shape to the mask, 0 to 1


def find_fish(photograph: Photograph, plan: SurfacePlan, flip: bool = False) -> FishFit:
    """Find the fish in a photograph and fit meshes to its outline; UserError if none is found.

    Its heading follows from shape and eye; `flip` reverses it.
    """
    colour, share = downscale(photograph)
    if photograph.opacity is None:
        mask, matrix, likeness = _segment(colour, plan)
    else:
        size = colour.shape[1::-1]
        opacity = cv2.resize(photograph.opacity, size, interpolation=cv2.INTER_AREA)
        mask = largest_region(opacity > 127)
        matrix, likeness = align_shape(plan, mask)
    if likeness < LEAST_LIKENESS:
        raise UserError(
            "no fish of this shape found; lay the mesh by hand, without --auto,"
            " or cut the fish out: clear pixels around it are taken for the background",
            file=photograph.path,
        )
    ways = [(matrix, likeness), align_shape(plan, mask, not _heads_right(matrix))]
    scores = []
    for one, score in ways:
        place = to_picture(one, np.array([plan.eye.at, plan.eye.height]))
        radius = plan.eye.radius * float(np.hypot(*one[:, 0]))
        _, contrast = eye_near(photograph.colour, (place + 0.5) / share - 0.5, radius / share)
        scores.append(score + EYE_WEIGHT * contrast)
    matrix, likeness = ways[int(scores[1] > scores[0]) ^ int(flip)]
    if photograph.opacity is None:
        right = _heads_right(matrix)
        for _ in range(ROUNDS):
            new = grab_cut(colour, _shape_trimap(plan, matrix, mask.shape, CLOSER))
            if not new.any():
                break
            mask = new
            matrix, likeness = align_shape(plan, mask, right)
    meshes = make_fish_meshes(plan, matrix)
    snap_to_outline(meshes, colour, mask)
    # Pixel centres are at whole numbers in both the small and the large picture.
    middle = np.full(2, 0.5 / share - 0.5)
    transform(meshes, np.eye(2) / share, np.zeros(2), middle)
    align_eye(meshes, photograph, plan)
    return FishFit(meshes, _enlarged(mask, photograph), likeness)


def align_eye(meshes: FishMeshes, photograph: Photograph, plan: SurfacePlan) -> None:
    """Deform the inside of the meshes so that the eye in the photograph is the species' eye.

    The border stays. Nothing moves without an eye of enough contrast nearby.
    """
    body, rest = meshes.body, side_view(plan).body
    column = float(np.interp(plan.eye.at, rest[4, :15, 0], np.arange(15)))
    j, t = int(column), column % 1.0
    heights = (1.0 - t) * rest[:, j, 1] + t * rest[:, j + 1, 1]
    row = float(np.interp(-plan.eye.height, -heights, np.arange(len(heights))))
    k, s = min(int(row), len(heights) - 2), row - min(int(row), len(heights) - 2)
    upper, lower = ((1.0 - t) * body.nodes[i, j] + t * body.nodes[i, j + 1] for i in (k, k + 1))
    here = (1.0 - s) * upper + s * lower
    radius = plan.eye.radius * meshes.length
    there, contrast = eye_near(photograph.colour, here, radius)
    if contrast < EYE_CONTRAST or np.hypot(*(there - here)) > EYE_OFFSET * radius:
        return
    held = np.zeros(body.edge_weight.shape, bool)
    held[[0, -1]] = held[:, [0, -1]] = True
    body.anchors[held] = body.nodes[held]
    inside = [(a, b) for a in (k, k + 1) for b in (j, j + 1) if not held[a, b]]
    for at in inside:
        body.anchors[at] = body.nodes[at] + there - here
    relax(meshes, None, DEFAULT._replace(anchor=BORDER_ANCHOR), still=0.01, most=600)
    body.anchors[:] = np.nan
    set_rest_shape(meshes)


def _heads_right(matrix: Array) -> bool:
    return bool(np.linalg.det(matrix[:, :2]) > 0.0)


def segment_under(photograph: Photograph, meshes: FishMeshes) -> Bools:
    """Segment the fish (h, w) near meshes that fit it well."""
    colour, share = downscale(photograph)
    inside = mesh_mask(meshes, photograph.colour.shape)
    size = colour.shape[1::-1]
    there = cv2.resize(inside.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.5
    mask = there
    if there.any():
        mask = grab_cut(colour, _trimap(there, share * meshes.length, *HELD))
    return _enlarged(mask, photograph) if mask.any() else inside


def _enlarged(mask: Bools, photograph: Photograph) -> Bools:
    """A mask of the small picture at the photograph's size, or the photograph's own opacity."""
    if photograph.opacity is not None:
        return np.asarray(photograph.opacity > 127)
    size = photograph.colour.shape[1::-1]
    large = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_CUBIC)
    return np.asarray(large > 0.5)


def _segment(colour: Bytes, plan: SurfacePlan) -> tuple[Bools, Array, float]:
    """Segment a small picture; return mask, matrix of the species, and likeness."""
    best: tuple[Bools, Array, float] = (np.zeros(colour.shape[:2], bool), np.eye(3)[:2], 0.0)
    blank = colour.std(axis=(0, 1)).max() < BLANK
    for guess in () if blank else (*initial_masks(colour), *_centred_guesses(colour, plan)):
        if best[2] > GOOD_LIKENESS:
            break
        for _ in range(1 + ROUNDS):
            mask = grab_cut(colour, guess)
            if not SMALLEST < mask.mean() < LARGEST:
                break
            matrix, likeness = align_shape(plan, mask)
            likeness -= _cut_off(mask)
            if likeness > best[2]:
                best = mask, matrix, likeness
            guess = _shape_trimap(plan, matrix, mask.shape, WIDE)
    return best


def _cut_off(mask: Bools) -> float:
    """The fraction of a mask's outline that lies on the picture's border."""
    k = 1 + max(1, round(0.01 * min(mask.shape)))  # the border that `initial_masks` leaves out
    rim = np.concatenate([mask[k], mask[-k - 1], mask[:, k], mask[:, -k - 1]])
    return float(rim.sum()) / max(1, int(_border(mask).sum()))


def _centred_guesses(colour: Bytes, plan: SurfacePlan) -> Iterator[Bytes]:
    """GrabCut labels of the species in the middle of the picture, in several sizes, both ways."""
    height, width = colour.shape[:2]
    middle = np.array([width / 2, height / 2])
    for size in GUESS_SIZES:
        for mirror in (1.0, -1.0):
            matrix = centred_matrix(width, height, plan)
            matrix[:, 2] -= middle
            matrix = np.diag([mirror * size, size]) @ matrix
            matrix[:, 2] += middle
            yield _shape_trimap(plan, matrix, colour.shape, WIDE)


def _shape_trimap(
    plan: SurfacePlan, matrix: Array, shape: tuple[int, ...], reach: tuple[float | None, float]
) -> Bytes:
    """GrabCut labels of the species' shape."""
    return _trimap(silhouette(plan, matrix, shape), float(np.hypot(*matrix[:, 0])), *reach)


def _trimap(inside: Bools, length: float, core: float | None, halo: float) -> Bytes:
    """GrabCut labels for a rough mask: sure fish from `core` body lengths inside it on, if given.

    Sure background begins `halo` body lengths outside.
    """
    here = inside.astype(np.uint8)
    deep = cv2.distanceTransform(here, cv2.DIST_L2, 5)
    far = cv2.distanceTransform(1 - here, cv2.DIST_L2, 5)
    guess = np.where(inside, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    if core is not None:
        guess[deep > min(core * length, 0.7 * deep.max())] = cv2.GC_FGD
    guess[far > halo * length] = cv2.GC_BGD
    return guess


def silhouette(plan: SurfacePlan, matrix: Array, shape: tuple[int, ...]) -> Bools:
    """The pixels (h, w) that the species covers in its own shape."""
    out = np.zeros(shape[:2], np.uint8)
    rest = side_view(plan)
    rings = [outline(subdivide(rest.body))]
    rings += [
        np.concatenate([fin.root, subdivide(np.stack([fin.root, fin.edge]))[1, ::-1]])
        for fin in rest.fins.values()
    ]
    for ring in rings:
        pixels = np.round(to_picture(matrix, ring) * 16.0).astype(np.int32)
        cv2.fillPoly(out, [pixels], 1, shift=4)
    return out.astype(bool)


def align_shape(
    plan: SurfacePlan, mask: Bools, heads_right: bool | None = None
) -> tuple[Array, float]:
    """Return the matrix (2, 3) that fits the species best to a mask, and their likeness."""
    share = min(1.0, COMPARE_SIDE / max(mask.shape))
    size = round(mask.shape[1] * share), round(mask.shape[0] * share)
    there = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    there = np.asarray(cv2.GaussianBlur(there, (0, 0), BLUR))
    shape = _Shape(plan)
    y, x = np.nonzero(there > 0.5)
    if len(x) < 10:
        return np.eye(3)[:2], 0.0
    middle = x.mean(), y.mean()
    zoom = float(np.log(np.sqrt(len(x) / shape.area)))
    shape.soften(zoom)
    spread = np.cov(np.stack([x, y]))
    axis = 0.5 * np.arctan2(2.0 * spread[0, 1], spread[0, 0] - spread[1, 1])
    best: tuple[float, Array, bool] = (-1.0, np.zeros(5), False)
    for right in (False, True) if heads_right is None else (heads_right,):
        tries = []
        for tilt in {*TILTS.tolist(), float(axis)}:
            start = np.array([*middle, zoom, 0.0, tilt])
            tries.append(_hill_climb(shape, there, start, right, 1))
        tries.sort(key=lambda one: -one[0])
        for _, values in tries[:3]:
            found = (*_hill_climb(shape, there, values, right, 5), right)
            best = max(best, found, key=lambda one: one[0])
    likeness, values, right = best
    matrix = shape.matrix(values, right) / share  # in pixels of the mask
    matrix[:, 2] += 0.5 / share - 0.5
    return matrix, likeness


class _Shape:
    """The silhouette of a species as a blurred picture."""

    def __init__(self, plan: SurfacePlan) -> None:
        own = np.array([[UNIT, 0.0, 0.15 * UNIT], [0.0, -UNIT, 0.65 * UNIT]])
        plain = silhouette(plan, own, (int(1.3 * UNIT), int(1.4 * UNIT)))
        y, x = np.nonzero(plain)
        self.area = len(x) / UNIT**2  # body lengths²
        self.middle = (x.mean() / UNIT - 0.15, 0.65 - y.mean() / UNIT)  # body lengths
        self.back = np.linalg.inv(np.vstack([own, [0.0, 0.0, 1.0]]))
        self.plain = plain.astype(np.float32)
        self.picture = self.plain

    def soften(self, zoom: float) -> None:
        """Blur the picture as it would be blurred at a log size of `zoom`."""
        blur = BLUR * UNIT / float(np.exp(zoom))
        self.picture = np.asarray(cv2.GaussianBlur(self.plain, (0, 0), blur))

    def matrix(self, values: Array, heads_right: bool) -> Array:
        """Body lengths to pixels; values are middle x and y, log size, log depth, tilt."""
        x, y, zoom, deep, tilt = values
        cos, sin = np.cos(tilt), np.sin(tilt)
        size = np.exp(zoom) * np.array([np.exp(-0.5 * deep), np.exp(0.5 * deep)])
        size[0] *= -1.0 if heads_right else 1.0
        turn = np.array([[cos, -sin], [sin, cos]]) @ np.diag(size * (1.0, -1.0))
        return np.column_stack([turn, np.array([x, y]) - turn @ self.middle])

    def likeness(self, there: Array, values: Array, heads_right: bool) -> float:
        """Dice coefficient with another picture, less costs of tilt and depth."""
        matrix = self.matrix(values, heads_right)
        onto = matrix[:, :2] @ self.back[:2]
        onto[:, 2] += matrix[:, 2]
        here = cv2.warpAffine(self.picture, onto, there.shape[::-1], flags=cv2.INTER_LINEAR)
        # Parts beyond the picture count too: the whole fish must be visible.
        own = self.area * float(np.exp(2.0 * values[2]))
        both = 2.0 * float(np.minimum(here, there).sum()) / (own + float(there.sum()))
        return both - TILT_COST * (values[4] / (0.5 * np.pi)) ** 2 - DEPTH_COST * values[3] ** 2


def _hill_climb(
    shape: _Shape, there: Array, values: Array, heads_right: bool, rounds: int
) -> tuple[float, Array]:
    """The likeness at a local maximum, and its values."""
    steps = np.array([4.0, 4.0, 0.12, 0.12, 0.15])
    best = shape.likeness(there, values, heads_right)
    for _ in range(rounds):
        before = -np.inf
        while best > before + 1e-3:
            before = best
            for k in range(len(values)):
                for sign in (1.0, -1.0):
                    while True:
                        other = values.copy()
                        other[k] += sign * steps[k]
                        now = shape.likeness(there, other, heads_right)
                        if now <= best + 1e-5:
                            break
                        best, values = now, other
        steps = steps / 2.0
    return best, values


def snap_to_outline(meshes: FishMeshes, colour: Bytes, mask: Bools) -> None:
    """Snap roughly placed meshes to the outline of a fish in a picture (h, w, 3).

    ``mask`` (h, w) is the segmented fish.
    """
    length = meshes.length
    for width in COARSE_BLURS:
        relax(meshes, edge_field(mask, max(width * length, 1.0)), still=0.02, most=600)
        set_rest_shape(meshes)
    border = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    off = cv2.distanceTransform(1 - border, cv2.DIST_L2, 5)
    near = np.exp(-0.5 * (off / max(EDGE_RANGE * length, 1.5)) ** 2).astype(np.float32)
    height = edge_field(colour, max(EDGE_BLUR * length, 1.0)).height * near
    down, right = np.gradient(height)
    field = EdgeField(height, np.dstack([right, down]).astype(np.float32))
    relax(meshes, field, still=0.02, most=600)


def outline_error(meshes: FishMeshes, mask: Bools) -> float:
    """Symmetric mean distance of the outlines of meshes and a mask (h, w), body lengths."""
    first, second = _border(mesh_mask(meshes, mask.shape)), _border(mask)
    if not first.any() or not second.any():
        return np.inf
    far = [
        cv2.distanceTransform((~one).astype(np.uint8), cv2.DIST_L2, 5) for one in (first, second)
    ]
    return float(0.5 * (far[0][second].mean() + far[1][first].mean()) / meshes.length)


def fin_errors(meshes: FishMeshes, plan: SurfacePlan) -> dict[str, float]:
    """Mean distance of each fin's root from the species' proportions, body lengths.

    No silhouette shows the border between body and fin. The species has it at a fraction of the
    way from the opposite border of the body to the edge of the fin. Fins that do not stand out of
    the body are left out.
    """
    rest, found = side_view(plan), {}
    for name, fin in meshes.fins.items():
        one = rest.fins[name]
        opposite = len(rest.body) - 1 - fin.row
        usual, begin = (
            fin.root_weights @ body[opposite] for body in (rest.body, meshes.body.nodes)
        )
        own, own_whole = _distances(usual, one.root), _distances(usual, one.edge)
        here, whole = (_distances(begin, row) for row in fin.mesh.nodes)
        off = np.abs(here - own / own_whole * whole)
        if one.shows.any():
            found[name] = float(off[one.shows].mean() / meshes.length)
    return found


def _distances(begin: Array, end: Array) -> Array:
    return np.asarray(np.hypot(*(end - begin).T))


def _border(mask: Bools) -> Bools:
    eroded = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8))
    return np.asarray(mask & (eroded == 0))
