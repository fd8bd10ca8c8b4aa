"""Read a photograph of a fish, segment the fish from the background, and find its eye.

An eye is a dark disc with a paler ring around it. Needs the extra `skin` (OpenCV).
"""

import warnings
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from PIL import Image, ImageOps, UnidentifiedImageError

from subsea.base.arrays import Array, Bools, Bytes
from subsea.base.errors import UserError, unreadable
from subsea.base.files import check_input
from subsea.base.pictures import in_srgb

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


FORMATS = "JPEG", "PNG", "WEBP", "TIFF", "BMP", "GIF", "PPM", "AVIF", "JPEG2000"
MOST_BYTES = 200 << 20
MOST_PIXELS = 150_000_000
LEAST = 96  # pixels of the longer side
WORK = 1600  # longest side of a loaded photograph, pixels: a sheet is 1024 texels wide
SEGMENT_SIDE = 400  # the same, for segmentation
CLEAR = 0.005  # fraction of clear pixels from which on the opacity shows the fish
BAND = 0.06  # width of the border that is mostly background, of the shorter side
COLOURS = 6  # colour clusters of the background
ROUNDS = 3  # of GrabCut


class Photograph(NamedTuple):
    """Pixels, top row first."""

    path: Path
    colour: Bytes  # (h, w, 3) sRGB
    opacity: Bytes | None  # (h, w); None if opaque


