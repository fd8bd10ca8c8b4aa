"""Line-up on the wall in a dive: on one computer, on a master, and on its nodes."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from subsea.base.arrays import Array, Bytes
from subsea.base.errors import UserError
from subsea.dive.options import DisplayOptions
from subsea.stage.cluster.messages import HASH
from subsea.stage.cluster.ticks import FollowerTicks, LeaderTicks
from subsea.stage.console import commands
from subsea.stage.setup import TheatreWindows, shown_windows, theatre_digest
from subsea.stage.theatre.adjusting import in_larger_pixels
from subsea.stage.theatre.channels import ProjectorChannel, blended
from subsea.stage.theatre.line_up import (
    NOTHING_CHANGED,
    Adjustments,
    LineUp,
    LineUpChannel,
    LineUpState,
)
from subsea.stage.theatre.line_up_file import AdjustedChannel, file_adjustment, save_line_up
from subsea.stage.theatre.line_up_marks import line_up_marks
from subsea.stage.theatre.theatre_rig import readjusted, theatre_rig
from subsea.ui import glfw
from subsea.view.adjustment import PatchAdjustment
from subsea.view.rig import CameraRig, select_outputs
from subsea.view.test_pattern import lineup

if TYPE_CHECKING:
    from subsea.stage.parts import TheatrePart
    from subsea.ui.dive import Dive

DIM = {"full": 1.0, "dim": 0.05, "black": 0.0}  # light of the channels that are not chosen
CODES = {"white": 255, "grey": 128, "black": 0}


class TheatreLineUp:
    """Shows the line-up of a theatre in a dive, and saves it."""

    def __init__(self, part: "TheatrePart", shown: TheatreWindows, display: DisplayOptions) -> None:
        """`shown` are the windows of the `part`."""
        self._part, self._shown, self._display = part, shown, display
        setup = shown.setup
        whole = setup.whole or setup.theatre
        names = _names(setup.channels)
        windows = setup.theatre.window
        self._channels = dict(zip(names, setup.channels, strict=True))
        self.session = LineUp(
            [
                LineUpChannel(
                    name,
                    (part.shrink * channel.size[0], part.shrink * channel.size[1]),
                    file_adjustment(whole, channel),
                    windows[channel.window].node,
                    channel.blend,
                )
                for name, channel in self._channels.items()
            ]
        )
        self._state = NOTHING_CHANGED  # that is shown
        self._now = setup.channels  # as they are shown
        self._saved: Adjustments = {}  # that the theatre file has, or that could not be written
        self._digest = setup.digest
        self._world: object = None
        self._canvas: tuple[object, Bytes] | None = None  # the last pattern, and what it is of

    def apply(self, command: commands.LineUpCommand) -> str:
        """Apply a command of the console; returns what was done, or raises a UserError."""
        return apply_command(self.session, command, self._write)

    def before(self, dive: "Dive") -> None:
        """Let all computers show the line-up in the next picture; take what nodes ask for."""
        ticks = dive.tick_source
        if isinstance(ticks, LeaderTicks):
            for line in ticks.reports():
                dive.note_fault(line)
            for asked in ticks.asked():
                self._try(dive, partial(_line_up_command, asked))
            ticks.line_up(self.session.state)

    def ticked(self, dive: "Dive") -> None:
        """Show the line-up of the picture that is drawn next."""
        ticks = dive.tick_source
        state: LineUpState | None = self.session.state
        if isinstance(ticks, FollowerTicks):
            state = ticks.lined_up
        if state is None or (state is self._state and dive.world is self._world):
            return
        if isinstance(ticks, FollowerTicks) and state.saved and state.saved != self._saved:
            self._saved = state.saved
            try:
                self._write(state.saved)
                ticks.renew_view(self._shown.view)
            except UserError as fault:
                dive.note(str(fault))
                ticks.report(str(fault))
        elif state.saved != self._saved:
            self._saved = state.saved
            if isinstance(ticks, LeaderTicks):
                ticks.renew_view(self._shown.view)
        self._state, self._world = state, dive.world
        self._show(dive, state)

    def listen(self, dive: "Dive") -> None:
        """Let the keys of this computer's windows line the projectors up; visitors have none."""
        if dive.kiosk:
            return
        for window in dive.window_set.windows:
            window.take_key = lambda key, modifiers: self._key(dive, key, modifiers)

    def _key(self, dive: "Dive", key: int, modifiers: int) -> bool:
        """Act on a key that went down; False: the key does something else."""
        command = key_command(key, modifiers, self._open(dive))
        if command is None:
            return False
        ticks = dive.tick_source
        if isinstance(ticks, FollowerTicks):
            ticks.ask(commands.to_json(command))
        else:
            self._try(dive, lambda: command)
        return True

    def _open(self, dive: "Dive") -> bool:
        ticks = dive.tick_source
        state = ticks.lined_up if isinstance(ticks, FollowerTicks) else self.session.state
        return state is not None and state.open

    def _try(self, dive: "Dive", command: Callable[[], commands.LineUpCommand]) -> None:
        """Apply a command of a keyboard; a fault is one line."""
        try:
            self.apply(command())
        except UserError as fault:
            dive.note(str(fault))

    def _show(self, dive: "Dive", state: LineUpState) -> None:
        """Let the windows of this computer show a line-up."""
        before = self._now
        self._now = tuple(
            self._adjusted(channel, state.adjustments.get(name), self._now[number])
            for number, (name, channel) in enumerate(self._channels.items())
        )
        if [_light(channel) for channel in self._now] != [_light(channel) for channel in before]:
            self._now = blended(self._now)
        rig = dive.picture.rig
        if [channel.size for channel in self._now] == [channel.size for channel in before]:
            rig = readjusted(rig, self._now)
        else:
            rig = self._new_rig(rig)
        names = list(self._channels)
        patterned = state.open and state.pattern != "sea"
        marks: dict[int, Array] = {}
        if patterned and state.channel in self._channels:
            chosen = names.index(state.channel)
            rig = _dimmed(rig, chosen, DIM[state.others])
            if state.pattern == "grid":  # on a plain colour their light would deceive
                marks = self._marks(rig, chosen, state)
        canvas = (lambda rig: self._pattern(rig, state.pattern)) if patterned else None
        dive.picture.fit(rig, canvas, marks, dive.overlay.help_hidden)

    def _adjusted(
        self, channel: ProjectorChannel, adjustment: Any, now: ProjectorChannel
    ) -> ProjectorChannel:
        """The channel of the theatre file with another adjustment, and the mask that it has now."""
        if adjustment is None:
            return replace(channel, mask=now.mask)
        smaller = in_larger_pixels(adjustment, self._part.shrink)
        return replace(channel, mask=now.mask, adjustment=smaller)

    def _new_rig(self, before: CameraRig) -> CameraRig:
        """The rig of the channels as they are now, for the windows that are open."""
        theatre, display = self._shown.setup.theatre, self._display
        numbers = shown_windows(theatre, self._now, self._part.node)
        rig = theatre_rig(theatre, self._now, numbers, display.mode, display.stereo)
        windows = {patch.output: self._now[patch.channel].window for patch in before.patches}
        return select_outputs(rig, [numbers.index(windows[k]) for k in range(len(before.outputs))])

    def _marks(self, rig: CameraRig, chosen: int, state: LineUpState) -> dict[int, Array]:
        """The marks over the patches of the chosen channel."""
        channel = self._now[chosen]
        shares = line_up_marks(channel.adjustment, channel.size, state.grid, state.point)
        return {k: shares for k, patch in enumerate(rig.patches) if patch.channel == chosen}

    def _pattern(self, rig: CameraRig, pattern: str) -> Bytes:
        """The canvas of a pattern; drawn again only if it would differ."""
        key = pattern, rig.canvas, tuple(patch.left for patch in rig.patches)
        if self._canvas is None or self._canvas[0] != key:
            width, height = rig.canvas
            if pattern == "grid":
                self._canvas = key, lineup(rig)
            else:
                self._canvas = key, np.full((height, width, 3), CODES[pattern], np.uint8)
        return self._canvas[1]

    def _write(self, adjustments: Adjustments) -> None:
        """Save adjustments into the theatre file of this computer."""
        adjusted = [
            AdjustedChannel(self._channels[name], adjustment)
            for name, adjustment in adjustments.items()
            if name in self._channels
        ]
        self._digest = save_line_up(self._shown.setup.path, self._digest, adjusted)
        if self._shown.view:
            digest = theatre_digest(self._part.name)
            self._shown.view["theatre files"] = HASH + digest[:10]


