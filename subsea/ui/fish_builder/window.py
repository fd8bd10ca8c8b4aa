"""The window of the fish builder: two views of one fish, numbers, checks, and the fish swimming."""

import math
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from imgui_bundle import imgui
from numpy.typing import NDArray

from subsea.biomechanics.body import MUSCLES
from subsea.core.errors import UserError
from subsea.fish.color_sheet import sheet_of
from subsea.fish.editing import checks
from subsea.fish.editing import draft as drafts
from subsea.fish.editing.checks import Mark, Remark
from subsea.fish.editing.draft import Box, Draft, EditError
from subsea.fish.editing.edit_state import Editing
from subsea.fish.editing.swimmer import WAYS, Swimmer
from subsea.fish.paint import paint
from subsea.fish.species import is_shipped, own_species_file, species_file, species_names
from subsea.render.fish.preview import FishPreview, Orbit
from subsea.render.gl.image_texture import ImageTexture
from subsea.ui.fish_builder.jobs import FEWEST, MOST, Making, recorded
from subsea.ui.fish_builder.new_species import Naming
from subsea.ui.fish_builder.number_panels import Panels
from subsea.ui.fish_builder.tracing import Tracing
from subsea.ui.fish_builder.views import Views, dressed
from subsea.ui.gui import QUIET, colour
from subsea.ui.tool_window import Bench, work

Picture = NDArray[np.uint8]

TITLE = "subsea build"
WITHOUT = "a species is a text file: docs/species.md"
START = "fusilier"  # what a new species is copied from, unless another is chosen
VIEWS_WIDE, SIDE_HIGH = 0.62, 0.54  # shares of the window
PREVIEW_HIGH = 0.36
FRAME_S = 1 / 40  # between two pictures of the fish that swims
WAY_WIDE = 3.9  # room that a way to swim takes, in heights of letters
NUDGE = 0.002  # body lengths that an arrow key moves a point
ARROWS = {
    imgui.Key.left_arrow: (-1, 0), imgui.Key.right_arrow: (1, 0),
    imgui.Key.up_arrow: (0, 1), imgui.Key.down_arrow: (0, -1),
}  # fmt: skip
TURN = 0.009  # rad of the orbit for a unit of the pointer
ZOOM = 1.15
SIGNS = {
    Mark.GOOD: ("ok", (0.45, 0.85, 0.55)),
    Mark.MIND: ("!", (1.0, 0.80, 0.32)),
    Mark.BAD: ("x", (1.0, 0.45, 0.36)),
}
HOW = "Learn finds how to use its muscles. Record takes down its motion, for scenarios."
HINT = (
    "Drag points, or nudge them by arrows; double-click a line to add one, Del takes it away. "
    "Wheel: larger. Right button: move the view."
)


class Judged(NamedTuple):
    """What the work in the background found out about a draft."""

    remarks: list[Remark]
    sheet: Picture
    flank: Picture
    place: Box


def judge(draft: Draft) -> Judged:
    """Check a draft, try how it swims, and paint it."""
    species = draft.species
    remarks = checks.standing(species)
    if species.muscles:
        remarks += checks.told(checks.tried(species.muscles), species.muscles)
    sheet, trouble = sheet_for(draft)
    return Judged([*remarks, *trouble], sheet, *dressed(species, sheet))


def sheet_for(draft: Draft) -> tuple[Picture, list[Remark]]:
    """What a draft wears; what is wrong with its picture, if it has one that cannot be worn."""
    try:
        return sheet_of(drafts.worn(draft)), []
    except UserError as fault:
        return paint(draft.species), [Remark(Mark.BAD, f"Its picture cannot be worn: {fault}.")]


