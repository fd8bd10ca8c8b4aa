"""The inspector ("desk" in settings and manual): a bar that opens panels over the sea (Tu §9.3).

While it is open the pointer does not steer: it uses panels, and picks and drags things in the sea.
Keys still steer.
"""

import itertools
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from imgui_bundle import imgui

from subsea.core.background import CancelledByUserError
from subsea.core.errors import UserError
from subsea.dive.intention_text import name_of
from subsea.ui.context import DiveContext, PanelContext
from subsea.ui.gui import GLASS, MARK, colour, recovering_errors
from subsea.ui.panels import PANELS

RING = 0.62  # radius of the ring around the chosen fish, in its lengths
LEAST_RING = 0.6  # least radius, in heights of letters
MARGIN, BAR = 0.7, 1.9  # around panels, and height of the bar, in heights of letters
LIKELY = 26.0, 20.0  # expected size of a panel before it is drawn, in the same
BACK = "To the helm"  # the bar's last entry
LEAST_SHARE = 0.1  # smallest factor on the bar's letters, in a narrow window
LEAST_GAP = 2.0  # between the bar's entries, in pointer units
PANEL = imgui.WindowFlags_.always_auto_resize.value | imgui.WindowFlags_.horizontal_scrollbar.value
STEP = 1.6  # offset of further panels when there is no free room


