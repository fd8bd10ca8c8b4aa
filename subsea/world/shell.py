"""Keep fishes in the shell of free water around stone off the stone as it is drawn.

A fish that feeds or hides there comes nearer than the solids that others avoid. Contact foresees a
straight way and a straight body. After the motion, this moves back what reaches into the stone.
"""

from subsea.base.arrays import Array, Ints
from subsea.geometry.rotation import quaternion, rotate
from subsea.geometry.vector import Vector, minus, norm, plus, store, times, vector
from subsea.habitat.formations import NEAR_CM, blocks_near, drawn_distance, outward
from subsea.kernels import kernel
from subsea.motor.containment import GAP_CM, PASSES, SWING
from subsea.motor.pose import ends
from subsea.state import Fishes, Sea


@kernel
def keep_off_drawn(who: Ints, fishes: Fishes, nodes: Array, sea: Sea, dt: float) -> None:
    """Move each of the fishes `who` in the shell out of the drawn stone by snout, middle and tail.

    `nodes` are the library's. As in `motor.containment.contain`, a body that fits nowhere near
    keeps the place and attitude of the last tick.
    """
    for i in who:
        if fishes.shell[i] <= 0.0 or not fishes.alive[i]:
            continue
        here = times(1.0, vector(fishes.position[i]))
        q = quaternion(fishes.orientation[i])
        nose, edge = ends(fishes, nodes, i)
        nose, edge = rotate(q, nose), rotate(q, edge)
        before = times(1.0, vector(fishes.previous_position[i]))
        length = float(fishes.length[i])
        blocks = blocks_near(sea.stones, here, length + NEAR_CM)
        place, free = here, len(blocks) == 0
        for _ in range(0 if free else PASSES):
            gap, way = _deepest(place, nose, edge, blocks)
            free = gap >= 0.0
            if free:
                break
            place = plus(place, times(GAP_CM - gap, way))
        if norm(minus(place, here)) == 0.0:
            continue
        if not free or norm(minus(place, here)) > norm(minus(here, before)) + SWING * length:
            place = before
            if not fishes.live[i]:
                store(fishes.orientation[i], quaternion(fishes.previous_orientation[i]))
        store(fishes.position[i], place)
        store(fishes.velocity[i], times(1.0 / dt, minus(place, before)))


@kernel
def _deepest(here: Vector, nose: Vector, edge: Vector, blocks: Array) -> tuple[float, Vector]:
    """The least gap, cm, of snout, middle and tail to the drawn stone, and the way out of it."""
    least, part = drawn_distance(blocks, here), here
    for end in (nose, edge):
        gap = drawn_distance(blocks, plus(here, end))
        if gap < least:
            least, part = gap, plus(here, end)
    return least, outward(blocks, part)[0]
