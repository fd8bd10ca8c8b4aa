"""Modal dialogs in the middle of a window: a question, and the names of a new species."""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from imgui_bundle import imgui

from subsea.fish.species import species_names
from subsea.ui.gui import button

MODAL = imgui.WindowFlags_.no_title_bar.value | imgui.WindowFlags_.always_auto_resize.value
Answers = Mapping[str, Callable[[], object] | None]  # None does nothing; Esc gives the last


class Question:
    """A text and buttons, shown until one of them is clicked."""

    def __init__(self, text: str, answers: Answers) -> None:
        """Open it with the next `draw`."""
        self.text, self.answers = text, answers
        self._shown = False

    def draw(self) -> str | None:
        """Draw it into the present frame; return the answer, if there is one."""
        answer: str | None = None
        with modal("##question", opening=not self._shown) as visible:
            if visible:
                imgui.text(self.text)
                imgui.dummy((0.0, 0.3 * imgui.get_font_size()))
                for number, label in enumerate(self.answers):
                    if number:
                        imgui.same_line()
                    if imgui.button(f"{label}##answer"):
                        answer = label
                if cancelled():
                    answer = list(self.answers)[-1]
                if answer is not None:
                    imgui.close_current_popup()
        self._shown = True
        return answer


def cancelled() -> bool:
    """Return True if Esc was pressed in the present dialog; it closes an open list of it first."""
    if not imgui.is_key_pressed(imgui.Key.escape):
        return False
    context = imgui.get_current_context()
    level = context.begin_popup_stack.size()
    if context.open_popup_stack.size() == level:
        return True
    imgui.internal.close_popup_to_level(level, True)
    return False


@contextmanager
def modal(name: str, opening: bool) -> Iterator[bool]:
    """Draw a modal dialog in the middle of the window; yields whether it is visible."""
    if opening:
        imgui.open_popup(name)
    size = imgui.get_io().display_size
    imgui.set_next_window_pos((size.x / 2, size.y / 2), 0, (0.5, 0.5))
    visible = imgui.begin_popup_modal(name, None, MODAL)[0]
    try:
        yield visible
    finally:
        if visible:
            imgui.end_popup()


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
