"""`subsea dive`: the submarine in a window."""

import time
from contextlib import ExitStack, closing

from subsea.app import pacing
from subsea.app.clock import Clock
from subsea.app.console import say
from subsea.app.overlay import Overlay, one_page, panes
from subsea.app.pilot import Pilot
from subsea.app.start import start_world
from subsea.app.window import Window
from subsea.frame import make_scene, pack
from subsea.ocean import step
from subsea.render import Renderer, page_switch, window_context
from subsea.render.quality import AUTO, CHOICES, LADDER, PRESETS, Quality, first_rung, name_of
from subsea.scenario import load_scenario
from subsea.view.levels import nothing_drawn
from subsea.view.rig import Rig, views
from subsea.view.rigs import cockpit, display_rig
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
    quality: str,
    target_ms: float | None,
) -> int:
    """Dive until the window is closed, Esc is pressed, or `seconds` have passed; exit code 0."""
    with closing(
        Dive(scenario, display, size, fullscreen, seed, stereo, surround, quality, target_ms)
    ) as running:
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
        quality: str = AUTO,
        target_ms: float | None = None,
    ) -> None:
        """Open the window, then the world: the visitor sees at once that something happens.

        `quality` is one of `render.quality.CHOICES`; "auto" holds `target_ms`, None: what the
        renderer suggests. Whatever fails, all that was opened is closed again.
        """
        load_scenario(scenario)  # a misspelt name is told before a window flashes up
        self.display, self._stereo, self._surround = display, stereo, surround
        self.pilot = Pilot()
        self._clock = Clock(TICK_S)
        self._help_wanted = self._quality_wanted = 0
        self._quality = quality
        with ExitStack() as undo:
            self.window = Window("subsea", size, fullscreen, self.pilot, paged=display == PAGED)
            undo.callback(self.window.close)
            self.overlay = Overlay(self.window.handle)
            undo.callback(self.overlay.close)
            self.world = start_world(scenario, seed, tell=self._tell)
            self._tell("starting OpenGL")
            self._context = window_context(self.window.get_proc_address)
            self._size = self.window.size
            renderer = self._context.info["GL_RENDERER"]
            self._target_ms = target_ms or pacing.target_for(renderer)
            self._rig = self._make_rig()
            self._pace = pacing.start(first_rung(renderer), self._rig.exact)
            self._page = page_switch(self.window.get_proc_address) if display == PAGED else one_page
            self._renderer = Renderer(
                self._context,
                make_scene(self.world),
                self._rig,
                self._chosen(),
                self._page,
            )
            self._memory = nothing_drawn(len(self.world.state.fishes.species))
            undo.callback(self._renderer.release)
            self._undo = undo.pop_all()

    def frame(self, elapsed_s: float) -> None:
        """One picture, `elapsed_s` after the last: events, due ticks, drawing, presenting."""
        start = time.perf_counter()
        self.window.poll()
        if self.window.help_wanted != self._help_wanted:
            self._help_wanted = self.window.help_wanted
            self.overlay.toggle_help()
        if self.window.quality_wanted != self._quality_wanted:
            self._quality_wanted = self.window.quality_wanted
            self._quality = CHOICES[(CHOICES.index(self._quality) + 1) % len(CHOICES)]
            self._pace = pacing.resumed(self._pace)
            self._renderer.adapt(self._chosen())
            self.overlay.show_quality()
        for _ in range(self._clock.advance(elapsed_s)):
            step(self.world, self.pilot.helm(TICK_S))
        if self.window.size != self._size:
            self._size = self.window.size
            self._rig = self._make_rig()
            self._renderer.arrange(self._rig)
        submarine, alpha = self.world.state.submarine, self._clock.alpha
        observer = cockpit(submarine, alpha)
        quality = self._renderer.quality
        packet = pack(
            self.world, views(self._rig, observer), alpha,
            detail=quality.detail, growth=quality.growth, memory=self._memory,
        )  # fmt: skip
        self._renderer.draw(packet, into=self._context.screen)
        throttle, stopping = self.pilot.throttle, self.pilot.stopping
        scale = self.window.text_scale
        self.overlay.draw(
            submarine,
            throttle,
            stopping,
            elapsed_s,
            scale,
            panes(self._rig, self._page),
            self.quality,
        )
        if self._quality == AUTO:
            self._context.finish()  # the time of the picture, without waiting for the display
            self._pace = pacing.paced(
                self._pace, 1000.0 * (time.perf_counter() - start), self._target_ms
            )
            if self._chosen() != self._renderer.quality:
                self._renderer.adapt(self._chosen())
        self.window.present()

    @property
    def quality(self) -> str:
        """How the picture is drawn, in words."""
        name = name_of(self._renderer.quality)
        return f"picture {name}" if self._quality != AUTO else f"picture auto: {name}"

    def _make_rig(self) -> Rig:
        return display_rig(self.display, self._size, self._stereo, self._surround)

    def _chosen(self) -> Quality:
        return LADDER[self._pace.rung] if self._quality == AUTO else PRESETS[self._quality]

    def close(self) -> None:
        """Close everything in the reverse order of its opening."""
        self._undo.close()

    def _tell(self, message: str) -> None:
        """Say it on the terminal and in the window."""
        say(message)
        self.window.poll()
        self.overlay.message(message, self.window.text_scale)
        self.window.present()
