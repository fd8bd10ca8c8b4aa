"""The presenter's remote control of a dive: applies commands, publishes state and pictures."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from subsea.base.errors import UserError, printable, unknown
from subsea.base.progress import say
from subsea.dive.directed_camera import is_directed
from subsea.dive.presented import NOTHING, Presentation
from subsea.dive.ride import nearest_to_middle
from subsea.scenario.load import load_scenario, scenario_names
from subsea.scenario.schema import AUTOPILOT, DIRECTED
from subsea.scenario.shoals import find_fish
from subsea.stage import show_edit
from subsea.stage.cluster.ticks import LeaderTicks
from subsea.stage.console import commands
from subsea.stage.console.board import Board
from subsea.stage.console.options import ConsoleOptions
from subsea.stage.console.server import ConsoleServer
from subsea.stage.show_player import ShowScreens
from subsea.stage.small_picture import SmallPicture
from subsea.ui.menu import scenario_summaries
from subsea.view.front_screen import front_view
from subsea.world.feeding import EVERY_S
from subsea.world.step import cue_direction

if TYPE_CHECKING:
    from subsea.stage.fleet.desk import FleetDesk
    from subsea.stage.fleet_part import FleetPart
    from subsea.stage.line_up import TheatreLineUp
    from subsea.stage.structured_light import StructuredLight
    from subsea.ui.dive import Dive

STATE_S, PICTURE_S = 0.4, 0.25  # between two publications
PICTURE_WIDTH = 480  # pixels
MOST_A_FRAME = 4  # commands
STALL_S = 1.0  # a picture that takes longer is a fault
NEAREST = "nearest"
SHARED = "several computers show this dive, which nothing but the pilot's input may change"


class RemoteControl:
    """Applies commands of the board between two frames, and publishes the dive on it."""

    def __init__(
        self, dive: "Dive", board: Board, server: ConsoleServer | None,
        show: ShowScreens | None = None, line_up: "TheatreLineUp | None" = None,
        light: "Callable[[], StructuredLight] | None" = None, fleet: "FleetPart | None" = None,
    ) -> None:  # fmt: skip
        """`server` serves the board, None: nobody; the others are those of the dive."""
        self.presented = NOTHING  # over the picture
        self.board = board
        self._dive, self._board, self._server, self._show = dive, board, server, show
        self._line_up, self._light, self._fleet = line_up, light, fleet
        self._rate = 0.0  # pictures a second
        self._presentation = Presentation()
        self._small = SmallPicture(dive.window_set.context, PICTURE_WIDTH)
        self._scenarios = _scenarios()
        self._begun_s = self._state_s = time.monotonic()
        self._pictured_s = 0.0
        self._frames = 0
        self._losses = 0  # of nodes, so far
        self._refused = ""  # the last refusal on the terminal
        self._opened = True  # a scenario, which takes long, before this frame
        self._publish(0.0)

    def update(self, elapsed_s: float) -> None:
        """Apply waiting commands and publish the state, `elapsed_s` after the last frame."""
        self.beat()
        if elapsed_s > STALL_S and not self._opened:
            self._dive.faults.add(f"the picture stood still for {elapsed_s:.1f} s")
        self._opened = False
        for _ in range(MOST_A_FRAME):
            if (request := self._board.take()) is None:
                break
            command, done = request
            try:
                done.set_result(self._apply(command))
            except UserError as fault:
                self._board.refusals.add(f"{command.__struct_config__.tag}: {fault}")
                done.set_exception(fault)
        self.presented = self._presentation.update(elapsed_s)
        self._frames += 1
        now = time.monotonic()
        if now - self._state_s >= STATE_S:
            self._rate = self._frames / (now - self._state_s)
            self._publish(self._rate)
            self._frames, self._state_s = 0, now
        if self._server is not None and (ended := self._server.check()):
            self._dive.faults.say(ended)

    def beat(self) -> None:
        """Note that the dive is alive."""
        self._board.beat()

    def look(self) -> None:
        """Publish a small picture of the window now and then, if somebody looks."""
        if (picture := self._small.read()) is not None:
            self._board.show(picture)
        if self._fleet is not None and (desk := self._fleet.desk) is not None:
            for name in self._board.take_wanted_nodes():
                desk.want_picture(name)
            self._board.node_pictures = desk.pictures
        now = time.monotonic()
        if self._board.picture_wanted and now - self._pictured_s >= PICTURE_S:
            self._pictured_s = now
            self._small.copy(self._dive.window_set.front.size)

    def close(self) -> None:
        """Stop the server, and release the small picture."""
        if self._server is not None:
            self._server.close()
        self._small.release()

    def _apply(self, command: commands.PresenterCommand) -> str:
        """Apply a command; returns what was done, or raises a UserError."""
        dive = self._dive
        match command:
            case commands.OpenScenario(name):
                return self._open_scenario(name)
            case commands.StartTour(name):
                dive.tours.start(name)
                return f"on tour {name}"
            case commands.StopTour():
                dive.tours.stop()
                return "no tour"
            case commands.StartCue(number):
                return self._start_cue(number)
            case commands.NextItem():
                self._played.cue()
                return "on to the next item"
            case commands.GoToItem(number):
                self._played.go_to(number - 1)
                return f"on to item {number}"
            case commands.EditItem(number, key, value):
                played = self._played
                played.take(show_edit.edit_item(played.path, number - 1, key, value))
                return f"item {number}: `{key}` is {value or 'left out'}"
            case commands.AddSpecialDay(date, title, hours, days):
                day = show_edit.special_day(date, title, hours, days)
                self._played.take(show_edit.add_special_day(self._played.path, day))
                return f"added {title or date}"
            case commands.RemoveSpecialDay(number):
                self._played.take(show_edit.remove_special_day(self._played.path, number - 1))
                return f"removed special day {number}"
            case commands.ShowCaption(text, seconds):
                words = " ".join(printable(text.replace("\n", " ")).split())
                self._presentation.show_caption(words, seconds or None)
                return f"shows {words!r}" if words else "no caption"
            case commands.FollowFish(fish):
                return self._ride(fish, behind=True)
            case commands.RideFish(fish):
                return self._ride(fish, behind=False)
            case commands.LeaveFish():
                dive.ride_fish(None)
                return "on the submarine"
            case commands.FeedFishes():
                return self._feed()
            case commands.SetQuality(quality):
                dive.picture.choose(quality)
                return dive.picture.quality_text
            case commands.SetVolume(volume):
                louder = {"volume": round(volume, 2)} if volume > 0.0 else {}
                dive.sound.change(mute=not louder, **louder)
                return dive.sound.text
            case commands.BlankScreens(on):
                self._presentation.blank = on
                return "the screens are blank" if on else "the screens show the sea"
            case commands.LineUpCommand():
                if self._line_up is None:
                    raise UserError("no theatre to line up: begin the dive with --theatre FILE")
                done = self._line_up.apply(command)
                self._publish(self._rate)  # a technician waits for the new places
                return done
            case commands.ShowLineUp(on):
                self._presentation.pattern = on
                if dive.picture.pattern != on:
                    dive.picture.show_pattern(dive.overlay.help_hidden)
                return "the screens show the test pattern" if on else "the screens show the sea"
            case commands.RestartNode(node):
                return self._desk.restart(node)
            case commands.WakeNode(node):
                return self._desk.wake(node)
            case commands.SwitchProjector(name, on):
                return self._desk.projectors.switch(name, on)
            case commands.ShowStructuredLight(number):
                if self._light is None:
                    raise UserError("no projectors to calibrate: begin the dive with --theatre")
                return self._light().show(number)
        raise NotImplementedError(type(command).__name__)

    @property
    def _desk(self) -> "FleetDesk":
        """The technician's desk; a UserError without a theatre."""
        desk = None if self._fleet is None else self._fleet.desk
        if desk is None:
            raise UserError("no theatre whose computers could be controlled: begin with --theatre")
        return desk

    @property
    def _played(self) -> ShowScreens:
        """The show; a UserError without one."""
        if self._show is None:
            raise UserError("no show is played: begin the dive with --playlist FILE")
        return self._show

    def _open_scenario(self, name: str) -> str:
        dive = self._dive
        if name not in (names := scenario_names()):  # not a path
            raise unknown("scenario", name, names)
        scenario, source, _ = load_scenario(name)
        if dive.menu.open:
            dive.menu.hide()
        self._opened = True
        self._publish(0.0, loading=True)
        if not dive.open_world(scenario, source):
            raise UserError(dive.overlay.note_text)
        self._scenarios = _scenarios()
        return f"opened {scenario.title or name}"

    def _start_cue(self, wanted: int) -> str:
        dive = self._dive
        self._refuse_in_cluster()
        number = self._next_cue if wanted < 0 else wanted
        directions = dive.world.scenario.direction
        if number is None and directions:
            raise UserError("no cue is left: all directions have begun")
        number = number or 0
        if number >= len(directions):
            last = f"0 to {len(directions) - 1}" if directions else "none, there are no directions"
            raise UserError(f"cue {number}: expected {last}")
        cue_direction(dive.world, number)
        if dive.timeline is not None:
            dive.timeline.touch()
        return f"started {directions[number].name or f'cue {number}'}"

    def _feed(self) -> str:
        self._refuse_in_cluster()
        time = self._dive.timeline
        if time is None or not time.feed():
            raise UserError(
                f"no food now: it takes plankton, and {EVERY_S:g} s from pinch to pinch"
            )
        return "food for the fishes"

    def _ride(self, name: str, behind: bool) -> str:
        self._refuse_in_cluster()
        fish = self._fish(name)
        self._dive.ride_fish(fish, behind)
        return f"on fish {fish}, a {self._species(fish)}"

    def _fish(self, name: str) -> int:
        """The living fish that a name means: the first of a species, or a UserError."""
        dive = self._dive
        world, picture = dive.world, dive.picture
        alive = world.state.fishes.alive
        if name == NEAREST:
            found = nearest_to_middle(world, picture.views()[front_view(picture.rig)])
            if found is None:
                raise UserError("no other fish lives here")
            return found
        fish = find_fish(name, world.scenario)
        if name == self._species(fish):  # of a shoal any living one will do
            those = np.flatnonzero(alive & (world.state.fishes.species == self._kind(fish)))
            fish = int(those[0]) if len(those) else fish
        if not alive[fish]:
            raise UserError(f"fish {name}: has died")
        return fish

    def _kind(self, fish: int) -> int:
        return int(self._dive.world.state.fishes.species[fish])

    def _species(self, fish: int) -> str:
        return self._dive.world.script.species[self._kind(fish)]

    def _refuse_in_cluster(self) -> None:
        if self._dive.shared:
            raise UserError(SHARED)

    @property
    def _next_cue(self) -> int | None:
        """The first direction of the file that has not begun."""
        world = self._dive.world
        left = np.flatnonzero(world.state.directions.began[: len(world.scenario.direction)] < 0)
        return int(left[0]) if len(left) else None

    def _publish(self, pictures_a_s: float, loading: bool = False) -> None:
        """Publish the state as JSON."""
        state = self._state(pictures_a_s, loading)
        nodes = state["nodes"]
        lost = sum(node["late"] + node["dropped"] + node["diverged"] for node in nodes)
        if lost > self._losses:
            away = [node["name"] for node in nodes if not node["in_step"]]
            self._dive.faults.add(f"not in step: {', '.join(away)}" if away else "a node was late")
        self._losses = lost
        if (refused := state["refusal"]) is not None and refused.text != self._refused:
            self._refused = refused.text  # at most one line for each state: senders may flood
            say(f"the console refused {refused.text}")
        self._board.state = msgspec.json.encode(state)
        about = {key: state[key] for key in ("up_s", "pictures_a_s", "loading", "fault", "refusal")}
        about["fleet"] = state["fleet"]
        about["nodes"] = {node["name"]: node["in_step"] for node in nodes}
        self._board.health = msgspec.json.encode(about)

    def _state(self, pictures_a_s: float, loading: bool) -> dict[str, Any]:
        """Describe the dive: docs/reference/console-interface.md."""
        dive = self._dive
        world, picture, sound = dive.world, dive.picture, dive.sound.settings
        scenario, began = world.scenario, world.state.directions.began
        ticks, ride, show = dive.tick_source, picture.ride, self._show
        steering = ticks.steering
        tours = [AUTOPILOT, *[DIRECTED] * is_directed(scenario)]
        if not dive.shared:
            tours += [tour.name for tour in scenario.tour]
        living = np.bincount(
            world.state.fishes.species[world.state.fishes.alive], minlength=len(scenario.species)
        )
        return {
            "title": scenario.title,
            "scenario": dive.source.stem,
            "scenarios": self._scenarios,
            "tours": tours,
            "tour": dive.tours.current if steering is not None and steering.tour else None,
            "cues": [
                {
                    "number": number,
                    "name": direction.name,
                    "caption": direction.caption or "",
                    "begun": bool(began[number] >= 0),
                }
                for number, direction in enumerate(scenario.direction)
            ],
            "next_cue": self._next_cue,
            "show": None if show is None else show.player.state(),
            "caption": dive.caption.words,
            "fish": None
            if ride is None
            else {
                "number": ride.by.fish,
                "species": self._species(ride.by.fish),
                "behind": ride.behind,
            },
            "species": [
                {"name": name, "living": int(count)}
                for name, count in zip(world.script.species, living, strict=True)
            ],
            "quality": picture.quality,
            "quality_now": picture.quality_text,
            "volume": 0.0 if sound.mute else sound.volume,
            "blank": self._presentation.blank,
            "line_up": picture.pattern,
            "projectors": None if self._line_up is None else self._line_up.session.describe(),
            "nodes": ticks.nodes() if isinstance(ticks, LeaderTicks) else [],
            "fleet": self._fleet.desk.describe() if self._fleet and self._fleet.desk else None,
            "several_computers": dive.shared,
            "loading": loading,
            "pictures_a_s": round(pictures_a_s, 1),
            "up_s": round(time.monotonic() - self._begun_s, 1),
            "fault": dive.faults.state,
            "refusal": self._board.refusals.state,
        }


def open_console(
    dive: "Dive", options: ConsoleOptions, show: ShowScreens | None = None,
    line_up: "TheatreLineUp | None" = None, light: "Callable[[], StructuredLight] | None" = None,
    fleet: "FleetPart | None" = None,
) -> RemoteControl | None:  # fmt: skip
    """Open the console of a dive; a fault, such as a port that is taken, is one line."""
    if not dive.tick_source.has_pilot:
        say("the console is on the master's computer, not on its nodes")
        return None
    board = Board()
    try:
        server = ConsoleServer(options, board)
    except UserError as fault:
        dive.note(str(fault))
        return None
    say(f"the presenter's console: {options.url}")
    return RemoteControl(dive, board, server, show, line_up, light, fleet)


def _scenarios() -> list[dict[str, str]]:
    return [{"name": path.stem, "title": head.title} for path, head in scenario_summaries().items()]
