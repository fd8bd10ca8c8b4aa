"""Specks of plankton and leaves of seaweed that the views of a picture see."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Bools, Ints
from subsea.habitat.seaweed import KINDS as SEAWEED_KINDS
from subsea.kernels import kernel
from subsea.state import Seaweed
from subsea.view.culling import ViewArrays, eye_distance, in_frustum

# Texels of a leaf of seaweed: its nodes from the root to the tip, then its look.
LEAF_NODES = 8
LEAF_TEXELS = LEAF_NODES + 2  # width, facing, twist, own number; colour, length
LEAF_NEAR_PX = 260.0  # below this a leaf is drawn coarsely ...
LEAF_LEAST_PX = 7.0  # ... and below this not at all
LEAF_FULL = 1.5  # times either of both, it has all that comes with it
LEAF_MOST_CM = 150.0  # largest size of a cluster that counts
BLADE = 16.0  # length of the longest frond of kelp over its width, as in `seaweed.vert`
KELP = SEAWEED_KINDS.index("kelp")
ROOM_CM = 10.0  # leaves are wider than their chains, and leave their boxes between ticks
GOLDEN = 0.6180339887  # its multiples modulo 1 fill [0, 1) evenly

PLANKTON_REACH_CM = 1400.0  # where specks have faded
SPECK_CM = 4.0  # farthest that a speck is drawn from its position

COARSE, FINE = 1, 2  # of a cluster; 0: not drawn


class LeafLimits(NamedTuple):
    """Limits to the seaweed that is drawn."""

    reach: float  # cm, how far one sees
    detail: float  # factor on the pixels by which levels are chosen
    growth: float  # share of the clusters
    culling: bool  # leave out what no view sees
    lod: bool  # draw small leaves coarsely or not at all


@kernel
def plankton_in_sight(
    plankton: Array, absent: Array, views: ViewArrays, culling: bool
) -> tuple[Ints, Ints]:
    """Indices of the specks that each view sees, view by view, and the v + 1 bounds of views.

    The look of a speck depends on its index.
    """
    number = len(views[1])
    found = np.empty(number * len(plankton), np.int32)
    bounds = np.zeros(number + 1, np.int64)
    end = 0
    for v in range(number):
        for i in range(len(plankton)):
            x, y, z = plankton[i, 0], plankton[i, 1], plankton[i, 2]
            if absent[i] <= 0.0 and (
                not culling
                or (
                    in_frustum(views[0], v, x, y, z, SPECK_CM)
                    and eye_distance(views, v, x, y, z) - SPECK_CM < PLANKTON_REACH_CM
                )
            ):
                found[end] = i
                end += 1
        bounds[v + 1] = end
    return found[:end], bounds


@kernel
def leaves_in_sight(
    boxes: Array, seaweed: Seaweed, views: ViewArrays, limits: LeafLimits
) -> tuple[Ints, int, Bools, Array]:
    """Leaves (k,) of clusters in sight, fine ones first; the number of fine ones.

    `boxes` (c, 6) hold the clusters. The third result says which of the leaves (v, k) each view
    sees, the last what each leaf (k,) lacks: 0 to 1 of the detail of fine ones, 1 to 2 of its size.
    """
    number = len(views[1])
    level = np.zeros(len(boxes), np.uint8)
    seen = np.zeros((number, len(boxes)), np.bool_)
    lacking = np.zeros(len(boxes), np.float32)
    fine, coarse = 0, 0
    for c in range(len(boxes)):
        level[c], lacking[c] = _level_of_cluster(boxes, seaweed, views, limits, c, seen)
        leaves = seaweed.first[c + 1] - seaweed.first[c]
        if level[c] == FINE:
            fine += leaves
        elif level[c] == COARSE:
            coarse += leaves
    order = np.empty(fine + coarse, np.int64)
    leaf_seen = np.empty((number, fine + coarse), np.bool_)
    leaf_lacking = np.empty(fine + coarse, np.float32)
    place = 0
    for part in (FINE, COARSE):
        for c in range(len(boxes)):
            if level[c] != part:
                continue
            for leaf in range(seaweed.first[c], seaweed.first[c + 1]):
                order[place], leaf_lacking[place] = leaf, lacking[c]
                for v in range(number):
                    leaf_seen[v, place] = seen[v, c]
                place += 1
    return order, fine, leaf_seen, leaf_lacking


@kernel
def _level_of_cluster(
    boxes: Array, seaweed: Seaweed, views: ViewArrays, limits: LeafLimits, c: int, seen: Bools
) -> tuple[int, float]:
    """How finely cluster `c` is drawn, and what it lacks; sets seen[:, c]."""
    two = np.float32(2.0)
    x, y, z = (
        (boxes[c, 0] + boxes[c, 3]) / two,
        (boxes[c, 1] + boxes[c, 4]) / two,
        (boxes[c, 2] + boxes[c, 5]) / two,
    )
    wide, deep, high = (
        boxes[c, 3] - boxes[c, 0],
        boxes[c, 4] - boxes[c, 1],
        boxes[c, 5] - boxes[c, 2],
    )
    blade = np.float32(0.0)
    for leaf in range(seaweed.first[c], seaweed.first[c + 1]):
        if seaweed.kind[leaf] == KELP:
            blade = max(blade, np.float32(BLADE) * seaweed.look[leaf, 0])
    radius = np.sqrt(wide * wide + deep * deep + high * high) / two + np.float32(ROOM_CM) + blade
    covers = min(two * radius, np.float32(LEAF_MOST_CM))
    pixels = np.float32(-1.0)
    for v in range(len(views[1])):
        distance = eye_distance(views, v, x, y, z)
        seen[v, c] = not limits.culling or (
            distance - radius < limits.reach and in_frustum(views[0], v, x, y, z, radius)
        )
        if seen[v, c]:
            pixels = max(pixels, np.float32(covers / max(distance, 1.0) * views[2][v]))
    pixels *= np.float32(limits.detail)
    if not c * GOLDEN % 1.0 < limits.growth or pixels < 0.0:
        return 0, 0.0
    if not limits.lod:
        return FINE, 0.0
    if pixels > LEAF_NEAR_PX:
        return FINE, _lacking(pixels, LEAF_NEAR_PX)
    return (COARSE if pixels > LEAF_LEAST_PX else 0), 1.0 + _lacking(pixels, LEAF_LEAST_PX)


@kernel
def _lacking(pixels: float, least: float) -> float:
    return float(min(max((LEAF_FULL - pixels / least) / (LEAF_FULL - 1.0), 0.0), 1.0))


@kernel
def leaf_texels(seaweed: Seaweed, order: Ints, lacking: Array, alpha: float) -> Array:
    """Texels of the leaves `order`, `alpha` of the way from the last tick to the current one.

    `lacking` (k,) is as of `leaves_in_sight`.
    """
    out = np.zeros((len(order), LEAF_TEXELS, 4), np.float32)
    share = np.float32(alpha)
    for k in range(len(order)):
        leaf = order[k]
        for node in range(LEAF_NODES):
            for axis in range(3):
                before = seaweed.previous[leaf, node, axis]
                out[k, node, axis] = before + share * (seaweed.node[leaf, node, axis] - before)
        out[k, 0, 3] = seaweed.kind[leaf]
        out[k, 1, 3] = lacking[k]
        for column in range(8):
            out[k, LEAF_NODES + column // 4, column % 4] = seaweed.look[leaf, column]
    return out
