"""Kinds that branch: stony thickets, soft corals, sea fans, and their rubble."""

import numpy as np

from subsea.rendering.reef.coral_branches import (
    Branches,
    grow_offshoots,
    grow_stems,
    out_share,
    thicket_light,
    together,
)
from subsea.rendering.reef.coral_mesh import UP, CoralMesh, Rng, bumps, joined, tubes, unit


def staghorn(rng: Rng, level: int) -> CoralMesh:
    """Antlers: stems, boughs on them, and twigs with pale ends."""
    stems = grow_stems(rng, 7, 1.5, 0.5, 0.062)
    boughs = grow_offshoots(rng, stems, 3, 0.8, 0.35, 0.8, 0.45)
    twigs = grow_offshoots(rng, boughs, 3, 0.75, 0.4, 0.72, 0.3)
    if level == 0:
        return together(stems, boughs, twigs).tubes(4, 8, True, pale=0.45)
    if level == 1:
        return together(stems, boughs, twigs).tubes(2, 5, False, 1.1, pale=0.45)
    if level == 2:
        few = twigs.taken(np.arange(0, len(twigs.length), 2))
        return together(boughs, few).tubes(2, 3, False, 1.5, pale=0.2)
    few = twigs.taken(np.arange(0, len(twigs.length), 5))
    few = few._replace(
        start=0.4 * few.start, way=unit(few.start + 0.4 * few.way), length=0.75 + 0 * few.length
    )
    return few.tubes(2, 3, False, 2.2, pale=0.3)


def bush(rng: Rng, level: int) -> CoralMesh:
    """A cushion of short fingers, each with a knobbly pale head."""
    number = 72
    k = np.arange(number) + 0.5
    z = 1.0 - 0.98 * k / number
    turn = k * 2.39996 + rng.uniform(-0.35, 0.35, number)
    r = np.sqrt(1.0 - z * z)
    way = unit(
        np.stack([r * np.cos(turn), r * np.sin(turn), 0.9 * z + 0.12], axis=1)
        + rng.normal(0, 0.1, (number, 3))
    )
    far = 1.0 + 0.3 * bumps(rng, way, 1.7) + rng.uniform(-0.1, 0.1, number)
    thick = rng.uniform(0.8, 1.2, number)
    fingers = Branches(
        0.3 * way, way, far - 0.35, 0.1 * rng.normal(size=(number, 3)) + 0.12 * UP,
        thick[:, None] * np.array([0.07, 0.105]), np.zeros(number),
    )  # fmt: skip
    if level == 0:
        return fingers.tubes(2, 8, True, pale=0.4, dark=0.12)
    if level == 1:
        return fingers.tubes(2, 5, False, 1.1, pale=0.4, dark=0.12)
    few = fingers.taken(np.arange(0, number, 2 if level == 2 else 6))
    return few.tubes(2, 3, False, 1.5 if level == 2 else 2.5, pale=0.25, dark=0.15)


def finger(rng: Rng, level: int) -> CoralMesh:
    """Soft fingers with round ends on a lobed foot."""
    stems = grow_stems(rng, 9, 1.1, 0.55, 0.13)
    knobs = grow_offshoots(rng, stems, 3, 0.7, 0.5, 0.85, 0.4)
    both = together(stems, knobs)
    if level == 0:
        return both.tubes(5, 10, True, pale=0.3, sway=0.5, dark=0.25)
    if level == 1:
        return both.tubes(2, 5, True, pale=0.1, sway=0.5, dark=0.25)
    few = knobs.taken(np.arange(0, len(knobs.length), level))
    few = few._replace(length=few.length + 0.2, start=few.start - 0.2 * few.way)
    return few.tubes(2, 4 if level == 2 else 3, False, 1.25, pale=0.1, sway=0.5, dark=0.25)


def soft(rng: Rng, level: int) -> CoralMesh:
    """A soft tree: pale swollen trunk and boughs, and bunches of bright polyps on them."""
    trunk = grow_stems(rng, 1, 0.2, 0.7, 0.13)
    trunk = trunk._replace(
        start=np.array([[0.0, 0.0, -0.05]]), bend=0.15 * rng.normal(size=(1, 3)) * (1, 1, 0)
    )
    boughs = grow_offshoots(rng, trunk, 11, 1.3, 0.15, 0.62, 0.12)
    boughs = boughs._replace(length=rng.uniform(0.5, 0.75, 11) * (1.2 - 0.05 * np.arange(11)))
    twigs = grow_offshoots(rng, boughs, 4, 1.0, 0.25, 0.6, 0.45)
    twigs = twigs._replace(length=0.55 * twigs.length)
    bunches, per = len(twigs.length), 9
    ends = twigs.at(np.ones((bunches, 1)))
    heads = (
        ends
        + 0.13 * unit(rng.normal(size=(bunches, per, 3))) * rng.uniform(0.5, 1.2, (bunches, per, 1))
    ).reshape(-1, 3)
    size = rng.uniform(0.042, 0.075, len(heads))
    if level == 0:
        stem = together(trunk, boughs, twigs).tubes(3, 7, False, sway=0.7, pale=1.5, dark=0.5)
    else:
        few = boughs.taken(np.arange(0, 11, max(level - 1, 1)))
        sides = 4 if level == 1 else 3
        stem = together(trunk, few).tubes(2, sides, False, sway=0.7, pale=1.5)
    step, larger = ((1, 1.0), (2, 1.4), (9, 2.7), (25, 4.2))[level]
    heads, size = heads[::step], larger * size[::step]
    # Spindles that stand out from their bunch.
    out = unit(unit(heads - np.array([0.0, 0.0, 0.6])) + 0.5 * rng.normal(size=heads.shape))
    along = size[:, None] * np.array([-0.9, 0.25, 1.5])
    path = heads[:, None] + along[..., None] * out[:, None]
    radius = size[:, None] * np.array([0.0, 0.75, 0.0])
    bulbs = tubes(
        path, radius, 4 if level < 2 else 3, tip=np.array([0.8, 0.9, 1.0]),
        light=thicket_light(path, 0.45), sway=0.7 * out_share(path),
    )  # fmt: skip
    return joined(stem, bulbs)


