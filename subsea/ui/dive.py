"""A dive: its windows, its world, and their frames."""

import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from subsea.base.errors import UserError
from subsea.base.language import marked, set_language, translated
from subsea.base.progress import say
from subsea.dive.captions import Caption, FaultLog, caption_of, draw_caption
from subsea.dive.directed_camera import endless_tour, is_cut
from subsea.dive.live_sound import LiveSound
from subsea.dive.options import DiveOptions
from subsea.dive.presented import NOTHING
from subsea.dive.ride import Ride
from subsea.dive.settings import Command, kiosk_settings
from subsea.dive.tick_source import LocalTicks, TickSource, TickSourceMaker
from subsea.dive.timeline import RATES, Timeline
from subsea.jobs.background import CancelledByUserError
from subsea.media.screenshots import ScreenCapture, pictures_folder
from subsea.scenario.load import load_scenario
from subsea.scenario.schema import Scenario
from subsea.scenario.shoals import with_total
from subsea.scenario.storage import held
from subsea.sound.space import at_rest
from subsea.stage.headset.controllers import HeadsetLostError
from subsea.stage.headset.display import GOES_ON, HeadsetDisplay, LostHeadset, put_on
from subsea.stage.kiosk import Kiosk
from subsea.stage.show_player import ShowScreens
from subsea.ui.commands import Commands
from subsea.ui.first_picture import Loader
from subsea.ui.help_overlay import help_content
from subsea.ui.idle_tours import IdleTours
from subsea.ui.inspector import Inspector
from subsea.ui.menu import Menu
from subsea.ui.monitors import Installation
from subsea.ui.open_windows import Opening, open_windows
from subsea.ui.overlay import Overlay
from subsea.ui.picture import ScenePicture
from subsea.ui.preferences import Preferences, follow, help_of
from subsea.ui.text_layer import TextLayer
from subsea.view.display_rigs import HEADSET, cockpit
from subsea.view.rig import front
from subsea.world.build import create_world
from subsea.world.migrate import migrate
from subsea.world.world import World

if TYPE_CHECKING:  # loaded only for a console
    from subsea.stage.console.remote_control import RemoteControl


