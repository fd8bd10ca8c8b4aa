"""A card beside the fish under the pointer: its name, what it is about, and what one can do."""

from typing import TYPE_CHECKING

import numpy as np
from imgui_bundle import imgui

from subsea.base.language import marked, translated
from subsea.dive.plain_words import sentence
from subsea.dive.settings import ControlName, key_words
from subsea.ui.gui import GLASS, INK, MARK, QUIET, colour, ground

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

LOOK_S = 0.2  # between two looks at what is under the pointer
REST_S = 0.3  # for which a fish is under the pointer before its card appears
FADE_S = 0.25
TAPPED_S = 8.0  # for which the card of a tapped fish stays
REACH = 0.04  # share of the picture's height around a fish that may be under the pointer
WIDEST = 20.0  # of a sentence, in heights of letters
AWAY = 1.2  # between the fish and its card, in heights of letters
KEYS: tuple[tuple[ControlName, str], ...] = (
    ("ride", marked("ride")), ("follow", marked("follow")), ("reins", marked("steer")),
)  # fmt: skip


class FishCard:
    """Follows the pointer at the helm."""

    def __init__(self, dive: "Dive") -> None:
        """Start without a fish."""
        self._dive = dive
        self.fish: int | None = None  # of the card
        self.opacity = 0.0
        self.area = (0.0, 0.0), (0.0, 0.0)  # its corners on the screen
        self._under: int | None = None  # the fish under the pointer ...
        self._for_s, self._since_s = 0.0, 0.0  # ... for this time; time since the last look
        self._stays_s = 0.0  # for this time the card of a tapped fish stays

    def clear(self) -> None:
        """Forget the fish: the world was replaced."""
        self.fish, self._under, self.opacity = None, None, 0.0
        self._stays_s = 0.0

    def tap(self) -> None:
        """Show the card of the fish under a finger for a while, or hide that of another."""
        self._under, self._stays_s = self._look(), TAPPED_S
        self._for_s = REST_S

    def update(self, elapsed_s: float, wanted: bool) -> None:
        """Look under the pointer, `elapsed_s` after the last frame; hide the card unless `wanted`.

        The exact look costs a small picture, so it waits for a fish about there.
        """
        self._since_s += elapsed_s
        self._stays_s -= elapsed_s
        if self._dive.pilot.settings.mouse.touch:  # a lifted finger leaves the pointer there
            self._under = self._under if self._stays_s > 0.0 else None
        elif self._since_s >= LOOK_S:
            under = self._look() if wanted else None
            self._for_s = self._for_s + self._since_s if under == self._under else 0.0
            self._under, self._since_s = under, 0.0
        if self._under is not None and self._for_s >= REST_S:
            self.fish = self._under
        alive = self.fish is not None and self._dive.world.state.fishes.alive[self.fish]
        shown = wanted and alive and self._under == self.fish
        step = elapsed_s / FADE_S if shown else -elapsed_s / FADE_S
        self.opacity = min(max(self.opacity + step, 0.0), 1.0)
        if self.opacity == 0.0 and not shown:
            self.fish = None

    def _look(self) -> int | None:
        dive, front = self._dive, self._dive.picture.front_view
        pointer = dive.gui.pointer
        if front is None or not all(0.0 <= share <= 1.0 for share in pointer):
            return None
        fishes = dive.world.state.fishes
        gap = np.abs(front.places(fishes.position) - pointer)
        size = imgui.get_io().display_size
        far = np.linalg.norm(fishes.position - np.asarray(front.view.eye), axis=1)
        half = 0.5 * float(front.view.projection[1, 1]) * fishes.length / np.maximum(far, 1.0)
        with np.errstate(invalid="ignore"):
            about = np.hypot(gap[:, 0] * size.x / size.y, gap[:, 1]) < half + REACH
        about &= fishes.alive & (far < dive.world.scenario.water.visibility_cm)
        return dive.picture.fish_at(*pointer) if about.any() else None

    def draw(self) -> None:
        """Draw the card beside its fish in the current frame."""
        dive, front = self._dive, self._dive.picture.front_view
        if self.fish is None or self.opacity == 0.0 or front is None:
            return
        fishes, fish = dive.world.state.fishes, self.fish
        size, line = imgui.get_io().display_size, imgui.get_font_size()
        before = fishes.previous_position[fish].astype(np.float64)
        place = before + dive.picture.alpha * (fishes.position[fish] - before)
        side = front.view.view[0, :3].astype(np.float64)
        rim = place + 0.5 * float(fishes.length[fish]) * side
        (x, y), (rim_x, _) = (front.places(np.stack([place, rim])) * (size.x, size.y)).tolist()
        if not np.isfinite([x, y, rim_x]).all():
            return
        name = translated(dive.world.species[fishes.species[fish]].name)
        words = sentence(dive.world, fish)
        inputs = dive.pilot.bindings.inputs
        keys = "   ".join(
            f"{key_words(inputs(control)[0])} {translated(what)}"
            for control, what in KEYS
            if inputs(control) and not dive.shared
        )
        room = WIDEST * line
        lines = [(name, MARK, 1.1), (words, INK, 1.0), *([(keys, QUIET, 0.85)] if keys else [])]
        boxes = []
        for text, _, scale in lines:
            imgui.push_font(None, scale * line)
            boxes.append(imgui.calc_text_size(text, wrap_width=room))
            imgui.pop_font()
        wide = max(box.x for box in boxes) + line
        high = sum(box.y + 0.2 * line for box in boxes) + 0.6 * line
        # The nearer half of a fish looks longer.
        away = float(np.linalg.norm(place - np.asarray(front.view.eye)))
        nearer = away / max(away - 0.5 * float(fishes.length[fish]), 0.4 * away)
        reach = abs(rim_x - x) * nearer + AWAY * line
        left = x + reach if x + reach + wide < size.x else x - reach - wide
        left = min(max(left, 0.3 * line), max(size.x - wide - 0.3 * line, 0.0))
        foot = min(size.y, dive.overlay.foot) - 0.3 * line  # it covers no instruments
        top = min(max(y - high / 2, 0.3 * line), max(foot - high, 0.0))
        self.area = (left, top), (left + wide, top + high)
        canvas = imgui.get_background_draw_list()
        canvas.add_rect_filled(*self.area, colour(GLASS, ground(0.8) * self.opacity), 0.35 * line)
        y_text = top + 0.3 * line
        for (text, rgb, scale), box in zip(lines, boxes, strict=True):
            imgui.push_font(None, scale * line)
            canvas.add_text(
                imgui.get_font(), scale * line, (left + 0.5 * line, y_text),
                colour(rgb, self.opacity), text, wrap_width=room,
            )  # fmt: skip
            imgui.pop_font()
            y_text += box.y + 0.2 * line
