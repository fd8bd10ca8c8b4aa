"""A photograph behind the side view, to trace its outline."""

from pathlib import Path
from typing import Any

from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.base.extras import require
from subsea.rendering.gl.image_texture import ImageTexture
from subsea.studio.handles import Box

FIELD = 7.0  # width of an input, text heights


class PhotoOverlay:
    """A photograph and its place, in body lengths of the side view."""

    def __init__(self, context: Any, pixels: NDArray[Any]) -> None:
        """Take pixels (h, w, 3), top row first; at first as wide as the fish is long."""
        self.shown = ImageTexture(context, pixels)
        self.high = pixels.shape[0] / pixels.shape[1]  # height over width
        self.left, self.middle, self.wide = 0.0, 0.0, 1.0
        self.flipped = False

    @property
    def box(self) -> Box:
        """Left, low, right, high; left and right are swapped if it is flipped."""
        half = 0.5 * self.wide * self.high
        left, right = self.left, self.left + self.wide
        if self.flipped:
            left, right = right, left
        return left, self.middle - half, right, self.middle + half

    def draw_options(self) -> None:
        """Draw a button that opens the options of its place."""
        if imgui.button("Photograph"):
            imgui.open_popup("##photograph")
        if imgui.begin_popup("##photograph"):
            for name in ("left", "middle", "wide"):
                imgui.set_next_item_width(FIELD * imgui.get_font_size())
                low, high = (0.1, 20.0) if name == "wide" else (-10.0, 10.0)
                now = getattr(self, name)
                _, now = imgui.drag_float(f"{name}, lengths", now, 0.002, low, high, "%.3f")
                setattr(self, name, now)
            _, self.flipped = imgui.checkbox("the fish heads right", self.flipped)
            imgui.end_popup()

    def release(self) -> None:
        """Free the texture."""
        self.shown.release()


def read_photo(path: Path) -> NDArray[Any]:
    """Return the pixels of a photograph; UserError for another file, or without OpenCV."""
    require("skin", "the photograph")
    from subsea.studio.photograph import read_photograph

    return read_photograph(path).colour
