"""A dive: its windows, its world, and their frames."""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from typing import Any

from subsea.base.disk_cache import forget
from subsea.base.errors import UserError
from subsea.base.interrupts import deferred_interrupts
from subsea.base.language import marked, set_language, translated
from subsea.base.memory import give_back_memory
from subsea.base.progress import say
from subsea.base.restarts import RESTART
from subsea.dive.captions import Caption, FaultLog, caption_of, draw_caption
from subsea.dive.directed_camera import check_tour, endless_tour, is_cut
from subsea.dive.live_sound import LiveSound
from subsea.dive.options import DiveOptions
from subsea.dive.part import GOES_ON, DivePart, LostDisplayError
from subsea.dive.presented import NOTHING
from subsea.dive.ride import Ride
from subsea.dive.settings import Command, Settings
from subsea.dive.start import ready_world
from subsea.dive.tick_source import LocalTicks, TickSource, TickSourceMaker
from subsea.dive.timeline import RATES, Timeline
from subsea.frame.packet import make_scene
from subsea.jobs.background import CancelledByUserError, run_in_background
from subsea.media.screenshots import ScreenCapture, pictures_folder
from subsea.rendering.renderer import BakedScene, bake_scene
from subsea.scenario.load import LoadedScenario, load_scenario
from subsea.scenario.schema import Scenario
from subsea.scenario.shoals import find_fish, with_total
from subsea.scenario.storage import held
from subsea.sound.space import at_rest
from subsea.ui.commands import Commands
from subsea.ui.first_picture import FirstPicture, LoadingBar
from subsea.ui.fish_card import FishCard
from subsea.ui.gui import set_look
from subsea.ui.help_overlay import NOT_SHARED, HelpContent, help_content
from subsea.ui.idle_tours import IdleTours
from subsea.ui.inspector import Inspector
from subsea.ui.introduction import Introduction
from subsea.ui.logbook_keeper import LogbookKeeper
from subsea.ui.menu import Menu
from subsea.ui.open_windows import Opening, open_windows
from subsea.ui.overlay import Overlay
from subsea.ui.photo import PhotoMode
from subsea.ui.picture import ScenePicture
from subsea.ui.preferences import Preferences
from subsea.ui.text_layer import TextLayer
from subsea.ui.touch import TouchScreen
from subsea.view.rig import front
from subsea.world.build import check_placed, create_world
from subsea.world.levels import has_levels
from subsea.world.migrate import migrate
from subsea.world.world import World

BAR_S = 0.2  # between two pictures of the loading bar
YIELD_S = 0.001  # between two frames while a world is made


