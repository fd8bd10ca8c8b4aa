"""The uniforms of a view in one buffer, which all programs share: `shaders/view.glsl`.

Set one by one in each program, they took a sixth of the renderer's own time.
"""

import struct
from typing import Any

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
