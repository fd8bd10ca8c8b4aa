"""The binary container of glTF 2.0, whose arrays are stored exactly, or rounded and compressed.

A file is JSON, then one buffer with all arrays. `quantised` needs KHR_mesh_quantization of the
reader, `meshopt` also EXT_meshopt_compression. Keys of animations and texture coordinates are
rounded as glTF itself allows.
"""

import json
import math
import struct
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.base.arrays import Array
from subsea.base.errors import UserError
from subsea.base.system import require
from subsea.export import COMPRESSIONS, MESHOPT, PLAIN
from subsea.export.conventions import copyright_line

QUANTIZATION, COMPRESSION = "KHR_mesh_quantization", "EXT_meshopt_compression"
SHORT, BYTE, FULL_SHORT, FULL_BYTE = 32767, 127, 65535, 255  # greatest values: of ±1, and of 1


class PositionGrid(NamedTuple):
    """The grid of rounded positions: a position is `middle` + `half` times its integer / SHORT.

    One step for all axes, so that normals need no correction.
    """

    middle: Array  # (3,) metres
    half: float  # metres; 0: positions are stored as they are

    @property
    def matrix(self) -> Array:
        """Return the matrix (4, 4) from stored positions to metres."""
        out = np.eye(4)
        if self.half:
            out[:3, :3] *= self.half
            out[:3, 3] = self.middle
        return out

    def node(self) -> dict[str, list[float]]:
        """Return the grid as properties of a node."""
        if not self.half:
            return {}
        return {"translation": self.middle.tolist(), "scale": [self.half] * 3}


class Stored(NamedTuple):
    """An array to store."""

    values: NDArray[Any]
    normalised: bool = False  # its integers stand for numbers from 0 or -1 to 1
    step: float = 0.0  # of its floats, as coarse as compression may make them; 0: exact


class Packing(NamedTuple):
    """The rounding and compression of the arrays of a file."""

    kind: str = PLAIN

    @property
    def rounds(self) -> bool:
        """Tell if values are rounded to integers."""
        return self.kind != PLAIN

    def grid(self, points: Array, reach: float = 0.0) -> PositionGrid:
        """Make the grid of points (..., 3) and offsets of up to `reach` along an axis, metres."""
        if not self.rounds:
            return PositionGrid(np.zeros(3), 0.0)
        low, high = points.reshape(-1, 3).min(axis=0), points.reshape(-1, 3).max(axis=0)
        half = max(float((high - low).max()) / 2.0, reach) or 1.0
        return PositionGrid((low + high) / 2.0, half)

    def positions(self, points: Array, grid: PositionGrid) -> Stored:
        """Store positions (n, 3), metres."""
        return self.offsets(points - grid.middle, grid)

    def offsets(self, ways: Array, grid: PositionGrid) -> Stored:
        """Store differences (n, 3) of positions, metres."""
        return self._rounded(ways / (grid.half or 1.0), SHORT, np.int16)

    def normals(self, normals: Array) -> Stored:
        """Store unit vectors (n, 3)."""
        return self._rounded(normals, BYTE, np.int8)

    def turned_normals(self, change: Array) -> Stored:
        """Store differences (n, 3) of unit vectors; those beyond ±1 cannot be rounded."""
        return self.normals(change) if np.abs(change).max(initial=0.0) <= 1.0 else _single(change)

    def coordinates(self, places: Array) -> Stored:
        """Store texture coordinates (n, 2) or colours (n, 3) from 0 to 1."""
        return self._rounded(places, FULL_SHORT, np.uint16)

    def weights(self, weights: Array) -> Stored:
        """Store weights (n, 4) of joints, of sum 1."""
        stored = self._rounded(weights, FULL_BYTE, np.uint8)
        if self.rounds:
            # The greatest takes what is left, so that the sum is exact.
            missing = FULL_BYTE - stored.values.sum(axis=1, dtype=np.int64)
            stored.values[np.arange(len(weights)), weights.argmax(axis=1)] += missing.astype(
                np.uint8
            )
        return stored

    def shares(self, shares: Array) -> Stored:
        """Store weights (...) of morph targets, 0 to 1."""
        return self._rounded(shares, FULL_BYTE, np.uint8)

    def rotations(self, turns: Array) -> Stored:
        """Store unit quaternions (T, 4)."""
        return self._rounded(turns, SHORT, np.int16)

    def lengths(self, values: Array, step: float) -> Stored:
        """Store positions (T, 3) of nodes, metres; `step` is what they may be off."""
        return Stored(np.asarray(values, np.float32), step=step if self.rounds else 0.0)

    def _rounded(self, values: Array, full: int, kind: type[np.integer[Any]]) -> Stored:
        """Store `values` as they are, or as integers in steps of 1 / `full`."""
        if not self.rounds:
            return _single(values)
        return Stored(np.round(np.clip(values, -1.0, 1.0) * full).astype(kind), True)

    def extensions(self) -> list[str]:
        """List the extensions of glTF that a reader needs."""
        rounded = [QUANTIZATION] if self.rounds else []
        return rounded + ([COMPRESSION] if self.kind == MESHOPT else [])


