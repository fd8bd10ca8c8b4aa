"""Pectoral fins and mouth, moved kinematically (Tu §5.5, appendix B)."""

import numpy as np
from numba import njit

from subsea.state import Fishes

REST_RAD = 0.55  # sweep of a relaxed fin away from the body
FLAP_RAD = 0.22  # amplitude of the idle flapping
EFFORT_RAD = 0.35  # added by hard climbing, diving or turning
BEAT_HZ = 1.1  # idle; a busy fin beats up to three times as fast
BREATH_HZ = 0.8  # at rest; an effort doubles it
GAPE = 0.45  # how far the mouth opens to breathe
FOLD_RAD = 0.35  # a fast fish folds its fins to the body


@njit(cache=True, error_model="numpy")
def flap(fishes: Fishes, dt: float) -> None:
    """Advance fins and breath: a·sin(b·t), where a and b grow with the effort (Tu B.1).

    In a turn the outer fin rows while the inner one is held out, as flat-bodied fishes do.
    """
    for i in range(len(fishes.species)):
        effort = abs(fishes.steering[i, 0]) + abs(fishes.steering[i, 1])
        effort = min(effort / 0.6, 1.0)
        slow = 1.0 - fishes.goal_speed[i]
        rate = BEAT_HZ * fishes.rate[i] * (1.0 + 2.0 * max(effort, slow))
        phase = fishes.fin_phase[i] + 2.0 * np.pi * rate * dt
        fishes.fin_phase[i] = phase % (2.0 * np.pi)
        swing = (FLAP_RAD + EFFORT_RAD * effort) * np.sin(phase)
        held = REST_RAD - FOLD_RAD * (1.0 - slow)
        lean = 0.5 * fishes.steering[i, 0]
        fishes.pectoral[i, 0] = held + swing + lean
        fishes.pectoral[i, 1] = held + swing * np.cos(0.6 * effort) - lean

        panting = max(effort, 1.0 - slow)
        breath = fishes.breath[i] + 2.0 * np.pi * BREATH_HZ * fishes.rate[i] * (1.0 + panting) * dt
        fishes.breath[i] = breath % (2.0 * np.pi)
        fishes.mouth[i] = GAPE * 0.5 * (1.0 - np.cos(breath))
