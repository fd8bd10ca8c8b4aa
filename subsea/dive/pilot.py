"""From input to helm: pointer, buttons, wheel, keys and sticks; and a prediction of the eye.

Independent of the window library. The pilot receives actions of inputs and a pointer in [-1, 1]
from the middle of the window (x right, y up), and returns one Helm a tick.

Fishes are drawn between the last two ticks, up to one tick late. The submarine is drawn between
the last tick and the next, predicted from the current helm, so that input shows without delay.
"""

import math
from copy import copy, deepcopy

from subsea.dive.settings import DEFAULTS, Action, Settings
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.view.display_rigs import cockpit
from subsea.view.rig import CameraPose
from subsea.world.step import steer
from subsea.world.world import World

CATCH_UP_S = 0.5  # to change from delayed to predicted, after a tour or a pause


class Prediction:
    """The delay at which the submarine is drawn: 0 or, on tours, 1 tick."""

    def __init__(self) -> None:
        """Start without delay."""
        self._delay = 0.0

    def update(self, elapsed_s: float, known: bool) -> None:
        """Reduce the delay `elapsed_s` later if the next tick is `known`; else set it to 1."""
        self._delay = max(self._delay - elapsed_s / CATCH_UP_S, 0.0) if known else 1.0

    def eye(self, world: World, alpha: float, helm: Helm) -> CameraPose:
        """The pilot's eye at `alpha` of the next tick, if the `helm` stays as it is."""
        submarine = world.state.submarine
        ahead = alpha - self._delay
        if ahead < 0.0:
            return cockpit(submarine, 1.0 + ahead)
        after = deepcopy(submarine)
        steer(world, after, helm)
        return cockpit(after, ahead)


DEAD_ZONE = 0.10  # of half the window: no turn
CURVE = 1.6  # exponent of the response: fine near the middle, strong at the edge
MOUSE_PITCH = 0.75  # share of the steepest pitch, for a pointer at the edge
WHEEL_STEP = 0.125  # of full thrust a notch
TAKE_S = 1.2  # the pointer takes the helm gradually, without a jolt when it enters
RELEASE_S = 0.35
SMOOTH_S = 0.12  # smoothing of keys
POINTER_MOVED = 0.01  # of half the window: less is noise
STICK_MOVED = 0.15  # of its range: less does not end a full stop


