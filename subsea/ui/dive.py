"""`subsea dive`: the submarine in a window, or in several."""

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing, suppress
from dataclasses import replace
from pathlib import Path

from subsea.core.background import LeftError, meanwhile
from subsea.core.console import say
from subsea.core.errors import UserError
from subsea.core.interrupts import deferred
from subsea.dive.bindings import Meaning, Wish
from subsea.dive.captions import caption_of
from subsea.dive.directed_camera import check_tour, is_directed, is_over, leapt
from subsea.dive.options import (
    DisplayOptions,
    DiveOptions,
    RetinaColours,
    TheatreOptions,
)
from subsea.dive.pilot import Pilot
from subsea.dive.ride import Ride, nearest_to_middle
from subsea.dive.start import awake
from subsea.dive.tick_source import Alone, Crew, muster
from subsea.dive.timeline import RATES, Timeline
from subsea.dive.tour import guide
from subsea.media.screenshots import Shots, pictures_folder
from subsea.scenario.fish_lookup import find_fish
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario, load_scenario
from subsea.scenario.storage import held
from subsea.ui import subtitles
from subsea.ui.attract import Attract, tour_named
from subsea.ui.comfort import Vignette, draw_horizon
from subsea.ui.help_overlay import sign_of
from subsea.ui.hud import reading
from subsea.ui.inspector import Desk
from subsea.ui.kiosk import Kiosk, locked
from subsea.ui.labels import letter
from subsea.ui.menu import Menu
from subsea.ui.monitors import Installation, Screen
from subsea.ui.open_windows import Opening, opened
from subsea.ui.overlay import Overlay
from subsea.ui.picture import Picture
from subsea.ui.window import Window
from subsea.view.retina import Gaze
from subsea.view.unproject import front_view
from subsea.world.migrate import carry
from subsea.world.world import World, create_world

SHARED_TIME = "several computers show this dive: its time goes on"
# What is granted while the menu is open.
BESIDE_MENU: tuple[Wish, ...] = ("fullscreen", "leave", "picture", "film")


def dive(options: DiveOptions, opening: Opening | None = None, notes: Sequence[str] = ()) -> int:
    """Dive until the window is closed, the menu says so, or the time is over; exit code 0.

    `opening` is the windows, if they are open already. `notes` are lines to show at first.
    """
    theatre, start, kiosk = options.theatre, options.start, options.kiosk
    if options.see_brightness and theatre is not None and theatre.node is not None:
        raise UserError("--see-brightness is for one computer: others would not see the same light")
    fish_name = start.follow if start.eyes is None else start.eyes
    if theatre is not None and theatre.node is not None and (fish_name or start.pace is not None):
        option = "--follow" if start.follow else "--eyes" if start.eyes else "--pace"
        raise UserError(f"{option} is for one computer: others would not go along")
    fish = None
    if fish_name is not None or options.tour is not None or kiosk:
        # Report an unknown name before a window opens.
        scenario = load_scenario(options.scenario, options.changes)[0]
        fish = None if fish_name is None else find_fish(fish_name, scenario)
        if options.tour is not None or kiosk:
            check_tour(scenario, options.tour or options.settings.attract.tour)
    installation: Installation | None = None
    crew: Callable[[World, Pilot], Crew] = Alone
    if theatre is not None:
        installation, crew = _in_theatre(theatre, options.display)
    # Raised in the midst of compiled code or of the window library an interrupt may be lost.
    with suppress(LeftError), deferred() as check:
        running = Dive(options, installation, crew, opening, check)
        if kiosk:
            say(f"a kiosk: {options.settings.kiosk.leave} leaves it, in its window")
        for line in notes:
            running.overlay.note(line)
        with closing(running):
            if fish is not None:
                running.mount(fish, behind=start.eyes is None)
                running.show_ride(start.gaze, start.colours, start.teleop)
            if start.pace is not None:
                running.go_at(start.pace)
            begun = last = time.perf_counter()
            while running.wall.open and (options.seconds is None or last - begun < options.seconds):
                check()
                now = time.perf_counter()
                running.frame(now - last)
                last = now
    return 0


