"""Decode photographs of structured light: which pixel of a projector lights a pixel of a camera."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from subsea.base.arrays import Array, Bytes, Ints
from subsea.base.errors import UserError
from subsea.stage.calibration.optics import SeenLight
from subsea.stage.calibration.photographs import (
    MOST_MISMATCH,
    LightStep,
    light_of,
    mismatch,
    read_photograph,
)
from subsea.view.structured_light import COLUMNS, ROWS, STRIPE_PX, UNIFORM, from_gray

LEAST_LIGHT = 0.02  # of a projector's white in a usable photograph; 1: the camera's white
FAINT = 0.06  # share of the brightest light below which a pixel is not lit
DOUBTFUL = 0.15  # contrast of a bit, of that of white, below which it is not read
RESOLVED = 0.35  # median contrast of stripes that a camera can tell apart
CLIPPED, MOST_CLIPPED = 254, 0.1  # code value of an overexposed pixel, and the share allowed
BLOCKS = 6000  # of a projector, over which pixels are averaged
FEWEST = 12  # pixels of a block
OUTLIER = 2.5  # standard deviations

Size = tuple[int, int]


def decode(
    paths: Sequence[Path],
    steps: Sequence[LightStep],
    camera: int,
    done: Callable[[], object] = lambda: None,
) -> tuple[list[SeenLight], Size]:
    """Decode the photographs `paths` of one camera, one for each step.

    Returns what it saw of each projector that it saw, and the size of the photographs. `done` is
    called after each photograph. A UserError names a photograph that does not fit.
    """
    seen: list[SeenLight] = []
    size: Size | None = None
    begin = 0
    while begin < len(steps):
        channel = steps[begin].channel
        end = begin
        while end < len(steps) and steps[end].channel == channel:
            end += 1
        reader = PhotoReader(size, done)
        found = _decode_projector(paths[begin:end], steps[begin:end], camera, reader)
        size, begin = reader.size, end
        if found is not None:
            seen.append(found)
    assert size is not None
    return seen, size


class PhotoReader:
    """Reads photographs of one size."""

    def __init__(self, size: Size | None, done: Callable[[], object]) -> None:
        self.size, self._done = size, done

    def read(self, path: Path) -> Bytes:
        """Read a photograph (h, w, 3); a UserError if it has another size than those before."""
        picture = read_photograph(path)
        height, width, _ = picture.shape
        if self.size is not None and self.size != (width, height):
            expected = f"{self.size[0]}×{self.size[1]}"
            message = f"{width}×{height} pixels, expected {expected} as in those before"
            raise UserError(message, file=path)
        self.size = width, height
        self._done()
        return picture


def _decode_projector(
    paths: Sequence[Path], steps: Sequence[LightStep], camera: int, reader: PhotoReader
) -> SeenLight | None:
    """Decode the photographs of one projector; None if the camera saw nothing of it."""
    uniform = [reader.read(path) for path in paths[: len(UNIFORM)]]
    white, black = (_brightness(picture) for picture in uniform[:2])
    contrast = white - black
    brightest = float(np.percentile(contrast, 99.5))
    if brightest < LEAST_LIGHT:
        for path in paths[len(UNIFORM) :]:
            reader.read(path)
        return None
    lit = contrast > FAINT * brightest
    if (uniform[0][lit].max(axis=-1) >= CLIPPED).mean() > MOST_CLIPPED:
        raise UserError(
            f"overexposed where {steps[0].name!r} shines; expected a shorter exposure, the same "
            "for all photographs",
            file=paths[0],
        )
    rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
    box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    lit, white, black = lit[box], white[box], black[box]
    pairs = zip(steps[len(UNIFORM) :: 2], paths[len(UNIFORM) :: 2], paths[len(UNIFORM) + 1 :: 2],
                strict=True)  # fmt: skip
    codes = {axis: np.zeros(lit.shape, np.int32) for axis in (COLUMNS, ROWS)}
    doubts = {axis: np.zeros(lit.shape, np.int32) for axis in (COLUMNS, ROWS)}
    narrowest = {COLUMNS: 0, ROWS: 0}
    told = {COLUMNS: True, ROWS: True}
    for step, path, inverse_path in pairs:
        picture, inverse = (_brightness(reader.read(one)[box]) for one in (path, inverse_path))
        if mismatch(white, black, picture, inverse) > MOST_MISMATCH:
            raise UserError(
                f"does not show {step.words}, or {inverse_path.name} not its inverse; expected the "
                "photographs in the order of the patterns, and that nobody walks before the camera",
                file=path,
            )
        axis = step.pattern.axis
        assert axis is not None
        share = (picture - inverse) / np.where(lit, white - black, 1.0)
        told[axis] &= float(np.median(np.abs(share[lit]))) > RESOLVED
        if told[axis]:
            codes[axis] = 2 * codes[axis] + (share > 0.0)
            doubts[axis] += np.abs(share) < DOUBTFUL
            narrowest[axis] = step.pattern.bit
    valid = lit & (doubts[COLUMNS] <= 1) & (doubts[ROWS] <= 1)
    shown = np.stack(
        [
            (from_gray(codes[axis][valid]) + 0.5) * (STRIPE_PX << narrowest[axis])
            for axis in (COLUMNS, ROWS)
        ],
        axis=1,
    )
    y, x = np.nonzero(valid)
    if len(x) < FEWEST:
        return None
    light = np.stack([light_of(picture[box][valid]) for picture in uniform], axis=1)
    pixels = np.column_stack([x + columns[0] + 0.5, y + rows[0] + 0.5]).astype(np.float64)
    told_bits = narrowest[COLUMNS], narrowest[ROWS]
    return _blocks(SeenLight(steps[0].channel, camera, pixels, shown, light, told_bits))


def _blocks(seen: SeenLight) -> SeenLight:
    """Average pixels over square blocks, without those that do not fit into theirs."""
    side = max(round(np.sqrt(len(seen.pixels) / BLOCKS)), 4)
    cell = (seen.pixels // side).astype(np.int64)
    key = cell[:, 1] * (int(cell[:, 0].max()) + 1) + cell[:, 0]
    _, number = np.unique(key, return_inverse=True)
    count = np.bincount(number)
    mean = _means(seen.shown, number, count)
    spread = np.sqrt(_means((seen.shown - mean[number]) ** 2, number, count))
    widths = np.array([STRIPE_PX << bit for bit in seen.bits])
    away = np.abs(seen.shown - mean[number])
    kept = (away <= OUTLIER * np.maximum(spread[number], widths)).all(axis=1)
    number = number[kept]
    count = np.bincount(number, minlength=len(count))
    used = count >= min(FEWEST, side * side // 2)
    values = [_means(part[kept], number, count)[used] for part in
              (seen.pixels, seen.shown, seen.light.reshape(len(seen.light), -1))]  # fmt: skip
    return seen._replace(
        pixels=values[0], shown=values[1], light=values[2].reshape(-1, *seen.light.shape[1:])
    )


def _means(values: Array, number: Ints, count: Ints) -> Array:
    """The mean (blocks, k) of values (n, k) of each block."""
    sums = [np.bincount(number, column, minlength=len(count)) for column in values.T]
    return np.asarray(np.stack(sums, axis=1) / np.maximum(count, 1)[:, None])


def _brightness(picture: Bytes) -> Array:
    """The linear light (h, w) of a photograph (h, w, 3), 0 to 1."""
    return np.asarray(light_of(picture).mean(axis=2))
