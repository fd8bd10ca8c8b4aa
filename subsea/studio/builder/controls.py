"""The options of the outline views, and the swimming preview with its modes."""

from collections.abc import Callable

from imgui_bundle import imgui

from subsea.fish.swimmer import MODES
from subsea.studio.builder.tracing import PhotoOverlay
from subsea.studio.builder.views import OutlineViews
from subsea.studio.edit_state import EditState
from subsea.studio.tool_window import ToolWindow
from subsea.ui.gui import button
from subsea.ui.preview_panel import PreviewPanel

MODE_WIDTH = 3.9  # of a button of a swimming mode, text heights


def draw_view_options(
    views: OutlineViews,
    editing: EditState,
    overlay: PhotoOverlay | None,
    remove_point: Callable[[], None],
) -> None:
    """Draw the options of the views, and the buttons that add and remove points."""
    _, views.outline = imgui.checkbox("Outline", views.outline)
    imgui.same_line()
    _, views.scaffold = imgui.checkbox("Scaffold", views.scaffold)
    imgui.same_line()
    _, views.soft = imgui.checkbox("Soft", views.soft)
    imgui.set_item_tooltip("Points beside the one that is dragged go along")
    imgui.same_line()
    if imgui.button("Add point" if not views.adding else "Click on a line…"):
        views.adding = not views.adding
    imgui.same_line()
    if button("Take away", editing.selected is not None):
        remove_point()
    imgui.same_line()
    if imgui.button("Fit"):
        views.fit()
    if overlay:
        imgui.same_line()
        overlay.draw_options()


def draw_preview(preview: PreviewPanel, window: ToolWindow, elapsed_s: float) -> None:
    """Draw the fish, and the choice of how it swims."""
    (width, height), line = room(), window.text_height
    scale = window.window.size[0] / window.window.points[0]
    preview.draw((max(width, 8), max(height - 1.9 * line, 8)), scale, elapsed_s)
    swimmer = preview.swimmer
    modes = MODES if swimmer.can_turn else MODES[:4]
    if width < MODE_WIDTH * line * len(modes):
        imgui.set_next_item_width(width)
        _, number = imgui.combo("##way", modes.index(swimmer.mode), list(modes))
        swimmer.mode = modes[number]
        return
    for number, mode in enumerate(modes):
        if number:
            imgui.same_line()
        if imgui.radio_button(mode.capitalize(), swimmer.mode == mode):
            swimmer.mode = mode


def room() -> tuple[float, float]:
    """Return the free width and height of the present panel, in points."""
    free = imgui.get_content_region_avail()
    return free.x, free.y
