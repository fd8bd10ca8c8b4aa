"""The controllers, or tracked hands, of a headset's session, and what a dive gets from it.

Functions get the module `xr` from their caller, the one module that imports it. An action has the
same name as its field of `Hand`. A button that a controller lacks is left out, or is on another
part if the dive cannot do without.
"""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from subsea.dive.part import LostDisplayError
from subsea.stage.headset.head import HeadEye, Pose

HANDS = "/user/hand/left", "/user/hand/right"
HAND_INTERACTION = "XR_EXT_hand_interaction"
ACTIONS = {  # and their types in OpenXR
    "aim": "POSE_INPUT", "stick": "VECTOR2F_INPUT", "trigger": "FLOAT_INPUT",
    "squeeze": "FLOAT_INPUT", "primary": "BOOLEAN_INPUT", "secondary": "BOOLEAN_INPUT",
    "menu": "BOOLEAN_INPUT", "feed": "BOOLEAN_INPUT", "haptic": "VIBRATION_OUTPUT",
}  # fmt: skip


class Profile(NamedTuple):
    """A kind of controller: the part for each action, in both hands or in one of them."""

    both: Mapping[str, str]
    left: Mapping[str, str] = {}
    right: Mapping[str, str] = {}
    extension: str = ""  # of OpenXR, that has it

    def paths(self) -> list[tuple[str, str]]:
        """Pairs of an action and the full path of a part."""
        return [
            (action, f"{hand}/{part}")
            for hand, only in zip(HANDS, (self.left, self.right), strict=True)
            for action, part in {**self.both, **only}.items()
        ]


CONTROLLER = {"aim": "input/aim/pose", "haptic": "output/haptic"}
# The only other button of some controllers: in the left hand the menu, in the right one food.
MENU, FEED = {"menu": "input/menu/click"}, {"feed": "input/menu/click"}
WITH_STICK = CONTROLLER | {
    "stick": "input/thumbstick",
    "trigger": "input/trigger/value",
    "squeeze": "input/squeeze/value",
}
PROFILES = {
    "khr/simple_controller": Profile(CONTROLLER | {"trigger": "input/select/click"}, MENU, FEED),
    "oculus/touch_controller": Profile(
        WITH_STICK,
        {"primary": "input/x/click", "secondary": "input/y/click", "menu": "input/menu/click"},
        {"primary": "input/a/click", "secondary": "input/b/click",
         "feed": "input/thumbstick/click"},
    ),
    "valve/index_controller": Profile(
        WITH_STICK | {"primary": "input/a/click", "secondary": "input/b/click"},
        {"menu": "input/thumbstick/click"},  # the system has its only other button
        {"feed": "input/thumbstick/click"},
    ),
    "htc/vive_controller": Profile(WITH_STICK | {
        "stick": "input/trackpad", "squeeze": "input/squeeze/click",
        "primary": "input/trackpad/click",
    }, MENU, FEED),
    "microsoft/motion_controller": Profile(WITH_STICK | {
        "squeeze": "input/squeeze/click", "primary": "input/trackpad/click",
        "secondary": "input/thumbstick/click",
    }, MENU, FEED),
    "ext/hand_interaction_ext": Profile({
        "aim": "input/aim/pose", "trigger": "input/pinch_ext/value",
        "squeeze": "input/grasp_ext/value",
    }, extension=HAND_INTERACTION),
}  # fmt: skip


class HeadsetLostError(LostDisplayError):
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
    feed: bool = False  # scatter food


class HeadsetFrame(NamedTuple):
    """A frame that has begun."""

    eyes: tuple[HeadEye, ...]  # left and right, predicted for the time of display
    tracked: bool  # False: the poses are the last known ones
    visible: bool  # False: the runtime shows something else, so nothing needs to be drawn
    textures: tuple[int, ...]  # OpenGL's names of one for each eye to draw into; () if not visible


NO_HANDS = Hand(), Hand()


def pose_of(pose: Any) -> Pose:
    """A pose of the runtime as arrays."""
    place, turn = pose.position, pose.orientation
    return Pose(np.array([place.x, place.y, place.z]), np.array([turn.x, turn.y, turn.z, turn.w]))


