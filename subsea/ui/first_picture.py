"""The first picture of a dive, kept to show it at once when the same dive begins again.

Loading takes seconds; the same scenario and seed begin with the same picture.

Create a world, and show it at rest until its fishes can move.
"""

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.disk_cache import keep, recall
from subsea.dive.start import WAKING, wake
from subsea.dive.warm_up import warm_up
from subsea.jobs.background import run_in_background
from subsea.scenario.schema import Scenario
from subsea.world.build import create_world
from subsea.world.world import World

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
        self._read = False  # the picture of this dive
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

    def keep(self, read: Callable[[], Bytes]) -> None:
        """Keep the picture (h, w, 3) that `read` gives for the next time.

        Only the first call counts. It replaces one that an earlier version of the program drew.
        """
        if self._read:
            return
        self._read, pixels = True, read()
        step = -(-pixels.shape[1] // MOST_PX)
        small = np.ascontiguousarray(pixels[::step, ::step])
        if self._pixels is None or not np.array_equal(small, self._pixels):
            keep(self._name, small)

    def release(self) -> None:
        """Free the texture."""
        if self._texture is not None:
            self._texture.release()
            self._texture = None


Tell = Callable[[str], None]


class Loader:
    """Loads worlds in a thread."""

    def __init__(self, look: Callable[[str | None], None]) -> None:
        """`look` handles events meanwhile, shows lines on the progress, and may raise."""
        self.at_rest = False  # True while a world is shown whose fishes cannot move yet
        self._look = look

    def create(self, scenario: Scenario, source: Path, seed: int | None) -> World:
        """Create the world of a scenario at tick 0, with kernels compiled."""

        def work(tell: Tell) -> World:
            warm_up(tell)
            return create_world(scenario, seed, progress=tell, source=str(source))

        return run_in_background(work, self._look)

    def wake(self, world: World) -> None:
        """Make the first tick of a world that was created last, which is drawn already."""

        def work(tell: Tell) -> None:
            tell(WAKING)  # shows the world at once
            wake(world)

        self.at_rest = True
        try:
            run_in_background(work, self._look)
        finally:
            self.at_rest = False
