"""Soft shadows, on the sand, of fishes that swim low and of the vessel from which one looks."""

from typing import Any

import moderngl
import numpy as np

from subsea.core.arrays import Array
from subsea.core.kernels import kernel
from subsea.frame.packet import FISH, KIND, ORIENTATION, POSITION, SCALE, Packet, Scene
from subsea.geometry.height_field import height_at
from subsea.habitat.stone_shade import SUN
from subsea.render.gl.shaders import program, set_uniforms
from subsea.state import HULL_CM

HIGHEST_CM = 200.0  # who swims higher over the sand casts none
FARTHEST_CM = 700.0  # nor who is farther from the eye,
FADING_CM = 200.0  # and over the last of these the shadow fades away
MOST = 600  # shadows
DARK = 0.62  # share of the light that is missing under a fish that lies on the sand
LONG, WIDE = 0.46, 0.13  # half the shadow's length and width over the fish's length
SOFT = 0.16  # by this share of its height over the sand a shadow is wider all round
SLOPE_CM = 18.0  # half the distance over which the slope of the sand is taken
COLUMNS = 10  # x, y, z; slopes along x and y; axis x, y; half length and width, cm; how dark


class SoftShadowRenderer:
    """Holds one record a shadow."""

    def __init__(self, context: Any, scene: Scene) -> None:
        """`scene` says how long the species are and how the sand lies."""
        self._lengths = np.array(scene.recorded_length_cm, np.float64)
        self._heights, self._width = scene.terrain, scene.terrain_half_width_cm
        self._records = np.zeros((MOST, COLUMNS), np.float32)
        self._number = 0
        self._program = program(context, "blobs")
        self._buffer = context.buffer(reserve=self._records.nbytes)
        self._array = context.vertex_array(
            self._program, [(self._buffer, "3f4 4f4 3f4 /i", "a_place", "a_lie", "a_size")]
        )

    def upload(self, packet: Packet) -> None:
        """Find the shadows of a packet."""
        eye = np.mean([view.eye for view in packet.views], axis=0).astype(np.float64)
        vessel = eye if packet.vessel is None else np.asarray(packet.vessel, np.float64)
        self._number = cast(
            packet.instances, self._lengths, self._heights, self._width, eye, vessel, self._records
        )
        if self._number:
            self._buffer.orphan()
            self._buffer.write(self._records[: self._number].tobytes())

    def draw(self, uniforms: dict[str, Any]) -> int:
        """Darken the sand that has been drawn, blended; the number of triangles."""
        if self._number:
            set_uniforms(self._program, **uniforms)
            self._array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._number)
        return 2 * self._number

    def release(self) -> None:
        """Free every OpenGL object."""
        for held in (self._array, self._buffer, self._program):
            held.release()


@kernel
def cast(
    instances: Array,
    lengths: Array,
    heights: Array,
    half_width: float,
    eye: Array,
    vessel: Array,
    out: Array,
) -> int:
    """Write the records of shadows into `out` (m, COLUMNS) and return how many there are.

    `instances` are those of a packet, `lengths` (s,) the recorded lengths of the species, cm. The
    first one is that of the vessel, if it is low enough; the others follow from the last instance
    to the first, so that what is left out when `out` is full is drawn coarsely and far away. A fish
    casts one however often it is there, for all views: who is beside one may darken its sand.
    """
    number = _lay(
        vessel[0], vessel[1], vessel[2], 1.0, 0.0, 0.8 * HULL_CM, 0.6 * HULL_CM, 1.0, heights,
        half_width, out, 0,
    )  # fmt: skip
    most = 0.0
    for k in range(len(instances)):
        most = max(most, instances[k, FISH])
    has_one = np.zeros(int(most) + 1, np.bool_)
    for k in range(len(instances) - 1, -1, -1):
        if number == len(out):
            break
        one = instances[k]
        fish = int(one[FISH])
        if has_one[fish]:
            continue
        has_one[fish] = True
        x, y, z = one[POSITION]
        far = np.sqrt((x - eye[0]) ** 2 + (y - eye[1]) ** 2 + (z - eye[2]) ** 2)
        if far >= FARTHEST_CM:
            continue
        share = min((FARTHEST_CM - far) / FADING_CM, 1.0)
        a, b, c, d = one[ORIENTATION]
        # Where its snout points, seen from above.
        ax, ay = 1.0 - 2.0 * (c * c + d * d), 2.0 * (b * c + a * d)
        length = lengths[int(one[KIND])] * one[SCALE]
        flat = np.sqrt(ax * ax + ay * ay)
        ax, ay = (ax / flat, ay / flat) if flat > 1e-3 else (1.0, 0.0)
        long = max(LONG * flat, WIDE) * length
        wide = WIDE * length
        number = _lay(x, y, z, ax, ay, long, wide, share, heights, half_width, out, number)
    return number


@kernel
def _lay(
    x: float, y: float, z: float, ax: float, ay: float, long: float, wide: float,
    share: float, heights: Array, half_width: float, out: Array, number: int,
) -> int:  # fmt: skip
    """One shadow, where the sun's ray through (x, y, z) meets the sand; the number of all.

    `share` of its darkness is left at its distance from the eye.
    """
    high = z - height_at(heights, half_width, x, y)
    if high > HIGHEST_CM:
        return number
    x, y = x - high * SUN[0] / SUN[2], y - high * SUN[1] / SUN[2]
    ground = height_at(heights, half_width, x, y)
    high = max(z - ground, 0.0)
    near = 1.0 - high / HIGHEST_CM
    if near <= 0.0:
        return number
    east = height_at(heights, half_width, x + SLOPE_CM, y)
    west = height_at(heights, half_width, x - SLOPE_CM, y)
    north = height_at(heights, half_width, x, y + SLOPE_CM)
    south = height_at(heights, half_width, x, y - SLOPE_CM)
    soft = SOFT * high
    out[number, 0], out[number, 1] = x, y
    # On a crest or in a trough it lies on the mean of what is about it.
    out[number, 2] = max(ground, 0.25 * (east + west + north + south))
    out[number, 3], out[number, 4] = (
        (east - west) / (2 * SLOPE_CM),
        (north - south) / (2 * SLOPE_CM),
    )
    out[number, 5], out[number, 6] = ax, ay
    out[number, 7], out[number, 8] = 1.35 * long + soft, 1.35 * wide + soft
    # The wider it gets the less light is missing in its middle.
    out[number, 9] = share * DARK * near * min(1.0, 1.6 * wide / (wide + soft))
    return number + 1
