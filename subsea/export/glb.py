"""The binary container of glTF 2.0: JSON, then one buffer with all arrays."""

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.export.clips import ROUGHNESS

TYPES = {"u1": 5121, "u2": 5123, "u4": 5125, "f4": 5126}  # componentType
SHAPES = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}
VERTICES, INDICES = 34962, 34963  # targets of buffer views
CLAMPED = 33071  # wrapS and wrapT of a sampler


class GlbBuffer:
    """The binary part of a file, with its views and accessors."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def view(self, data: bytes, target: int | None = None) -> int:
        """Append bytes, such as an image file; return the number of their view."""
        self.data += bytes(-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += data
        return len(self.views) - 1

    def add(self, values: NDArray[Any], target: int | None = None) -> int:
        """Append an array of float32 or unsigned integers; return the number of its accessor.

        (n,), (n, 2), (n, 3) and (n, 4) are scalars and vectors, (n, 4, 4) matrices with their
        rows as in numpy.
        """
        rows = np.swapaxes(values, 1, 2) if values.ndim == 3 else values
        flat = np.ascontiguousarray(rows).reshape(len(values), -1)
        self.accessors.append(
            {
                "bufferView": self.view(flat.tobytes(), target),
                "componentType": TYPES[flat.dtype.str[1:]],
                "count": len(values),
                "type": SHAPES[values.shape[1:]],
                "min": flat.min(axis=0).tolist(),
                "max": flat.max(axis=0).tolist(),
            }
        )
        return len(self.accessors) - 1


def material(name: str, looks: dict[str, Any]) -> dict[str, Any]:
    """A material with the colours of texture 0; `looks` are its blending and sides."""
    skin = {
        "baseColorTexture": {"index": 0},
        "metallicFactor": 0.0,
        "roughnessFactor": ROUGHNESS,
    }
    return {"name": name, "pbrMetallicRoughness": skin} | looks


def glb(content: dict[str, Any], buffer: GlbBuffer) -> bytes:
    """The bytes of a .glb file of JSON content and a buffer."""
    content = content | {
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data = bytes(buffer.data) + bytes(-len(buffer.data) % 4)
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
