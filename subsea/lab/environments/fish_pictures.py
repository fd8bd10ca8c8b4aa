"""Pictures of a living sea without a window: what a fish sees, and a view from behind it."""

import numpy as np

from subsea.base.arrays import Bytes
from subsea.library.pictures import render, retina
from subsea.library.world import World as LibraryWorld
from subsea.view.follow import FollowCamera, follow_fish
from subsea.world.world import World

QUALITY = "low"


class FishPictures:
    """Draws one world; a UserError without OpenGL."""

    def __init__(self, world: World, size: tuple[int, int]) -> None:
        """Pictures from behind have `size` (width, height) pixels."""
        self._world, self._size = LibraryWorld(world), size
        self._camera: tuple[int, FollowCamera] | None = None

    def behind(self, fish: int) -> Bytes:
        """The fish from behind (height, width, 3); the camera follows it smoothly."""
        before = self._camera[1] if self._camera and self._camera[0] == fish else None
        camera, pose = follow_fish(self._world.internal, fish, 1.0, before)
        self._camera = fish, camera
        return render(self._world, pose, self._size, QUALITY)

    def retina(self, fish: int, size: tuple[int, int]) -> Bytes:
        """Both eyes side by side (height, 2 width, 3), the left one first."""
        return np.concatenate(retina(self._world, fish, size, quality=QUALITY).picture, axis=1)
