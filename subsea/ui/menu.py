"""The menu, readable from three metres, used by mouse, arrows and Enter, or gamepad.

The sea goes on behind it, dimmed, while the submarine holds station.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

import msgspec
from imgui_bundle import imgui

from subsea.core.errors import UserError
from subsea.core.toml_files import load_toml
from subsea.dive.settings import COMFORTS, ComfortSettings
from subsea.rendering.gl.image_texture import ImageTexture
from subsea.rendering.output.quality import CHOICES
from subsea.scenario.load import load_scenario, scenario_file, scenario_names
from subsea.scenario.schema import MAX_SEED
from subsea.scenario.thumbnails import read_thumbnail
from subsea.ui.context import DiveContext
from subsea.ui.gui import DEEP, LIT, QUIET, colour
from subsea.ui.panels.fields import typed_whole

APPEAR_S = 0.25
DIM = 0.5  # opacity of the shade over the sea
LARGE = 2.0  # size of its letters over that of other text, if there is room
LEAST = 0.74  # least size; then pages scroll
ROW = 1.75  # height of an entry, in heights of letters
PADDING = 0.25  # above and below its text
ABOUT, ABOUT_SIZE = 0.65, 0.7  # height of the line below an entry, and of its letters
WIDE = 17.0  # width of an entry, in the same
THUMBNAIL = 16 / 9 * 2.0, 2.0  # width and height of the picture at its left end
COMFORTABLE = {
    "calm": "Turns in steps, slow starts, a dark rim while moving.",
    "usual": "Smooth turns, a dark rim while moving fast.",
    "free": "Smooth turns, no rim.",
}
RECENTRE = "Look straight ahead first."
SEED = "The same seed, the same dive; another one, another dive."

DISPLAYS = {
    "mono": "One picture",
    "side-by-side": "3D, side by side",
    "top-bottom": "3D, one above the other",
    "anaglyph": "3D, red and cyan",
    "anaglyph-comfort": "3D, red and cyan, calm",
    "interlaced": "3D, rows by turns",
    "checkerboard": "3D, checkerboard",
    "panorama": "Panorama",
    "dome": "Dome",
    "equirectangular": "All round",
    "stereo": "3D, shutter glasses",
    "headset": "Headset",
}
VOLUMES = (1.0, 0.8, 0.6, 0.4, 0.2)
GROUPS = {"sea": "Reef and waves", "fishes": "Fishes", "vessel": "Vessel"}
GROUP_LEVELS = (1.0, 0.5, 0.0)  # by turns
QUALITIES = {
    "auto": "Automatic", "low": "Low", "medium": "Medium", "high": "High", "ultra": "Ultra",
}  # fmt: skip


class Entry(NamedTuple):
    """A line of the menu."""

    text: str
    act: Callable[[], object]
    aside: str = ""  # text at its right end
    chosen: bool = False
    about: str = ""  # a line below it
    scenario: Path | None = None  # the file whose picture is at its left end

    @property
    def high(self) -> float:
        """Its height, in heights of letters."""
        return ROW + ABOUT if self.about else ROW


class Menu:
    """Pages of entries. Entries act after the frame."""

    def __init__(self, dive: DiveContext, kiosk: bool = False) -> None:
        """Start closed. In a `kiosk` it lacks entries that could block an exhibit."""
        self.dive, self.kiosk = dive, kiosk
        self.open = False
        self.seed = 0  # value of its field
        self.page = ""
        self._opacity = 0.0
        self._gui_was_open = False
        self._files: dict[Path, ScenarioSummary] = {}
        self._thumbnails: dict[Path, ImageTexture | None] = {}
        self._pages: dict[str, Callable[[], Iterator[Entry]]] = {
            "": self._first,
            "Display": self._displays,
            "Quality": self._qualities,
            "Sound": self._sounds,
            "Comfort": self._comforts,
            "Scenario": self._scenarios,
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
        """Return to the first page, or close it."""
        if self.page:
            self._open_page("")
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
        imgui.text_colored((*QUIET, 1.0), self.page or self.dive.scenario.title)
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
        imgui.push_style_color(imgui.Col_.button.value, (*LIT, 0.35) if entry.chosen else clear)
        room = ROW - 1.12 - 2.0 * PADDING  # for the text in the upper ROW of it
        align = 0.0, 0.5 * room / (room + entry.high - ROW)
        imgui.push_style_var(imgui.StyleVar_.button_text_align.value, align)
        left = 0.7 + (THUMBNAIL[0] if entry.scenario else 0.0)
        imgui.push_style_var(imgui.StyleVar_.frame_padding.value, (left * line, PADDING * line))
        size = self._width * line, (entry.high - 0.12) * line
        pressed = imgui.button(f"{entry.text}##{entry.aside}", size)
        imgui.pop_style_var(2)
        imgui.pop_style_color()
        if entry.scenario and imgui.is_item_visible():
            self._draw_thumbnail(entry.scenario, line)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        canvas, ground = imgui.get_window_draw_list(), low.y + (ROW - 0.12) * line
        if entry.aside:
            imgui.push_font(None, 0.7 * line)
            box = imgui.calc_text_size(entry.aside)
            place = high.x - box.x - 0.7 * line, (low.y + ground - box.y) / 2
            canvas.add_text(place, colour(QUIET), entry.aside)
            imgui.pop_font()
        if entry.about:
            imgui.push_font(None, ABOUT_SIZE * line)
            canvas.push_clip_rect(low, high, True)  # it may be long
            place = low.x + left * line, ground - 0.22 * line
            canvas.add_text(place, colour(QUIET), entry.about)
            canvas.pop_clip_rect()
            imgui.pop_font()
        if pressed:
            self.dive.inspector.later(entry.act)

    def _draw_thumbnail(self, scenario: Path, line: float) -> None:
        """Draw the picture of a scenario at the left end of the last item; nothing without one."""
        if scenario not in self._thumbnails:
            pixels = read_thumbnail(scenario)
            self._thumbnails[scenario] = (
                None if pixels is None else self.dive.picture.upload(pixels)
            )
        texture = self._thumbnails[scenario]
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
        return WIDE + (THUMBNAIL[0] if self.page == "Scenario" else 0.0)

    def _seed_field(self, line: float) -> None:
        imgui.set_cursor_pos_x(imgui.get_cursor_pos_x() + 0.7 * line)
        imgui.align_text_to_frame_padding()
        imgui.text("Seed")
        imgui.same_line()
        imgui.set_next_item_width((self._width - 4.5) * line)
        self.seed = typed_whole("##seed", self.seed, 0, MAX_SEED)

    def _first(self) -> Iterator[Entry]:
        dive = self.dive
        yield Entry("Continue", self.hide)
        if dive.picture.head is not None:
            yield Entry("Recentre", lambda: dive.run_command("recentre"), about=RECENTRE)
            yield Entry("Comfort", partial(self._open_page, "Comfort"))
        if not self.kiosk and dive.picture.displays:
            yield Entry(
                "Display", lambda: self._open_page("Display"), DISPLAYS[dive.picture.display]
            )
        if not self.kiosk:
            now = QUALITIES[dive.picture.quality]
            yield Entry("Quality", partial(self._open_page, "Quality"), now)
        if not self.kiosk:
            now = dive.sound.text.removeprefix("sound ")
            yield Entry("Sound", partial(self._open_page, "Sound"), now)
        if not dive.shared:
            yield Entry("Scenario", partial(self._open_page, "Scenario"), dive.scenario.title)
        if not self.kiosk and not dive.window.fixed:
            yield Entry("Full screen", dive.window.toggle_fullscreen)
        yield Entry("Help", self._help)
        if not self.kiosk:
            yield Entry("Leave", dive.window.ask_to_close)

    def _displays(self) -> Iterator[Entry]:
        picture = self.dive.picture
        for name in picture.displays:
            show = partial(picture.show_as, name)
            yield Entry(DISPLAYS[name], show, chosen=name == picture.display)
        yield self._back()

    def _qualities(self) -> Iterator[Entry]:
        picture = self.dive.picture
        for name in CHOICES:
            choose = partial(picture.choose, name)
            yield Entry(QUALITIES[name], choose, chosen=name == picture.quality)
        yield self._back()

    def _sounds(self) -> Iterator[Entry]:
        sound = self.dive.sound
        own = sound.settings
        for volume in VOLUMES:
            choose = partial(sound.change, volume=volume, mute=False)
            now = not own.mute and own.volume == volume
            yield Entry(f"{volume:.0%}", choose, chosen=now)
        yield Entry("Off", partial(sound.change, mute=True), chosen=own.mute)
        for group, title in GROUPS.items():
            level = getattr(own, group)
            lower = next((step for step in GROUP_LEVELS if step < level), GROUP_LEVELS[0])
            yield Entry(title, partial(sound.change, **{group: lower}), f"{level:.0%}")
        for name, on, about in (
            ("night", own.night, "Loud sounds are softer."),
            ("captions", own.captions, "Sounds are shown in words."),
        ):
            flip = partial(sound.change, **{name: not on})
            yield Entry(name.capitalize(), flip, "on" if on else "off", about=about)
        yield self._back()

    def _comforts(self) -> Iterator[Entry]:
        now = self.dive.pilot.settings.comfort
        for name, comfort in COMFORTS.items():
            choose = partial(self._choose_comfort, comfort)
            yield Entry(name.capitalize(), choose, chosen=now == comfort, about=COMFORTABLE[name])
        yield self._back()

    def _choose_comfort(self, comfort: ComfortSettings) -> None:
        pilot = self.dive.pilot
        pilot.settings = msgspec.structs.replace(pilot.settings, comfort=comfort)

    def _scenarios(self) -> Iterator[Entry]:
        dive = self.dive
        if dive.source.resolve() not in self._files:
            now = dive.scenario
            about, file = now.description, dive.source
            yield Entry(now.title, self._restart, file.name, True, about, file)
        for path, (title, description) in self._files.items():
            here = path == dive.source.resolve()
            yield Entry(title, partial(self._enter, path), path.stem, here, description, path)
        if not self.kiosk:
            yield Entry("Restart", self._restart, f"with seed {self.seed}", about=SEED)
        yield self._back()

    def _back(self) -> Entry:
        return Entry("Back", partial(self._open_page, ""))

    def _open_page(self, page: str) -> None:
        self.page = page

    def _help(self) -> None:
        self.hide()
        self.dive.overlay.show_help()

    def _enter(self, path: Path) -> None:
        self.hide()
        try:
            scenario, source = load_scenario(str(path))
        except UserError as fault:
            self.dive.overlay.note(str(fault))
        else:
            self.dive.open_world(scenario, source)

    def _restart(self) -> None:
        self.hide()
        self.dive.open_world(self.dive.scenario, self.dive.source, self.seed)


class ScenarioSummary(NamedTuple):
    """The title and the description of a scenario file."""

    title: str
    description: str


class _Head(msgspec.Struct, frozen=True):
    title: str = ""
    description: str = ""


def scenario_summaries() -> dict[Path, ScenarioSummary]:
    """Files of all named scenarios, with their titles and descriptions.

    An unreadable file is listed by its name; choosing it reports the error.
    """
    return {(path := scenario_file(name).resolve()): _summary(path) for name in scenario_names()}


def _summary(path: Path) -> ScenarioSummary:
    with suppress(UserError):
        head = load_toml(path, _Head)
        return ScenarioSummary(head.title or path.stem, head.description)
    return ScenarioSummary(path.stem, "")
