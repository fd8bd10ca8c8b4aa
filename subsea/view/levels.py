"""Levels of detail of fishes by projected size (SMC §7.3), with cross-fades.

A level is kept until its threshold is overstepped by HYSTERESIS. During a change, which takes
FADE_S, a fish is drawn at both levels, each in the pixels that the other leaves out. `LodState`
belongs to the viewer, not to the world.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.kernels import kernel
from subsea.kernels.threads import share

# Finest first; the second and the third are those of SMC table 2.
LEVELS = ("tessellated", "close", "distant", "far", "speck", "dot")
SPECK = LEVELS.index("speck")  # from this level on a fish has short shaders of its own
# Least length of a fish in pixels for each level but the last.
THRESHOLDS_PX = np.array([190.0, 110.0, 60.0, 24.0, 8.5])
HYSTERESIS = 0.12
FADE_S = 0.3
HIDDEN = 255  # instead of a level
LEAST_PART = 16384  # fishes for which another thread pays


class LodState(NamedTuple):
    """The levels of n fishes in the last picture."""

    level: Ints  # (n,) uint8, or HIDDEN
    former: Ints  # (n,) uint8, the level before
    since: Array  # (n,) float64 s, time of the change


def empty_lod_state(n: int) -> LodState:
    """The state before the first picture of n fishes."""
    return LodState(np.full(n, HIDDEN, np.uint8), np.full(n, HIDDEN, np.uint8), np.full(n, -np.inf))


def thresholds_of(detail: float, dots: bool) -> Array:
    """Compute the least length in pixels for each level but the last; `detail` divides it.

    Without `dots` a speck may be of any length.
    """
    thresholds = THRESHOLDS_PX / detail
    thresholds[SPECK] *= float(dots)
    return np.asarray(thresholds)


def update_levels(
    pixels: Array, finer: Bools, thresholds: Array, time_s: float, memory: LodState
) -> None:
    """Update the levels of fishes whose length covers `pixels` (n,), below 0 if out of sight.

    Those in `finer` are drawn one level finer. A fish that comes into sight has its level at once;
    no change begins during another.
    """
    groups = pixels, finer, thresholds, time_s, memory
    share(_update, np.arange(len(pixels)), LEAST_PART, *groups)


@kernel
def _update(
    who: Ints, pixels: Array, finer: Bools, thresholds: Array, time_s: float, memory: LodState
) -> None:
    level, former, since = memory
    for i in who:
        if pixels[i] < 0.0:
            level[i] = HIDDEN
            continue
        plain, fine, coarse = 0, 0, 0
        for threshold in thresholds:
            plain += pixels[i] < threshold
            fine += pixels[i] * (1.0 + HYSTERESIS) < threshold
            coarse += pixels[i] < threshold * (1.0 + HYSTERESIS)
        if finer[i]:
            plain, fine, coarse = max(plain - 1, 0), max(fine - 1, 0), max(coarse - 1, 0)
        if level[i] == HIDDEN:
            level[i], since[i] = plain, -np.inf
            continue
        kept = min(max(level[i], fine), coarse)
        if kept != level[i] and not _under_way(since[i], time_s):
            former[i], level[i], since[i] = level[i], kept, time_s


def draw_order(
    distance: Array, time_s: float, levels: int, memory: LodState
) -> tuple[Ints, Array, Ints]:
    """Sort the fishes to draw into groups: indices, shares of the cross-fade, starts of groups.

    Each view has one group per level, coarsest first, of fishes at rest, then one per level of
    fading fishes, which are in two groups. Fading specks and dots count as at rest. A view draws
    the fishes at a finite `distance` (v, n), in each group the farthest first. Returns indices
    (m,), shares (m,) as `frame.packet.FADE`, and starts (v, 2 levels + 1), which include the end.
    """
    seen = [np.flatnonzero((row < np.inf) & (memory.level != HIDDEN)) for row in distance]
    order = [_farthest_first(own, row[own]) for own, row in zip(seen, distance, strict=True)]
    first = np.cumsum([0, *map(len, order)])
    return _grouped(np.concatenate(order), first, time_s, levels, memory)


def _farthest_first(fish: Ints, distance: Array) -> Ints:
    """The indices `fish`, rising, sorted by their distances (n,) float32; of equal ones as before.

    Distances are not negative, so their bits are ordered as they are. One sort of numbers takes a
    tenth of the time of a stable sort of indices.
    """
    bits = distance.astype(np.float32).view(np.uint32).astype(np.uint64)
    keys = (np.uint64(0xFFFFFFFF) - bits) << np.uint64(32) | fish.astype(np.uint64)
    keys.sort()
    return (keys & np.uint64(0xFFFFFFFF)).astype(np.int64)


@kernel
def _grouped(
    order: Ints, first: Ints, time_s: float, levels: int, memory: LodState
) -> tuple[Ints, Array, Ints]:
    """As `draw_order`, of fishes `order`; view v has those from first[v] to first[v + 1]."""
    level, former, since = memory
    groups, views = 2 * levels, len(first) - 1
    count = np.zeros(views * groups + 1, np.int64)
    for v in range(views):
        own = count[v * groups + 1 :]
        for i in order[first[v] : first[v + 1]]:
            fading = _under_way(since[i], time_s)
            own[_group(level[i], fading, levels)] += 1
            if fading:
                own[_group(former[i], fading, levels)] += 1
    ends = np.cumsum(count)
    fish = np.empty(ends[-1], np.int64)
    share = np.empty(ends[-1], np.float32)
    starts = np.empty((views, groups + 1), np.int64)
    for v in range(views):
        for k in range(groups + 1):
            starts[v, k] = ends[v * groups + k]
    for v in range(views):
        end = ends[v * groups :]
        for i in order[first[v] : first[v + 1]]:
            fading = _under_way(since[i], time_s)
            k = _group(level[i], fading, levels)
            fish[end[k]], share[end[k]] = i, 0.0
            end[k] += 1
            if fading:
                done = min(max((time_s - since[i]) / FADE_S, 0.01), 0.99)
                share[end[k] - 1] = done
                k = _group(former[i], fading, levels)
                fish[end[k]], share[end[k]] = i, done - 1.0
                end[k] += 1
    return fish, share, starts


@kernel
def _under_way(since: float, time_s: float) -> bool:
    return 0.0 <= time_s - since < FADE_S


@kernel
def _group(level: int, fading: bool, levels: int) -> int:
    return levels - 1 - level + (levels if fading and level < SPECK else 0)
