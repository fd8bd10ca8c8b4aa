"""Identity and depth of the thing at each pixel: identity and range maps (Tu §6.7).

The triangles of a picture are drawn again by the same vertex shaders, and by fragment shaders
compiled with `OBJECT_IDS` (`shaders/show.glsl`). A pixel shows the nearest thing that covers its
middle and hides at least half of what lies behind it. Haze hides nothing. Shadows and light shafts
are not things, and specks of plankton and marine snow are too soft to separate from the water.
"""

from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.base.errors import UserError
from subsea.rendering.gl.context import GpuOwner
from subsea.view.rig import Rect

# Kinds of things. An object id packs a kind and a number into one float32, exactly.
KINDS = (
    "water", "surface", "seabed", "pillar", "rock", "coral", "seaweed", "bubbles", "hook",
    "fish",
)  # fmt: skip
WATER, SURFACE, SEABED, PILLAR, ROCK, CORAL, SEAWEED, BUBBLES, HOOK, FISH = range(10)
NUMBERED = "pillar", "rock", "coral", "fish"  # kinds whose things have a number
NUMBERS = 2**20  # ids of one kind


def object_id(kind: int, number: Any = 0) -> Any:
    """The object id of `number`, a scalar or an array, among things of this kind."""
    return float(kind * NUMBERS) + number


class IdMaps(NamedTuple):
    """Content of the pixels of a canvas (h, w), top row first."""

    kind: Ints  # (h, w) uint8, index into KINDS
    number: Ints  # (h, w) int32, index of the fish, pillar, rock or growth; else 0
    depth: Array  # (h, w) float32, cm along the view's axis, infinite in open water
    # (h, w, 2) float32, change of 1 / depth from pixel to pixel, to the right and down, on the
    # plane of the triangle that is seen; None: not known
    slope: Array | None = None

    def normals(self, focal_px: float) -> Array:
        """The unit normals (h, w, 3) of the drawn triangles; NaN in open water.

        Axes of the camera: x right, y down, z ahead. It is a pinhole that looks along the middle of
        the picture.
        """
        if self.slope is None:
            raise ValueError("these maps have no slopes")
        # On the plane n·p = c, 1 / z is n·(x, y, 1) / c, with x and y from the middle.
        across, down = self.slope[..., 0], self.slope[..., 1]
        height, width = self.depth.shape
        x, y = (np.arange(side, dtype=np.float32) - 0.5 * (side - 1) for side in (width, height))
        focal = np.float32(-focal_px)
        steep = x * across + y[:, None] * down - np.float32(1.0) / self.depth
        normal = np.stack([focal * across, focal * down, steep], axis=-1)
        length = np.sqrt((normal * normal).sum(axis=-1, keepdims=True))
        normal /= np.where(np.isfinite(self.depth)[..., None], length, np.nan)
        return np.asarray(normal)


class IdBuffer(GpuOwner):
    """The framebuffer that object ids and depths are drawn into."""

    def __init__(self, context: Any, size: tuple[int, int]) -> None:
        """Make it `size` (width, height) pixels large; UserError if the GPU cannot hold it."""
        super().__init__()
        self.size = size
        try:
            texture = self.own(context.texture(size, 4, dtype="f4"))
            depth = self.own(context.depth_renderbuffer(size))
        except moderngl.Error as fault:
            raise UserError(
                f"maps of {size[0]}x{size[1]} pixels are more than this GPU can hold; "
                "take a smaller --size"
            ) from fault
        self.framebuffer = self.own(context.framebuffer([texture], depth))

    def read(self, part: Rect | None = None) -> IdMaps:
        """Read back object ids, depths and slopes, from a part of the canvas or all of it."""
        part = part or (0, 0, *self.size)
        width, height = part[2:]
        data = self.framebuffer.read(part, components=4, dtype="f4")
        texels = np.frombuffer(data, np.float32).reshape(height, width, 4)[::-1]
        kind, number = np.divmod(texels[..., 0].astype(np.int32), NUMBERS)
        depth = np.where(kind == WATER, np.float32(np.inf), texels[..., 1])
        slope = texels[..., 2:] * np.array([1.0, -1.0], np.float32)
        return IdMaps(kind.astype(np.uint8), number, depth, slope)
