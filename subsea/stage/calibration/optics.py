"""The camera that took the photographs: its lens and place, found from what it saw.

Two models of lenses serve, both with two terms of radial distortion: an ordinary lens, r = f tan θ
(1 + k₁ tan² θ + k₂ tan⁴ θ) (Brown 1966), and a fisheye, r = f θ (1 + k₁ θ² + k₂ θ⁴) (Kannala and
Brandt 2006). θ is the angle between a ray and the axis, r its distance from the middle in pixels.

A camera is solved from reference points whose places on the screen are known, and from the light of
the projectors. A projector draws straight lines, so the points of the screen that its pixels light
are a projective picture of these pixels. They come out so with the right lens of the camera alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array
from subsea.stage.calibration.surface import LitSurface
from subsea.stage.theatre.screens import Flat

ORDINARY, FISHEYE = "ordinary", "fisheye"
WIDEST = {ORDINARY: np.radians(75.0), FISHEYE: np.radians(115.0)}  # largest θ
STEPS = 4000  # of the table of a lens
FOCAL = {ORDINARY: (0.6, 1.1, 1.8), FISHEYE: (0.3, 0.45)}  # first guesses, in sides of a photograph
POINT_PX = 1.0  # error of a marked reference point, in pixels of the photograph
LIGHT_PX = 0.7  # of a block of structured light, in pixels of the projector
BENT = 0.02  # usual distortion of a projector, as a share at the corner of its picture
CLEAN_PX = 3.0  # errors beyond this many times the expected ones count less and less
UPRIGHT = 0.03  # rms error, in sides of a photograph, of a first guess that is good enough
GROSS = 4.0  # median errors: blocks that are farther off may have moved the fit of a projector
STARTS, MEMBERS = 40, 7  # fits to a few blocks each; the best is another start
ROUNDS = 4  # in which the blocks of a projector are weighted
BLOCKS = 150  # of each projector that serve to solve a camera


class ReferencePoint(NamedTuple):
    """A point of the screen whose place in the room and in the photographs is known."""

    name: str
    at: Array  # (3,) from the eye, cm; of a dome only the direction counts
    pixel: tuple[float, float]  # from the upper left corner of the photographs


class SeenLight(NamedTuple):
    """Blocks of pixels of a camera that saw the stripes of a projector."""

    channel: int
    camera: int
    pixels: Array  # (n, 2) of the camera, from the upper left corner
    shown: Array  # (n, 2) of the projector, from its upper left corner
    light: Array  # (n, patterns, 3) linear light of the uniform pictures, 0 to 1
    bits: tuple[int, int] = (0, 0)  # narrowest bits of columns and rows that it could tell apart


@dataclass(frozen=True)
class PhotoCamera:
    """A camera: lens and pose."""

    size: tuple[int, int]  # of its photographs
    lens: str  # ORDINARY or FISHEYE
    focal: float  # pixels
    bend: tuple[float, float]  # k₁, k₂
    middle: tuple[float, float]  # of the axis, pixels from the middle of the photograph
    place: Array  # (3,) cm from the eye
    axes: Array  # (3, 3) rows right, up, ahead

    def rays(self, pixels: Array) -> Array:
        """The unit directions (n, 3) of pixels (n, 2), in the room; NaN beyond the lens."""
        away = np.asarray(pixels, np.float64) - (np.array(self.size) / 2.0 + self.middle)
        away = away * [1.0, -1.0]
        length = np.linalg.norm(away, axis=1)
        angles = np.linspace(0.0, WIDEST[self.lens], STEPS)
        reach = self._reach(angles)
        rising = np.maximum.accumulate(reach)  # a bent lens may turn back at its edge
        angle = np.interp(length, rising, angles, right=np.nan)
        across = away * (np.sin(angle) / np.maximum(length, 1e-12))[:, None]
        return np.asarray(np.column_stack([across, np.cos(angle)]) @ self.axes)

    def seen(self, points: Array) -> Array:
        """The pixels (n, 2) of points (n, 3) of the room."""
        ways = (points - self.place) @ self.axes.T
        length = np.linalg.norm(ways[:, :2], axis=1)
        angle = np.minimum(np.arctan2(length, ways[:, 2]), WIDEST[self.lens])
        away = ways[:, :2] * (self._reach(angle) / np.maximum(length, 1e-12))[:, None]
        return np.asarray(away * [1.0, -1.0] + np.array(self.size) / 2.0 + self.middle)

    def _reach(self, angle: Array) -> Array:
        """Distances from the axis, in pixels, of rays at an angle from it."""
        x = np.tan(angle) if self.lens == ORDINARY else angle
        return self.focal * x * (1.0 + self.bend[0] * x**2 + self.bend[1] * x**4)


class ProjectorLens(NamedTuple):
    """The lens of a projector: a projective picture with radial distortion."""

    matrix: Array  # (3, 4) from points of the room, or (3, 3) from places of a flat screen
    bend: float  # at the corners of the picture
    size: tuple[int, int]

    def straight(self, shown: Array) -> Array:
        """Pixels (n, 2) as a lens without distortion would show them."""
        middle = np.array(self.size) / 2.0
        away = shown - middle
        far = (away**2).sum(axis=1, keepdims=True) / (middle @ middle)
        return np.asarray(middle + away * (1.0 + self.bend * far))

    def pixels(self, surface: LitSurface, places: Array) -> Array:
        """The straight pixels (n, 2) that light places (n, 2)."""
        mapped = _known(surface, places, surface.points(places)) @ self.matrix.T
        return np.asarray(mapped[:, :2] / mapped[:, 2:])


def fit_projector(
    surface: LitSurface, points: Array, shown: Array, size: tuple[int, int], bend: float,
    doubt: bool = True,
) -> tuple[ProjectorLens, Array]:  # fmt: skip
    """Fit the lens of a projector to points (n, 3) that its pixels (n, 2) light.

    Returns it with the errors (n, 2) in pixels of the projector. The direct linear transformation
    (Hartley and Zisserman, §7.1) is repeated with its terms weighted by depth, so that it minimises
    errors in pixels, and by Cauchy's weights, as light may have been reflected on its way. It
    begins again with the least median error of fits to a few points (Rousseeuw 1984) if points are
    far off, unless `doubt` is False: a camera is still moved then.
    """
    lens = ProjectorLens(np.zeros((3, 4)), bend, size)
    target = lens.straight(shown)
    known = _known(surface, surface.places(points), points)
    inner, outer = _normaliser(known), _normaliser(np.column_stack([target, np.ones(len(target))]))
    ends = known @ inner.T
    u, v = (target * np.diag(outer)[:2] + outer[:2, 2]).T
    aim, zero = np.stack([u, v], axis=1), np.zeros_like(ends)
    rows = np.stack(
        [np.hstack([ends, zero, -u[:, None] * ends]), np.hstack([zero, ends, -v[:, None] * ends])],
        axis=1,
    )
    found, away = _reweighted(rows, ends, aim, _null_matrices(rows.reshape(2 * len(u), -1)))
    usual = float(np.median(away))
    if doubt and (away.max() > GROSS * usual or usual > CLEAN_PX * outer[0, 0]):
        some = np.random.default_rng(0).integers(len(u), size=(STARTS, MEMBERS))
        tries = _null_matrices(rows[some].reshape(STARTS, 2 * MEMBERS, -1))
        medians = np.median(_apart(ends @ np.swapaxes(tries, 1, 2), aim), axis=1)
        second = _reweighted(rows, ends, aim, tries[np.argmin(medians)])
        found, away = min((found, away), second, key=lambda one: float(np.median(one[1])))
    lens = lens._replace(matrix=np.linalg.inv(outer) @ found @ inner)
    mapped = known @ lens.matrix.T
    return lens, np.asarray(mapped[:, :2] / mapped[:, 2:] - target)


def _known(surface: LitSurface, places: Array, points: Array) -> Array:
    """Homogeneous coordinates of a projector's lit points: (n, 3) of a flat screen, else (n, 4)."""
    flat = surface.radius is None and isinstance(surface.screen, Flat)
    ends = places if flat else points
    return np.column_stack([ends, np.ones(len(ends))])


