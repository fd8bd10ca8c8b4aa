"""What stands over the water: the help, the instruments, and a word while loading."""

import math
import re
from typing import Any

from imgui_bundle import imgui

from subsea.app.gui import GLASS, INK, QUIET, colour
from subsea.state import Submarine

Row = tuple[str, str, str]  # what, by the mouse, by keys

# What hands can do, in the words of a sign beside the exhibit.
RIDING: tuple[Row, ...] = (
    ("Ride the fish ahead, or the next", "", "R"),
    ("Turn its eyes, show maps", "", "arrows, I"),
)
FULL_SCREEN: Row = ("Full screen", "", "F")
HELP: tuple[Row, ...] = (
    ("Look and turn", "move the mouse", "arrows, A D"),
    ("Ahead", "left button", "W"),
    ("Astern", "right button", "S"),
    ("Set a speed", "wheel", ""),
    ("Rise and dive", "both buttons, move", "E Q"),
    ("Full stop", "press the wheel", "space"),
    *RIDING,
    ("This help", "", "H"),
    ("Panels", "", "Tab"),
    ("Quality of the picture", "", "P"),
    ("Test pattern", "", "T"),
    FULL_SCREEN,
    ("Menu", "", "Esc"),
)
BESIDE = 50.0  # with so much room the help stands beside the instruments, else above them
FADE_S = 1.5
NOTE_S = 4.0
MOVED_CM = 60.0  # how far the visitor must have gone by herself before the help fades
DEEP = (0.02, 0.13, 0.20)