class Dive:
    """The windows, the pilot and the shown world."""

    def __init__(
        self,
        options: DiveOptions,
        opening: Opening | None = None,
        check: Callable[[], None] = lambda: None,
        loaded: LoadedScenario | None = None,
    ) -> None:
        """Open the windows before loading the world, so that something shows at once.

        The parts of the options are planned (`dive.part.planned`). `opening` has the windows, if
        they are open already. `check` is called while loading, and may raise. `loaded` is the
        scenario of the options, if it is loaded already. If anything fails, all that was opened is
        closed again.
        """
        display, settings = options.display, options.settings
        loaded = loaded or load_scenario(options.scenario, options.changes)
        self.scenario, self.source = with_total(loaded.scenario, options.fish), loaded.path
        self.known = held(self.source)
        set_language(settings.display.language)
        self.preferences = Preferences(settings, options.settings_file, self._follow)
        self.parts: list[DivePart] = [*options.parts]
        self.kiosk = options.kiosk
        self.see_brightness = options.see_brightness
        self.tick_source: TickSource
        self.overlay: Overlay
        installation, make_ticks = next(
            filter(None, (part.installation(options) for part in self.parts)), (None, LocalTicks)
        )
        self._make_ticks: TickSourceMaker = make_ticks
        self._in_front = installation is None or installation.in_front
        self._check = check
        self.shots = ScreenCapture(pictures_folder(settings.pictures.folder), self.note)
        self.records_text = settings.pictures.instruments  # in pictures and films
        self._loading = True
        self.changing = False  # True while the world's next state is made (`change_world`)
        self._passed_s = 0.0  # seconds since the last frame that other frames have shown
        self.pictures = 0  # of the sea, shown so far
        self.black = False  # True while a part keeps the screens black
        self.restarts = False  # True if the command starts again after the dive
        self.faults = FaultLog()
        tour = options.tour or settings.attract.tour
        opening = opening or open_windows(
            display.mode, display.size, display.fullscreen, settings, installation
        )
        self._shows_place = installation is None and display.mode == "mono"
        # Until the world is there.
        self._first = opening.first or self._place_picture(self.source, display.size)
        self._opening = opening._replace(first=self._first)
        self._bar, self._message, self._shown_s = LoadingBar(), "loading", 0.0
        self.window_set, self.gui, self.pilot = opening.window_set, opening.gui, opening.pilot
        self.window = self.window_set.front
        with ExitStack() as undo:
            undo.callback(opening.close)
            undo.callback(self._close_parts)
            speakers = installation and installation.loudspeakers
            self.sound = LiveSound(
                settings.sound, lambda text: self.overlay.note(text), self.faults.say, speakers
            )
            undo.callback(self.sound.close)
            self.overlay = Overlay(help_content(settings.bindings, settings.mouse.steer))
            undo.callback(lambda: self.preferences.keep(self.note))
            head = next(filter(None, (part.worn(self) for part in self.parts)), None)
            if head is not None:
                self.sound.head = head.pose
            self.picture = ScenePicture(self.window_set, opening.rig, display, head)
            undo.callback(self.picture.close)
            self.inspector, self.menu = Inspector(self), Menu(self, options.kiosk)
            undo.callback(self.menu.release)
            self.logbook = LogbookKeeper(self, settings.pictures.logbook, options.kiosk)
            self.introduction = Introduction(self)
            self.photo, self.card, self.touch = PhotoMode(self), FishCard(self), TouchScreen(self)
            undo.callback(self.photo.release)
            self.commands = Commands(self)
            self.text = TextLayer(self, settings)
            for part in self.parts:
                part.opened(self)
            start = self.scenario, self.source, options.seed
            self.world = self._load(*start)
            self._wait(marked("starting OpenGL"))
            self._of_world = ExitStack()  # closed when the world is replaced
            undo.callback(lambda: self._of_world.close())
            self._show_world(self.world, lambda: self._wait(None), options.tour)
            self._wait(None)
            self.overlay.help = self._help(settings)
            after_s = 60.0 * settings.attract.after_min
            self.tours = IdleTours(self, tour, after_s, start, options.kiosk)
            if options.tour is not None:
                self.tours.timer.begin()
            self._loading = False
            if self.logbook.fault:
                self.note_fault(self.logbook.fault)
            undo.callback(self.shots.end)
            undo.callback(self.inspector.close)
            for part in self.parts:
                part.begin(self)
            self._introduce(options)
            self._undo = undo.pop_all()

    def _introduce(self, options: DiveOptions) -> None:
        """Begin with an introduction, unless something else steers, or the settings say no."""
        settings, start = options.settings, options.start
        wanted = settings.display.introduction
        elsewhere = self.shared or not self.tick_source.has_pilot or self.kiosk
        elsewhere = elsewhere or self.tours.timer.touring or self.picture.head is not None
        if elsewhere or start.follow or start.eyes or start.pace is not None or wanted == "off":
            return
        returns = bool(self.logbook.book.entries)
        self.introduction.begin(short=returns or wanted == "short")

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
        if self.introduction.active:
            return self.introduction.caption
        if shown.caption:
            return Caption(shown.caption, shown.opacity)
        return caption_of(self.world, self.picture.alpha)

    @property
    def subtitle(self) -> Caption:
        """The caption on these windows: of several computers, those ahead of the audience."""
        shown = self._in_front or self.picture.text_panel is not None
        return self.caption if shown else Caption()

    def take_picture(self) -> None:
        """Save a picture of the next frame."""
        if self.photo.open:
            self.photo.take()
        else:
            self.shots.wanted = True

    def open_world(self, scenario: Scenario, source: Path, seed: int | None = None) -> bool:
        """Replace the world by that of a scenario; False, with a note, if it has a fault.

        `source` is the scenario's file.
        """
        self.tick_source.change()
        forget()
        try:
            world = self._load(scenario, source, seed)
        except UserError as fault:
            self.note_fault(str(fault))
            return False
        self.source = source
        self._replace(scenario, world)
        return True

    def change_world(self, scenario: Scenario) -> bool:
        """Change the scenario of the world: the submarine and everything alive stay, and time.

        The new world is made in a thread, and this one goes on until then, frame by frame. Call
        it between two frames. Raises a UserError, without effect, for a fault of the scenario.
        Returns False if the visitor left or opened another world meanwhile.
        """
        if self.changing:
            return False
        before, source, begun = self.world, str(self.source), time.perf_counter()
        seed, last = before.state.seed, begun

        def make(tell: Callable[[str], None]) -> tuple[World, BakedScene]:
            check_placed(scenario, source, seed)
            world = create_world(scenario, seed, source=source)
            world.levels = has_levels(scenario, world.state)
            return world, bake_scene(make_scene(world))

        def go_on(line: str | None) -> None:
            nonlocal last
            self._check()
            now = time.perf_counter()
            self.frame(now - last)
            last = now
            if not self.window_set.open or self.world is not before:
                raise CancelledByUserError

        self.changing = True
        try:
            world, baked = run_in_background(make, go_on, YIELD_S)
        except CancelledByUserError:
            return False
        finally:
            self.changing = False
            self._passed_s += last - begun
        migrate(before, world)
        world.notices.clear()  # a panel says what a change of the scenario does
        ride, timeline = self.picture.ride, self.timeline
        self.picture.keep_fishes()
        self._replace(scenario, world, baked)
        if ride is not None and ride.by.fish < len(world.state.fishes.alive):
            self.ride_fish(ride.by.fish)
        if timeline is not None and self.timeline is not None:
            self.timeline.run_at(timeline.rate)
            self.timeline.paused = timeline.paused
        return True

    def _replace(self, scenario: Scenario, world: World, baked: BakedScene | None = None) -> None:
        """Close the shown world, and show another one of a scenario."""
        self.photo.close()
        self.introduction.end()
        self.ride_fish(None)
        self._of_world.close()
        self.scenario = scenario
        self._show_world(world, baked=baked)

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
        elapsed_s, self._passed_s = max(elapsed_s - self._passed_s, 0.0), 0.0
        try:
            self._frame(elapsed_s)
            for part in self.parts:
                part.shown(self)
        except LostDisplayError as fault:
            self.picture.take_off()
            self.sound.head = at_rest
            self.note_fault(f"{fault}; {GOES_ON}")

    def restart(self) -> None:
        """End, and let the command start again."""
        self.restarts = True
        self.window.ask_to_close()

    def end(self) -> None:
        """End in order: nobody wants to see more."""
        for part in self.parts:
            part.end(self)

    def put_on(self, head: Any) -> None:
        """Go on in a display on the diver's head, which a part has found again."""
        self.picture.put_on(head)
        self.sound.head = head.pose

    def _frame(self, elapsed_s: float) -> None:
        start = time.perf_counter()
        commands = self.window_set.poll()
        if commands or self.pilot.held:
            self.introduction.skip()
        for command in commands:
            self.run_command(command)
        if not self.window_set.open:
            return
        for line in (*self.window_set.notes(), *self.world.notices):
            self.note(line)
        self.world.notices.clear()
        self.sound.check()
        black = [part.before(self, elapsed_s) for part in self.parts]
        self._set_overlays()
        measures = self.tick_source.presented.light is not None  # outside the hours, too
        self.black = any(black) and not measures
        if self.black:
            self.pilot.was_active()  # nobody sees where they steer
            self._present_black()
            return
        self.tours.update(elapsed_s)
        self.introduction.update(elapsed_s)
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
        for part in self.parts:
            part.ticked(self)
        picture, ride = self.picture, self.picture.ride
        presented = self.tick_source.presented
        picture.follow_pattern(presented.pattern, self.overlay.help_hidden)
        picture.follow_light(presented.light, self.overlay.help_hidden)
        picture.alpha = picture.alpha if alpha is None else alpha
        eye = self.photo.eye(elapsed_s) if self.photo.open else self.tick_source.eye()
        last_eye, picture.eye = picture.eye, eye
        if is_cut(last_eye, picture.eye, RATES[-1] * elapsed_s):
            picture.jump()
        if ride is not None:
            if not self.steers_fish:
                ride.turn_gaze(*self.pilot.gaze_rate, elapsed_s)
            if not self.world.state.fishes.alive[ride.by.fish]:
                self.ride_fish(None)
        picture.draw(self.overlay.help_hidden, self.inspector.chosen)
        if self._first is not None:
            self._first.keep(self.window_set.picture())
            self._first.release()
            self._first = None
        self.logbook.look(elapsed_s)
        if self.photo.open:
            self.photo.expose()
        if not self.records_text:
            self._record(elapsed_s, self.subtitle)
        self.text.draw(elapsed_s)
        if self.records_text:
            self._record(elapsed_s)
        if (blank := self.tick_source.presented.blank) > 0.0 and presented.light is None:
            picture.blacken(blank)
        for part in self.parts:
            part.after(self)
        picture.end(self.text.vignette.opacity)
        picture.adapt_quality(time.perf_counter() - start)
        if alpha is not None:
            self.tick_source.swap(picture.finish)
        self.window_set.present()
        self.pictures += 1
        self.inspector.end_frame()

    def show_message(self, text: str) -> None:
        """Fill the pilot's window with one line of text, over the first picture while loading."""
        blank = 0.0 if self._loading else self.tick_source.presented.blank
        if blank >= 1.0:
            self._present_black()
            return
        self._message = text
        self._bar.follow(text)
        words, colon, figures = text.partition(": ")
        text = translated(words) + colon + figures
        if self._first is not None and blank == 0.0:
            self._opening.show(text, self._bar.share)
            self._shown_s = time.monotonic()
            return
        self.text.message(text)
        self.picture.blacken(blank)
        self.window_set.present()

    def _set_overlays(self) -> None:
        """Lay what presenter and show want over the sea; a node shows what its master does."""
        if self.parts and self.tick_source.has_pilot:
            over = NOTHING
            for part in self.parts:
                over = part.over(over)
            self.tick_source.presented = over

    def _present_black(self) -> None:
        self.picture.blacken(1.0)
        self.window_set.present()
        self.pictures += 1

    def close(self) -> None:
        """Close everything, in the reverse order of opening."""
        self._close_parts()
        self._undo.close()

    def _close_parts(self) -> None:
        for part in self.parts:
            part.close()

    def _load(self, scenario: Scenario, source: Path, seed: int | None) -> World:
        """Make a world in a thread while the windows handle events."""
        loaded = LoadedScenario(scenario, source)
        if self._first is None:
            self._first, self._bar = self._place_picture(source, self.window.size), LoadingBar()
            self._opening = self._opening._replace(first=self._first)
        return run_in_background(
            lambda tell: ready_world(loaded, seed, tell, levels=True), self._wait
        )

    def _place_picture(self, source: Path, size: tuple[int, int]) -> FirstPicture | None:
        """The picture of a scenario's place for one flat window of that size."""
        if not self._shows_place:
            return None
        return FirstPicture(scenario=source, shape=size[0] / size[1])

    def _show_world(
        self, world: World, check: Callable[[], object] = lambda: None, tour: str | None = None,
        baked: BakedScene | None = None,
    ) -> None:  # fmt: skip
        """Draw and tick this world from now on, on a `tour` if one is named.

        `check` is called while loading, and may raise. `baked` is its scene, if there was time.
        """
        with ExitStack() as undo:
            self.picture.open_world(world, check, baked)
            undo.callback(self.picture.close_world)
            for part in self.parts:
                part.restore(world)
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
            self.card.clear()
            self._of_world = undo.pop_all()
        give_back_memory()  # of the world before, and what making this one took

    def _follow(self, settings: Settings) -> None:
        """Follow settings that a visitor changed."""
        self.pilot.settings, self.pilot.bindings = settings, settings.bindings
        self.text.set_comfort(settings.comfort)
        set_look(settings.display)
        self.overlay.help = self._help(settings)

    def _help(self, settings: Settings) -> HelpContent:
        """Return the help of this dive with these settings."""
        without, worn = NOT_SHARED if self.shared else (), self.picture.head is not None
        return help_content(settings.bindings, settings.mouse.steer, without, worn)

    def _close_ticks(self) -> None:
        for line in self.tick_source.close():
            say(line)

    def _record(self, elapsed_s: float, caption: Caption | None = None) -> None:
        """Save what is drawn so far, with a caption, if a picture or film was asked for."""
        if not (self.shots.wanted or self.shots.filming):
            return
        pixels = self.window_set.picture()
        if self.shots.wanted:
            self.logbook.photographed(pixels)
        if caption is not None and not self.picture.pattern:
            rig = self.picture.rig
            pixels = draw_caption(pixels, rig, front(rig).output, caption)
        self.shots.frame(pixels, elapsed_s)

    def _wait(self, message: str | None) -> None:
        """Handle events while loading and show a message; raise if the visitor leaves."""
        self._check()
        for part in self.parts:
            part.beat()
        if "leave" in (commands := self.window_set.poll()):
            self.window.ask_to_close()
        if not self.window_set.open or ("menu" in commands and self._loading and not self.kiosk):
            raise CancelledByUserError
        if message is not None:
            say(message)
            self.show_message(message)
        elif self._first is not None and time.monotonic() - self._shown_s > BAR_S:
            self.show_message(self._message)


