"""The skin editor, `subsea skin PHOTO`: meshes over a photograph, and the fish that wears it."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui

from subsea.base.arrays import Bools, Bytes
from subsea.base.errors import UserError
from subsea.fish.color_sheet import assign_sheet, write
from subsea.fish.species import (
    is_shipped,
    load_species,
    own_species_file,
    repertoire_file,
    species_file,
    species_names,
)
from subsea.rendering.gl.textures import ImageTexture
from subsea.repertoire import read_repertoire, write_repertoire
from subsea.studio import mesh_edit
from subsea.studio.deformable_mesh import BODY, DORSAL, VENTRAL
from subsea.studio.draft import copy_draft, read_draft, save_draft
from subsea.studio.dress import check_mesh, check_sheet, load_mesh, save_mesh
from subsea.studio.fitting import FishFit, find_fish
from subsea.studio.mesh_edit import MeshSnapshot
from subsea.studio.photograph import Photograph, read_photograph
from subsea.studio.preview_panel import PreviewPanel
from subsea.studio.questions import NameDialog
from subsea.studio.side_view import side_view
from subsea.studio.skin_editor.document import MeshSliders, SkinDocument, lift_from
from subsea.studio.skin_editor.photo_canvas import MODES, PhotoCanvas, same_line
from subsea.studio.tool_window import ToolWindow, run_tool
from subsea.ui.gui import CLAMP, button
from subsea.ui.undo import History

DEFAULT_SPECIES = "clownfish"

COLUMN_SHARE, COLUMN_LEAST = 0.30, 21.0  # width of the right column: of the window, text heights
ROWS = 11.0  # of the mesh panel ...
MOST = 0.64  # ... which takes at most this share of the height
PREVIEW_SHARE = 0.55  # of the rest; the sheet has the remainder
FRAME_S = 1.0 / 25.0  # while the fish swims ...
BUSY_S = 0.2  # ... or there is work in the background
IDLE_S = 60.0  # without input the fish stops swimming after this
PARTS = {
    "All": (BODY, DORSAL, VENTRAL),
    "Body": (BODY,),
    "Dorsal": (DORSAL,),
    "Ventral": (VENTRAL,),
}
SQUARES = 8  # of the checkerboard behind the sheet, along a quarter of its width


class SkinEditor:
    """The tool: windows, files and background work around the document."""

    def __init__(
        self,
        window: ToolWindow,
        photograph: Photograph,
        name: str,
        flip: bool = False,
        mesh: Path | None = None,
        out: Path | None = None,
        force: bool = False,
    ) -> None:
        """Load the meshes of the file `mesh` if it exists, else look for the fish.

        Saving writes the sheet to `out`, or assigns it to the species, and the meshes to `mesh`.
        With `force` it replaces a file that is not a picture.
        """
        self.window, self.out, self.force = window, out, force
        self.mesh_file = mesh or photograph.path.with_suffix(".json")
        self._saves_mesh = mesh is not None
        self._naming: NameDialog | None = None
        self._renamed: dict[str, str] = {}  # shipped species -> the copies that were saved
        self._lifting: object | None = None  # identifies the sheet in progress that is wanted
        self.swims = True  # the fish in the preview ...
        self.painted = False  # ... which shows the painted sheet, for comparison
        self.document = document = SkinDocument(photograph, name, flip)
        self.canvas = PhotoCanvas(window.context, _on_black(photograph), document.colour.shape)
        self.texture = ImageTexture(window.context, _on_squares(document.sheet))
        self.preview = PreviewPanel(window.context, document.species, document.sheet)
        if mesh is not None and mesh.exists():
            document.load_mesh(mesh)
            document.begin_history()
        else:
            self.find(flip)

    @property
    def history(self) -> History[MeshSnapshot]:
        """Undo history, which knows what is saved."""
        return self.document.history

    def undo(self) -> None:
        """Go back by one edit."""
        if not self.canvas.dragging:
            self.document.relax(False)
            self._show(self.history.undo())

    def redo(self) -> None:
        """Go forward by one edit."""
        if not self.canvas.dragging:
            self._show(self.history.redo())

    def save(self) -> bool:
        """Write the sheet, and assign it to the species; a shipped one is copied first."""
        document = self.document
        if self.searching:
            self.window.show_message("not yet: the fish is still being looked for", error=True)
            return False
        if self.out is None and is_shipped(document.name):
            self._naming = self._naming or NameDialog(document.name, copies=False)
            return False
        document.relax(False)
        if self._saves_mesh:
            self.save_mesh()
        check_sheet(document.photograph.path, document.name, self.out, self.force)
        if self.working:
            document.sheet_outdated, self._lifting = False, None
            meshes = document.to_photo(document.meshes)
            self._take_sheet(
                lift_from(document.photograph, meshes, document.species, document.fish)
            )
        if self.out is not None:
            write(self.out, document.sheet)
            self.window.show_message(f"{self.out}: the sheet")
        else:
            assign_sheet(species_file(document.name), document.sheet)
            self.window.show_message(
                f"{document.species.name} wears it from now on: dive, and look for it."
            )
        document.history.saved()
        return True

    def draw_menu(self) -> None:
        """Draw the entries that save and load the mesh."""
        for label, enabled, act, verb in (
            ("Keep mesh", True, self.save_mesh, "write"),
            ("Take up mesh", self.mesh_file.exists(), self.load_mesh, "read"),
        ):
            if imgui.menu_item(label, "", False, enabled)[0]:
                self.window.defer(act)
            imgui.set_item_tooltip(f"{verb} {self.mesh_file}")

    def close(self) -> None:
        """Free every texture."""
        self.preview.release()
        self.texture.release()
        self.canvas.release()

    @property
    def searching(self) -> bool:
        """True if a search for the fish runs."""
        return self.document.search is not None

    @property
    def working(self) -> bool:
        """True if the sheet is not up to date."""
        return self.document.sheet_outdated or self._lifting is not None

    def find(self, flip: bool = False) -> None:
        """Look for the fish in the background, and lay the meshes over it."""
        document = self.document
        document.relaxing = False
        document.search = search = object()
        photograph, surface = document.photograph, document.species.surface

        def done(fit: FishFit | None) -> None:
            if document.search is not search:
                return
            document.search = None
            if fit is None:
                self.canvas.mode = "whole"
                self.window.show_message(
                    "No fish of this shape was found: lay the mesh over it.", error=True
                )
                document.record()
                return
            self.window.show_message(
                "The fish is found. Where the mesh misses its outline, pull at the mesh."
            )
            document.meshes = document.from_photo(fit.meshes)
            history = document.history
            if history.may_undo or history.present.name != document.name:
                document.record()
            else:  # nothing was edited so far
                document.begin_history()
            document.fish = fit.mask
            document.set_fish(fit.mask)

        def look() -> FishFit | None:
            try:
                return find_fish(photograph, surface, flip)
            except UserError:
                return None

        def failed() -> None:
            document.search = None

        self.window.run_in_background(look, done, "looking for the fish", failed)

    def choose(self, name: str) -> None:
        """Edit another species, with new meshes."""
        self.document.relaxing = False
        self._set_species(name)
        self.document.meshes = self.document.initial_meshes()
        self.find()

    def reset(self) -> None:
        """Lay the meshes across the photograph in the species' own shape."""
        self.document.relaxing = False
        self.document.meshes, self.canvas.mode = self.document.initial_meshes(), "whole"
        self.document.record()

    def save_mesh(self) -> None:
        """Write the meshes to their file."""
        document = self.document
        save_mesh(self.mesh_file, document.photograph, document.to_photo(document.meshes))
        self.window.show_message(f"{self.mesh_file}: the mesh")

    def load_mesh(self) -> None:
        """Read the meshes from their file."""
        self.document.load_mesh(self.mesh_file)
        self.document.record()

    def save_as(self, key: str, title: str) -> None:
        """Save as an own species that is built and moves as the present one."""
        document, path = self.document, own_species_file(key)
        for file in (path, path.with_suffix(".png")):
            if file.exists():
                raise UserError("exists; choose another name", file=file)
        save_draft(copy_draft(read_draft(species_file(document.name)), key, title), path)
        source = repertoire_file(document.name)
        if source.is_file():
            write_repertoire(repertoire_file(key), replace(read_repertoire(source), species=key))
        self._renamed[document.name] = key
        document.name, document.species = key, load_species(key)
        self.window.save()

    def _show(self, snapshot: MeshSnapshot) -> None:
        """Show a state of the undo history."""
        name = self._renamed.get(snapshot.name, snapshot.name)
        if name != self.document.name:
            self._set_species(name)
        self.document.restore(snapshot.meshes)

    def _set_species(self, name: str) -> None:
        document = self.document
        document.set_species(name)
        self.preview.release()
        self.preview = PreviewPanel(self.window.context, document.species, document.painted_sheet)
        document.sheet = document.painted_sheet
        self._show_sheet()
        document.sheet_outdated, document.fish, self._lifting = True, None, None

    def _show_sheet(self) -> None:
        self.texture.release()
        self.texture = ImageTexture(self.window.context, _on_squares(self.document.sheet))
        self._update_preview()

    def _update_preview(self) -> None:
        document = self.document
        sheet = document.painted_sheet if self.painted else document.sheet
        self.preview.set_sheet(document.species, sheet)

    def _lift(self) -> None:
        """Make the sheet from the present meshes, in the background."""
        document = self.document
        document.sheet_outdated, self._lifting = False, (lifting := object())
        meshes = document.to_photo(document.meshes)

        def done(result: tuple[Bytes, Bools]) -> None:
            if self._lifting is lifting:
                self._lifting = None
                self._take_sheet(result)

        def failed() -> None:
            self._lifting = None

        lift = partial(lift_from, document.photograph, meshes, document.species, document.fish)
        self.window.run_in_background(lift, done, "making the sheet", failed)

    def _take_sheet(self, result: tuple[Bytes, Bools]) -> None:
        self.document.set_sheet(*result)
        self._show_sheet()

    def draw(self, elapsed_s: float) -> float:
        """Draw all panels."""
        window, document, line = self.window, self.document, self.window.text_height
        if message := document.simulate(self.canvas.dragging):
            window.show_message(message)
        edited = document.relaxing or self.canvas.dragging
        if document.sheet_outdated and not (edited or self._lifting or self.searching):
            self._lift()
        left, top, width, height = window.area
        column = min(max(COLUMN_SHARE * width, COLUMN_LEAST * line), 0.5 * width)
        window.hint = MODES[self.canvas.mode][1]
        with window.panel("Photograph", (left, top, width - column, height), titled=False):
            self.canvas.draw_options()
            room = imgui.get_content_region_avail()
            self.canvas.draw(document, (room.x, room.y))
        left += width - column
        panel = min(ROWS * imgui.get_frame_height_with_spacing() + 2.6 * line, MOST * height)
        shown = PREVIEW_SHARE * (height - panel)
        sheet = height - panel - shown
        with window.panel("The fish that wears it", (left, top, column, shown)):
            self._draw_preview(elapsed_s)
        with window.panel("The mesh", (left, top + shown, column, panel)):
            self._draw_mesh()
        with window.panel("The sheet, which is saved", (left, top + height - sheet, column, sheet)):
            self._draw_sheet()
        if self._naming is not None and (confirmed := self._naming.draw()) is not None:
            key, title, self._naming = self._naming.key, self._naming.name, None
            if confirmed:
                window.defer(partial(self.save_as, key, title))
        if document.relaxing or self.canvas.dragging:
            return 0.0
        if window.busy:
            return BUSY_S
        return FRAME_S if self.swims and window.idle_s < IDLE_S else math.inf

    def _draw_preview(self, elapsed_s: float) -> None:
        """Draw the fish, and the choice of how it is shown."""
        room, window = imgui.get_content_region_avail(), self.window.window
        size = room.x, room.y - imgui.get_frame_height_with_spacing()
        scale = window.size[0] / window.points[0]
        self.preview.draw(size, scale, elapsed_s if self.swims else 0.0)
        self.swims = imgui.checkbox("Swims", self.swims)[1]
        for label, painted in (("After", False), ("Before", True)):
            same_line(label)
            if imgui.radio_button(label, self.painted == painted):
                self.painted = painted
                self._update_preview()

    def _draw_mesh(self) -> None:
        """Draw the species, the actions on the meshes, and the sliders."""
        document, canvas, defer = self.document, self.canvas, self.window.defer
        imgui.push_item_width(-7.5 * imgui.get_font_size())
        if imgui.begin_combo("species", document.species.name):
            for name in species_names():
                if imgui.selectable(name.replace("_", " "), name == document.name)[0]:
                    defer(lambda name=name: self.choose(name))  # type: ignore[misc]
            imgui.end_combo()
        for label, enabled, act, tip in (
            ("Place", not self.searching, self.find, "Find the fish, and lay the mesh over it."),
            ("Reset", True, self.reset, "Lay the mesh across the picture in its own shape."),
            ("Flip", True, document.flip, "The fish heads the other way."),
        ):
            if button(label, enabled):
                defer(act)
            imgui.set_item_tooltip(tip)
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
            off = ", ".join(
                f"{name} {100.0 * off:.1f} %" for name, off in document.fin_errors.items()
            )
            imgui.text(f"fins: {off} of the length off")
            imgui.set_item_tooltip(
                "Mean distance of the roots of the fins from the species' proportions."
                "\nFins that are folded or taller count too."
            )
        imgui.align_text_to_frame_padding()
        imgui.text_disabled("touch")
        for label, parts in PARTS.items():
            if all(part in document.meshes.parts for part in parts) or label == "All":
                same_line(label)
                if imgui.radio_button(label, canvas.parts == parts):
                    canvas.parts = parts
        _draw_sliders(document)
        imgui.pop_item_width()

    def _draw_sheet(self) -> None:
        """Draw the sheet (h, w) as it will be saved."""
        room = imgui.get_content_region_avail()
        height, width = self.document.sheet.shape[:2]
        scale = min(room.x / width, room.y / height)
        corner = imgui.get_cursor_screen_pos()
        x, y = corner.x + (room.x - scale * width) / 2, corner.y
        imgui.get_window_draw_list().add_image(
            imgui.ImTextureRef(self.texture.glo), (x, y), (x + scale * width, y + scale * height)
        )
        imgui.dummy((room.x, scale * height))


