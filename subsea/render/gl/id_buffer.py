"""What each pixel shows, and how far away it is: identity and range maps (Tu §6.7).

The triangles of a picture are drawn again, by the same vertex shaders and as far as a pixel's
opacity goes by the same fragment shaders, which are compiled with `MARKS` (`shaders/show.glsl`).
A pixel shows what is in front of all that covers its middle and hides at least half of what lies
behind. Haze hides nothing. Shadows and shafts of light are no things, and specks of plankton and
of marine snow are too soft to be told from the water.
"""

from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.core.arrays import Array, Ints
from subsea.core.errors import UserError
from subsea.render.gl.shaders import program, set_uniforms, wanted
from subsea.view.rig import Rect

# What there is to be seen. A mark is a kind and the number of one of that kind, in one number:
# float32 holds it exactly, so one half of a texel does.
KINDS = (
    "water", "surface", "seabed", "pillar", "rock", "coral", "seaweed", "bubbles", "hook",
    "fish",
)  # fmt: skip
WATER, SURFACE, SEABED, PILLAR, ROCK, CORAL, SEAWEED, BUBBLES, HOOK, FISH = range(10)
NUMBERS = 2**20  # of one kind


def object_id(kind: int, number: Any = 0) -> Any:
    """The mark of the one with this `number` among those of its kind; arrays give arrays."""
    return float(kind * NUMBERS) + number


class IdMaps(NamedTuple):
    """Maps of what the pixels of a canvas (h, w), top row first, show."""

    kind: Ints  # (h, w) uint8, as KINDS are numbered
    number: Ints  # (h, w) int32: which fish of the world, pillar or rock of the sea, growth; else 0
    depth: Array  # (h, w) float32 cm along the view's axis, infinite in open water


class ProgramVariants:
    """A program and the arrays that it draws, and for each of both twins: for marks, for lamps."""

    def __init__(self, context: Any, name: str, kind: int) -> None:
        """The twins are made when they are first asked for."""
        self.program = program(context, name)
        self._context, self._name, self._kind = context, name, kind
        self._contents: dict[Any, tuple[Any, ...]] = {}
        self._twins: dict[Any, Any] = {}

    def array(self, *content: Any) -> Any:
        """A vertex array of the program, of `content` as moderngl has it."""
        made = self._context.vertex_array(self.program, *content)
        self._contents[made] = content
        return made

    def ready(self, array: Any, marked: bool, **uniforms: Any) -> Any:
        """The `array`, or its twin, with these uniforms set."""
        if wants := wanted(uniforms, marked):
            array = self._twin(array, wants)
            uniforms["u_mark"] = object_id(self._kind)
        set_uniforms(array.program, **uniforms)
        return array

    def _twin(self, array: Any, wants: tuple[str, ...]) -> Any:
        if wants not in self._twins:
            self._twins[wants] = program(self._context, self._name, **dict.fromkeys(wants, 1))
        if (array, wants) not in self._twins:
            self._twins[array, wants] = double(
                self._context, self._twins[wants], *self._contents[array]
            )
        return self._twins[array, wants]

    def release(self) -> None:
        """Free the programs and the arrays; the buffers stay their makers'."""
        for held in (*self._contents, *self._twins.values(), self.program):
            held.release()


def double(context: Any, compiled: Any, content: Any, indices: Any = None) -> Any:
    """A vertex array like that of another program, but for the attributes that this one lacks."""
    return context.vertex_array(compiled, content, indices, skip_errors=True)


class IdBuffer:
    """The picture that marks are drawn into."""

    def __init__(self, context: Any, size: tuple[int, int]) -> None:
        """Of `size` (width, height) pixels; more than the GPU can hold is a UserError."""
        self.size = size
        try:
            self._texture = context.texture(size, 2, dtype="f4")
            self._depth = context.depth_renderbuffer(size)
        except moderngl.Error as fault:
            raise UserError(
                f"maps of {size[0]}x{size[1]} pixels are more than this GPU can hold; "
                "take a smaller --size"
            ) from fault
        self.framebuffer = context.framebuffer([self._texture], self._depth)

    def read(self, part: Rect | None = None) -> IdMaps:
        """What was drawn, in a part of the canvas or in all of it."""
        part = part or (0, 0, *self.size)
        width, height = part[2:]
        data = self.framebuffer.read(part, components=2, dtype="f4")
        texels = np.frombuffer(data, np.float32).reshape(height, width, 2)[::-1]
        kind, number = np.divmod(texels[..., 0].astype(np.int32), NUMBERS)
        depth = np.where(kind == WATER, np.float32(np.inf), texels[..., 1])
        return IdMaps(kind.astype(np.uint8), number, depth)

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self.framebuffer, self._texture, self._depth):
            held.release()
