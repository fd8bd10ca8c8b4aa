"""What every shader may ask for of a view: where the eye is, the water, the time, the lamps."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.frame.packet import Packet
from subsea.scenario.schema import Water
from subsea.view.camera import View

SHAFTS_UNIT = 15  # texture unit: all shaders read it, so nothing else may use it
# After so long the shaders count time from 0 again, and waves and snow leap once. Their float32
# tells 1 ms apart up to then, but 8 after a day and 60 after a week: waves would move by jerks.
TIDE_S = 4 * 3600.0
CONTRAST_LEFT = 0.02  # at the distance that a scenario calls its visibility


def uniforms_of(packet: Packet, view: View, water: Water) -> dict[str, Any]:
    """What every shader may ask for."""
    both = view.projection.astype(np.float64) @ view.view.astype(np.float64)
    return {
        "u_view": _columns(view.view),
        "u_projection": _columns(view.projection),
        "u_view_projection": _columns(both),
        "u_inverse": _columns(np.linalg.inv(both)),
        "u_eye": tuple(float(x) for x in view.eye),
        "u_size": (float(view.viewport[2]), float(view.viewport[3])),
        "u_without": float(view.without),
        "u_time": packet.time_s % TIDE_S,
        "u_fog": water.fog,
        "u_extinction": -np.log(CONTRAST_LEFT) / water.visibility_cm,
        "u_caustics": 1,
        "u_noise": 2,
        "u_shafts": SHAFTS_UNIT,
    } | _lamps(packet)


def _lamps(packet: Packet) -> dict[str, Any]:
    """Where the lights are and the way they shine; nothing while they are off."""
    if packet.lamps is None:
        return {}
    places, ways = ([tuple(map(float, one)) for one in part] for part in packet.lamps)
    return {"u_lamps": places, "u_beams": ways}


def _columns(matrix: NDArray[np.floating[Any]]) -> bytes:
    """A matrix as OpenGL wants it: column after column."""
    return np.ascontiguousarray(matrix.T, dtype="f4").tobytes()