def _reweighted(rows: Array, ends: Array, aim: Array, found: Array) -> tuple[Array, Array]:
    """Improve a projection (3, k) of `ends` (n, k) to `aim` (n, 2); also return distances (n,)."""
    for _ in range(ROUNDS):
        mapped = ends @ found.T
        away, depth = _apart(mapped, aim), np.abs(mapped[:, 2])
        weight = 1.0 / np.maximum(depth, 1e-6 * depth.max())
        weight /= np.hypot(1.0, away / max(2.0 * float(np.median(away)), 1e-9))
        found = _null_matrices((rows * weight[:, None, None]).reshape(2 * len(rows), -1))
    return found, _apart(ends @ found.T, aim)


def _null_matrices(rows: Array) -> Array:
    """The matrices (..., 3, k) that rows (..., n, 3 k) take nearest to 0."""
    _, vectors = np.linalg.eigh(np.swapaxes(rows, -1, -2) @ rows)
    return np.asarray(vectors[..., 0].reshape(*rows.shape[:-2], 3, -1))


def _apart(mapped: Array, aim: Array) -> Array:
    """Distances (..., n) of homogeneous points (..., n, 3) from points (n, 2)."""
    depth = np.where(mapped[..., 2] == 0.0, 1e-12, mapped[..., 2])
    return np.asarray(
        np.hypot(mapped[..., 0] / depth - aim[:, 0], mapped[..., 1] / depth - aim[:, 1])
    )


