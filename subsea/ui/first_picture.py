"""The picture and the bar that a window shows while a dive is loading.

The first picture of a dive is kept to show it at once when the same dive begins again: the same
scenario and seed begin with the same picture. Before that the picture beside the scenario's file
shows the place.
"""

import hashlib
import math
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.disk_cache import keep, recall
from subsea.scenario.storage import read_thumbnail

MOST_PX = 640  # of its width: it is shown for seconds
STEPS = (
    ("loading", 0.0), ("reading repertoires", 0.1),
    ("shaping the seabed and growing the reef", 0.2), ("letting the fishes in", 0.5),
    ("waking the fishes", 0.55), ("starting OpenGL", 0.65),
)  # fmt: skip
"""Lines on the progress, each with the share of the work that is done when it begins."""
TYPICAL_S = 2.0  # in which a step is well under way
COMPILED = 0.7  # share of all work if kernels must be compiled


class LoadingBar:
    """The share of the loading that is done, by the lines on its progress."""

    def __init__(self) -> None:
        """Start with nothing done."""
        self._begun, self._end, self._since_s = 0.0, STEPS[1][1], time.monotonic()
        self._compiled = 0.0  # share of compiling, which is seldom necessary

    def follow(self, line: str) -> None:
        """Follow a line, such as ``compiling: 2/6``."""
        done, slash, number = line.rpartition(": ")[2].partition("/")
        if slash and done.isdecimal() and number.isdecimal():
            begun, end = (COMPILED * (int(done) + k) / max(int(number), 1) for k in (0, 1))
            self._compiled = COMPILED
            self._begin(begun, min(end, COMPILED))
            return
        for k, (words, share) in enumerate(STEPS):
            if words == line:
                end = STEPS[k + 1][1] if k + 1 < len(STEPS) else 1.0
                rest = 1.0 - self._compiled
                self._begin(self._compiled + rest * share, self._compiled + rest * end)

    def _begin(self, begun: float, end: float) -> None:
        self._begun, self._end = max(begun, self.share), end
        self._since_s = time.monotonic()

    @property
    def share(self) -> float:
        """The share that is done; it creeps on within a step, and never goes back."""
        passed = 1.0 - math.exp(-(time.monotonic() - self._since_s) / TYPICAL_S)
        return min(self._begun + passed * max(self._end - self._begun, 0.0), 1.0)


def picture_name(scenario: Path, changes: Sequence[str], others: Sequence[object]) -> str:
    """The name of the first picture of a dive in a scenario file, with all that changes it."""
    about = hashlib.sha256(scenario.read_bytes())
    about.update(repr((tuple(changes), tuple(others))).encode())
    return f"first_picture-{about.hexdigest()[:32]}"


class FirstPicture:
    """Draws the kept picture over a window, or keeps the one that is shown first."""

    def __init__(self, name: str = "", scenario: Path | None = None, shape: float = 16 / 9) -> None:
        """Look up the picture of that name, else the one beside the file of a scenario.

        That one is cut to the `shape` of the window: its width over its height.
        """
        self._name, self._texture = name, None
        self._pixels: Bytes | None = None
        with suppress(LookupError):
            pixels = recall(name, Bytes) if name else np.zeros((0, 0, 3), np.uint8)
            if pixels.ndim == 3 and pixels.shape[2] == 3 and pixels.size:
                self._pixels = pixels
        if self._pixels is None and scenario is not None:
            self._pixels = _place_picture(scenario, shape)

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
        """Keep the picture (h, w, 3) for the next time, in place of the one that was known.

        Without a name it is not kept.
        """
        if not self._name:
            return
        step = -(-pixels.shape[1] // MOST_PX)
        keep(self._name, np.ascontiguousarray(pixels[::step, ::step]))

    def release(self) -> None:
        """Free the texture."""
        if self._texture is not None:
            self._texture.release()
            self._texture = None


def _place_picture(scenario: Path, shape: float) -> Bytes | None:
    """The picture beside a scenario's file, enlarged smoothly; None without one."""
    small = read_thumbnail(scenario)
    if small is None:
        return None
    from PIL import Image

    height, width = small.shape[:2]
    across, down = min(width, round(height * shape)), min(height, round(width / shape))
    left, top = (width - across) // 2, (height - down) // 2
    part = Image.fromarray(small[top : top + max(down, 1), left : left + max(across, 1)])
    size = MOST_PX, max(round(MOST_PX / shape), 1)
    return np.asarray(part.resize(size, Image.Resampling.BICUBIC))
