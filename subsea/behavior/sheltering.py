"""Cover: fishes dive into a crevice or a coral at a shadow, and bathe in their anemone.

A clownfish that bathes is never still: it wriggles among the tentacles, which keeps its slime coat
fit (Mariscal 1970).
"""

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.behavior.chasing import chase, mouth_of, set_urge
from subsea.behavior.manoeuvring import careful, steer
from subsea.geometry.rotation import x_axis
from subsea.geometry.vector import ZERO, Vector, dot, minus, norm, plus, times, vector
from subsea.kernels import kernel
from subsea.state import BATHES, NOBODY, SPAWNING, Clock, Fishes, Minds, Nature, Sea

REST = 0.5  # desire for cover by night
ALARM = 0.8  # desire for cover of a fish under a shadow
HIDE_S = (6.0, 14.0)  # how long a fish stays after the shadow has gone, by its identity
SLACK_CM = 3.0  # depth below its cover that a body may reach
NEAR_BL, NEAR_CM = 3.0, 60.0  # distance at which it goes in: the larger of both
DOOR_CM, DOOR_COS = 25.0, 0.3  # the door of a crevice, and who is before it
STAYS_BL, LOSES_S = 1.5, 20.0  # in its cover at last; time after which it tries another one
INSIDE_BL = 0.6  # distance within which it is in its cover
# Shares of the fastest speed: inside, at the door and before it.
HOVERS, SETTLES, ENTERS = 0.03, 0.25, 0.6
BATHING = 0.4  # desire of a clownfish to bathe
CYCLE_S = (70.0, 110.0)  # from bath to bath, by identity ...
SHARE = 0.22  # ... and the share of it that is spent in the anemone
SWAY_BL, SWAY_HZ = 0.45, 0.11  # circle among the tentacles
WRIGGLE, WRIGGLE_HZ = 0.9, 0.9  # its sideways urge, over that ahead
WRIGGLES, TURNS = 0.16, 0.05  # shares of its fastest speed, ahead and in a turn
AMONG_BL = 1.5  # distance within which it is among the tentacles


@kernel
def desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """Alarm of fishes with a cover in reach, under a shadow or frightened, and for a while after.

    Shadows alarm no fish whose fear is imposed, or that a direction pairs.
    It also counts `minds.wary` down.
    """
    low, high = HIDE_S
    for i in who:
        minds.wary[i] = max(minds.wary[i] - minds.pause[i], np.float32(0.0))
        # By direction: of imposed fear, or of a pair.
        directed = minds.fright[i] >= 0.0 or minds.betrothed[i] != NOBODY
        afraid = minds.fright[i] > nature.alarmed if directed else minds.shadow[i] > 0.0
        if minds.cover[i] >= 0 and minds.ways[i] and afraid:
            minds.wary[i] = low + (high - low) * fishes.identity[i]
        out[i] = 0.0
        if minds.cover[i] >= 0:
            rests = minds.dark[i] and minds.courtship[i] != SPAWNING
            out[i] = ALARM if minds.wary[i] > 0.0 else REST if rests else 0.0


@kernel
def act(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Dive to the cover and hover in it."""
    for i in who:
        s = minds.cover[i]
        place = vector(sea.site_place[s])
        toward = minus(place, vector(fishes.position[i]))
        far, length = norm(toward), float(fishes.length[i])
        normal = vector(sea.site_normal[s])
        before = -dot(toward, normal) > DOOR_COS * far or sea.site_growth[s] >= 0
        before = before or far < STAYS_BL * length
        if minds.held[i] > LOSES_S and far > STAYS_BL * length and minds.wary[i] <= 0.0:
            minds.cover[i] = -1  # perception finds another place
        if far > max(NEAR_BL * length, NEAR_CM) or (not before and far > INSIDE_BL * length):
            # Into a crevice by its open side, into a coral from anywhere.
            door = 0.0 if sea.site_growth[s] >= 0 else DOOR_CM + float(sea.site_depth[s])
            chase(fishes, minds, i, plus(place, times(door, normal)), ZERO)
            continue
        fishes.close[i], fishes.shell[i] = True, sea.site_depth[s] + SLACK_CM
        if far > INSIDE_BL * length:
            quick = max(SETTLES, min(far / (NEAR_BL * length), ENTERS))
            fishes.goal_speed[i] = careful(steer(fishes, minds, i, toward)) * quick
        else:
            # It looks out, with its back to the stone.
            ahead = x_axis(fishes.orientation[i])
            out = plus((0.5 * ahead[0], 0.5 * ahead[1], 0.0), (normal[0], normal[1], 0.0))
            steer(fishes, minds, i, out if norm(out) > 1e-3 else ahead)
            fishes.goal_speed[i] = HOVERS


@kernel
def bathing_desire(
    who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock, out: Array
) -> None:
    """A desire of fishes with an anemone, for a part of each cycle of their own."""
    now = clock.tick * clock.dt
    for i in who:
        out[i] = 0.0
        if minds.ways[i] & BATHES and minds.cover[i] >= 0 and minds.errand[i] <= 0.0:
            low, high = CYCLE_S
            own = float(fishes.identity[i])
            phase = (now / (low + (high - low) * own) + 7.0 * own) % 1.0
            out[i] = BATHING if phase < SHARE else 0.0


@kernel
def bathe(who: Ints, fishes: Fishes, minds: Minds, sea: Sea, nature: Nature, clock: Clock) -> None:
    """Wriggle among the tentacles of the anemone."""
    now = clock.tick * clock.dt
    for i in who:
        s = minds.cover[i]
        length, own = float(fishes.length[i]), float(fishes.identity[i])
        spot = plus(vector(sea.site_place[s]), _swayed(now, own, length))
        toward = minus(spot, mouth_of(fishes, i))
        far = norm(toward)
        if far > max(NEAR_BL * length, NEAR_CM):
            chase(fishes, minds, i, spot, ZERO)
            continue
        fishes.close[i], fishes.shell[i] = True, sea.site_depth[s] + SLACK_CM
        ahead = x_axis(fishes.orientation[i])
        side = np.sin(2.0 * np.pi * (WRIGGLE_HZ * now + own)) if far < AMONG_BL * length else 0.0
        aside = times(WRIGGLE * side, (-ahead[1], ahead[0], 0.0))
        set_urge(minds, i, plus(times(1.0 / max(far, 1e-3), toward), aside))
        # It turns about on the spot: a wide turn would lead it out of the anemone.
        behind = dot(toward, ahead) < 0.3 * far
        quick = min(WRIGGLES + 0.5 * far / NEAR_CM, 0.5)
        fishes.goal_speed[i] = TURNS if behind else quick


@kernel
def _swayed(now: float, own: float, length: float) -> Vector:
    """A point that circles in the crown of the anemone."""
    turn = 2.0 * np.pi * (SWAY_HZ * now + own)
    c, s = SWAY_BL * length * np.cos(turn), SWAY_BL * length * np.sin(turn)
    return c, s, 0.3 * s
