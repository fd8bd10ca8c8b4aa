"""Metadata that mark a film for players as stereo or as 360°.

Stereo: the frame packing message of H.264, which switches televisions, and the box `st3d`, which
players on computers read. 360°: the box `sv3d` ("spherical video V2" by Google). ffmpeg's muxer
writes these boxes only for input from a demuxer, so they are inserted into the complete file.
"""

import shutil
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from subsea import __version__


class VideoMetadata(NamedTuple):
    """Frame packing and boxes of a film."""

    packing: int | None = None  # of Annex D of H.264; None: every frame is one picture
    boxes: bytes = b""  # for the sample description of the track


def box(kind: bytes, content: bytes) -> bytes:
    """Build a box of an MP4 file: length, four letters, content."""
    return struct.pack(">I4s", 8 + len(content), kind) + content


def _st3d(mode: int) -> bytes:
    return box(b"st3d", bytes(4) + bytes([mode]))


def _sv3d() -> bytes:
    header = box(b"svhd", bytes(4) + f"subsea {__version__}".encode() + b"\0")
    pose = box(b"prhd", bytes(4) + struct.pack(">3i", 0, 0, 0))  # front in the middle, level
    whole = box(b"equi", bytes(4) + struct.pack(">4I", 0, 0, 0, 0))  # uncropped
    return box(b"sv3d", header + box(b"proj", pose + whole))


NO_METADATA = VideoMetadata()


def metadata_for(display: str) -> VideoMetadata:
    """Metadata of a film in a display mode."""
    known = {
        "checkerboard": VideoMetadata(packing=0),
        "interlaced": VideoMetadata(packing=2),
        "side-by-side": VideoMetadata(packing=3, boxes=_st3d(2)),
        "top-bottom": VideoMetadata(packing=4, boxes=_st3d(1)),
        "equirectangular": VideoMetadata(boxes=_st3d(0) + _sv3d()),
    }
    return known.get(display, NO_METADATA)


# Offset of the boxes inside a box.
CHILDREN_AT = {b"moov": 8, b"trak": 8, b"mdia": 8, b"minf": 8, b"stbl": 8, b"stsd": 16}


def insert_boxes(path: Path, boxes: bytes) -> None:
    """Append boxes to the sample description of the pictures in an MP4 file, index first."""
    new = path.with_name(f"{path.name}.tagged")
    try:
        with path.open("rb") as source, new.open("wb") as target:
            target.write(_read(source))  # ftyp
            target.write(_grown(_read(source), boxes, len(boxes)))  # moov
            shutil.copyfileobj(source, target, 1 << 20)
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def _read(source: IO[bytes]) -> bytes:
    """Read the next box of a file."""
    head = source.read(8)
    return head + source.read(struct.unpack(">I", head[:4])[0] - 8)


def _grown(whole: bytes, boxes: bytes, shift: int) -> bytes:
    """A copy of a box with `boxes` in its sample description and file offsets moved by `shift`."""
    kind = whole[4:8]
    if kind == b"avc1":
        return box(kind, whole[8:] + boxes)
    if kind in (b"stco", b"co64"):
        number = ">u4" if kind == b"stco" else ">u8"
        offsets = np.frombuffer(whole[16:], number).astype(np.uint64) + np.uint64(shift)
        return whole[:16] + offsets.astype(number).tobytes()
    if kind not in CHILDREN_AT:
        return whole
    start = CHILDREN_AT[kind]
    return box(
        kind, whole[8:start] + b"".join(_grown(b, boxes, shift) for b in _each(whole[start:]))
    )


def _each(data: bytes) -> Iterator[bytes]:
    """Split `data` into its boxes."""
    while data:
        (length,) = struct.unpack(">I", data[:4])
        yield data[:length]
        data = data[length:]
