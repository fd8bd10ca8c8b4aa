"""The focusser: targets of intentions, and motor preferences (Tu §6.5, §7.6)."""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.rotation import conjugate, rotate
from subsea.geometry.solids import (
    far_from_rock,
    from_pillar,
    from_rock,
    height_at,
    is_far_from_rocks,
)
from subsea.geometry.vector import Vector, dot, minus, norm, times, vector
from subsea.kernels import kernel
from subsea.kernels.threads import share
from subsea.perception.collision import ANTENNA_BL, caution
from subsea.perception.foraging import perceives, price_of
from subsea.perception.vision import ahead_of, along_body_near, eye_of, sees_fish
from subsea.state import (
    ASCEND,
    AVOID,
    BACKWARD,
    DESCEND,
    EAT,
    ESCAPE,
    FEAR,
    FORWARD,
    HUNGER,
    LEFT,
    LIBIDO,
    MATE,
    NO_COURTSHIP,
    NOBODY,
    PREDATOR,
    RIGHT,
    RUSHING,
    SUBMARINE,
    Clock,
    Fishes,
    Minds,
    Nature,
    Sea,
)
from subsea.state.feelings import feeling_for
from subsea.state.places import place_near

COMPROMISE = 0.2  # p of Tu §6.5.3: weight of motor preferences in desirability
STRANGER = 0.5  # factor on the desirability of a mate of another species
ENDEARS = 0.5  # desirability of a mate by the liking for it
STEEPEST = 0.6  # sine of the steepest climb or dive, as in `motor/controller.py`
ARC = 0.5  # share by which the way to a point straight behind is longer
TOWARD = 0.5  # cosine of the 60 degrees about an axis that count as its direction
ELBOW_BL = 0.6  # distance within which a companion is in the way
LEAST_PART = 1024  # fishes for which another thread pays
APPETISING_BL = 5.0  # range of food that sets motor preferences