def fan(rng: Rng, level: int) -> CoralMesh:
    """A flat fan of twigs that fork repeatedly in one plane, across the current."""
    start = np.array([[-0.02, -0.05], [0.0, -0.05], [0.02, -0.05]])
    angle = np.array([-0.75, 0.05, 0.7])
    length, number, found = 0.26, 3, []
    widths = (0.04, 0.032, 0.026, 0.022, 0.019, 0.017, 0.015, 0.014, 0.013)
    lean = rng.normal(0.0, 0.12)
    for order, width in enumerate(widths):
        way = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        run = length * rng.uniform(0.75, 1.25, number)[:, None]
        end = start + run * way
        same = np.tile([width, widths[min(order + 1, 8)], order], (number, 1))
        found.append(np.column_stack([start, end, same]))
        rough = 0.9 + 0.07 * rng.normal(size=number)
        inside = np.hypot(end[:, 0] - lean, (end[:, 1] - 0.85) / 0.95) < rough
        fork = 1 + (rng.uniform(size=number) < (1.0 if order < 2 else 0.62))
        keep = inside | (order < 4)
        start, angle, fork = end[keep], angle[keep], fork[keep]
        spread = (0.42 if order < 3 else 0.34) * rng.uniform(0.6, 1.4, len(angle))
        side = np.where(rng.uniform(size=len(angle)) < 0.5, -1.0, 1.0)
        start = np.concatenate([start, start[fork == 2]])
        bent = angle + side * np.where(fork == 2, spread, 0.4 * spread)
        angle = 0.93 * np.concatenate([bent, (angle - side * spread)[fork == 2]])
        number, length = len(angle), 0.86 * length if order < 3 else 0.93 * length
    rows = np.concatenate(found)
    orders = (9, 7, 5, 4)[level]
    rows = rows[rows[:, 6] < orders]
    if level:  # thicker, because fewer
        rows[:, 4:6] *= (1.0, 1.4, 2.4, 3.4)[level]
    share = np.array([0.0, 1.0])[None, :, None]
    flat = rows[:, None, 0:2] + share * (rows[:, None, 2:4] - rows[:, None, 0:2])
    warp = 0.09 * np.sin(2.2 * flat[..., 0] + rng.uniform(0, 6)) * flat[..., 1]
    path = np.stack([flat[..., 0], warp, flat[..., 1]], axis=-1)
    radius = rows[:, 4:5] + share[..., 0] * (rows[:, 5:6] - rows[:, 4:5])
    tip = np.clip((path[..., 2] - 0.2) / 1.2, 0.0, 1.0)
    return tubes(
        path, radius, 4 if level == 0 else 3, tip=tip, light=0.75 + 0.25 * tip, sway=out_share(path)
    )


def rubble(rng: Rng, level: int) -> CoralMesh:
    """Dead, broken branches lying about."""
    number = (22, 14, 8, 4)[level]
    turn, far = rng.uniform(0, 2 * np.pi, 22), np.sqrt(rng.uniform(0, 1, 22)) * 0.8
    at = np.stack([far * np.cos(turn), far * np.sin(turn), 0.02 + rng.uniform(0, 0.03, 22)], axis=1)
    lie = rng.uniform(0, 2 * np.pi, 22)
    way = np.stack([np.cos(lie), np.sin(lie), rng.normal(0.0, 0.25, 22)], axis=1)
    size = rng.uniform(0.025, 0.055, 22)
    long = rng.uniform(0.12, 0.4, 22)
    sticks = Branches(
        at - 0.5 * long[:, None] * way, unit(way), long,
        0.15 * rng.normal(size=(22, 3)) * (1, 1, 0.3),
        size[:, None] * np.array([1.0, 0.7]), np.zeros(22),
    ).taken(np.arange(number))  # fmt: skip
    return sticks.tubes(
        2, 4 if level == 0 else 3, False, (1.0, 1.2, 1.5, 2.0)[level], pale=0.3, dark=0.7
    )
