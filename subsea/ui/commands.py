"""Commands of keys, buttons and panels in a dive, apart from steering."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from subsea.base.language import LANGUAGES, language, marked, translated
from subsea.dive.options import RetinaColours
from subsea.dive.ride import nearest_to_middle
from subsea.dive.settings import Command, ControlName, key_words
from subsea.dive.timeline import Timeline
from subsea.ui.photo import WITH_PHOTO
from subsea.view.front_screen import front_view
from subsea.view.retina import Gaze
from subsea.world.world import TICK_S

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

SHARED_TIME = marked("several computers show this dive: its time goes on")
# These work while the menu is open.
WITH_MENU: tuple[Command, ...] = (
    "fullscreen", "leave", "picture", "film", "mute", "louder", "quieter", "score", "recentre",
    "language", "cue",
)  # fmt: skip


class Commands:
    """Runs commands by name."""

    def __init__(self, dive: "Dive") -> None:
        self._dive = dive
        self._functions: dict[Command, Callable[[], object]] = {
            "help": self._show_help,
            "desk": self._toggle_inspector,
            "ride": self._ride_nearest,
            "alight": lambda: dive.ride_fish(None),
            "look": lambda: dive.picture.next_colours(),
            "follow": self._toggle_behind,
            "reins": self._toggle_teleop,
            "pause": lambda: self._change_time(Timeline.pause),
            "slower": lambda: self._change_time(Timeline.slower),
            "faster": lambda: self._change_time(Timeline.faster),
            "tick": lambda: self._change_time(Timeline.single),
            "rewind": lambda: self._change_time(self._rewind),
            "pattern": self._toggle_pattern,
            "quality": self._next_quality,
            "lights": self._toggle_lights,
            "feed": self._feed,
            "picture": dive.take_picture,
            "photo": lambda: dive.photo.toggle(),
            "film": lambda: dive.shots.film(dive.window.size),
            "instruments": lambda: self._note_instruments(),
            "mute": lambda: dive.sound.mute(),
            "louder": lambda: dive.sound.turn(up=True),
            "quieter": lambda: dive.sound.turn(up=False),
            "score": lambda: dive.sound.turn_score(),
            "language": self._next_language,
            "fullscreen": dive.window.toggle_fullscreen,
            "menu": self._open_menu,
            "recentre": lambda: dive.picture.recentre(),
            "cue": self._next_cue,
            "leave": dive.window.ask_to_close,
        }

    def run(self, command: Command) -> None:
        """Run a command. While the menu is open only a few work."""
        photo = self._dive.photo
        if photo.open and command in ("menu", "alight"):
            photo.back()
        elif photo.open and command not in WITH_PHOTO:
            return
        elif self._dive.menu.open and command in ("menu", "alight"):
            self._dive.menu.back()
        elif command in self._functions and (not self._dive.menu.open or command in WITH_MENU):
            self._functions[command]()

    def start_ride(
        self, gaze: tuple[float, float] | None, colours: RetinaColours | None, teleop: bool
    ) -> None:
        """Set the gaze (degrees) and retina colours of the current ride, and steer the fish."""
        picture = self._dive.picture
        if picture.ride is not None and gaze is not None:
            picture.ride.gaze = Gaze(*gaze)
        picture.colours = colours or picture.colours
        if teleop:
            self._toggle_teleop()

    def set_pace(self, pace: float) -> None:
        """Set the rate of time, one of `timeline.RATES`; 0: pause."""
        time = self._dive.timeline
        if time is not None and pace == 0.0:
            time.pause()
        elif time is not None:
            time.run_at(pace)

    def _open_menu(self) -> None:
        if self._dive.picture.pattern:
            self._toggle_pattern()
        else:
            self._dive.window.take_keyboard()  # Esc may have been pressed in another window
            self._dive.menu.show()

    def _show_help(self) -> None:
        if not self._dive.picture.pattern:
            self._dive.overlay.toggle_help()

    def _toggle_inspector(self) -> None:
        if self._dive.shared:
            self._dive.overlay.note(translated("no desk here: several computers show this dive"))
        elif not self._dive.picture.pattern:
            self._dive.window.take_keyboard()
            self._dive.inspector.toggle()

    def _next_cue(self) -> None:
        for part in self._dive.parts:
            part.cue()

    def _toggle_pattern(self) -> None:
        self._dive.picture.show_pattern(self._dive.overlay.help_hidden)

    def _next_quality(self) -> None:
        self._dive.picture.choose_next()
        self._dive.overlay.note(self._dive.picture.quality_text)

    def _note_instruments(self) -> None:
        overlay = self._dive.overlay
        mode = translated(overlay.hud.cycle())
        overlay.note(translated("instruments: {mode}").format(mode=mode))

    def _next_language(self) -> None:
        self._dive.preferences.next_language()
        self._dive.overlay.note(LANGUAGES[language()])

    def _toggle_lights(self) -> None:
        """Toggle the submarine's lights, on all computers that show this dive."""
        dive = self._dive
        if not dive.tick_source.has_pilot:
            return
        lights = dive.world.state.submarine.lights
        lights[:] = ~lights
        if dive.timeline is not None:
            dive.timeline.touch()

    def _feed(self) -> None:
        """Scatter food before the submarine; not where several computers show the dive."""
        dive = self._dive
        if dive.timeline is None:
            dive.overlay.note(translated("no food here: several computers show this dive"))
        elif dive.timeline.feed():
            dive.overlay.note(translated("food for the fishes"))

    def _change_time(self, act: Callable[[Timeline], None]) -> None:
        if self._dive.timeline is None:
            self._dive.overlay.note(translated(SHARED_TIME))
        else:
            act(self._dive.timeline)

    def _rewind(self, time: Timeline) -> None:
        """Go a second back; say to when, unless the state of paused time does."""
        tick = time.rewind()
        if not time.paused:
            words = marked("back to second {second} of the dive")
            if tick == time.earliest:
                words = marked("back to second {second} of the dive, the earliest")
            self._dive.overlay.note(translated(words).format(second=f"{tick * TICK_S:.0f}"))

    def _ride_nearest(self, follow_hint: str = marked("from behind")) -> None:
        """Ride the chosen fish, or the one nearest to the middle of the view."""
        dive, picture = self._dive, self._dive.picture
        if picture.pattern or dive.shared:
            return
        fish = self._dive.inspector.chosen if self._dive.inspector.open else self._dive.card.fish
        if fish is None or (picture.ride is not None and picture.ride.by.fish == fish):
            fish = nearest_to_middle(dive.world, picture.views()[front_view(picture.rig)])
        if fish is not None:
            first = picture.ride is None
            dive.ride_fish(fish)
            if first:
                self._hint(
                    ("follow", follow_hint),
                    ("reins", marked("steer it")),
                    ("alight", marked("leave it")),
                )

    def _toggle_behind(self) -> None:
        """Toggle between looking from behind a fish and through its eyes."""
        picture = self._dive.picture
        behind = picture.ride is None or not picture.ride.behind
        if picture.ride is None:
            self._ride_nearest(marked("through its eyes"))
        if picture.ride is not None:
            picture.ride.look_from(behind)
            picture.jump()

    def _toggle_teleop(self) -> None:
        picture, ticks = self._dive.picture, self._dive.tick_source
        if picture.ride is None:
            self._ride_nearest()
        if picture.ride is not None:
            self._dive.pilot.full_stop()  # inputs held before must not steer the fish
            ticks.steered_fish = picture.ride.by.fish if ticks.steered_fish is None else None
            if ticks.steered_fish is not None:
                before = translated("steer it as the submarine")
                self._hint(("reins", marked("let it go")), before=before)

    def _hint(self, *hints: tuple[ControlName, str], before: str = "") -> None:
        """Show for a while the current functions of keys."""
        inputs = ((self._dive.pilot.bindings.inputs(name), text) for name, text in hints)
        words = [f"{key_words(names[0])} {translated(text)}" for names, text in inputs if names]
        self._dive.overlay.note("   ".join([before, *words] if before else words))
