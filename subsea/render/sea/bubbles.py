"""Air bubbles that rise from vents in the seabed to the surface (Tu §8.2)."""

from typing import Any

import moderngl
import numpy as np

from subsea.core.arrays import Array
from subsea.frame.packet import Packet, Scene
from subsea.render.gl.id_buffer import BUBBLES, ProgramVariants
from subsea.render.sea.seabed import drawn_height
from subsea.view.culling import IN_SIGHT

SLOWEST = 0.22  # share of a vent's largest diameter, as `bubbles.vert` throws its dice
STREAM_CM = 60.0  # a stream is no wider, but for the current


class BubbleRenderer:
    """Holds the slots of every vent; what is in them follows from the time, in the shader."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """Of the scene's vents, which stand on the drawn sand."""
        x, y = scene.vents[:, 0], scene.vents[:, 1]
        feet = drawn_height(scene.terrain, scene.terrain_half_width_cm, x, y)
        self._current = scene.water.current_cm_s
        self._reach = IN_SIGHT * scene.water.visibility_cm
        self._slots = [
            slots((x, y, float(z)), rate, size, number)
            for number, ((x, y, rate, size), z) in enumerate(zip(scene.vents, feet, strict=True))
        ]
        self._streams = [stream(slot, self._current) for slot in self._slots]
        self._drawn = ProgramVariants(context, "bubbles", BUBBLES)
        total = sum(len(slot) for slot in self._slots)
        self._buffer = context.buffer(reserve=max(32 * total, 32))
        self._array = self._drawn.array([(self._buffer, "4f4 4f4 /i", "a_vent", "a_slot")])

    def draw(
        self, packet: Packet, number: int, uniforms: dict[str, Any], marked: bool = False
    ) -> int:
        """Draw the vents in sight, blended, or their marks; the number of triangles."""
        view, current = packet.views[number], packet.current_cm_s
        if current is not None and current != self._current:
            self._current = current
            self._streams = [stream(slot, current) for slot in self._slots]
        seen = [
            slot
            for slot, ends in zip(self._slots, self._streams, strict=True)
            if in_sight(ends, view.planes, view.eye, self._reach)
        ]
        if not seen:
            return 0
        records = np.concatenate(seen)
        self._buffer.orphan()
        self._buffer.write(records.tobytes())
        array = self._drawn.ready(self._array, marked, **uniforms, u_current=self._current)
        array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=len(records))
        return 2 * len(records)

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self._drawn, self._buffer):
            held.release()


def terminal_speed(diameter: Array | float) -> Array:
    """Speed in cm/s at which a bubble of that diameter in cm rises in the end (Mendelson 1967)."""
    wave = np.sqrt(154.0 / np.asarray(diameter) + 495.0 * np.asarray(diameter))
    return np.asarray(np.minimum(wave, 280.0 * np.asarray(diameter)))


def slots(foot: tuple[float, float, float], rate: float, size: float, number: int) -> Array:
    """Records (n, 8) float32 of a vent at `foot`, cm, that lets go `rate` bubbles a second.

    The largest is `size` cm across. So many are under way at a time; those of a slot follow one
    another in the time that the slowest takes. They leave in bursts.
    """
    diameters = size * np.linspace(SLOWEST, 1.0, 50)
    slowest_s = -foot[2] / float(terminal_speed(diameters).min()) + 1.0
    count = int(np.ceil(rate * slowest_s))
    k = np.arange(count)
    burst = 9.0
    moment = (k + 0.85 * burst / (2 * np.pi) * np.sin(2 * np.pi * k / burst)) / rate
    out = np.empty((count, 8), np.float32)
    out[:, :3] = foot
    out[:, 3] = size
    out[:, 4] = moment + 0.37 * number
    out[:, 5] = count / rate
    out[:, 6] = k % 1000 + 0.1 * number
    out[:, 7] = 2.4 * number
    return out


def stream(records: Array, current_cm_s: tuple[float, float]) -> Array:
    """Where the bubbles (n, 8) of a vent leave and where the slowest arrives: (2, 3) cm."""
    x, y, z = (float(c) for c in records[0, :3])
    drift = np.asarray(current_cm_s) * float(records[0, 5])
    return np.array([[x, y, z], [x + drift[0], y + drift[1], 0.0]])


def in_sight(ends: Array, planes: Array, eye: Array, reach: float) -> bool:
    """Whether anything near the line between `ends` (2, 3) can be seen."""
    inside = ends @ planes[:, :3].T + planes[:, 3] > -STREAM_CM
    way = ends[1] - ends[0]
    share = np.clip((eye - ends[0]) @ way / max(float(way @ way), 1.0), 0.0, 1.0)
    near = np.linalg.norm(ends[0] + share * way - eye) < reach + STREAM_CM
    return bool(inside.any(axis=0).all() and near)
