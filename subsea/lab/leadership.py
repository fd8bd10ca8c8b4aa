"""Measure who turns first in a school: delays of direction (Nagy et al. 2010)."""

from typing import NamedTuple

import numpy as np

from subsea.base.arrays import Array, Ints
from subsea.geometry.periodic import gathered
from subsea.lab.measures import headings
from subsea.media.record import Record
from subsea.state import AVOID, ESCAPE, PICK, SCHOOL

STEP_S = 0.1  # interval of samples
MOST_S = 2.0  # longest delay that is looked for
LEAST_SHARE = 0.5  # of the record that a fish schools for, to be measured
LEAST_DROP = 0.01  # of the correlation within MOST_S; it falls less in a school that swims straight


class Leadership(NamedTuple):
    """Delays of the m fishes of a school; NaN for a fish whose delay is unknown."""

    fish: Ints  # (m,)
    delay_s: Array  # (m,) by which the others turn after this fish; negative: before
    front_bl: Array  # (m,) mean place ahead of the middle of the school, body lengths

    @property
    def first(self) -> int | None:
        """The fish that turns first; None if no delay is known."""
        return None if np.isnan(self.delay_s).all() else int(self.fish[np.nanargmax(self.delay_s)])

    @property
    def front_correlation(self) -> float:
        """Pearson's correlation of the delays with the places ahead; NaN for less than three."""
        known = ~np.isnan(self.delay_s)
        delay, front = self.delay_s[known], self.front_bl[known]
        if len(delay) < 3 or delay.std() < 1e-9 or front.std() < 1e-9:
            return float("nan")
        return float(np.corrcoef(delay, front)[0, 1])


def leadership(record: Record, leader: int) -> Leadership:
    """Measure the delays of direction in the school of a leader.

    The delay of a fish is the time after which the mean heading of the others correlates most with
    its own. Samples in which a fish does not school do not count for it.
    """
    every = max(round(STEP_S / record.tick_s), 1)
    led = record.leader[::every] == leader
    led[:, leader] = True
    doing = np.isin(record.intention[::every], (SCHOOL, PICK, AVOID, ESCAPE))
    doing[:, leader] = True
    there = led & doing & record.alive[::every]
    fish = np.flatnonzero(there.mean(axis=0) >= LEAST_SHARE)
    there = there[:, fish]
    ahead = headings(record.orientation[::every][:, fish]) * there[..., None]
    others = _unit(ahead.sum(axis=1, keepdims=True) - ahead)
    lags = np.arange(-round(MOST_S / (every * record.tick_s)), 0)
    lags = np.concatenate([lags, [0], -lags[::-1]])
    found = np.array([_correlation(ahead, others, int(lag)) for lag in lags])
    delay = np.array([_peak(column) for column in found.T]) - len(lags) // 2
    place = record.position[::every][:, fish].astype(np.float64)
    if record.period[0]:
        place = np.stack([gathered(one, record.period) for one in place])
    count = np.maximum(there.sum(axis=1), 1)[:, None, None]
    middle = (place * there[..., None]).sum(axis=1, keepdims=True) / count
    way = _unit(ahead.sum(axis=1, keepdims=True))
    along = ((place - middle) * way).sum(axis=2) * there
    front = along.sum(axis=0) / np.maximum(there.sum(axis=0), 1) / record.length[fish]
    return Leadership(fish, delay * every * record.tick_s, front)


def _unit(vectors: Array) -> Array:
    """Scale vectors (..., 3) to length 1; zeros stay."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def _correlation(ahead: Array, others: Array, lag: int) -> Array:
    """Correlate headings (T, m, 3) with those of the others `lag` samples later (m,)."""
    samples = len(ahead) - abs(lag)
    if samples < 1:
        return np.full(ahead.shape[1], np.nan)
    begin = max(-lag, 0)
    mine, theirs = ahead[begin : begin + samples], others[begin + lag : begin + lag + samples]
    counts = (np.abs(mine).sum(axis=2) > 0) & (np.abs(theirs).sum(axis=2) > 0)
    total = (mine * theirs).sum(axis=2) * counts
    return np.asarray(total.sum(axis=0) / np.maximum(counts.sum(axis=0), 1))


def _peak(values: Array) -> float:
    """Find the place of the peak of a correlation (k,), between samples by a parabola.

    NaN for a flat peak, and for one from which the correlation hardly falls toward an end.
    """
    k = int(values.argmax()) if np.isfinite(values).all() else 0
    if k in (0, len(values) - 1) or values[k] - max(values[0], values[-1]) < LEAST_DROP:
        return float("nan")
    before, top, after = values[k - 1 : k + 2]
    return k + 0.5 * float(before - after) / min(float(before - 2.0 * top + after), -1e-12)
