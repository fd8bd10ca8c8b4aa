"""Compare a benchmark with an older one: speedup, and whether it is significant.

Plot the stages of every frame of a benchmark, stacked.
"""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np

from subsea.base.errors import UserError
from subsea.base.files import read_input, replacing
from subsea.base.report_files import DPI, STYLE
from subsea.base.validation import plain_words
from subsea.lab.profiling.frame_statistics import STAGES, Frames

SETTINGS = (
    "renderer", "size", "theatre", "display", "quality", "scenario", "set", "tour", "seed",
    "frames", "without", "motor",
)  # fmt: skip
MACHINE = "cpu", "cores", "driver"
SIGNIFICANT = 1.05  # runs of the same code differ by less, apart from the machine's own speed
MAX_BYTES = 100 << 20  # of a report

T = TypeVar("T")


class OlderReport(msgspec.Struct, frozen=True):
    """The parts of an older report that are compared."""

    fish: int
    version: str
    frame_ms: dict[str, float]
    stages_ms: dict[str, float]
    renderer: str
    size: list[Any]
    display: str
    scenario: str
    seed: int
    frames: int
    without: list[str]
    theatre: str | None = None
    quality: str = "low"
    set: list[str] = []
    tour: str = "auto"
    motor: str = "playback"
    parts_ms: dict[str, list[float]] = {}
    cpu_ms: dict[str, float] = {}
    yardstick_ms: float | None = None
    machine: dict[str, Any] = {}


def read_json(path: Path, command: str, decode: Callable[[bytes], T]) -> T:
    """Read the report that a command wrote as JSON; a UserError names the fault."""
    content = read_input(path, MAX_BYTES)
    try:
        return decode(content)
    except (ValueError, RecursionError) as fault:
        message, at, place = str(fault).partition(" - at ")
        reason = f"{plain_words(message)}{at}{place}"
        raise UserError(f"expected a report of `{command}` ({reason})", file=path) from fault


def read_reports(path: Path) -> list[OlderReport]:
    """The reports in a file of `subsea benchmark --json`; a UserError names the fault."""
    return read_json(path, "subsea benchmark", _decoded)


def _decoded(content: bytes) -> list[OlderReport]:
    found = msgspec.json.decode(content)
    if isinstance(found, dict):
        found = found.get("ladder", [found])
    reports = msgspec.convert(found, list[OlderReport])
    if not reports or any("p50" not in report.frame_ms for report in reports):
        raise ValueError("missing `frame_ms.p50`")
    return reports


def compare(reports: Sequence[dict[str, Any]], older: Sequence[OlderReport], path: Path) -> None:
    """Print the figures of both for each number of fishes, and settings that differ."""
    before = {report.fish: report for report in older}
    for report in reports:
        old = before.get(report["fish"])
        if old is None:
            if len(reports) > 1 or len(older) > 1:
                print(f"\n{path} has no {report['fish']} fishes")
                continue
            old = older[0]
        print(f"\n{report['fish']} fishes, against {path} (subsea {old.version})")
        others = [name for name in ("fish", *SETTINGS) if getattr(old, name) != report[name]]
        others += [
            name
            for name in MACHINE
            if name in old.machine and old.machine[name] != report["machine"][name]
        ]
        if others:
            print(f"different: {', '.join(others)}")
        parts = old.parts_ms
        machine = spread(parts.get("yardstick", []), report["parts_ms"]["yardstick"])
        print(f"{'ms':<14}{'then':>10}{'now':>10}{'times faster':>14}{'in most parts':>20}")
        for name, then, now in _rows(report, old):
            own = spread(parts.get(name, []), report["parts_ms"][name])
            ratio = f"{then / now:.2f}" if now > 0.0 else "-"
            part = f"{own[0]:.2f} to {own[1]:.2f}" if own else "-"
            # Processor time does not depend on other programs.
            told = "" if name == "yardstick" else verdict(own, None if name == "cpu" else machine)
            print(f"{name:<14}{then:>10.3f}{now:>10.3f}{ratio:>14}{part:>20}  {told}".rstrip())


def _rows(report: dict[str, Any], old: OlderReport) -> Iterator[tuple[str, float, float]]:
    """Names, and medians then and now, of all common figures."""
    yield "frame", old.frame_ms["p50"], report["frame_ms"]["p50"]
    if "all" in old.cpu_ms:
        yield "cpu", old.cpu_ms["all"], report["cpu_ms"]["all"]
    for name, now in report["stages_ms"].items():
        if name in old.stages_ms:
            yield name, old.stages_ms[name], now
    if old.yardstick_ms is not None:
        yield "yardstick", old.yardstick_ms, report["yardstick_ms"]


def spread(then: Sequence[float], now: Sequence[float]) -> tuple[float, float] | None:
    """10th and 90th percentile of the ratios of corresponding parts of a tour.

    None unless both have the same number of parts, and more than one.
    """
    if len(then) != len(now) or len(now) < 2 or min(now) <= 0.0:
        return None
    low, high = np.percentile(np.array(then) / np.array(now), [10, 90])
    return float(low), float(high)


def verdict(own: tuple[float, float] | None, machine: tuple[float, float] | None) -> str:
    """Classify the ratios of a figure, given those of the machine's own speed.

    A difference is significant beyond 1 and the machine's own change by the factor `SIGNIFICANT`.
    Empty for a report without parts.
    """
    if own is None:
        return ""
    usual = 1.0, *(machine or ())
    low, high = min(usual), max(usual)
    if own[0] > high * SIGNIFICANT:
        return "faster"
    return "slower" if own[1] * SIGNIFICANT < low else "no difference"


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
