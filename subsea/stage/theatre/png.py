"""PNG pictures of unknown origin, used for blend maps of projectors."""

import io
import struct

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from subsea.base.errors import UserError
from subsea.stage.theatre.archives import first_line

MAX_SIDE = 2**14  # pixels
MAX_PIXELS = 2**24  # 4096 by 4096
MAX_BYTES = 8 * MAX_PIXELS


def parse_png(data: bytes, where: str) -> NDArray[np.float32]:
    """Decode a picture (h, w, 3) from 0 to 1, upper row first; else a UserError at `where`.

    Its alpha channel is left out. Pillow reads grey pictures of 16 bits as they are, but only the
    upper 8 bits of each colour of a coloured one: as fine as the pictures that it is to blend.
    """
    if data[:8] != b"\x89PNG\r\n\x1a\n" or data[12:16] != b"IHDR" or len(data) < 24:
        raise UserError("not a PNG picture", file=where)
    width, height = struct.unpack_from(">II", data, 16)
    if not 0 < width * height <= MAX_PIXELS or max(width, height) > MAX_SIDE:
        raise UserError(
            f"{width}×{height} pixels, expected 1 to {MAX_PIXELS} of them, "
            f"{MAX_SIDE} a side at most",
            file=where,
        )
    grey: NDArray[np.float32]
    try:
        with Image.open(io.BytesIO(data), formats=("PNG",)) as image:
            if image.mode.startswith("I"):
                grey = np.asarray(image).astype(np.float32) / np.float32(65535)
            elif image.mode in ("1", "L", "LA"):
                grey = np.asarray(image.convert("L"), np.float32) / np.float32(255)
            else:
                return np.asarray(image.convert("RGB"), np.float32) / np.float32(255)
    except Exception as fault:  # Pillow raises nearly anything for a damaged file
        raise UserError(f"not a readable PNG picture ({first_line(fault)})", file=where) from fault
    grey = np.clip(grey, 0.0, 1.0)
    return np.broadcast_to(grey[..., None], (*grey.shape, 3))  # a third of the memory


def stretched(picture: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """Resize a picture (h, w, 3) with linear interpolation."""
    if picture.shape[:2] == (height, width):
        return picture
    layers = [Image.fromarray(np.ascontiguousarray(picture[..., k])) for k in range(3)]
    scaled = [one.resize((width, height), Image.Resampling.BILINEAR) for one in layers]
    return np.stack([np.asarray(one, np.float32) for one in scaled], axis=2).clip(0.0, 1.0)
