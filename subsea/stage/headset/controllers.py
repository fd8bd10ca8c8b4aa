"""The controllers, or the tracked hands, of a session: their states, and vibration.

The functions get the module `xr` from their caller, the one module that imports it.
"""

from contextlib import suppress
from typing import Any

import numpy as np

from subsea.stage.headset.bindings import (
    AMOUNTS,
    BUTTONS,
    HANDS,
    POSES,
    PROFILES,
    PULSES,
    STICKS,
)
from subsea.stage.headset.session import Hand
from subsea.view.head import Pose

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
        self._set = xr.create_action_set(
            instance,
            xr.ActionSetCreateInfo(
                action_set_name="dive", localized_action_set_name="Dive", priority=0
            ),
        )
        kinds = xr.ActionType
        self._actions = {
            name: self._make_action(name, kind)
            for names, kind in (
                (POSES, kinds.POSE_INPUT),
                (STICKS, kinds.VECTOR2F_INPUT),
                (AMOUNTS, kinds.FLOAT_INPUT),
                (BUTTONS, kinds.BOOLEAN_INPUT),
                (PULSES, kinds.VIBRATION_OUTPUT),
            )
            for name in names
        }
        self._suggest(instance, extensions)
        xr.attach_session_action_sets(
            session, xr.SessionActionSetsAttachInfo(action_sets=[self._set])
        )
        self._aims = [
            xr.create_action_space(
                session,
                xr.ActionSpaceCreateInfo(action=self._actions["aim"], subaction_path=path),
            )
            for path in self._paths
        ]
        self._queries = [
            {
                name: xr.ActionStateGetInfo(action=action, subaction_path=path)
                for name, action in self._actions.items()
            }
            for path in self._paths
        ]

    def _make_action(self, name: str, kind: Any) -> Any:
        info = self._xr.ActionCreateInfo(
            action_name=name,
            action_type=kind,
            subaction_paths=self._paths,
            localized_action_name=name.capitalize(),
        )
        return self._xr.create_action(self._set, info)

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
            path = xr.string_to_path(instance, f"/interaction_profiles/{name}")
            with suppress(xr.PathUnsupportedError):  # a runtime that lacks this controller
                xr.suggest_interaction_profile_bindings(
                    instance,
                    xr.InteractionProfileSuggestedBinding(
                        interaction_profile=path, suggested_bindings=bindings
                    ),
                )

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
            for name in AMOUNTS
        )
        buttons = (
            bool(xr.get_action_state_boolean(session, queries[name]).current_state)
            for name in BUTTONS
        )
        aim = self._aim(number, space, time) if time else None
        return Hand(aim, moved, trigger, squeeze, *buttons)

    def _aim(self, number: int, space: Any, time: int) -> Pose | None:
        flags = self._xr.SpaceLocationFlags
        valid = flags.POSITION_VALID_BIT | flags.ORIENTATION_VALID_BIT
        found = self._xr.locate_space(self._aims[number], space, time)
        return pose_of(found.pose) if found.location_flags & valid == valid else None

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