class Controllers:
    """The action set of a session."""

    def __init__(self, xr: Any, instance: Any, session: Any, extensions: set[str]) -> None:
        """Make the actions, suggest their bindings and attach them to the session.

        `extensions` of OpenXR that are enabled.
        """
        self._xr, self._session = xr, session
        self._paths = [xr.string_to_path(instance, hand) for hand in HANDS]
        about = xr.ActionSetCreateInfo(
            action_set_name="dive", localized_action_set_name="Dive", priority=0
        )
        self._set = xr.create_action_set(instance, about)
        self._actions = {}
        for name, kind in ACTIONS.items():
            info = xr.ActionCreateInfo(
                action_name=name,
                action_type=getattr(xr.ActionType, kind),
                subaction_paths=self._paths,
                localized_action_name=name.capitalize(),
            )
            self._actions[name] = xr.create_action(self._set, info)
        self._suggest(instance, extensions)
        attached = xr.SessionActionSetsAttachInfo(action_sets=[self._set])
        xr.attach_session_action_sets(session, attached)
        aim = self._actions["aim"]
        spaces = [xr.ActionSpaceCreateInfo(action=aim, subaction_path=at) for at in self._paths]
        self._aims = [xr.create_action_space(session, space) for space in spaces]
        self._queries = [
            {
                name: xr.ActionStateGetInfo(action=action, subaction_path=path)
                for name, action in self._actions.items()
            }
            for path in self._paths
        ]

    def _suggest(self, instance: Any, extensions: set[str]) -> None:
        xr = self._xr
        for name, profile in PROFILES.items():
            if profile.extension and profile.extension not in extensions:
                continue
            bindings = [
                xr.ActionSuggestedBinding(
                    action=self._actions[action], binding=xr.string_to_path(instance, path)
                )
                for action, path in profile.paths()
            ]
            suggested = xr.InteractionProfileSuggestedBinding(
                interaction_profile=xr.string_to_path(instance, f"/interaction_profiles/{name}"),
                suggested_bindings=bindings,
            )
            with suppress(xr.PathUnsupportedError):  # a runtime that lacks this controller
                xr.suggest_interaction_profile_bindings(instance, suggested)

    def read(self, space: Any, time: int) -> tuple[Hand, Hand]:
        """The hands; their poses in a space at a time of the runtime, ns, 0 if unknown."""
        xr = self._xr
        active = xr.ActiveActionSet(action_set=self._set, subaction_path=0)
        try:
            xr.sync_actions(self._session, xr.ActionsSyncInfo(active_action_sets=[active]))
        except xr.SessionNotFocused:  # before the event that says so
            return NO_HANDS
        return self._hand(0, space, time), self._hand(1, space, time)

    def _hand(self, number: int, space: Any, time: int) -> Hand:
        xr, session, queries = self._xr, self._session, self._queries[number]
        stick = xr.get_action_state_vector2f(session, queries["stick"])
        moved = (stick.current_state.x, stick.current_state.y) if stick.is_active else None
        trigger, squeeze = (
            float(xr.get_action_state_float(session, queries[name]).current_state)
            for name in ("trigger", "squeeze")
        )
        buttons = (
            bool(xr.get_action_state_boolean(session, queries[name]).current_state)
            for name in ("primary", "secondary", "menu", "feed")
        )
        aim = self._aim(number, space, time) if time else None
        return Hand(aim, moved, trigger, squeeze, *buttons)

    def _aim(self, number: int, space: Any, time: int) -> Pose | None:
        flags = self._xr.SpaceLocationFlags
        valid = flags.POSITION_VALID_BIT | flags.ORIENTATION_VALID_BIT
        location = self._xr.locate_space(self._aims[number], space, time)
        return pose_of(location.pose) if location.location_flags & valid == valid else None

    def pulse(self, hand: int, strength: float, seconds: float) -> None:
        """Vibrate a controller; nothing for one that cannot."""
        xr = self._xr
        vibration = xr.HapticVibration(
            duration=max(round(seconds * 1e9), 1),
            frequency=xr.FREQUENCY_UNSPECIFIED,
            amplitude=min(max(strength, 0.0), 1.0),
        )
        info = xr.HapticActionInfo(action=self._actions["haptic"], subaction_path=self._paths[hand])
        with suppress(xr.SessionNotFocused):
            xr.apply_haptic_feedback(self._session, info, vibration)
