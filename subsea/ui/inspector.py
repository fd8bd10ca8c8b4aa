"""The inspector ("desk" in settings and manual): a bar that opens panels over the sea (Tu §9.3).

Visitors see three cards (`ui/cards.py`); the panels of researchers stand behind "more".

While it is open the pointer does not steer: it uses panels, and picks and drags things in the sea.
Keys still steer.
"""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import numpy as np
from imgui_bundle import imgui
from msgspec import Meta

from subsea.base.errors import UserError
from subsea.base.files import read_text, replacing
from subsea.base.language import marked, translated
from subsea.dive.minds_text import name_of
from subsea.dive.ride import ASPECT, EDGE, WIDE, nearest_to_middle
from subsea.dive.settings import settings_path
from subsea.ui.cards import CARDS, GAP, SEA, EyePictures, common, dock
from subsea.ui.gui import GLASS, MARK, colour, look
from subsea.ui.panels import PANELS
from subsea.ui.panels.fields import Area, PanelContext

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Places = dict[str, tuple[Share, Share]]  # upper left corners, in shares of the screen

SMALLER = 0.93  # factor on the letters of cards that cover one another, in each frame
TITLE = 1.6  # height of a panel's title, in heights of letters
TITLE_WEIGHT = 8.0  # of covering a title against covering the rest of a panel
LONGEST = 1 << 16  # bytes of a file of places
# Expected sizes with all their contents, in heights of letters.
SIZES = {
    "Initialisation": (36.6, 26.7),
    "Placement": (21.5, 26.0),
    "Physics": (25.3, 26.9),
    "Behavior": (25.4, 33.2),
    "Habits": (26.5, 14.8),
    "Control": (23.8, 22.2),
    "Fish view": (25.3, 20.3),
    "Time": (28.2, 7.2),
}
OTHER_SIZE = 26.0, 20.0


def best_place(size: tuple[float, float], room: Area, taken: Sequence[Area], line: float) -> Area:
    """The area in the `room` for a panel that covers least of the `taken` ones.

    It lies at the sides of the room if possible, so that the middle stays free, and titles of
    covered panels stay visible. `line` is the height of letters.
    """
    left, top, width, height = room
    wide, high = min(size[0], width), min(size[1], height)
    columns = {left, left + width - wide}
    rows = {top, top + height - high}
    gap = 0.5 * line
    for x, y, across, down in taken:
        columns |= {x + across + gap, x - gap - wide}
        rows |= {y + down + gap, y - gap - high, y + TITLE * line}
    best, least = (left, top, wide, high), (float("inf"), 0.0, 0.0, 0.0)
    for x, y in itertools.product(columns, rows):
        here = x, y, wide, high
        if not (left <= x <= left + width - wide and top <= y <= top + height - high):
            continue
        covered = sum(
            common(here, area) + TITLE_WEIGHT * common(here, (*area[:3], TITLE * line))
            for area in taken
        )
        cost = covered, min(x - left, left + width - wide - x), y, x
        if cost < least:
            best, least = here, cost
    return best


def arrange(
    names: Iterable[str], areas: Mapping[str, Area], places: Places, room: Area, line: float,
    kept: Sequence[Area] = (),
) -> dict[str, Area]:  # fmt: skip
    """Place panels beside others with `areas` and off the `kept` ones; return their areas.

    A panel that was dragged lies at its share of the screen, another where it covers least.
    """
    left, top, width, height = room
    names = sorted(names, key=lambda name: name not in places)
    others = [area for name, area in areas.items() if name not in names]
    placed: dict[str, Area] = {}
    for name in names:
        wide, high = (heights * line for heights in SIZES.get(name, OTHER_SIZE))
        if name in places:
            x, y = places[name]
            placed[name] = x * (width + 2.0 * left), y * (top + height + left), wide, high
        else:
            taken = [*others, *placed.values(), *kept]
            placed[name] = best_place((wide, high), room, taken, line)
    return placed


def covers(over: Iterable[Area], area: Area) -> bool:
    """True if any of the areas `over` another hides a part of it."""
    return any(common(above, area) > 0.0 for above in over)


def eye_areas(width: float, height: float) -> tuple[Area, Area]:
    """The places of the pictures of both eyes of a ridden fish, on a screen of this size."""
    edge, wide = EDGE * width, WIDE * width
    high = min(wide / ASPECT, height)
    return (edge, edge, wide, high), (width - edge - wide, edge, wide, high)


