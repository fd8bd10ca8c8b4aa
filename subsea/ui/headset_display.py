"""The dive in a headset: its eyes look, its controllers steer, its panel shows the text."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from subsea.core.arrays import Array
from subsea.core.errors import UserError
from subsea.dive.settings import Settings
from subsea.headset.openxr import open_headset
from subsea.headset.session import Hand, Headset, HeadsetFrame
from subsea.rendering.output.cabin import Cabin
from subsea.ui.gamepad import GamepadState
from subsea.ui.gui import Gui
from subsea.ui.window_set import WindowSet
from subsea.view.head import (
    AT_ORIGIN,
    HeadEye,
    Home,
    Pose,
    head_eyes,
    headset_rig,
    home_of,
    on_observer,
    snapped,
)
from subsea.view.panel import PANEL
from subsea.view.rig import CameraPose, CameraRig, pose_from_angles
from subsea.view.text_viewports import WHOLE, TextViewport

# Until the first frame: 90 degrees for each eye, 6.4 cm apart.
BEFORE = tuple(
    HeadEye(
        Pose(np.array([side * 0.032, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 1.0])),
        *np.radians([-45.0, 45.0, 45.0, -45.0]).tolist(),
    )
    for side in (-1.0, 1.0)
)
GOES_ON = "the dive goes on in the window"
CLICKED, UNCLICKED = 0.6, 0.4  # of a trigger


def put_on(
    windows: WindowSet, gui: Gui, settings: Settings, note: Callable[[str], None]
) -> "HeadsetDisplay | None":
    """Connect the headset to the windows of a dive; None, with a note, if there is none."""
    try:
        headset = open_headset()
    except UserError as fault:
        note(f"{fault}; {GOES_ON}")
        return None
    head = HeadsetDisplay(headset, windows.context, gui, settings.comfort.snap_turn_deg)
    windows.gamepads.read_hands = head.gamepad
    windows.wait_for_display(False)
    return head


class HeadsetDisplay:
    """Connects a headset's session to the rig, the pilot and the gui of a dive."""

    def __init__(self, headset: Headset, context: Any, gui: Gui, step_deg: float = 0.0) -> None:
        """The `context` is the one that the session was opened in.

        The view turns in steps of `step_deg`, or smoothly if that is 0.
        """
        self.headset = headset
        self.eyes: Sequence[HeadEye] = BEFORE
        self.home: Home = AT_ORIGIN
        self._context, self._gui = context, gui
        self._cabin = Cabin(context)
        self._frame: HeadsetFrame | None = None
        self._step, self._heading = math.radians(step_deg), 0.0  # the one that is shown
        self._seated = False  # the home is where the head was
        self._clicked = False  # the trigger is down on the panel

    def rig(self, mirror: tuple[int, int]) -> CameraRig:
        """The rig, with a window of `mirror` pixels."""
        self._cabin.resize(mirror)
        return headset_rig(self.headset.sizes, self.eyes, mirror)

    def moved(self, rig: CameraRig) -> CameraRig:
        """The rig with its eyes where those of the head are."""
        viewports = [eye.viewport for eye in rig.eyes]
        return rig._replace(eyes=head_eyes(self.eyes, viewports, self.home))

    def turned(self, observer: CameraPose) -> CameraPose:
        """The observer, level, with a heading that changes in steps if that was chosen."""
        heading = math.atan2(observer.forward[1], observer.forward[0])
        if self._step > 0.0:
            heading = self._heading = snapped(heading, self._heading, self._step)
        return pose_from_angles(observer.eye, heading, 0.0)

    def recentre(self) -> None:
        """Take the head's place and direction as those of the pilot."""
        self._seated = False

    def begin(self) -> None:
        """Process events, wait for the headset and begin a frame, if its session runs."""
        self.headset.poll()
        if self._gui.open:
            self._point()
        self._frame = self.headset.begin()
        if self._frame is None:
            return
        self.eyes = self._frame.eyes
        if self.headset.recentred or (not self._seated and self._frame.tracked):
            self.home, self._seated = home_of(self.eyes), True

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
            self._cabin.draw(target, eye, light, vignette)
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
        state = gamepad_of(left, right)
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
                offset, axes = on_observer(hand.aim, self.home)
                return PANEL.hit(offset, axes[2])
        eyes = head_eyes(self.eyes, [(0, 0, 1, 1)] * len(self.eyes), self.home)
        middle = np.mean([eye.offset for eye in eyes], axis=0)
        return PANEL.hit(middle, np.mean([eye.axes[2] for eye in eyes], axis=0))


def gamepad_of(left: Hand, right: Hand) -> GamepadState:
    """The gamepad with the sticks, triggers and buttons of both controllers.

    A and B are right, X and Y left; squeezes are the bumpers.
    """
    buttons = dict.fromkeys(range(15), False)
    buttons |= {0: right.primary, 1: right.secondary, 2: left.primary, 3: left.secondary}
    buttons |= {4: left.squeeze > CLICKED, 5: right.squeeze > CLICKED, 7: left.menu or right.menu}
    sticks = left.stick[0], -left.stick[1], right.stick[0], -right.stick[1]
    triggers = 2.0 * left.trigger - 1.0, 2.0 * right.trigger - 1.0
    return GamepadState("headset", [int(down) for down in buttons.values()], (*sticks, *triggers))
