"""Dear ImGui in the pilot's window: frames, input and drawing."""

import time
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal, NamedTuple

import glfw
from imgui_bundle import imgui

from subsea.base.language import japanese_font, latin_font
from subsea.dive.settings import MODIFIER_KEYS, DisplaySettings, key_name
from subsea.view.front_screen import WHOLE, TextViewport

MODIFIERS = (
    (glfw.MOD_CONTROL, imgui.Key.mod_ctrl),
    (glfw.MOD_SHIFT, imgui.Key.mod_shift),
    (glfw.MOD_ALT, imgui.Key.mod_alt),
    (glfw.MOD_SUPER, imgui.Key.mod_super),
)


class KeyEvent(NamedTuple):
    """An event of the keyboard."""

    feed: Callable[[], object]  # passes it to ImGui
    presses: bool = False  # a key other than a modifier goes down
    modifies: bool = False  # a modifier goes up or down


class KeyQueue:
    """Keys and characters in their order.

    A frame has one state of the modifiers: Ctrl+Z that begins and ends within a frame would be Z.
    """

    def __init__(self) -> None:
        """Attach to the present context of ImGui."""
        self._io = imgui.get_io()
        self._events: deque[KeyEvent] = deque()
        self._held: set[imgui.Key] = set()  # modifiers, after these events

    def press(self, name: imgui.Key, down: bool) -> None:
        """Queue a key that goes up or down."""
        modifies = any(name == modifier for _, modifier in MODIFIERS)
        if modifies and down == (name in self._held):
            return
        self._held ^= {name} if modifies else set()
        feed = partial(self._io.add_key_event, name, down)
        self._events.append(KeyEvent(feed, down and not modifies, modifies))

    def type(self, character: int) -> None:
        """Queue a character."""
        self._events.append(KeyEvent(partial(self._io.add_input_character, character)))

    def feed(self) -> None:
        """Pass events to ImGui, up to a modifier after another key has gone down."""
        pressed = False
        while self._events and not (pressed and self._events[0].modifies):
            event = self._events.popleft()
            pressed |= event.presses
            event.feed()


Rgb = tuple[float, float, float]

TEXT_PT = 18.0
LINES = 60.0  # of text at most in the height of a window: on large screens letters are larger
STEPS = {"normal": 1.0, "large": 1.3, "largest": 1.7}  # of the size of text
ROOM = 34.0, 20.0  # smallest screen for the help, in heights of its letters
SQUEEZED = 1.2  # factor on text in squeezed viewports, which is also bold
INK = (0.93, 0.97, 1.0)
QUIET = (0.62, 0.76, 0.84)
DEEP = (0.02, 0.13, 0.20)
GLASS = (0.01, 0.06, 0.10)  # background of panels
LIT = (0.16, 0.52, 0.66)
MARK = (0.40, 0.80, 1.0)  # the chosen item, and curves
WARM = (0.98, 0.75, 0.35)  # warnings
REFUSED = (0.90, 0.25, 0.25)  # of what is refused
SHADE = (0.0, 0.05, 0.08)  # behind text over the sea
BACKING = 0.6  # opacity of a dark ground under text
FIRM = 2.5  # least width of strokes with more contrast, in pixels
CLAMP = imgui.SliderFlags_.always_clamp.value  # also what is typed

KEYS = {
    glfw.KEY_LEFT: imgui.Key.left_arrow,
    glfw.KEY_RIGHT: imgui.Key.right_arrow,
    glfw.KEY_UP: imgui.Key.up_arrow,
    glfw.KEY_DOWN: imgui.Key.down_arrow,
    glfw.KEY_KP_ENTER: imgui.Key.keypad_enter,
} | {
    getattr(glfw, f"KEY_{name.upper()}"): imgui.Key[name]
    for name in (
        "tab", "page_up", "page_down", "home", "end", "insert", "delete", "backspace", "space",
        "enter", "escape", *"acvxyzs",  # with Ctrl: all, copy, paste, cut, redo, undo, save
    )
}  # fmt: skip
PRESSED = {
    imgui.Key.mod_ctrl: (glfw.KEY_LEFT_CONTROL, glfw.KEY_RIGHT_CONTROL),
    imgui.Key.mod_shift: (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT),
}
# Parts of a gamepad that navigate: to the next entry, choose, back.
PADS = {
    "pad A": imgui.Key.gamepad_face_down,
    "pad B": imgui.Key.gamepad_face_right,
    **{
        f"pad {stick}{way}": key
        for stick in ("", "left stick ")
        for way, key in (
            ("up", imgui.Key.gamepad_dpad_up),
            ("down", imgui.Key.gamepad_dpad_down),
            ("left", imgui.Key.gamepad_dpad_left),
            ("right", imgui.Key.gamepad_dpad_right),
        )
    },
}
PUSHED = 0.5  # amount from which a part of a gamepad navigates


