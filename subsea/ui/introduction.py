"""The first minutes of a dive: the vessel glides in, the helm is handed over, prompts follow.

A visitor who returns, as the logbook shows, sees the name of the place only.
"""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from imgui_bundle import imgui

from subsea.base.language import marked, translated
from subsea.dive.camera_way import hidden
from subsea.dive.captions import Caption, faded
from subsea.dive.settings import ControlName, key_words
from subsea.submarine.vessel import CLEARANCE_CM, Rail, gaps_at, hull_axes
from subsea.ui.gui import GLASS, INK, MARK, colour, ground, stroke
from subsea.world.world import TICK_S, World

if TYPE_CHECKING:
    from subsea.submarine.vessel import Helm
    from subsea.ui.dive import Dive

GLIDE_S = 18.0
FARTHEST_CM, STEP_CM = 320.0, 40.0  # from where it comes; tried in steps
# Begin and end, s, of the title, of what there is to see, and of the words at the helm.
TITLE_S, ABOUT_S, HELM_S = (1.5, 8.0), (8.5, 17.0), (18.0, 24.0)
SHORT_S = 0.5, 5.0  # the title alone
HELM = marked("The helm is yours.")
STEERED_S, GOES_CM_S = 1.0, 20.0  # a prompt is followed when the hull turns or goes for this time
TURNS_RAD_S = 0.06
ENOUGH_S = 12.0  # a prompt without an answer goes by itself after this time
FADE_S = 0.6


class Prompt(NamedTuple):
    """Something that a visitor may try now."""

    words: str  # with {key} for the input of `control`
    control: ControlName | None
    followed: Callable[["Dive"], bool]


def _turns(dive: "Dive") -> bool:
    return abs(float(dive.world.state.submarine.rates[0])) > TURNS_RAD_S


def _goes(dive: "Dive") -> bool:
    return float(np.linalg.norm(dive.world.state.submarine.velocity)) > GOES_CM_S


def _rides(dive: "Dive") -> bool:
    return dive.picture.ride is not None


def _is_off(dive: "Dive") -> bool:
    return dive.picture.ride is None


def _went_back(dive: "Dive") -> bool:
    return dive.timeline is None or dive.timeline.tick < dive.timeline.latest


def _helped(dive: "Dive") -> bool:
    return not dive.overlay.help_hidden


PROMPTS = (
    Prompt(marked("Move the mouse: the submarine turns to where you point."), None, _turns),
    Prompt(marked("Hold {key} to go there."), "ahead", _goes),
    Prompt(marked("Point at a fish, and press {key} to ride it."), "ride", _rides),
    Prompt(marked("Press {key} to leave the fish."), "alight", _is_off),
    Prompt(marked("Press {key} to go back in time, a second each."), "rewind", _went_back),
    Prompt(marked("{key} shows all keys. Have a good dive!"), "help", _helped),
)
MOUSE = {"mouse left": marked("the left button"), "mouse right": marked("the right button")}


