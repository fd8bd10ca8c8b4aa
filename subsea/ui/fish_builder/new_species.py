"""The question what a new species is built like, and what it is to be called."""

import re
from typing import Any

from imgui_bundle import imgui

from subsea.fish.species import species_names

KEY = re.compile(r"[^a-z0-9]+")
ASKED = imgui.WindowFlags_.no_title_bar.value | imgui.WindowFlags_.always_auto_resize.value
LONGEST = 40  # letters


class Naming:
    """A question in the midst of the window, open until it is answered."""

    def __init__(self, source: str, copies: bool = True) -> None:
        """Of a copy of `source`, which can be chosen, or, if none `copies`, of what is there."""
        self.source, self.copies = source, copies
        self.name, self.key = "", ""
        self.shown = False
        self._own_key = False  # whether the file's name was typed, not made from the name

    def draw(self, bench: Any) -> bool | None:
        """The question in the present frame; whether it was answered with a name, None not yet."""
        if not self.shown:
            imgui.open_popup("##naming")
            self.shown = True
        size, answer = imgui.get_io().display_size, None
        imgui.set_next_window_pos((size.x / 2, size.y / 2), 0, (0.5, 0.5))
        if imgui.begin_popup_modal("##naming", None, ASKED)[0]:
            imgui.text("A new species" if self.copies else "A name of its own")
            imgui.dummy((0.0, 0.2 * bench.line))
            wide = 15.0 * bench.line
            if self.copies:
                names = species_names()
                now = names.index(self.source) if self.source in names else 0
                imgui.set_next_item_width(wide)
                chosen = imgui.combo("built like", now, [name.replace("_", " ") for name in names])
                self.source = names[chosen[1]]
            else:
                imgui.text_disabled("The species that come with the program stay as they are.")
            imgui.set_next_item_width(wide)
            changed, name = imgui.input_text("its name", self.name)
            if changed:
                self.name = name[:LONGEST]
                if not self._own_key:
                    self.key = KEY.sub("_", self.name.lower()).strip("_")
            imgui.set_next_item_width(wide)
            changed, key = imgui.input_text("its file", self.key)
            if changed:
                self.key, self._own_key = key[:LONGEST], bool(key)
            imgui.dummy((0.0, 0.2 * bench.line))
            imgui.begin_disabled(not self.key or not self.name.strip())
            if imgui.button("Make it" if self.copies else "Save it"):
                answer = True
            imgui.end_disabled()
            imgui.same_line()
            if imgui.button("Cancel") or imgui.is_key_pressed(imgui.Key.escape):
                answer = False
            if answer is not None:
                imgui.close_current_popup()
            imgui.end_popup()
        return answer