class Look(NamedTuple):
    """The look of text and panels, by the settings."""

    text: float = 1.0  # factor on the size of letters
    contrast: bool = False  # opaque grounds, no quiet colours, no thin strokes


_look = Look()  # of this process, as its language is


def look() -> Look:
    """The present look."""
    return _look


def set_look(display: DisplaySettings) -> None:
    """Follow the settings of the display; panels follow with the next frame."""
    global _look
    _look = Look(STEPS[display.text], display.contrast)


class Gui:
    """Draws frames over the picture, with the OpenGL 3 backend.

    While it is `open` it receives the pointer, which does not steer then, and keys while text is
    typed.
    """

    def __init__(self) -> None:
        """Attach to the window whose OpenGL context is current."""
        self.open = False
        self.heard = 0  # count of input events
        self.take_key: Callable[[str], object] | None = (
            None  # gets the next key, which acts no more
        )
        self._navigated = False
        self._unsure = 0  # frames until it is known whether the last click was on a text field
        self._context = imgui.create_context()
        self._io = imgui.get_io()
        self._keys = KeyQueue()
        self._io.set_ini_filename(None)
        self._io.config_error_recovery_enable_debug_log = False  # see `ui/picture.py`
        self._io.config_error_recovery_enable_tooltip = False
        self._plain, self._bold = self._font("Regular"), self._font("Bold")
        imgui.backends.opengl3_init("#version 330")
        self._window = 1.0, 1.0
        self._viewports: Sequence[TextViewport] = (WHOLE,)
        self._last = time.perf_counter()
        self._styled: Look | None = None

    def _font(self, weight: Literal["Regular", "Bold"]) -> Any:
        """A font whose letters of Japanese are those of another."""
        font = self._io.fonts.add_font_from_file_ttf(str(latin_font(weight)), TEXT_PT)
        more = imgui.ImFontConfig()
        more.merge_mode = True
        self._io.fonts.add_font_from_file_ttf(str(japanese_font()), TEXT_PT, more)
        return font

    def begin(
        self, points: tuple[int, int], pixels: tuple[int, int], scale: float,
        viewports: Sequence[TextViewport] = (WHOLE,),
    ) -> None:  # fmt: skip
        """Begin a frame on a window of a size in pointer units and in pixels.

        All later drawing goes to each of the `viewports`, for both eyes at the depth of the screen.
        """
        if self._styled != look():
            self._styled = look()
            _set_style(imgui.get_style())
        imgui.backends.opengl3_new_frame()
        now = time.perf_counter()
        self._io.delta_time, self._last = max(now - self._last, 1e-4), now
        self._window, self._viewports = (float(points[0]), float(points[1])), viewports
        viewport = viewports[0]
        width, height = (
            share * size for share, size in zip(viewport.screen, self._window, strict=True)
        )
        self._io.display_size = imgui.ImVec2(width, height)
        self._io.display_framebuffer_scale = imgui.ImVec2(
            pixels[0] / points[0], pixels[1] / points[1]
        )
        self._draw_pointer(self.open and len(viewports) > 1)
        self._keys.feed()
        imgui.new_frame()
        self._unsure = max(self._unsure - 1, 0)
        usual = max(TEXT_PT * scale, height / LINES) * look().text
        tall = min(
            usual * (SQUEEZED if viewport.squeezed else 1.0),
            width / ROOM[0],
            height / ROOM[1],
        )
        imgui.push_font(self._bold if viewport.squeezed else self._plain, max(tall, 1.0))

    def end(self) -> None:
        """End the frame and draw it."""
        imgui.pop_font()
        imgui.render()
        data = imgui.get_draw_data()
        scale = data.framebuffer_scale
        across, down = scale.x, scale.y
        for viewport in self._viewports:
            viewport.page(viewport.number)
            # The viewport shows its part of a larger window.
            wider, higher = (
                viewport.screen[0] / viewport.width,
                viewport.screen[1] / viewport.height,
            )
            width, height = wider * self._window[0], higher * self._window[1]
            data.display_pos = imgui.ImVec2(-viewport.x * width, -viewport.y * height)
            data.display_size = imgui.ImVec2(width, height)
            data.framebuffer_scale = imgui.ImVec2(across / wider, down / higher)
            imgui.backends.opengl3_render_draw_data(data)

    def _draw_pointer(self, on: bool) -> None:
        """Draw the pointer for each eye, or have the desktop show it once."""
        if on != self._io.mouse_draw_cursor:
            self._io.mouse_draw_cursor = on
            mode = glfw.CURSOR_HIDDEN if on else glfw.CURSOR_NORMAL
            glfw.set_input_mode(glfw.get_current_context(), glfw.CURSOR, mode)

    def navigate(self, on: bool) -> None:
        """Set whether arrows, Enter and a gamepad navigate. The focused entry is outlined."""
        flags = imgui.ConfigFlags_
        keys = flags.nav_enable_keyboard.value | flags.nav_enable_gamepad.value
        self._io.config_flags = self._io.config_flags & ~keys | (keys if on else 0)
        self._io.config_nav_cursor_visible_always = on  # else Enter is ignored until an arrow
        self._navigated = on
        self._io.backend_flags |= imgui.BackendFlags_.has_gamepad.value

    @property
    def points(self) -> tuple[float, float]:
        """The size of the window, in pointer units."""
        return self._window

    @property
    def on_panel(self) -> bool:
        """True if the pointer is on a panel, or in a drag that began on one."""
        return bool(self._io.want_capture_mouse)

    @property
    def pointer(self) -> tuple[float, float]:
        """The pointer, in shares of the screen from the upper left corner."""
        place, size = self._io.mouse_pos, self._io.display_size
        return place.x / size.x, place.y / size.y

    def pointed(self, x: float, y: float) -> bool:
        """The pointer moved, in pointer units of the window; True if panels take it."""
        self.heard += 1
        # Map from the viewport under the pointer to the screen that all show.
        share_x, share_y = x / self._window[0], y / self._window[1]
        viewport = next(
            (shown for shown in self._viewports if _within(shown, share_x, share_y)),
            self._viewports[0],
        )
        self._io.add_mouse_pos_event(
            (share_x - viewport.x) / viewport.width * viewport.screen[0] * self._window[0],
            (share_y - viewport.y) / viewport.height * viewport.screen[1] * self._window[1],
        )
        return self.open

    def pressed(self, button: int, down: bool) -> bool:
        """A mouse button went down or up; True if panels take it."""
        self.heard += 1
        if self.open and down:
            self._unsure = 2
        if (self.open or not down) and button < imgui.MouseButton_.count.value:
            self._io.add_mouse_button_event(button, down)
        return self.open

    def scrolled(self, dx: float, dy: float) -> bool:
        """The wheel turned; True if panels take it."""
        self.heard += 1
        if self.open:
            self._io.add_mouse_wheel_event(dx, dy)
        return self.open

    def keyed(self, key: int, down: bool, modifiers: int) -> bool:
        """A key went down or up; True if a text field takes it.

        Also True just after a click, until it is known whether that was on a text field.
        """
        self.heard += 1
        if self.take_key is not None and down and (input_ := key_name(key, modifiers)):
            if input_.rpartition("+")[2] not in MODIFIER_KEYS:
                take, self.take_key = self.take_key, None
                take(input_)
            return True
        if self.open or not down:
            for bit, name in MODIFIERS:
                self._keys.press(name, bool(modifiers & bit))
            # ImGui expects the modifiers of an event before it.
            for name, keys in PRESSED.items():
                if key in keys:
                    self._keys.press(name, down)
            if key in KEYS:
                self._keys.press(KEYS[key], down)
        return self.open and (bool(self._io.want_text_input) or self._unsure > 0)

    def moved(self, name: str, amount: float) -> bool:
        """A part of a gamepad moved; True if it navigates."""
        if not self._navigated or name not in PADS:
            return False
        self._io.add_key_event(PADS[name], amount > PUSHED)
        return True

    def typed(self, character: int) -> None:
        """A character was typed."""
        self.heard += 1
        if self.open:
            self._keys.type(character)

    def release_all(self) -> None:
        """Release all inputs: the window lost the keyboard, or panels were closed."""
        self.heard += 1
        for button in range(3):
            self._io.add_mouse_button_event(button, False)
        for name in (*KEYS.values(), *PADS.values(), *(modifier for _, modifier in MODIFIERS)):
            self._keys.press(name, False)

    def close(self) -> None:
        """Release resources; the window's context must still be current."""
        imgui.backends.opengl3_shutdown()
        imgui.destroy_context(self._context)


