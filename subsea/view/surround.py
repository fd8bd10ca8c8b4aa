"""Surround displays: six views on the faces of a cube, resampled to a wide picture.

Directions are (right, up, ahead) in the axes of the observer. The six faces lie on a canvas of
three columns and two rows; each is a little wider than a right angle, so that pixels at its edge
have neighbours to interpolate with.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.view.camera import axes_of
from subsea.view.rig import Rect

# Direction and up vector of each face, in canvas order: the lower row from the left, then the upper
# row. `shaders/resolve.frag` has the same order.
FACES = {
    "left": ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    "ahead": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "right": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    "below": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "astern": ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
    "above": ((0.0, 1.0, 0.0), (0.0, 0.0, -1.0)),
}
COLUMNS, ROWS = 3, 2
MARGIN_PX = 12  # by which a face is wider than a right angle: half the largest speck of plankton
STEPS = 256  # samples per side to find which parts of the faces a picture shows
UNSURE = 16.0 / STEPS  # largest distance of samples on a face, in half faces
LARGEST_FACE = 2560  # pixels; GPUs hold textures of three side by side


class Surround(NamedTuple):
    """Extent of a wide picture, degrees."""

    angle_deg: float = 160.0  # of a panorama, from left to right
    tilt_deg: float = 30.0  # of a dome toward the front; 0: zenith in the middle
    dome_deg: float = 180.0  # of a dome, from edge to edge

    @property
    def wide(self) -> tuple[float, float, float]:
        """All in radians, as `rig.DisplayPatch` has them."""
        angle, tilt, dome = np.radians(self)
        return float(angle), float(tilt), float(dome)


ALL_ROUND = Surround()


def face_size(display: str, size: tuple[int, int], surround: Surround) -> int:
    """Pixels of a side of a cube face: as fine as the picture at its finest, up to a limit."""
    width, height = size
    per_radian = {
        "equirectangular": width / (2 * np.pi),
        "dome": min(width, height) / np.radians(surround.dome_deg),
        "panorama": width / np.radians(surround.angle_deg),
    }[display]
    return int(np.clip(np.ceil(2 * per_radian), 16, LARGEST_FACE)) + 2 * MARGIN_PX


def on_faces(d: Array) -> tuple[Ints, Array]:
    """Face index (n,) of directions (n, 3), and position (n, 2) on it in [-1, 1]."""
    axes = np.array([[np.cross(up, ahead), up, ahead] for ahead, up in FACES.values()])
    number = np.argmax(axes[:, 2] @ d.T, axis=0)
    along = np.einsum("nij,nj->ni", axes[number], d)
    return number, along[:, :2] / along[:, 2:]


def visible_parts(
    display: str, size: tuple[int, int], surround: Surround, aside: float = 0.0
) -> list[Array | None]:
    """The part (4,) of each face in the picture: left, right, bottom, top in [-1, 1].

    None if the picture shows nothing of a face. The eye is `aside` to the right of the middle, as
    a share of the screen distance.
    """
    x, y = (np.linspace(0.0, pixels, STEPS + 1) for pixels in size)
    pixels = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    d = directions(display, size, surround, pixels) - [aside, 0.0, 0.0]
    number, place = on_faces(d[~np.isnan(d[:, 0])])
    parts: list[Array | None] = []
    for face in range(len(FACES)):
        samples = place[number == face]
        if not len(samples):
            parts.append(None)
            continue
        low, high = samples.min(axis=0) - UNSURE, samples.max(axis=0) + UNSURE
        parts.append(np.clip([low[0], high[0], low[1], high[1]], -1.0, 1.0))
    return parts


def inner(rect: Rect) -> Rect:
    """A picture on the canvas without its margin."""
    x, y, width, height = rect
    return x + MARGIN_PX, y + MARGIN_PX, width - 2 * MARGIN_PX, height - 2 * MARGIN_PX


def half_tangent(face: int) -> float:
    """Tangent of half the field of view of a face with its margin."""
    return face / (face - 2 * MARGIN_PX)


def directions(display: str, size: tuple[int, int], surround: Surround, pixels: Array) -> Array:
    """Directions (n, 3) of pixels (n, 2) from the lower left, as the shader; NaN outside a dome."""
    width, height = size
    x, y = np.asarray(pixels, np.float64).T / [[width], [height]]
    if display == "equirectangular":
        longitude, latitude = 2 * np.pi * (x - 0.5), np.pi * (y - 0.5)
        level = np.cos(latitude)
        return np.stack(
            [np.sin(longitude) * level, np.sin(latitude), np.cos(longitude) * level], axis=1
        )
    if display == "panorama":
        angle = np.radians(surround.angle_deg)
        longitude, rise = angle * (x - 0.5), angle * (y - 0.5) * height / width
        ways = np.stack([np.sin(longitude), rise, np.cos(longitude)], axis=1)
        return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))
    radius = min(width, height)
    p = (np.stack([x, y], axis=1) - 0.5) * [width, height] / (radius / 2)
    r = np.linalg.norm(p, axis=1)
    away = r * np.radians(surround.dome_deg) / 2
    right, behind, middle = axes_of(0.0, np.pi / 2 - np.radians(surround.tilt_deg))
    aside = p / np.maximum(r, 1e-9)[:, None]
    ways = np.cos(away)[:, None] * middle
    ways += np.sin(away)[:, None] * (aside[:, :1] * right + aside[:, 1:] * behind)
    ways[r > 1] = np.nan
    return ways
