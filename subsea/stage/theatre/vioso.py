"""Warp maps of VIOSO's calibration, ``.vwf``.

Little-endian. A set begins with ``vwf1``, the number of blocks, the offset of the first (16) and a
zero; a file of one map without. A map is ``vwf0`` (also ``vwf2``, ``vwf3``), the size of its
header, flags, the monitor, the size of its data, width and height; after the header a record of
four numbers for each pixel, upper row first: u, v from the upper left corner and 1 where they are
valid. Windows bitmaps may follow: the first blends the map before (factors on code values), the
next two correct black and white. Flags: 1 packed, 8 the picture has a border of 1 percent, 64 the
records are points in space. (VIOSO_API: Include/VWBTypes.h, VIOSOWarpBlend/LoadVWF.cpp and
GL/pixelshader.h. No example file is public.)
"""

import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.errors import UserError
from subsea.stage.theatre.measured_mesh import MeasuredMesh
from subsea.stage.theatre.warp import from_grid, validated

MAPS = (b"vwf0", b"vwf2", b"vwf3")
PACKED, BORDER, IN_SPACE = 1, 8, 64  # flags
NAME_AT, NAME = 124, 256  # of the header: bytes
INNER = 1.02  # by which a picture with a border is stretched


class ViosoMap(NamedTuple):
    """A map: its size in pixels, u, v and their validity, and a mask."""

    name: str
    size: tuple[int, int]
    sources: NDArray[np.float32]  # (h, w, 2) from the lower left corner; NaN: none
    blend: NDArray[np.float32] | None = None  # (h, w, 3)


def parse_vioso(data: bytes, _: tuple[int, int], where: str) -> MeasuredMesh:
    """Parse the warp and blend of the first map of a file's bytes; a UserError names `where`."""
    maps, notes = vioso_maps(data, where)
    others = len(maps) - 1
    if others:
        notes = (*notes, f"{where}: {others} more maps than the first")
    return vioso_mesh(maps[0], where)._replace(notes=notes)


def vioso_mesh(measured: ViosoMap, where: str) -> MeasuredMesh:
    """Make the warp and mask of a map."""
    warp = validated(from_grid(measured.sources, measured.size), where)
    if measured.blend is None:
        return MeasuredMesh(warp)
    mask = np.zeros((*measured.blend.shape[:2], 4), np.float32)
    mask[..., :3] = measured.blend
    return MeasuredMesh(warp, mask)


def vioso_maps(data: bytes, where: str) -> tuple[list[ViosoMap], tuple[str, ...]]:
    """All maps of a file's bytes, and a line for each thing that is left out."""
    at, blocks = 0, 1
    if data[:4] == b"vwf1" and len(data) >= 16:
        blocks, at = struct.unpack_from("<2I", data, 4)
        if blocks < 1 or at < 16:
            raise UserError(f"{blocks} blocks from byte {at}, expected 1 from byte 16", file=where)
    maps: list[ViosoMap] = []
    unused = 0
    for number in range(blocks):
        head = data[at : at + 4]
        if head in MAPS:
            latest, at = _map(data, at, where)
            maps.append(latest)
        elif head[:2] == b"BM" and maps:
            blend, at = _bitmap(data, at, maps[-1].size, where)
            if maps[-1].blend is None:
                maps[-1] = maps[-1]._replace(blend=blend)
            else:
                unused += 1
        else:
            raise UserError(
                f"block {number + 1} at byte {at} is neither a map ('vwf0') nor its bitmap ('BM')",
                file=where,
            )
    notes = (f"{where}: {unused} bitmaps for black and white levels",) if unused else ()
    return maps, notes


def _map(data: bytes, at: int, where: str) -> tuple[ViosoMap, int]:
    """The map at a byte, and the first byte after it."""
    if len(data) < at + 28:
        raise UserError("ends within the header of a map", file=where)
    header, flags, _, _, width, height = struct.unpack_from("<4I2i", data, at + 4)
    if flags & PACKED:
        raise UserError("its data is packed, expected a map that is not", file=where)
    if flags & IN_SPACE:
        raise UserError("a 3D map has points in space, expected u and v", file=where)
    if min(width, height) < 2:
        raise UserError(f"{width}×{height} points, expected 2×2 or more", file=where)
    begin, end = at + header, at + header + 16 * width * height
    if header < 28 or end > len(data):
        raise UserError(f"{width}×{height} points do not fit its {len(data)} bytes", file=where)
    records = np.frombuffer(data, "<f4", 4 * width * height, begin).reshape(height, width, 4)
    with np.errstate(invalid="ignore", over="ignore"):
        sources = np.where(records[..., 2:3] > 0.1, records[..., :2] * [1, -1] + [0, 1], np.nan)
        if flags & BORDER:
            sources = (sources - 0.5) * INNER + 0.5
    name = b""
    if header >= NAME_AT + NAME:
        name = data[at + NAME_AT : at + NAME_AT + NAME].partition(b"\0")[0]
    title = name.decode("latin-1")
    return ViosoMap(title, (width, height), sources.astype(np.float32)), end


def _bitmap(
    data: bytes, at: int, size: tuple[int, int], where: str
) -> tuple[NDArray[np.float32], int]:
    """A bitmap (h, w, 3) of 8, 16 or (as floats) 32 bits a colour, and the byte after it."""
    if len(data) < at + 54:
        raise UserError("ends within the header of a bitmap", file=where)
    offset, _, width, height, _, bits = struct.unpack_from("<2I2i2H", data, at + 10)
    kinds = {24: ("u1", 3), 32: ("u1", 4), 64: ("<u2", 4), 128: ("<f4", 4)}
    if (width, abs(height)) != size or bits not in kinds:
        raise UserError(
            f"a bitmap of {width}×{height} pixels of {bits} bits, expected {size[0]}×{size[1]} "
            f"of {', '.join(str(kind) for kind in kinds)}",
            file=where,
        )
    kind, channels = kinds[bits]
    pitch, begin = (width * bits + 31) // 32 * 4, at + offset
    end = begin + pitch * abs(height)
    if offset < 54 or end > len(data):
        raise UserError("ends within a bitmap", file=where)
    rows = np.frombuffer(data, np.uint8, pitch * abs(height), begin).reshape(abs(height), pitch)
    plain = np.ascontiguousarray(rows[:, : width * bits // 8]).view(kind)
    pixels = plain.reshape(abs(height), width, channels).astype(np.float32)
    pixels = pixels[::-1] if height > 0 else pixels  # the lowest row is the first
    most = {"u1": 255.0, "<u2": 65535.0, "<f4": 1.0}[kind]
    # Windows stores blue first; VIOSO's wider records red first.
    colours = pixels[..., 2::-1] if kind == "u1" else pixels[..., :3]
    return np.clip(np.nan_to_num(colours / most), 0.0, 1.0).astype(np.float32), end