EXACT = Packing()


def packing_of(kind: str) -> Packing:
    """Return the packing of a name; UserError without the package that it needs."""
    if kind not in COMPRESSIONS:
        raise UserError(f"unknown compression {kind!r}, expected {', '.join(COMPRESSIONS)}")
    if kind == MESHOPT:
        require("meshopt", "compressed glTF")
    return Packing(kind)


def _single(values: Array) -> Stored:
    return Stored(np.asarray(values, np.float32))


TYPES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}  # componentType
SHAPES = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}
VERTICES, INDICES = 34962, 34963  # targets of buffer views
CLAMPED = 33071  # wrapS and wrapT of a sampler
WORD = 4  # bytes: where vertices and views begin
BOUNDED = 1, 3  # numbers in a row of positions, times and indices, whose bounds readers want
MOST_BITS = 24  # of a compressed fraction


class GlbBuffer:
    """The binary part of a file, with its views and accessors."""

    def __init__(self, packing: Packing = EXACT) -> None:
        self.packing = packing
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self._unpacked = 0  # bytes of the buffer that readers decompress

    def view(self, data: bytes, target: int | None = None) -> int:
        """Append bytes, such as an image file; return the number of their view."""
        view = {"buffer": 0, "byteOffset": self._append(data), "byteLength": len(data)}
        self.views.append(view | ({"target": target} if target else {}))
        return len(self.views) - 1

    def add(self, values: NDArray[Any] | Stored, target: int | None = None) -> int:
        """Append an array of float32 or integers; return the number of its accessor.

        (n,), (n, 2), (n, 3) and (n, 4) are scalars and vectors, (n, 4, 4) matrices with their
        rows as in numpy.
        """
        return self.block([values if isinstance(values, Stored) else Stored(values)], target)[0]

    def block(self, arrays: Sequence[Stored], target: int | None = None) -> list[int]:
        """Append arrays of one type and shape to one view; return the numbers of their accessors.

        Readers and files are quicker and smaller with few views.
        """
        rows = [_rows(array.values) for array in arrays]
        kind, wide = rows[0].dtype.str[1:], rows[0].shape[1]
        size = rows[0].itemsize * wide
        stride = size + (-size % WORD if target == VERTICES else 0)
        number = self._compressed(rows, stride, target, arrays[0].step)
        if number is None:
            number = self.view(b"".join(_padded(part, stride).tobytes() for part in rows), target)
            if stride != size:
                self.views[number]["byteStride"] = stride
        begin = 0
        for array, part in zip(arrays, rows, strict=True):
            self.accessors.append(
                {"bufferView": number}
                | ({"byteOffset": begin} if begin else {})
                | {"componentType": TYPES[kind], "count": len(part)}
                | ({"normalized": True} if array.normalised else {})
                | {"type": SHAPES[array.values.shape[1:]]}
                | ({} if array.step or wide not in BOUNDED else _bounds(part))
            )
            begin += len(part) * stride
        return list(range(len(self.accessors) - len(arrays), len(self.accessors)))

    def changes(self, values: Stored) -> int:
        """Append the changes (n, 3) of a morph target, without zeros if that is shorter."""
        rows = _rows(values.values)
        moved = np.flatnonzero(rows.any(axis=1))
        size = rows.itemsize * rows.shape[1]
        short = len(rows) <= np.iinfo(np.uint16).max
        index = np.uint16 if short else np.uint32
        # Two views and their JSON take some hundred bytes.
        sparse = (len(moved) or 1) * (size + index(0).itemsize) + 300
        if not self.packing.rounds or sparse >= len(rows) * (size + -size % WORD):
            return self.add(values, VERTICES)
        moved = moved if len(moved) else np.zeros(1, np.int64)
        self.accessors.append(
            {"componentType": TYPES[rows.dtype.str[1:]], "count": len(rows)}
            | ({"normalized": True} if values.normalised else {})
            | {"type": "VEC3"}
            | _bounds(rows)
            | {
                "sparse": {
                    "count": len(moved),
                    "indices": {
                        "bufferView": self.view(moved.astype(index).tobytes()),
                        "componentType": TYPES[np.dtype(index).str[1:]],
                    },
                    "values": {"bufferView": self.view(rows[moved].tobytes())},
                }
            }
        )
        return len(self.accessors) - 1

    def buffers(self) -> list[dict[str, Any]]:
        """Describe the buffers of the file: the data, and the place to decompress them to."""
        buffers: list[dict[str, Any]] = [{"byteLength": len(self.data)}]
        if self._unpacked:
            fallback = {COMPRESSION: {"fallback": True}}
            buffers.append({"byteLength": self._unpacked, "extensions": fallback})
        return buffers

    def extensions(self) -> list[str]:
        """List the extensions that a reader of these arrays needs."""
        needed = self.packing.extensions()
        return needed if self._unpacked else [name for name in needed if name != COMPRESSION]

    def _append(self, data: bytes) -> int:
        self.data += bytes(-len(self.data) % WORD)
        self.data += data
        return len(self.data) - len(data)

    def _compressed(
        self, rows: list[NDArray[Any]], stride: int, target: int | None, step: float
    ) -> int | None:
        """Append rows compressed; return their view, or None if they cannot be made shorter."""
        if self.packing.kind != MESHOPT:
            return None
        import meshopt

        whole = rows[0] if len(rows) == 1 else np.concatenate(rows)
        size = len(whole) * stride
        coded: dict[str, Any] = {}
        if target == INDICES:
            coded |= {"byteStride": whole.itemsize, "count": len(whole), "mode": "TRIANGLES"}
            data = meshopt.encode_gltf_buffer(whole[:, 0].astype(np.uint32), "TRIANGLES")
        else:
            if step:  # Fractions with a common exponent for a vector.
                most = float(np.abs(whole).max()) or step
                bits = min(max(math.ceil(math.log2(most / step)) + 2, 2), MOST_BITS)
                packed = meshopt.encode_filter_exp(whole, bits, "SharedVector")
                coded["filter"] = "EXPONENTIAL"
            else:
                flat = _padded(whole, stride).reshape(-1)
                width = stride if stride % WORD == 0 else WORD
                packed = np.concatenate([flat, np.zeros(-len(flat) % width, np.uint8)])
                packed = packed.reshape(-1, width)
                size = packed.size
            coded |= {"byteStride": packed.shape[1], "count": len(packed), "mode": "ATTRIBUTES"}
            data = meshopt.encode_gltf_buffer(packed, "ATTRIBUTES")
        if len(data) >= size:
            return None
        coded |= {"buffer": 0, "byteOffset": self._append(data), "byteLength": len(data)}
        begin = self._unpacked + -self._unpacked % WORD
        self._unpacked = begin + size
        view = {"buffer": 1, "byteOffset": begin, "byteLength": size}
        view |= {"target": target} if target else {}
        view |= {"byteStride": stride} if target == VERTICES else {}
        self.views.append(view | {"extensions": {COMPRESSION: coded}})
        return len(self.views) - 1


