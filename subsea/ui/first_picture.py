"""The first picture of a dive, kept to show it at once when the same dive begins again.

Loading takes seconds; the same scenario and seed begin with the same picture.
"""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.disk_cache import keep, recall

MOST_PX = 640  # of its width: it is shown for seconds


def picture_name(scenario: Path, changes: Sequence[str], others: Sequence[object]) -> str:
    """The name of the first picture of a dive in a scenario file, with all that changes it."""
    about = hashlib.sha256(scenario.read_bytes())
    about.update(repr((tuple(changes), tuple(others))).encode())
    return f"first_picture-{about.hexdigest()[:32]}"


class FirstPicture:
    """Draws the kept picture over a window, or keeps the one that is shown first."""

    def __init__(self, name: str) -> None:
        """Look up the picture of that name."""
        self._name, self._texture = name, None
        self._pixels: Bytes | None = None
        try:
            pixels = recall(name, Bytes)
        except LookupError:
            return
        if pixels.ndim == 3 and pixels.shape[2] == 3 and pixels.size:
            self._pixels = pixels

    @property
    def known(self) -> bool:
        """True if there is a picture to show."""
        return self._pixels is not None

    def texture(self, context: Any) -> Any:
        """The picture as a texture, lowest row first; `release` frees it."""
        if self._texture is None and self._pixels is not None:
            height, width = self._pixels.shape[:2]
            data = np.ascontiguousarray(self._pixels[::-1]).tobytes()
            self._texture = context.texture((width, height), 3, data, alignment=1)
        return self._texture

    def keep(self, pixels: Bytes) -> None:
        """Keep the picture (h, w, 3) for the next time, in place of the one that was known."""
        step = -(-pixels.shape[1] // MOST_PX)
        keep(self._name, np.ascontiguousarray(pixels[::step, ::step]))

    def release(self) -> None:
        """Free the texture."""
        if self._texture is not None:
            self._texture.release()
            self._texture = None
