"""What is blended over a view last: plankton and marine snow, air bubbles, lines of diagrams."""

from typing import Any

import moderngl
import numpy as np

from subsea.base.arrays import Array, Bools
from subsea.frame.in_sight import PLANKTON_REACH_CM
from subsea.frame.packet import Packet, RenderScene
from subsea.geometry.vector import dot, minus, norm, plus, times, vector
from subsea.habitat.plankton import departures
from subsea.kernels import kernel
from subsea.rendering.gl.context import GpuOwner, replace_data
from subsea.rendering.gl.id_buffer import BUBBLES
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.shaders import program, set_uniforms
from subsea.rendering.output.quality import PRESETS, Quality
from subsea.rendering.sea.seabed import drawn_height
from subsea.view.camera import View
from subsea.view.culling import IN_SIGHT

SNOW = max(preset.snow for preset in PRESETS.values())  # most specks in the box about the eye
SNOW_BOX_CM = 520.0
SNOW_SINKS_CM_S = 1.5
SNOW_LOOK = {"u_diameter": 0.5, "u_colour": (0.50, 0.55, 0.53), "u_reach": 250.0}
PLANKTON_LOOK = {"u_diameter": 0.85, "u_colour": (0.75, 0.72, 0.62), "u_reach": PLANKTON_REACH_CM}


class ParticleRenderer(GpuOwner):
    """Draws plankton, and marine snow about the eye that shows the speed of the submarine."""

    def __init__(self, context: Any, scene: RenderScene, quality: Quality) -> None:
        super().__init__()
        self.adapt(quality)
        places = np.random.default_rng(0x5A0).uniform(size=(SNOW, 3)).astype("f4")
        snow = self.own(context.buffer(places.tobytes()))
        self._places = self.own(context.buffer(reserve=12))
        self._seen = self.own(context.buffer(reserve=4))
        self._programs = self.own(ProgramVariants(context, "particles", None, quality.defines))
        self._snow = self._programs.array([(snow, "3f4", "a_position")])
        self._plankton = self._programs.array([(self._places, "3f4", "a_position")], self._seen)
        self._current = scene.water.current_cm_s
        self._starts = [0]  # of the plankton of each view, and the end

    def adapt(self, quality: Quality) -> None:
        """Draw in this quality from now on, with at most SNOW specks."""
        self._specks = min(quality.snow, SNOW)

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
        ready = self._programs.ready
        snow = ready(self._snow, False, **uniforms, **SNOW_LOOK, u_box=SNOW_BOX_CM)
        snow.render(moderngl.POINTS, vertices=self._specks)
        first, end = self._starts[number : number + 2]
        if end > first:
            looks = uniforms | PLANKTON_LOOK
            plankton = ready(self._plankton, False, **looks, u_box=0.0)
            plankton.render(moderngl.POINTS, vertices=end - first, first=first)
        return 0


STREAM_CM = 60.0  # half width of a stream without current


class BubbleRenderer(GpuOwner):
    """Draws the bubbles of the vents in sight (Tu §8.2); the shader moves them by time alone."""

    def __init__(self, context: Any, scene: RenderScene, quality: Quality) -> None:
        super().__init__()
        x, y = scene.vents[:, 0], scene.vents[:, 1]
        feet = drawn_height(scene.terrain, scene.terrain_half_width_cm, x, y)
        self._current = scene.water.current_cm_s
        self._reach = IN_SIGHT * scene.water.visibility_cm
        self._slots = [
            slots((x, y, float(z)), rate, size, number)
            for number, ((x, y, rate, size), z) in enumerate(zip(scene.vents, feet, strict=True))
        ]
        self._streams = self._ends()
        self._held: list[bool] = []  # True for the vents whose slots are in the buffer
        self._count = 0  # of these slots
        self._programs = self.own(ProgramVariants(context, "bubbles", BUBBLES, quality.defines))
        total = sum(len(slot) for slot in self._slots)
        self._buffer = self.own(context.buffer(reserve=max(32 * total, 32)))
        self._array = self._programs.array([(self._buffer, "4f4 4f4 /i", "a_vent", "a_slot")])

    def draw(
        self, packet: Packet, number: int, uniforms: dict[str, Any], as_ids: bool = False
    ) -> int:
        """Blend bubbles over a view, or draw their ids; returns the number of triangles."""
        view, current = packet.views[number], packet.current_cm_s
        if current is not None and current != self._current:
            self._current = current
            self._streams = self._ends()
        if not self._slots:
            return 0
        eye = np.asarray(view.eye, np.float64)
        seen = in_sight(self._streams, view.planes, eye, self._reach).tolist()
        if not any(seen):
            return 0
        if seen != self._held:  # rarely changes
            self._held = seen
            records = np.concatenate([self._slots[k] for k, one in enumerate(seen) if one])
            replace_data(self._buffer, records)
            self._count = len(records)
        array = self._programs.ready(self._array, as_ids, **uniforms, u_current=self._current)
        array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._count)
        return 2 * self._count

    def _ends(self) -> Array:
        """The ends (k, 2, 3) of all streams."""
        ends = [stream(slot, self._current) for slot in self._slots]
        return np.array(ends, np.float64).reshape(-1, 2, 3)