class Inspector(PanelContext):
    """The bar and the windows of the panels."""

    def __init__(self, dive: DiveContext) -> None:
        """Closed, in this dive."""
        super().__init__(dive)
        self.shown: set[str] = set()  # names of open panels
        self.areas: dict[str, tuple[float, float, float, float]] = {}  # x, y, width, height

    @property
    def open(self) -> bool:
        """Whether the pointer uses panels rather than steers."""
        return self.dive.gui.open

    def toggle(self) -> None:
        """Open or close it; open panels stay open."""
        gui = self.dive.gui
        gui.open = not gui.open
        if gui.open:
            self.dive.overlay.hide_help()  # it explains steering with the pointer
        else:
            gui.release_all()

    def reset(self) -> None:
        """Clear the choice, after the world was replaced."""
        self.chosen = None
        self.take_changes()

    def draw(self) -> None:
        """Draw the bar and the open panels in the current frame."""
        self._drop_dead()
        if not self.open:
            return
        self._mark_chosen()
        self._bar()
        for name, panel in PANELS.items():
            if name not in self.shown:
                self.areas.pop(name, None)
                continue
            if name not in self.areas:
                imgui.set_next_window_pos(self._room(), imgui.Cond_.first_use_ever.value)
            _keep_inside(name)
            drawn, stays = imgui.begin(name, True, PANEL)
            if drawn:
                with self._contained(name), recovering_errors():
                    panel(self)
            (x, y), (width, height) = imgui.get_window_pos(), imgui.get_window_size()
            self.areas[name] = x, y, width, height
            imgui.end()
            if not stays:
                self.shown.discard(name)
        if imgui.is_mouse_released(0) and not self.dive.gui.on_panel:
            dragged = imgui.get_mouse_drag_delta(0)
            if not (dragged.x or dragged.y or self.dragging):
                self._choose_at(*self.dive.gui.pointer)
        self.dragging &= imgui.is_mouse_down(0)

    def _bar(self) -> None:
        """Draw an entry for each panel and one to close; closer together if narrow."""
        words = [*PANELS, BACK]
        screen, style = imgui.get_io().display_size, imgui.get_style()
        wide, gaps = sum(imgui.calc_text_size(word).x for word in words), 3 * len(words)
        room = screen.x - 2.0 * style.window_padding.x
        gap = min(max((room - wide) / gaps, LEAST_GAP), style.item_spacing.x)
        shrunk = min(max((room - gaps * gap) / wide, LEAST_SHARE), 1.0)
        imgui.push_font(None, imgui.get_font_size() * shrunk)
        imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (gap, style.item_spacing.y))
        if imgui.begin_main_menu_bar():
            for name in PANELS:
                if imgui.menu_item(name, "", name in self.shown)[0]:
                    self.shown ^= {name}
            imgui.separator()
            if imgui.menu_item(BACK, "", False)[0]:
                self.toggle()
            imgui.end_main_menu_bar()
        imgui.pop_style_var()
        imgui.pop_font()

    @contextmanager
    def _contained(self, what: str) -> Iterator[None]:
        """Report an error within, close the panel `what` and continue the dive."""
        try:
            yield
        except CancelledByUserError:
            raise
        except UserError as fault:
            self.dive.note(str(fault))
            self.shown.discard(what)
        except Exception as fault:
            self.dive.note(f"{what} failed: {type(fault).__name__}: {fault}")
            self.shown.discard(what)
            warnings.warn(traceback.format_exc(), RuntimeWarning, stacklevel=3)

    def _room(self) -> tuple[float, float]:
        """A place for another panel that hides none of the open ones, if possible."""
        line, size = imgui.get_font_size(), imgui.get_io().display_size
        margin, taken = MARGIN * line, self.areas.values()
        columns = sorted([margin, *(x + width + margin for x, _, width, _ in taken)])
        rows = sorted([BAR * line, *(y + height + margin for _, y, _, height in taken)])
        for share in (1.0, 0.5, 0.25):
            wide, high = (share * length * line for length in LIKELY)
            for x, y in itertools.product(columns, rows):
                fits = x + wide <= size.x and y + high <= size.y
                if fits and not any(
                    x < left + width and left < x + wide and y < top + height and top < y + high
                    for left, top, width, height in taken
                ):
                    return x, y
        step = STEP * line * len(self.areas)
        return margin + step, BAR * line + step

    def end_frame(self) -> None:
        """Run the calls that panels deferred to the end of the frame."""
        if self.take_changes() and self.dive.timeline:
            self.dive.timeline.touch()
        for act in self.take_waiting():
            with self._contained("That"):
                act()

    def _choose_at(self, x: float, y: float) -> None:
        """Choose the fish at a place on the screen; None if there is none."""
        self.chosen = self.dive.picture.fish_at(x, y)

    def _drop_dead(self) -> None:
        world = self.dive.world
        if self.chosen is not None and not world.state.fishes.alive[self.chosen]:
            self.dive.overlay.note(f"{name_of(world, self.chosen)} has died")
            self.chosen = None

    def _mark_chosen(self) -> None:
        """Draw a thin ring around the chosen fish, under all panels."""
        front_view, ride = self.dive.picture.front_view, self.dive.picture.ride
        if self.chosen is None or front_view is None or (ride and ride.by.fish == self.chosen):
            return
        fishes = self.dive.world.state.fishes
        before = fishes.previous_position[self.chosen].astype(np.float64)
        place = before + self.dive.picture.alpha * (fishes.position[self.chosen] - before)
        up = front_view.view.view[1, :3].astype(np.float64)
        rim = place + RING * float(fishes.length[self.chosen]) * up
        size = imgui.get_io().display_size
        seen = front_view.places(np.stack([place, rim])) * (size.x, size.y)
        if not np.isfinite(seen).all():
            return
        middle = float(seen[0, 0]), float(seen[0, 1])
        line = imgui.get_font_size()
        radius = max(float(np.linalg.norm(seen[1] - seen[0])), LEAST_RING * line)
        canvas = imgui.get_background_draw_list()
        for wide, ink in ((0.16, colour(GLASS, 0.5)), (0.07, colour(MARK, 0.95))):
            canvas.add_circle(middle, radius, ink, 0, max(wide * line, 1.0))


def _keep_inside(name: str) -> None:
    """Keep a panel that is about to be drawn within the screen."""
    screen, window = imgui.get_io().display_size, imgui.internal.find_window_by_name(name)
    margin, bar = (heights * imgui.get_font_size() for heights in (MARGIN, BAR))
    most = screen.x - 2.0 * margin, screen.y - bar - margin
    imgui.set_next_window_size_constraints((0.0, 0.0), most)
    if window is not None:
        (x, y), (width, height) = window.pos, window.size
        inside = max(min(x, screen.x - width), 0.0), max(min(y, screen.y - height), bar)
        if inside != (x, y):
            imgui.set_next_window_pos(inside)
