"""A modal question in the middle of a window."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from imgui_bundle import imgui

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
