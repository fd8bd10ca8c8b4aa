"""Choose which items of a static batch the views draw, at which levels and in which calls."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.frame.packet import BITE_CM
from subsea.kernels import kernel
from subsea.view.camera import View
from subsea.view.culling import ViewArrays, eye_distance, in_frustum, view_arrays
from subsea.view.levels import FADE_S

OUT_OF_SIGHT = -1  # instead of a level
LEAST_PX = 3.0  # smaller items are not drawn
LARGE_PX = 150.0  # diameter from which a detail below 1 matters less; from twice that not at all
HYSTERESIS = 0.12  # share by which a threshold is overstepped before the level changes
CALL = 6  # columns of a call: view; first of its ranges and their end; triangles; share; bitten


class LevelState(NamedTuple):
    """The levels of k items in the last picture, changed in place."""

    level: Ints  # (k,), or OUT_OF_SIGHT
    former: Ints  # (k,), the level before
    since: Array  # (k,) s, time of the change; -inf: no fade
    time_s: Array  # (1,) of the picture


class Drawn(NamedTuple):
    """The visible and bitten items of the last picture, changed in place."""

    seen: Bools  # (v, k) by each view
    bitten: Bools  # (k,) drawn with traces of feeding


def empty_levels(k: int) -> LevelState:
    """Make the state before the first picture of k items."""
    nothing = np.full(k, OUT_OF_SIGHT), np.full(k, OUT_OF_SIGHT)
    return LevelState(*nothing, np.full(k, -np.inf), np.full(1, -np.inf))


def levels_in_sight(
    spheres: tuple[Array, Array],
    views: Sequence[View],
    reach_cm: float,
    detail: float,
    thresholds_px: Array,
    before: Ints,
) -> tuple[Ints, Bools]:
    """Levels of detail (k,) of `spheres`, and which of them (v, k) each view sees.

    `spheres` are centres (k, 3) and radii (k,), cm. The level follows from the largest diameter in
    pixels; it is OUT_OF_SIGHT for what no view sees or what is too small. The level `before` is
    kept until a threshold is overstepped by HYSTERESIS. A `detail` below 1 spares what is large.
    """
    centres, radii = spheres
    seen = np.ones((len(views), len(centres)), np.bool_)
    if detail == np.inf:
        return np.zeros(len(centres), np.int64), seen
    arrays = view_arrays(views)
    level = _levels(centres, radii, arrays, reach_cm, detail, thresholds_px, before, seen)
    return level, seen


@kernel
def _levels(
    centres: Array,
    radii: Array,
    views: ViewArrays,
    reach: float,
    detail: float,
    thresholds: Array,
    before: Ints,
    seen: Bools,
) -> Ints:
    planes, _, scales = views
    level = np.empty(len(centres), np.int64)
    for i in range(len(centres)):
        x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
        pixels = 0.0
        for v in range(len(planes)):
            seen[v, i] = in_frustum(planes, v, x, y, z, radii[i])  # most are not
            if not seen[v, i]:
                continue
            d = eye_distance(views, v, x, y, z)
            seen[v, i] = d - radii[i] < reach
            if seen[v, i]:
                pixels = max(pixels, 2.0 * radii[i] * scales[v] / max(d - radii[i], 1.0))
        # The straight edges of a coarse level would show in large items: these have full detail.
        full = min(max(pixels / LARGE_PX - 1.0, 0.0), 1.0) if detail < 1.0 else 0.0
        pixels *= detail + full * (1.0 - detail)
        new = before[i] == OUT_OF_SIGHT
        if pixels < (LEAST_PX if new else LEAST_PX / (1.0 + HYSTERESIS)):
            level[i] = OUT_OF_SIGHT
            continue
        finest, plain, coarsest = 0, 0, 0
        for threshold in thresholds:
            finest += pixels * (1.0 + HYSTERESIS) < threshold
            plain += pixels < threshold
            coarsest += pixels / (1.0 + HYSTERESIS) < threshold
        level[i] = plain if new else min(max(before[i], finest), coarsest)
    return level


@kernel
def advance(
    level: Ints,
    shown: Bools,
    seen: Bools,
    time_s: float,
    boxes: tuple[Array, Array],
    bites: Array,
    state: LevelState,
    drawn: Drawn,
) -> bool:
    """Update the state for a picture that wants `level` (k,); True if its calls are not the last.

    Items that are not `shown` (k,) are out of sight, and removed from what the views have `seen`
    (v, k). Only a step to the next level fades, in a picture that follows the last: items that come
    into sight, and all items after a jump in time or while it stands still, have their levels at
    once. No change begins during another. The `bites` (b, 4) of a packet may lie on items in whose
    `boxes` they are, lowest and highest corners (k, 3).
    """
    follows = 0.0 < time_s - state.time_s[0] < FADE_S
    state.time_s[0] = time_s
    low, high = boxes
    changed = False
    for i in range(len(level)):
        wanted = level[i] if shown[i] else OUT_OF_SIGHT
        before, since = state.level[i], state.since[i]
        now, former, start = wanted, OUT_OF_SIGHT, -np.inf
        if follows:
            kept = wanted != OUT_OF_SIGHT and before != OUT_OF_SIGHT
            former = state.former[i]
            if kept and time_s - since < FADE_S:
                now, start = before, since
            elif kept and abs(wanted - before) == 1:
                former, start = before, time_s
        state.level[i], state.former[i], state.since[i] = now, former, start
        changed |= now != before or start > -np.inf or since > -np.inf
        bitten = False
        for k in range(len(bites)):
            near = True
            for axis in range(3):
                place = bites[k, axis]
                near &= max(low[i, axis] - place, place - high[i, axis]) < BITE_CM
            bitten |= near
        changed |= bitten != drawn.bitten[i]
        drawn.bitten[i] = bitten
        for v in range(len(seen)):
            here = seen[v, i] and wanted != OUT_OF_SIGHT
            changed |= here != drawn.seen[v, i]
            drawn.seen[v, i] = here
    return changed


@kernel
def nearness(centres: Array, radii: Array, eyes: Array, seen: Bools) -> Array:
    """Distances (v, k) of the surfaces of spheres from the eyes (v, 3); inf where not `seen`."""
    near = np.empty(seen.shape)
    for v in range(len(eyes)):
        for i in range(len(centres)):
            near[v, i] = np.inf
            if seen[v, i]:
                x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
                x, y, z = x - eyes[v, 0], y - eyes[v, 1], z - eyes[v, 2]
                near[v, i] = np.sqrt(x * x + y * y + z * z) - radii[i]
    return near


@kernel
def list_calls(
    order: Ints, state: LevelState, drawn: Drawn, ranges: Ints, absent: Bools
) -> tuple[Array, Ints, Ints, Ints, Ints]:
    """List the calls (n, CALL) that draw what views see, and the ranges (m,) of these calls.

    `order` (v, k) are the items of each view in the order of drawing, those that it sees first.
    `ranges` (k, levels, 3) are the first triangle, the end and the first vertex of each mesh. A
    range is returned as the number of its indices (int32), their first byte and its first vertex
    (int32). The last result are the first vertices of its meshes that are `absent` (k, levels).

    In each view a call draws all items at rest. Two calls draw the items whose level began to
    change at one moment, one for each level. Each of these is two calls where some are bitten.
    """
    views, k = order.shape
    moments = np.empty(k)
    fades = 0
    for i in range(k):
        place = 0
        while place < fades and moments[place] < state.since[i]:
            place += 1
        if state.since[i] == -np.inf or (place < fades and moments[place] == state.since[i]):
            continue
        for at in range(fades, place, -1):
            moments[at] = moments[at - 1]
        moments[place] = state.since[i]
        fades += 1
    calls = np.empty((2 * views * (1 + 2 * fades), CALL))
    counts, vertices = np.empty(2 * views * k, np.int32), np.empty(2 * views * k, np.int32)
    offsets, missing = np.empty(2 * views * k, np.int64), np.empty(2 * views * k, np.int64)
    called, end, lacking = 0, 0, 0
    for v in range(views):
        for group in range(1 + 2 * fades):
            start, share = -np.inf, 0.0
            if group > 0:
                start = moments[(group - 1) // 2]
                share = min(max((state.time_s[0] - start) / FADE_S, 0.01), 0.99)
                if group % 2 == 0:
                    share -= 1.0
            for bitten in (False, True):
                first, triangles = end, 0
                for i in order[v]:
                    if not drawn.seen[v, i]:
                        break
                    if state.since[i] != start or drawn.bitten[i] != bitten:
                        continue
                    level = state.former[i] if share < 0.0 else state.level[i]
                    number = ranges[i, level, 1] - ranges[i, level, 0]
                    if number == 0:
                        continue
                    counts[end], offsets[end] = 3 * number, 12 * ranges[i, level, 0]
                    vertices[end] = ranges[i, level, 2]
                    if absent[i, level]:
                        missing[lacking] = ranges[i, level, 2]
                        lacking += 1
                    triangles += number
                    end += 1
                if end > first:
                    call = calls[called]
                    call[0], call[1], call[2] = v, first, end
                    call[3], call[4], call[5] = triangles, share, bitten
                    called += 1
    return calls[:called], counts[:end], offsets[:end], vertices[:end], missing[:lacking]
