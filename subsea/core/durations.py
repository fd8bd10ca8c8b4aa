"""What a list of durations says."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subsea.core.console import counted

SUMMARY = ("mean", "p50", "p95", "p99", "max")


def summary(durations_s: Sequence[float] | NDArray[np.floating[Any]]) -> dict[str, float]:
    """Mean, percentiles and maximum in milliseconds of durations in seconds, keyed by SUMMARY.

    Percentiles interpolate linearly between the neighbouring ranks.
    """
    ms = 1000.0 * np.asarray(durations_s, np.float64)
    p50, p95, p99 = np.percentile(ms, [50, 95, 99])
    return dict(zip(SUMMARY, map(float, (ms.mean(), p50, p95, p99, ms.max())), strict=True))


def sentence(durations_s: Sequence[float]) -> str:
    """The summary in one line, with the number of frames."""
    figures = summary(durations_s)
    named = ", ".join(f"{name} {figures[name]:.1f}" for name in ("mean", "p50", "p95", "max"))
    return f"{counted(len(durations_s), 'frame', 'frames')}; frame time in ms: {named}"