class Builder:
    """The fish builder, a `bench.Craft`."""

    def __init__(
        self, bench: Bench, draft: Draft, path: Path | None, asks: bool = False,
        photo: Picture | None = None,
    ) -> None:  # fmt: skip
        """Begin with a draft that is saved at `path`; None: it needs a name of its own first.

        With `asks` that name, and what to begin from, are asked for at once. A `photo` (h, w, 3)
        lies behind the side view.
        """
        self.bench, self.path = bench, path
        self.editing, self.views, self.panels = Editing(draft), Views(), Panels()
        self.swimmer = Swimmer(draft.species)
        self.making = Making(bench.wake)
        self.orbit = Orbit(0.5, 0.2, 1.05)
        self.remarks: list[Remark] | None = None  # of the present draft; None: not known yet
        self.naming = Naming(draft.key) if asks else None
        self._before = self.editing, path  # what is gone back to where no new one is made
        self._file = draft if path else None  # as it was read or written last
        self.swims = self._known and recorded(draft.key)  # whether it has a repertoire
        self._judged: Draft | None = None  # the last draft that was judged, or is being
        self._shaped = draft
        sheet, _ = sheet_for(draft)
        self.specimen = FishPreview(bench.context, draft.species, sheet)
        self.tracing = Tracing(bench.context, photo) if photo is not None else None
        flank, self._place = dressed(draft.species, sheet)
        self._flank = ImageTexture(bench.context, flank)

    @property
    def unsaved(self) -> bool:
        """Whether something would be lost."""
        return self.editing.history.unsaved

    @property
    def may_undo(self) -> bool:
        """Whether there is something to undo."""
        return self.editing.history.may_undo

    @property
    def may_redo(self) -> bool:
        """Whether something was undone."""
        return self.editing.history.may_redo

    def undo(self) -> None:
        """Go back by one edit."""
        self.editing.undo()

    def redo(self) -> None:
        """Go forth by one edit."""
        self.editing.redo()

    def save(self) -> bool:
        """Write the species file; a species that comes with the program first gets a new name.

        What something else has written there meanwhile is asked about first.
        """
        if self.naming:
            self.bench.tell("it has no name yet: Make it, or Cancel", trouble=True)
            return False
        if self.path is None:
            self.naming = Naming(self.editing.present.key, copies=False)
            return False
        if drafts.differs(self.path, self._file):
            self.bench.ask(
                f"{self.path.name} was changed outside since it was read or saved here.",
                {"Read it": self._read_again, "Write over it": self._write, "Go on": None},
            )
            return False
        return self._write()

    def _read_again(self) -> None:
        """Take the file as it is now; what was drawn comes back by Undo."""
        assert self.path
        self._file = found = drafts.read(self.path)
        self.editing.do(lambda _: found)
        self.editing.history.saved()

    def _write(self) -> bool:
        assert self.path
        drafts.save(self.editing.present, self.path)
        self._file = drafts.read(self.path)
        self.editing.history.saved()
        self.bench.tell(f"saved as {self.path}")
        if self.swims and not self.making.runs:
            self.making.told = (
                "It was recorded before this was saved: Record takes up what changed."
            )
        return True

    def close(self) -> None:
        """Stop what runs, and release what is on the graphics card."""
        self.making.close()
        self.specimen.release()
        self._flank.release()
        if self.tracing:
            self.tracing.release()

    def bar(self) -> None:
        """New from…, but not while something runs: that is about the fish on the table."""
        if imgui.menu_item("New from…", "", False, not self.making.runs)[0]:
            self.bench.later(self._ask_new)
        if self.making.runs:
            imgui.set_item_tooltip("When Learn or Record has ended")

    def draw(self, elapsed_s: float) -> float:
        """All panes; the seconds until it will look different."""
        self._follow()
        left, top, width, height = self.bench.room
        wide = round(VIEWS_WIDE * width)
        side = round(SIDE_HIGH * height)
        editing, contraction = self.editing, self._contraction()
        with self.bench.pane("Side", left, top, wide, side, titled=False):
            self._tools()
            seen = None if editing.present.species.surface.wing else self._dressed()
            if self.tracing:
                seen = self.tracing.shown.glo, self.tracing.box
            self.views.draw("side", editing, _room(), contraction, seen)
        with self.bench.pane("Top", left, top + side, wide, height - side, titled=False):
            seen = self._dressed() if editing.present.species.surface.wing else None
            self.views.draw("top", editing, _room(), contraction, seen)
        high = round(PREVIEW_HIGH * height)
        made = self.making.height * self.bench.line
        with self.bench.pane("Swimming", left + wide, top, width - wide, high, titled=False):
            self._preview(elapsed_s)
        with self.bench.pane(
            "Numbers", left + wide, top + high, width - wide, height - high - made, titled=False
        ):
            self._tabs()
        with self.bench.pane(
            "Making", left + wide, top + height - made, width - wide, made, titled=False
        ):
            self._make()
        if not (self.views.side.hovered or self.views.top.hovered):
            editing.over = self.panels.over
        if editing.held and not imgui.is_any_item_active() and not imgui.is_mouse_down(0):
            editing.settle()  # what was dragged in a window of its own, as colours are
        self._keys()
        if editing.refused:
            self.bench.tell(editing.refused, trouble=True)
            editing.refused = ""
        self._name()
        self.bench.title, self.bench.hint = f"{TITLE} · {editing.present.species.name}", HINT
        return FRAME_S if self.swimmer.moves else math.inf

    def _follow(self) -> None:
        """What is shown follows the present draft: its shape at once, all else when it settled."""
        draft = self.editing.present
        if draft is not self._shaped:
            self._shaped = draft
            self.swimmer.reshape(draft.species)
            self.specimen.dress(draft.species)
            self.remarks = None
        if self.remarks is None and not self.bench.busy and not self.editing.held:
            self._judged = draft
            self.bench.behind(lambda: judge(draft), self._tell_judged)

    def _tell_judged(self, judged: Judged) -> None:
        """What was found out about a draft, if it is still the present one."""
        if self._judged is self.editing.present:
            self.remarks = judged.remarks
            self.specimen.dress(self.editing.present.species, judged.sheet)
            self._flank.release()
            self._flank = ImageTexture(self.bench.context, judged.flank)
            self._place = judged.place

    def _dressed(self) -> tuple[int, Box]:
        return self._flank.glo, self._place

    def _contraction(self) -> NDArray[np.float64]:
        return self.swimmer.contraction if self.swimmer.moves else np.zeros(MUSCLES)

    def _tools(self) -> None:
        """What is shown in the views, and points more or fewer."""
        views = self.views
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
        imgui.begin_disabled(self.editing.chosen is None)
        if imgui.button("Take away"):
            self._take_away()
        imgui.end_disabled()
        imgui.same_line()
        if imgui.button("Fit"):
            views.fit()
        if self.tracing:
            imgui.same_line()
            self.tracing.panel()

    def _take_away(self) -> None:
        path = self.editing.chosen
        if path is not None and self.editing.do(lambda draft: drafts.removed(draft, path)):
            self.editing.chosen = self.editing.over = None

    def _keys(self) -> None:
        """Del takes the chosen point away, arrows nudge it in the view that was touched last."""
        if imgui.get_io().want_text_input or self.bench.asks or self.naming:
            return
        if imgui.is_key_pressed(imgui.Key.delete) or imgui.is_key_pressed(imgui.Key.backspace):
            self._take_away()
        if imgui.is_key_pressed(imgui.Key.escape):
            self.views.adding = False
        for key, (right, up) in ARROWS.items():
            if imgui.is_key_pressed(key) and not imgui.is_any_item_active():
                self._nudge(NUDGE * right, NUDGE * up)

    def _nudge(self, right: float, up: float) -> None:
        """The chosen point a little farther, if it is in the view that was touched last."""
        view, path = self.views.view, self.editing.chosen
        for spot in drafts.spots(self.editing.present, view):
            if spot.path == path:
                to = spot.at[0] + right, spot.at[1] + up
                self.editing.do(
                    partial(drafts.moved, view=view, path=spot.path, to=to, soft=self.views.soft)
                )
                return

    def _preview(self, elapsed_s: float) -> None:
        """The fish, turned by the mouse; how it swims is chosen below it."""
        room, line = _room(), self.bench.line
        size = max(int(room[0]), 8), max(int(room[1] - 1.9 * line), 8)
        scale = self.bench.window.size[0] / self.bench.window.points[0]
        pixels = round(size[0] * scale), round(size[1] * scale)
        points = self.swimmer.swum(elapsed_s)
        texture = self.specimen.draw(points, self.orbit, pixels)
        corner = imgui.get_cursor_screen_pos()
        imgui.invisible_button("##fish", size)
        end = corner.x + size[0], corner.y + size[1]
        imgui.get_window_draw_list().add_image(
            imgui.ImTextureRef(texture.glo), corner, end, (0.0, 1.0), (1.0, 0.0)
        )
        io = imgui.get_io()
        if imgui.is_item_active():
            self.orbit = self.orbit.moved(-TURN * io.mouse_delta.x, TURN * io.mouse_delta.y)
        if imgui.is_item_hovered() and io.mouse_wheel:
            imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
            self.orbit = self.orbit.zoomed(ZOOM**io.mouse_wheel)
        ways = WAYS if self.swimmer.turns else WAYS[:4]
        if room[0] < WAY_WIDE * line * len(ways):
            imgui.set_next_item_width(room[0])
            _, number = imgui.combo("##way", ways.index(self.swimmer.way), list(ways))
            self.swimmer.way = ways[number]
            return
        for number, way in enumerate(ways):
            if number:
                imgui.same_line()
            if imgui.radio_button(way.capitalize(), self.swimmer.way == way):
                self.swimmer.way = way

    def _tabs(self) -> None:
        if imgui.begin_tab_bar("##tabs"):
            if imgui.begin_tab_item("Checks", None, self.panels.opens("Checks"))[0]:
                imgui.begin_child("##checks")
                self._draw_checks()
                imgui.end_child()
                imgui.end_tab_item()
            self.panels.draw(self.editing)
            imgui.end_tab_bar()

    def _draw_checks(self) -> None:
        """What there is to say of the fish, the worst first."""
        if self.remarks is None:
            imgui.text_disabled("trying how it swims…")
            return
        for mark, text in sorted(self.remarks, key=lambda one: -one.mark):
            sign, ink = SIGNS[mark]
            place, size = imgui.get_cursor_screen_pos(), imgui.get_font_size()
            canvas = imgui.get_window_draw_list()
            middle = place.x + 0.6 * size, place.y + 0.5 * size
            canvas.add_circle_filled(middle, 0.55 * size, colour(ink))
            imgui.push_font(None, 0.72 * size)
            box = imgui.calc_text_size(sign)
            canvas.add_text(
                (middle[0] - box.x / 2, middle[1] - box.y / 2), colour((0.0, 0.08, 0.12)), sign
            )
            imgui.pop_font()
            imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + 1.6 * size)
            imgui.push_text_wrap_pos(0.0)
            imgui.text_wrapped(text)
            imgui.pop_text_wrap_pos()
        if self.editing.present.species.spine:
            imgui.push_text_wrap_pos(0.0)
            imgui.text_colored(
                (*QUIET, 1.0),
                "Its spine moves this fish: there are no masses and no muscles to try.",
            )
            imgui.pop_text_wrap_pos()

    def _make(self) -> None:
        """Learn, Record, and what they tell."""
        making, saved = self.making, self.path is not None and not self.unsaved
        for name, act, may in (
            ("Learn", self._learn, bool(self.editing.present.species.muscles)),
            ("Record", self._record, True),
        ):
            imgui.begin_disabled(making.runs or not may)
            if imgui.button(name):
                self.bench.later(act if saved else partial(self._save_then, act))
            imgui.end_disabled()
            imgui.same_line()
        if making.runs:
            if imgui.button("Stop"):
                making.stop()
            imgui.same_line()
            imgui.progress_bar(making.share, (-1.0, 0.0), making.doing)
        else:
            imgui.begin_disabled(not self.swims)
            if imgui.button("Dive with it"):
                making.dive(self._key)
            imgui.end_disabled()
            imgui.same_line()
            imgui.set_next_item_width(-6.0 * self.bench.line)
            changed, tries = imgui.drag_int("tries to learn", making.tries, 2.0, FEWEST, MOST)
            making.tries = tries if changed else making.tries
        if (end := making.ended()) is not None:
            self._ended(*end)
        imgui.push_text_wrap_pos(0.0)
        imgui.text_colored((*QUIET, 1.0), making.told or HOW)
        imgui.pop_text_wrap_pos()

    def _save_then(self, act: Callable[[], object]) -> None:
        if self.save():
            act()

    def _learn(self) -> None:
        assert self.path
        self.making.learn(self.path)

    def _record(self) -> None:
        if not self._known:
            raise UserError(
                f"{self.path} lies elsewhere: New from… puts a copy among your own species"
            )
        self.making.record(self._key)

    def _ended(self, kind: str, code: int) -> None:
        """A command has ended."""
        self.swims = self._known and recorded(self._key)
        self.bench.tell(self.making.told, trouble=code not in (0, 130))
        if kind == "learn" and code == 0:
            assert self.path and self._file
            found = drafts.read(self.path)
            values: dict[drafts.Path_, Any] = {
                (key,): found.content[key] for key in ("swim", "turn")
            }
            self.editing.do(lambda draft: drafts.changed_all(draft, values))
            if drafts.to_toml(drafts.changed_all(self._file, values)) == found.text:
                self._file = found  # nothing but controllers has changed there
            if self.editing.present.content == found.content:
                self.editing.history.saved()

    @property
    def _key(self) -> str:
        """The name of the species' file, by which commands know it."""
        return self.path.stem if self.path else ""

    @property
    def _known(self) -> bool:
        """Whether commands mean this file by its name, not another species' of the same name."""
        key = self._key
        return (
            self.path is not None
            and key in species_names()
            and species_file(key).resolve() == self.path.resolve()
        )

    def _ask_new(self) -> None:
        if self.unsaved:
            self.bench.ask(
                "There is unsaved work.",
                {
                    "Save": partial(self._save_then, self._begin_new),
                    "Throw it away": self._begin_new,
                    "Go on": None,
                },
            )
        else:
            self._begin_new()

    def _look_at(self, source: str) -> None:
        """Show the species that a new one may be built like."""
        if self.editing.present.key != source:
            self.editing, self.path = Editing(drafts.read(species_file(source))), None

    def _begin_new(self) -> None:
        self._before = self.editing, self.path
        self.naming = Naming(self.editing.present.key if self.path else START)

    def _name(self) -> None:
        """The question for a name, if it is open."""
        if self.naming is None:
            return
        answer = self.naming.draw(self.bench)
        if answer is None:
            if self.naming.copies:
                self._look_at(self.naming.source)
            return
        naming, self.naming = self.naming, None
        if not answer:
            if naming.copies:
                self.editing, self.path = self._before
            return
        try:
            source = (
                drafts.read(species_file(naming.source)) if naming.copies else self.editing.present
            )
            draft = drafts.copied(source, naming.key, naming.name)
            path = own_species_file(naming.key)
            if path.exists():
                raise EditError(f"There is a species {naming.key!r} already: choose another name.")
        except (EditError, UserError) as fault:
            self.bench.tell(str(fault), trouble=True)
            self.naming = naming
            naming.shown = False
            return
        self.path, self._file = path, None
        self.making.told, self.swims = "", False
        if naming.copies:
            self.editing = Editing(draft, new=True)
        else:  # what was done so far can still be undone
            self.editing.do(lambda _: draft)
            self.bench.later(self.bench.save)


def build(name: str | None, in_place: bool, over: Path | None) -> int:
    """Open the builder with a species, or to begin a new one; exit code 0."""
    return work(TITLE, begun(name, in_place, over), without=WITHOUT)


def begun(
    name: str | None, in_place: bool = False, over: Path | None = None
) -> Callable[[Bench], Builder]:
    """What puts a builder on a bench; a faulty file is a UserError before a window opens.

    The photograph `over` which is drawn needs the extra `skin`.
    """
    path = species_file(name or START)
    draft = drafts.read(path)
    keeps = name is not None and (in_place or path != shipped_path(draft.key))
    own = path if keeps else None
    photo = photograph(over) if over else None
    return lambda bench: Builder(bench, draft, own, asks=name is None, photo=photo)


def photograph(path: Path) -> Picture:
    """The pixels of a photograph; what is none is a UserError."""
    if find_spec("cv2") is None:
        raise UserError("photographs need OpenCV: install subsea[skin]")
    from subsea.fish.photo.photograph import read

    return read(path).colour


def shipped_path(key: str) -> Path | None:
    """The file of a species that comes with the program."""
    return species_file(key) if is_shipped(key) else None


def _room() -> tuple[float, float]:
    room = imgui.get_content_region_avail()
    return room.x, room.y