def apply_command(
    session: LineUp, command: commands.LineUpCommand, write: Callable[[Adjustments], object]
) -> str:
    """Apply a command to a line-up, which `write` saves; returns what was done, or a UserError."""
    match command:
        case commands.EditLineUp(on):
            return session.begin() if on else session.cancel()
        case commands.ChooseLineUp(channel, point):
            return session.choose(channel, point)
        case commands.MoveLineUp(right, down):
            return session.move(right, down)
        case commands.SetLineUp(key, value):
            return session.set(key, value)
        case commands.ShowLineUpPattern(pattern, others):
            return session.show(pattern, others)
        case commands.UndoLineUp():
            return session.undo()
        case commands.RedoLineUp():
            return session.redo()
        case commands.CompareLineUp(on):
            return session.compare(on)
        case commands.SaveLineUp():
            return session.save(write)
    raise NotImplementedError(type(command).__name__)


def _names(channels: tuple[ProjectorChannel, ...]) -> list[str]:
    """Name channels; a region of an archive with the name of another one gets its key."""
    names: list[str] = []
    for channel in channels:
        names.append(f"{channel.name} ({channel.key})" if channel.name in names else channel.name)
    return names


def _light(channel: ProjectorChannel) -> tuple[object, ...]:
    """Return all that the masks of all channels depend on."""
    adjustment = channel.adjustment
    return adjustment.gamma, adjustment.black, adjustment.blend_width