class Dive:
    """The windows, the pilot and the shown world."""

    def __init__(
        self,
        options: DiveOptions,
        installation: Installation | None = None,
        make_ticks: TickSourceMaker = LocalTicks,
        opening: Opening | None = None,
        check: Callable[[], None] = lambda: None,
        show: ShowScreens | None = None,
    ) -> None:
        """Open the windows before loading the world, so that something shows at once.

        The rig and the windows are those of the `installation`, else one window. `check` is called
        while loading, and may raise. If anything fails, all that was opened is closed again.
        """
        display, settings = options.display, options.settings
        scenario, self.source, _ = load_scenario(options.scenario, options.changes)
        self.scenario = with_total(scenario, options.fish)
        self.known = held(self.source)
        if options.kiosk:
            settings, display = kiosk_settings(settings), replace(display, fullscreen=True)
        set_language(settings.display.language)
        self.preferences = Preferences(settings, options.settings_file, partial(follow, self))
        self.show = show
        self.see_brightness = options.see_brightness
        self.tick_source: TickSource
        self.overlay: Overlay
        self._make_ticks, self._check = make_ticks, check
        self.shots = ScreenCapture(pictures_folder(settings.pictures.folder), self.note)
        self.records_text = settings.pictures.instruments  # in pictures and films
        self._loading, self._loader = True, Loader(self._wait)
        self.pictures = 0  # of the sea, shown so far
        self.faults = FaultLog()
        self.remote: RemoteControl | None = None  # the presenter's, if a console is open
        tour = options.tour or settings.attract.tour
        opening = opening or open_windows(
            display.mode, display.size, display.fullscreen, settings, installation
        )
        self._opening, self._first = opening, opening.first  # until the world is there
        self.window_set, self.gui, self.pilot = opening.window_set, opening.gui, opening.pilot
        self.window = self.window_set.front
        with ExitStack() as undo:
            undo.callback(opening.close)
            speakers = installation and installation.loudspeakers
            self.sound = LiveSound(
                settings.sound, lambda text: self.overlay.note(text), self.faults.say, speakers
            )
            undo.callback(self.sound.close)
            self.overlay = Overlay(help_content(settings.bindings, settings.mouse.steer))
            undo.callback(lambda: self.preferences.keep(self.note))
            head = None
            self._lost_headset = LostHeadset(options.kiosk and display.mode == HEADSET)
            if display.mode == HEADSET:
                try:
                    head = self._put_on()
                except UserError as fault:
                    self.note(f"{fault}; {GOES_ON}")
            self.picture = ScenePicture(self.window_set, opening.rig, display, head)
            undo.callback(self.picture.close)
            self.inspector, self.menu = Inspector(self), Menu(self, options.kiosk)
            undo.callback(self.menu.release)
            self.commands = Commands(self, self.menu, self.inspector)
            self.text = TextLayer(self, settings, self.menu, self.inspector)
            self._kiosk = Kiosk(self.window_set.windows) if options.kiosk else None
            start = self.scenario, self.source, options.seed
            self.world = self._loader.create(*start)
            self._wait(marked("starting OpenGL"))
            self._of_world = ExitStack()  # closed when the world is replaced
            undo.callback(lambda: self._of_world.close())
            self._show_world(self.world, lambda: self._wait(None), options.tour)
            self._wait(None)
            self.overlay.help = help_of(self, settings)
            after_s = 60.0 * settings.attract.after_min
            self.tours = IdleTours(self, tour, after_s, start, self._kiosk)
            if options.tour is not None:
                self.tours.timer.begin()
            self._loading, self._first = False, None
            if show is not None:
                undo.callback(show.close)
            undo.callback(self.shots.end)
            undo.callback(self.inspector.close)
            self._undo = undo.pop_all()

    @property
    def timeline(self) -> Timeline | None:
        """The time of the world; None if another computer controls it."""
        return self.tick_source.timeline

    @property
    def shared(self) -> bool:
        """True if other computers show the same dive, so that nothing here may change it."""
        return self.tick_source.shared

    @property
    def steers_fish(self) -> bool:
        """True if the pilot steers the ridden fish."""
        return self.tick_source.steered_fish is not None

    def run_command(self, command: Command) -> None:
        """Run the command as a key bound to it does."""
        self.commands.run(command)

    def note(self, text: str) -> None:
        """Show a line on the terminal, and for a while in the window."""
        say(text)
        self.overlay.note(text)

    def note_fault(self, text: str) -> None:
        """Note a fault after which the dive goes on, for its presenter too."""
        self.note(text)
        self.faults.add(text)

    @property
    def caption(self) -> Caption:
        """The caption of this picture: of presenter or show, else of the directions."""
        shown = self.tick_source.presented
        if shown.caption:
            return Caption(shown.caption, shown.opacity)
        return caption_of(self.world, self.picture.alpha)

    def take_picture(self) -> None:
        """Save a picture of the next frame."""
        self.shots.wanted = True

    def open_world(
        self, scenario: Scenario, source: Path, seed: int | None = None, keep: bool = False
    ) -> bool:
        """Replace the world by that of a scenario; False, with a note, if it has a fault.

        `source` is the scenario's file. With `keep` the submarine and everything alive go on from
        where they are (`world.migrate.migrate`), and so does time.
        """
        before, ride, time = self.world, self.picture.ride, self.timeline
        try:
            if keep:
                world = create_world(scenario, seed, source=str(source))
                migrate(before, world)
            else:
                world = self._loader.create(scenario, source, seed)
        except UserError as fault:
            self.note_fault(str(fault))
            return False
        self.ride_fish(None)
        self._of_world.close()
        self.scenario, self.source = scenario, source
        self._show_world(world)
        if keep and ride is not None and ride.by.fish < len(world.state.fishes.alive):
            self.ride_fish(ride.by.fish)
        if keep and time is not None and self.timeline is not None:
            self.timeline.run_at(time.rate)
            self.timeline.paused = time.paused
        return True

    def ride_fish(self, fish: int | None, behind: bool | None = None) -> None:
        """Ride a fish from now on; None: return to the submarine.

        Look through its eyes, or from `behind`; None: as on the last ride.
        """
        if behind is None:
            behind = self.picture.ride is not None and self.picture.ride.behind
        self.picture.ride = None if fish is None else Ride(self.world, fish, behind)
        self.inspector.chosen = self.inspector.chosen if fish is None else fish
        self.tick_source.steered_fish = None
        self.world.seen_light.clear()
        self.sound.fish = fish
        self.pilot.set_riding(self.picture.ride is not None)
        self.picture.jump()
        self.picture.arrange(self.overlay.help_hidden)

    def frame(self, elapsed_s: float) -> None:
        """One picture, `elapsed_s` after the last: events, due ticks, drawing, presenting."""
        try:
            self._frame(elapsed_s)
        except HeadsetLostError as fault:
            self.picture.take_off()
            self.sound.head = at_rest
            self.note_fault(f"{fault}; {GOES_ON}")

    def _put_on(self) -> HeadsetDisplay:
        head = put_on(self.window_set, self.gui, self.note)
        self.sound.head = head.pose
        return head

    def _frame(self, elapsed_s: float) -> None:
        if self._lost_headset.due(elapsed_s, self.picture.head is not None):
            with suppress(UserError):
                self.picture.put_on(self._put_on())
        start = time.perf_counter()
        for command in self.window_set.poll():
            self.run_command(command)
        if not self.window_set.open:
            return
        for line in (*self.window_set.notes(), *self.world.notices):
            self.note(line)
        self.world.notices.clear()
        self.sound.check()
        if self.remote is not None:
            self.remote.update(elapsed_s)
        if self.show is not None:
            self.show.update(self, elapsed_s)
            if self.show.rest(self):
                self.pilot.was_active()  # nobody sees where they steer
                self._present_black()
                return
        self._set_overlays()
        self.tours.update(elapsed_s)
        if self.menu.open:
            self.pilot.full_stop()  # arrows choose entries there
        if self.see_brightness:
            self.picture.see_light()
        before = self.world.state.tick
        alpha = self.tick_source.advance(elapsed_s)
        if self.world.state.tick < before:
            self.picture.jump()
        if alpha is None and not self.tick_source.waiting:
            return  # nothing new to draw
        start += self.tick_source.idle_s
        picture, ride = self.picture, self.picture.ride
        picture.follow_pattern(self.tick_source.presented.pattern, self.overlay.help_hidden)
        picture.alpha = picture.alpha if alpha is None else alpha
        last_eye, picture.eye = picture.eye, self.tick_source.eye()
        if is_cut(last_eye, picture.eye, RATES[-1] * elapsed_s):
            picture.jump()
        if ride is not None:
            if not self.steers_fish:
                ride.turn_gaze(*self.pilot.gaze_rate, elapsed_s)
            if not self.world.state.fishes.alive[ride.by.fish]:
                self.ride_fish(None)
        picture.draw(self.overlay.help_hidden, self.inspector.chosen)
        if not self.records_text:
            self._record(elapsed_s, self.caption)
        self.text.draw(elapsed_s, self.tours)
        if self.records_text:
            self._record(elapsed_s)
        if (blank := self.tick_source.presented.blank) > 0.0:
            picture.blacken(blank)
        if self.remote is not None:
            self.remote.look()
        picture.end(self.text.vignette.opacity)
        picture.adapt_quality(time.perf_counter() - start)
        if alpha is not None:
            self.tick_source.swap(picture.finish)
        self.window_set.present()
        self.pictures += 1
        self.inspector.end_frame()

    def show_message(self, text: str) -> None:
        """Fill the pilot's window with one line of text, or write it under a world at rest."""
        first = self._first
        blank = 0.0 if self._loading else self.tick_source.presented.blank
        if blank >= 1.0:
            self._present_black()
            return
        words, colon, figures = text.partition(": ")
        text = translated(words) + colon + figures
        if self._loader.at_rest:
            self.picture.draw(clear=False, chosen=None)
            if first is not None:
                first.keep(self.window_set.picture)
        elif first is not None and first.known:
            self._opening.show(text)
            return
        self.text.message(text, fill=not self._loader.at_rest)
        self.picture.blacken(blank)
        self.window_set.present()

    def _set_overlays(self) -> None:
        """Lay what presenter and show want over the sea; a node shows what its master does."""
        if self.remote is not None or self.show is not None:
            over = NOTHING if self.remote is None else self.remote.presented
            self.tick_source.presented = over if self.show is None else self.show.under(over)

    def _present_black(self) -> None:
        self.picture.blacken(1.0)
        self.window_set.present()
        self.pictures += 1

    def close(self) -> None:
        """Close everything, in the reverse order of opening."""
        if self.remote is not None:
            self.remote.close()
        self._undo.close()

    def _show_world(
        self, world: World, check: Callable[[], object] = lambda: None, tour: str | None = None
    ) -> None:
        """Draw and tick this world from now on, on a `tour` if one is named.

        `check` is called while loading, and may raise.
        """
        with ExitStack() as undo:
            self.picture.open_world(world, check)
            undo.callback(self.picture.close_world)
            if world.state.tick == 0:
                self.picture.eye = cockpit(world.state.submarine, 1.0)
                self._loader.wake(world)
            self.tick_source = self._make_ticks(world, self.pilot)
            undo.callback(self._close_ticks)
            self._set_overlays()
            self.tick_source.offer(self.source)
            self.tick_source.resume(check)
            if tour is not None:
                # Before other computers join: a tour puts the submarine at its beginning.
                self.tick_source.set_tour(endless_tour(world, tour))
                if self.timeline is not None:
                    self.timeline.touch()
            self.world = world
            self.sound.fish = None
            self.sound.attend(world)
            self.picture.eye = self.tick_source.eye()
            self.inspector.reset()
            self._of_world = undo.pop_all()

    def _close_ticks(self) -> None:
        for line in self.tick_source.close():
            say(line)

    def _record(self, elapsed_s: float, caption: Caption | None = None) -> None:
        """Save what is drawn so far, with a caption, if a picture or film was asked for."""
        if not (self.shots.wanted or self.shots.filming):
            return
        pixels = self.window_set.picture()
        if caption is not None and not self.picture.pattern:
            rig = self.picture.rig
            pixels = draw_caption(pixels, rig, front(rig).output, caption)
        self.shots.frame(pixels, elapsed_s)

    def _wait(self, message: str | None) -> None:
        """Handle events while loading and show a message; raise if the visitor leaves."""
        self._check()
        if self.remote is not None:
            self.remote.beat()
        if "leave" in (commands := self.window_set.poll()):
            self.window.ask_to_close()
        if not self.window_set.open or (
            "menu" in commands and self._loading and self._kiosk is None
        ):
            raise CancelledByUserError
        if message is not None:
            say(message)
            self.show_message(message)
