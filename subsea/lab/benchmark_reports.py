"""Reports of `subsea benchmark`: statistics, tables, files, and comparison with older reports.

docs/developers/benchmarks.md has the formulas.
"""

import csv
import json
import os
import platform
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import msgspec
import numpy as np

import subsea
from subsea.base.arrays import Array, summarize_ms
from subsea.base.errors import UserError
from subsea.base.file_kinds import csv_file, json_file
from subsea.base.files import read_text, replacing
from subsea.base.progress import print_line
from subsea.base.report_files import DPI, STYLE
from subsea.base.system import cores
from subsea.base.validation import plain_words
from subsea.view.levels import LEVELS

PACKAGES = "numpy", "numba", "moderngl"
REFERENCE_SINES = 1 << 15  # on each core: about a third of a millisecond
STAGES = ("perception", "behavior", "motor", "habitat", "pose", "cull", "upload", "draw", "present")
PARTS = 10  # of a run; their medians show its evenness
REPORT = json_file("a report of `subsea benchmark`", "frame_ms", "ladder")
TIMES = csv_file("a table of `subsea benchmark`", "fish", "frame")
SHOWN = ("visible", "simulated", "triangles", "draw_calls")
COLOURS = (
    "#0072B2", "#009E73", "#56B4E9", "#C9A66B", "#CC79A7", "#F0E442", "#8C564B", "#E69F00",
    "#D55E00",
)  # fmt: skip
SETTINGS = (
    "renderer", "size", "theatre", "display", "quality", "scenario", "set", "tour", "seed",
    "frames", "without", "motor",
)  # fmt: skip
MACHINE = "cpu", "cores", "driver"
SIGNIFICANT = 1.05  # runs of the same code differ by less, apart from the machine's own speed
MAX_BYTES = 100 << 20  # of a report

T = TypeVar("T")


