"""Help, instruments and notes over the picture, and messages while loading."""

import math
import re

from imgui_bundle import imgui

from subsea.ui.gui import draw_line
from subsea.ui.help_overlay import HelpContent, draw_brief, draw_help
from subsea.ui.hud import HIGH, Hud, Reading

FADE_S = 1.5
NOTE_S = 4.0
MOVED_CM = 60.0  # distance after which the help fades
COASTED_CM = 300.0  # farthest distance by which a submarine glides on from a tour


class Overlay:
    """Text over the picture, drawn in a frame of the gui.

    Three lines of the help show at the start, and fade when the submarine gets under way.
    """

    def __init__(self, help: HelpContent) -> None:
        self.help, self.hud = help, Hud()
        self.help_opacity = 1.0
        self._full = False  # the whole help, until it is hidden
        self._shown = True
        self._gone_cm = 0.0
        self.foot = math.inf  # upper edge of notes and instruments, in pointer units
        self.note_text = ""
        self._note_s = 0.0

    def note(self, text: str) -> None:
        """Show a text for a while, above the instruments."""
        self.note_text, self._note_s = text, NOTE_S

    def show_help(self) -> None:
        """Show the help until it is hidden."""
        self._shown = self._full = True

    def greet(self) -> None:
        """Show a new visitor three lines of the help, until the submarine is under way.

        It may still glide on from a tour.
        """
        self._shown, self._full, self._gone_cm = True, False, -COASTED_CM

    def hide_help(self) -> None:
        """Fade out the help."""
        self._shown = False

    def toggle_help(self) -> None:
        """Show the whole help until it is hidden, or hide it."""
        if self._shown and self._full:
            self.hide_help()
        else:
            self.show_help()

    @property
    def help_hidden(self) -> bool:
        """True if no help covers the corners of the picture."""
        return self.help_opacity == 0.0

    @property
    def covered(self) -> float:
        """Opacity of the whole help, which covers the middle of the picture."""
        return self.help_opacity if self._full else 0.0

    def draw(
        self, now: Reading, dt: float, circumstances: str = "", away: bool = False,
        covered: bool = False,
    ) -> None:  # fmt: skip
        """Draw help, notes and instruments, `dt` seconds after the last frame.

        `circumstances` is a text that stays. `away` from the helm there are no instruments, nor
        while a card or panel has them `covered`.
        """
        self._note_s -= dt
        self._fade(abs(now.ahead_m_s) * 100.0 * dt, dt, away)
        self.hud.update(now, dt, wanted=not (away or covered))
        self.hud.draw(now)
        size, line = imgui.get_io().display_size, imgui.get_font_size()
        # Text stays above the instruments even while they are hidden, so that it does not jump.
        foot = size.y - (1.2 if away else 1.2 + HIGH) * line
        note = self.note_text if self._note_s > 0.0 else ""
        words = "   ".join(filter(None, (circumstances, note)))
        if words:
            foot = draw_line(unbroken(words), size, foot)
        self.foot = foot
        if self.help_opacity > 0.0 and self._full:
            draw_help(self.help, self.help_opacity, foot)
        elif self.help_opacity > 0.0:
            draw_brief(self.help, self.help_opacity)

    def draw_note(self, dt: float) -> None:
        """Draw the note alone, at the top of the picture, `dt` seconds after the last frame."""
        self._note_s -= dt
        if self._note_s > 0.0:
            size, line = imgui.get_io().display_size, imgui.get_font_size()
            draw_line(unbroken(self.note_text), size, 2.4 * line)

    def _fade(self, gone_cm: float, dt: float, away: bool) -> None:
        self._gone_cm += math.inf if away else gone_cm  # on a ride or tour counts as under way
        if self._gone_cm > MOVED_CM and not self._full:
            self._shown = False
        step = dt / FADE_S if self._shown else -dt / FADE_S
        self.help_opacity = min(max(self.help_opacity + step, 0.0), 1.0)


def unbroken(text: str) -> str:
    """Make a text wrap only between parts, which three blanks separate."""
    return re.sub(r"(?<! ) (?! )", "\u00a0", text)
