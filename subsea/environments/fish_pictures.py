"""Pictures of a living sea without a window: what a fish sees, and a view from behind it."""

from contextlib import ExitStack
from dataclasses import replace

import numpy as np

from subsea.core.arrays import Bytes
from subsea.dive.retina_images import SIDES, velocity_of
from subsea.dive.start import headless, picture_maker
from subsea.frame.packet import pack
from subsea.render.output.quality import PRESETS
from subsea.view.camera import View
from subsea.view.display_rigs import display_rig
from subsea.view.follow import FollowCamera, follow_fish
from subsea.view.retina import FishEyes, fish_eyes, retina_rig, retinal_views
from subsea.view.rig import views
from subsea.world.world import World

QUALITY = "low"


class FishPictures:
    """A renderer of one world; a UserError without OpenGL."""

    def __init__(self, world: World, size: tuple[int, int]) -> None:
        """Open an OpenGL context; pictures from behind have `size` pixels."""
        self._world, self._rig = world, display_rig("mono", size)
        self._camera: tuple[int, FollowCamera] | None = None
        self._eyes: dict[int, FishEyes] = {}
        with ExitStack() as stack:
            context = stack.enter_context(headless())
            self._renderer = stack.enter_context(
                picture_maker(context, world, self._rig, PRESETS[QUALITY])
            )
            self._open = stack.pop_all()

    def behind(self, fish: int) -> Bytes:
        """The fish from behind (height, width, 3); the camera follows it smoothly."""
        before = self._camera[1] if self._camera and self._camera[0] == fish else None
        camera, pose = follow_fish(self._world, fish, 1.0, before)
        self._camera = fish, camera
        return self._draw(views(self._rig, pose), fish)[0]

    def retina(self, fish: int, size: tuple[int, int]) -> Bytes:
        """Both eyes side by side (height, 2 width, 3), the left one first."""
        by = self._eyes.setdefault(fish, fish_eyes(self._world, fish))
        rig = retina_rig(size, by.half_cm)
        with self._renderer.apart(rig):
            return np.concatenate(
                self._draw(retinal_views(self._world, by, rig, 1.0), fish, len(SIDES)), axis=1
            )

    def close(self) -> None:
        """Release the OpenGL context."""
        self._open.close()

    def _draw(self, seen: tuple[View, ...], fish: int, outputs: int = 1) -> list[Bytes]:
        packet = pack(self._world, seen, 1.0, options=PRESETS[QUALITY].packing)
        packet = replace(packet, passing_cm_s=velocity_of(self._world, fish))
        self._renderer.draw(packet)
        return [self._renderer.read_pixels(output) for output in range(outputs)]
