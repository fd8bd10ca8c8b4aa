"""Start and end tours of an unattended dive, and draw over the picture."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from imgui_bundle import imgui

from subsea.base.errors import UserError
from subsea.base.language import translated
from subsea.dive.directed_camera import check_tour, endless_tour, is_directed, is_over
from subsea.dive.idle_timer import IdleTimer
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario
from subsea.ui.gui import DEEP, INK, colour, draw_shadowed_text

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

BREATH_S = 5.0  # period in which the invitation fades in and out


class IdleTours:
    """Starts a tour when there is no input, and ends it at any input."""

    def __init__(
        self, dive: "Dive", name: str, after_s: float,
        start: tuple[Scenario, Path, int | None], starts_over: bool = False,
    ) -> None:  # fmt: skip
        """A tour called `name` begins `after_s` without input; 0: never.

        If it `starts_over`, it begins in the world of the `start`: scenario, file and seed.
        """
        self.name = self.current = name  # of an idle dive, and of the last tour
        self.timer = IdleTimer(after_s, leaps=False)
        self._dive, self._start, self._starts_over = dive, start, starts_over
        self.active = False  # there was input before this picture
        self.visits = 0  # times that somebody began to steer
        self._visited = False  # somebody steers since the last tour
        # The autopilot and directions go on from where the submarine is: no need to fade to dark.
        leaps = name not in (AUTOPILOT, DIRECTED) or starts_over
        self.timer.leaps = leaps and not dive.shared

    def update(self, elapsed_s: float) -> None:
        """Begin or end a tour, `elapsed_s` after the last frame."""
        dive, ticks = self._dive, self._dive.tick_source
        self.active = active = dive.pilot.was_active()
        if active and not self._visited and ticks.has_pilot:
            self._visited = True
            self.visits += 1
        # A visitor who works with panels, paused time or films is not interrupted.
        busy = dive.inspector.open and not dive.menu.open
        busy |= dive.picture.pattern or dive.shots.filming or not ticks.has_pilot
        busy |= dive.timeline is not None and dive.timeline.paused
        what = self.timer.update(active, elapsed_s, not busy)
        if what == "end":
            ticks.set_tour(None)
            dive.overlay.greet()
            if dive.kiosk and dive.preferences.settings.kiosk.prompts:
                dive.introduction.prompt()
        elif what == "begin" or self._directions_over:
            self.begin()

    def begin(self) -> None:
        """Close what is open, and begin the tour, in the scenario of the start if that is asked."""
        dive = self._dive
        self._visited = False
        dive.logbook.book.forget_visit()
        dive.introduction.end()
        self._close_panels()
        if self._starts_over:
            dive.preferences.restore()
        if self._starts_over and not dive.shared:
            dive.picture.colours = "colours"
            dive.open_world(*self._start)
        dive.overlay.greet()  # the next visitor sees the help again
        if dive.shared:  # only ticks may move the submarine there, so it cannot be put elsewhere
            follows = self.name == DIRECTED and is_directed(dive.world.scenario)
            self._steer(self.name if follows else AUTOPILOT)
        else:
            self._steer(self.name)

    def start_item(
        self, tour: str | None, since_s: float, start: tuple[Scenario, Path, int | None] | None
    ) -> None:
        """Begin a tour of a show, `since_s` after its beginning; None: the pilot steers.

        Later tours begin in the scenario of the `start`; None: in the one of before.
        """
        dive = self._dive
        self._close_panels()
        self.name, self._start = tour or AUTOPILOT, start or self._start
        self.timer.idle_s, self.timer.touring = 0.0, False
        if tour is None:
            dive.pilot.reset()
            dive.tick_source.set_tour(None)
        else:
            self._visited = False
            self._steer(tour, since_s)
            self.timer.begin()
        dive.pilot.was_active()

    def start(self, name: str) -> None:
        """Begin a tour of this scenario for a presenter; a UserError if it is unknown.

        In a cluster only the autopilot and directions: other tours begin elsewhere.
        """
        check_tour(self._dive.world.scenario, name)
        if self._dive.shared and name not in (AUTOPILOT, DIRECTED):
            raise UserError(
                f"tour {name!r} begins elsewhere, but several computers show this dive: "
                f"expected {AUTOPILOT!r} or {DIRECTED!r}"
            )
        self._close_panels()
        self._steer(name)
        self.timer.begin()

    def stop(self) -> None:
        """End the tour, as input does."""
        self.timer.end()
        self._dive.tick_source.set_tour(None)

    def _close_panels(self) -> None:
        dive = self._dive
        if dive.menu.open:
            dive.menu.hide()
        if dive.inspector.open:
            dive.inspector.toggle()
        dive.ride_fish(None)

    def _steer(self, name: str, since_s: float = 0.0) -> None:
        dive = self._dive
        dive.pilot.reset()
        self.current = name
        dive.tick_source.set_tour(endless_tour(dive.world, name, since_s))
        if dive.timeline is not None:
            dive.timeline.touch()
            dive.timeline.run_at(1.0)

    @property
    def _directions_over(self) -> bool:
        """True if an idle dive that starts over has shown all of its directions."""
        dive = self._dive
        shows = self.timer.touring and self._starts_over and not dive.shared
        directed = self.name == DIRECTED and is_directed(dive.world.scenario)
        return shows and directed and is_over(dive.world)

    def draw(self) -> None:
        """Draw the fade to dark before a tour, and the invitation during it."""
        size, line, timer = imgui.get_io().display_size, imgui.get_font_size(), self.timer
        if timer.shade > 0.0:
            canvas = imgui.get_background_draw_list()
            canvas.add_rect_filled((0.0, 0.0), size, colour(DEEP, timer.shade))
        if timer.touring:
            breath = 0.5 - 0.5 * math.cos(math.tau * timer.toured_s / BREATH_S)
            place = size.x / 2, size.y - 4.0 * line
            invitation = translated("move the mouse to steer")
            draw_shadowed_text(place, invitation, 1.5 * line, INK, (0.25 + 0.6 * breath), 0.5)
