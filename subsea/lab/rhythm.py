"""The rhythm of swimming: how the speed of one fish varies, and how long it glides."""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from subsea.base.arrays import Bools, Ints
from subsea.lab.measures import SAMPLE_S
from subsea.media.record import Record

LEAST_S = 8.0  # of a fish, for a measure of its speeds
SLOW = 0.5  # of the own median speed
STILL_S = 0.4  # a tail that keeps its place for so long is still, not at the end of a beat
STILL_BL = 0.02  # greatest way to the side of a still tail
MOVING_BL_S = 0.1  # a fish that glides is faster


class Rhythm(NamedTuple):
    """Rhythm of several fishes; NaN where none was watched for long enough."""

    variation: float  # standard deviation of the speed over its mean: median of the fishes
    slow: float  # share of the time below half the own median speed: mean of the fishes
    gliding: float  # share of the time that they move with a still tail


def rhythm(record: Record, those: Ints, chosen: Bools) -> Rhythm:
    """Measure the rhythm of the fishes `those` (m,) in the ticks `chosen` (T, m).

    Speeds are those of the centre of mass over a fifth of a second. Fins at the breast may move in
    a glide, but not oars that drive the fish.
    """
    every = max(round(SAMPLE_S / record.tick_s), 1)
    length = record.length[those].astype(np.float64)
    way = np.diff(record.centre[::every][:, those].astype(np.float64), axis=0)
    speed = np.linalg.norm(way, axis=2) / (every * record.tick_s) / length
    there = chosen[::every][1:] & chosen[::every][:-1]
    found = [speed[there[:, k], k] for k in range(len(those))]
    found = [one for one in found if len(one) * SAMPLE_S >= LEAST_S and one.mean() > 0.0]
    if not found:
        return Rhythm(np.nan, np.nan, np.nan)
    variation = float(np.median([one.std() / one.mean() for one in found]))
    slow = float(np.mean([(one < SLOW * np.median(one)).mean() for one in found]))
    still = glides(record, those)
    return Rhythm(variation, slow, float(still[chosen].mean()) if chosen.any() else np.nan)


def glides(record: Record, those: Ints) -> Bools:
    """Flag (T, m) where the fishes `those` glide: they move while their tails keep their places."""
    ticks = max(round(STILL_S / record.tick_s), 1) + 1
    if len(record.time) < ticks:
        return np.zeros((len(record.time), len(those)), np.bool_)
    length = record.length[those]
    w, x, y, z = np.moveaxis(record.orientation[:, those], -1, 0)
    right = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
    behind = record.tail[:, those] - record.position[:, those]
    aside = sliding_window_view((behind * right).sum(axis=-1) / length, ticks, axis=0)
    still = aside.max(axis=-1) - aside.min(axis=-1) < STILL_BL
    centre = record.centre[:, those]
    way = np.linalg.norm(centre[ticks - 1 :] - centre[: 1 - ticks], axis=-1) / length
    still &= way > MOVING_BL_S * (ticks - 1) * record.tick_s
    rows = np.array([name.startswith("row") for name in record.segment_names])
    # A tick is part of a glide if any of the windows about it is.
    count = np.zeros((len(record.time) + 1, len(those)), np.int32)
    count[ticks:] = np.cumsum(still, axis=0)
    first = np.arange(len(record.time))
    covered = count[np.minimum(first + ticks, len(record.time))] > count[first]
    return np.asarray(covered & ~rows[record.segment[:, those]])
