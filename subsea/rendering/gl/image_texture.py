"""Pictures as textures for panels."""

from typing import Any

import numpy as np

from subsea.base.arrays import Bytes


class ImageTexture:
    """A picture on the GPU; `glo` is its OpenGL name, which panels need."""

    def __init__(self, context: Any, pixels: Bytes) -> None:
        """Upload pixels (h, w, 3 or 4), top row first, halved until the GPU can hold them."""
        most = context.info["GL_MAX_TEXTURE_SIZE"]
        while max(pixels.shape[:2]) > most:
            pixels = pixels[::2, ::2]
        height, width, planes = pixels.shape
        self._texture = context.texture(
            (width, height), planes, np.ascontiguousarray(pixels).tobytes(), alignment=1
        )
        self._texture.build_mipmaps()
        self._texture.filter = context.LINEAR_MIPMAP_LINEAR, context.LINEAR
        self._texture.repeat_x = self._texture.repeat_y = False
        self.glo: int = self._texture.glo

    def release(self) -> None:
        """Free the texture; no panel may show it any more."""
        self._texture.release()
