"""Plot the stages of every frame of a benchmark, stacked."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from subsea.base.atomic_io import replacing
from subsea.base.plot_files import DPI, STYLE
from subsea.lab.profiling.frame_statistics import STAGES, Frames

COLOURS = (
    "#0072B2", "#009E73", "#56B4E9", "#C9A66B", "#CC79A7", "#F0E442", "#8C564B", "#E69F00",
    "#D55E00",
)  # fmt: skip


def plot_stages(path: Path, runs: Sequence[tuple[dict[str, Any], Frames]]) -> None:
    """Write a PNG with a chart for each run, atomically. Needs matplotlib."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE), replacing(path) as temporary:
        page = Figure(figsize=(9, 1.0 + 2.4 * len(runs)), dpi=DPI, layout="constrained")
        charts = page.subplots(len(runs), 1, sharex=True, squeeze=False)[:, 0]
        for chart, (report, frames) in zip(charts, runs, strict=True):
            number = np.arange(len(frames.frame_s))
            stages = 1000.0 * np.stack([frames.stages_s[name] for name in STAGES])
            chart.stackplot(number, stages, labels=STAGES, colors=COLOURS, linewidth=0)
            chart.plot(number, 1000.0 * frames.frame_s, color="0.15", linewidth=0.7, label="all")
            chart.set(
                title=f"{report['fish']} fishes: {report['frame_ms']['p50']:.1f} ms a frame",
                ylabel="ms",
                xlim=(0, max(len(number) - 1, 1)),
                ylim=(0, 1.25 * 1000.0 * float(np.percentile(frames.frame_s, 99))),
            )
        charts[-1].set_xlabel(f"frame of {report['scenario']}, tour {report['tour']}")
        handles, labels = charts[0].get_legend_handles_labels()
        page.legend(handles[::-1], labels[::-1], loc="outside right upper")
        page.savefig(temporary, format="png", metadata={"Software": None})
