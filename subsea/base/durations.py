"""Statistics of frame times."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.base.console import count_noun

SUMMARY = ("mean", "p50", "p95", "p99", "max")


def summarize_ms(durations_s: Sequence[float] | NDArray[np.floating[Any]]) -> dict[str, float]:
    """Mean, percentiles and maximum in milliseconds of durations in seconds, keyed by SUMMARY.

    Percentiles are interpolated linearly.
    """
    ms = 1000.0 * np.asarray(durations_s, np.float64)
    p50, p95, p99 = np.percentile(ms, [50, 95, 99])
    return dict(zip(SUMMARY, map(float, (ms.mean(), p50, p95, p99, ms.max())), strict=True))


def describe_durations(durations_s: Sequence[float]) -> str:
    """Number of frames and statistics of their times, in one line."""
    figures = summarize_ms(durations_s)
    named = ", ".join(f"{name} {figures[name]:.1f}" for name in ("mean", "p50", "p95", "max"))
    return f"{count_noun(len(durations_s), 'frame', 'frames')}; frame time in ms: {named}"