def read_photograph(path: Path) -> Photograph:
    """Read a photograph upright, in sRGB and with at most `WORK` pixels on its longer side.

    UserError for a file that is not a picture, damaged, too large or too small.
    """
    size = check_input(path)
    try:
        if size > MOST_BYTES:
            raise UserError(f"{size >> 20} MiB, expected at most {MOST_BYTES >> 20} MiB", file=path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # sizes are checked below; odd tags do not matter
            with Image.open(path, formats=FORMATS) as image:
                return _decoded(path, image)
    except UnidentifiedImageError as fault:
        kinds = ", ".join(FORMATS)
        raise UserError(f"not a picture, expected one of {kinds}", file=path) from fault
    except Image.DecompressionBombError as fault:
        raise UserError(f"too many pixels, expected at most {_most()}", file=path) from fault
    except MemoryError as fault:
        raise UserError("too large for this computer's memory", file=path) from fault
    except OSError as fault:
        if fault.errno:
            raise unreadable(path, fault) from fault
        raise UserError(f"damaged or cut off ({fault})", file=path) from fault
    except (ValueError, TypeError, SyntaxError, EOFError, IndexError, KeyError) as fault:
        # Pillow's readers raise any of these for damaged files.
        raise UserError(f"damaged ({fault})", file=path) from fault


def _most() -> str:
    return f"{MOST_PIXELS // 1_000_000} million"


def _decoded(path: Path, image: Image.Image) -> Photograph:
    width, height = image.size
    if width * height > MOST_PIXELS:
        raise UserError(f"{width}×{height} pixels, expected at most {_most()}", file=path)
    if max(width, height) < LEAST or min(width, height) < LEAST // 4:
        raise UserError(
            f"{width}×{height} pixels, expected a longer side of {LEAST} or more", file=path
        )
    image.draft("RGB", (WORK, WORK))  # a huge JPEG need not be decoded completely
    ImageOps.exif_transpose(image, in_place=True)
    upright = image
    if upright.mode in ("P", "PA", "La", "RGBa") or "transparency" in upright.info:
        upright = upright.convert("RGBA")
    elif upright.mode == "1":
        upright = upright.convert("L")
    # Scale down before other conversions: a huge picture would take gigabytes.
    white = _white(upright) if upright.mode.startswith("I") or upright.mode == "F" else None
    if upright.mode.startswith("I;16"):  # Pillow cannot shrink these
        upright = upright.convert("I")
    upright.thumbnail((WORK, WORK), Image.Resampling.LANCZOS, reducing_gap=3.0)
    if white:
        upright = _eight_bits(upright, white)
    pixels = np.asarray(in_srgb(upright))
    opacity = np.ascontiguousarray(pixels[..., 3]) if pixels.shape[2] == 4 else None
    if opacity is not None and (opacity < 128).mean() < CLEAR:
        opacity = None
    return Photograph(path, np.ascontiguousarray(pixels[..., :3]), opacity)


def _white(image: Image.Image) -> float:
    """The white level of 16-bit or floating-point greys."""
    if image.mode.startswith("I;16"):
        return 65535.0
    most = float(np.fmax.reduce(np.asarray(image), axis=None))  # ignores NaN
    if not most > 0.0:
        return 1.0
    return next((white for white in (1.0, 255.0, 65535.0) if most <= white), most)


def _eight_bits(image: Image.Image, white: float) -> Image.Image:
    """Convert 16-bit or floating-point greys to eight bits."""
    values = np.nan_to_num(np.asarray(image, np.float64))
    grey = (255.0 * np.clip(values / white, 0.0, 1.0)).round().astype(np.uint8)
    out = Image.fromarray(grey)
    out.info = image.info
    return out


def downscale(photograph: Photograph) -> tuple[Bytes, float]:
    """The colours scaled down for segmentation, and the scale."""
    colour = photograph.colour
    height, width = colour.shape[:2]
    share = min(1.0, SEGMENT_SIDE / max(height, width))
    size = max(1, round(width * share)), max(1, round(height * share))
    return np.asarray(cv2.resize(colour, size, interpolation=cv2.INTER_AREA), np.uint8), share


def initial_masks(colour: Bytes) -> list[Bytes]:
    """GrabCut labels of first guesses: salient pixels, then the middle of the picture."""
    height, width = colour.shape[:2]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    off = np.hypot((x - width / 2) / (0.42 * width), (y - height / 2) / (0.36 * height))
    middle = off < 1.0
    salient = _saliency(colour) * np.exp(-0.5 * off**2)
    level = salient / max(float(salient.max()), 1e-6) * 255.0
    threshold, _ = cv2.threshold(level.astype(np.uint8), 0, 255, cv2.THRESH_OTSU)
    edge = max(1, round(0.01 * min(height, width)))
    out = []
    for inside in (level > threshold, middle):
        guess = np.where(inside, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
        guess[:edge], guess[-edge:], guess[:, :edge], guess[:, -edge:] = (cv2.GC_BGD,) * 4
        out.append(guess)
    return out


def _saliency(colour: Bytes) -> Array:
    """Distance of colours (h, w, 3) from those of the border, in standard deviations."""
    lab = np.asarray(cv2.cvtColor(cv2.GaussianBlur(colour, (0, 0), 1.5), cv2.COLOR_RGB2LAB))
    lab = lab.astype(np.float32)
    height, width = lab.shape[:2]
    band = max(2, round(BAND * min(height, width)))
    near = np.zeros((height, width), bool)
    near[:band], near[-band:], near[:, :band], near[:, -band:] = (True,) * 4
    around = lab[near]
    cv2.setRNGSeed(1)
    ends = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 20, 0.5)
    count = min(COLOURS, len(around))
    _, which, middles = cv2.kmeans(around, count, None, ends, 2, cv2.KMEANS_PP_CENTERS)
    far = np.full((height, width), np.inf, np.float32)
    for k, middle in enumerate(middles):
        mine = around[which[:, 0] == k]
        if len(mine) < 0.02 * len(around):
            continue  # a corner of the fish that reaches the border
        wide = mine.std(axis=0) + 4.0
        far = np.minimum(far, np.sqrt((((lab - middle) / wide) ** 2).sum(axis=2)))
    return np.asarray(cv2.GaussianBlur(np.minimum(far, 12.0), (0, 0), 2.0))


def grab_cut(colour: Bytes, guess: Bytes) -> Bools:
    """Segment the fish in `colour` (h, w, 3) by GrabCut from a guess of labels."""
    words = guess.copy()
    fish = (words == cv2.GC_FGD) | (words == cv2.GC_PR_FGD)
    if not fish.any() or fish.all():
        return np.zeros(fish.shape, bool)
    cv2.setRNGSeed(1)  # for the clustering of its colours
    smooth = cv2.bilateralFilter(colour, 5, 25, 3)
    try:
        cv2.grabCut(
            smooth, words, None, np.zeros((1, 65)), np.zeros((1, 65)), ROUNDS, cv2.GC_INIT_WITH_MASK
        )
    except cv2.error:  # too few colours for its clusters
        return largest_region(fish)
    return largest_region((words == cv2.GC_FGD) | (words == cv2.GC_PR_FGD))


def largest_region(mask: Bools) -> Bools:
    """The largest region of a mask (h, w), opened and without holes."""
    reach = max(1, round(0.004 * max(mask.shape)))
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1,) * 2)
    opened = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, disc)
    count, pieces, about, _ = cv2.connectedComponentsWithStats(opened)
    if count < 2:
        return np.zeros(mask.shape, bool)
    largest = (pieces == 1 + int(np.argmax(about[1:, cv2.CC_STAT_AREA]))).astype(np.uint8)
    around = np.pad(1 - largest, 1, constant_values=1)
    _, outside = cv2.connectedComponents(around, connectivity=4)
    return np.asarray((outside != outside[0, 0])[1:-1, 1:-1])
