"""Vision of a fish: view volume and occlusion (Tu §6.3, §6.4)."""

import math

from subsea.base.arrays import Array
from subsea.geometry.rotation import x_axis
from subsea.geometry.solids import (
    misses_rocks,
    passes_over_all,
    ray_meets_pillar,
    ray_meets_rock,
    ray_meets_seabed,
)
from subsea.geometry.vector import Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import Fishes, Nature, Sea
from subsea.state.places import place_near

FIELD_COS = math.cos(math.radians(150.0))  # half of the field of 300 degrees
# Points of the centre line, from snout to tail, that are tested for occlusion, the middle first.
# A solid that hides all five is as long as the fish and hides all 23 nodes too.
BODY_SHARES = (0.5, 0.25, 0.75, 0.0, 1.0)
# Most multiples of V_r: water reduces contrast exponentially.
FARTHEST = 3.0
SUBMARINE_CM = 300.0  # length of the submarine as fishes see it


@kernel
def ahead_of(fishes: Fishes, i: int) -> Vector:
    """Unit vector along the x axis of the body."""
    return x_axis(fishes.orientation[i])


@kernel
def eye_of(fishes: Fishes, i: int) -> Vector:
    """The cyclopean origin: the tip of the snout, cm, world."""
    return along_body(fishes, i, 0.0)


@kernel
def along_body(fishes: Fishes, i: int, share: float) -> Vector:
    """A point on the centre line, `share` of the body length behind the snout, cm, world.

    The line is taken as straight: bends of a swimming body are less than a tenth of its length.
    """
    return along_from(vector(fishes.position[i]), fishes, i, share)


@kernel
def along_body_near(fishes: Fishes, j: int, share: float, here: Vector) -> Vector:
    """The same point of another fish j, in a box on its image nearest to `here`."""
    return along_from(place_near(fishes, j, here), fishes, j, share)


@kernel
def along_from(origin: Vector, fishes: Fishes, i: int, share: float) -> Vector:
    """The same point if the origin of the body frame lies at `origin`."""
    along = float(fishes.snout[i]) - share * float(fishes.length[i])
    return plus(origin, times(along, ahead_of(fishes, i)))


@kernel
def sight(length: float, nature: Nature) -> float:
    """Range at which a thing of `length` cm is seen, V_r s^p, cm (Tu §6.3.1)."""
    return nature.vision_cm * min(length / nature.standard_cm, FARTHEST)


@kernel
def in_view(eye: Vector, ahead: Vector, p: Vector, reach: float) -> bool:
    """True if p lies in the view volume: within `reach` and less than 150 degrees from ahead."""
    ray = minus(p, eye)
    distance = norm(ray)
    return distance <= reach and (distance == 0.0 or dot(ray, ahead) > FIELD_COS * distance)


@kernel
def hidden(sea: Sea, eye: Vector, p: Vector) -> bool:
    """True if a pillar, a rock or the seabed occludes p; other fishes do not."""
    if passes_over_all(sea.skyline, sea.half_width, eye, p):
        return False
    for k in range(len(sea.pillars)):
        if ray_meets_pillar(sea.pillars[k], 0.0, eye, p) <= 1.0:
            return True
    clear = misses_rocks(sea.tops, sea.half_width, eye, p)
    for k in range(0 if clear else len(sea.rocks)):
        if ray_meets_rock(sea.rocks[k], 0.0, eye, p) <= 1.0:
            return True
    if min(eye[2], p[2]) > sea.crest:
        return False
    return ray_meets_seabed(sea.heights, sea.half_width, 0.0, eye, p) <= 1.0


@kernel
def sees_point(fishes: Fishes, i: int, sea: Sea, p: Vector, reach: float) -> bool:
    """True if fish i sees the point p within `reach` cm (Tu §6.4.1)."""
    eye = eye_of(fishes, i)
    return in_view(eye, ahead_of(fishes, i), p, reach) and not hidden(sea, eye, p)


@kernel
def sees_fish(fishes: Fishes, i: int, j: int, sea: Sea, nature: Nature) -> bool:
    """True if fish i sees fish j: middle in view, any point not occluded (Tu §6.4.2)."""
    eye = eye_of(fishes, i)
    reach = sight(float(fishes.length[j]), nature)
    there = place_near(fishes, j, eye)
    if not in_view(eye, ahead_of(fishes, i), there, reach):
        return False
    seen = False
    for share in BODY_SHARES:
        seen = seen or not hidden(sea, eye, along_from(there, fishes, j, share))
    return seen


@kernel
def sees_pillar(fishes: Fishes, i: int, pillar: Array, nature: Nature) -> bool:
    """True if a pillar is near enough to be seen: |P - O| - r < V_r (Tu §6.4.3).

    P is the point of the axis closest in height to the eye. Occlusion and the blind angle are
    neglected.
    """
    eye = eye_of(fishes, i)
    x, y, radius, top = pillar
    return norm(minus((x, y, min(eye[2], top)), eye)) - radius < nature.vision_cm


@kernel
def sees_box(fishes: Fishes, i: int, sea: Sea, box: Array, reach: float) -> bool:
    """True if any corner of a box, as of a cluster of seaweed, is seen (Tu §6.4.4)."""
    for corner in range(8):
        p = (
            float(box[3 if corner & 1 else 0]),
            float(box[4 if corner & 2 else 1]),
            float(box[5 if corner & 4 else 2]),
        )
        if sees_point(fishes, i, sea, p, reach):
            return True
    return False
