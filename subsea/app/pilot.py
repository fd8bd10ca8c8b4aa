"""From hands to helm: what pointer, buttons, wheel and keys ask of the submarine.

Nothing here knows the window library. The pilot hears of actions by name and of a pointer in
[-1, 1] from the middle of the window (x right, y up), and gives one Helm a tick.
"""

import math
from typing import Literal

from subsea.submarine.helm import Helm

Action = Literal["ahead", "astern", "left", "right", "up", "down", "rise", "dive", "full stop"]

Button = Literal["left", "right", "middle"]

DEAD_ZONE = 0.10  # of half the window: here the submarine keeps its course
CURVE = 1.6  # exponent of the answer: fine near the middle, strong at the edge
MOUSE_PITCH = 0.75  # the pointer at the edge asks for this share of the steepest pitch
WHEEL_STEP = 0.125  # of full thrust a notch
TAKE_S = 1.2  # the pointer takes the helm gradually, so entering the window is no jolt
RELEASE_S = 0.35
SMOOTH_S = 0.12  # keys are on or off; the helm is not
HAND_MOVED = 0.01  # of half the window: less is a nudged table


class Pilot:
    """Holds what the visitor's hands do now, and hands out the helm.

    The last hand to move steers: a steering key takes the helm from a resting pointer, a
    moved pointer takes it back. A full stop holds until any hand asks for something else.
    """

    def __init__(self) -> None:
        """Hands off: no pointer, nothing held, no speed set."""
        self._pointer: tuple[float, float] | None = None
        self._rested: tuple[float, float] | None = None  # where the pointer lost the helm
        self._held: set[Action] = set()
        self._buttons: set[Button] = set()
        self._throttle = 0.0
        self._stopping = False
        self._grip = 0.0
        self._smooth = Helm()
        self._riding = False

    @property
    def riding(self) -> bool:
        """Whether the submarine is left alone, and hands turn the gaze of a fish."""
        return self._riding

    def ride(self, riding: bool) -> None:
        """Mount a fish, or come back: the submarine stops and waits."""
        self._riding = riding
        self.full_stop()

    @property
    def glance(self) -> tuple[float, float]:
        """How fast the keys turn the gaze of who is ridden: right and up, in [-1, 1]."""
        return self._axis("right", "left"), self._axis("up", "down")

    @property
    def throttle(self) -> float:
        """The speed set with the wheel, as a share of full thrust in [-1, 1]."""
        return self._throttle

    @property
    def stopping(self) -> bool:
        """Whether a full stop holds."""
        return self._stopping

    def point(self, x: float, y: float) -> None:
        """The pointer is at (x, y) in [-1, 1]² from the middle of the window."""
        here = (min(max(x, -1.0), 1.0), min(max(y, -1.0), 1.0))
        if self._pointer is None:
            self._rested = here  # it entered, or was there at the start: wait for a movement
        self._pointer = here
        if self._rested is not None and math.dist(here, self._rested) > HAND_MOVED:
            self._rested = None
            self._stopping = False

    def leave(self) -> None:
        """The pointer has left the window."""
        self._pointer = None
        self._rested = None

    def button(self, name: Button, down: bool) -> None:
        """A mouse button went down or up."""
        if not down:
            self._buttons.discard(name)
            return
        if name == "middle":
            self.full_stop()
            return
        self._buttons.add(name)
        self._stopping = False
        self._throttle = 0.0  # a hand on the button outranks the speed set before

    def wheel(self, notches: float) -> None:
        """The wheel turned by `notches`, away from the hand positive: set a lasting speed."""
        self._stopping = False
        self._throttle = min(max(self._throttle + notches * WHEEL_STEP, -1.0), 1.0)

    def key(self, action: Action, down: bool) -> None:
        """A key that means `action` went down or up."""
        if not down:
            self._held.discard(action)
            return
        if action == "full stop":
            self.full_stop()
            return
        self._held.add(action)
        self._stopping = False
        if action in ("ahead", "astern"):
            self._throttle = 0.0
        if action in ("left", "right", "up", "down"):
            self._rested = self._pointer

    def full_stop(self) -> None:
        """Brake, level, hold the heading, until a hand asks for something else."""
        self._stopping = True
        self._throttle = 0.0
        self._rested = self._pointer
        self._grip = 0.0
        self._held.clear()
        self._buttons.clear()

    def let_go(self) -> None:
        """The window lost the keyboard: no key or button counts as held any more."""
        self._held.clear()
        self._buttons.clear()
        self.leave()

    def helm(self, dt: float) -> Helm:
        """What the hands ask for over the next `dt` seconds."""
        if self._stopping or self._riding:
            self._smooth = Helm(full_stop=True)
            return self._smooth
        steering = self._pointer is not None and self._rested is None
        step = dt / TAKE_S if steering else -dt / RELEASE_S
        self._grip = min(max(self._grip + step, 0.0), 1.0)
        x, y = self._pointer or (0.0, 0.0)
        lift = {"left", "right"} <= self._buttons  # both buttons: the pointer lifts and lowers
        aim = self._grip * _answer(y)
        asked = Helm(
            surge=self._surge(lift),
            yaw=_limited(self._axis("left", "right") - self._grip * _answer(x)),
            pitch=_limited(self._axis("up", "down") + (0.0 if lift else MOUSE_PITCH * aim)),
            heave=_limited(self._axis("rise", "dive") + (aim if lift else 0.0)),
        )
        share = 1.0 - math.exp(-dt / SMOOTH_S)
        old = self._smooth
        self._smooth = Helm(
            surge=old.surge + share * (asked.surge - old.surge),
            yaw=old.yaw + share * (asked.yaw - old.yaw),
            pitch=old.pitch + share * (asked.pitch - old.pitch),
            heave=old.heave + share * (asked.heave - old.heave),
        )
        return self._smooth

    def _surge(self, lift: bool) -> float:
        buttons = 0.0
        if not lift:
            buttons = float("left" in self._buttons) - float("right" in self._buttons)
        return _limited(self._throttle + buttons + self._axis("ahead", "astern"))

    def _axis(self, positive: Action, negative: Action) -> float:
        return float(positive in self._held) - float(negative in self._held)


def _answer(offset: float) -> float:
    """The helm in [-1, 1] for a pointer `offset` in [-1, 1]; zero in the dead zone, smooth."""
    beyond = max(abs(offset) - DEAD_ZONE, 0.0) / (1.0 - DEAD_ZONE)
    return math.copysign(beyond**CURVE, offset)


def _limited(value: float) -> float:
    return min(max(value, -1.0), 1.0)
