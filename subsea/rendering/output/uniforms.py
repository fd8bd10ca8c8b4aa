"""Uniforms that all shaders share: eye, water, time, lamps.

The uniforms of a view in one buffer, which all programs share: `shaders/view.glsl`.

Set one by one in each program, they took a sixth of the renderer's own time.
"""

import struct
from typing import Any

import numpy as np

from subsea.frame.packet import Packet
from subsea.rendering.output.daylight import light_uniforms
from subsea.scenario.schema import Water
from subsea.view.camera import View

NAME = "View"
BINDING = 1  # `fishes.LOOKS_BINDING` is 0
# Each member in the layout std140, with the gap behind it.
_MEMBERS = {
    "u_view": "16f", "u_projection": "16f", "u_view_projection": "16f", "u_inverse": "16f",
    "u_eye": "3f", "u_time": "1f", "u_balance": "3f4x", "u_far": "3f4x", "u_broad": "3f4x",
    "u_narrow": "3f4x",
}  # fmt: skip
_BYTES = sum(map(struct.calcsize, _MEMBERS.values()))


def view_block(values: dict[str, Any]) -> bytes:
    """The content of the buffer: matrices as bytes, vectors, the time; zeros for missing ones."""
    return b"".join(_packed(layout, values.get(name)) for name, layout in _MEMBERS.items())


def _packed(layout: str, value: Any) -> bytes:
    if value is None:
        return bytes(struct.calcsize(layout))
    if isinstance(value, bytes):
        return value
    return struct.pack(layout, *((value,) if isinstance(value, float) else value))


class ViewBuffer:
    """The buffer of a context, which holds the view that is drawn."""

    def __init__(self, context: Any) -> None:
        """Bind the buffer for all programs of the context."""
        self._buffer = context.buffer(reserve=_BYTES)
        self._buffer.bind_to_uniform_block(BINDING)
        self._content = b""

    def write(self, content: bytes) -> None:
        """Write the content of a view, unless it is there."""
        if content != self._content:
            self._buffer.write(content)
            self._content = content


SHAFTS_UNIT = 15  # texture unit that all shaders read
# Period of the shaders' time; waves and snow jump when it ends. Their float32 resolves 1 ms up to
# here, but only 8 ms after a day, and waves would jerk.
TIDE_S = 4 * 3600.0


def uniforms_of(packet: Packet, view: View, water: Water) -> dict[str, Any]:
    """The uniforms of a view."""
    both = view.projection.astype(np.float64) @ view.view.astype(np.float64)
    rows = np.array([view.view, view.projection, both, np.linalg.inv(both)], np.float32)
    matrices = rows.transpose(0, 2, 1).tobytes()  # in OpenGL's column-major order
    values = (
        {
            "u_view": matrices[:64],
            "u_projection": matrices[64:128],
            "u_view_projection": matrices[128:192],
            "u_inverse": matrices[192:],
            "u_eye": tuple(float(x) for x in view.eye),
            "u_size": (float(view.viewport[2]), float(view.viewport[3])),
            "u_without": float(view.without),
            "u_time": packet.time_s % TIDE_S,
            "u_caustics": 1,
            "u_noise": 2,
            "u_shafts": SHAFTS_UNIT,
        }
        | light_uniforms(water, view.eye)
        | _lamps(packet)
    )
    return values | {"view": view_block(values)}


def _lamps(packet: Packet) -> dict[str, Any]:
    """Positions and axes of the lamps; empty while they are off."""
    if packet.lamps is None:
        return {}
    places, ways = ([tuple(map(float, one)) for one in part] for part in packet.lamps)
    return {"u_lamps": places, "u_beams": ways}
