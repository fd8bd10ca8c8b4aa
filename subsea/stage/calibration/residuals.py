"""Pictures of residuals: how far the light that cameras saw is from the mesh of a projector."""

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from subsea.base.arrays import Array, Bytes
from subsea.stage.calibration.meshes import MeasuredProjector

WIDE = 640  # pixels of the picture
CELL_PX = 10  # of the picture, over which residuals are averaged
NEAR_CELLS = 2.5  # a cell that is farther from those with blocks was not seen
WORST_PX = 2.0  # residual of the last colour, pixels of the projector
UNSEEN = 70, 70, 75
# Dark blue, green, yellow, red: from no residual to WORST_PX.
COLOURS = np.array([[20, 30, 90], [0, 140, 110], [250, 220, 60], [210, 30, 30]], float)


def residual_picture(name: str, measured: MeasuredProjector) -> Bytes:
    """The picture (h, w, 3) of a projector as it shines: the rms residual of each cell.

    Blocks of a camera may be farther apart than cells, so a cell without takes the nearest one's.
    """
    from scipy.ndimage import distance_transform_edt

    width, height = measured.size
    scale = WIDE / width
    columns, rows = WIDE // CELL_PX, max(round(height * scale / CELL_PX), 1)
    cell = np.minimum((measured.shown * scale / CELL_PX).astype(int), [columns - 1, rows - 1])
    number = cell[:, 1] * columns + cell[:, 0]
    count = np.bincount(number, minlength=rows * columns)
    total = np.bincount(number, (measured.error_px**2).sum(axis=1), minlength=rows * columns)
    rms = np.sqrt(total / np.maximum(count, 1)).reshape(rows, columns)
    empty = count.reshape(rows, columns) == 0
    away, (row, column) = distance_transform_edt(empty, return_indices=True)
    cells = np.where((away < NEAR_CELLS)[..., None], coloured(rms[row, column]), UNSEEN)
    body = np.kron(cells.astype(np.uint8), np.ones((CELL_PX, CELL_PX, 1), np.uint8))
    head = Image.new("RGB", (WIDE, 56), (250, 250, 247))
    draw, font = ImageDraw.Draw(head), ImageFont.load_default(15)
    words = f"{name}: {measured.rms_px:.2f} px rms"
    draw.text((8, 6), words, (40, 44, 50), font)
    ramp = coloured(np.linspace(0.0, WORST_PX, 240))
    for k, colour in enumerate(ramp.astype(int).tolist()):
        draw.line([(60 + k, 34), (60 + k, 48)], tuple(colour))
    draw.text((8, 32), "0 px", (40, 44, 50), font)
    draw.text((308, 32), f"{WORST_PX:g} px and more", (40, 44, 50), font)
    draw.rectangle([460, 34, 480, 48], UNSEEN)
    draw.text((488, 32), "not seen", (40, 44, 50), font)
    return np.concatenate([np.asarray(head), body])


def coloured(residual_px: Array) -> Array:
    """The colours (..., 3) of residuals in pixels."""
    at = np.clip(np.asarray(residual_px) / WORST_PX, 0.0, 1.0) * (len(COLOURS) - 1)
    known = np.arange(len(COLOURS))
    return np.stack([np.interp(at, known, COLOURS[:, k]) for k in range(3)], axis=-1)