def focus(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Set `minds.preference` and `minds.target` of the fishes `who`, whose intention is known.

    The target is the worst threat for avoiding, the most fearful predator for escaping, a speck
    or prey for eating, and a fish to court for mating, until the courtship goes on. Other
    intentions have no target. Objects that are gone or no longer perceived are dropped.
    """
    share(_focus, who, LEAST_PART, fishes, minds, sea, nature)


@kernel
def _focus(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature) -> None:
    set_preferences(who, fishes, minds, sea, nature)
    set_targets(who, fishes, minds, sea, nature)


@kernel
def set_targets(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature,
) -> None:  # fmt: skip
    """Set the target of each of the fishes `who`.

    A speck has the desirability D = 1 - d / O_r (Tu §6.5.3) for the way d to swim; for prey the
    least cost decides (§7.9.1). Males prefer near females, females large males, both their own
    species (§7.9.3), and both those that they like. The present target is kept while it is
    perceived, unless another is nearer, or cheaper to catch, by `devotion_cm` (§7.7.3).
    """
    desire, gaps = np.zeros(minds.foods.shape[1]), np.zeros(minds.foods.shape[1])
    for i in who:
        intention, now = minds.intention[i], np.int64(minds.target[i])
        eye, ahead = eye_of(fishes, i), ahead_of(fishes, i)
        devotion_cm = nature.devotion_cm * float(minds.devotion[i])
        if intention == AVOID:
            minds.target[i] = minds.threat[i]
        elif intention == ESCAPE:
            minds.target[i] = minds.predator[i]
        elif intention == EAT and minds.kind[i] == PREDATOR:
            best = minds.foods[i, 0]
            mine = now >= 0 and fishes.alive[now] and now != minds.conceded[i]
            if mine and minds.hunt[i] == RUSHING:
                best = now  # it is committed
            elif mine and best >= 0:
                toward = minus(place_near(fishes, now, eye), eye)
                if perceives(fishes, i, now, sea, nature, norm(toward)):
                    present = price_of(fishes, minds, i, now, eye, ahead)
                    other = price_of(fishes, minds, i, np.int64(best), eye, ahead)
                    best = now if present - other <= devotion_cm else best
            minds.target[i] = best
        elif intention == EAT:
            for k, speck in enumerate(minds.foods[i]):
                if speck >= 0:
                    gaps[k] = way_to(minus(vector(sea.plankton[speck]), eye), ahead)
                    desire[k] = max(1.0 - gaps[k] / nature.smell_cm, 0.0)
            k = most_desirable(fishes, i, minds.foods[i], desire, sea.plankton, minds.preference[i])
            best = minds.foods[i, k] if k >= 0 else -1
            if now >= 0 and best >= 0 and sea.absent[now] <= 0.0:
                gap = way_to(minus(vector(sea.plankton[now]), eye), ahead)
                if gap <= nature.smell_cm and gap - gaps[k] <= devotion_cm:
                    best = now
            minds.target[i] = best
        elif intention == MATE and minds.courtship[i] == NO_COURTSHIP:
            for k, j in enumerate(minds.mates[i]):
                if j >= 0:
                    length = float(fishes.length[j])
                    gaps[k] = norm(minus(place_near(fishes, j, eye), eye))
                    desire[k] = length / (length + float(fishes.length[i]))
                    if minds.male[i]:
                        desire[k] = max(1.0 - gaps[k] / nature.vision_cm, 0.0)
                    if fishes.species[i] != fishes.species[j]:
                        desire[k] *= STRANGER
                    desire[k] += ENDEARS * feeling_for(minds, i, j)
            k = most_desirable(
                fishes, i, minds.mates[i], desire, fishes.position, minds.preference[i]
            )
            best = minds.mates[i, k] if k >= 0 else NOBODY
            still = now >= 0 and best >= 0 and fishes.alive[now]
            if still and sees_fish(fishes, i, now, sea, nature):
                gap = norm(minus(place_near(fishes, now, eye), eye))
                if gap - gaps[k] <= devotion_cm:
                    best = now
            minds.target[i] = best


@kernel
def way_to(toward: Vector, ahead: Vector) -> float:
    """About how far a fish must swim to a point at `toward` (cm) from its mouth.

    The arc of its turn adds up to half of the distance, for a point straight behind; the way is
    no steeper than recorded motion allows.
    """
    distance = norm(toward)
    cosine = dot(toward, ahead) / max(distance, 1e-6)
    turn = np.arccos(min(max(cosine, -1.0), 1.0)) / np.pi
    return max(distance, abs(toward[2]) / STEEPEST) * (1.0 + ARC * turn)


@kernel
def most_desirable(
    fishes: Fishes, i: int, targets: Ints, desire: Array, place: Array, preference: Array
) -> int:
    """The target, of up to K, that fish i chooses, or -1 (Tu §6.5.3).

    `targets` (k,) index rows of `place`, -1 for none; `desire` (k,) is their desirability. The
    best wins if it is better than the next by more than p. Otherwise p M is added for the side on
    which each lies: left, right or front.
    """
    first, second = -1, -1
    for k in range(len(targets)):
        if targets[k] < 0:
            continue
        if first < 0 or desire[k] > desire[first]:
            first, second = k, first
        elif second < 0 or desire[k] > desire[second]:
            second = k
    if second < 0 or desire[first] - desire[second] > COMPROMISE:
        return first
    best, most = -1, -np.inf
    eye, q = eye_of(fishes, i), fishes.orientation[i]
    for k in range(len(targets)):
        if targets[k] >= 0:
            toward = to_body(q, minus(vector(place[targets[k]]), eye))
            side = FORWARD
            if abs(toward[2]) > toward[0]:
                side = RIGHT if toward[2] > 0.0 else LEFT
            worth = desire[k] + COMPROMISE * float(preference[side])
            if worth > most:
                best, most = k, worth
    return best


@kernel
def set_preferences(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature,
) -> None:  # fmt: skip
    """Set the motor preferences of each of the fishes `who` (Tu §6.5.2, §7.6).

    Each stimulus recommends the directions in which it lies, or warns of them, with the strength
    of its desire relative to the present intention. Recommendations and warnings are averaged
    separately and added.
    """
    sums, counts = np.zeros((2, 6)), np.zeros((2, 6))
    for i in who:
        sums[:] = 0.0
        counts[:] = 0.0
        eye, q = eye_of(fishes, i), fishes.orientation[i]
        strength = 1.0
        if minds.intention[i] == ESCAPE:
            strength = minds.mental[i, FEAR]
        elif minds.intention[i] == EAT:
            strength = minds.mental[i, HUNGER]
        elif minds.intention[i] == MATE:
            strength = minds.mental[i, LIBIDO]
        warn_of_fishes(fishes, i, np.int64(minds.threat[i]), minds.neighbour[i], sums, counts)
        warn_of_solids(fishes, i, sea, caution(minds, i, nature), sums, counts)
        fear = against(minds.mental[i, FEAR], strength)
        for j in minds.predators[i]:
            if j != NOBODY and fear > 0.0:
                danger = vector(sea.submarine) if j == SUBMARINE else place_near(fishes, j, eye)
                note(q, minus(danger, eye), -fear, sums, counts)
        hunger = against(minds.mental[i, HUNGER], strength)
        hunts = minds.kind[i] == PREDATOR
        for k in minds.foods[i]:
            if k >= 0 and hunger > 0.0:
                food = place_near(fishes, k, eye) if hunts else vector(sea.plankton[k])
                toward = minus(food, eye)
                if norm(toward) < APPETISING_BL * fishes.length[i]:
                    note(q, toward, hunger, sums, counts)
        libido = against(minds.mental[i, LIBIDO], strength)
        for j in minds.mates[i]:
            if j >= 0 and libido > 0.0:
                note(q, minus(place_near(fishes, j, eye), eye), libido, sums, counts)
        for side in range(6):
            good = sums[0, side] / max(counts[0, side], 1.0)
            bad = sums[1, side] / max(counts[1, side], 1.0)
            minds.preference[i, side] = good + bad


@kernel
def against(desire: float, strength: float) -> float:
    """The strength of a desire relative to the intention, at most 1 (Tu §7.6)."""
    return min(float(desire) / max(float(strength), 1e-6), 1.0)


@kernel
def warn_of_fishes(
    fishes: Fishes, i: int, threat: int, neighbour: Ints, sums: Array, counts: Array
) -> None:
    """Warn of the fish in `threat` and of companions that are too near."""
    here, q = vector(fishes.position[i]), fishes.orientation[i]
    if threat != NOBODY:
        note(q, minus(along_body_near(fishes, threat, 0.5, here), here), -1.0, sums, counts)
    for j in neighbour:
        if j == NOBODY:
            break
        gap = minus(place_near(fishes, j, here), here)
        elbow = ELBOW_BL * 0.5 * (fishes.length[i] + fishes.length[j])
        if j != threat and norm(gap) < elbow:
            note(q, gap, -1.0, sums, counts)


@kernel
def warn_of_solids(
    fishes: Fishes, i: int, sea: Sea, scale: float, sums: Array, counts: Array
) -> None:
    """Warn of obstacles within an antenna's length of the eye, which `scale` multiplies."""
    eye, q = eye_of(fishes, i), fishes.orientation[i]
    reach = scale * ANTENNA_BL * float(fishes.length[i])
    for k in range(len(sea.pillars)):
        normal, distance = from_pillar(sea.pillars[k], eye)
        if distance < reach:
            note(q, times(-1.0, normal), -1.0, sums, counts)
    clear = is_far_from_rocks(sea.tops, sea.half_width, eye, reach)
    for k in range(0 if clear else len(sea.rocks)):
        if far_from_rock(sea.rocks[k], eye, reach):
            continue
        normal, distance = from_rock(sea.rocks[k], eye)
        if distance < reach:
            note(q, times(-1.0, normal), -1.0, sums, counts)
    if -eye[2] < reach:
        note(q, (0.0, 0.0, 1.0), -1.0, sums, counts)
    if eye[2] - height_at(sea.floor, sea.half_width, eye[0], eye[1]) < reach:
        note(q, (0.0, 0.0, -1.0), -1.0, sums, counts)
    if sea.radius - norm((eye[0], eye[1], 0.0)) < reach:
        note(q, (eye[0], eye[1], 0.0), -1.0, sums, counts)


@kernel
def note(q: Array, toward: Vector, value: float, sums: Array, counts: Array) -> None:
    """Count a stimulus for each direction within 60 degrees of it."""
    x, y, z = to_body(q, times(1.0 / max(norm(toward), 1e-9), toward))
    sign = 0 if value > 0.0 else 1
    for side, along in (
        (LEFT, -z), (RIGHT, z), (FORWARD, x), (BACKWARD, -x), (ASCEND, y), (DESCEND, -y),
    ):  # fmt: skip
        if along > TOWARD:
            sums[sign, side] += value
            counts[sign, side] += 1.0


@kernel
def to_body(q: Array, v: Vector) -> Vector:
    """A vector in the axes of a body of orientation q: forward, up, right."""
    return rotate(conjugate(q), v)