def dive(options: DiveOptions, opening: Opening | None = None, notes: Sequence[str] = ()) -> int:
    """Dive until the window is closed, the menu says so, or the time is over; exit code 0.

    RESTART if a part wants the command to start again. The parts of the options are planned.
    `opening` is the windows, if they are open already.
    `notes` are lines to show at first.
    """
    start = options.start
    fish_name = start.follow if start.eyes is None else start.eyes
    # Report an unknown name before a window opens.
    loaded = load_scenario(options.scenario, options.changes)
    scenario = with_total(loaded.scenario, options.fish)
    fish = None if fish_name is None else find_fish(fish_name, scenario)
    if options.tour is not None or options.kiosk:
        check_tour(scenario, options.tour or options.settings.attract.tour)
    # An interrupt raised within compiled code or the window library could be lost.
    with suppress(CancelledByUserError), deferred_interrupts() as check:
        running = Dive(options, opening, check, loaded)
        for line in notes:
            running.overlay.note(line)
        with closing(running):
            if fish is not None:
                running.ride_fish(fish, behind=start.eyes is None)
                running.commands.start_ride(start.gaze, start.colours, start.teleop)
            if start.pace is not None:
                running.commands.set_pace(start.pace)
            begun = last = time.perf_counter()
            while running.window_set.open and (
                options.seconds is None or last - begun < options.seconds
            ):
                check()
                now = time.perf_counter()
                running.frame(now - last)
                last = now
            running.end()
            running.show_message(marked("closing"))  # it may take seconds, and a film is completed
        return RESTART if running.restarts else 0
    return 0