def _in_theatre(
    theatre: TheatreOptions, display: DisplayOptions
) -> tuple[Installation, Callable[[World, Pilot], Crew]]:
    """The rig and windows of a theatre, and what makes the source of ticks."""
    from subsea.dive.theatre_setup import open_house, told

    house = open_house(theatre.name, display.mode, display.stereo, theatre.node, theatre.shrink)
    view = ""
    if theatre.node is not None:  # computers may differ in pixels, and in which eye is which
        view = repr((told(theatre.name), display.mode, display.stereo._replace(swapped=False)))
    crew = muster(house.theatre, house.path, theatre.node, view)
    screens = [
        Screen(window.name, window.size, window.position, window.monitor)
        for window in house.windows
    ]
    return Installation(house.rig, screens, str(house.path)), crew


class Dive:
    """The windows, the pilot, and the world that they are in."""

    def __init__(
        self,
        options: DiveOptions,
        installation: Installation | None = None,
        crew: Callable[[World, Pilot], Crew] = Alone,
        opening: Opening | None = None,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        """Open the windows, then the world: the visitor sees at once that something happens.

        The rig and the windows are those of the `installation`, else one window. `crew` makes what
        makes the ticks. `check` is called while loading, and may raise. If anything fails, all
        that was opened is closed again.
        """
        display, settings = options.display, options.settings
        seed, kiosk = options.seed, options.kiosk
        # Report an unknown name before a window opens.
        self.scenario, self.source = load_scenario(options.scenario, options.changes)
        self.known = held(self.source)
        if kiosk:
            settings, display = locked(settings), replace(display, fullscreen=True)
        self._crew_of = crew
        self._crew: Crew
        self._grants: dict[Wish, Callable[[], None]] = {
            "help": self._show_help,
            "desk": self._open_desk,
            "ride": self._ride_one,
            "alight": lambda: self.mount(None),
            "look": lambda: self.picture.look_otherwise(),
            "follow": self._follow_one,
            "reins": self._take_reins,
            "pause": lambda: self._have_time(Timeline.pause),
            "slower": lambda: self._have_time(Timeline.slower),
            "faster": lambda: self._have_time(Timeline.faster),
            "tick": lambda: self._have_time(Timeline.single),
            "rewind": lambda: self._have_time(Timeline.rewind),
            "pattern": self._show_pattern,
            "quality": self._choose_quality,
            "lights": self._switch_lights,
            "picture": self._want_picture,
            "film": lambda: self._shots.film(self.window.size),
            "instruments": lambda: self.overlay.note(f"instruments: {self.overlay.hud.turn()}"),
            "fullscreen": self.fill_screen,
            "menu": self._open_menu,
            "leave": self.leave,
        }
        self._shots = Shots(pictures_folder(settings.pictures.folder), self.note)
        self._wants_picture = False
        self._settings, self._vignette = settings, Vignette(settings.comfort.vignette)
        self._at_first = self.scenario, self.source, seed
        self._tour = options.tour or settings.attract.tour
        self._taken = tour_named(self._tour)
        self.attract = Attract(60.0 * settings.attract.after_min, leaps=False)
        self._diving, self._check = False, check  # rather than loading
        # Whether the fish that is ridden reacts to the light in its eyes.
        self.see_brightness = options.see_brightness
        self._seen_tick = 0  # at which the fish that is ridden has seen the light last
        opening = opening or opened(
            display.mode, display.size, display.fullscreen, settings, installation
        )
        self.wall, self.gui, self.pilot = opening.wall, opening.gui, opening.pilot
        with ExitStack() as undo:
            undo.callback(opening.close)
            self.picture = Picture(self.wall, opening.rig, display)
            self.overlay = Overlay(sign_of(settings.bindings, settings.mouse.steer))
            self.desk, self.menu = Desk(self), Menu(self, kiosk)
            self._kiosk = Kiosk(self.wall.windows) if kiosk else None
            self.world = self._made(self.scenario, self.source, seed)
            self._wait("starting OpenGL")
            self._stay = ExitStack()  # what belongs to the world that it is in
            undo.callback(lambda: self._stay.close())
            self._live_in(self.world, lambda: self._wait(None), options.tour is not None)
            self._wait(None)
            if self._crew.shared:
                self.overlay.sign = sign_of(
                    settings.bindings, settings.mouse.steer, ("ride", "desk")
                )
            # From where it is these two go on; what begins elsewhere must not be a jump.
            leaps = self._tour not in (AUTOPILOT, DIRECTED) or kiosk
            self.attract.leaps = leaps and not self._crew.shared
            self._diving = True
            undo.callback(self._shots.end)
            self._undo = undo.pop_all()

    @property
    def window(self) -> Window:
        """The pilot's window."""
        return self.wall.front

    @property
    def shared(self) -> bool:
        """Whether other computers show the same dive: then nothing here may change it."""
        return self._crew.shared

    def enter(
        self, scenario: Scenario, source: Path, seed: int | None = None, stay: bool = False
    ) -> bool:
        """Leave this world for the one that a scenario begins with; whether there is such a one.

        If not, that is told, and everything stays as it is. `source` is the scenario's file. With
        `stay` the submarine and what lives go on from here (`staying.carry`), and so does time.
        """
        before, ride, time = self.world, self.picture.ride, self._crew.timeline
        try:
            if stay:
                world = create_world(scenario, seed, source=str(source))
                carry(before, world)
            else:
                world = self._made(scenario, source, seed)
        except UserError as fault:
            self.note(str(fault))
            return False
        self.mount(None)
        self._stay.close()
        self.scenario, self.source = scenario, source
        self._live_in(world)
        if stay and ride is not None and ride.by.fish < len(world.state.fishes.alive):
            self.mount(ride.by.fish)
        if stay and time is not None and self._crew.timeline is not None:
            self._crew.timeline.run_at(time.rate)
            self._crew.timeline.paused = time.paused
        return True

    @property
    def can_fill(self) -> bool:
        """Whether there is a window that may fill the screen."""
        return any(not window.fixed for window in self.wall.windows)

    def fill_screen(self) -> None:
        """Have the pilot's window fill the screen, or go back to its former size."""
        self.window.toggle_fullscreen()

    def leave(self) -> None:
        """End the dive."""
        self.window.ask_to_close()

    def _made(self, scenario: Scenario, source: Path, seed: int | None) -> World:
        """The world that a scenario begins with, awake."""

        return meanwhile(lambda tell: awake(scenario, source, seed, tell), self._wait)

    def _live_in(
        self,
        world: World,
        heed: Callable[[], object] = lambda: None,
        touring: bool = False,
    ) -> None:
        """Have a world drawn and its ticks made from now on; the one before was left.

        That takes a while, in which `heed` is called, and may raise. A tour begins with it if it is
        `touring`.
        """
        with ExitStack() as undo:
            self.picture.enter(world, heed)
            undo.callback(self.picture.leave)
            # A tour puts the submarine at its beginning, where other computers must find it.
            carried = self._taken(world) if touring else None
            self._crew = self._crew_of(world, self.pilot)
            self._crew.carry(carried)
            if touring:
                self.attract.begin()
            undo.callback(self._disband)
            self.world, self._seen_tick = world, 0
            self.picture.eye = self._crew.eye()
            self.desk.enter()
            self._stay = undo.pop_all()

    def frame(self, elapsed_s: float) -> None:
        """One picture, `elapsed_s` after the last: events, due ticks, drawing, presenting."""
        start = time.perf_counter()
        for wish in self.wall.poll():
            self.grant(wish)
        for line in (*self.wall.notes(), *self.world.notices):
            self.note(line)
        self.world.notices.clear()
        self._attend(elapsed_s)
        if self.menu.open:
            self.pilot.full_stop()  # it holds station, whatever arrows choose there
        self._see_light()
        before = self.world.state.tick
        alpha = self._crew.picture(elapsed_s)
        if self.world.state.tick < before:
            self.picture.jump()
        if alpha is None and not self._crew.waiting:
            return  # what is shown stays, until there is something else
        start += self._crew.idle_s
        picture, ride = self.picture, self.picture.ride
        picture.alpha = picture.alpha if alpha is None else alpha
        seen_from, picture.eye = picture.eye, self._crew.eye()
        if leapt(seen_from, picture.eye, RATES[-1] * elapsed_s):
            picture.jump()
        if ride is not None:
            if self._crew.steered is None:
                ride.glance(*self.pilot.glance, elapsed_s)
            if not self.world.state.fishes.alive[ride.by.fish]:
                self.mount(None)
        picture.draw(self._clear, self.desk.chosen)
        self._write(elapsed_s)
        self._shoot(elapsed_s)
        picture.pace(lambda: time.perf_counter() - start)
        if alpha is not None:
            self._crew.swap(picture.finish)
        self.wall.present()
        self.desk.afterwards()

    @property
    def timeline(self) -> Timeline | None:
        """The time of the world; None where that is another computer's."""
        return self._crew.timeline

    def _attend(self, elapsed_s: float) -> None:
        """A tour when nobody is there, and the helm for whoever does anything."""
        stirred = self.pilot.stirred()
        if self._kiosk is not None:
            self._kiosk.keep(stirred, elapsed_s)
        # Who has opened the desk or stopped time works, even if no hand moves for a while.
        works = self.desk.open and not self.menu.open
        works |= self.picture.pattern or self._shots.filming or not self._crew.hands
        works |= self._crew.timeline is not None and self._crew.timeline.paused
        what = self.attract.look(stirred, elapsed_s, not works)
        if what is None and self._shown_to_its_end:
            what = "begin"
        if what == "end":
            self._crew.carry(None)
            self.overlay.greet()
        elif what == "begin":
            self._take_tour()

    @property
    def _shown_to_its_end(self) -> bool:
        """Whether a kiosk that nobody is at has shown what its directions had to show."""
        scenario = self.world.scenario
        shows = self.attract.touring and self._kiosk is not None and not self._crew.shared
        return shows and self._tour == DIRECTED and is_directed(scenario) and is_over(self.world)

    def _take_tour(self) -> None:
        if self.menu.open:
            self.menu.hide()
        if self.desk.open:
            self.desk.toggle()
        self.mount(None)
        if self._kiosk is not None and not self._crew.shared:
            self.picture.look = "colours"
            self.enter(*self._at_first)
        self.pilot.hands_off()
        self.overlay.greet()  # the help is there again for the next
        if self._crew.shared:  # where the submarine is put there is only what makes a tick
            follows = self._tour == DIRECTED and is_directed(self.world.scenario)
            self._crew.carry(self._taken(self.world) if follows else guide(self.world, None))
            return
        self._crew.carry(self._taken(self.world))
        if self._crew.timeline is not None:
            self._crew.timeline.touch()
            self._crew.timeline.run_at(1.0)

    @property
    def steers_fish(self) -> bool:
        """Whether hands hold the reins of the fish that is ridden."""
        return self._crew.steered is not None

    def _see_light(self) -> None:
        """Let the fish that is ridden go by what it sees now, in the ticks until the next picture.

        Once a picture, however many ticks that has: seeing takes time too.
        """
        ride, tick = self.picture.ride, self.world.state.tick
        if ride is None or not self.see_brightness or self._seen_tick == tick:
            return
        self._seen_tick = tick
        self.world.seen_light[ride.by.fish] = self.picture.brightness(ride)

    def mount(self, fish: int | None, behind: bool | None = None) -> None:
        """Ride a fish of this number from now on, or come back to the submarine.

        Through its eyes, or from `behind` it; None: as the last one, if there was one.
        """
        if behind is None:
            behind = self.picture.ride is not None and self.picture.ride.behind
        self.picture.ride = None if fish is None else Ride(self.world, fish, behind)
        self.desk.chosen = self.desk.chosen if fish is None else fish
        self._crew.steered = None
        self.world.seen_light.clear()
        self._seen_tick = 0
        self.pilot.ride(self.picture.ride is not None)
        self.picture.jump()
        self.picture.arrange(self._clear)

    @property
    def _clear(self) -> bool:
        """Whether the help does not stand where pictures of a fish's eyes would be."""
        return self.overlay.help_opacity == 0.0

    def _write(self, elapsed_s: float) -> None:
        """What is to be read over the picture: instruments and help, or what is waited for.

        Nothing over the test pattern, by which projectors are measured.
        """
        if self.picture.pattern:
            return
        self._begin()
        letter(self.picture.labels, self.picture.sight)
        if not self.menu.open:  # nor is it to be read behind the help
            caption = caption_of(self.world, self.picture.alpha)
            opacity = caption.opacity * (1.0 - self.overlay.help_opacity)
            subtitles.draw(caption._replace(opacity=opacity), self.picture.rig)
        if self._crew.hands:
            submarine = self.world.state.submarine
            helm = self.picture.ride is None and not self.attract.touring
            if helm and self._settings.comfort.horizon and self.picture.sight:
                draw_horizon(self.picture.sight)
            self._vignette.feel(submarine.rates, submarine.velocity, elapsed_s)
            self._vignette.draw()
            if not self.menu.open:
                now = reading(submarine, self.pilot.throttle, self.pilot.stopping)
                self.overlay.draw(now, elapsed_s, self._circumstances, not helm)
                self.desk.draw()
            self.attract.draw()
        else:
            self.overlay.caption(self._crew.waiting)
        if self.menu.open:
            self.menu.draw(elapsed_s)
        self.gui.end()

    def note(self, text: str) -> None:
        """Tell a line, on the terminal and for a while in the window."""
        say(text)
        self.overlay.note(text)

    def _switch_lights(self) -> None:
        """The submarine's lights, on or off; on all computers that show this dive."""
        if not self._crew.hands:
            return
        lights = self.world.state.submarine.lights
        lights[:] = ~lights
        if self._crew.timeline is not None:
            self._crew.timeline.touch()

    def _want_picture(self) -> None:
        self._wants_picture = True

    def _shoot(self, elapsed_s: float) -> None:
        """Pictures and films that were asked for, of what is about to be shown."""
        if not (self._wants_picture or self._shots.filming):
            return
        pixels = self.wall.picture()
        self._shots.frame(pixels, elapsed_s)
        if self._wants_picture:
            self._wants_picture = False
            self._shots.picture(pixels)

    @property
    def _circumstances(self) -> str:
        """Whom one rides, and what is not usual about time, in one line."""
        parts = []
        if self.picture.ride is not None:
            steered = self._crew.steered is not None
            parts.append(self.picture.ride.text(self.world, self.picture.look, steered))
        if self._crew.timeline is not None and self._crew.timeline.text:
            parts.append(self._crew.timeline.text)
        return "   ".join(parts)

    def _begin(self) -> None:
        """Begin a frame of the gui on the pilot's window."""
        window = self.window
        self.gui.begin(window.points, window.size, window.text_scale, self.picture.panes)

    def grant(self, wish: Wish) -> None:
        """Do what the visitor asked for by a key. While the menu is open only that answers."""
        if self.menu.open and wish in ("menu", "alight"):
            self.menu.back()
        elif wish in self._grants and (not self.menu.open or wish in BESIDE_MENU):
            self._grants[wish]()

    def _open_menu(self) -> None:
        if self.picture.pattern:
            self._show_pattern()
        else:
            self.window.take_keyboard()  # Esc may have been pressed in another
            self.menu.show()

    def _show_help(self) -> None:
        if not self.picture.pattern:
            self.overlay.toggle_help()

    def _open_desk(self) -> None:
        if self._crew.shared:
            self.overlay.note("no desk here: several computers show this dive")
        elif not self.picture.pattern:
            self.window.take_keyboard()
            self.desk.toggle()

    def _ride_one(self, turned: str = "from behind") -> None:
        if self.picture.pattern or self._crew.shared:
            return
        fish = self.desk.chosen if self.desk.open else None
        if fish is None or (self.picture.ride is not None and self.picture.ride.by.fish == fish):
            fish = nearest_to_middle(self.world, self.picture.views()[front_view(self.picture.rig)])
        if fish is not None:
            first = self.picture.ride is None
            self.mount(fish)
            if first:
                self._hint(("follow", turned), ("reins", "steer it"), ("alight", "back"))

    def show_ride(
        self, gaze: tuple[float, float] | None, look: RetinaColours | None, reins: bool
    ) -> None:
        """Turn the eyes of the fish that is ridden, show what they see so, and take its reins."""
        ride = self.picture.ride
        if ride is not None and gaze is not None:
            ride.gaze = Gaze(*gaze)
        self.picture.look = look or self.picture.look
        if reins:
            self._take_reins()

    def go_at(self, pace: float) -> None:
        """Let time go at one of `timeline.RATES`; 0: let it stand still."""
        time = self._crew.timeline
        if time is not None and pace == 0.0:
            time.pause()
        elif time is not None:
            time.run_at(pace)

    def _follow_one(self) -> None:
        behind = self.picture.ride is None or not self.picture.ride.behind
        if self.picture.ride is None:
            self._ride_one("through its eyes")
        if self.picture.ride is not None:
            self.picture.ride.look_from(behind)
            self.picture.jump()

    def _take_reins(self) -> None:
        if self.picture.ride is None:
            self._ride_one()
        if self.picture.ride is not None:
            self.pilot.full_stop()  # what hands held before was not meant for it
            self._crew.steered = self.picture.ride.by.fish if self._crew.steered is None else None
            if self._crew.steered is not None:
                self._hint(("reins", "let it go"), before="steer it as the submarine")

    def _hint(self, *pairs: tuple[Meaning, str], before: str = "") -> None:
        """Tell for a while what keys do now."""
        inputs = ((self.pilot.bindings.inputs(meaning), what) for meaning, what in pairs)
        words = [f"{names[0]} {what}" for names, what in inputs if names]
        self.overlay.note("   ".join([before, *words] if before else words))

    def _have_time(self, act: Callable[[Timeline], None]) -> None:
        if self._crew.timeline is None:
            self.overlay.note(SHARED_TIME)
        else:
            act(self._crew.timeline)

    def _show_pattern(self) -> None:
        self.picture.show_pattern(self._clear)

    def _choose_quality(self) -> None:
        self.picture.choose_next()
        self.overlay.note(self.picture.fineness)

    def _disband(self) -> None:
        for line in self._crew.close():
            say(line)

    def close(self) -> None:
        """Close everything in the reverse order of its opening."""
        self._undo.close()

    def _wait(self, message: str | None) -> None:
        """Say on the terminal and in the window how far a world is, unless the visitor leaves."""
        self._check()
        wishes = self.wall.poll()
        if "leave" in wishes:
            self.leave()
        if not self.wall.open or ("menu" in wishes and not self._diving and self._kiosk is None):
            raise LeftError
        if message is not None:
            self._tell(message)

    def _tell(self, message: str) -> None:
        """Say it on the terminal and in the window."""
        say(message)
        self._begin()
        self.overlay.message(message)
        self.gui.end()
        self.wall.present()
