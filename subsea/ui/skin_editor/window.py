"""The window of `subsea skin`: meshes over a photograph, and the fish that wears it."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from imgui_bundle import imgui

from subsea.core.arrays import Bools, Bytes
from subsea.core.errors import UserError
from subsea.core.undo import History
from subsea.fish.color_sheet import sheet_of, wear, write
from subsea.fish.editing.draft import copied as draft_of
from subsea.fish.editing.draft import read as read_draft
from subsea.fish.editing.draft import save
from subsea.fish.photo import mesh_edit
from subsea.fish.photo.deformable_mesh import (
    LAW,
    Field,
    Law,
    Net,
    copied,
    field,
    meshes,
    step,
    transform,
)
from subsea.fish.photo.dress import check_mesh, check_sheet, load_mesh, save_mesh
from subsea.fish.photo.fitting import Found, found, outline_error, under
from subsea.fish.photo.lift import lifted
from subsea.fish.photo.mesh_edit import Pose
from subsea.fish.photo.photograph import Photograph, read, small
from subsea.fish.photo.side_view import across, at_rest, laid
from subsea.fish.species import (
    Species,
    is_shipped,
    load_species,
    own_species_file,
    repertoire_file,
    species_file,
)
from subsea.render.gl.image_texture import ImageTexture
from subsea.repertoire import read_repertoire, write_repertoire
from subsea.ui.fish_builder.new_species import Naming
from subsea.ui.skin_editor import panels
from subsea.ui.skin_editor.panels import Sliders
from subsea.ui.skin_editor.photo_canvas import HANDS, Easel
from subsea.ui.skin_editor.preview import Preview
from subsea.ui.tool_window import Bench, work

USUAL = "clownfish"  # who wears it, unless somebody is named

COLUMN_SHARE, COLUMN_LEAST = 0.30, 21.0  # width of the right column: of the window, in letters
ROWS = 11.0  # of the panel of the mesh ...
MOST = 0.64  # ... which takes at most this of the height; of what it leaves ...
PREVIEW_SHARE = 0.55  # ... the fish has this, and the sheet the rest
STEPS = 5  # of the simulation in a frame: slow enough to be watched
STILL = 0.01  # pixels a step: what moves less has come to rest
PATIENCE = 4000  # steps: two outlines may pull at one node for ever
FRAME_S = 1.0 / 25.0  # of a fish that swims ...
BUSY_S = 0.2  # the same while something is done in the background
TIRED_S = 60.0  # ... until nobody has done anything for so long
CHECKS = 8  # squares behind what is clear, along the sheet


class Dressing:
    """A species, a photograph, and the meshes between them: the craft at the bench.

    Places in its nets are pixels of a small picture, where forces have their usual strengths;
    `large` takes a net to the pixels of the photograph.
    """

    def __init__(
        self,
        bench: Bench,
        photograph: Photograph,
        name: str,
        flip: bool = False,
        mesh: Path | None = None,
        out: Path | None = None,
    ) -> None:
        """Take up the meshes of the file `mesh` if it is there, else look for the fish.

        What is saved is worn by the species, or written to `out` alone; the meshes go to `mesh`.
        """
        self.bench, self.photograph = bench, photograph
        self.mesh_file = mesh or photograph.path.with_suffix(".json")
        self._keeps = mesh is not None  # whether the meshes are saved with the sheet
        self._out = out
        self._naming: Naming | None = None  # the question what a copy is to be called
        self._renamed: dict[str, str] = {}  # shipped species by the copies that were saved
        self.sliders = Sliders()
        self.relaxing = False
        self._colour, self._share = small(photograph)
        self._told: Bools | None = None  # the fish told apart for the present meshes, if known
        self._mask: Bools | None = None  # the fish that was found, in the small picture
        self._steps = 0
        self._felt: tuple[float, bool] | None = None  # for which `_field` was made
        self._field: Field | None = None
        self._stale = True  # whether the sheet is not that of the present meshes
        self._taken_up = False  # whether meshes came from a file: then they show where the fish is
        self._search: object | None = None  # for the fish, as long as its result is wanted
        self._lifting: object | None = None  # the sheet that is being made, if it is wanted
        self.painted = False  # whether the preview wears what was painted, to compare
        self.error: float | None = None
        self._species(name)
        self.net = self._fresh()
        if flip:
            self.net = mesh_edit.flipped(self.net)
        self.history: History[Pose] = History(Pose(name, copied(self.net)))
        self.easel = Easel(bench.context, _on_black(photograph), self._colour.shape[:2])
        self.sheet = self._paint
        self.shown_sheet = ImageTexture(bench.context, _seen(self.sheet))
        self.preview = Preview(bench.context, self.species, self.sheet)
        if mesh is not None and mesh.exists():
            self._taken_up = True
            self.net = self.small(load_mesh(mesh, photograph, self.species))
            self.history = History(Pose(name, copied(self.net)))
        else:
            self.find(flip)

    def _species(self, name: str) -> None:
        """Take up a species, or leave all as it was: a faulty one is a UserError."""
        species = load_species(name)
        rest, painted = at_rest(species.surface), sheet_of(species)
        self.name, self.species, self.rest, self._paint = name, species, rest, painted

    # What the bench asks of a craft.

    @property
    def unsaved(self) -> bool:
        """Whether the meshes are others than those that were saved."""
        return self.history.unsaved

    @property
    def may_undo(self) -> bool:
        """Whether there is something to undo."""
        return self.history.may_undo and not self.easel.dragging

    @property
    def may_redo(self) -> bool:
        """Whether something was undone."""
        return self.history.may_redo and not self.easel.dragging

    def undo(self) -> None:
        """Go back by one edit."""
        if self.relaxing:
            self.relax(False)
        self._take(self.history.undo())

    def redo(self) -> None:
        """Go forth by one edit."""
        self._take(self.history.redo())

    def save(self) -> bool:
        """Write the sheet, and have the species wear it; one that is shipped as a copy."""
        if self.searching:
            self.bench.tell("not yet: it is still looking for the fish", trouble=True)
            return False
        if self._out is None and is_shipped(self.name):
            self._naming = self._naming or Naming(self.name, copies=False)
            return False
        self.relax(False)
        if self._keeps:
            self.keep_mesh()
        check_sheet(self.photograph.path, self.name, self._out)
        if self.working:
            self._stale, self._lifting = False, None
            self._lifted(_lift(self.photograph, self.large(self.net), self.species, self._told))
        if self._out is not None:
            write(self._out, self.sheet)
            self.bench.tell(f"{self._out}: the sheet")
        else:
            wear(species_file(self.name), self.sheet)
            self.bench.tell(f"{self.species.name} wears it from now on: dive, and look for it.")
        self.history.saved()
        return True

    def bar(self) -> None:
        """A mesh is kept in a file, and taken up again."""
        for words, may, act, what in (
            ("Keep mesh", True, self.keep_mesh, "write"),
            ("Take up mesh", self.mesh_file.exists(), self.take_up_mesh, "read"),
        ):
            if imgui.menu_item(words, "", False, may)[0]:
                self.bench.later(act)
            imgui.set_item_tooltip(f"{what} {self.mesh_file}")

    def close(self) -> None:
        """Free every picture."""
        self.preview.release()
        self.shown_sheet.release()
        self.easel.release()

    # What is done.

    def did(self) -> None:
        """The present meshes are worth to be kept."""
        self.history.do(Pose(self.name, copied(self.net)))
        self._stale, self._told, self._search = True, None, None

    def find(self, flip: bool = False) -> None:
        """Look for the fish in the photograph, and lay the meshes over it."""
        self.relaxing = False
        self._search = search = object()
        surface = self.species.surface

        def done(result: Found | None) -> None:
            if self._search is not search:  # hands went on meanwhile
                return
            self._search = None
            if result is None:
                self.easel.hand = "whole"
                self.bench.tell("No fish of this shape was found: lay the mesh over it.", True)
                self.did()
                return
            self.net = self.small(result.net)
            self.bench.tell("The fish is found. Where its outline is not met, pull at the mesh.")
            if self.history.may_undo or self.history.present.name != self.name:
                self.did()
            else:  # no hand has done anything so far
                self.history, self._stale = History(Pose(self.name, copied(self.net))), True
            self._told = result.mask
            self._see(result.mask)

        def look() -> Found | None:
            try:
                return found(self.photograph, surface, flip)
            except UserError:
                return None

        def failed() -> None:
            self._search = None

        self.bench.behind(look, done, "looking for the fish", failed)

    def relax(self, on: bool) -> None:
        """Let the springs and the picture move the meshes, or stop that."""
        if self.relaxing and not on:
            self.did()
        self.relaxing, self._steps = on, 0

    def flip(self) -> None:
        """Have the fish head the other way."""
        self.relaxing = False
        self.net = mesh_edit.flipped(self.net)
        self.did()

    def choose(self, name: str) -> None:
        """Dress another species: its meshes begin anew."""
        self.relaxing = False
        self._species(name)
        self._refit()
        self.net = self._fresh()
        self.find()

    def anew(self) -> None:
        """Lay the meshes in the species' own shape across the photograph, to be put in place."""
        self.relaxing = False
        self.net, self.easel.hand = self._fresh(), "whole"
        self.did()

    def _fresh(self) -> Net:
        height, width = self._colour.shape[:2]
        return laid(self.species.surface, across(width, height, self.species.surface))

    def keep_mesh(self) -> None:
        """Write the present meshes to their file."""
        save_mesh(self.mesh_file, self.photograph, self.large(self.net))
        self.bench.tell(f"{self.mesh_file}: the mesh")

    def take_up_mesh(self) -> None:
        """Go on with the meshes of their file."""
        net = self.small(load_mesh(self.mesh_file, self.photograph, self.species))
        self.relax(False)
        self.net, self._taken_up = net, True
        self.did()

    def large(self, net: Net) -> Net:
        """A net over the small picture, over the photograph."""
        other = copied(net)
        middle = np.full(2, 0.5 / self._share - 0.5)
        transform(other, np.eye(2) / self._share, np.zeros(2), middle)
        for one in meshes(other).values():
            one.anchors[:] = one.anchors / self._share + middle
        return other

    def small(self, net: Net) -> Net:
        """The other way round."""
        other = copied(net)
        middle = np.full(2, 0.5 * self._share - 0.5)
        transform(other, np.eye(2) * self._share, np.zeros(2), middle)
        for one in meshes(other).values():
            one.anchors[:] = one.anchors * self._share + middle
        return other

    @property
    def searching(self) -> bool:
        """Whether it looks for the fish."""
        return self._search is not None

    @property
    def knows_fish(self) -> bool:
        """Whether the fish was told apart from what lies behind it."""
        return self._mask is not None

    @property
    def working(self) -> bool:
        """Whether the sheet is not that of the present meshes yet."""
        return self._stale or self._lifting is not None

    @property
    def law(self) -> Law:
        """How strong everything is, as the sliders say."""
        return LAW._replace(
            tension=self.sliders.tension,
            rigidity=self.sliders.rigidity,
            picture=self.sliders.picture,
        )

    @property
    def reach(self) -> float:
        """So far about the hand the mesh follows it, pixels."""
        row = self.net.body.nodes[len(self.net.body.nodes) // 2]
        return self.sliders.reach * float(np.hypot(*(row[0] - row[-1])))

    @property
    def field(self) -> Field:
        """What the picture does to nodes."""
        felt = self.sliders.smoothing, self.sliders.found and self._mask is not None
        if self._field is None or felt != self._felt:
            told = self._mask if felt[1] else None
            seen: Any = self._colour if told is None else told
            self._field = field(seen, self.sliders.smoothing)
            self._felt = felt
            self.easel.show_field(self._field)
        return self._field

    def _take(self, pose: Pose) -> None:
        self.relaxing = False
        name = self._renamed.get(pose.name, pose.name)
        if name != self.name:
            self._species(name)
            self._refit()
        self.net = copied(pose.net)
        self._stale, self._told = True, None

    def _refit(self) -> None:
        """There is another species in the preview."""
        self.preview.release()
        self.preview = Preview(self.bench.context, self.species, self._paint)
        self._wear(self._paint)
        self._stale, self._told, self._lifting = True, None, None

    def _wear(self, sheet: Bytes) -> None:
        self.sheet = sheet
        self.shown_sheet.release()
        self.shown_sheet = ImageTexture(self.bench.context, _seen(sheet))
        self.dress()

    def dress(self) -> None:
        """Let the fish of the preview wear its sheet, or what was painted."""
        self.preview.dress(self.species, self._paint if self.painted else self.sheet)

    def _begin_to_lift(self) -> None:
        """Have the sheet made from the present meshes, in the background."""
        self._stale, self._lifting = False, (lifting := object())
        photograph, species = self.photograph, self.species
        net, told = self.large(self.net), self._told

        def done(result: tuple[Bytes, Bools]) -> None:
            if self._lifting is lifting:  # nothing else is worn meanwhile
                self._lifting = None
                self._lifted(result)

        def failed() -> None:
            self._lifting = None

        lift = partial(_lift, photograph, net, species, told)
        self.bench.behind(lift, done, "making the sheet", failed)

    def _lifted(self, result: tuple[Bytes, Bools]) -> None:
        """There is another sheet."""
        sheet, mask = result
        if self._mask is None and self._taken_up:
            self._see(mask)
        if self._mask is not None:
            self.error = outline_error(self.net, self._mask)
        self._wear(sheet)

    def _see(self, mask: Bools) -> None:
        """This of the photograph is the fish."""
        size = self._colour.shape[1::-1]
        there = cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA)
        self._mask, self._field = np.asarray(there > 0.5), None
        if self.easel.edges:
            _ = self.field

    def _save_as(self, key: str, title: str) -> None:
        """Save as a species of one's own that is built and moves as the present one."""
        path = own_species_file(key)
        for one in (path, path.with_suffix(".png")):
            if one.exists():
                raise UserError(f"{one}: is there already, expected another name")
        save(draft_of(read_draft(species_file(self.name)), key, title), path)
        source = repertoire_file(self.name)
        if source.is_file():
            write_repertoire(repertoire_file(key), replace(read_repertoire(source), species=key))
        self._renamed[self.name] = key
        self.name, self.species = key, load_species(key)
        self.bench.save()

    # What is drawn.

    def draw(self, elapsed_s: float) -> float:
        """All panes."""
        self._simulate()
        idle = not (self.relaxing or self.easel.dragging or self._lifting or self._search)
        if self._stale and idle:
            self._begin_to_lift()
        bench, line = self.bench, self.bench.line
        left, top, width, height = bench.room
        column = min(max(COLUMN_SHARE * width, COLUMN_LEAST * line), 0.5 * width)
        bench.hint = HANDS[self.easel.hand][1]
        with bench.pane("Photograph", left, top, width - column, height, titled=False):
            panels.tools(self)
            room = imgui.get_content_region_avail()
            self.easel.draw(self, (room.x, room.y))
        left += width - column
        panel = min(ROWS * imgui.get_frame_height_with_spacing() + 2.6 * line, MOST * height)
        shown = PREVIEW_SHARE * (height - panel)
        sheet = height - panel - shown
        with bench.pane("The fish that wears it", left, top, column, shown):
            panels.fish(self, elapsed_s)
        with bench.pane("The mesh", left, top + shown, column, panel):
            panels.mesh(self)
        with bench.pane("The sheet, which is saved", left, top + height - sheet, column, sheet):
            panels.sheet(self)
        if self._naming is not None and (named := self._naming.draw(bench)) is not None:
            key, title, self._naming = self._naming.key, self._naming.name, None
            if named:
                bench.later(partial(self._save_as, key, title))
        if self.relaxing or self.easel.dragging:
            return 0.0
        if self.bench.busy:
            return BUSY_S
        return FRAME_S if self.preview.swims and bench.quiet_s < TIRED_S else math.inf

    def _simulate(self) -> None:
        if not self.relaxing:
            return
        moved = step(self.net, self.field, mesh_edit.stable(self.law), STEPS)
        self._steps += STEPS
        if (moved < STILL or self._steps > PATIENCE) and not self.easel.dragging:
            self.bench.tell(
                "The mesh has come to rest."
                if moved < STILL
                else "The mesh does not come to rest: two outlines pull at it. Anchors may help."
            )
            self.relax(False)


