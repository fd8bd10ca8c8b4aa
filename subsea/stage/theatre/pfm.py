"""Portable float maps with three numbers (``PF``) or one (``Pf``) a pixel, used for warps.

The header is three lines: ``PF``, width and height, and a scale whose sign tells the order of
bytes, negative for little-endian. Numbers of 32 bits follow, the lowest row first
(netpbm.sourceforge.net/doc/pfm.html). In memory the upper row is the first, as in all pictures
here.
"""

import math
import re

import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError

MAX_POINTS = 2**23  # a projector of 4096 by 2048 pixels, a point for each
MAX_BYTES = 12 * MAX_POINTS + 256

_HEADER = re.compile(rb"(P[Ff])\s+(\d{1,9})\s+(\d{1,9})\s+([-+.\deE]{1,40})(\s)")


def parse_pfm(data: bytes, where: str) -> NDArray[np.float32]:
    """The numbers (height, width, 3 or 1) of a file, upper row first; a UserError names `where`."""
    header = _HEADER.match(data[:256])
    if not header:
        raise UserError("not a PFM file, expected 'PF', width, height and scale", file=where)
    kind, width, height = header[1], int(header[2]), int(header[3])
    if not 0 < width * height <= MAX_POINTS:
        raise UserError(f"{width}×{height} points, expected 1 to {MAX_POINTS} of them", file=where)
    try:
        scale = float(header[4])
    except ValueError:
        scale = 0.0
    if scale == 0.0 or not math.isfinite(scale):
        raise UserError(f"scale {header[4].decode()!r}, expected a number such as -1.0", file=where)
    channels = 3 if kind == b"PF" else 1
    begin, expected = header.end(), 4 * width * height * channels
    if len(data) - begin == expected + 1 and data[begin - 1 : begin + 1] == b"\r\n":
        begin += 1
    if len(data) - begin != expected:
        raise UserError(f"{len(data) - begin} bytes of numbers, expected {expected}", file=where)
    numbers = np.frombuffer(data, "<f4" if scale < 0 else ">f4", offset=begin)
    rows = numbers.reshape(height, width, channels)[::-1]
    return np.ascontiguousarray(rows, np.float32)
