"""Read pictures of numbers for warps and blends: portable float maps and PNG."""

import io
import math
import re

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from subsea.base.errors import UserError
from subsea.base.pictures import naming_faults

MAX_PICTURE = 256 * 2**20  # bytes of a file
MAX_PIXELS = 2**24  # of a picture, which may be packed into far fewer bytes: 4096 by 4096
_HEADER = re.compile(rb"(P[Ff])\s+(\d{1,9})\s+(\d{1,9})\s+([-+.\deE]{1,40})(\s)")


def parse_pfm(data: bytes, where: str) -> NDArray[np.float32]:
    """Parse a portable float map; return its numbers (height, width, 3 or 1), upper row first.

    The header is three lines: ``PF`` for three numbers a pixel or ``Pf`` for one, width and height,
    and a scale whose sign tells the order of bytes, negative for little-endian. Numbers of 32 bits
    follow, the lowest row first (netpbm.sourceforge.net/doc/pfm.html). A UserError names `where`.
    """
    header = _HEADER.match(data[:256])
    if not header:
        raise UserError("not a PFM file, expected 'PF', width, height and scale", file=where)
    width, height = int(header[2]), int(header[3])
    try:
        scale = float(header[4])
    except ValueError:
        scale = 0.0
    if scale == 0.0 or not math.isfinite(scale):
        raise UserError(f"scale {header[4].decode()!r}, expected a number such as -1.0", file=where)
    channels = 3 if header[1] == b"PF" else 1
    begin, expected = header.end(), 4 * width * height * channels
    if len(data) - begin == expected + 1 and data[begin - 1 : begin + 1] == b"\r\n":
        begin += 1
    if len(data) - begin != expected or not expected:
        raise UserError(
            f"{width}×{height} points in {len(data) - begin} bytes of numbers, expected {expected}",
            file=where,
        )
    numbers = np.frombuffer(data, "<f4" if scale < 0 else ">f4", offset=begin)
    rows = numbers.reshape(height, width, channels)[::-1]
    return np.ascontiguousarray(rows, np.float32)


def parse_png(data: bytes, where: str) -> NDArray[np.float32]:
    """Decode a PNG picture (h, w, 3) from 0 to 1, upper row first; a UserError names `where`.

    Its alpha channel is left out. Pillow reads grey pictures of 16 bits as they are, but only the
    upper 8 bits of each colour of a coloured one: as fine as the pictures that it is to blend.
    """
    grey: NDArray[np.float32]
    opened = naming_faults("PNG picture", where)
    with opened, Image.open(io.BytesIO(data), formats=("PNG",)) as image:
        if image.width * image.height > MAX_PIXELS:
            raise UserError(
                f"{image.width}×{image.height} pixels, expected {MAX_PIXELS} at most", file=where
            )
        if image.mode.startswith("I"):
            grey = np.asarray(image).astype(np.float32) / np.float32(65535)
        elif image.mode in ("1", "L", "LA"):
            grey = np.asarray(image.convert("L"), np.float32) / np.float32(255)
        else:
            return np.asarray(image.convert("RGB"), np.float32) / np.float32(255)
    grey = np.clip(grey, 0.0, 1.0)
    return np.broadcast_to(grey[..., None], (*grey.shape, 3))  # a third of the memory


def stretched(picture: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """Resize a picture (h, w, 3) with linear interpolation."""
    if picture.shape[:2] == (height, width):
        return picture
    layers = [Image.fromarray(np.ascontiguousarray(picture[..., k])) for k in range(3)]
    scaled = [layer.resize((width, height), Image.Resampling.BILINEAR) for layer in layers]
    return np.stack([np.asarray(layer, np.float32) for layer in scaled], axis=2).clip(0.0, 1.0)
