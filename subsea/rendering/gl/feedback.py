"""Run a vertex shader without a picture and read back what it computes (transform feedback).

Exports and tests take the shapes of fishes and seaweed from here, so that only the shaders say how
these bend.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.rendering.gl.context import GpuOwner, headless_context
from subsea.rendering.gl.programs import variant_array
from subsea.rendering.gl.shaders import BLOCKS, TEXTURE_UNITS, set_uniforms, source
from subsea.rendering.gl.textures import table


@cache
def compute_context() -> Any:
    """Return the context of this process for computing; UserError without OpenGL."""
    context = headless_context()
    with context:
        # A transformation needs a framebuffer in use. The end of this block detaches the context
        # from the thread: no window could open otherwise.
        context.simple_framebuffer((1, 1)).use()
    return context


class VertexFeedback:
    """A compiled vertex shader whose outputs can be read. It lives as long as the process."""

    def __init__(self, name: str, outputs: Mapping[str, int], **constants: int) -> None:
        """Compile `shaders/NAME.vert`; `outputs` are names of `out` variables and their sizes."""
        self._sizes = list(outputs.values())
        self._context = compute_context()
        with self._context:
            self._program = self._context.program(
                vertex_shader=source(f"{name}.vert", **constants), varyings=tuple(outputs)
            )

    def run(
        self,
        attributes: Sequence[tuple[Any, ...]],
        count: tuple[int, int],
        textures: Mapping[str, Array],
        blocks: Mapping[str, Array] = {},
        **uniforms: Any,
    ) -> list[Array]:
        """Return each output as an array (instances, vertices, size) of float32.

        `attributes` are arrays, each with its format and names as in moderngl. `count` is the
        number of instances and of vertices. Textures have texels (rows, columns, 4).
        """
        with self._context as context:
            held = GpuOwner()
            for name, texels in textures.items():
                held.own(table(context, np.asarray(texels, "f4"))).use(TEXTURE_UNITS[name])
            for name, values in blocks.items():
                held.own_buffers(context, values)[0].bind_to_uniform_block(BLOCKS[name])
            content = [
                (held.own_buffers(context, np.asarray(values, "f4"))[0], *layout)
                for values, *layout in attributes
            ]
            array = held.own(variant_array(context, self._program, content))
            out = held.own(context.buffer(reserve=4 * sum(self._sizes) * count[0] * count[1]))
            set_uniforms(self._program, **uniforms)
            array.transform(out, context.POINTS, vertices=count[1], instances=count[0])
            values = np.frombuffer(out.read(), np.float32).reshape(*count, -1)
            held.release()
        return np.split(values, np.cumsum(self._sizes)[:-1], axis=2)
