"""The presenter's remote control of a dive: applies commands, publishes state and pictures."""

import ctypes
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from subsea.base.arrays import Bytes
from subsea.base.errors import UserError, printable, unknown
from subsea.base.progress import say
from subsea.dive.captions import FaultState
from subsea.dive.directed_camera import is_directed
from subsea.dive.presented import NOTHING, Presentation
from subsea.dive.ride import nearest_to_middle
from subsea.rendering.gl.context import GpuOwner, gl_function
from subsea.scenario.load import load_scenario, scenario_names
from subsea.scenario.schema import AUTOPILOT, DIRECTED
from subsea.scenario.shoals import find_fish
from subsea.stage.cluster.ticks import LeaderTicks, NodeStatus
from subsea.stage.console import commands
from subsea.stage.console.board import Board
from subsea.stage.console.options import ConsoleOptions
from subsea.stage.console.server import ConsoleServer
from subsea.stage.show_player import ShowScreens, ShowStatus
from subsea.ui.menu import scenario_summaries
from subsea.view.front_screen import front_view
from subsea.world.step import cue_direction

if TYPE_CHECKING:
    from subsea.ui.dive import Dive

STATE_S, PICTURE_S = 0.4, 0.25  # between two publications
PICTURE_WIDTH = 480  # pixels
MOST_A_FRAME = 4  # commands
STALL_S = 1.0  # a picture that takes longer is a fault
NEAREST = "nearest"
SHARED = "several computers show this dive, which nothing but the pilot's input may change"
# OpenGL enums
READ_FRAMEBUFFER, DRAW_FRAMEBUFFER, COLOR_BIT, LINEAR = 0x8CA8, 0x8CA9, 0x4000, 0x2601


class SmallPicture(GpuOwner):
    """Shrinks the screen of a context on the GPU, and reads the copy a frame later."""

    def __init__(self, context: Any, width: int) -> None:
        """Copies are `width` pixels wide at most, and as high as the window's shape says."""
        super().__init__()
        self._context, self._width = context, width
        self._size = (0, 0)
        self._copied = False
        self._blit = gl_function(
            context, "glBlitFramebuffer", *[ctypes.c_int] * 8, ctypes.c_uint, ctypes.c_uint
        )
        self._bind = gl_function(context, "glBindFramebuffer", ctypes.c_uint, ctypes.c_uint)

    def copy(self, window: tuple[int, int]) -> None:
        """Begin to copy the screen, whose size is that of the `window` in pixels."""
        context, width = self._context, min(self._width, window[0])
        size = width, max(round(width * window[1] / window[0]), 1)
        if size != self._size:
            self.release()
            self._size = size
            texture = self.own(context.texture(size, 4))
            self._small = self.own(context.framebuffer([texture]))
            self._buffer = self.own(context.buffer(reserve=4 * size[0] * size[1]))
        self._bind(READ_FRAMEBUFFER, context.screen.glo)
        self._bind(DRAW_FRAMEBUFFER, self._small.glo)
        self._blit(0, 0, *window, 0, 0, *size, COLOR_BIT, LINEAR)
        self._small.read_into(self._buffer, components=4)
        context.screen.use()
        context.error  # clear it: moderngl asks for an attachment that windows lack  # noqa: B018
        self._copied = True

    def read(self) -> Bytes | None:
        """The copy (h, w, 4) that was begun last, top row first, once; None if there is none."""
        if not self._copied:
            return None
        self._copied = False
        width, height = self._size
        return np.frombuffer(self._buffer.read(), np.uint8).reshape(height, width, 4)[::-1]


class Option(msgspec.Struct, frozen=True, omit_defaults=True):
    """A scenario or a species to choose."""

    name: str
    title: str = ""
    living: int = 0


class CueState(msgspec.Struct, frozen=True):
    """A direction of the scenario."""

    number: int
    name: str
    caption: str
    begun: bool


class FishState(msgspec.Struct, frozen=True):
    """The fish that is followed or ridden."""

    number: int
    species: str
    behind: bool


