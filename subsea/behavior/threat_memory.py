"""Remember threats: fear fades within seconds, alarm spreads by sight, a harmless hull is let near.

A fish remembers where it last perceived what it fears. Its fear fades with the time constant
`fear_s`, whether the threat is in its blind angle, behind a rock or far away. Prey of reefs return
to what they did 5 to 30 s after a predator has gone.

Companions that start show a fish an attack that it does not see: a wave of alarm runs through a
school faster than the predator (Radakov, Schooling in the Ecology of Fish, 1973). A fish starts if
the share of its companions that do is large enough (Rosenthal et al., PNAS 112:4690, 2015).

Prey grow used to a submarine that does nothing (habituation), and forget this within minutes.
"""

import math

import numpy as np

from subsea.geometry.vector import Vector, dot, minus, norm, store, vector
from subsea.kernels import kernel
from subsea.state import ALARM as ALARM_SCENT
from subsea.state import FEAR, NOBODY, PREY, SUBMARINE, Fishes, Minds, Nature, Sea
from subsea.state.places import place_near

# Least fear of what alarms a fish, a predator or companions that start, over f0: so alarm lasts for
# 0.47 fear_s after the last sight.
ALARMING = 1.6
RECOGNISED = 0.5  # fear of what is in sight, over the fear remembered, to be its cause
KNOWN = 3.0  # time constants for which a fish knows where the threat was
ATTENDED = 4  # nearest companions at which a fish looks for alarm
# Companions that started within the time since the last look and STARTED_S alarm a fish if they
# are at least the share CALM_SHARE of those, or AFRAID_SHARE for one in full fear.
STARTED_S, CALM_SHARE, AFRAID_SHARE = 0.1, 0.7, 0.2
LEAST_CALM_S = 1.5  # time since its own start until those of companions alarm a fish
# Evidence of an attack, s at the threshold of looming: companions that start are more than enough.
WARNED_S, UNSURE_S = 1.0, 0.09
# Most fear by smell, and the strength of alarm substance, 1/m³, that causes it.
WARY, ALARMING_SCENT = 0.2, 0.05
RUSH_CM_S = 70.0  # speed of approach of the submarine from which it is feared again ...
RENEWED_S = 1.0  # ... within this time constant
FORGOTTEN_S = 240.0  # time constant of the habituation's loss
NEAR = 0.5  # fear of a new submarine, over f0, within which a fish grows used to it
LEAST_DREAD = 0.3  # share of the submarine's D₀ that is left for fishes that are used to it


@kernel
def felt_fear(fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature) -> float:
    """Compute the fear of prey i: of what it perceives, or what is left of its last fear.

    Update the place of the threat, and the time since it was perceived.
    """
    faded = float(minds.mental[i, FEAR])
    if faded > 0.0:
        faded *= math.exp(-float(minds.pause[i]) / nature.fear_s)
    present = float(minds.menaces[i])
    j = minds.predator[i]
    if j != NOBODY and present > 0.0 and present >= RECOGNISED * faded:
        minds.unseen[i] = 0.0
        store(minds.threat_place[i], place_of(fishes, sea, j, vector(fishes.position[i])))
    else:
        minds.unseen[i] += minds.pause[i]
    if present > nature.alarmed:
        present = max(present, ALARMING * nature.alarmed)
    present += fear_of_scent(float(minds.scent[i, ALARM_SCENT]))
    return max(present, faded, _alarm(fishes, minds, i, sea, nature))


@kernel
def fear_of_scent(scent: float) -> float:
    """Fear that the smell of alarm substance, 1/m³, adds: prey that smells it is more vigilant.

    Minnows that smell the skin of a wounded companion take fright earlier (von Frisch,
    Z. vergl. Physiol. 29:46, 1941).
    """
    return WARY * min(scent / ALARMING_SCENT, 1.0)


@kernel
def _alarm(fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature) -> float:
    """Fear by the sight of companions that start, or 0; fish i is then ready to start, too.

    It learns from them where the threat is.
    """
    minds.alert[i] = min(minds.alert[i], np.float32(UNSURE_S))
    before = np.float32(STARTED_S) + minds.pause[i]
    count, started, first = 0, 0, NOBODY
    for j in minds.neighbour[i, :ATTENDED]:
        if j < 0:
            break
        count += 1
        if minds.startled[j] < before:
            started += 1
            first = j if first == NOBODY else first
    needed = CALM_SHARE + (AFRAID_SHARE - CALM_SHARE) * float(minds.mental[i, FEAR])
    if started == 0 or started < needed * count or minds.startled[i] < LEAST_CALM_S:
        return 0.0
    minds.alert[i] = WARNED_S
    if minds.unseen[i] > 0.0:
        j = minds.predator[first]
        here, source = vector(fishes.position[i]), first if j == NOBODY else j
        place = place_of(fishes, sea, source, here)
        store(minds.threat_place[i], place)
        minds.unseen[i] = minds.pause[i]
    return min(ALARMING * nature.alarmed, 1.0)


@kernel
def is_warned(minds: Minds, i: int) -> bool:
    """True if companions of fish i have just started."""
    return minds.alert[i] >= WARNED_S


@kernel
def place_of(fishes: Fishes, sea: Sea, j: int, here: Vector) -> Vector:
    """The place of fish j as seen from `here`, or of the submarine, cm."""
    return vector(sea.submarine[:3]) if j == SUBMARINE else place_near(fishes, j, here)


@kernel
def knows_threat(minds: Minds, i: int, nature: Nature) -> bool:
    """True if fish i perceives a predator, or remembers where one was."""
    return minds.predator[i] != NOBODY or minds.unseen[i] < KNOWN * nature.fear_s


@kernel
def flees_from_memory(minds: Minds, i: int) -> bool:
    """True if the fear of fish i is of a threat that it does not perceive now."""
    if minds.predator[i] == NOBODY:
        return True
    return minds.unseen[i] > 0.0 and minds.menaces[i] < RECOGNISED * minds.mental[i, FEAR]


@kernel
def grow_used(fishes: Fishes, minds: Minds, i: int, sea: Sea, nature: Nature) -> None:
    """Update the habituation of fish i to the submarine.

    It grows with time near a hull in sight, and is lost at once to one that rushes at the fish.
    """
    left = float(minds.hull_dread[i])
    if minds.predator[i] == NOBODY and left == 1.0:
        return
    pause = float(minds.pause[i])
    toward = minus(vector(fishes.position[i]), vector(sea.submarine[:3]))
    distance = norm(toward)
    near = False
    if NEAR * nature.alarmed * distance < nature.submarine_cm:
        for j in minds.predators[i]:
            near = near or j == SUBMARINE
    if not near:
        left = 1.0 - (1.0 - left) * math.exp(-pause / FORGOTTEN_S)
    elif dot(vector(sea.submarine[3:6]), toward) > RUSH_CM_S * distance:
        left = 1.0 - (1.0 - left) * math.exp(-pause / RENEWED_S)
    else:
        left = max(left * 0.5 ** (pause / nature.habituation_s), LEAST_DREAD)
    minds.hull_dread[i] = left


@kernel
def wariness(minds: Minds, i: int, nature: Nature) -> float:
    """How wary prey i is: 0 up to half of f0, 1 from f0 on."""
    if minds.kind[i] != PREY:
        return 0.0
    share = 2.0 * float(minds.mental[i, FEAR]) / max(nature.alarmed, 1e-6) - 1.0
    return min(max(share, 0.0), 1.0)