def _normaliser(ends: Array) -> Array:
    """The matrix that moves homogeneous coordinates to mean 0 and a mean square of 1."""
    count = ends.shape[1] - 1
    mean, spread = ends[:, :count].mean(axis=0), max(float(ends[:, :count].std()), 1e-9)
    matrix = np.eye(count + 1) / spread
    matrix[:count, count] = -mean / spread
    matrix[count, count] = 1.0
    return matrix


class SolvedCamera(NamedTuple):
    """A camera with the errors of the points that it was solved from."""

    camera: PhotoCamera
    point_px: Array  # (n,) distances of reference points, pixels of the photograph
    light_px: float  # rms error of the projectors as lenses, in their pixels
    bends: dict[int, float]  # distortion of the projectors, by channel


def solve_camera(
    size: tuple[int, int],
    points: Sequence[ReferencePoint],
    seen: Sequence[SeenLight],
    surfaces: dict[int, LitSurface],
    sizes: dict[int, tuple[int, int]],
) -> SolvedCamera:
    """Find lens and pose of a camera with photographs of `size`.

    `seen` is what it saw of the projectors, `surfaces` and `sizes` are theirs by channel.
    """
    few = [_fewer(one) for one in seen]
    tries: list[tuple[float, int, SolvedCamera]] = []
    for quarter in range(4):  # cameras are upright as a rule
        for lens in (ORDINARY, FISHEYE):
            for share in FOCAL[lens]:
                first = _first_guess(size, points, lens, share * max(size), quarter * np.pi / 2.0)
                found = _refined(first, points, [], surfaces, sizes, bend=False)
                tries.append((float(np.square(found.point_px).mean()), len(tries), found))
        if min(tries)[0] < (UPRIGHT * max(size)) ** 2:
            break
    best = []
    for lens in (ORDINARY, FISHEYE):
        _, _, start = min(one for one in tries if one[2].camera.lens == lens)
        found = _refined(start.camera, points, few, surfaces, sizes)
        cost = np.square(found.point_px / POINT_PX).sum()
        cost += len(few) * BLOCKS * (found.light_px / LIGHT_PX) ** 2
        best.append((float(np.nan_to_num(cost, nan=np.inf)), found))
    return min(best, key=lambda one: one[0])[1]


def _fewer(seen: SeenLight) -> SeenLight:
    """Evenly chosen blocks, enough to solve a camera."""
    chosen = np.linspace(0, len(seen.pixels) - 1, min(BLOCKS, len(seen.pixels))).astype(int)
    return seen._replace(pixels=seen.pixels[chosen], shown=seen.shown[chosen])


