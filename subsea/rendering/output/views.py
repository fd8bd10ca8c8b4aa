"""A small copy of what a window shows, read without waiting for the GPU.

Lines of diagrams, as quads that are a few pixels wide and that solids hide.

They are drawn on the canvas, so that every kind of output shows them. The shader inverts the tone
curve, so that a line has the colour asked for.
"""

import ctypes
from typing import Any

import moderngl
import numpy as np

from subsea.base.arrays import Bytes
from subsea.frame.packet import Packet
from subsea.rendering.gl.owner import GpuOwner, replace_data
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.rendering.gl.textures import gl_function
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


# OpenGL enums
READ_FRAMEBUFFER, DRAW_FRAMEBUFFER, COLOR_BIT, LINEAR = 0x8CA8, 0x8CA9, 0x4000, 0x2601


class SmallPicture(GpuOwner):
    """Shrinks the screen of a context on the GPU, and reads the copy a frame later."""

    def __init__(self, context: Any, width: int) -> None:
        """Copies are `width` pixels wide at most, and as high as the window's shape says."""
        super().__init__()
        self._context, self._width = context, width
        self._size = (0, 0)
        self._copied = False
        self._blit = gl_function(
            context, "glBlitFramebuffer", *[ctypes.c_int] * 8, ctypes.c_uint, ctypes.c_uint
        )
        self._bind = gl_function(context, "glBindFramebuffer", ctypes.c_uint, ctypes.c_uint)

    def copy(self, window: tuple[int, int]) -> None:
        """Begin to copy the screen, whose size is that of the `window` in pixels."""
        context, width = self._context, min(self._width, window[0])
        size = width, max(round(width * window[1] / window[0]), 1)
        if size != self._size:
            self.release()
            self._size = size
            texture = self.own(context.texture(size, 4))
            self._small = self.own(context.framebuffer([texture]))
            self._buffer = self.own(context.buffer(reserve=4 * size[0] * size[1]))
        self._bind(READ_FRAMEBUFFER, context.screen.glo)
        self._bind(DRAW_FRAMEBUFFER, self._small.glo)
        self._blit(0, 0, *window, 0, 0, *size, COLOR_BIT, LINEAR)
        self._small.read_into(self._buffer, components=4)
        context.screen.use()
        context.error  # clear it: moderngl asks for an attachment that windows lack  # noqa: B018
        self._copied = True

    def read(self) -> Bytes | None:
        """The copy (h, w, 4) that was begun last, top row first, once; None if there is none."""
        if not self._copied:
            return None
        self._copied = False
        width, height = self._size
        return np.frombuffer(self._buffer.read(), np.uint8).reshape(height, width, 4)[::-1]