def describe_machine(graphics: Mapping[str, str]) -> dict[str, Any]:
    """Collect data to cite with a figure; `graphics` is the `info` of an OpenGL context.

    `load` is the load average of the last minute, None where the system has none.
    """
    return {
        "cpu": _processor(),
        "cores": cores(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "system": platform.platform(),
        "driver": graphics["GL_VERSION"],
        "python": platform.python_version(),
        "packages": {name: version(name) for name in PACKAGES},
        "commit": _commit(Path(subsea.__file__).parents[1]),
    }


def machine_line(machine: Mapping[str, Any]) -> str:
    """Describe the machine in one line."""
    count = f"{machine['cores']} cores" if machine["cores"] > 1 else "1 core"
    load = "" if machine["load"] is None else f", load {machine['load']}"
    commit = f"; commit {machine['commit']}" if machine["commit"] else ""
    return f"{machine['cpu']}, {count}{load}; OpenGL {machine['driver']}{commit}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())


def _commit(checkout: Path) -> str | None:
    """Ask for the commit of a checkout, with "+" if files differ from it; None elsewhere."""
    if not (checkout / ".git").exists():
        return None
    ask = ["git", "-C", str(checkout), "describe", "--always", "--exclude=*", "--dirty=+"]
    try:
        told = subprocess.run(ask, capture_output=True, text=True, check=False, timeout=10)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return told.stdout.strip() or None


@contextmanager
def reference_work() -> Iterator[Callable[[], float]]:
    """Yield a function that does a small fixed work on every core and returns its time, s.

    Other programs slow it down as they slow down frames, independently of our version.
    """
    number = cores()
    work = [np.linspace(0.0, 1.0, REFERENCE_SINES) for _ in range(number)]
    out = [np.empty(REFERENCE_SINES) for _ in range(number)]

    def measure() -> float:
        start = time.perf_counter()
        list(pool.map(np.sin, work, out))
        return time.perf_counter() - start

    with ThreadPoolExecutor(number) as pool:
        yield measure


class Frames(NamedTuple):
    """Times of F frames in seconds, and counts of the drawn things."""

    frame_s: Array  # (F,) total
    host_s: Array  # (F,) without running and waiting for drawing calls
    cpu_s: Array  # (F,) processor time of all threads
    thread_s: Array  # (F,) processor time of the calling thread
    yardstick_s: Array  # (F,) time of a fixed work beside it, see `machine.reference_work`
    stages_s: dict[str, Array]  # (F,) each
    gpu_s: dict[str, Array]  # (F,) time of the GPU in each of its stages; empty without a GPU
    visible: Array  # (F,) fishes drawn
    simulated: Array  # (F,) fishes simulated
    levels: Array  # (F, L) fishes drawn at each level of detail
    triangles: Array  # (F,)
    draw_calls: Array  # (F,)

    @property
    def rest_s(self) -> Array:
        """(F,) time outside the stages: hull, views, and other programs between stages."""
        return self.frame_s - np.sum([self.stages_s[name] for name in STAGES], axis=0)


def statistics(frames: Frames) -> dict[str, Any]:
    """Compute the measured part of a report."""
    frame_ms = summarize_ms(frames.frame_s)
    return {
        "frames": len(frames.frame_s),
        "visible_mean": float(frames.visible.mean()),
        "simulated_mean": float(frames.simulated.mean()),
        "frame_ms": frame_ms,
        "host_ms": summarize_ms(frames.host_s)["p50"],
        "cpu_ms": {
            "all": summarize_ms(frames.cpu_s)["p50"],
            "thread": summarize_ms(frames.thread_s)["p50"],
        },
        "gpu_ms": _gpu_ms(frames.gpu_s),
        "yardstick_ms": summarize_ms(frames.yardstick_s)["p50"],
        "fps": 1000.0 / frame_ms["mean"],
        "stages_ms": {name: summarize_ms(frames.stages_s[name])["p50"] for name in STAGES},
        "rest_ms": summarize_ms(frames.rest_s)["p50"],
        "parts_ms": {
            "frame": _parts_ms(frames.frame_s),
            "cpu": _parts_ms(frames.cpu_s),
            "yardstick": _parts_ms(frames.yardstick_s),
            **{name: _parts_ms(frames.stages_s[name]) for name in STAGES},
        },
        "lod": dict(zip(LEVELS, frames.levels.mean(axis=0).tolist(), strict=True)),
        "triangles_mean": float(frames.triangles.mean()),
        "draw_calls": int(frames.draw_calls.max()),
    }


def _gpu_ms(gpu_s: dict[str, Array]) -> dict[str, float] | None:
    """Compute medians of the time of the GPU, in all and in each stage; None without a GPU."""
    if not gpu_s:
        return None
    whole = np.sum([*gpu_s.values()], axis=0)
    return {
        name: summarize_ms(seconds)["p50"] for name, seconds in ({"all": whole} | gpu_s).items()
    }


def bound_by(report: dict[str, Any]) -> str | None:
    """Name what takes longer for a frame: "GPU" or "host"; None without a GPU."""
    if report["gpu_ms"] is None:
        return None
    return "GPU" if report["gpu_ms"]["all"] > report["cpu_ms"]["thread"] else "host"


def _parts_ms(durations_s: Array) -> list[float]:
    """Compute medians of consecutive tenths of a run, ms; fewer for less than ten frames."""
    parts = np.array_split(durations_s, min(PARTS, len(durations_s)))
    return [1000.0 * float(np.median(part)) for part in parts]


def print_report(report: dict[str, Any]) -> None:
    """Print a report, one figure a line."""
    print(f"{report['fish']} fishes, {report['visible_mean']:.1f} visible, {_pixels(report)}")
    print(f"motor {report['motor']}, {report['simulated_mean']:.1f} simulated")
    print(_drawn_by(report))
    print(machine_line(report["machine"]))
    for title in ("frame_ms", "cpu_ms", "stages_ms", "gpu_ms", "lod"):
        if report[title] is None:
            continue
        print(title)
        for name, value in report[title].items():
            print(f"  {name:<14}{value:>10.3f}")
    print(f"rest_ms {report['rest_ms']:.2f}, in no stage")
    print(f"host_ms {report['host_ms']:.2f}, at most {report['draw_calls']} drawing calls a frame")
    if limit := bound_by(report):
        print(f"bound by the {limit}")
    print(f"triangles {report['triangles_mean']:.0f} a frame, {report['fps']:.1f} frames a second")


def print_ladder(reports: Sequence[dict[str, Any]]) -> None:
    """Print several reports, one a line, medians in ms."""
    print_line(f"{reports[0]['scenario']}, motor {reports[0]['motor']}, {_pixels(reports[0])}")
    print(_drawn_by(reports[0]))
    print(machine_line(reports[0]["machine"]))
    names = ("fishes", "visible", "fps", "frame", "p95", "cpu", *STAGES)
    print("".join(f"{name:>{_wide(name)}}" for name in names))
    for report in reports:
        line = f"{report['fish']:>{_wide('fishes')}}{report['visible_mean']:>{_wide('visible')}.0f}"
        frame, cpu = report["frame_ms"], report["cpu_ms"]["all"]
        values = report["fps"], frame["p50"], frame["p95"], cpu, *report["stages_ms"].values()
        for name, value in zip(names[2:], values, strict=True):
            line += f"{value:>{_wide(name)}.2f}"
        print(line)


def _wide(name: str) -> int:
    return max(len(name), 7) + 2


def _pixels(report: dict[str, Any]) -> str:
    sizes = report["size"] if report["theatre"] else [report["size"]]
    return " + ".join(f"{width}x{height}" for width, height in sizes)


def _drawn_by(report: dict[str, Any]) -> str:
    return f"{report['renderer']}, quality {report['quality']} ({report['quality_drawn']})"


def write_json(path: Path, reports: Sequence[dict[str, Any]]) -> None:
    """Write a report as JSON; several as the list `ladder`."""
    content = reports[0] if len(reports) == 1 else {"ladder": [*reports]}
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def write_csv(path: Path, runs: Sequence[tuple[dict[str, Any], Frames]]) -> None:
    """Write a row for every frame: number of fishes, frame, times in ms, counts."""
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        times = [f"{name}_ms" for name in ("frame", "host", "cpu", *STAGES, "rest")]
        rows.writerow(["fish", "frame", *times, *SHOWN])
        for report, frames in runs:
            columns = [frames.frame_s, frames.host_s, frames.cpu_s]
            columns += [*(frames.stages_s[name] for name in STAGES), frames.rest_s]
            shown = [getattr(frames, name) for name in SHOWN]
            for k in range(len(frames.frame_s)):
                spent = [f"{1000.0 * column[k]:.4f}" for column in columns]
                rows.writerow([report["fish"], k, *spent, *(int(column[k]) for column in shown)])


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


def read_json(path: Path, command: str, decode: Callable[[str], T]) -> T:
    """Read the report that a command wrote as JSON; a UserError names the fault."""
    content = read_text(path, MAX_BYTES)
    try:
        return decode(content)
    except (ValueError, RecursionError) as fault:
        message, at, place = str(fault).partition(" - at ")
        reason = f"{plain_words(message)}{at}{place}"
        raise UserError(f"expected a report of `{command}` ({reason})", file=path) from fault


def read_reports(path: Path) -> list[OlderReport]:
    """Read the reports in a file of `subsea benchmark --json`; a UserError names the fault."""
    return read_json(path, "subsea benchmark", _decoded)


def _decoded(content: str) -> list[OlderReport]:
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
                print()
                print_line(f"{path} has no {report['fish']} fishes")
                continue
            old = older[0]
        print()
        print_line(f"{report['fish']} fishes, against {path} (subsea {old.version})")
        others = [name for name in ("fish", *SETTINGS) if getattr(old, name) != report[name]]
        here = report["machine"]
        others += [name for name in MACHINE if old.machine.get(name, here[name]) != here[name]]
        if others:
            print_line(f"different: {', '.join(others)}")
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
    """List names, and medians then and now, of all common figures."""
    yield "frame", old.frame_ms["p50"], report["frame_ms"]["p50"]
    if "all" in old.cpu_ms:
        yield "cpu", old.cpu_ms["all"], report["cpu_ms"]["all"]
    for name, now in report["stages_ms"].items():
        if name in old.stages_ms:
            yield name, old.stages_ms[name], now
    if old.yardstick_ms is not None:
        yield "yardstick", old.yardstick_ms, report["yardstick_ms"]


def spread(then: Sequence[float], now: Sequence[float]) -> tuple[float, float] | None:
    """Compute the 10th and 90th percentile of the ratios of corresponding parts of a tour.

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
