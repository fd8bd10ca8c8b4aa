"""`subsea dive`: the submarine in a window."""

import time
from contextlib import ExitStack, closing

from subsea.app.clock import Clock
from subsea.app.console import say
from subsea.app.overlay import Overlay, one_page, panes
from subsea.app.pilot import Pilot
from subsea.app.start import start_world
from subsea.app.window import Window
from subsea.frame import make_scene, pack
from subsea.ocean import step
from subsea.render import Renderer, page_switch, window_context
from subsea.render.quality import LADDER, first_rung
from subsea.scenario import load_scenario
from subsea.view.rigs import cockpit, views_for
from subsea.view.stereo import EYES, PAGED, Stereo
from subsea.view.surround import ALL_ROUND, Surround
from subsea.world import TICK_S


def dive(
    scenario: str,
    display: str,
    stereo: Stereo,
    surround: Surround,
    size: tuple[int, int],
    fullscreen: bool,
    seed: int | None,
    seconds: float | None,
) -> int:
    """Dive until the window is closed, Esc is pressed, or `seconds` have passed; exit code 0."""
    with closing(Dive(scenario, display, size, fullscreen, seed, stereo, surround)) as running:
        start = last = time.perf_counter()
        while running.window.open and (seconds is None or last - start < seconds):
            now = time.perf_counter()
            running.frame(now - last)
            last = now
    return 0


class Dive:
    """A window, its pilot, and the world that they are in."""

    def __init__(
        self,
        scenario: str,
        display: str,
        size: tuple[int, int],
        fullscreen: bool = False,
        seed: int | None = None,
        stereo: Stereo = EYES,
        surround: Surround = ALL_ROUND,
    ) -> None:
        """Open the window, then the world: the visitor sees at once that something happens.

        Whatever fails, all that was opened is closed again.
        """
        load_scenario(scenario)  # a misspelt name is told before a window flashes up
        self.display, self._stereo, self._surround = display, stereo, surround
        self.pilot = Pilot()
        self._clock = Clock(TICK_S)
        self._help_wanted = 0
        with ExitStack() as undo:
            self.window = Window("subsea", size, fullscreen, self.pilot, paged=display == PAGED)
            undo.callback(self.window.close)
            self.overlay = Overlay(self.window.handle)
            undo.callback(self.overlay.close)
            self.world = start_world(scenario, seed, tell=self._tell)
            self._tell("starting OpenGL")
            self._context = window_context(self.window.get_proc_address)
            self._size = self.window.size
            page = page_switch(self.window.get_proc_address) if display == PAGED else one_page
            self._renderer = Renderer(
                self._context,
                make_scene(self.world),
                self._size,
                LADDER[first_rung(self._context.info["GL_RENDERER"])],
                display=display,
                surround=surround,
                page=page,
            )
            self._panes = panes(display, page)
            undo.callback(self._renderer.release)
            self._undo = undo.pop_all()

    def frame(self, elapsed_s: float) -> None:
        """One picture, `elapsed_s` after the last: events, due ticks, drawing, presenting."""
        self.window.poll()
        if self.window.help_wanted != self._help_wanted:
            self._help_wanted = self.window.help_wanted
            self.overlay.toggle_help()
        for _ in range(self._clock.advance(elapsed_s)):
            step(self.world, self.pilot.helm(TICK_S))
        if self.window.size != self._size:
            self._size = self.window.size
            self._renderer.resize(self._size)
        submarine, alpha = self.world.state.submarine, self._clock.alpha
        observer = cockpit(submarine, alpha)
        views = views_for(self.display, self._size, observer, self._stereo, self._surround)
        self._renderer.draw(pack(self.world, views, alpha), into=self._context.screen)
        throttle, stopping = self.pilot.throttle, self.pilot.stopping
        scale = self.window.text_scale
        self.overlay.draw(submarine, throttle, stopping, elapsed_s, scale, self._panes)
        self.window.present()

    def close(self) -> None:
        """Close everything in the reverse order of its opening."""
        self._undo.close()

    def _tell(self, message: str) -> None:
        """Say it on the terminal and in the window."""
        say(message)
        self.window.poll()
        self.overlay.message(message, self.window.text_scale)
        self.window.present()
