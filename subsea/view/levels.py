"""In what detail each fish is drawn (SMC §7.3): by projected size, and without a visible switch.

A level is kept until its threshold is overstepped by HYSTERESIS, and changes within FADE_S, in
which a fish is drawn at both levels, each in the pixels that the other leaves out. What this has to
remember is `Memory`: it belongs to whoever draws, not to the world.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from subsea.core.arrays import Array, Ints
from subsea.core.kernels import kernel

# Finest first; the second and the third are those of SMC table 2.
LEVELS = ("tessellated", "close", "distant", "far", "speck")
# A level is used as long as the fish's length covers at least so many pixels.
THRESHOLDS_PX = np.array([190.0, 110.0, 60.0, 24.0])
HYSTERESIS = 0.12
FADE_S = 0.3
HIDDEN = 255  # in place of a level


class LodState(NamedTuple):
    """How n fishes were drawn last."""

    level: Ints  # (n,) uint8, or HIDDEN
    former: Ints  # (n,) uint8, the level before that
    since: Array  # (n,) float64 s, when it changed


def empty_lod_state(n: int) -> LodState:
    """The memory of whoever has drawn none of n fishes yet."""
    return LodState(np.full(n, HIDDEN, np.uint8), np.full(n, HIDDEN, np.uint8), np.full(n, -np.inf))


@kernel
def update_levels(
    pixels: Array, finer: NDArray[np.bool_], thresholds: Array, time_s: float, memory: LodState
) -> None:
    """Set the levels of the fishes whose length covers `pixels` (n,), below 0 out of sight.

    `finer` are to be drawn one level finer than others. A fish that comes into sight has its level
    at once, and while one change is under way no other begins.
    """
    level, former, since = memory
    for i in range(len(pixels)):
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
    """What is drawn: fishes, their share of a cross-fade, and where each group of them begins.

    For each view one group a level, coarsest first, of the fishes at rest; then one for each of
    those that fade, which are drawn at both levels. Specks that fade are among those at rest. A
    view's fishes are those at a finite `distance` (v, n); within a group those at the greatest come
    first. Returns the fishes (m,), the shares (m,) as `frame.FADE` has them, and the beginnings
    (v, 2 levels + 1,), each with the end.
    """
    seen = [np.flatnonzero((row < np.inf) & (memory.level != HIDDEN)) for row in distance]
    order = [
        own[np.argsort(-row[own], kind="stable")] for own, row in zip(seen, distance, strict=True)
    ]
    first = np.cumsum([0, *map(len, order)])
    return _grouped(np.concatenate(order), first, time_s, levels, memory)


@kernel
def _grouped(
    order: Ints, first: Ints, time_s: float, levels: int, memory: LodState
) -> tuple[Ints, Array, Ints]:
    """As `arranged`; in `order` those of view v are from first[v] to first[v + 1]."""
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
    return levels - 1 - level + (levels if fading and level < levels - 1 else 0)
