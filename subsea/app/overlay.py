"""What stands over the water: the help, the instruments, and a word while loading."""

import ctypes
import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import imgui_bundle
from imgui_bundle import imgui

from subsea.state import Submarine
from subsea.view.rig import Rig, front, seen_part

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
    ("Quality of the picture", "", "P"),
    ("Test pattern", "", "T"),
    FULL_SCREEN,
    ("Leave", "", "Esc"),
)
TEXT_PT = 18.0
ROOM = 34.0, 20.0  # what the help needs of the screen at least, in heights of its letters
BESIDE = 50.0  # with so much room it stands beside the instruments, else above them
SQUEEZED = 1.2  # how much larger, and bold, text is whose strokes would be lost
FADE_S = 1.5
NOTE_S = 4.0
MOVED_CM = 60.0  # how far the visitor must have gone by herself before the help fades
INK = (0.93, 0.97, 1.0)
QUIET = (0.62, 0.76, 0.84)
DEEP = (0.02, 0.13, 0.20)


def one_page(number: int) -> None:
    """There is only one buffer to draw into."""


class Pane(NamedTuple):
    """A part of the window that shows everything, in shares of it from the upper left corner.

    Where two eyes share a screen each has a pane, into which all is squeezed that would fill the
    screen: `screen` is its width and height, in the same shares.
    """

    x: float = 0.0
    y: float = 0.0
    width: float = 1.0
    height: float = 1.0
    screen: tuple[float, float] = (1.0, 1.0)
    number: int = 0
    page: Callable[[int], None] = one_page

    @property
    def squeezed(self) -> bool:
        """Whether thin strokes would be lost."""
        return self.screen[0] > 1.4 * self.width or self.screen[1] > 1.4 * self.height


WHOLE = Pane()


def panes(rig: Rig, page: Callable[[int], None]) -> tuple[Pane, ...]:
    """Where text goes: in the pilot's window, on the screen ahead, in the part of each eye."""
    ahead = front(rig)
    width, height = rig.outputs[ahead.output]
    parts = [
        patch
        for patch in rig.patches
        if (patch.output, patch.channel) == (ahead.output, ahead.channel)
    ]
    low, high = (
        [choose(p.place[axis] + far * p.place[axis + 2] for p in parts) for axis in (0, 1)]
        for choose, far in ((min, 0), (max, 1))
    )
    # As much of it as is seen of each part.
    seen, place = seen_part(ahead), ahead.place
    screen = (
        (high[0] - low[0]) / width * seen[2] / place[2],
        (high[1] - low[1]) / height * seen[3] / place[3],
    )
    found = []
    for patch in parts:
        x, y, across, up = seen_part(patch)
        top = height - y - up
        share = x / width, top / height, across / width, up / height
        found.append(Pane(*share, screen, patch.page, page))
    return tuple(found)


