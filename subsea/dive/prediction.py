"""Predict the pilot's eye, so that input shows without delay.

Fishes are drawn between the last two ticks, up to one tick late. The submarine is drawn between
the last tick and the next, which is predicted from the current helm.
"""

from copy import deepcopy

from subsea.submarine.helm import Helm
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