def button(label: str, enabled: bool) -> bool:
    """Draw a button that may be disabled; returns True if it was pressed."""
    imgui.begin_disabled(not enabled)
    pressed = bool(imgui.button(label))
    imgui.end_disabled()
    return pressed and enabled


def wrapped_text(text: str, rgb: Rgb = QUIET, wide: float = 0.0) -> None:
    """Text that wraps at `wide` heights of letters; 0: at the edge of the panel."""
    imgui.push_text_wrap_pos(wide * imgui.get_font_size())
    imgui.text_colored((*rgb, 1.0), text)
    imgui.pop_text_wrap_pos()


def fill_with_text(text: str) -> None:
    """Fill the window with one line of text, in the current frame."""
    size = imgui.get_io().display_size
    box = imgui.calc_text_size(text)
    canvas = imgui.get_background_draw_list()
    canvas.add_rect_filled((0.0, 0.0), size, colour(DEEP))
    canvas.add_text(((size.x - box.x) / 2, (size.y - box.y) / 2), colour(INK), text)


def text_at_foot(text: str) -> None:
    """Write one line of text near the foot of the window, in the current frame."""
    size = imgui.get_io().display_size
    draw_line(text, size, size.y - 1.6 * imgui.get_font_size())


def draw_loading_bar(share: float) -> None:
    """Draw a bar along the foot of the window that is filled by a share in [0, 1]."""
    size, line = imgui.get_io().display_size, imgui.get_font_size()
    canvas = imgui.get_background_draw_list()
    left, right, top = 1.2 * line, size.x - 1.2 * line, size.y - 0.9 * line
    high = max(0.25 * line, 2.0)
    canvas.add_rect_filled((left, top), (right, top + high), colour(SHADE, 0.7), 0.5 * high)
    tip = left + min(max(share, 0.0), 1.0) * (right - left)
    if tip > left + high:
        canvas.add_rect_filled((left, top), (tip, top + high), colour(MARK), 0.5 * high)


