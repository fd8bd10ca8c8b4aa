"""A fish in a panel that turns under the hand and swims."""

from typing import Any

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.fish.editing.swimmer import Swimmer
from subsea.fish.species import Species
from subsea.render.fish.preview import FishPreview, Orbit

TURN = 0.008  # rad for each unit of the pointer
ZOOM = 1.12  # of a step of the wheel
AT_FIRST = Orbit(turn=0.35, tilt=0.12)


class Preview:
    """A species in a sheet; drawn into the panel that is current."""

    def __init__(self, context: Any, species: Species, sheet: NDArray[np.uint8]) -> None:
        """Dressed in a sheet, bottom row first, as `skins.paint` makes them."""
        self.orbit = AT_FIRST
        self.swims = True
        self._swimmer = Swimmer(species)
        self._specimen = FishPreview(context, species, sheet)

    def dress(self, species: Species, sheet: NDArray[np.uint8]) -> None:
        """Another sheet, for the same fish."""
        self._specimen.dress(species, sheet)

    def draw(self, size: tuple[float, float], pixels: float, elapsed_s: float) -> None:
        """Draw it at that size in pointer units, `pixels` for each.

        The left button turns it, the wheel zooms, a double click turns it back.
        """
        size = max(size[0], 1.0), max(size[1], 1.0)
        corner = imgui.get_cursor_screen_pos()
        imgui.invisible_button("preview", size)
        if imgui.is_item_hovered():
            imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
            self.orbit = self.orbit.zoomed(ZOOM ** imgui.get_io().mouse_wheel)
            if imgui.is_mouse_double_clicked(0):
                self.orbit = AT_FIRST
        if imgui.is_item_active():
            moved = imgui.get_io().mouse_delta
            self.orbit = self.orbit.moved(-TURN * moved.x, TURN * moved.y)
        points = self._swimmer.swum(elapsed_s if self.swims else 0.0)
        whole = max(round(size[0] * pixels), 1), max(round(size[1] * pixels), 1)
        texture = self._specimen.draw(points, self.orbit, whole)
        imgui.get_window_draw_list().add_image_rounded(
            imgui.ImTextureRef(texture.glo), corner, (corner.x + size[0], corner.y + size[1]),
            (0.0, 1.0), (1.0, 0.0), imgui.get_color_u32((1.0, 1.0, 1.0, 1.0)), 4.0,
        )  # fmt: skip

    def release(self) -> None:
        """Free every OpenGL object."""
        self._specimen.release()
