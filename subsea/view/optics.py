"""The way of light from the water to a pixel: a pinhole, a lens with distortion, and a flat port.

A picture is drawn by a pinhole in the water. Where light bends, the drawn picture is wider than the
wanted one, and each wanted pixel takes the value of the place that its ray comes from. Points are
projected by the exact formulas instead.

Axes of a camera: x right, y down, z ahead, cm, from the centre of its lens. The middle of the upper
left pixel is (0, 0), as in OpenCV.
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array, Bytes, Ints

T = TypeVar("T", bound=np.generic)

WATER_INDEX, GLASS_INDEX = 1.333, 1.52  # of refraction, sea water 1.34, BK7 glass 1.517
STEEPEST = float(np.tan(np.radians(80.0)))  # of a ray from the axis, in air
STEPS = 12  # of Newton's method; both maps are smooth
CLOSE_PX = 0.01  # a ray that misses its pixel by more has not converged
MOST_WIDER = 3.0  # sides of the drawn picture over those of the wanted one
MARGIN = 1.02  # of the drawn picture about the wanted rays
LOOKS = 4  # searches for the depth at which a ray through a port ends


class CameraLens(NamedTuple):
    """The distortion of a lens, with the names and formulas of OpenCV."""

    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0


class FlatPort(NamedTuple):
    """A flat window across the optical axis, with air between it and the lens."""

    gap_cm: float  # from the centre of the lens to the glass
    glass_cm: float = 0.5  # thickness
    glass_index: float = GLASS_INDEX
    water_index: float = WATER_INDEX

    @property
    def front_cm(self) -> float:
        """From the centre of the lens to the water."""
        return self.gap_cm + self.glass_cm

    @property
    def virtual_cm(self) -> float:
        """Distance before the lens at which rays near the axis seem to meet, below 0 behind it."""
        apparent = self.gap_cm + self.glass_cm / self.glass_index
        return self.front_cm - self.water_index * apparent


STRAIGHT = CameraLens()


@dataclass(frozen=True)
class Optics:
    """A camera without its place: the size and angle of its picture, and what bends light."""

    size: tuple[int, int]  # width, height, pixels
    field_deg: float  # angle from left to right without lens and port
    lens: CameraLens = STRAIGHT
    port: FlatPort | None = None

    def __post_init__(self) -> None:
        """Raise a ValueError for values that no camera has."""
        if not 1.0 <= self.field_deg <= 150.0:
            raise ValueError(f"field_deg: {self.field_deg!r}, expected degrees from 1 to 150")
        if not np.isfinite(self.lens).all():
            raise ValueError(f"lens: {self.lens!r}, expected finite numbers")
        port = self.port
        if port and not (
            0.0 <= port.gap_cm <= 100.0
            and 0.0 <= port.glass_cm <= 100.0
            and 1.0 <= port.glass_index <= 3.0
            and 1.0 <= port.water_index <= 2.0
        ):
            raise ValueError(
                f"port: {port!r}, expected distances from 0 to 100 cm, indices of refraction from "
                "1 to 3 for glass and from 1 to 2 for water"
            )

    @property
    def straight(self) -> bool:
        """True for a pinhole: nothing bends light."""
        return self.lens == STRAIGHT and self.port is None

    @property
    def focal_px(self) -> float:
        """The focal length, pixels."""
        return 0.5 * self.size[0] / float(np.tan(np.radians(self.field_deg) / 2))

    @property
    def middle(self) -> Array:
        """The pixel (2,) on the optical axis."""
        return (np.array(self.size, np.float64) - 1.0) / 2

    @property
    def intrinsics(self) -> Array:
        """The matrix K (3, 3) of OpenCV."""
        f, (cx, cy) = self.focal_px, self.middle
        return np.array([[f, 0.0, cx], [0.0, f, cy], [0.0, 0.0, 1.0]])

    def project(self, points: Array) -> Array:
        """Project points (…, 3) to pixels (…, 2); NaN for points behind the lens or its window.

        Points far outside the field, where the formula of the lens folds, are put at its edge.
        """
        points = np.asarray(points, np.float64)
        front = 0.0 if self.port is None else self.port.front_cm
        ahead = points[..., 2] > front
        z = np.where(ahead, points[..., 2], front + 1.0)
        if self.port is None:
            way = points[..., :2] / z[..., None]
        else:
            off = np.hypot(points[..., 0], points[..., 1])
            slope = air_slope(self.port, off, z)
            way = points[..., :2] * (slope / np.maximum(off, 1e-12))[..., None]
        pixels = self.focal_px * distort(self.lens, _within(self.lens, way)) + self.middle
        return np.where(ahead[..., None], pixels, np.nan)

    def rays(self, pixels: Array) -> tuple[Array, Array]:
        """Rays in the water of pixels (…, 2): where they begin (…, 3), and ways (…, 3) with z = 1.

        A point of a ray at depth z is begin + (z - begin[2]) way. A ValueError if the formula of
        the lens folds within the picture.
        """
        way = undistort(self.lens, (np.asarray(pixels, np.float64) - self.middle) / self.focal_px)
        if not (self.focal_px * np.abs(_missed(self.lens, way, pixels, self)) < CLOSE_PX).all():
            raise ValueError(f"{self.lens}: folds within a picture of {self.field_deg:g}°")
        ones = np.ones((*way.shape[:-1], 1))
        if self.port is None:
            return np.zeros((*way.shape[:-1], 3)), np.concatenate([way, ones], axis=-1)
        slope = np.linalg.norm(way, axis=-1)
        glass, water = (bent(slope, index) for index in self.port[2:])
        unit = way / np.maximum(slope, 1e-12)[..., None]
        off = self.port.gap_cm * slope + self.port.glass_cm * glass
        begin = np.concatenate([unit * off[..., None], self.port.front_cm * ones], axis=-1)
        return begin, np.concatenate([unit * water[..., None], ones], axis=-1)

    def points(self, depth: Array) -> Array:
        """Points (h, w, 3) at the depths (h, w) of all pixels; infinite depths give directions."""
        begin, way = _pixel_rays(self)
        far = ~np.isfinite(depth)
        reach = np.where(far, 1.0, depth - begin[..., 2])[..., None]
        return np.where(far[..., None], 0.0, begin) + reach * way


def _within(lens: CameraLens, way: Array) -> Array:
    """Ways (…, 2) shortened to where the formula of a lens is unique."""
    length = np.linalg.norm(way, axis=-1, keepdims=True)
    return way * np.minimum(1.0, unique_slope(lens) / np.maximum(length, 1e-12))


@cache
def unique_slope(lens: CameraLens) -> float:
    """The slope to the axis up to which the radial formula of a lens grows."""
    r = np.linspace(0.0, STEEPEST, 4000)
    falls = 1.0 + 3.0 * lens.k1 * r**2 + 5.0 * lens.k2 * r**4 + 7.0 * lens.k3 * r**6 <= 0.0
    return float(r[falls.argmax()]) if falls.any() else STEEPEST


def distort(lens: CameraLens, way: Array) -> Array:
    """Bend ways (…, 2), x / z and y / z, by the formula of OpenCV."""
    x, y = way[..., 0], way[..., 1]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
    bent_x = x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x * x)
    bent_y = y * radial + lens.p1 * (r2 + 2.0 * y * y) + 2.0 * lens.p2 * x * y
    return np.stack([bent_x, bent_y], axis=-1)


def undistort(lens: CameraLens, bent_way: Array) -> Array:
    """Invert `distort` by Newton's method."""
    if lens == STRAIGHT:
        return bent_way
    way = _within(lens, bent_way)
    for _ in range(STEPS):
        x, y = way[..., 0], way[..., 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
        slope = 2.0 * (lens.k1 + r2 * (2.0 * lens.k2 + 3.0 * lens.k3 * r2))
        xx = radial + slope * x * x + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x
        yy = radial + slope * y * y + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x
        xy = slope * x * y + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y
        off_x, off_y = np.moveaxis(distort(lens, way) - bent_way, -1, 0)
        area = xx * yy - xy * xy
        area = np.where(np.abs(area) < 1e-9, 1e-9, area)
        step = np.stack([yy * off_x - xy * off_y, xx * off_y - xy * off_x], axis=-1)
        way = _within(lens, way - step / area[..., None])
    return way


def _missed(lens: CameraLens, way: Array, pixels: Array, optics: Optics) -> Array:
    if lens == STRAIGHT:
        return np.zeros_like(way)
    return distort(lens, way) - (pixels - optics.middle) / optics.focal_px


def bent(slope: Array, index: float) -> Array:
    """The slope to the axis in a medium of a ray with a slope in air (Snell's law)."""
    sine = slope / np.sqrt(1.0 + slope * slope) / index
    return np.asarray(sine / np.sqrt(1.0 - sine * sine))


def air_slope(port: FlatPort, off: Array, z: Array) -> Array:
    """The slope in air of the ray to a point `off` the axis at a depth `z` before the lens.

    The distance from the axis is a concave function of the slope, so Newton's method from the slope
    near the axis rises to the solution.
    """
    reach = z - port.front_cm
    near = port.gap_cm + port.glass_cm / port.glass_index + reach / port.water_index
    slope = np.minimum(off / near, STEEPEST)
    for _ in range(STEPS):
        glass, water = bent(slope, port.glass_index), bent(slope, port.water_index)
        past = port.gap_cm * slope + port.glass_cm * glass + reach * water
        # d tan(b) / d tan(a) = cos³(a) / (n cos³(b))
        cos3 = (1.0 + slope * slope) ** -1.5
        grows = port.gap_cm + cos3 * (
            port.glass_cm * (1.0 + glass * glass) ** 1.5 / port.glass_index
            + reach * (1.0 + water * water) ** 1.5 / port.water_index
        )
        slope = np.clip(slope + (off - past) / grows, 0.0, STEEPEST)
    return np.asarray(slope)


def pixel_grid(size: tuple[int, int]) -> Array:
    """The middles (h, w, 2) of all pixels."""
    width, height = size
    x, y = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    return np.stack([x, y], axis=-1)


@cache
def _pixel_rays(optics: Optics) -> tuple[Array, Array]:
    return optics.rays(pixel_grid(optics.size))


class Canvas(NamedTuple):
    """The pinhole picture that is drawn for a camera."""

    size: tuple[int, int]
    focal_px: float
    ahead_cm: float  # of the pinhole before the lens

    @property
    def optics(self) -> Optics:
        """Return the pinhole as a camera."""
        field = 2.0 * np.degrees(np.arctan(0.5 * self.size[0] / self.focal_px))
        return Optics(self.size, float(field))


@cache
def canvas_of(optics: Optics) -> Canvas:
    """Choose the pinhole picture that covers all rays of a camera, as fine as its own pixels.

    A ValueError if that picture were too large.
    """
    if optics.straight:
        return Canvas(optics.size, optics.focal_px, 0.0)
    _, way = _pixel_rays(optics)
    apart = min(
        float(np.linalg.norm(np.diff(way[..., :2], axis=axis), axis=-1).min())
        for axis in (0, 1)
        if way.shape[axis] > 1
    )
    ahead = 0.0 if optics.port is None else optics.port.virtual_cm
    widest = MARGIN * np.abs(way[..., :2]).max(axis=(0, 1))
    if (widest > STEEPEST).any():
        raise ValueError(f"{optics.lens}: needs a view of more than 160°")
    focal = 1.0 / max(apart, 1e-9)
    most = MOST_WIDER * np.array(optics.size)
    focal = float(min(focal, *(most / (2.0 * widest))))
    if focal < 0.5 * optics.focal_px:
        raise ValueError(f"{optics.lens}: bends too much for a view of {optics.field_deg:g}°")
    width, height = (int(np.ceil(2.0 * focal * side)) + 2 for side in widest)
    return Canvas((width, height), focal, ahead)


def sources(optics: Optics, canvas: Canvas, depth: Array) -> Array:
    """Places (h, w, 2) on a canvas that the pixels of a camera show.

    `depth` (H, W) is that of the canvas. Rays through a port do not meet in one point, so the depth
    at which a ray ends is searched.
    """
    begin, way = _pixel_rays(optics)
    middle = (np.array(canvas.size) - 1.0) / 2
    if optics.port is None:
        return np.asarray(canvas.focal_px * way[..., :2] + middle)
    begin = begin - (0.0, 0.0, canvas.ahead_cm)
    z = np.full(way.shape[:-1], np.inf)
    for _ in range(LOOKS):
        far = ~np.isfinite(z)
        ends = begin + (np.where(far, 1.0, z) - begin[..., 2])[..., None] * way
        ends = np.where(far[..., None], way, ends)
        place = canvas.focal_px * ends[..., :2] / ends[..., 2:] + middle
        z = take_nearest(depth, place)
    return np.asarray(place)


def take_nearest(values: NDArray[T], places: Array) -> NDArray[T]:
    """Values (H, W, …) at the pixels nearest to places (h, w, 2)."""
    row, column = _nearest(values.shape, places)
    return np.asarray(values[row, column])


def _nearest(shape: tuple[int, ...], places: Array) -> tuple[Ints, Ints]:
    column = np.clip(np.rint(places[..., 0]).astype(np.int64), 0, shape[1] - 1)
    row = np.clip(np.rint(places[..., 1]).astype(np.int64), 0, shape[0] - 1)
    return row, column


def take_between(picture: Bytes, places: Array) -> Bytes:
    """Values of a picture (H, W, 3) at places (h, w, 2), linear between its pixels, as uint8."""
    height, width = picture.shape[:2]
    x, y = np.clip(places[..., 0], 0.0, width - 1.0), np.clip(places[..., 1], 0.0, height - 1.0)
    left = np.minimum(x.astype(np.int64), max(width - 2, 0))
    upper = np.minimum(y.astype(np.int64), max(height - 2, 0))
    right, lower = np.minimum(left + 1, width - 1), np.minimum(upper + 1, height - 1)
    s, t = (x - left)[..., None], (y - upper)[..., None]
    above = (1.0 - s) * picture[upper, left] + s * picture[upper, right]
    below = (1.0 - s) * picture[lower, left] + s * picture[lower, right]
    return np.asarray(np.rint((1.0 - t) * above + t * below), np.uint8)