def slots(foot: tuple[float, float, float], rate: float, size: float, number: int) -> Array:
    """Instances (n, 8) float32 of a vent at `foot`, cm, that emits `rate` bubbles a second.

    The largest is `size` cm across. There are as many slots as bubbles that rise at one time;
    each is reused after the time that the slowest bubble needs. Bubbles leave in bursts.
    """
    moments, period = departures(-foot[2], rate, size, number)
    count = len(moments)
    k = np.arange(count)
    out = np.empty((count, 8), np.float32)
    out[:, :3] = foot
    out[:, 3] = size
    out[:, 4] = moments
    out[:, 5] = period
    out[:, 6] = k % 1000 + 0.1 * number
    out[:, 7] = 2.4 * number
    return out


def stream(records: Array, current_cm_s: tuple[float, float]) -> Array:
    """The ends (2, 3) cm of the path of the slowest bubble among `records` (n, 8)."""
    x, y, z = (float(c) for c in records[0, :3])
    drift = np.asarray(current_cm_s) * float(records[0, 5])
    return np.array([[x, y, z], [x + drift[0], y + drift[1], 0.0]])


@kernel
def in_sight(streams: Array, planes: Array, eye: Array, reach: float) -> Bools:
    """True for each of the `streams` (k, 2, 3) that comes near what a view sees."""
    out = np.empty(len(streams), np.bool_)
    at = vector(eye)
    for k in range(len(streams)):
        low, high = vector(streams[k, 0]), vector(streams[k, 1])
        way = minus(high, low)
        share = min(max(dot(minus(at, low), way) / max(dot(way, way), 1.0), 0.0), 1.0)
        out[k] = norm(minus(plus(low, times(share, way)), at)) < reach + STREAM_CM
        for p in range(len(planes)):
            plane = planes[p, 0], planes[p, 1], planes[p, 2]
            away = max(dot(plane, low), dot(plane, high)) + planes[p, 3]
            out[k] = out[k] and away > -STREAM_CM
    return out


THINNEST_PX, SHARE = 1.3, 1 / 480  # least width, and share of the picture's height
COLUMNS = 11  # of an instance: both ends, colour, lift


class LineRenderer(GpuOwner):
    """Draws the lines of a packet, one instance each, as quads that solids hide.

    They are on the canvas, so that every kind of output shows them. The shader inverts the tone
    curve, so that a line has the colour asked for.
    """

    def __init__(self, context: Any) -> None:
        super().__init__()
        self._program = self.own(program(context, "lines"))
        self._buffer = self.own(context.buffer(reserve=4 * COLUMNS))
        names = "a_from", "a_to", "a_colour", "a_lift"
        content = [(self._buffer, "3f4 3f4 4f4 1f4 /i", *names)]
        self._array = self.own(context.vertex_array(self._program, content))

    def upload(self, packet: Packet) -> None:
        """Upload the lines of a packet."""
        ends, colours, lift = packet.lines
        if len(ends):
            records = np.concatenate([ends.reshape(-1, 6), colours, lift[:, None]], axis=1)
            replace_data(self._buffer, np.ascontiguousarray(records, "f4"))

    def draw(self, packet: Packet, number: int, view: View, uniforms: dict[str, Any]) -> int:
        """Blend all lines over a view; returns the number of triangles.

        They do not belong to the light of the sea.
        """
        count = 0 if "u_passes" in uniforms else len(packet.lines.ends)
        if not count or (packet.lined is not None and number >= packet.lined):
            return 0
        width = max(SHARE * view.viewport[3], THINNEST_PX)
        set_uniforms(self._program, **uniforms, u_width=width)
        self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=count)
        return 2 * count