def places_path() -> Path:
    """The file of the places to which panels were dragged."""
    return settings_path().with_name("panels.json")


def read_places() -> Places:
    """Read the places; none if the file is missing or damaged."""
    with suppress(UserError, msgspec.MsgspecError):
        return msgspec.json.decode(read_text(places_path(), LONGEST), type=Places)
    return {}


def write_places(places: Places) -> None:
    """Write the places; without a writable folder they are forgotten."""
    with suppress(UserError), replacing(places_path()) as part:
        part.write_bytes(msgspec.json.encode(places))


RING = 0.62  # radius of the ring around the chosen fish, in its lengths
LEAST_RING = 0.6  # least radius, in heights of letters
MARGIN, BAR = 0.7, 1.9  # around panels, and height of the bar, in heights of letters
ABREAST = 84.0  # width of three panels, in heights of their letters
LEAST_LETTERS = 0.82  # share of the usual height of letters
MORE, LESS = marked("more"), marked("less")  # the bar's entry for the panels of researchers
BACK = marked("To the helm")  # the bar's last entry
LEAST_SHARE = 0.1  # smallest factor on the bar's letters, in a narrow window
LEAST_GAP = 2.0  # between the bar's entries, in pointer units
PANEL = imgui.WindowFlags_.always_auto_resize.value | imgui.WindowFlags_.horizontal_scrollbar.value
CARD = (
    imgui.WindowFlags_.always_auto_resize.value
    | imgui.WindowFlags_.no_move.value
    | imgui.WindowFlags_.no_collapse.value
    | imgui.WindowFlags_.no_scrollbar.value  # the wheel scrolls in a small window
)


