"""Diagrams over the sea: lines as strips of pixels that solids hide.

They are drawn onto the canvas, so every way to show it shows them too: bent, woven or blended. The
light that a line is drawn with is what the tone curve makes its colour of.
"""

from typing import Any

import moderngl
import numpy as np

from subsea.frame.packet import Packet
from subsea.render.gl.shaders import program, set_uniforms
from subsea.view.camera import View

THINNEST_PX, SHARE = 1.3, 1 / 480  # width of a line: this share of the picture's height, but ...
COLUMNS = 11  # of a record: both ends, colour, lift


class LineRenderer:
    """Holds one record a line."""

    def __init__(self, context: Any) -> None:
        """Nothing is drawn until a packet has lines."""
        self._program = program(context, "lines")
        self._buffer = context.buffer(reserve=4 * COLUMNS)
        names = "a_from", "a_to", "a_colour", "a_lift"
        self._array = context.vertex_array(
            self._program, [(self._buffer, "3f4 3f4 4f4 1f4 /i", *names)]
        )

    def upload(self, packet: Packet) -> None:
        """Send a packet's lines."""
        ends, colours, lift = packet.lines
        if len(ends):
            records = np.concatenate([ends.reshape(-1, 6), colours, lift[:, None]], axis=1)
            data = np.ascontiguousarray(records, "f4")
            self._buffer.orphan(data.nbytes)
            self._buffer.write(data)

    def draw(self, packet: Packet, number: int, view: View, uniforms: dict[str, Any]) -> int:
        """Draw all lines into a view, blended; the number of triangles."""
        count = len(packet.lines.ends)
        if not count or (packet.lined is not None and number >= packet.lined):
            return 0
        width = max(SHARE * view.viewport[3], THINNEST_PX)
        set_uniforms(self._program, **uniforms, u_width=width)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)
        return 2 * count

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self._array, self._buffer, self._program):
            held.release()
