"""Encode textures as the bytes of PNG and WebP files."""

import io
import struct
import zlib

import numpy as np
from numpy.typing import NDArray
from PIL import Image

WEBP_QUALITY = 92  # of 100; opacity has no losses


def sheet_png(sheet: NDArray[np.uint8]) -> bytes:
    """Encode a colour texture (h, w, 4), bottom row first."""
    file = io.BytesIO()
    Image.fromarray(sheet[::-1]).save(file, "PNG")
    return file.getvalue()


def sheet_webp(sheet: NDArray[np.uint8]) -> bytes:
    """Encode a colour texture (h, w, 4), bottom row first, a sixth as large and with losses."""
    file = io.BytesIO()
    Image.fromarray(sheet[::-1]).save(file, "WEBP", quality=WEBP_QUALITY)
    return file.getvalue()


def png16(texels: NDArray[np.uint16]) -> bytes:
    """Encode texels (h, w, 3), top row first, with 16 bits a channel (not in Pillow)."""
    height, width, _ = texels.shape
    rows = texels.astype(">u2").view(np.uint8).reshape(height, -1)
    # Filter 2 stores differences from the row above: frames are similar.
    rows[1:] -= rows[:-1].copy()
    lines = np.concatenate([np.full((height, 1), 2, np.uint8), rows], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
    chunks = (b"IHDR", header), (b"IDAT", zlib.compress(lines.tobytes(), 6)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
