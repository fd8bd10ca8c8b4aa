"""Soft shadows on the sand, of fishes that swim low and of the submarine."""

from typing import Any, NamedTuple

import moderngl
import numpy as np

from subsea.base.arrays import Array
from subsea.frame.packet import FISH, KIND, ORIENTATION, POSITION, SCALE, Packet, RenderScene
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import height_at
from subsea.habitat.stone import SUN
from subsea.kernels import kernel
from subsea.rendering.gl.context import GpuOwner, replace_data
from subsea.rendering.gl.programs import ProgramVariants
from subsea.rendering.gl.shaders import set_uniforms
from subsea.state import HULL_CM
from subsea.view.camera import middle_eye

HIGHEST_CM = 200.0  # height over the sand from which on there is no shadow
FARTHEST_CM = 700.0  # distance from the eye, likewise
FADING_CM = 200.0  # a shadow fades over this distance before that
MOST = 600  # shadows
DARK = 0.62  # share of the light that is missing under a fish on the sand
LONG, WIDE = 0.46, 0.13  # half the shadow's length and width over the fish's length
SOFT = 0.16  # widening on each side over the height above the sand
SLOPE_CM = 18.0  # half the distance over which the slope of the sand is measured
COLUMNS = 10  # x, y, z; slopes along x and y; axis x, y; half length and width, cm; how dark


class Sand(NamedTuple):
    """The height field of the seabed."""

    heights: Array  # (n, n) cm
    half_width: float  # cm


class Caster(NamedTuple):
    """Something that casts a shadow."""

    x: float  # cm, world
    y: float
    z: float
    ax: float  # unit vector of its long axis, seen from above
    ay: float
    long: float  # half its length and width, cm
    wide: float
    share: float  # of the darkness of its shadow that its distance from the eye leaves


class SoftShadowRenderer(GpuOwner):
    """Draws one quad for each shadow."""

    def __init__(self, context: Any, scene: RenderScene) -> None:
        super().__init__()
        self._lengths = np.array(scene.recorded_length_cm, np.float64)
        self._sand = Sand(scene.terrain, float(scene.terrain_half_width_cm))
        self._records = np.zeros((MOST, COLUMNS), np.float32)
        self._number = 0
        self._programs = self.own(ProgramVariants(context, "blobs"))
        self._buffer = self.own(context.buffer(reserve=self._records.nbytes))
        content = [(self._buffer, "3f4 4f4 3f4 /i", "a_place", "a_lie", "a_size")]
        self._array = self._programs.array(content)

    def upload(self, packet: Packet, fishes: bool = True) -> None:
        """Compute and upload the shadows of a packet; without `fishes`, the submarine's alone."""
        eye = middle_eye(packet.views)
        vessel = eye if packet.vessel is None else np.asarray(packet.vessel, np.float64)
        records = packet.instances if fishes else packet.instances[:0]
        self._number = cast(records, self._lengths, self._sand, eye, vessel, self._records)
        if self._number:
            replace_data(self._buffer, self._records[: self._number])

    def draw(self, uniforms: dict[str, Any]) -> int:
        """Blend the shadows over the sand; returns the number of triangles."""
        if self._number:
            array = self._programs.variant(self._array, ("PASSES",) * ("u_passes" in uniforms))
            set_uniforms(array.program, **uniforms)
            array.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._number)
        return 2 * self._number


@kernel
def cast(
    instances: Array, lengths: Array, sand: Sand, eye: Array, vessel: Array, out: Array
) -> int:
    """Write the shadows into `out` (m, COLUMNS) and return their number.

    `instances` are those of a packet, `lengths` (s,) the recorded lengths of the species, cm. The
    submarine's shadow comes first, if it is low enough. Instances follow from the last to the
    first, so that a full `out` lacks those drawn coarsely and far away. Each fish has one shadow
    for all views, because a fish outside a view may darken sand within it.
    """
    hull = Caster(vessel[0], vessel[1], vessel[2], 1.0, 0.0, 0.8 * HULL_CM, 0.6 * HULL_CM, 1.0)
    number = _lay(hull, sand, out, 0)
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
        ax, ay, _ = x_axis(one[ORIENTATION])  # the direction of its snout, seen from above
        length = lengths[int(one[KIND])] * one[SCALE]
        flat = np.sqrt(ax * ax + ay * ay)
        ax, ay = (ax / flat, ay / flat) if flat > 1e-3 else (1.0, 0.0)
        long = max(LONG * flat, WIDE) * length
        wide = WIDE * length
        number = _lay(Caster(x, y, z, ax, ay, long, wide, share), sand, out, number)
    return number


@kernel
def _lay(caster: Caster, sand: Sand, out: Array, number: int) -> int:
    """Write a shadow where the sun's ray through the caster meets the sand.

    `number` shadows are there already; returns the new number.
    """
    heights, half_width = sand
    x, y, z, ax, ay, long, wide, share = caster
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
    # On a crest or in a trough: the mean height around.
    out[number, 2] = max(ground, 0.25 * (east + west + north + south))
    out[number, 3], out[number, 4] = (
        (east - west) / (2 * SLOPE_CM),
        (north - south) / (2 * SLOPE_CM),
    )
    out[number, 5], out[number, 6] = ax, ay
    out[number, 7], out[number, 8] = 1.35 * long + soft, 1.35 * wide + soft
    # The wider the shadow, the paler its middle.
    out[number, 9] = share * DARK * near * min(1.0, 1.6 * wide / (wide + soft))
    return number + 1
