"""The dive in a headset: its eyes look, its controllers steer, its panel shows the text."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from subsea.base.arrays import Array
from subsea.dive.pilot import Pilot
from subsea.frame.packet import Lamps
from subsea.stage.headset import head
from subsea.stage.headset.cabin import Cabin
from subsea.stage.headset.controllers import Hand, HeadsetFrame, HeadsetLostError
from subsea.stage.headset.openxr import OpenXrHeadset, open_headset
from subsea.state import PREDATOR
from subsea.ui.gamepad import GamepadState
from subsea.ui.gui import Gui
from subsea.ui.window_set import WindowSet
from subsea.view.display_rigs import cockpit
from subsea.view.front_screen import WHOLE, FrontView, TextViewport
from subsea.view.rig import CameraPose, CameraRig, pose_from_angles
from subsea.view.theatre_vessel import PANEL
from subsea.world.world import TICK_S, World

FADE_S, LONG_S = 1.5, 1800.0  # the picture fades in; time of use until a reminder
CLICKED, UNCLICKED = 0.6, 0.4  # of a trigger
PUSH_CM, FULL_PUSH_CM = 0.5, 4.0  # by which a solid moves the hull in a tick: felt; strongest
NEAR_CM = 250.0  # distance of a shark that is felt
SHARK_LENGTH_CM = 80.0  # of the smallest hunter that is felt
STRONGEST_PASS = 0.35
FULL_TURN, FULL_CLIMB = 0.7, 0.6  # rad by which a hand points aside, or up, for the most


def put_on(windows: WindowSet, gui: Gui, note: Callable[[str], None]) -> "HeadsetDisplay":
    """Connect the headset to the windows of a dive; a UserError if there is none.

    `note` shows a line to the diver.
    """
    display = HeadsetDisplay(open_headset(), windows.context, gui, windows.pilot, note)
    windows.gamepads.read_hands = display.gamepad
    windows.wait_for_display(False)
    return display


class HeadsetDisplay:
    """Connects a headset's session to the rig, the pilot and the gui of a dive."""

    def __init__(
        self,
        headset: OpenXrHeadset,
        context: Any,
        gui: Gui,
        pilot: Pilot,
        note: Callable[[str], None],
    ) -> None:
        """The `context` is the one that the session was opened in.

        Comfort follows the settings of the `pilot`; `note` shows a line to the diver.
        """
        self.headset = headset
        self.eyes: Sequence[head.HeadEye] = head.AT_REST
        self.home: head.Home = head.AT_ORIGIN
        self._context, self._gui, self._pilot, self._note = context, gui, pilot, note
        self._cabin = Cabin(context)
        self._frame: HeadsetFrame | None = None
        self._heading = 0.0  # rad, the one that is shown
        self._worn_since: float | None = None
        self._worn_told = False  # the time of use
        self._dark = 1.0  # the picture fades in
        self._last = self._mirrored = time.perf_counter()
        self._mirror: head.Mirror | None = None
        self._seated = False  # the home is where the head was
        self._clicked = False  # the trigger is down on the panel

    def rig(self, mirror: tuple[int, int]) -> CameraRig:
        """The rig, with a window of `mirror` pixels."""
        self._cabin.resize(mirror)
        return head.headset_rig(self.headset.sizes, self.eyes, mirror)

    def moved(self, rig: CameraRig) -> CameraRig:
        """The rig with its eyes where those of the head are."""
        viewports = [eye.viewport for eye in rig.eyes]
        return rig._replace(eyes=head.head_eyes(self.eyes, viewports, self.home))

    def steadied(self, rig: CameraRig) -> CameraRig:
        """The rig whose window shows a steadied part of what the left eye sees."""
        now, size = time.perf_counter(), rig.outputs[0]
        eye = self.moved(rig).eyes[0]
        self._mirror = head.mirror_of(eye, size, self._mirror, now - self._mirrored)
        self._mirrored = now
        return rig._replace(patches=(head.mirror_patch(self._mirror, eye, size), *rig.patches[1:]))

    def front_view(self, rig: CameraRig, observer: CameraPose) -> FrontView:
        """The view in the window, for an observer."""
        eye, size = self.moved(rig).eyes[0], rig.outputs[0]
        mirror = self._mirror or head.mirror_of(eye, size, None, 0.0)
        return FrontView(head.mirror_view(mirror, eye, observer, size), (-1.0, -1.0), (1.0, 1.0))

    def turned(self, observer: CameraPose) -> CameraPose:
        """The observer, level, with a heading that changes in steps if that was chosen."""
        heading = math.atan2(observer.forward[1], observer.forward[0])
        step = math.radians(self._pilot.settings.comfort.snap_turn_deg)
        if step > 0.0:
            heading = self._heading = head.snapped(heading, self._heading, step)
        return pose_from_angles(observer.eye, heading, 0.0)

    def recentre(self) -> None:
        """Take the head's place and direction as those of the pilot."""
        self._seated, self._dark = False, 1.0

    def pose(self, observer: CameraPose) -> CameraPose:
        """The pose of the head on an observer: the middle of its eyes."""
        return self._placed(observer, *self._middle())

    def lamps(self, observer: CameraPose) -> Lamps | None:
        """The lamp in the right or else the left hand; None if neither is tracked."""
        for hand in reversed(self.headset.hands):
            if hand.aim is not None:
                pose = self._placed(observer, *head.on_observer(hand.aim, self.home))
                return Lamps(np.stack([pose.eye] * 2), np.stack([pose.forward] * 2))
        return None

    def feel(self, world: World) -> None:
        """Let the diver's hands feel the last tick."""
        if not self.headset.focused:
            return
        strengths = hand_pulses(world, cockpit(world.state.submarine, 1.0))
        with suppress(HeadsetLostError):  # raised again by the next frame, not within a tick
            for hand, strength in enumerate(strengths.tolist()):
                if strength > 0.02:
                    self.headset.pulse(hand, strength, TICK_S)

    def begin(self) -> None:
        """Process events, wait for the headset and begin a frame, if its session runs."""
        self.headset.poll()
        if self._gui.open:
            self._point()
        self._note_use()
        self._frame = self.headset.begin()
        if self._frame is None:
            return
        self.eyes = self._frame.eyes
        if self.headset.recentred or (not self._seated and self._frame.tracked):
            self.home, self._seated = head.home_of(self.eyes), True

    @property
    def targets(self) -> Mapping[int, Any]:
        """Framebuffers of the eyes, by output; empty if nothing is shown there."""
        if self._frame is None or not self._frame.visible:
            return {}
        return {
            1 + k: self._cabin.eye(texture, self.headset.sizes[k])
            for k, texture in enumerate(self._frame.textures)
        }

    def text_viewports(self, window: TextViewport) -> tuple[TextViewport, ...]:
        """Viewports for text: of the window, and of the panel."""
        return (
            window._replace(page=lambda number: self._context.screen.use()),
            WHOLE._replace(page=self._use_panel),
        )

    def end(self, rig: CameraRig, light: Array, vignette: float) -> None:
        """Draw the vessel and the panel over the pictures, and show the frame."""
        if self._frame is None:
            return
        for (_, target), eye in zip(self.targets.items(), self.moved(rig).eyes, strict=False):
            self._cabin.draw_over(target, eye, light, vignette, self._dark)
        now = time.perf_counter()
        if self._frame.visible:
            self._dark = max(self._dark - (now - self._last) / FADE_S, 0.0)
        self._last = now
        self._context.screen.use()
        self._frame = None
        self.headset.end()

    def close(self) -> None:
        """End the session."""
        self._cabin.release()
        self.headset.close()

    def gamepad(self) -> GamepadState | None:
        """Both controllers as one gamepad, so that its bindings apply; None if neither is held."""
        left, right = self.headset.hands
        if not self.headset.focused:
            return None
        state = gamepad_of(left, right, self.home)
        if self._gui.open:  # the triggers click on the panel
            return state._replace(axes=(*state.axes[:4], -1.0, -1.0))
        return state

    def _use_panel(self, number: int) -> None:
        self._cabin.panel.use()
        self._cabin.panel.clear(0.0, 0.0, 0.0, 0.0)

    def _point(self) -> None:
        """Move the gui's pointer to where a controller, or else the head, points at the panel."""
        triggers = max(hand.trigger for hand in self.headset.hands)
        hit = self._pointed()
        if hit is not None:
            width, height = self._gui.points
            self._gui.pointed(hit[0] * width, hit[1] * height)
        clicked = triggers > (UNCLICKED if self._clicked else CLICKED)
        if clicked != self._clicked and (hit is not None or not clicked):
            self._clicked = clicked
            self._gui.pressed(0, clicked)

    def _pointed(self) -> tuple[float, float] | None:
        """Shares of the panel where it is pointed at; None beside it."""
        left, right = self.headset.hands
        for hand in sorted((right, left), key=lambda hand: -hand.trigger):
            if hand.aim is not None:
                offset, axes = head.on_observer(hand.aim, self.home)
                return PANEL.hit(offset, axes[2])
        offset, axes = self._middle()
        return PANEL.hit(offset, axes[2])

    def _middle(self) -> tuple[Array, Array]:
        """Offset (3,), cm, and axes (3, 3) of the middle of the eyes on the observer."""
        eyes = head.head_eyes(self.eyes, [(0, 0, 1, 1)] * len(self.eyes), self.home)
        return np.mean([eye.offset for eye in eyes], axis=0), eyes[0].axes

    def _placed(self, observer: CameraPose, offset: Array, axes: Array) -> CameraPose:
        """The pose of something on an observer."""
        own = observer.axes
        return CameraPose(observer.eye + offset @ own, axes[2] @ own, axes[1] @ own)

    def _note_use(self) -> None:
        """Fade in when it is put on; say once that it has been worn for long."""
        now = time.perf_counter()
        if not self.headset.worn:
            self._worn_since, self._worn_told, self._dark = None, False, 1.0
        elif self._worn_since is None:
            self._worn_since = now
        elif now - self._worn_since > LONG_S and not self._worn_told:
            self._worn_told = True
            self._note(f"{LONG_S / 60.0:.0f} minutes in the headset: time for a break")