def _lift(
    photograph: Photograph, net: Net, species: Species, told: Bools | None
) -> tuple[Bytes, Bools]:
    """The sheet of a species under meshes, and the fish told apart there, if that is not known."""
    mask = under(photograph, net) if told is None else told
    return lifted(photograph.colour, net, species, mask), mask


def dress_by_hand(
    photo: Path, name: str | None, out: Path | None, flip: bool, mesh: Path | None
) -> int:
    """Open the window, and work in it until it is closed; exit code 0.

    Whatever is wrong with what is given is told before that opens, in one line.
    """
    name = name or USUAL
    species, photograph = load_species(name), read(photo)
    at_rest(species.surface)
    check_mesh(mesh, flip)
    if mesh is not None and mesh.exists():
        load_mesh(mesh, photograph, species)
    if out is not None or not is_shipped(name):  # else it gets a name of its own
        check_sheet(photo, name, out)
    return work(
        f"subsea skin  {photo.name}",
        lambda bench: Dressing(bench, photograph, name, flip, mesh, out),
        "`subsea skin PHOTO --species NAME --auto` works",
    )


def _on_black(photograph: Photograph) -> Bytes:
    """The colours of a photograph, dark where it is clear."""
    if photograph.opacity is None:
        return photograph.colour
    share = photograph.opacity[..., None] / 255.0
    return np.asarray(photograph.colour * (0.12 + 0.88 * share)).astype(np.uint8)


def _seen(sheet: Bytes) -> Bytes:
    """A sheet, bottom row first, over squares: what is clear is told from what is white."""
    height, width = sheet.shape[:2]
    side = width // (4 * CHECKS)
    y, x = np.mgrid[:height, :width] // side
    squares = np.where((x + y) % 2, 46.0, 62.0)[..., None]
    share = sheet[..., 3:] / 255.0
    return (sheet[..., :3] * share + squares * (1.0 - share)).astype(np.uint8)[::-1]
