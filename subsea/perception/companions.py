"""Companions that a schooling fish perceives: those that it sees, and those that it feels.

Sight reaches farther, but not into the blind angle behind the fish, and less far in dim water. The
lateral line feels fishes nearby in all directions (Pitcher, Partridge and Wardle, Science 194:963,
1976: a blinded saithe kept its place in a school).
"""

import math

from subsea.base.arrays import Ints
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import dot, minus, norm, vector
from subsea.kernels import kernel
from subsea.perception.vision import FARTHEST, sight
from subsea.state import NOBODY, Fishes, Minds, Nature
from subsea.state.places import place_near
from subsea.state.school_rules import ATTENDED, BLIND_COS, LATERAL_LINE_BL, SIGHT_BL
from subsea.state.schools import known_by

# The distance of a reaction grows with the logarithm of light up to a saturation (Vogel and
# Beauchamp, Can. J. Fish. Aquat. Sci. 56:1293, 1999). Brightness is a share of that at the surface.
BRIGHT, DARK = 0.1, 1e-4  # sight is full above, and none below


@kernel
def clarity(light: float) -> float:
    """Share of its range at which a fish sees in water of a brightness."""
    if light <= DARK:
        return 0.0
    return min(math.log(light / DARK) / math.log(BRIGHT / DARK), 1.0)


@kernel
def sight_of_companions(fishes: Fishes, minds: Minds, i: int, nature: Nature) -> float:
    """Range at which fish i sees fishes of its size, cm."""
    length = float(fishes.length[i])
    own = minds.rules[minds.school_rule[i], SIGHT_BL] * length
    return clarity(float(minds.light[i])) * min(own, sight(length, nature))


@kernel
def keep_perceived(who: Ints, fishes: Fishes, minds: Minds, nature: Nature) -> None:
    """Remove from `minds.neighbour` what the fishes `who` neither see nor feel.

    Sets `company_mood` of those that school. Call it when `neighbour` and `light` are new.
    """
    for i in who:
        if not minds.schools[i]:
            continue
        rule = minds.rules[minds.school_rule[i]]
        seen = sight_of_companions(fishes, minds, i, nature)
        felt = rule[LATERAL_LINE_BL] * float(fishes.length[i])
        here, ahead = vector(fishes.position[i]), x_axis(fishes.orientation[i])
        kept, of_school, mood = 0, 0, 0.0
        school = known_by(minds, i)
        for j in minds.neighbour[i]:
            if j < 0:
                break
            way = minus(place_near(fishes, j, here), here)
            gap = norm(way)
            if gap > felt and (gap > seen or dot(way, ahead) <= rule[BLIND_COS] * gap):
                continue
            minds.neighbour[i, kept] = j
            kept += 1
            fellow = minds.schools[j] and known_by(minds, j) == school
            if of_school < rule[ATTENDED] and fellow:
                mood += float(minds.mood[j])
                of_school += 1
        minds.neighbour[i, kept:] = NOBODY
        minds.company_mood[i] = mood / max(of_school, 1)


@kernel
def sees_school(fishes: Fishes, minds: Minds, i: int, nature: Nature, gap: float) -> bool:
    """True if fish i sees its school, whose middle is `gap` cm away.

    It sees a companion, or the school as one large thing. A fish that only feels others does not
    know where the middle of its school is.
    """
    seen = sight_of_companions(fishes, minds, i, nature)
    if seen <= minds.rules[minds.school_rule[i], LATERAL_LINE_BL] * fishes.length[i]:
        return False
    large = clarity(float(minds.light[i])) * FARTHEST * nature.vision_cm
    return minds.neighbour[i, 0] >= 0 or gap < large