def gamepad_of(left: Hand, right: Hand, home: head.Home = head.AT_ORIGIN) -> GamepadState:
    """The gamepad with the sticks, triggers and buttons of both controllers.

    A and B are right, X and Y left; squeezes are the bumpers, food is the pad's down. Without
    sticks the vessel goes where a hand points while it pulls its trigger.
    """
    if left.stick is None and right.stick is None:
        return _pointing(left, right, home)
    buttons = dict.fromkeys(range(15), False)
    buttons |= {0: right.primary, 1: right.secondary, 2: left.primary, 3: left.secondary}
    buttons |= {4: left.squeeze > CLICKED, 5: right.squeeze > CLICKED, 7: left.menu or right.menu}
    buttons[13] = left.feed or right.feed
    (x, y), (turn, nose) = (hand.stick or (0.0, 0.0) for hand in (left, right))
    sticks = x, -y, turn, -nose
    triggers = 2.0 * left.trigger - 1.0, 2.0 * right.trigger - 1.0
    return GamepadState("headset", [int(down) for down in buttons.values()], (*sticks, *triggers))


def _pointing(left: Hand, right: Hand, home: head.Home) -> GamepadState:
    """The gamepad of hands that point: a left fist is the menu, a right one scatters food."""
    buttons, axes = [0] * 15, [0.0, 0.0, 0.0, 0.0, -1.0, -1.0]
    buttons[7] = int(left.menu or right.menu or left.squeeze > CLICKED)
    buttons[13] = int(left.feed or right.feed or right.squeeze > CLICKED)
    hand = max((right, left), key=lambda one: one.trigger)
    if hand.aim is not None and hand.trigger > UNCLICKED:
        _, (_, _, (across, up, ahead)) = head.on_observer(hand.aim, home)
        course = math.atan2(across, ahead) / FULL_TURN
        axes[0] = min(max(course, -1.0), 1.0)
        axes[1] = -hand.trigger
        climb = min(max(math.asin(min(max(up, -1.0), 1.0)) / FULL_CLIMB, -1.0), 1.0)
        axes[5 if climb > 0.0 else 4] = 2.0 * abs(climb) - 1.0
    return GamepadState("headset", buttons, axes)


def hand_pulses(world: World, pilot: CameraPose) -> Array:
    """Strengths (2,) of the pulses in the left and right hand over the last tick, in [0, 1]."""
    submarine, fishes = world.state.submarine, world.state.fishes
    moved = submarine.position - submarine.previous_position
    push = float(np.linalg.norm(moved - TICK_S * submarine.velocity))
    knock = min(push / FULL_PUSH_CM, 1.0) if push > PUSH_CM else 0.0
    strengths = np.full(2, knock)
    big = fishes.alive & (world.state.minds.kind == PREDATOR) & (fishes.length > SHARK_LENGTH_CM)
    for i in np.flatnonzero(big):
        away = fishes.position[i] - pilot.eye
        near = STRONGEST_PASS * max(1.0 - float(np.linalg.norm(away)) / NEAR_CM, 0.0)
        side = int(away @ np.cross(pilot.forward, pilot.up) > 0.0)
        strengths[side] = max(strengths[side], near)
    return strengths
