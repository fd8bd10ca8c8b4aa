"""The menu, readable from three metres, used by mouse, arrows and Enter, or gamepad.

The sea goes on behind it, dimmed, while the submarine holds station.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec
from imgui_bundle import imgui

from subsea.base.errors import UserError
from subsea.base.language import LANGUAGES, language, marked, translated
from subsea.base.toml_files import load_toml
from subsea.dive.logbook import SEEN, SPECIES, hint_of, subjects, title_of, write_page
from subsea.dive.settings import COMFORTS, CONTROLS, ControlName, is_key, key_words
from subsea.media.screenshots import pictures_folder
from subsea.rendering.gl.textures import ImageTexture
from subsea.rendering.output.quality import CHOICES
from subsea.scenario.load import load_scenario, scenario_file, scenario_names
from subsea.scenario.schema import MAX_SEED
from subsea.scenario.storage import read_thumbnail
from subsea.ui.gui import DEEP, LIT, MARK, QUIET, colour
from subsea.ui.panels.fields import typed_whole
from subsea.world.repertoires import file_version

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

ROW = 1.75  # height of an entry, in heights of letters
ABOUT = 0.65  # height of the line below an entry


class Entry(NamedTuple):
    """A line of the menu, in the language of visitors."""

    text: str
    act: Callable[[], object]
    aside: str = ""  # text at its right end
    chosen: bool = False
    about: str = ""  # a line below it
    picture: Path | None = None  # at its left end: a file whose suffix .jpg replaces

    @property
    def high(self) -> float:
        """Its height, in heights of letters."""
        return ROW + ABOUT if self.about else ROW


SETTINGS = marked("Settings")
LOGBOOK, VISIT = marked("Logbook"), marked("This visit")
PARTS = (
    marked("Keys"), marked("Comfort"), marked("Reading"), marked("Sound"), marked("Language"),
)  # fmt: skip
ABOVE = dict.fromkeys(PARTS, SETTINGS) | dict.fromkeys((SPECIES, SEEN), LOGBOOK)
KIOSK_PARTS = "Comfort", "Reading", "Language"
TEXTS = {
    "normal": marked("Usual letters"), "large": marked("Large letters"),
    "largest": marked("Largest letters"),
}  # fmt: skip
UNREVIEWED = marked("A draft that no native speaker has reviewed.")
PRESETS = {
    "calm": (marked("Calm"), marked("Turns in steps, slow starts, a dark rim while moving.")),
    "usual": (marked("Usual"), marked("Smooth turns, a dark rim while moving fast.")),
    "free": (marked("Free"), marked("Smooth turns, no rim.")),
}
FLAT_PRESETS = {
    "calm": marked("Slow starts, a dark rim in turns."),
    "usual": marked("A line shows the horizon while it tilts."),
    "free": marked("No line, no rim."),
}
VOLUMES = (1.0, 0.8, 0.6, 0.4, 0.2)
GROUPS = {
    "sea": marked("Reef and waves"), "fishes": marked("Fishes"), "vessel": marked("Vessel"),
}  # fmt: skip
GROUP_LEVELS = (1.0, 0.5, 0.0)  # by turns
SCORE_LEVELS = (1.0, 0.7, 0.4, 0.0)  # the same of the score


APPEAR_S = 0.25
DIM = 0.5  # opacity of the shade over the sea
LARGE = 2.0  # size of its letters over that of other text, if there is room
LEAST = 1.0  # least size over that of other text; then pages scroll
PADDING = 0.25  # above and below its text
LEAST_ABOUT = 0.75  # of the size of a long line below an entry over that of others
ASIDE_SIZE = 0.8  # of the letters at the right end, over those of its text
ABOUT_SIZE = 0.7  # of the letters below an entry, over those of its text
WIDE = 17.0  # width of an entry, in the same
THUMBNAIL = 16 / 9 * 2.0, 2.0  # width and height of the picture at its left end
MORE = {"Keys": 9.0} | dict.fromkeys(("Scenario", SPECIES, SEEN, VISIT), THUMBNAIL[0])
"""By how much pages with long lines or pictures are wider, in heights of letters."""
RECENTRE = marked("Look straight ahead first.")
SEED = marked("The same seed, the same dive; another one, another dive.")

DISPLAYS = {
    "mono": marked("One picture"),
    "side-by-side": marked("3D, side by side"),
    "top-bottom": marked("3D, one above the other"),
    "anaglyph": marked("3D, red and cyan"),
    "anaglyph-comfort": marked("3D, red and cyan, calm"),
    "interlaced": marked("3D, rows by turns"),
    "checkerboard": marked("3D, checkerboard"),
    "panorama": marked("Panorama"),
    "dome": marked("Dome"),
    "equirectangular": marked("All round"),
    "stereo": marked("3D, shutter glasses"),
    "headset": marked("Headset"),
}
QUALITIES = {
    "auto": marked("Automatic"), "low": marked("Low"), "medium": marked("Medium"),
    "high": marked("High"), "ultra": marked("Ultra"),
}  # fmt: skip


class Menu:
    """Pages of entries. Entries act after the frame."""

    def __init__(self, dive: "Dive", kiosk: bool = False) -> None:
        """Start closed. In a `kiosk` it lacks entries that could block an exhibit."""
        self.dive, self.kiosk = dive, kiosk
        self.open = False
        self.seed = 0  # value of its field
        self.page = ""
        self._opacity = 0.0
        self._gui_was_open = False
        self._files: dict[Path, ScenarioSummary] = {}
        self._thumbnails: dict[Path, ImageTexture | None] = {}
        self._waiting: ControlName | None = None  # for its key
        self._focused = "", ""  # page and text of the focused entry
        self._pages: dict[str, Callable[[], Iterator[Entry]]] = {
            "": self._first,
            "Display": self._displays,
            "Quality": self._qualities,
            "Scenario": self._scenarios,
            LOGBOOK: self._logbook,
            SPECIES: partial(self._subjects, SPECIES),
            SEEN: partial(self._subjects, SEEN),
            VISIT: self._visit,
            SETTINGS: self._settings,
            "Keys": self._keys,
            "Comfort": self._comforts,
            "Reading": self._reading,
            "Sound": self._sounds,
            "Language": self._languages,
        }

    def show(self) -> None:
        """Open it; it takes the pointer, arrows and Enter."""
        self.open, self.page, self._opacity = True, "", 0.0
        self.seed = self.dive.world.state.seed
        self._files = scenario_summaries()
        self._gui_was_open = self.dive.gui.open
        self.dive.gui.open = True
        self.dive.gui.navigate(True)

    def hide(self) -> None:
        """Close it, and return to the helm or the inspector."""
        self.open = False
        self.dive.preferences.keep(self.dive.note)
        self.dive.gui.navigate(False)
        self.dive.gui.release_all()
        self.dive.gui.open = self._gui_was_open
        self.release()

    def release(self) -> None:
        """Free the pictures of scenarios."""
        for texture in filter(None, self._thumbnails.values()):
            texture.release()
        self._thumbnails.clear()

    def back(self) -> None:
        """Return to the page before, or close it."""
        if self.page:
            self._open_page(ABOVE.get(self.page, ""))
        else:
            self.hide()

    def entries(self) -> list[Entry]:
        """The entries of the current page."""
        return list(self._pages[self.page]())

    def draw(self, dt: float) -> None:
        """Draw it in the current frame, `dt` seconds after the last."""
        self._opacity = min(self._opacity + dt / APPEAR_S, 1.0)
        size = imgui.get_io().display_size
        self.dive.picture.darken(DEEP, DIM * self._opacity)
        entries = self.entries()
        seeded = self.page == "Scenario" and not self.kiosk
        rows = sum(entry.high for entry in entries) + ROW * (2.5 + seeded)
        letters = imgui.get_font_size()
        high, least = size.y / (rows + 1.0), LEAST * letters
        line = min(LARGE * letters, max(high, least), size.x / (self._width + 4.0))
        imgui.push_font(None, line)
        imgui.push_style_var(imgui.StyleVar_.alpha.value, self._opacity)
        imgui.push_style_var(imgui.StyleVar_.window_rounding.value, 0.5 * line)
        imgui.push_style_var(imgui.StyleVar_.window_padding.value, (0.9 * line, 0.8 * line))
        imgui.push_style_var(imgui.StyleVar_.frame_rounding.value, 0.3 * line)
        imgui.push_style_var(imgui.StyleVar_.item_spacing.value, (0.4 * line, 0.12 * line))
        imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (0.7 * line, PADDING * line))
        imgui.set_next_window_pos((size.x / 2, size.y / 2), 0, (0.5, 0.5))
        imgui.set_next_window_size_constraints((0.0, 0.0), (size.x, size.y))
        flags = imgui.WindowFlags_
        # One name for each page, so that each keeps its own scroll position.
        imgui.begin(
            f"menu {self.page}",
            None,
            flags.no_title_bar.value
            | flags.no_move.value
            | flags.always_auto_resize.value
            | (flags.no_scrollbar.value if line <= high else 0)  # the page has room
            | flags.no_saved_settings.value,
        )
        imgui.text_colored((*QUIET, 1.0), translated(self.page or self.dive.scenario.title))
        imgui.dummy((self._width * line, 0.15 * line))
        default = next((k for k, entry in enumerate(entries) if entry.chosen), 0)
        for number, entry in enumerate(entries):
            if seeded and number == len(entries) - 2:
                self._seed_field(line)
            self.draw_entry(entry, line)
            if number == default:
                imgui.set_item_default_focus()
        imgui.end()
        if imgui.is_key_pressed(imgui.Key.gamepad_face_right):
            self.dive.inspector.later(self.back)
        imgui.pop_style_var(6)
        imgui.pop_font()

    def draw_entry(self, entry: Entry, line: float) -> None:
        """Draw one line of the menu, its letters `line` high."""
        clear = (0.0, 0.0, 0.0, 0.0)
        # Only the focused entry is light, which the pointer takes along when it moves.
        light = (*LIT, 0.8) if self._focused == (self.page, entry.text) else clear
        imgui.push_style_color(imgui.Col_.button.value, light)
        imgui.push_style_color(imgui.Col_.button_hovered.value, light)
        room = ROW - 1.12 - 2.0 * PADDING  # for the text in the upper ROW of it
        align = 0.0, 0.5 * room / (room + entry.high - ROW)
        imgui.push_style_var(imgui.StyleVar_.button_text_align.value, align)
        left = 0.7 + (THUMBNAIL[0] if entry.picture else 0.0)
        imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (left * line, PADDING * line))
        size = self._width * line, (entry.high - 0.12) * line
        pressed = imgui.button(f"{entry.text}##{entry.aside}", size)
        imgui.pop_style_var(2)
        imgui.pop_style_color(2)
        self._focus_under_pointer()
        if imgui.is_item_focused():
            self._focused = self.page, entry.text
        if entry.picture and imgui.is_item_visible():
            self._draw_thumbnail(entry.picture, line)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        canvas, ground = imgui.get_window_draw_list(), low.y + (ROW - 0.12) * line
        if entry.chosen:  # a bar at its left end: the light entry is the focused one
            bar = (low.x, low.y + 0.2 * line), (low.x + 0.25 * line, high.y - 0.2 * line)
            canvas.add_rect_filled(*bar, colour(MARK), 0.12 * line)
        if entry.aside:
            imgui.push_font(None, ASIDE_SIZE * line)
            box = imgui.calc_text_size(entry.aside)
            place = high.x - box.x - 0.7 * line, (low.y + ground - box.y) / 2
            canvas.add_text(place, colour(QUIET), entry.aside)
            imgui.pop_font()
        if entry.about:
            imgui.push_font(None, ABOUT_SIZE * line)
            share = (size[0] - (left + 0.5) * line) / imgui.calc_text_size(entry.about).x
            imgui.pop_font()
            imgui.push_font(None, ABOUT_SIZE * line * min(max(share, LEAST_ABOUT), 1.0))
            canvas.push_clip_rect(low, high, True)  # it may be long
            place = low.x + left * line, ground - 0.22 * line
            canvas.add_text(place, colour(QUIET), entry.about)
            canvas.pop_clip_rect()
            imgui.pop_font()
        if pressed:
            self.dive.inspector.later(entry.act)

    def _focus_under_pointer(self) -> None:
        """Focus the last entry if the pointer has moved onto it, so that one entry is light."""
        moved = imgui.get_io().mouse_delta
        if imgui.is_item_hovered() and (moved.x or moved.y):
            window = imgui.internal.get_current_window()
            imgui.internal.set_focus_id(imgui.get_item_id(), window)

    def _draw_thumbnail(self, beside: Path, line: float) -> None:
        """Draw the picture beside a file at the left end of the last item; nothing without one."""
        if beside not in self._thumbnails:
            pixels = read_thumbnail(beside)
            self._thumbnails[beside] = None if pixels is None else self.dive.picture.upload(pixels)
        texture = self._thumbnails[beside]
        if texture is None:
            return
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        wide, tall = (side * line for side in THUMBNAIL)
        x = y = (high.y - low.y - tall) / 2
        corner = low.x + x, low.y + y
        imgui.get_window_draw_list().add_image_rounded(
            imgui.ImTextureRef(texture.glo), corner, (corner[0] + wide, corner[1] + tall),
            (0.0, 0.0), (1.0, 1.0), colour((1.0, 1.0, 1.0)), 0.2 * line,
        )  # fmt: skip

    @property
    def _width(self) -> float:
        """The width of the entries of this page, in heights of letters."""
        return WIDE + MORE.get(self.page, 0.0)

    def _seed_field(self, line: float) -> None:
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + 0.7 * line)
        imgui.align_text_to_frame_padding()
        imgui.text(translated("Seed"))
        imgui.same_line()
        imgui.set_next_item_width((self._width - 4.5) * line)
        self.seed = typed_whole("##seed", self.seed, 0, MAX_SEED)

    def _first(self) -> Iterator[Entry]:
        dive, picture = self.dive, self.dive.picture
        yield Entry(translated("Continue"), self.hide)
        if picture.head is not None:
            recentre = partial(dive.run_command, "recentre")
            yield Entry(translated("Recentre"), recentre, about=translated(RECENTRE))
        if not self.kiosk and picture.displays:
            yield self._leads_to(marked("Display"), translated(DISPLAYS[picture.display]))
        if not self.kiosk:
            yield self._leads_to(marked("Quality"), translated(QUALITIES[picture.quality]))
        if dive.logbook.wanted:
            yield self._leads_to(LOGBOOK, self._met)
        yield self._leads_to(SETTINGS)
        if not dive.shared:
            yield self._leads_to(marked("Scenario"), translated(dive.scenario.title))
        if not self.kiosk and not dive.window.fixed:
            yield Entry(translated("Full screen"), dive.window.toggle_fullscreen)
        yield Entry(translated("Help"), self._help)
        if not self.kiosk:
            first = any(dive.logbook.book.visit.values())
            leave = partial(self._open_page, VISIT) if first else dive.window.ask_to_close
            yield Entry(translated("Leave"), leave)

    @property
    def _met(self) -> str:
        """The number of subjects in the logbook, and of all."""
        book = self.dive.logbook.book
        return f"{len(book.entries)} / {sum(map(len, subjects(book.entries)))}"

    def _logbook(self) -> Iterator[Entry]:
        """Lead to the species and the behaviors, and save them as a page."""
        book = self.dive.logbook.book
        for title, names in zip((SPECIES, SEEN), subjects(book.entries), strict=True):
            seen = sum(name in book.entries for name in names)
            yield self._leads_to(title, f"{seen} / {len(names)}")
        yield from self._save_page()
        yield self._back()

    def _subjects(self, title: str) -> Iterator[Entry]:
        """List all species or behaviors, those not yet seen with a hint."""
        book = self.dive.logbook.book
        for name in subjects(book.entries)[title == SEEN]:
            entry = book.entries.get(name)
            about = hint_of(name) if entry is None else translated(entry.place)
            day = translated(marked("not yet")) if entry is None else f"{entry.day:%Y-%m-%d}"
            stay = partial(self._open_page, title)
            yield Entry(title_of(name), stay, day, False, about, book.picture(name))
        yield self._back()

    def _visit(self) -> Iterator[Entry]:
        """List what was seen for the first time in this visit, before leaving."""
        book, nothing = self.dive.logbook.book, partial(self._open_page, VISIT)
        for name, new in book.visit.items():
            if new:
                about = translated(book.entries[name].place)
                yield Entry(title_of(name), nothing, "", False, about, book.picture(name))
        yield from self._save_page()
        yield Entry(translated("Leave"), self.dive.window.ask_to_close, chosen=True)
        yield self._back()

    def _save_page(self) -> Iterator[Entry]:
        if not self.kiosk:
            about = translated(marked("A file to print or to send, in your pictures."))
            yield Entry(translated(marked("Save as a page")), self._write_page, about=about)

    def _write_page(self) -> None:
        dive, visit = self.dive, self.page == VISIT
        book, folder = dive.logbook.book, pictures_folder(dive.preferences.settings.pictures.folder)
        try:
            path = write_page(book, folder, book.visit if visit else None)
        except UserError as fault:
            dive.note(str(fault))
        else:
            dive.note(f"page: {path}")

    def _leads_to(self, page: str, now: str = "") -> Entry:
        return Entry(translated(page), partial(self._open_page, page), now)

    def _displays(self) -> Iterator[Entry]:
        picture = self.dive.picture
        for name in picture.displays:
            show = partial(picture.show_as, name)
            yield Entry(translated(DISPLAYS[name]), show, chosen=name == picture.display)
        yield self._back()

    def _qualities(self) -> Iterator[Entry]:
        picture = self.dive.picture
        for name in CHOICES:
            choose = partial(picture.choose, name)
            yield Entry(translated(QUALITIES[name]), choose, chosen=name == picture.quality)
        yield self._back()

    def _scenarios(self) -> Iterator[Entry]:
        dive = self.dive
        if dive.source.resolve() not in self._files:
            now = dive.scenario
            title, about, file = translated(now.title), translated(now.description), dive.source
            yield Entry(title, self._restart, file.name, True, about, file)
        for path, head in self._files.items():
            here = path == dive.source.resolve()
            enter, about = partial(self._enter, path), translated(head.description)
            yield Entry(translated(head.title), enter, path.stem, here, about, path)
        if not self.kiosk:
            seed = translated("with seed {seed}").format(seed=self.seed)
            yield Entry(translated("Restart"), self._restart, seed, about=translated(SEED))
        yield self._back()

    def _settings(self) -> Iterator[Entry]:
        sound = self.dive.sound
        loud = translated(marked("no device")) if sound.missing else sound.volume_text
        now = {"Sound": loud, "Language": LANGUAGES[language()]}
        for part in KIOSK_PARTS if self.kiosk else PARTS:
            yield Entry(translated(part), partial(self._open_page, part), now.get(part, ""))
        yield self._back()

    def _keys(self) -> Iterator[Entry]:
        bindings = self.dive.preferences.settings.bindings
        for name, control in CONTROLS.items():
            inputs = ", ".join(map(key_words, filter(is_key, bindings.inputs(name))))
            if name == self._waiting:
                inputs = translated("press a key, or Esc")
            yield Entry(translated(control.what), partial(self._ask_key, name), inputs)
        yield Entry(translated("All keys as they were"), self.dive.preferences.usual_keys)
        yield self._back()

    def _ask_key(self, control: ControlName) -> None:
        self._waiting = control
        self.dive.gui.take_key = partial(self._bind, control)

    def _bind(self, control: ControlName, key: str) -> None:
        self._waiting = None
        if key not in ("", "Esc"):
            self.dive.preferences.bind(control, key)

    def _comforts(self) -> Iterator[Entry]:
        now, worn = self.dive.preferences.settings.comfort, self.dive.picture.head is not None
        for name, comfort in COMFORTS.items():
            title, about = PRESETS[name]
            choose = partial(self.dive.preferences.set_comfort, comfort)
            about = translated(about if worn else FLAT_PRESETS[name])
            yield Entry(translated(title), choose, chosen=now == comfort, about=about)
        yield self._back()

    def _reading(self) -> Iterator[Entry]:
        """Lead to the size of text, contrast and touch."""
        settings, change = self.dive.preferences.settings, self.dive.preferences.set_display
        for text, title in TEXTS.items():
            chosen = settings.display.text == text
            yield Entry(translated(title), partial(change, text=text), chosen=chosen)
        contrast = settings.display.contrast
        about = translated(marked("Opaque grounds, and no thin lines."))
        flip = partial(change, contrast=not contrast)
        yield Entry(translated(marked("More contrast")), flip, _on(contrast), about=about)
        touch = settings.mouse.touch
        about = translated(marked("Drag to look, hold to go, tap a fish."))
        flip = partial(self.dive.preferences.set_touch, not touch)
        yield Entry(translated(marked("Touch screen")), flip, _on(touch), about=about)
        yield self._back()

    def _sounds(self) -> Iterator[Entry]:
        if self.dive.sound.missing:
            about = translated(marked("Connect loudspeakers or headphones; they are found soon."))
            stay = partial(self._open_page, "Sound")
            yield Entry(translated(marked("No sound device is there")), stay, about=about)
        own, change = self.dive.sound.settings, self._change_sound
        for volume in VOLUMES:
            now = not own.mute and own.volume == volume
            yield Entry(f"{volume:.0%}", partial(change, volume=volume, mute=False), chosen=now)
        yield Entry(translated("Off"), partial(change, mute=True), chosen=own.mute)
        for group, title in GROUPS.items():
            level = getattr(own, group)
            lower = next((step for step in GROUP_LEVELS if step < level), GROUP_LEVELS[0])
            yield Entry(translated(title), partial(change, **{group: lower}), f"{level:.0%}")
        level = own.score_level if own.score else 0.0
        lower = next((step for step in SCORE_LEVELS if step < level), SCORE_LEVELS[0])
        values = {"score": lower > 0.0, "score_level": lower or own.score_level}
        state = f"{level:.0%}" if own.score else translated("off")
        about = translated(marked("Slow tones that follow depth, hour and what happens."))
        yield Entry(
            translated(marked("Quiet score")), partial(change, **values), state, about=about
        )
        for name, on, title, about in (
            ("night", own.night, marked("Night"), marked("Loud sounds are softer.")),
            ("captions", own.captions, marked("Captions"), marked("Sounds are shown in words.")),
        ):
            flip = partial(change, **{name: not on})
            yield Entry(translated(title), flip, _on(on), about=translated(about))
        yield self._back()

    def _change_sound(self, **values: object) -> None:
        self.dive.sound.change(**values)
        self.dive.preferences.keep_sound(**values)

    def _languages(self) -> Iterator[Entry]:
        for code, name in LANGUAGES.items():
            choose = partial(self.dive.preferences.set_language, code)
            about = "" if code == "en" else translated(UNREVIEWED)
            yield Entry(name, choose, chosen=code == language(), about=about)
        yield self._back()

    def _back(self) -> Entry:
        return Entry(translated("Back"), self.back)

    def _open_page(self, page: str) -> None:
        self.page = page

    def _help(self) -> None:
        self.hide()
        self.dive.overlay.show_help()

    def _enter(self, path: Path) -> None:
        self.hide()
        try:
            scenario, source, _ = load_scenario(str(path))
        except UserError as fault:
            self.dive.overlay.note(str(fault))
        else:
            self.dive.open_world(scenario, source)

    def _restart(self) -> None:
        self.hide()
        self.dive.open_world(self.dive.scenario, self.dive.source, self.seed)


def _on(on: bool) -> str:
    return translated(marked("on") if on else marked("off"))


class ScenarioSummary(msgspec.Struct, frozen=True):
    """The title and the description of a scenario file."""

    title: str = ""
    description: str = ""


def scenario_summaries() -> dict[Path, ScenarioSummary]:
    """Titles and descriptions of all named scenarios by file; a faulty one has its name."""
    files = [scenario_file(name).resolve() for name in scenario_names()]
    return {path: _summary(path, file_version(path)) for path in files}


@lru_cache(maxsize=256)  # else each opening of the menu takes as long as two pictures
def _summary(path: Path, version: object) -> ScenarioSummary:
    with suppress(UserError):
        head = load_toml(path, ScenarioSummary)
        return head if head.title else ScenarioSummary(path.stem, head.description)
    return ScenarioSummary(path.stem)