def _first_guess(
    size: tuple[int, int], points: Sequence[ReferencePoint], lens: str, focal: float, roll: float
) -> PhotoCamera:
    """A camera at the eye that looks at the middle of the reference points."""
    at = np.array([point.at for point in points])
    unit = at / np.linalg.norm(at, axis=1, keepdims=True)
    ahead = unit.mean(axis=0)
    ahead /= max(np.linalg.norm(ahead), 1e-9)
    up = np.array([0.0, 1.0, 0.0]) if abs(ahead[1]) < 0.8 else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, ahead)
    right /= np.linalg.norm(right)
    up = np.cross(ahead, right)
    c, s = np.cos(roll), np.sin(roll)
    axes = np.stack([c * right + s * up, c * up - s * right, ahead])
    return PhotoCamera(size, lens, focal, (0.0, 0.0), (0.0, 0.0), np.zeros(3), axes)


def _refined(
    camera: PhotoCamera,
    points: Sequence[ReferencePoint],
    seen: Sequence[SeenLight],
    surfaces: dict[int, LitSurface],
    sizes: dict[int, tuple[int, int]],
    bend: bool = True,
) -> SolvedCamera:
    """Improve a camera by least squares; without `bend` only pose and focal length."""
    from scipy.optimize import least_squares

    at = np.array([point.at for point in points])
    marked = np.array([point.pixel for point in points])
    far = float(np.linalg.norm(at, axis=1).mean())
    side = float(max(camera.size))
    count = 11 if bend else 7

    def built(x: Array) -> PhotoCamera:
        turn = rotation_vector(x[:3])
        bends, middle = ((x[7], x[8]), (side * x[9], side * x[10])) if bend else ((0.0, 0.0),) * 2
        return replace(
            camera, axes=camera.axes @ turn, place=camera.place + far * x[3:6],
            focal=camera.focal * np.exp(x[6]), bend=bends, middle=middle,
        )  # fmt: skip

    def light_errors(built_camera: PhotoCamera, bends: Array) -> list[Array]:
        errors = []
        for one, projector_bend in zip(seen, bends, strict=True):
            surface = surfaces[one.channel]
            met = surface.meet(built_camera.place, built_camera.rays(one.pixels))
            kept = np.isfinite(met).all(axis=1)
            error = np.full(one.shown.shape, 50.0)
            if kept.sum() > 20:
                error[kept] = fit_projector(
                    surface, met[kept], one.shown[kept], sizes[one.channel], projector_bend,
                    doubt=False,
                )[1]  # fmt: skip
            errors.append(error)
        return errors

    def residuals(x: Array) -> Array:
        now = built(x)
        parts = [(now.seen(at) - marked).ravel() / POINT_PX]
        bends = BENT * x[count:]
        # All blocks of a projector weigh as much as BLOCKS, however many it has.
        parts += [
            error.ravel() / LIGHT_PX * np.sqrt(BLOCKS / max(len(error), 1))
            for error in light_errors(now, bends)
        ]
        prior = x[7:11] / [0.5, 0.5, 0.05, 0.05] if bend else x[:0]
        return np.nan_to_num(np.concatenate([*parts, prior, x[count:]]), nan=1e3)

    start = np.zeros(count + len(seen))
    if bend:
        start[7:11] = *camera.bend, *(np.array(camera.middle) / side)
    solved = least_squares(residuals, start, loss="soft_l1", f_scale=CLEAN_PX, max_nfev=40)
    found, bends = built(solved.x), BENT * solved.x[count:]
    errors = light_errors(found, bends)
    light = float(np.sqrt(np.mean(np.concatenate(errors) ** 2) * 2.0)) if errors else 0.0
    away = np.linalg.norm(found.seen(at) - marked, axis=1)
    channels = [one.channel for one in seen]
    return SolvedCamera(found, away, light, dict(zip(channels, bends.tolist(), strict=True)))


def rotation_vector(vector: Array) -> Array:
    """The rotation (3, 3) by a vector along its axis, as long as its angle (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)
