"""From the light of a picture to the bytes of a file: blur, noise, compression; maps as PNG."""

import io
import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

from subsea.base.arrays import Array, Bytes, Ints

MIDDLE = 128.0  # grey at which noise has its nominal strength
DARK = 0.1  # variance of noise in the dark, over that of a middle grey
MM = 10.0  # per cm
FLOW_STEPS, FLOW_ZERO = 64.0, 2**15  # of KITTI: values a pixel, value of no flow


def sensed(picture: Bytes, blur_px: float, noise: float, seed: list[int]) -> Bytes:
    """Blur a picture (h, w, 3) and add the noise of a sensor, which grows with light."""
    if blur_px > 0.0:
        blurred = Image.fromarray(picture).filter(ImageFilter.GaussianBlur(blur_px))
        picture = np.asarray(blurred)
    if noise > 0.0:
        grain = np.random.default_rng(seed).standard_normal(picture.shape, np.float32)
        light = picture.astype(np.float32)
        strength = noise * np.sqrt(DARK + (1.0 - DARK) * light / MIDDLE)
        picture = np.clip(np.rint(light + strength * grain), 0, 255).astype(np.uint8)
    return picture


def jpeg(picture: Bytes, quality: int) -> bytes:
    """Compress a picture."""
    file = io.BytesIO()
    Image.fromarray(picture).save(file, "JPEG", quality=quality)
    return file.getvalue()


def png(values: NDArray[Any]) -> bytes:
    """Write an array (h, w) or (h, w, 3) of 8 or 16 bits as PNG.

    Pillow writes no colours of 16 bits. Each row is stored as its difference from the one above.
    """
    high, wide = values.shape[:2]
    rows = np.ascontiguousarray(values.astype(values.dtype.newbyteorder(">")))
    data = rows.view(np.uint8).reshape(high, -1)
    data[1:] -= data[:-1].copy()
    filtered = np.concatenate([np.full((high, 1), 2, np.uint8), data], axis=1)
    colour = 2 if values.ndim == 3 else 0
    head = struct.pack(">IIBBBBB", wide, high, 8 * values.itemsize, colour, 0, 0, 0)
    parts = (b"IHDR", head), (b"IDAT", zlib.compress(filtered.tobytes(), 1)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(part)) + kind + part + struct.pack(">I", zlib.crc32(kind + part))
        for kind, part in parts
    )


def depth_map(depth: Array) -> NDArray[np.uint16]:
    """Round depths (h, w) in cm to millimetres; 0 in open water."""
    found = np.where(np.isfinite(depth), np.rint(MM * depth), 0.0)
    return np.minimum(found, 2**16 - 1).astype(np.uint16)


def normal_map(normal: Array) -> Bytes:
    """Round normals (h, w, 3) to 8 bits: 128 + 127 n; 0 in open water."""
    return np.where(np.isnan(normal), 0.0, np.rint(128.0 + 127.0 * normal)).astype(np.uint8)


def flow_map(flow: Array) -> NDArray[np.uint16]:
    """Write flow (h, w, 2) as KITTI does: 64 steps a pixel about 2^15; then 1 where it is known."""
    known = ~np.isnan(flow[..., 0])
    steps = np.rint(np.float32(FLOW_STEPS) * flow) + np.float32(FLOW_ZERO)
    out = np.zeros((*known.shape, 3), np.uint16)
    out[known, :2] = np.clip(steps[known], 0, 2**16 - 1)
    out[..., 2] = known
    return out


def run_lengths(places: Ints, pixels: int) -> list[int]:
    """Run lengths of a mask with these `places` among `pixels`, beginning with what is not in it.

    COCO counts down the columns, so places are ascending numbers in that order.
    """
    if not len(places):
        return [pixels]
    breaks = np.flatnonzero(np.diff(places) != 1)
    begins = places[np.concatenate([[0], breaks + 1])]
    ends = places[np.concatenate([breaks, [len(places) - 1]])] + 1
    edges = np.concatenate([[0], np.stack([begins, ends], axis=-1).ravel(), [pixels]])
    runs = np.diff(edges).tolist()
    return runs if runs[-1] else runs[:-1]


def masks_of(identity: Ints, least: int) -> dict[int, str]:
    """Pack the masks of all identities (h, w) of at least `least`, by identity."""
    down = identity.T.ravel()
    places = np.flatnonzero(down >= least)
    order = np.argsort(down[places], kind="stable")
    values, begins = np.unique(down[places][order], return_index=True)
    groups = np.split(places[order], begins[1:])
    return {
        int(value): packed_runs(run_lengths(group, down.size))
        for value, group in zip(values, groups, strict=False)
    }


def packed_runs(runs: list[int] | Ints) -> str:
    """Pack run lengths into the compressed text of COCO: differences in groups of 5 bits."""
    letters = []
    for k, run in enumerate(runs):
        left = int(run) - int(runs[k - 2]) if k > 2 else int(run)
        more = True
        while more:
            bits = left & 31
            left >>= 5
            more = left != -1 if bits & 16 else left != 0
            letters.append(chr((bits | 32 if more else bits) + 48))
    return "".join(letters)