class Pilot:
    """The state of all steering inputs, and the helm that follows from it.

    The last input wins: a steering key takes the helm from a resting pointer, a moved pointer
    takes it back. A full stop lasts until any other input.
    """

    def __init__(self, settings: Settings = DEFAULTS) -> None:
        """Start without a pointer, held inputs or a set speed."""
        self.settings, self.bindings = settings, settings.bindings
        self.pointer: tuple[float, float] | None = None
        self._rested: tuple[float, float] | None = None  # where the pointer lost the helm
        self.held: dict[str, tuple[Action, float]] = {}  # by input: action and amount
        self._stopped: dict[str, float] = {}  # inputs that were held when a full stop began
        self.throttle = 0.0  # set with the wheel: share of full thrust in [-1, 1]
        self.stopping = False  # True during a full stop
        self.passive = False  # True while nobody may steer
        self.riding = False  # True while inputs turn the gaze of a ridden fish
        self._grip = 0.0
        self._smooth = Helm()
        self._active = False

    def set_riding(self, riding: bool) -> None:
        """Begin or end a ride on a fish: the submarine stops."""
        self.riding = riding
        self.full_stop()

    @property
    def gaze_rate(self) -> tuple[float, float]:
        """Speed at which keys turn the gaze of a fish: right and up, in [-1, 1]."""
        return self._axis("right", "left"), self._axis("up", "down")

    def point(self, x: float, y: float) -> None:
        """The pointer is at (x, y) in [-1, 1]² from the middle of the window."""
        here = (min(max(x, -1.0), 1.0), min(max(y, -1.0), 1.0))
        if self.pointer is None:
            self._rested = here  # the pointer entered: wait for a movement
        self.pointer = here
        if self._rested is not None and math.dist(here, self._rested) > POINTER_MOVED:
            self._rested = None
            self.stopping = False

    def pointer_left(self) -> None:
        """The pointer has left the window."""
        self.pointer = None
        self._rested = None

    def wheel(self, notches: float) -> None:
        """The wheel turned by `notches`, forward positive: change the set speed."""
        self.stopping = False
        self.throttle = min(max(self.throttle + notches * WHEEL_STEP, -1.0), 1.0)

    def hold(self, action: Action, name: str, amount: float = 1.0) -> None:
        """The input `name` is held for an `action`, at an `amount` in [0, 1]."""
        if amount <= 0.0:
            self.release(name)
            return
        if abs(amount - self._stopped.get(name, math.inf)) < STICK_MOVED:
            return
        self._stopped.pop(name, None)
        if action == "full stop":
            self.held[name] = action, amount
            self.full_stop()
            return
        self.held[name] = action, min(amount, 1.0)
        self.stopping = False
        if action in ("ahead", "astern"):
            self.throttle = 0.0  # takes precedence over the set speed
        if action in ("left", "right", "up", "down"):
            self._rested = self.pointer

    def release(self, name: str) -> None:
        """The input `name` was released."""
        self.held.pop(name, None)
        self._stopped.pop(name, None)

    def note_activity(self) -> None:
        """Note any input, bound or not."""
        self._active = True

    def was_active(self) -> bool:
        """True if there was any input since the last call."""
        active, self._active = self._active, False
        return active

    def reset(self) -> None:
        """Release the helm until there is input."""
        self.full_stop()
        self.stopping, self._smooth = False, Helm()

    def full_stop(self) -> None:
        """Brake, level and keep the heading until any other input."""
        self.stopping = True
        self.throttle = 0.0
        self._rested = self.pointer
        self._grip = 0.0
        self._stopped |= {name: amount for name, (_, amount) in self.held.items()}
        self.held.clear()

    def release_all(self) -> None:
        """Release all inputs: the window lost the keyboard."""
        self.held.clear()
        self._stopped.clear()
        self.pointer_left()

    def helm(self, dt: float) -> Helm:
        """The submarine's helm for the next `dt` seconds."""
        if self.passive:
            return NEUTRAL
        if self.riding:
            self._smooth = Helm(full_stop=True)
            return self._smooth
        return self.commanded(dt)

    def predicted(self, dt: float) -> Helm:
        """The result of `helm`, without changing the state."""
        return copy(self).helm(dt)

    def commanded(self, dt: float) -> Helm:
        """The helm of all inputs for the next `dt` seconds, of the submarine or a fish."""
        if self.stopping:
            self._smooth = Helm(full_stop=True)
            return self._smooth
        steering = self.pointer is not None and self._rested is None
        step = dt / TAKE_S if steering else -dt / RELEASE_S
        self._grip = min(max(self._grip + step, 0.0), 1.0)
        x, y = self.pointer or (0.0, 0.0)
        # With both buttons down the pointer lifts and lowers.
        lift = {"ahead", "astern"} <= {
            action for name, (action, _) in self.held.items() if name.startswith("mouse")
        }
        mouse, share = self.settings.mouse, self.settings.comfort.acceleration
        across, up = (self._grip * _answer(mouse.sensitivity * offset) for offset in (x, y))
        turn = across if mouse.steer else 0.0
        nose = up if mouse.steer and not lift else 0.0
        surge = 0.0 if lift else self._axis("ahead", "astern")
        asked = Helm(
            surge=share * _limited(self.throttle + surge),
            yaw=share * _limited(self._axis("left", "right") - turn),
            pitch=_limited(
                self._axis("up", "down") + MOUSE_PITCH * (-nose if mouse.invert_pitch else nose)
            ),
            heave=share * _limited(self._axis("rise", "dive") + (up if lift else 0.0)),
        )
        eased = 1.0 - math.exp(-dt / SMOOTH_S)
        old = self._smooth
        self._smooth = Helm(
            surge=old.surge + eased * (asked.surge - old.surge),
            yaw=old.yaw + eased * (asked.yaw - old.yaw),
            pitch=old.pitch + eased * (asked.pitch - old.pitch),
            heave=old.heave + eased * (asked.heave - old.heave),
        )
        return self._smooth

    def _axis(self, positive: Action, negative: Action) -> float:
        return self._amount(positive) - self._amount(negative)

    def _amount(self, action: Action) -> float:
        """The largest amount of the inputs held for an action."""
        return max((share for held, share in self.held.values() if held == action), default=0.0)


def _answer(offset: float) -> float:
    """Response in [-1, 1] to a pointer at `offset`: smooth, zero in the dead zone."""
    beyond = max(min(abs(offset), 1.0) - DEAD_ZONE, 0.0) / (1.0 - DEAD_ZONE)
    return math.copysign(beyond**CURVE, offset)


def _limited(value: float) -> float:
    return min(max(value, -1.0), 1.0)