def draw_line(text: str, size: Any, foot: float) -> float:
    """Draw wrapped text that ends at `foot` of a window; returns its upper edge less a gap."""
    line, font = imgui.get_font_size(), imgui.get_font()
    room = size.x - 2.4 * line
    box = imgui.calc_text_size(text, wrap_width=room)
    x, y = 1.2 * line, foot - box.y
    draw_backing((x, y), (x + box.x, foot), line)
    canvas = imgui.get_background_draw_list()
    for off, ink in ((1.0, colour(SHADE, 0.6)), (0.0, colour(INK))):
        canvas.add_text(font, line, (x + off, y + off), ink, text, wrap_width=room)
    return y - 0.6 * line


def colour(rgb: Rgb, alpha: float = 1.0) -> int:
    """A colour packed for draw lists."""
    if look().contrast and rgb == QUIET:
        rgb = INK
    packed: int = imgui.get_color_u32((*rgb, alpha))
    return packed


def stroke(wide: float) -> float:
    """The width of a line: with more contrast none is thin."""
    return max(wide, FIRM) if look().contrast else wide


def ground(opacity: float) -> float:
    """The opacity of a ground behind text: with more contrast it hides what is behind it."""
    return 1.0 if look().contrast else opacity


def draw_backing(
    low: tuple[float, float], high: tuple[float, float], line: float, opacity: float = 1.0
) -> None:
    """Draw a dark ground for letters `line` high, from an upper left to a lower right corner."""
    (left, top), (right, foot), room = low, high, 0.45 * line
    imgui.get_background_draw_list().add_rect_filled(
        (left - room, top - 0.5 * room),
        (right + room, foot + 0.5 * room),
        colour(SHADE, ground(BACKING) * opacity),
        0.35 * line,
    )


