"""When nobody is there: a tour takes the submarine along, until a hand does anything."""

import math
from collections.abc import Callable
from typing import Literal

from imgui_bundle import imgui

from subsea.dive.directed_camera import directed, is_directed, is_over
from subsea.dive.tour import Steer, Tour
from subsea.scenario.schema import DIRECTED
from subsea.submarine.course import course_of, rail_at
from subsea.submarine.helm import Helm
from subsea.submarine.rail import Rail, board
from subsea.ui.gui import DEEP, INK, colour, shadowed
from subsea.world.world import TICK_S, World

DIP_S = 1.0  # in which the picture goes dark before a tour that begins elsewhere, and comes back
BREATH_S = 5.0  # the invitation comes and goes so slowly
INVITATION = "move the mouse to steer"


class Attract:
    """Whether a tour goes on, and when the next one begins."""

    def __init__(self, after_s: float, leaps: bool) -> None:
        """After so long without input, 0: never; tours that `leap` begin elsewhere, in the dark."""
        self.after_s, self.leaps = after_s, leaps
        self.touring = False
        self.shade = 0.0  # how dark the picture is
        self._idle_s = 0.0
        self._toured_s = 0.0

    def begin(self) -> None:
        """A tour goes on from now on."""
        self.touring, self._toured_s = True, 0.0

    def look(self, stirred: bool, dt: float, may: bool = True) -> Literal["begin", "end"] | None:
        """`dt` later a hand has `stirred`, or not: what is to be done. A tour `may` begin now."""
        if stirred:
            self._idle_s = 0.0
        else:
            self._idle_s += dt
        self._toured_s += dt
        if stirred and self.touring:
            self.touring = False
            return "end"
        due = may and not self.touring and 0.0 < self.after_s <= self._idle_s
        dark = due and self.leaps
        self.shade = min(max(self.shade + (dt if dark else -dt) / DIP_S, 0.0), 1.0)
        if due and (not self.leaps or self.shade == 1.0):
            self.begin()
            return "begin"
        return None

    def draw(self) -> None:
        """The dark before a tour, and during it the invitation, in the present frame."""
        size, line = imgui.get_io().display_size, imgui.get_font_size()
        canvas = imgui.get_background_draw_list()
        if self.shade > 0.0:
            canvas.add_rect_filled((0.0, 0.0), size, colour(DEEP, self.shade))
        if self.touring:
            breath = 0.5 - 0.5 * math.cos(math.tau * self._toured_s / BREATH_S)
            place = size.x / 2, size.y - 4.0 * line
            shadowed(place, INVITATION, 1.5 * line, INK, (0.25 + 0.6 * breath), 0.5)


def tour_named(name: str) -> Callable[[World], Steer]:
    """Who takes the submarine along in whatever world: the tour of that name, or the autopilot.

    The tour begins at once, at its beginning; that of the directions as far as these are. The
    autopilot goes on where one has ended, and takes over where a scenario has none of that name.
    """

    def taken(world: World) -> Steer:
        if name == DIRECTED and is_directed(world.scenario):
            show, later = directed(world), Tour()
            return lambda world: later.helm(world) if is_over(world) else show(world)
        if name not in {tour.name for tour in world.scenario.tour}:
            return Tour().helm
        course, after = course_of(world.scenario, name), Tour()
        first, start = world.state.tick, rail_at(course, world.state, 0.0)
        board(world.state.submarine, start, start)

        def steer(world: World) -> Helm | Rail:
            t = (world.state.tick + 1 - first) * TICK_S
            over = not course.curve.loop and t > course.seconds
            return after.helm(world) if over else rail_at(course, world.state, t)

        return steer

    return taken
