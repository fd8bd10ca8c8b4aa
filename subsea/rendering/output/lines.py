"""Lines of diagrams, as quads that are a few pixels wide and that solids hide.

They are drawn on the canvas, so that every kind of output shows them. The shader inverts the tone
curve, so that a line has the colour asked for.
"""

from typing import Any

import moderngl
import numpy as np

from subsea.frame.packet import Packet
from subsea.rendering.gl.owner import GpuOwner, replace_data
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.view.camera import View

THINNEST_PX, SHARE = 1.3, 1 / 480  # least width, and share of the picture's height
COLUMNS = 11  # of an instance: both ends, colour, lift


class LineRenderer(GpuOwner):
    """Draws the lines of a packet, one instance each."""

    def __init__(self, context: Any) -> None:
        super().__init__()
        self._program = self.own(program(context, "lines"))
        self._buffer = self.own(context.buffer(reserve=4 * COLUMNS))
        names = "a_from", "a_to", "a_colour", "a_lift"
        content = [(self._buffer, "3f4 3f4 4f4 1f4 /i", *names)]
        self._array = self.own(context.vertex_array(self._program, content))

    def upload(self, packet: Packet) -> None:
        """Upload the lines of a packet."""
        ends, colours, lift = packet.lines
        if len(ends):
            records = np.concatenate([ends.reshape(-1, 6), colours, lift[:, None]], axis=1)
            replace_data(self._buffer, np.ascontiguousarray(records, "f4"))

    def draw(self, packet: Packet, number: int, view: View, uniforms: dict[str, Any]) -> int:
        """Blend all lines over a view; returns the number of triangles."""
        count = len(packet.lines.ends)
        if not count or (packet.lined is not None and number >= packet.lined):
            return 0
        width = max(SHARE * view.viewport[3], THINNEST_PX)
        set_uniforms(self._program, **uniforms, u_width=width)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)
        return 2 * count
