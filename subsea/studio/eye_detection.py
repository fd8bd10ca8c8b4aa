"""Eye detection in a photograph: a dark disc with a paler ring around it.

Needs the extra `skin` (OpenCV).
"""

import cv2
import numpy as np

from subsea.base.arrays import Array, Bytes

PATCH = 96  # pixels each way of the searched square
GRAIN = 9.0  # radius of an eye in that square, pixels
PUPILS = 3.5, 4.5, 5.5, 6.5, 7.5  # radii of pupils in that square, pixels
FAR = 2.6  # greatest distance from the expected position, radii of an eye
DIRECTIONS = 16
WEAKEST = 0.2  # fraction of directions that may be dark: a lid, a band through the eye


def eye_near(colour: Bytes, place: Array, radius: float) -> tuple[Array, float]:
    """Return the likeliest eye near a point of a photograph (h, w, 3), and its contrast, 0 to 1.

    The contrast is the brightness of its ring less that of its disc. `radius` is in pixels.
    """
    scale = radius / GRAIN
    middle = (PATCH - 1) / 2
    back = np.array(
        [[scale, 0.0, place[0] - scale * middle], [0.0, scale, place[1] - scale * middle]]
    )
    smooth = cv2.GaussianBlur(colour, (0, 0), max(0.6 * scale, 0.1))
    patch = cv2.warpAffine(
        smooth, back, (PATCH, PATCH), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    grey = cv2.cvtColor(patch, cv2.COLOR_RGB2GRAY).astype(np.float32) / 255.0
    y, x = np.mgrid[:PATCH, :PATCH] - middle
    far = np.hypot(x, y)
    best, where = -1.0, (middle, middle)
    turn = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    for pupil in PUPILS:
        disc = _mean(grey, 0.7 * pupil)
        soft = _mean(grey, 0.25 * pupil)
        ring = np.stack([_shifted(soft, 1.45 * pupil * way) for way in ways])
        plain = np.quantile(ring, WEAKEST, axis=0) - disc
        plain[far > FAR * GRAIN] = -1.0
        k, j = np.unravel_index(plain.argmax(), plain.shape)
        if plain[k, j] > best:
            best, where = float(plain[k, j]), (float(j), float(k))
    return back[:, :2] @ where + back[:, 2], max(best, 0.0)


def _mean(grey: Array, radius: float) -> Array:
    """The means over discs."""
    reach = int(np.ceil(radius))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    disc = np.clip(radius + 0.5 - np.hypot(x, y), 0.0, 1.0).astype(np.float32)
    return np.asarray(cv2.filter2D(grey, -1, disc / disc.sum(), borderType=cv2.BORDER_REPLICATE))


def _shifted(grey: Array, by: Array) -> Array:
    """Shift a picture by `by` pixels."""
    matrix = np.array([[1.0, 0.0, by[0]], [0.0, 1.0, by[1]]])
    out = cv2.warpAffine(
        grey, matrix, grey.shape[::-1], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
    return np.asarray(out)
