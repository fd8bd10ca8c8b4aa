"""Events of the keyboard that wait for the next frame of ImGui."""

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import glfw
from imgui_bundle import imgui

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