def edit_skin(
    photo: Path,
    name: str | None,
    out: Path | None,
    flip: bool,
    mesh: Path | None,
    force: bool = False,
) -> int:
    """Open the skin editor until it is closed; exit code 0.

    Faults of the arguments are one-line UserErrors before the window opens.
    """
    name = name or DEFAULT_SPECIES
    species, photograph = load_species(name), read_photograph(photo)
    side_view(species.surface)
    check_mesh(mesh, flip)
    if mesh is not None and mesh.exists():
        load_mesh(mesh, photograph, species)
    if out is not None or not is_shipped(name):  # else it gets a name of its own
        check_sheet(photo, name, out, force)
    return run_tool(
        f"subsea skin  {photo.name}",
        lambda window: SkinEditor(window, photograph, name, flip, mesh, out, force),
        "`subsea skin PHOTO --species NAME --auto` works",
    )


def _draw_sliders(document: SkinDocument) -> None:
    """Draw the settings of the forces on the meshes."""
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
    known = document.mask is not None
    for label, found in (("all", False), ("the fish found", True)):
        same_line(label)
        imgui.begin_disabled(found and not known)
        if imgui.radio_button(label, (document.sliders.found and known) == found):
            document.sliders = document.sliders._replace(found=found)
        imgui.end_disabled()
    imgui.same_line()
    if imgui.button("Usual"):
        document.sliders = MeshSliders()


def _on_black(photograph: Photograph) -> Bytes:
    """Return the colours of a photograph, dark where it is transparent."""
    if photograph.opacity is None:
        return photograph.colour
    share = photograph.opacity[..., None] / 255.0
    return np.asarray(photograph.colour * (0.12 + 0.88 * share)).astype(np.uint8)


def _on_squares(sheet: Bytes) -> Bytes:
    """Return a sheet, top row first, over a checkerboard that shows transparency."""
    height, width = sheet.shape[:2]
    side = width // (4 * SQUARES)
    y, x = np.mgrid[:height, :width] // side
    squares = np.where((x + y) % 2, 46.0, 62.0)[..., None]
    share = sheet[..., 3:] / 255.0
    return (sheet[..., :3] * share + squares * (1.0 - share)).astype(np.uint8)[::-1]
