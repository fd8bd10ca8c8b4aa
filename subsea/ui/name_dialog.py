"""A modal dialog for the names of a new species."""

import re

from imgui_bundle import imgui

from subsea.fish.species import species_names
from subsea.ui.gui import button
from subsea.ui.question import cancelled, modal

NOT_IN_KEY = re.compile(r"[^a-z0-9]+")
LONGEST = 40  # characters


class NameDialog:
    """The source, the common name and the file name of a new species."""

    def __init__(self, source: str, copies: bool = True) -> None:
        """Ask for the names of a copy of `source`, or, without `copies`, of what is shown."""
        self.source, self.copies = source, copies
        self.name, self.key = "", ""
        self._shown = False
        self._key_typed = False  # else it follows from the name

    def reopen(self) -> None:
        """Ask again after an answer that could not be used."""
        self._shown = False

    def draw(self) -> bool | None:
        """Draw it into the present frame; True: confirmed, False: cancelled, None: still open."""
        answer, line = None, imgui.get_font_size()
        with modal("##naming", opening=not self._shown) as visible:
            if visible:
                imgui.text("A new species" if self.copies else "A name of its own")
                imgui.dummy((0.0, 0.2 * line))
                if self.copies:
                    names = species_names()
                    now = names.index(self.source) if self.source in names else 0
                    imgui.set_next_item_width(15.0 * line)
                    shown = [name.replace("_", " ") for name in names]
                    self.source = names[imgui.combo("built like", now, shown)[1]]
                else:
                    imgui.text_disabled("The species that come with the program stay as they are.")
                imgui.set_next_item_width(15.0 * line)
                changed, name = imgui.input_text("its name", self.name)
                if changed:
                    self.name = name[:LONGEST]
                    if not self._key_typed:
                        self.key = NOT_IN_KEY.sub("_", self.name.lower()).strip("_")
                imgui.set_next_item_width(15.0 * line)
                changed, key = imgui.input_text("its file", self.key)
                if changed:
                    self.key, self._key_typed = key[:LONGEST], bool(key)
                imgui.dummy((0.0, 0.2 * line))
                named = bool(self.key and self.name.strip())
                if button("Make it" if self.copies else "Save it", named):
                    answer = True
                imgui.same_line()
                if imgui.button("Cancel") or cancelled():
                    answer = False
                if answer is not None:
                    imgui.close_current_popup()
        self._shown = True
        return answer