class Overlay:
    """Text over the picture, drawn with Dear ImGui's own OpenGL 3 backend.

    The help shows at the start, fades when the visitor gets under way, and comes and goes with
    `toggle_help`.
    """

    def __init__(self, window_handle: Any) -> None:
        """Attach to a window whose OpenGL context is current."""
        self._context = imgui.create_context()
        io = imgui.get_io()
        io.set_ini_filename(None)
        io.config_flags |= imgui.ConfigFlags_.no_mouse_cursor_change.value
        fonts = Path(imgui_bundle.__file__).parent / "assets" / "fonts" / "Roboto"
        self._plain, self._bold = (
            io.fonts.add_font_from_file_ttf(str(fonts / f"Roboto-{weight}.ttf"), TEXT_PT)
            for weight in ("Regular", "Bold")
        )
        # The overlay takes no input, so the pilot keeps all callbacks of the window.
        address = ctypes.cast(window_handle, ctypes.c_void_p).value or 0
        imgui.backends.glfw_init_for_opengl(address, False)
        imgui.backends.opengl3_init("#version 330")
        self.rows = HELP  # of the help
        self._help = 1.0  # opacity
        self._pinned = False
        self._shown = True
        self._gone_cm = 0.0
        self._note_s = 0.0

    def show_quality(self) -> None:
        """Show for a while in what quality the picture is drawn."""
        self._note_s = NOTE_S

    def toggle_help(self) -> None:
        """Show the help until told otherwise, or hide it."""
        self._shown = not self._shown
        self._pinned = self._shown
        self._gone_cm = math.inf

    @property
    def help_opacity(self) -> float:
        """How visible the help is, from 0 to 1."""
        return self._help

    def message(self, text: str, scale: float) -> None:
        """Fill the window with one line of text on deep water; the caller presents it."""
        self._begin(scale)
        size = imgui.get_io().display_size
        box = imgui.calc_text_size(text)
        canvas = imgui.get_background_draw_list()
        canvas.add_rect_filled((0.0, 0.0), size, _colour(DEEP))
        canvas.add_text(((size.x - box.x) / 2, (size.y - box.y) / 2), _colour(INK), text)
        self._end()

    def draw(
        self,
        submarine: Submarine,
        throttle: float,
        stopping: bool,
        dt: float,
        scale: float,
        panes: Sequence[Pane] = (WHOLE,),
        quality: str = "",
        riding: str = "",
    ) -> None:
        """Draw help and instruments over the present picture; `dt` is the time since the last.

        While somebody is `riding` that is what is told, instead of the submarine's instruments.

        What `quality` says is shown beside the help, and for a while after it has changed by
        `show_quality`.

        They are drawn in each of the `panes`, in the same place for both eyes: at the screen.
        """
        if riding:
            self._gone_cm = math.inf  # under way, if not by submarine
        self._fade(submarine, dt)
        self._begin(scale, panes[0])
        size = imgui.get_io().display_size
        note = quality if self._help > 0.0 or self._note_s > 0.0 else ""
        line = riding or readout(submarine, throttle, stopping)
        high = self._line(unbroken("   ".join(filter(None, (line, note)))), size)
        if self._help > 0.0:
            beside = size.x > BESIDE * imgui.get_font_size() and not riding
            self._help_panel(size, 0.0 if beside else high)
        self._end(panes)

    def caption(self, text: str, scale: float, panes: Sequence[Pane] = (WHOLE,)) -> None:
        """Draw one line at the foot of the present picture, in each of the `panes`."""
        self._begin(scale, panes[0])
        if text:
            self._line(text, imgui.get_io().display_size)
        self._end(panes)

    def close(self) -> None:
        """Release what it holds; the window's context must still be current."""
        imgui.backends.opengl3_shutdown()
        imgui.backends.glfw_shutdown()
        imgui.destroy_context(self._context)

    def _fade(self, submarine: Submarine, dt: float) -> None:
        self._note_s -= dt
        self._gone_cm += dt * float(sum(v * v for v in submarine.velocity)) ** 0.5
        if self._gone_cm > MOVED_CM and not self._pinned:
            self._shown = False
        step = dt / FADE_S if self._shown else -dt / FADE_S
        self._help = min(max(self._help + step, 0.0), 1.0)

    def _begin(self, scale: float, pane: Pane = WHOLE) -> None:
        imgui.backends.opengl3_new_frame()
        imgui.backends.glfw_new_frame()
        io = imgui.get_io()
        self._window = io.display_size.x, io.display_size.y
        width, height = (
            share * size for share, size in zip(pane.screen, self._window, strict=True)
        )
        io.display_size = imgui.ImVec2(width, height)
        imgui.new_frame()
        tall = min(
            TEXT_PT * scale * (SQUEEZED if pane.squeezed else 1.0),
            width / ROOM[0],
            height / ROOM[1],
        )
        imgui.push_font(self._bold if pane.squeezed else self._plain, tall)

    def _end(self, panes: Sequence[Pane] = (WHOLE,)) -> None:
        imgui.pop_font()
        imgui.render()
        data = imgui.get_draw_data()
        scale = data.framebuffer_scale
        across, down = scale.x, scale.y
        for pane in panes:
            pane.page(pane.number)
            # What would fill the screen is drawn as the pane's part of a larger window.
            wider, higher = pane.screen[0] / pane.width, pane.screen[1] / pane.height
            width, height = wider * self._window[0], higher * self._window[1]
            data.display_pos = imgui.ImVec2(-pane.x * width, -pane.y * height)
            data.display_size = imgui.ImVec2(width, height)
            data.framebuffer_scale = imgui.ImVec2(across / wider, down / higher)
            imgui.backends.opengl3_render_draw_data(data)

    def _line(self, text: str, size: Any) -> float:
        """Text at the foot, in as many lines as it needs; where it ends, from below."""
        line, font = imgui.get_font_size(), imgui.get_font()
        room = size.x - 2.4 * line
        high = imgui.calc_text_size(text, wrap_width=room).y
        x, y = 1.2 * line, size.y - 1.2 * line - high
        canvas = imgui.get_background_draw_list()
        for off, ink in ((1.0, _colour((0.0, 0.05, 0.08), 0.6)), (0.0, _colour(INK, 0.85))):
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
        imgui.push_style_color(imgui.Col_.window_bg.value, (0.01, 0.06, 0.10, 1.0))
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


def _colour(rgb: tuple[float, float, float], alpha: float = 1.0) -> int:
    packed: int = imgui.get_color_u32((*rgb, alpha))
    return packed
