"""The panels of the skin editor: view options, the preview, the mesh, the sheet."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from imgui_bundle import imgui

from subsea.fish.species import species_names
from subsea.rendering.gl.textures import ImageTexture
from subsea.studio import mesh_edit
from subsea.studio.deformable_mesh import BODY, DORSAL, VENTRAL
from subsea.studio.preview_panel import PreviewPanel
from subsea.studio.skin_editor.document import MeshSliders, SkinDocument
from subsea.studio.skin_editor.photo_canvas import MODES, PhotoCanvas
from subsea.ui.gui import CLAMP, button

PARTS = {
    "All": (BODY, DORSAL, VENTRAL),
    "Body": (BODY,),
    "Dorsal": (DORSAL,),
    "Ventral": (VENTRAL,),
}


@dataclass(frozen=True)
class MeshActions:
    """The actions of the mesh panel's buttons."""

    choose: Callable[[str], object]  # another species
    find: Callable[[], object]
    reset: Callable[[], object]
    flip: Callable[[], object]


def draw_view_options(canvas: PhotoCanvas) -> None:
    """Draw the choice of the mouse mode, and of what is shown."""
    for number, (mode, (label, tip)) in enumerate(MODES.items()):
        if number:
            _same_line(label)
        if imgui.radio_button(label, canvas.mode == mode):
            canvas.mode = mode
        imgui.set_item_tooltip(tip)
    _same_line("Photograph Edges", gap=1.5)
    if imgui.radio_button("Photograph", not canvas.edges):
        canvas.edges = False
    _same_line("Edges")
    if imgui.radio_button("Edges", canvas.edges):
        canvas.edges = True
    _same_line("Mesh lines")
    canvas.lines = imgui.checkbox("Mesh lines", canvas.lines)[1]
    _same_line("Whole picture")
    if imgui.button("Whole picture"):
        canvas.view.fit()


def _same_line(label: str, gap: float = 0.0) -> None:
    """Put the next widget beside the last, if there is room for its label."""
    line = imgui.get_font_size()
    imgui.same_line(0.0, imgui.get_style().item_spacing.x + gap * line)
    if imgui.get_content_region_avail().x < imgui.calc_text_size(label).x + 2.0 * line:
        imgui.new_line()


@dataclass
class PreviewOptions:
    """Settings of the fish preview."""

    swims: bool = True
    painted: bool = False  # show the painted sheet, for comparison


def draw_preview(
    preview: PreviewPanel, options: PreviewOptions, scale: float, elapsed_s: float
) -> bool:
    """Draw the fish; return True if it should show another sheet."""
    room = imgui.get_content_region_avail()
    size = room.x, room.y - imgui.get_frame_height_with_spacing()
    preview.draw(size, scale, elapsed_s if options.swims else 0.0)
    options.swims = imgui.checkbox("Swims", options.swims)[1]
    changed = False
    for label, painted in (("After", False), ("Before", True)):
        _same_line(label)
        if imgui.radio_button(label, options.painted == painted):
            options.painted, changed = painted, True
    return changed


def draw_mesh(
    document: SkinDocument,
    canvas: PhotoCanvas,
    actions: MeshActions,
    defer: Callable[[Callable[[], object]], None],
    searching: bool,
) -> None:
    """Draw the species, the actions on the meshes, and the sliders."""
    imgui.push_item_width(-7.5 * imgui.get_font_size())
    if imgui.begin_combo("species", document.species.name):
        for name in species_names():
            if imgui.selectable(name.replace("_", " "), name == document.name)[0]:
                defer(lambda name=name: actions.choose(name))  # type: ignore[misc]
        imgui.end_combo()
    if button("Place", not searching):
        defer(actions.find)
    imgui.set_item_tooltip("Find the fish, and lay the mesh over it.")
    imgui.same_line()
    if imgui.button("Reset"):
        defer(actions.reset)
    imgui.set_item_tooltip("Lay the mesh across the picture in its own shape.")
    imgui.same_line()
    if imgui.button("Flip"):
        defer(actions.flip)
    imgui.set_item_tooltip("The fish heads the other way.")
    imgui.same_line()
    if imgui.button("Stop###relax" if document.relaxing else "Relax###relax"):
        document.relax(not document.relaxing)
    imgui.set_item_tooltip("Let the mesh snap to the edges, and come to rest.")
    imgui.same_line()
    if button("Lift anchors", bool(mesh_edit.anchored_nodes(document.meshes))):
        document.meshes = mesh_edit.without_anchors(document.meshes)
        document.record()
    if document.error is not None:
        imgui.text(f"outline: {100.0 * document.error:.1f} % of the length off the fish")
        imgui.set_item_tooltip("Mean distance to the outline of the fish that was found.")
    if document.fin_errors:
        off = ", ".join(f"{name} {100.0 * off:.1f} %" for name, off in document.fin_errors.items())
        imgui.text(f"fins: {off} of the length off")
        imgui.set_item_tooltip(
            "Mean distance of the roots of the fins from the species' proportions."
            "\nFins that are folded or taller count too."
        )
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("touch")
    for label, parts in PARTS.items():
        if all(part in document.meshes.parts for part in parts) or label == "All":
            _same_line(label)
            if imgui.radio_button(label, canvas.parts == parts):
                canvas.parts = parts
    _draw_sliders(document)
    imgui.pop_item_width()


def _draw_sliders(document: SkinDocument) -> None:
    for key, label, low, high, tip in (
        ("tension", "tension", 0.0, 1.0, "Resistance to stretching."),
        ("rigidity", "rigidity", 0.0, 0.6, "Resistance to bending."),
        ("picture", "pull of edges", 0.0, 20.0, "Attraction of its border by edges."),
        ("smoothing", "smoothing", 0.7, 12.0, "σ: from how far away edges attract."),
        ("reach", "reach", 0.03, 1.0, "Distance from the pointer up to which the mesh follows."),
    ):  # fmt: skip
        value: Any = getattr(document.sliders, key)
        _, value = imgui.slider_float(label, value, low, high, "%.2f", CLAMP)
        imgui.set_item_tooltip(tip)
        document.sliders = document.sliders._replace(**{key: value})
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("edges of")
    known = document.fish_known
    for label, found in (("all", False), ("the fish found", True)):
        _same_line(label)
        imgui.begin_disabled(found and not known)
        if imgui.radio_button(label, (document.sliders.found and known) == found):
            document.sliders = document.sliders._replace(found=found)
        imgui.end_disabled()
    imgui.same_line()
    if imgui.button("Usual"):
        document.sliders = MeshSliders()


def draw_sheet(texture: ImageTexture, shape: tuple[int, ...]) -> None:
    """Draw the sheet (h, w) as it will be saved."""
    room = imgui.get_content_region_avail()
    height, width = shape[:2]
    scale = min(room.x / width, room.y / height)
    corner = imgui.get_cursor_screen_pos()
    x, y = corner.x + (room.x - scale * width) / 2, corner.y
    imgui.get_window_draw_list().add_image(
        imgui.ImTextureRef(texture.glo), (x, y), (x + scale * width, y + scale * height)
    )
    imgui.dummy((room.x, scale * height))