class Overlay:
    """Text over the picture, drawn in a frame of the gui.

    The help shows at the start, fades when the visitor gets under way, and comes and goes with
    `toggle_help`.
    """

    def __init__(self) -> None:
        self.rows = HELP  # of the help
        self._help = 1.0  # opacity
        self._pinned = False
        self._shown = True
        self._gone_cm = 0.0
        self._note = ""
        self._note_s = 0.0

    def note(self, text: str) -> None:
        """Show a few words for a while, beside the instruments."""
        self._note, self._note_s = text, NOTE_S

    def show_help(self) -> None:
        """Show the help until told otherwise."""
        self._shown = self._pinned = True
        self._gone_cm = math.inf

    def toggle_help(self) -> None:
        """Show the help until told otherwise, or hide it."""
        self._shown = not self._shown
        self._pinned = self._shown
        self._gone_cm = math.inf

    @property
    def help_opacity(self) -> float:
        """How visible the help is, from 0 to 1."""
        return self._help

    def message(self, text: str) -> None:
        """Fill the window with one line of text on deep water."""
        size = imgui.get_io().display_size
        box = imgui.calc_text_size(text)
        canvas = imgui.get_background_draw_list()
        canvas.add_rect_filled((0.0, 0.0), size, colour(DEEP))
        canvas.add_text(((size.x - box.x) / 2, (size.y - box.y) / 2), colour(INK), text)

    def draw(
        self,
        submarine: Submarine,
        throttle: float,
        stopping: bool,
        dt: float,
        quality: str = "",
        riding: str = "",
    ) -> None:
        """Draw help and instruments over the present picture; `dt` is the time since the last.

        While somebody is `riding` that is what is told, instead of the submarine's instruments.

        What `quality` says is shown beside the help.
        """
        if riding:
            self._gone_cm = math.inf  # under way, if not by submarine
        self._fade(submarine, dt)
        size = imgui.get_io().display_size
        note = self._note if self._note_s > 0.0 else quality if self._help > 0.0 else ""
        line = riding or readout(submarine, throttle, stopping)
        high = self._line(unbroken("   ".join(filter(None, (line, note)))), size)
        if self._help > 0.0:
            beside = size.x > BESIDE * imgui.get_font_size() and not riding
            self._help_panel(size, 0.0 if beside else high)

    def caption(self, text: str) -> None:
        """Draw one line at the foot of the present picture."""
        if text:
            self._line(text, imgui.get_io().display_size)

    def _fade(self, submarine: Submarine, dt: float) -> None:
        self._note_s -= dt
        self._gone_cm += dt * float(sum(v * v for v in submarine.velocity)) ** 0.5
        if self._gone_cm > MOVED_CM and not self._pinned:
            self._shown = False
        step = dt / FADE_S if self._shown else -dt / FADE_S
        self._help = min(max(self._help + step, 0.0), 1.0)

    def _line(self, text: str, size: Any) -> float:
        """Text at the foot, in as many lines as it needs; where it ends, from below."""
        line, font = imgui.get_font_size(), imgui.get_font()
        room = size.x - 2.4 * line
        high = imgui.calc_text_size(text, wrap_width=room).y
        x, y = 1.2 * line, size.y - 1.2 * line - high
        canvas = imgui.get_background_draw_list()
        for off, ink in ((1.0, colour((0.0, 0.05, 0.08), 0.6)), (0.0, colour(INK, 0.85))):
            canvas.add_text(font, line, (x + off, y + off), ink, text, wrap_width=room)
        return 1.2 * line + high

    def _help_panel(self, size: Any, above: float) -> None:
        line = imgui.get_font_size()
        flags = imgui.WindowFlags_
        corner = size.x - 1.2 * line, size.y - (above + (1.0 if above else 1.2) * line)
        imgui.set_next_window_pos(corner, 0, (1.0, 1.0))
        imgui.set_next_window_bg_alpha(0.55)
        imgui.push_style_var(imgui.StyleVar_.alpha.value, self._help)
        imgui.push_style_var(imgui.StyleVar_.window_rounding.value, 0.6 * line)
        imgui.push_style_var(imgui.StyleVar_.window_border_size.value, 0.0)
        imgui.push_style_var(imgui.StyleVar_.window_padding.value, (1.2 * line, 0.8 * line))
        imgui.push_style_var(imgui.StyleVar_.cell_padding.value, (0.7 * line, 0.12 * line))
        imgui.push_style_color(imgui.Col_.window_bg.value, (*GLASS, 1.0))
        imgui.begin(
            "help",
            None,
            flags.no_decoration.value
            | flags.no_inputs.value
            | flags.always_auto_resize.value
            | flags.no_focus_on_appearing.value
            | flags.no_saved_settings.value,
        )
        columns = imgui.TableFlags_.sizing_fixed_fit.value | imgui.TableFlags_.pad_outer_x.value
        if imgui.begin_table("controls", 3, columns):
            for what, mouse, keys in self.rows:
                for text, tint in ((what, INK), (mouse, QUIET), (keys, QUIET)):
                    imgui.table_next_column()
                    imgui.text_colored((*tint, 1.0), text)
            imgui.end_table()
        imgui.end()
        imgui.pop_style_color()
        imgui.pop_style_var(5)


def help_rows(rides: bool, full_screen: bool) -> tuple[Row, ...]:
    """What the help has to tell where fishes can be ridden, and windows can fill the screen."""
    missing = (() if rides else RIDING) + (() if full_screen else (FULL_SCREEN,))
    return tuple(row for row in HELP if row not in missing)


def unbroken(text: str) -> str:
    """The same text, whose lines end between its parts only: three blanks are between them."""
    return re.sub(r"(?<! ) (?! )", "\u00a0", text)


def readout(submarine: Submarine, throttle: float, stopping: bool) -> str:
    """The instruments in one line: depth in m, compass heading (0° is +x), speed in m/s."""
    depth = -submarine.position[2] / 100.0
    heading = round(-math.degrees(submarine.angles[0])) % 360
    speed = float(sum(v * v for v in submarine.velocity)) ** 0.5 / 100.0
    parts = [f"depth {depth:.1f} m", f"heading {heading:03d}°", f"{speed:.1f} m/s"]
    if stopping:
        parts.append("full stop")
    elif throttle:
        parts.append(f"set {throttle:+.0%}")
    return "   ".join(parts)
