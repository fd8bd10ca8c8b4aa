"""Where the pilot's eye is in a picture: in the present, so that a hand sees at once what it does.

Fishes are drawn between the last two ticks, up to one late: nobody knows yet what they will do.
What the submarine does the helm tells. So it is drawn between the last tick and the next, as that
will be if the helm stays as it is; and when it comes, the picture is just there.
"""

from copy import deepcopy

from subsea.submarine.helm import Helm
from subsea.view.display_rigs import cockpit
from subsea.view.rig import CameraPose
from subsea.world.step import steer
from subsea.world.world import World

CATCH_UP_S = 0.5  # who comes from a tour, or from the past, comes to the present so gently


class Prediction:
    """How far behind the present the submarine is drawn, in ticks."""

    def __init__(self) -> None:
        """It is drawn in the present."""
        self._late = 0.0

    def go_on(self, elapsed_s: float, known: bool) -> None:
        """So much time has passed; is the next tick `known`, or is one to be late as fishes are?"""
        self._late = max(self._late - elapsed_s / CATCH_UP_S, 0.0) if known else 1.0

    def eye(self, world: World, alpha: float, helm: Helm) -> CameraPose:
        """The pilot's eye, when `alpha` of the next tick has passed, in which `helm` holds."""
        submarine = world.state.submarine
        ahead = alpha - self._late
        if ahead < 0.0:
            return cockpit(submarine, 1.0 + ahead)
        after = deepcopy(submarine)
        steer(world, after, helm)
        return cockpit(after, ahead)
