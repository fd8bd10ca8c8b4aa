"""The sound of a place: the stone around it, the silence between sounds, and large fishes near.

Everything is a function of the world's state, its seed and the time of the dive.
"""

import math
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.noise import uniform
from subsea.geometry.solids import height_at, ray_meets_pillar, ray_meets_rock
from subsea.geometry.vector import Vector
from subsea.kernels import kernel
from subsea.sound.space import METRE, Listener
from subsea.world.world import TICK_S, World

SLOW = np.int64(318)  # key of the random numbers of what changes slowly
# Mean times, s, in which the reef, and the sand and the deep, fall silent and sound again.
REEF_S, OTHERS_S = (17.0, 53.0), (13.0, 31.0)
QUIETEST = 0.12  # level of a reef in a silence

SIGHT_CM = 450.0  # stone farther off does not make a place sound enclosed
LEVEL_RAYS, SLANT = 8, math.sqrt(0.5)

LARGE_CM = 80.0  # length from which a fish moves enough water to be felt
STANDARD_CM = 130.0  # length of a fish of level 1
BEYOND = 1.25  # how far it is felt, over the range of sight
APPROACH_CM_S = 45.0  # speed of approach at which it is loudest
PASSING = 0.22  # level of one that keeps its distance
COMES = 0.5  # eased share of that speed from which it is said to come
HUSH_CM, HUSHED_CM = 1000.0, 350.0  # from where it silences a listener, and what is around it
BEAT_HZ = 0.7  # of its pulse; each fish has its own


class Place(NamedTuple):
    """The sound of the place of a listener."""

    depth: float  # cm
    height: float  # above the sand, cm
    roof: float  # share of what is above that is stone near by, 0 to 1
    walls: float  # the same all around
    reef: float  # level of the reef now, QUIETEST to 1
    others: float  # that of sand and deep, 0 to 1


class Loom(NamedTuple):
    """Large fishes near a listener."""

    fishes: Ints  # (f,) indices
    level: float  # of their pressure wave
    way: Array  # (3,) its direction to the right, ahead and up; shorter if they are all round
    hush: float  # share by which the reef around the listener falls silent
    nearest: float  # distance of the nearest that comes, cm; infinite for none


NO_LOOM = Loom(np.zeros(0, np.int64), 0.0, np.zeros(3), 0.0, math.inf)


@kernel
def wander(seed: int, t: float, key: int) -> float:
    """Return a smooth random function of time in [0, 1), with a number at each whole `t`."""
    number = math.floor(t)
    share = t - number
    eased = share * share * (3.0 - 2.0 * share)
    before, after = uniform(seed, key, number, SLOW), uniform(seed, key, number + 1, SLOW)
    return before + eased * (after - before)


@kernel
def breathing(seed: int, t: float, short_s: float, long_s: float, key: int) -> float:
    """Return a level from 0, a silence, to 1 that comes and goes in tens of seconds."""
    share = 0.6 * wander(seed, t / short_s, key) + 0.4 * wander(seed, t / long_s, key + 1)
    eased = min(max((share - 0.28) / 0.4, 0.0), 1.0)
    return eased * eased * (3.0 - 2.0 * eased)


def place_of(world: World, listener: Listener) -> Place:
    """Describe the place of a listener in the tick that the world has just made."""
    sea, seed, now = world.state.sea, world.state.seed, world.state.tick * TICK_S
    x, y, z = (float(part) for part in listener.place)
    roof, walls = enclosure(sea.pillars, sea.rocks, (x, y, z))
    return Place(
        max(-z, 0.0), max(z - height_at(sea.heights, sea.half_width, x, y), 0.0), roof, walls,
        QUIETEST + (1.0 - QUIETEST) * breathing(seed, now, *REEF_S, 6),
        breathing(seed, now, *OTHERS_S, 8),
    )  # fmt: skip


@kernel
def enclosure(pillars: Array, rocks: Array, place: Vector) -> tuple[float, float]:
    """Return how much stone is above a place, and around it: 0 for open water, 1 for a crevice."""
    roof, walls = 0.0, 0.0
    for k in range(LEVEL_RAYS + 5):
        turn = 2.0 * math.pi * k / LEVEL_RAYS
        flat, up = 1.0, 0.0
        if k == LEVEL_RAYS + 4:
            flat, up = 0.0, 1.0
        elif k >= LEVEL_RAYS:
            turn, flat, up = 0.25 * math.pi + 4.0 * math.pi * k / LEVEL_RAYS, SLANT, SLANT
        far = (
            place[0] + SIGHT_CM * flat * math.cos(turn),
            place[1] + SIGHT_CM * flat * math.sin(turn),
            place[2] + SIGHT_CM * up,
        )
        free = 1.0
        for pillar in pillars:
            free = min(free, ray_meets_pillar(pillar, 0.0, place, far))
        for rock in rocks:
            free = min(free, ray_meets_rock(rock, 0.0, place, far))
        if k < LEVEL_RAYS:
            walls += (1.0 - free) / LEVEL_RAYS
        else:
            roof += 0.2 * (1.0 - free)
    return roof, walls


def loom_of(world: World, listener: Listener, gap: Array, away: Array) -> Loom:
    """Find the large fishes that a listener feels; a fish that listens does not feel itself.

    `gap` (n, 3) leads from the listener to each fish, `away` (n,) is its length, cm.
    """
    fishes = world.state.fishes
    reach = BEYOND * world.scenario.water.visibility_cm
    felt = (fishes.length >= LARGE_CM) & (away < reach) & (away > 1.0) & fishes.alive
    large = np.flatnonzero(felt)
    if not len(large):
        return NO_LOOM
    far = away[large].astype(np.float64)
    ways = gap[large] / far[:, None]
    nears = ((listener.velocity - fishes.velocity[large]) * ways).sum(axis=1)
    coming = _eased(nears / APPROACH_CM_S)
    size = (fishes.length[large] / STANDARD_CM) ** 2
    beat = BEAT_HZ * (0.8 + 0.4 * fishes.identity[large])
    pulse = 0.7 + 0.3 * np.sin(math.tau * beat * world.state.tick * TICK_S)
    loud = np.minimum(size, 2.0) * (2.0 * METRE / np.maximum(far, 2.0 * METRE)) ** 0.5
    loud *= (PASSING + (1.0 - PASSING) * coming) * _eased(2.0 * (1.0 - far / reach)) * pulse
    hush = float((coming * _eased(1.5 * (1.0 - far / HUSH_CM))).max())
    total = float(loud.sum())
    way = listener.axes @ (loud @ ways) / max(total, 1e-9)
    nearest = float(np.where(coming > COMES, far, math.inf).min())
    return Loom(large, min(total, 1.5), way, hush, nearest)


def _eased(share: Array) -> Array:
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def spared(world: World, loom: Loom, places: Array) -> Array:
    """Return the share (n,) of sounds at `places` (n, 3) that large fishes near do not silence.

    Fishes fall silent near a predator (Luczkovich et al., Bioacoustics 2000); that shrimp do is
    designed.
    """
    kept = np.ones(len(places))
    for fish in loom.fishes.tolist():
        away = ((places - world.state.fishes.position[fish]) ** 2).sum(axis=1)
        kept *= 1.0 - 0.95 * np.exp(-away / HUSHED_CM**2)
    return kept