def draw_shadowed_text(
    place: tuple[float, float], text: str, size: float, rgb: Rgb,
    alpha: float = 1.0, share: float = 0.0,
) -> None:  # fmt: skip
    """Draw text with a shadow over the sea; `share` of its width lies left of the place."""
    canvas = imgui.get_background_draw_list()
    imgui.push_font(None, size)
    box = imgui.calc_text_size(text)
    x, y = place[0] - share * box.x, place[1]
    if look().contrast and text:
        low, high = (x - 0.15 * size, y), (x + box.x + 0.15 * size, y + box.y)
        canvas.add_rect_filled(low, high, colour(SHADE, alpha), 0.2 * size)
    for off, ink in (
        (max(0.06 * size, 1.0), colour(SHADE, 0.75 * alpha)),
        (0.0, colour(rgb, alpha)),
    ):
        canvas.add_text((x + off, y + off), ink, text)
    imgui.pop_font()


def _within(viewport: TextViewport, x: float, y: float) -> bool:
    return (
        viewport.x <= x < viewport.x + viewport.width
        and viewport.y <= y < viewport.y + viewport.height
    )


def _set_style(style: Any) -> None:
    """Style panels: dark glass over the sea, one light colour for the chosen item."""
    style.window_rounding, style.frame_rounding, style.grab_rounding = 8.0, 4.0, 4.0
    style.popup_rounding, style.scrollbar_rounding, style.tab_rounding = 6.0, 6.0, 4.0
    style.window_padding, style.frame_padding = (12.0, 10.0), (7.0, 3.0)
    style.item_spacing = (8.0, 5.0)
    border = 2.0 if look().contrast else 0.0
    style.window_border_size = style.popup_border_size = style.frame_border_size = border
    names = imgui.Col_
    for name, rgb, alpha in (
        (names.border, INK, 1.0),
        (names.text, INK, 1.0),
        (names.text_disabled, QUIET, 0.8),
        (names.window_bg, GLASS, 0.97),
        (names.popup_bg, GLASS, 0.98),
        (names.menu_bar_bg, GLASS, 0.78),
        (names.title_bg, (0.02, 0.10, 0.15), 1.0),
        (names.title_bg_active, (0.04, 0.17, 0.24), 1.0),
        (names.title_bg_collapsed, GLASS, 0.9),
        (names.frame_bg, (0.13, 0.27, 0.34), 0.55),
        (names.frame_bg_hovered, (0.18, 0.38, 0.47), 0.7),
        (names.frame_bg_active, (0.18, 0.42, 0.52), 0.85),
        (names.button, (0.11, 0.31, 0.41), 0.8),
        (names.button_hovered, (0.16, 0.43, 0.55), 0.95),
        (names.button_active, LIT, 1.0),
        (names.header, (0.11, 0.34, 0.44), 0.75),
        (names.header_hovered, (0.16, 0.43, 0.55), 0.9),
        (names.header_active, LIT, 1.0),
        (names.check_mark, MARK, 1.0),
        (names.slider_grab, LIT, 1.0),  # dark enough for the value that is written over it
        (names.slider_grab_active, (0.20, 0.60, 0.76), 1.0),
        (names.separator, QUIET, 0.25),
        (names.nav_cursor, MARK, 0.9),
        (names.tab, (0.08, 0.22, 0.30), 0.8),
        (names.tab_hovered, (0.16, 0.43, 0.55), 0.95),
        (names.tab_selected, (0.11, 0.36, 0.47), 0.95),
        (names.tab_selected_overline, MARK, 0.8),
        (names.modal_window_dim_bg, SHADE, 0.6),
        (names.plot_lines, MARK, 1.0),
        (names.plot_histogram, (0.40, 0.75, 0.86), 1.0),
    ):
        if look().contrast:
            rgb, alpha = INK if rgb == QUIET else rgb, ground(alpha)
        style.set_color_(name.value, (*rgb, alpha))
