"""Cross-fades of static items from one level of detail to the next.

As with fishes (`view.levels`), an item is drawn at both levels for FADE_S, each in the pixels that
the other leaves out.
"""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.view.levels import FADE_S

OUT_OF_SIGHT = -1  # instead of a level


class LevelState(NamedTuple):
    """The levels of k items in the last picture."""

    level: Ints  # (k,), or OUT_OF_SIGHT
    former: Ints  # (k,), the level before
    since: Array  # (k,) s, time of the change; -inf: no fade
    time_s: float  # of the picture


def empty_levels(k: int) -> LevelState:
    """The state before the first picture of k items."""
    return LevelState(
        np.full(k, OUT_OF_SIGHT), np.full(k, OUT_OF_SIGHT), np.full(k, -np.inf), -np.inf
    )


def next_levels(level: Ints, before: LevelState, time_s: float) -> LevelState:
    """The state after a picture that wants these levels (k,) at `time_s`.

    Only a step to the next level fades, in a picture that follows the last: items that come into
    sight, and all items after a jump in time or while it stands still, have their levels at once.
    No change begins during another.
    """
    if not 0.0 < time_s - before.time_s < FADE_S:
        return empty_levels(len(level))._replace(level=level, time_s=time_s)
    seen = (level != OUT_OF_SIGHT) & (before.level != OUT_OF_SIGHT)
    under_way = seen & (time_s - before.since < FADE_S)
    begins = seen & ~under_way & (np.abs(level - before.level) == 1)
    return LevelState(
        np.where(under_way, before.level, level),
        np.where(begins, before.level, before.former),
        np.where(begins, time_s, np.where(under_way, before.since, -np.inf)),
        time_s,
    )


class FadeGroup(NamedTuple):
    """Items that one call draws with one share of their pixels."""

    items: Ints  # (n,), in the order of drawing
    level: Ints  # (n,)
    share: float  # as `fades.glsl` takes it; 0 draws all pixels


def fade_groups(items: Ints, state: LevelState) -> list[FadeGroup]:
    """Groups of `items` in sight: those at rest, then both levels of each change under way."""
    since = state.since[items]
    rest = items[since == -np.inf]
    groups = [FadeGroup(rest, state.level[rest], 0.0)]
    if len(rest) == len(items):
        return groups
    for start in np.unique(since[since > -np.inf]).tolist():
        own = items[since == start]
        done = min(max((state.time_s - start) / FADE_S, 0.01), 0.99)
        groups.append(FadeGroup(own, state.level[own], done))
        groups.append(FadeGroup(own, state.former[own], done - 1.0))
    return groups


def under_way(state: LevelState) -> Bools:
    """True for each item (k,) that is drawn at two levels."""
    return np.asarray(state.since > -np.inf)
