"""Plankton, and marine snow that drifts about the eye and shows the speed of the submarine."""

from typing import Any

import moderngl
import numpy as np

from subsea.frame.packet import PLANKTON_REACH_CM, Packet, Scene
from subsea.render.gl.shaders import program, set_uniforms, wanted
from subsea.render.output.quality import PRESETS, Quality

SNOW = max(preset.snow for preset in PRESETS.values())  # specks in the box about the eye
SNOW_BOX_CM = 520.0
SNOW_SINKS_CM_S = 1.5
SNOW_LOOK = {"u_diameter": 0.55, "u_colour": (0.55, 0.62, 0.62), "u_reach": 250.0}
PLANKTON_LOOK = {"u_diameter": 1.0, "u_colour": (0.85, 0.88, 0.80), "u_reach": PLANKTON_REACH_CM}


class ParticleRenderer:
    """Holds the buffers of points."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Scatter the snow; the plankton comes with each packet."""
        self._context = context
        places = np.random.default_rng(0x5A0).uniform(size=(SNOW, 3)).astype("f4")
        self._snow = context.buffer(places.tobytes())
        self._plankton = context.buffer(reserve=12)
        self._seen = context.buffer(reserve=4)
        # The program and the arrays of snow and plankton; for lamps when these are first on.
        self._made: dict[tuple[str, ...], tuple[Any, Any, Any]] = {}
        self._make(())
        self._current = scene.water.current_cm_s
        self._starts = [0]  # of each view's specks, with the end
        self._specks = SNOW

    def adapt(self, quality: Quality) -> None:
        """So much snow from now on, at most SNOW specks."""
        self._specks = min(quality.snow, SNOW)

    def upload(self, packet: Packet) -> None:
        """Send the plankton."""
        seen = packet.plankton_seen
        if seen is None:
            seen = (np.arange(len(packet.plankton)),) * len(packet.views)
        self._starts = np.cumsum([0, *map(len, seen)]).tolist()
        if self._starts[-1]:
            for buffer, data in (
                (self._plankton, np.ascontiguousarray(packet.plankton, "f4")),
                (self._seen, np.concatenate(seen).astype("i4")),
            ):
                buffer.orphan(data.nbytes)
                buffer.write(data)

    def draw(self, packet: Packet, number: int, uniforms: dict[str, Any]) -> int:
        """Draw over what is there, blended; points count as no triangles."""
        if (wants := wanted(uniforms)) not in self._made:
            self._make(wants)
        compiled, snow, plankton = self._made[wants]
        current = self._current if packet.current_cm_s is None else packet.current_cm_s
        set_uniforms(
            compiled, **uniforms, **SNOW_LOOK,
            u_box=SNOW_BOX_CM, u_drift=(*current, -SNOW_SINKS_CM_S), u_passing=packet.passing_cm_s,
        )  # fmt: skip
        snow.render(moderngl.POINTS, vertices=self._specks)
        first, end = self._starts[number : number + 2]
        if end > first:
            set_uniforms(compiled, **PLANKTON_LOOK, u_box=0.0)
            plankton.render(moderngl.POINTS, vertices=end - first, first=first)
        return 0

    def _make(self, wants: tuple[str, ...]) -> None:
        compiled = program(self._context, "particles", **dict.fromkeys(wants, 1))
        snow, plankton = (
            self._context.vertex_array(compiled, [(buffer, "3f4", "a_position")], indices)
            for buffer, indices in ((self._snow, None), (self._plankton, self._seen))
        )
        self._made[wants] = compiled, snow, plankton

    def release(self) -> None:
        """Free every OpenGL object."""
        for compiled, snow, plankton in self._made.values():
            for held in (snow, plankton, compiled):
                held.release()
        for held in (self._snow, self._plankton, self._seen):
            held.release()