class Inspector(PanelContext):
    """The bar and the windows of the panels."""

    def __init__(self, dive: "Dive") -> None:
        super().__init__(dive)
        self.shown: set[str] = set(CARDS)  # names of open cards and panels
        self.more = False  # True if the bar names the panels of researchers
        self.areas: dict[str, Area] = {}  # of drawn panels
        self.cards: dict[str, Area] = {}  # of drawn cards
        self._fit = 1.0  # size of the letters of cards over that of other text
        self._fit_about: object = None  # the screen, the text and the cards of that size
        self._about: object = None  # the last subject
        self._before: dict[tuple[float, float], dict[str, Area]] = {}  # areas on other screens
        self._screen = 0.0, 0.0  # size for which the panels are placed
        self.places = read_places()  # of panels that were dragged

    @property
    def open(self) -> bool:
        """True if the pointer uses panels rather than steers."""
        return self.dive.gui.open

    def covers(self, area: Area) -> bool:
        """True if a drawn card or panel hides a part of an area of the screen."""
        return self.open and covers([*self.cards.values(), *self.areas.values()], area)

    def toggle(self) -> None:
        """Open or close it; open panels stay open."""
        gui = self.dive.gui
        gui.open = not gui.open
        if gui.open:
            self.dive.overlay.hide_help()  # it explains steering with the pointer
            self._choose_for_cards()
        else:
            gui.release_all()
            write_places(self.places)

    def _choose_for_cards(self) -> None:
        """Choose the fish of the card or of the ride, or one ahead, if none is chosen."""
        dive, picture = self.dive, self.dive.picture
        if self.chosen is not None or not self.shown & set(CARDS) - {SEA}:
            return
        self.chosen = dive.card.fish if picture.ride is None else picture.ride.by.fish
        if self.chosen is None and (front_view := picture.front_view) is not None:
            self.chosen = nearest_to_middle(dive.world, front_view.view)

    def close(self) -> None:
        """Save where the panels are, and free the pictures of cards."""
        self.state(EyePictures).release()
        write_places(self.places)

    def reset(self) -> None:
        """Clear the choice, after the world was replaced."""
        self.chosen = None
        self._changed = False
        self.state(EyePictures).release()

    def draw(self) -> None:
        """Draw the bar and the open panels in the current frame."""
        self._drop_dead()
        if not self.open:
            return
        self.areas = {name: area for name, area in self.areas.items() if name in self.shown}
        moved = self._arrange()
        self._mark_chosen()
        self._bar()
        imgui.begin_disabled(self.dive.changing)
        self._draw_cards()
        imgui.push_font(None, _letters())
        for name in [name for name in PANELS if name in self.shown]:
            _keep_inside(name)
            if name not in self.areas:
                imgui.set_next_window_pos(self._placed([name])[name][:2])
                imgui.set_next_window_focus()
            elif name in moved:
                imgui.set_next_window_pos(moved[name][:2])
            drawn, stays = imgui.begin(name, True, PANEL)
            if drawn:
                PANELS[name](self)
            self._note_area(name)
            imgui.end()
            if not stays:
                self.shown.discard(name)
        imgui.pop_font()
        imgui.end_disabled()
        if imgui.is_mouse_released(0) and not self.dive.gui.on_panel:
            dragged = imgui.get_mouse_drag_delta(0)
            if not (dragged.x or dragged.y or self.dragging):
                self.chosen = self.dive.picture.fish_at(*self.dive.gui.pointer)
        self.dragging &= imgui.is_mouse_down(0)

    def _draw_cards(self) -> None:
        """Draw the open cards where they are docked, with their titles in the present language."""
        line, screen = imgui.get_font_size(), imgui.get_io().display_size
        margin, bar = MARGIN * line, BAR * line
        room = margin, bar, screen.x - 2.0 * margin, screen.y - bar - margin
        kept = [] if self.subject is None or self.subject[1] is None else [self.subject[1]]
        kept += eye_areas(screen.x, screen.y) if self.dive.picture.insets else ()
        kept += self.areas.values()
        names = [name for name in CARDS if name in self.shown]
        self.cards = {name: area for name, area in self.cards.items() if name in names}
        sizes = {name: area[2:] for name, area in self.cards.items()}
        if not imgui.is_mouse_down(0):  # a slider must not slip away
            docked = {name: area for name, area in self.cards.items() if area[0] < screen.x}
            self.cards |= dock(sizes, docked, room, kept, GAP * line)
            self._fit_cards(names)
        line *= self._fit
        imgui.push_font(None, line)
        imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.45 * line, 0.3 * line))
        for name in names:
            known = self.cards.get(name)
            # Its size is known when it was drawn once.
            imgui.set_next_window_pos(known[:2] if known else (screen.x, screen.y))
            imgui.set_next_window_size_constraints((0.0, 0.0), room[2:])
            drawn, stays = imgui.begin(f"{translated(name)}###{name}", True, CARD)
            if drawn:
                CARDS[name](self)
            size, corner = imgui.get_window_size(), known or (screen.x, screen.y)
            self.cards[name] = corner[0], corner[1], size.x, size.y
            imgui.end()
            if not stays:
                self.shown.discard(name)
        imgui.pop_style_var()
        imgui.pop_font()

    def _fit_cards(self, names: list[str]) -> None:
        """Shrink the letters while cards cover one another, to the usual size at least."""
        screen, text = imgui.get_io().display_size, look().text
        about = screen.x, screen.y, text, names
        if about != self._fit_about:
            self._fit_about, self._fit = about, 1.0
        areas = [area for area in self.cards.values() if area[0] < screen.x]
        if any(common(one, other) for one, other in itertools.combinations(areas, 2)):
            self._fit = max(SMALLER * self._fit, 1.0 / text)

    def _bar(self) -> None:
        """Draw an entry for each card and panel and one to close; closer together if narrow."""
        more = LESS if self.more else MORE
        names = [*CARDS, *(PANELS if self.more else ())]
        words = [*(translated(name) for name in names), translated(more), translated(BACK)]
        screen, style = imgui.get_io().display_size, imgui.get_style()
        wide, gaps = sum(imgui.calc_text_size(word).x for word in words), 3 * len(words)
        room = screen.x - 2.0 * style.window_padding.x
        gap = min(max((room - wide) / gaps, LEAST_GAP), style.item_spacing.x)
        shrunk = min(max((room - gaps * gap) / wide, LEAST_SHARE), 1.0)
        imgui.push_font(None, imgui.get_font_size() * shrunk)
        imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (gap, style.item_spacing.y))
        if imgui.begin_main_menu_bar():
            for name in names:
                if imgui.menu_item(translated(name), "", name in self.shown)[0]:
                    self._open_or_close(name)
            imgui.separator()
            if imgui.menu_item(translated(more), "", False)[0]:
                self._show_more()
            if imgui.menu_item(translated(BACK), "", False)[0]:
                self.toggle()
            imgui.end_main_menu_bar()
        imgui.pop_style_var()
        imgui.pop_font()

    def _show_more(self) -> None:
        """Name the panels of researchers on the bar, or close them all."""
        self.more = not self.more
        if not self.more:
            self.shown -= set(PANELS)

    def _open_or_close(self, name: str) -> None:
        """Raise a panel that others cover; else open or close it."""
        if name in self.areas and covers(
            (self.areas[panel] for panel in self._above(name)), self.areas[name]
        ):
            imgui.set_window_focus(name)
        else:
            self.shown ^= {name}

    def _above(self, name: str) -> list[str]:
        """The panels drawn after this one, last frame."""
        depth = {
            panel: imgui.internal.find_window_display_index(window)
            for panel in self.areas
            if (window := imgui.internal.find_window_by_name(panel))
        }
        return [panel for panel in depth if depth[panel] > depth[name]]

    def _note_area(self, name: str) -> None:
        """Note where the current window is; also for other dives if it is being dragged."""
        (x, y), (width, height) = imgui.get_window_pos(), imgui.get_window_size()
        before, screen = self.areas.get(name), imgui.get_io().display_size
        if before and before[:2] != (x, y) and imgui.is_mouse_dragging(0):
            self.places[name] = _share(x / screen.x), _share(y / screen.y)
        self.areas[name] = x, y, width, height

    def _arrange(self) -> dict[str, Area]:
        """Place panels again on a screen of another size, and those that cover a new subject."""
        (about, box), before = self.subject or (None, None), self._about
        size = imgui.get_io().display_size
        screen, self._about = (size.x, size.y), about
        names: list[str] = []
        back: dict[str, Area] = {}
        if screen != self._screen:
            self._before[self._screen] = dict(self.areas)
            known = self._before.get(screen, {})
            self._screen = screen
            names = [name for name in self.areas if name not in known]
            back = {name: area for name, area in known.items() if name in self.areas}
            self.areas |= back
        elif box is not None and about != before:
            names = [name for name in self.areas if common(self.areas[name], box)]
            names = [name for name in names if name not in self.places]
        imgui.push_font(None, _letters())
        moved = self._placed(names)
        imgui.pop_font()
        self.areas |= moved
        return back | moved

    def _placed(self, names: list[str]) -> dict[str, Area]:
        """Places for panels on this screen, off the fishes' eyes and what panels are about."""
        line, screen = imgui.get_font_size(), imgui.get_io().display_size
        margin, bar = MARGIN * line, BAR * line
        room = margin, bar, screen.x - 2.0 * margin, screen.y - bar - margin
        kept = [] if self.subject is None or self.subject[1] is None else [self.subject[1]]
        if "Fish view" in names or self.dive.picture.insets:
            kept += eye_areas(screen.x, screen.y)
        kept += self.cards.values()
        return arrange(names, self.areas, self.places, room, line, kept)

    def end_frame(self) -> None:
        """Run the calls that panels deferred to the end of the frame."""
        if self._changed and self.dive.timeline:
            self.dive.timeline.touch()
        if self.dive.changing:
            return  # until the new world is there
        waiting, self._changed, self._after_frame = self._after_frame, False, []
        for act in waiting:
            try:
                act()
            except UserError as fault:  # the GPU cannot, for example
                self.dive.note(str(fault))

    def _drop_dead(self) -> None:
        world = self.dive.world
        if self.chosen is not None and not world.state.fishes.alive[self.chosen]:
            self.dive.overlay.note(f"{name_of(world, self.chosen)} has died")
            self.chosen = None

    def _mark_chosen(self) -> None:
        """Draw a thin ring around the chosen fish, under all panels."""
        front_view, ride = self.dive.picture.front_view, self.dive.picture.ride
        self.subject = None
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
        box = middle[0] - radius, middle[1] - radius, 2.0 * radius, 2.0 * radius
        self.subject = self.chosen, box
        canvas = imgui.get_background_draw_list()
        for wide, ink in ((0.16, colour(GLASS, 0.5)), (0.07, colour(MARK, 0.95))):
            canvas.add_circle(middle, radius, ink, 0, max(wide * line, 1.0))


def _letters() -> float:
    """The height of letters on panels: less on a narrow screen, so that three stand abreast."""
    usual = imgui.get_font_size()
    return min(max(imgui.get_io().display_size.x / ABREAST, LEAST_LETTERS * usual), usual)


def _share(value: float) -> float:
    return min(max(value, 0.0), 1.0)


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