def _dimmed(rig: CameraRig, chosen: int, light: float) -> CameraRig:
    """The rig with less light from all channels but the chosen one."""
    patches = []
    for patch in rig.patches:
        if patch.channel != chosen and light != 1.0:
            adjustment = patch.adjustment or PatchAdjustment()
            red, green, blue = adjustment.gain
            gain = light * red, light * green, light * blue
            patch = patch._replace(adjustment=adjustment._replace(gain=gain))
        patches.append(patch)
    return rig._replace(patches=tuple(patches))


def _line_up_command(data: bytes) -> commands.LineUpCommand:
    """Decode a command that a node asks for; a UserError for anything else."""
    command = commands.from_json(data)
    if not isinstance(command, commands.LineUpCommand):
        raise UserError("a node may ask for commands of the line-up only")
    return command


STEPS_PX = {0: 1.0, glfw.MOD_SHIFT: 10.0, glfw.MOD_ALT: 0.1}
ARROWS = {
    glfw.KEY_LEFT: (-1, 0),
    glfw.KEY_RIGHT: (1, 0),
    glfw.KEY_UP: (0, -1),
    glfw.KEY_DOWN: (0, 1),
}


def key_command(key: int, modifiers: int, is_open: bool) -> commands.LineUpCommand | None:
    """The command of a key in a window of the theatre; None: the key does something else."""
    modifiers &= glfw.MOD_SHIFT | glfw.MOD_ALT | glfw.MOD_CONTROL
    control = modifiers == glfw.MOD_CONTROL
    if control and key == glfw.KEY_T:
        return commands.EditLineUp(not is_open)
    if not is_open:
        return None
    if key in ARROWS and modifiers in STEPS_PX:
        right, down = (STEPS_PX[modifiers] * step for step in ARROWS[key])
        return commands.MoveLineUp(right, down)
    back = "previous" if modifiers == glfw.MOD_SHIFT else "next"
    if key == glfw.KEY_TAB:
        return commands.ChooseLineUp(point=back)
    if key in (glfw.KEY_PAGE_UP, glfw.KEY_PAGE_DOWN):
        return commands.ChooseLineUp("next" if key == glfw.KEY_PAGE_DOWN else "previous")
    if control and key == glfw.KEY_Z:
        return commands.UndoLineUp()
    if control and key == glfw.KEY_Y:
        return commands.RedoLineUp()
    if control and key == glfw.KEY_S:
        return commands.SaveLineUp()
    return None
