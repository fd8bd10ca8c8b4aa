"""The light of projectors as cameras saw it: gains, gammas and black levels.

A camera sees two projectors alike at a point of the screen that both light. So their ratio does not
depend on the paint of the screen, nor on the place of the camera.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.stage.calibration.optics import SeenLight
from subsea.view.rig import Rgb
from subsea.view.structured_light import GREYS, UNIFORM

NUMBER = {pattern.name: k for k, pattern in enumerate(UNIFORM)}
COLOURS = "red", "green", "blue"
NEAR = 1.5  # blocks apart, within which two blocks are at one place
SHARED = 20  # blocks that two projectors must share to be compared
BRIGHT = 0.3  # share of the brightest blocks' light below which a block is too dim to measure
LEAST_GAIN = 0.1
GAMMAS = 1.4, 3.2  # plausible ones
MOST_BLACK = 0.05


class LightLevels(NamedTuple):
    """The light of one projector."""

    gain: Rgb = (1.0, 1.0, 1.0)  # at which its overlaps match those of its neighbours
    gamma: Rgb | None = None  # None: not measured
    black: float = 0.0  # share of its white


def light_levels(seen: Sequence[SeenLight], count: int) -> list[LightLevels]:
    """The levels of `count` projectors from all that the cameras saw."""
    gains, blacks = _gains(seen, count), _blacks(seen, count)
    return [
        LightLevels(_rgb(gains[k]), _gamma([one for one in seen if one.channel == k]), blacks[k])
        for k in range(count)
    ]


def _gains(seen: Sequence[SeenLight], count: int) -> Array:
    """Gains (count, 3), at most 1, that make overlaps alike."""
    rows, values, weights = [], [], []
    for one, other, pairs in _overlaps(seen):
        ratio = []
        for colour, name in enumerate(COLOURS):
            a, b = (_light_of(part, name)[number, colour] for part, number in
                    ((one, pairs[0]), (other, pairs[1])))  # fmt: skip
            good = (a > BRIGHT * a.max()) & (b > BRIGHT * b.max())
            ratio.append(float(np.median(np.log(a[good] / b[good]))) if good.any() else 0.0)
        row = np.zeros(count)
        row[one.channel], row[other.channel] = 1.0, -1.0
        rows.append(row)
        values.append(ratio)
        weights.append(np.sqrt(len(pairs[0])))
    if not rows:
        return np.ones((count, 3))
    weight = np.array(weights)[:, None]
    # Of all solutions the shortest: each group of neighbours has a mean of 0.
    found, *_ = np.linalg.lstsq(np.array(rows) * weight, -np.array(values) * weight, rcond=None)
    for group in _groups(np.array(rows)):
        found[group] -= found[group].max(axis=0)
    return np.asarray(np.maximum(np.exp(found), LEAST_GAIN))


def _groups(rows: Array) -> Iterator[list[int]]:
    """Numbers of projectors that overlap directly or through others."""
    left = set(range(rows.shape[1]))
    while left:
        group = {left.pop()}
        while more := {
            int(k) for row in rows for k in np.flatnonzero(row)
            if group & set(np.flatnonzero(row).tolist())
        } - group:  # fmt: skip
            group |= more
        left -= group
        yield sorted(group)


def _gamma(seen: Sequence[SeenLight]) -> Rgb | None:
    """The gamma of a projector for red, green and blue; None if the photographs do not tell."""
    found = []
    for one in seen:
        primaries = np.stack([_light_of(one, name) for name in COLOURS], axis=2)  # (n, 3, colour)
        bright = primaries.sum(axis=(1, 2))
        good = bright > BRIGHT * bright.max(initial=0.0)
        good &= np.abs(np.linalg.det(primaries)) > 1e-9
        if good.sum() < SHARED:
            continue
        for code in GREYS:
            grey = _light_of(one, f"grey-{code}")[good]
            shares = np.linalg.solve(primaries[good], grey[..., None])[..., 0]
            share = np.median(shares, axis=0)
            if (share <= 0.0).any():
                return None
            found.append(np.log(share) / np.log(code / 255.0))
    if not found:
        return None
    gamma = np.mean(found, axis=0)
    return _rgb(gamma) if (gamma > GAMMAS[0]).all() and (gamma < GAMMAS[1]).all() else None


def _blacks(seen: Sequence[SeenLight], count: int) -> list[float]:
    """The black levels of projectors, as shares of their white.

    All projectors shine black in every black photograph, on top of the light of the room. This is
    a smooth function of the place, their black is in proportion to their white.
    """
    from scipy.optimize import nnls

    sums, number = np.zeros(count), np.zeros(count)
    for camera in {one.camera for one in seen}:
        own = [one for one in seen if one.camera == camera]
        pixels = np.concatenate([one.pixels for one in own])
        x, y = ((pixels - pixels.mean(axis=0)) / max(float(pixels.std()), 1.0)).T
        dark = np.concatenate([one.light[:, NUMBER["black"]].mean(axis=1) for one in own])
        whites = []
        for one in own:
            white, near = np.zeros(len(pixels)), _nearest(one, pixels)
            white[near >= 0] = _light_of(one, "white").mean(axis=1)[near[near >= 0]]
            whites.append(white)
        room = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
        # The room may rise or fall with the place; its light is not negative.
        terms = np.hstack([room, -room[:, 1:], np.stack(whites, axis=1)])
        solved, _ = nnls(terms, dark)
        for one, black in zip(own, solved[-len(own) :], strict=True):
            sums[one.channel] += black
            number[one.channel] += 1
    return np.clip(sums / np.maximum(number, 1.0), 0.0, MOST_BLACK).tolist()


def _overlaps(
    seen: Sequence[SeenLight],
) -> Iterator[tuple[SeenLight, SeenLight, tuple[Ints, Ints]]]:
    """Pairs of projectors that a camera saw at the same places, and the numbers of blocks there."""
    for k, one in enumerate(seen):
        for other in seen[k + 1 :]:
            if one.camera != other.camera:
                continue
            near = _nearest(other, one.pixels)
            mine = np.flatnonzero(near >= 0)
            if len(mine) >= SHARED:
                yield one, other, (mine, near[mine])


def _nearest(one: SeenLight, pixels: Array) -> Ints:
    """The number (n,) of the block nearest to each of `pixels` (n, 2); -1: none is near."""
    from scipy.spatial import cKDTree

    tree = cKDTree(one.pixels)
    apart = float(np.median(tree.query(one.pixels, 2)[0][:, 1]))
    _, number = tree.query(pixels, distance_upper_bound=NEAR * apart)
    return np.where(number < len(one.pixels), number, -1)


def _light_of(one: SeenLight, name: str) -> Array:
    """The light (n, 3) of a uniform picture of a projector, without black."""
    return np.asarray(one.light[:, NUMBER[name]] - one.light[:, NUMBER["black"]])


def _rgb(values: Array) -> Rgb:
    red, green, blue = (round(float(value), 3) for value in values)
    return red, green, blue
