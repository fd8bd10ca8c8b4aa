"""A swimming fish in a panel, turned by the mouse."""

from typing import Any

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.fish.species import Species
from subsea.fish.swimmer import Swimmer
from subsea.rendering.fish.preview import FishPreview, Orbit

TURN = 0.008  # rad per pointer unit
ZOOM = 1.12  # per step of the wheel
FIRST_ORBIT = Orbit(turn=0.35, tilt=0.12)


class PreviewPanel:
    """A species, its sheet, and how it swims."""

    def __init__(self, context: Any, species: Species, sheet: NDArray[np.uint8]) -> None:
        """Show a species with a sheet, bottom row first."""
        self.orbit = FIRST_ORBIT
        self.swimmer = Swimmer(species)
        self._fish = FishPreview(context, species, sheet)

    def reshape(self, species: Species) -> None:
        """Change the shape, and keep swimming."""
        self.swimmer.reshape(species)
        self._fish.update(species)

    def set_sheet(self, species: Species, sheet: NDArray[np.uint8]) -> None:
        """Show another sheet."""
        self._fish.update(species, sheet)

    def draw(self, size: tuple[float, float], scale: float, elapsed_s: float) -> None:
        """Draw it, `size` in pointer units of `scale` pixels.

        The left button turns the fish, the wheel zooms, a double click resets both.
        """
        size = max(size[0], 1.0), max(size[1], 1.0)
        corner = imgui.get_cursor_screen_pos()
        imgui.invisible_button("preview", size)
        if imgui.is_item_hovered():
            imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
            self.orbit = self.orbit.zoomed(ZOOM ** imgui.get_io().mouse_wheel)
            if imgui.is_mouse_double_clicked(0):
                self.orbit = FIRST_ORBIT
        if imgui.is_item_active():
            moved = imgui.get_io().mouse_delta
            self.orbit = self.orbit.moved(-TURN * moved.x, TURN * moved.y)
        points = self.swimmer.advance(elapsed_s)
        pixels = max(round(size[0] * scale), 1), max(round(size[1] * scale), 1)
        texture = self._fish.draw(points, self.orbit, pixels)
        imgui.get_window_draw_list().add_image_rounded(
            imgui.ImTextureRef(texture.glo), corner, (corner.x + size[0], corner.y + size[1]),
            (0.0, 1.0), (1.0, 0.0), imgui.get_color_u32((1.0, 1.0, 1.0, 1.0)), 4.0,
        )  # fmt: skip

    def release(self) -> None:
        """Free every OpenGL object."""
        self._fish.release()
