"""Suggested bindings: the parts of each kind of controller that the actions of a dive use.

An action has the same name as its field of `Hand`. A button that a controller lacks is left out,
or is on another part if the dive cannot do without.
"""

from collections.abc import Mapping
from typing import NamedTuple

HANDS = "/user/hand/left", "/user/hand/right"
HAND_INTERACTION = "XR_EXT_hand_interaction"
POSES = ("aim",)
STICKS = ("stick",)
AMOUNTS = "trigger", "squeeze"
BUTTONS = "primary", "secondary", "menu"
PULSES = ("haptic",)

CONTROLLER = {"aim": "input/aim/pose", "haptic": "output/haptic"}


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
            for hand, own in zip(HANDS, (self.left, self.right), strict=True)
            for action, part in {**self.both, **own}.items()
        ]


PROFILES = {
    "khr/simple_controller": Profile(
        CONTROLLER | {"trigger": "input/select/click", "menu": "input/menu/click"}
    ),
    "oculus/touch_controller": Profile(
        CONTROLLER
        | {
            "stick": "input/thumbstick",
            "trigger": "input/trigger/value",
            "squeeze": "input/squeeze/value",
        },
        {"primary": "input/x/click", "secondary": "input/y/click", "menu": "input/menu/click"},
        {"primary": "input/a/click", "secondary": "input/b/click"},
    ),
    "valve/index_controller": Profile(
        CONTROLLER
        | {
            "stick": "input/thumbstick",
            "trigger": "input/trigger/value",
            "squeeze": "input/squeeze/value",
            "primary": "input/a/click",
            "secondary": "input/b/click",
            "menu": "input/thumbstick/click",  # the system has its only other button
        }
    ),
    "htc/vive_controller": Profile(
        CONTROLLER
        | {
            "stick": "input/trackpad",
            "trigger": "input/trigger/value",
            "squeeze": "input/squeeze/click",
            "primary": "input/trackpad/click",
            "menu": "input/menu/click",
        }
    ),
    "microsoft/motion_controller": Profile(
        CONTROLLER
        | {
            "stick": "input/thumbstick",
            "trigger": "input/trigger/value",
            "squeeze": "input/squeeze/click",
            "primary": "input/trackpad/click",
            "secondary": "input/thumbstick/click",
            "menu": "input/menu/click",
        }
    ),
    "ext/hand_interaction_ext": Profile(
        {
            "aim": "input/aim/pose",
            "trigger": "input/pinch_ext/value",
            "squeeze": "input/grasp_ext/value",
        },
        extension=HAND_INTERACTION,
    ),
}
