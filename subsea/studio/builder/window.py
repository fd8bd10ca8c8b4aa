"""The fish builder: two views of one fish, numbers, checks, and the fish swimming."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui

from subsea.base.errors import UserError
from subsea.biomechanics.body import MUSCLES
from subsea.fish.species import is_shipped, own_species_file, species_file
from subsea.rendering.fish.preview import Orbit
from subsea.rendering.gl.textures import ImageTexture
from subsea.repertoire.findings import FishFinding
from subsea.studio.builder.assessment import Assessment, Picture, assess, draft_sheet, draw_findings
from subsea.studio.builder.jobs import CaptureJobs, draw_jobs, is_known, recorded
from subsea.studio.builder.panels import NumberPanels, draw_preview, draw_view_options, room
from subsea.studio.builder.views import OutlineViews, PhotoOverlay, read_photo, textured_view
from subsea.studio.draft import (
    EditError,
    EditState,
    KeyPath,
    SpeciesDraft,
    changed_on_disk,
    copy_draft,
    read_draft,
    save_draft,
    to_toml,
    with_values,
)
from subsea.studio.handles import drag_handle, handles
from subsea.studio.outline import remove_point
from subsea.studio.preview_panel import PreviewPanel
from subsea.studio.questions import NameDialog
from subsea.studio.tool_window import ToolWindow, run_tool
from subsea.ui.undo import History

TITLE = "subsea build"
WITHOUT = "a species is a text file: docs/reference/species.md"
START = "fusilier"  # the source of a new species, unless another is chosen
VIEWS_WIDTH, SIDE_HEIGHT = 0.62, 0.54  # shares of the window
PREVIEW_HEIGHT = 0.36
JOBS_HEIGHT = 5.2  # text heights
FRAME_S = 1 / 40  # while the fish swims
LEARNED = {"fit": ("body", "swim", "turn"), "learn": ("swim", "turn")}  # tables that a job writes
NUDGE = 0.002  # body lengths by which an arrow key moves a point
ARROWS = {
    imgui.Key.left_arrow: (-1, 0), imgui.Key.right_arrow: (1, 0),
    imgui.Key.up_arrow: (0, 1), imgui.Key.down_arrow: (0, -1),
}  # fmt: skip
HINT = (
    "Drag points, or nudge them by arrows; double-click a line to add one, Del takes it away. "
    "Wheel: larger. Right button: move the view."
)


class FishBuilder:
    """The tool that edits a species file."""

    def __init__(
        self,
        window: ToolWindow,
        draft: SpeciesDraft,
        path: Path | None,
        asks: bool = False,
        photo: Picture | None = None,
    ) -> None:
        """Begin with a draft that is saved at `path`; None: saving asks for a name first.

        With `asks` the name and the source are asked for at once. A `photo` (h, w, 3) lies behind
        the side view.
        """
        self.window, self.path = window, path
        self.editing, self.views, self.panels = EditState(draft), OutlineViews(), NumberPanels()
        self.jobs = CaptureJobs(window.wake)
        self.findings: list[FishFinding] | None = None  # on the present draft; None: not known yet
        self.naming = NameDialog(draft.key) if asks else None
        self._before_naming = self.editing, path  # restored if the dialog is cancelled
        self._file = draft if path else None  # as read or written last
        self.recorded = is_known(self.path) and recorded(draft.key)
        self._assessed: SpeciesDraft | None = None  # the last draft that was assessed
        self._shaped = draft
        sheet, _ = draft_sheet(draft)
        self.preview = PreviewPanel(window.context, draft.species, sheet)
        self.preview.orbit = Orbit(0.5, 0.2, 1.05)
        self.overlay = PhotoOverlay(window.context, photo) if photo is not None else None
        backdrop, self._box = textured_view(draft.species, sheet)
        self._backdrop = ImageTexture(window.context, backdrop)

    @property
    def history(self) -> History[SpeciesDraft]:
        """Undo history, which knows what is saved."""
        return self.editing.history

    def undo(self) -> None:
        """Go back by one edit."""
        self.editing.undo()

    def redo(self) -> None:
        """Go forward by one edit."""
        self.editing.redo()

    def save(self) -> bool:
        """Write the species file; a shipped species needs a new name first.

        Asks before it overwrites what another program wrote.
        """
        if self.naming:
            self.window.show_message("it has no name yet: Make it, or Cancel", error=True)
            return False
        if self.path is None:
            self.naming = NameDialog(self.editing.present.key, copies=False)
            return False
        if changed_on_disk(self.path, self._file):
            self.window.ask(
                f"{self.path.name} was changed outside since it was read or saved here.",
                {"Read it": self._reload, "Write over it": self._write, "Go on": None},
            )
            return False
        return self._write()

    def _reload(self) -> None:
        """Read the file again; Undo brings the edits back."""
        assert self.path
        self._file = found = read_draft(self.path)
        self.editing.do(lambda _: found)
        self.history.saved()

    def _write(self) -> bool:
        assert self.path
        save_draft(self.editing.present, self.path)
        self._file = read_draft(self.path)
        self.history.saved()
        self.window.show_message(f"saved as {self.path}")
        if self.recorded and not self.jobs.running:
            self.jobs.message = (
                "It was recorded before this was saved: Record takes up what changed."
            )
        return True

    def close(self) -> None:
        """Stop jobs, and free every texture."""
        self.jobs.close()
        self.preview.release()
        self._backdrop.release()
        if self.overlay:
            self.overlay.release()

    def draw_menu(self) -> None:
        """Draw New from…, disabled while a job works on the present fish."""
        if imgui.menu_item("New from…", "", False, not self.jobs.running)[0]:
            self.window.defer(partial(self.window.leave_work, self._begin_new))
        if self.jobs.running:
            imgui.set_item_tooltip("When Learn or Record has ended")

    def draw(self, elapsed_s: float) -> float:
        """Draw all panels."""
        self._update()
        window, editing = self.window, self.editing
        left, top, width, height = window.area
        views = round(VIEWS_WIDTH * width)
        side = round(SIDE_HEIGHT * height)
        flat = editing.present.species.surface.wing is not None
        swimmer = self.preview.swimmer
        contraction = swimmer.contraction if swimmer.moving else np.zeros(MUSCLES)
        backdrop = self._backdrop.glo, self._box
        with window.panel("Side", (left, top, views, side), titled=False):
            draw_view_options(self.views, editing, self.overlay, self._remove_point)
            behind = None if flat else backdrop
            if self.overlay:
                behind = self.overlay.shown.glo, self.overlay.box
            self.views.draw("side", editing, room(), contraction, behind)
        with window.panel("Top", (left, top + side, views, height - side), titled=False):
            self.views.draw("top", editing, room(), contraction, backdrop if flat else None)
        left, width = left + views, width - views
        preview = round(PREVIEW_HEIGHT * height)
        jobs = JOBS_HEIGHT * window.text_height
        with window.panel("Swimming", (left, top, width, preview), titled=False):
            draw_preview(self.preview, window, elapsed_s)
        numbers = height - preview - jobs
        with window.panel("Numbers", (left, top + preview, width, numbers), titled=False):
            self._draw_tabs()
        with window.panel("Making", (left, top + height - jobs, width, jobs), titled=False):
            if (end := self.jobs.ended()) is not None:
                self.take_job(*end)
            draw_jobs(self.jobs, self._key, self.recorded, self._job_starters(), window.text_height)
        if not (self.views.side.hovered or self.views.top.hovered):
            editing.hovered = self.panels.hovered
        if editing.dragging and not imgui.is_any_item_active() and not imgui.is_mouse_down(0):
            editing.commit()  # edits in popups, such as of colours
        self._handle_keys()
        if editing.refused:
            window.show_message(editing.refused, error=True)
            editing.refused = ""
        self._draw_naming()
        window.title, window.hint = f"{TITLE} · {editing.present.species.name}", HINT
        return FRAME_S if swimmer.moving else math.inf

    def _update(self) -> None:
        """Follow the present draft: its shape at once, the rest when the edit is complete."""
        draft = self.editing.present
        if draft is not self._shaped:
            self._shaped = draft
            self.preview.reshape(draft.species)
            self.findings = None
        if self.findings is None and not self.window.busy and not self.editing.dragging:
            self._assessed = draft
            self.window.run_in_background(lambda: assess(draft), self._take_assessment)

    def _take_assessment(self, assessment: Assessment) -> None:
        """Show an assessment, if it is of the present draft."""
        if self._assessed is self.editing.present:
            self.findings = assessment.findings
            self.preview.set_sheet(self.editing.present.species, assessment.sheet)
            self._backdrop.release()
            self._backdrop = ImageTexture(self.window.context, assessment.backdrop)
            self._box = assessment.box

    def _remove_point(self) -> None:
        path = self.editing.selected
        if path is not None and self.editing.do(lambda draft: remove_point(draft, path)):
            self.editing.selected = self.editing.hovered = None

    def _handle_keys(self) -> None:
        """Del removes the selected point, arrows move it in the view that was used last."""
        if imgui.get_io().want_text_input or self.window.asking or self.naming:
            return
        if imgui.is_key_pressed(imgui.Key.delete) or imgui.is_key_pressed(imgui.Key.backspace):
            self._remove_point()
        if imgui.is_key_pressed(imgui.Key.escape):
            self.views.adding = False
        for key, (right, up) in ARROWS.items():
            if imgui.is_key_pressed(key) and not imgui.is_any_item_active():
                self._nudge(NUDGE * right, NUDGE * up)

    def _nudge(self, right: float, up: float) -> None:
        view, path = self.views.view, self.editing.selected
        for handle in handles(self.editing.present, view):
            if handle.path == path:
                to = handle.at[0] + right, handle.at[1] + up
                edit = partial(drag_handle, view=view, path=path, to=to, soft=self.views.soft)
                self.editing.do(edit)
                return

    def _draw_tabs(self) -> None:
        if imgui.begin_tab_bar("##tabs"):
            if imgui.begin_tab_item("Checks", None, self.panels.tab_flags("Checks"))[0]:
                imgui.begin_child("##checks")
                draw_findings(self.findings, self.editing.present.species.spine is None)
                imgui.end_child()
                imgui.end_tab_item()
            self.panels.draw(self.editing)
            imgui.end_tab_bar()

    def _job_starters(self) -> dict[str, Callable[[], None] | None]:
        """Return what the buttons of jobs do, by name; unsaved work is saved first."""
        saved = self.path is not None and not self.history.unsaved

        def start(act: Callable[[], None]) -> None:
            self.window.defer(act if saved else partial(self._save_then, act))

        muscular = bool(self.editing.present.species.muscles)
        return {
            "Fit body": partial(start, self._fit) if muscular else None,
            "Learn": partial(start, self._learn) if muscular else None,
            "Record": partial(start, self._record),
        }

    def _save_then(self, act: Callable[[], object]) -> None:
        if self.save():
            act()

    def _fit(self) -> None:
        assert self.path
        self.jobs.fit(self.path)

    def _learn(self) -> None:
        assert self.path
        self.jobs.learn(self.path)

    def _record(self) -> None:
        if not is_known(self.path):
            raise UserError(
                f"{self.path} lies elsewhere: New from… puts a copy among your own species"
            )
        self.jobs.record(self._key)

    def take_job(self, kind: str, code: int) -> None:
        """Take the result of a job that has ended: its kind and its exit code."""
        self.recorded = is_known(self.path) and recorded(self._key)
        self.window.show_message(self.jobs.message, error=code not in (0, 130))
        if kind in LEARNED and code == 0:
            assert self.path and self._file
            found = read_draft(self.path)
            values: dict[KeyPath, Any] = {(key,): found.content[key] for key in LEARNED[kind]}
            self.editing.do(lambda draft: with_values(draft, values))
            if to_toml(with_values(self._file, values)) == found.text:
                self._file = found  # nothing else has changed there
            if self.editing.present.content == found.content:
                self.history.saved()

    @property
    def _key(self) -> str:
        """The name by which commands know the species."""
        return self.path.stem if self.path else ""

    def _begin_new(self) -> None:
        self._before_naming = self.editing, self.path
        self.naming = NameDialog(self.editing.present.key if self.path else START)

    def _draw_naming(self) -> None:
        """Draw the dialog for a new species, if it is open, and act on its answer."""
        naming = self.naming
        if naming is None:
            return
        confirmed = naming.draw()
        if confirmed is None:
            if naming.copies and self.editing.present.key != naming.source:
                source = read_draft(species_file(naming.source))  # show what will be copied
                self.editing, self.path = EditState(source), None
        elif confirmed:
            self._make_new(naming)
        else:
            self.naming = None
            if naming.copies:
                self.editing, self.path = self._before_naming

    def _make_new(self, naming: NameDialog) -> None:
        try:
            source = self.editing.present
            if naming.copies:
                source = read_draft(species_file(naming.source))
            draft = copy_draft(source, naming.key, naming.name)
            path = own_species_file(naming.key)
            if path.exists():
                raise EditError(f"There is a species {naming.key!r} already: choose another name.")
        except (EditError, UserError) as fault:
            self.window.show_message(str(fault), error=True)
            naming.reopen()
            return
        self.naming, self.path, self._file = None, path, None
        self.jobs.message, self.recorded = "", False
        if naming.copies:
            self.editing = EditState(draft, new=True)
        else:  # keeps the undo history
            self.editing.do(lambda _: draft)
            self.window.defer(self.window.save)


def build(name: str | None, in_place: bool, over: Path | None) -> int:
    """Open the builder with a species, or to begin a new one; exit code 0."""
    return run_tool(TITLE, builder_for(name, in_place, over), without=WITHOUT)


def builder_for(
    name: str | None, in_place: bool = False, over: Path | None = None
) -> Callable[[ToolWindow], FishBuilder]:
    """Return what makes a builder; a faulty file is a UserError before a window opens.

    A photograph `over` which the fish is drawn needs the extra `skin`.
    """
    path = species_file(name or START)
    draft = read_draft(path)
    shipped = species_file(draft.key) if is_shipped(draft.key) else None
    own = path if name is not None and (in_place or path != shipped) else None
    photo = read_photo(over) if over else None
    return lambda window: FishBuilder(window, draft, own, asks=name is None, photo=photo)
