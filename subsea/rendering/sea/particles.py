"""Plankton, and marine snow about the eye that shows the speed of the submarine."""

from typing import Any

import moderngl
import numpy as np

from subsea.frame.in_sight import PLANKTON_REACH_CM
from subsea.frame.packet import Packet, RenderScene
from subsea.rendering.gl.owner import GpuOwner, replace_data
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.output.quality import PRESETS, Quality

SNOW = max(preset.snow for preset in PRESETS.values())  # most specks in the box about the eye
SNOW_BOX_CM = 520.0
SNOW_SINKS_CM_S = 1.5
SNOW_LOOK = {"u_diameter": 0.5, "u_colour": (0.50, 0.55, 0.53), "u_reach": 250.0}
PLANKTON_LOOK = {"u_diameter": 0.85, "u_colour": (0.75, 0.72, 0.62), "u_reach": PLANKTON_REACH_CM}


class ParticleRenderer(GpuOwner):
    """Draws points."""

    def __init__(self, context: Any, scene: RenderScene, quality: Quality) -> None:
        super().__init__()
        self.adapt(quality)
        places = np.random.default_rng(0x5A0).uniform(size=(SNOW, 3)).astype("f4")
        snow = self.own(context.buffer(places.tobytes()))
        self._places = self.own(context.buffer(reserve=12))
        self._seen = self.own(context.buffer(reserve=4))
        self._programs = self.own(ProgramVariants(context, "particles", None, self._wants))
        self._snow = self._programs.array([(snow, "3f4", "a_position")])
        self._plankton = self._programs.array([(self._places, "3f4", "a_position")], self._seen)
        self._current = scene.water.current_cm_s
        self._starts = [0]  # of the plankton of each view, and the end

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on, with at most SNOW specks."""
        self._specks = min(quality.snow, SNOW)
        self._wants = quality.close_up_defines

    def upload(self, packet: Packet) -> None:
        """Upload the plankton of a packet."""
        seen = packet.plankton_seen
        if seen is None:
            seen = (np.arange(len(packet.plankton)),) * len(packet.views)
        self._starts = np.cumsum([0, *map(len, seen)]).tolist()
        if self._starts[-1]:
            replace_data(self._places, np.ascontiguousarray(packet.plankton, "f4"))
            replace_data(self._seen, np.concatenate(seen).astype("i4"))

    def draw(self, packet: Packet, number: int, uniforms: dict[str, Any]) -> int:
        """Blend the points over a view; returns 0 triangles."""
        current = self._current if packet.current_cm_s is None else packet.current_cm_s
        uniforms = uniforms | {
            "u_drift": (*current, -SNOW_SINKS_CM_S),
            "u_passing": packet.passing_cm_s,
        }
        ready, wants = self._programs.ready, self._wants
        snow = ready(self._snow, False, wants, **uniforms, **SNOW_LOOK, u_box=SNOW_BOX_CM)
        snow.render(moderngl.POINTS, vertices=self._specks)
        first, end = self._starts[number : number + 2]
        if end > first:
            looks = uniforms | PLANKTON_LOOK
            plankton = ready(self._plankton, False, wants, **looks, u_box=0.0)
            plankton.render(moderngl.POINTS, vertices=end - first, first=first)
        return 0
