"""The panels of `subsea skin`: hands and views, the fish, what is done to the mesh, the sheet."""

from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from imgui_bundle import imgui

from subsea.fish.photo import mesh_edit
from subsea.fish.photo.deformable_mesh import BODY, DORSAL, LAW, VENTRAL, meshes
from subsea.fish.species import species_names
from subsea.ui.skin_editor.photo_canvas import HANDS

if TYPE_CHECKING:
    from subsea.ui.skin_editor.window import Dressing

PARTS = {
    "All": (BODY, DORSAL, VENTRAL),
    "Body": (BODY,),
    "Dorsal": (DORSAL,),
    "Ventral": (VENTRAL,),
}
SMOOTHING = 1.8  # pixels of the small picture


class Sliders(NamedTuple):
    """What is felt how much."""

    tension: float = LAW.tension
    rigidity: float = LAW.rigidity
    picture: float = LAW.picture
    smoothing: float = SMOOTHING  # σ, pixels of the small picture
    found: bool = True  # whether the outline of the fish that was found is felt, not all edges
    reach: float = 0.15  # so far about the hand the mesh follows it, of the body's length


def tools(table: "Dressing") -> None:
    """Hands, and what is shown."""
    easel = table.easel
    for number, (hand, (words, tip)) in enumerate(HANDS.items()):
        if number:
            _beside(table, words)
        if imgui.radio_button(words, easel.hand == hand):
            easel.hand = hand
        imgui.set_item_tooltip(tip)
    _beside(table, "Photograph Edges", gap=1.5)
    if imgui.radio_button("Photograph", not easel.edges):
        easel.edges = False
    _beside(table, "Edges")
    if imgui.radio_button("Edges", easel.edges):
        easel.edges = True
        _ = table.field
    _beside(table, "Mesh lines")
    easel.lines = imgui.checkbox("Mesh lines", easel.lines)[1]
    _beside(table, "Whole picture")
    if imgui.button("Whole picture"):
        easel.canvas.fit()


def _beside(table: "Dressing", words: str, gap: float = 0.0) -> None:
    """What comes next stands beside the last, if there is room for its words."""
    imgui.same_line(0.0, imgui.get_style().item_spacing.x + gap * table.bench.line)
    wide = imgui.calc_text_size(words).x + 2.0 * table.bench.line
    if imgui.get_content_region_avail().x < wide:
        imgui.new_line()


def fish(table: "Dressing", elapsed_s: float) -> None:
    """The preview."""
    room = imgui.get_content_region_avail()
    foot = imgui.get_frame_height_with_spacing()
    window = table.bench.window
    pixels = window.size[0] / window.points[0]
    table.preview.draw((room.x, room.y - foot), pixels, elapsed_s)
    table.preview.swims = imgui.checkbox("Swims", table.preview.swims)[1]
    for words, painted in (("After", False), ("Before", True)):
        _beside(table, words)
        if imgui.radio_button(words, table.painted == painted):
            table.painted = painted
            table.dress()


def mesh(table: "Dressing") -> None:
    """What is done to the meshes, from the beginning to the end."""
    line = table.bench.line
    imgui.push_item_width(-7.5 * line)
    if imgui.begin_combo("species", table.species.name):
        for one in species_names():
            if imgui.selectable(one.replace("_", " "), one == table.name)[0]:
                table.bench.later(partial(table.choose, one))
        imgui.end_combo()
    imgui.begin_disabled(table.searching)
    if imgui.button("Place"):
        table.bench.later(table.find)
    imgui.set_item_tooltip("Look for the fish, and lay the mesh over it.")
    imgui.end_disabled()
    imgui.same_line()
    if imgui.button("Anew"):
        table.bench.later(table.anew)
    imgui.set_item_tooltip("Lay the mesh across the picture in its own shape.")
    imgui.same_line()
    if imgui.button("Flip"):
        table.bench.later(table.flip)
    imgui.set_item_tooltip("The fish heads the other way.")
    imgui.same_line()
    if imgui.button("Stop###relax" if table.relaxing else "Relax###relax"):
        table.relax(not table.relaxing)
    imgui.set_item_tooltip("Let the mesh take hold of the edges, and come to rest.")
    imgui.same_line()
    imgui.begin_disabled(not mesh_edit.anchors(table.net))
    if imgui.button("Lift anchors"):
        table.net = mesh_edit.without_anchors(table.net)
        table.did()
    imgui.end_disabled()
    if table.error is not None:
        imgui.text(f"outline: {100.0 * table.error:.1f} % of the length off the fish")
        imgui.set_item_tooltip("Mean distance to the outline of what was told apart.")
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("touch")
    for words, parts in PARTS.items():
        if all(part in meshes(table.net) for part in parts) or words == "All":
            _beside(table, words)
            if imgui.radio_button(words, table.easel.parts == parts):
                table.easel.parts = parts
    _slide(table)
    imgui.pop_item_width()


def _slide(table: "Dressing") -> None:
    was = table.sliders
    clamp = imgui.SliderFlags_.always_clamp.value
    for key, words, low, high, tip in (
        ("tension", "tension", 0.0, 1.0, "How much the mesh resists being stretched."),
        ("rigidity", "rigidity", 0.0, 0.6, "How much it resists being bent."),
        ("picture", "pull of edges", 0.0, 20.0, "How much its border is drawn to edges."),
        ("smoothing", "smoothing", 0.7, 12.0, "σ: from how far away edges are felt."),
        ("reach", "reach of the hand", 0.03, 1.0, "How far about it the mesh follows."),
    ):  # fmt: skip
        value: Any = getattr(table.sliders, key)
        _, value = imgui.slider_float(words, value, low, high, "%.2f", clamp)
        imgui.set_item_tooltip(tip)
        table.sliders = table.sliders._replace(**{key: value})
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("edges of")
    for words, told in (("all", False), ("the fish found", True)):
        _beside(table, words)
        imgui.begin_disabled(told and not table.knows_fish)
        chosen = table.sliders.found and table.knows_fish
        if imgui.radio_button(words, chosen == told):
            table.sliders = table.sliders._replace(found=told)
        imgui.end_disabled()
    imgui.same_line()
    if imgui.button("Usual"):
        table.sliders = Sliders()
    if table.sliders != was and (table.easel.edges or table.relaxing):
        _ = table.field


def sheet(table: "Dressing") -> None:
    """The sheet as it will be saved, over squares where it is clear."""
    room = imgui.get_content_region_avail()
    height, width = table.sheet.shape[:2]
    scale = min(room.x / width, room.y / height)
    corner = imgui.get_cursor_screen_pos()
    x, y = corner.x + (room.x - scale * width) / 2, corner.y
    imgui.get_window_draw_list().add_image(
        imgui.ImTextureRef(table.shown_sheet.glo), (x, y), (x + scale * width, y + scale * height)
    )
    imgui.dummy((room.x, scale * height))