class Introduction:
    """Steers at first, then prompts until all prompts are followed or skipped."""

    def __init__(self, dive: "Dive") -> None:
        """Rest until `begin`."""
        self._dive = dive
        self._since_s: float | None = None  # of the beginning; None: over
        self._short = False
        self._prompt: int | None = None  # the number of the prompt that is shown
        self._for_s = self._followed_s = self._opacity = 0.0
        self.area = (0.0, 0.0), (0.0, 0.0)  # of the last prompt that was drawn

    @property
    def active(self) -> bool:
        """True while the vessel glides in, or the place is introduced."""
        return self._since_s is not None

    @property
    def prompts(self) -> bool:
        """True while prompts are shown, in place of the lines for a new visitor."""
        return self._prompt is not None

    def begin(self, short: bool) -> None:
        """Glide in and introduce the place; or only name it."""
        dive = self._dive
        self._since_s, self._short, self._prompt = 0.0, short, None
        if short:
            return
        dive.overlay.hide_help()
        dive.overlay.help_opacity = 0.0
        dive.pilot.passive = True
        dive.tick_source.set_tour(glide_in(dive.world))
        if dive.timeline is not None:
            dive.timeline.touch()
        dive.picture.jump()

    def skip(self) -> None:
        """Hand over the helm at once."""
        if self.active and not self._short:
            self._hand_over()
        self._since_s = None

    def end(self) -> None:
        """End with all prompts: the world was replaced, or a tour began."""
        self.skip()
        self._prompt, self._opacity = None, 0.0

    def _hand_over(self) -> None:
        dive = self._dive
        if dive.pilot.passive:
            dive.pilot.passive = False
            dive.pilot.reset()
            dive.tick_source.set_tour(None)
            self.prompt()

    def prompt(self) -> None:
        """Show the prompts, one after the other, in place of the lines for a new visitor."""
        self._prompt, self._for_s, self._followed_s = 0, 0.0, 0.0
        self._dive.overlay.hide_help()

    def update(self, elapsed_s: float) -> None:
        """Advance by the time of a picture."""
        if self._since_s is not None:
            self._since_s += elapsed_s
            if not self._short and self._since_s >= GLIDE_S:
                self._hand_over()
            if self._since_s > (SHORT_S if self._short else HELM_S)[1]:
                self._since_s = None
        if self._prompt is None or self.active:
            return
        prompt = PROMPTS[self._prompt]
        self._for_s += elapsed_s
        if prompt.followed(self._dive):
            self._followed_s += elapsed_s
        shown = self._followed_s < STEERED_S and self._for_s < ENOUGH_S and self._possible(prompt)
        step = elapsed_s / FADE_S if shown else -elapsed_s / FADE_S
        self._opacity = min(max(self._opacity + step, 0.0), 1.0)
        if not shown and self._opacity == 0.0:
            after = self._prompt + 1
            self._prompt = after if after < len(PROMPTS) else None
            self._for_s = self._followed_s = 0.0

    def _possible(self, prompt: Prompt) -> bool:
        """True if there is an input for it, and, to leave a fish, a ride."""
        if prompt.control is None:
            return self._dive.pilot.settings.mouse.steer
        if prompt.control == "alight" and self._dive.picture.ride is None:
            return False
        if prompt.control == "rewind" and self._dive.timeline is None:
            return False
        return bool(self._dive.pilot.bindings.inputs(prompt.control))

    @property
    def caption(self) -> Caption:
        """The words about the place that are shown now."""
        if self._since_s is None:
            return Caption()
        scenario = self._dive.scenario
        spans = [(scenario.title, SHORT_S)]
        if not self._short:
            spans = [(scenario.title, TITLE_S), (scenario.description, ABOUT_S), (HELM, HELM_S)]
        for words, (begin, end) in spans:
            if begin <= self._since_s < end:
                return faded(translated(words), self._since_s - begin, end - self._since_s)
        return Caption()

    def draw(self) -> None:
        """Draw the prompt in the current frame, above the instruments."""
        if self._prompt is None or self._opacity == 0.0:
            return
        text = translated(PROMPTS[self._prompt].words).format(key=self._key(PROMPTS[self._prompt]))
        size, line = imgui.get_io().display_size, imgui.get_font_size()
        imgui.push_font(None, 1.25 * line)
        large = imgui.get_font_size()  # ImGui rounds it
        box = imgui.calc_text_size(text, wrap_width=0.8 * size.x)
        canvas, room = imgui.get_background_draw_list(), 0.6 * line
        top = min(0.68 * size.y, self._dive.overlay.foot - box.y - 1.2 * room)
        left = (size.x - box.x) / 2
        low, high = (left - room, top - 0.6 * room), (left + box.x + room, top + box.y + 0.6 * room)
        self.area = low, high
        canvas.add_rect_filled(low, high, colour(GLASS, ground(0.8) * self._opacity), 0.4 * line)
        canvas.add_rect(low, high, colour(MARK, 0.6 * self._opacity), 0.4 * line, stroke(1.0))
        canvas.add_text(
            imgui.get_font(), large, (left, top), colour(INK, self._opacity), text,
            wrap_width=0.8 * size.x,
        )  # fmt: skip
        imgui.pop_font()

    def _key(self, prompt: Prompt) -> str:
        if prompt.control is None:
            return ""
        inputs = self._dive.pilot.bindings.inputs(prompt.control)
        mouse = next((name for name in inputs if name in MOUSE), None)
        return translated(MOUSE[mouse]) if mouse else key_words(inputs[0])


def glide_in(world: World) -> Callable[[World], "Helm | Rail"]:
    """Steer from some metres behind the present place to it, slower and slower."""
    submarine = world.state.submarine
    end, (heading, pitch) = submarine.position.copy(), map(float, submarine.angles)
    ahead = hull_axes(heading, pitch)[0]
    start = end - max(distances_clear(world, end, ahead)) * ahead
    first = world.state.tick

    def steer(world: World) -> Rail:
        share = min((world.state.tick + 1 - first) * TICK_S / GLIDE_S, 1.0)
        rest = (1.0 - share) ** 2  # of the way: the vessel slows down evenly
        velocity = 2.0 * (1.0 - share) / GLIDE_S * (end - start)
        place = end + rest * (start - end)
        return Rail(place, velocity, (heading, pitch), cut=world.state.tick == first)

    return steer


def distances_clear(world: World, end: np.ndarray, ahead: np.ndarray) -> Iterator[float]:
    """Yield distances, cm, behind a place up to the first where the hull would not be free."""
    sea, bounds = world.state.sea, world.scenario.bounds
    yield 0.0
    for far in np.arange(STEP_CM, FARTHEST_CM + 1.0, STEP_CM):
        place = end - far * ahead
        x, y, z = (float(value) for value in place)
        gaps = gaps_at((x, y, z), sea, world.rock_owners)
        gaps["the surface"] = -z
        gaps["the edge"] = bounds.radius_cm - float(np.hypot(x, y))
        if min(gaps.values()) < CLEARANCE_CM or hidden(world, (x, y, z), tuple(end), 0.0):
            return
        yield float(far)
