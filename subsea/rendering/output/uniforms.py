"""Uniforms that all shaders share: eye, water, time, lamps."""

from typing import Any

import numpy as np

from subsea.frame.packet import Packet
from subsea.rendering.gl.view_block import view_block
from subsea.rendering.output.daylight import light_uniforms
from subsea.scenario.schema import Water
from subsea.view.camera import View

SHAFTS_UNIT = 15  # texture unit that all shaders read
# Period of the shaders' time; waves and snow jump when it ends. Their float32 resolves 1 ms up to
# here, but only 8 ms after a day, and waves would jerk.
TIDE_S = 4 * 3600.0


def uniforms_of(packet: Packet, view: View, water: Water) -> dict[str, Any]:
    """The uniforms of a view."""
    both = view.projection.astype(np.float64) @ view.view.astype(np.float64)
    rows = np.array([view.view, view.projection, both, np.linalg.inv(both)], np.float32)
    matrices = rows.transpose(0, 2, 1).tobytes()  # in OpenGL's column-major order
    values = (
        {
            "u_view": matrices[:64],
            "u_projection": matrices[64:128],
            "u_view_projection": matrices[128:192],
            "u_inverse": matrices[192:],
            "u_eye": tuple(float(x) for x in view.eye),
            "u_size": (float(view.viewport[2]), float(view.viewport[3])),
            "u_without": float(view.without),
            "u_time": packet.time_s % TIDE_S,
            "u_caustics": 1,
            "u_noise": 2,
            "u_shafts": SHAFTS_UNIT,
        }
        | light_uniforms(water, view.eye)
        | _lamps(packet)
    )
    return values | {"view": view_block(values)}


def _lamps(packet: Packet) -> dict[str, Any]:
    """Positions and axes of the lamps; empty while they are off."""
    if packet.lamps is None:
        return {}
    places, ways = ([tuple(map(float, one)) for one in part] for part in packet.lamps)
    return {"u_lamps": places, "u_beams": ways}