def material(
    name: str, looks: dict[str, Any], rough: float, texture: int = 0, metal: int | None = None,
    normal: int | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Describe a material with the colours of a texture; `looks` are its blending and sides.

    `rough` is its roughness; `metal` is a texture of roughness and metal, `normal` a normal map.
    """
    skin: dict[str, Any] = {"baseColorTexture": {"index": texture}}
    if metal is None:
        skin |= {"metallicFactor": 0.0, "roughnessFactor": rough}
    else:
        skin["metallicRoughnessTexture"] = {"index": metal}
    relief = {} if normal is None else {"normalTexture": {"index": normal}}
    return {"name": name, "pbrMetallicRoughness": skin} | relief | looks


def asset(species: Iterable[str], extras: dict[str, Any]) -> dict[str, Any]:
    """Describe the property `asset` of a file with these species."""
    notice = copyright_line(species)
    return {"version": "2.0", "generator": "subsea", "copyright": notice, "extras": extras}


def glb(
    content: dict[str, Any], buffer: GlbBuffer, needs: Sequence[str] = (), uses: Sequence[str] = ()
) -> bytes:
    """Return the bytes of a .glb file of JSON content and a buffer.

    `needs` are extensions that a reader of the content needs, `uses` those that it may ignore.
    """
    content = content | {
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": buffer.buffers(),
    }
    if extensions := [*buffer.extensions(), *needs]:
        content |= {"extensionsRequired": extensions}
    if extensions or uses:
        content |= {"extensionsUsed": [*extensions, *uses]}
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % WORD)
    data = bytes(buffer.data) + bytes(-len(buffer.data) % WORD)
    size = 12 + 8 + len(text) + 8 + len(data)
    return b"".join(
        [
            struct.pack("<4sII", b"glTF", 2, size),
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(data), b"BIN\0"),
            data,
        ]
    )


def _rows(values: NDArray[Any]) -> NDArray[Any]:
    """Reshape an array to rows (n, k) of numbers; columns of matrices follow one another."""
    rows = np.swapaxes(values, 1, 2) if values.ndim == 3 else values
    return np.ascontiguousarray(rows).reshape(len(values), -1)


def _bounds(rows: NDArray[Any]) -> dict[str, Any]:
    return {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}


def _padded(rows: NDArray[Any], stride: int) -> NDArray[np.uint8]:
    """Return the bytes (n, stride) of rows, filled up with zeros."""
    raw = rows.view(np.uint8).reshape(len(rows), -1)
    if raw.shape[1] == stride:
        return raw
    return np.pad(raw, ((0, 0), (0, stride - raw.shape[1])))