class DiveState(msgspec.Struct, frozen=True, kw_only=True):
    """The state of a dive, as the console shows it."""

    title: str
    scenario: str
    scenarios: list[Option]
    tours: list[str]
    tour: str | None
    cues: list[CueState]
    next_cue: int | None
    show: ShowStatus | None
    caption: str
    fish: FishState | None
    species: list[Option]
    quality: str
    quality_now: str
    volume: float  # 0: off
    blank: bool
    line_up: bool
    nodes: list[NodeStatus]
    several_computers: bool
    loading: bool
    pictures_a_s: float
    up_s: float
    fault: FaultState | None


class RemoteControl:
    """Applies commands of the board between two frames, and publishes the dive on it."""

    def __init__(
        self, dive: "Dive", board: Board, server: ConsoleServer | None = None,
        show: ShowScreens | None = None,
    ) -> None:  # fmt: skip
        """`server` serves the board; `show` is the one that the dive plays."""
        self.presented = NOTHING  # over the picture
        self._dive, self._board, self._server, self._show = dive, board, server, show
        self._presentation = Presentation()
        self._small = SmallPicture(dive.window_set.context, PICTURE_WIDTH)
        self._scenarios = _scenarios()
        self._begun_s = self._state_s = time.monotonic()
        self._pictured_s = 0.0
        self._frames = 0
        self._losses = 0  # of nodes, so far
        self._opened = True  # a scenario, which takes long, before this frame
        self._commands: dict[type[commands.PresenterCommand], Callable[[Any], str]] = {
            commands.OpenScenario: self._open_scenario,
            commands.StartTour: self._start_tour,
            commands.StopTour: self._stop_tour,
            commands.StartCue: self._start_cue,
            commands.NextItem: self._next_item,
            commands.ShowCaption: self._show_caption,
            commands.FollowFish: lambda one: self._ride(one.fish, behind=True),
            commands.RideFish: lambda one: self._ride(one.fish, behind=False),
            commands.LeaveFish: self._leave_fish,
            commands.SetQuality: self._set_quality,
            commands.SetVolume: self._set_volume,
            commands.BlankScreens: self._blank,
            commands.ShowLineUp: self._line_up,
        }
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
                done.set_exception(fault)
        self.presented = self._presentation.update(elapsed_s)
        self._frames += 1
        now = time.monotonic()
        if now - self._state_s >= STATE_S:
            self._publish(self._frames / (now - self._state_s))
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
        return self._commands[type(command)](command)

    def _open_scenario(self, command: commands.OpenScenario) -> str:
        dive = self._dive
        if command.name not in (names := scenario_names()):  # not a path
            raise unknown("scenario", command.name, names)
        scenario, source, _ = load_scenario(command.name)
        if dive.menu.open:
            dive.menu.hide()
        self._opened = True
        self._publish(0.0, loading=True)
        if not dive.open_world(scenario, source):
            raise UserError(dive.overlay.note_text)
        self._scenarios = _scenarios()
        return f"opened {scenario.title or command.name}"

    def _start_tour(self, command: commands.StartTour) -> str:
        self._dive.tours.start(command.name)
        return f"on tour {command.name}"

    def _stop_tour(self, _: commands.StopTour) -> str:
        self._dive.tours.stop()
        return "no tour"

    def _start_cue(self, command: commands.StartCue) -> str:
        dive = self._dive
        self._refuse_in_cluster()
        number = self._next_cue if command.number < 0 else command.number
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

    def _next_item(self, _: commands.NextItem) -> str:
        if self._show is None:
            raise UserError("no show is played: begin the dive with --playlist FILE")
        self._show.player.next_cue()
        return "on to the next item"

    def _show_caption(self, command: commands.ShowCaption) -> str:
        words = " ".join(printable(command.text.replace("\n", " ")).split())
        self._presentation.show_caption(words, command.seconds or None)
        return f"shows {words!r}" if words else "no caption"

    def _ride(self, name: str, behind: bool) -> str:
        dive = self._dive
        self._refuse_in_cluster()
        fish = self._fish(name)
        dive.ride_fish(fish, behind)
        return f"on fish {fish}, a {self._species(fish)}"

    def _leave_fish(self, _: commands.LeaveFish) -> str:
        self._dive.ride_fish(None)
        return "on the submarine"

    def _set_quality(self, command: commands.SetQuality) -> str:
        self._dive.picture.choose(command.quality)
        return self._dive.picture.quality_text

    def _set_volume(self, command: commands.SetVolume) -> str:
        sound = self._dive.sound
        if command.volume > 0.0:
            sound.change(volume=round(command.volume, 2), mute=False)
        else:
            sound.change(mute=True)
        return sound.text

    def _blank(self, command: commands.BlankScreens) -> str:
        self._presentation.blank = command.on
        return "the screens are blank" if command.on else "the screens show the sea"

    def _line_up(self, command: commands.ShowLineUp) -> str:
        dive = self._dive
        self._presentation.pattern = command.on
        if dive.picture.pattern != command.on:
            dive.picture.show_pattern(dive.overlay.help_hidden)
        return "the screens show the test pattern" if command.on else "the screens show the sea"

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
        lost = sum(one.late + one.dropped + one.diverged for one in state.nodes)
        if lost > self._losses:
            away = [one.name for one in state.nodes if not one.in_step]
            self._dive.faults.add(f"not in step: {', '.join(away)}" if away else "a node was late")
        self._losses = lost
        self._board.state = msgspec.json.encode(state)
        about = {
            "up_s": state.up_s,
            "pictures_a_s": state.pictures_a_s,
            "loading": loading,
            "fault": state.fault,
            "nodes": {one.name: one.in_step for one in state.nodes},
        }
        self._board.health = msgspec.json.encode(about)

    def _state(self, pictures_a_s: float, loading: bool) -> DiveState:
        dive = self._dive
        world, picture, sound = dive.world, dive.picture, dive.sound.settings
        scenario, began = world.scenario, world.state.directions.began
        ticks, ride, show = dive.tick_source, picture.ride, self._show
        steering = ticks.steering
        tours = [AUTOPILOT, *[DIRECTED] * is_directed(scenario)]
        if not dive.shared:
            tours += [one.name for one in scenario.tour]
        living = np.bincount(
            world.state.fishes.species[world.state.fishes.alive], minlength=len(scenario.species)
        )
        return DiveState(
            title=scenario.title,
            scenario=dive.source.stem,
            scenarios=self._scenarios,
            tours=tours,
            tour=dive.tours.current if steering is not None and steering.tour else None,
            cues=[
                CueState(k, one.name, one.caption or "", bool(began[k] >= 0))
                for k, one in enumerate(scenario.direction)
            ],
            next_cue=self._next_cue,
            show=None if show is None else show.player.state(),
            caption=dive.caption.words,
            fish=None
            if ride is None
            else FishState(ride.by.fish, self._species(ride.by.fish), ride.behind),
            species=[
                Option(name, living=int(count))
                for name, count in zip(world.script.species, living, strict=True)
            ],
            quality=picture.quality,
            quality_now=picture.quality_text,
            volume=0.0 if sound.mute else sound.volume,
            blank=self._presentation.blank,
            line_up=picture.pattern,
            nodes=ticks.nodes() if isinstance(ticks, LeaderTicks) else [],
            several_computers=dive.shared,
            loading=loading,
            pictures_a_s=round(pictures_a_s, 1),
            up_s=round(time.monotonic() - self._begun_s, 1),
            fault=self._dive.faults.state,
        )


def open_console(
    dive: "Dive", options: ConsoleOptions, show: ShowScreens | None = None
) -> RemoteControl | None:
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
    return RemoteControl(dive, board, server, show)


def _scenarios() -> list[Option]:
    return [Option(path.stem, head.title) for path, head in scenario_summaries().items()]
