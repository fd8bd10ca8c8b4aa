"""The interface of a headset to the dive, and its errors."""

from typing import NamedTuple, Protocol

from subsea.base.errors import UserError
from subsea.view.head import HeadEye, Pose


class HeadsetLostError(UserError):
    """The runtime or the headset ended; the message says so in one line."""


class Hand(NamedTuple):
    """The controller, or the tracked hand, in one hand."""

    aim: Pose | None = None  # where it points, along -z; None: not tracked
    stick: tuple[float, float] | None = None  # right and up, in [-1, 1]; None: it has no stick
    trigger: float = 0.0  # in [0, 1]; a pinch of a tracked hand
    squeeze: float = 0.0  # in [0, 1]; a fist of a tracked hand
    primary: bool = False  # the lower button: A or X
    secondary: bool = False  # the upper button: B or Y
    menu: bool = False


class HeadsetFrame(NamedTuple):
    """A frame that has begun."""

    eyes: tuple[HeadEye, ...]  # left and right, predicted for the time of display
    tracked: bool  # False: the poses are the last known ones
    visible: bool  # False: the runtime shows something else, so nothing needs to be drawn
    textures: tuple[int, ...]  # OpenGL's names of one for each eye to draw into; () if not visible


class Headset(Protocol):
    """A session of a headset's runtime, in the OpenGL context that is current.

    Every call may raise HeadsetLostError.
    """

    name: str  # of the runtime and of the headset, for people
    sizes: tuple[tuple[int, int], ...]  # of the pictures, pixels, left and right
    srgb: bool  # the textures hold values of sRGB, as a window does; False: linear ones
    hands: tuple[Hand, Hand]  # left and right, as of the last `poll`
    worn: bool  # True while the runtime shows the dive: from VISIBLE on
    focused: bool  # True while it takes input
    recentred: bool  # True if the runtime asks to take the head in the last `begin` as home

    def poll(self) -> None:
        """Process events and read the hands; call once a picture."""

    def begin(self) -> HeadsetFrame | None:
        """Wait for the runtime and begin a frame; None, at once, while the session does not run."""

    def end(self) -> None:
        """Show the frame that `begin` returned; call it for each."""

    def pulse(self, hand: int, strength: float, seconds: float) -> None:
        """Vibrate the controller in a hand (0 left, 1 right), with a strength in [0, 1]."""

    def close(self) -> None:
        """End the session and release everything."""
