"""A benchmark beside an older one: how many times faster, and how evenly so."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from subsea.errors import UserError

SETTINGS = (
    "renderer", "size", "theatre", "display", "quality", "scenario", "set", "tour", "seed",
    "frames", "without", "motor",
)  # fmt: skip
LARGEST = 100_000_000  # bytes of a report


class Report(msgspec.Struct, frozen=True):
    """What a comparison needs of a report that was written before."""

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


def read_reports(path: Path) -> list[Report]:
    """The reports in a file of `subsea benchmark --json`; a UserError names what is wrong."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except OSError as fault:
        raise UserError(f"{path}: cannot read ({fault.strerror})") from fault
    try:
        if len(content) > LARGEST:
            raise ValueError("too large")
        found = msgspec.json.decode(content)
        if isinstance(found, dict):
            found = found.get("ladder", [found])
        reports = msgspec.convert(found, list[Report])
        if not reports or any("p50" not in report.frame_ms for report in reports):
            raise ValueError("missing `frame_ms.p50`")
    except (ValueError, RecursionError) as fault:
        raise UserError(
            f"{path}: expected what `subsea benchmark --json` writes ({fault})"
        ) from fault
    return reports


def compare(reports: Sequence[dict[str, Any]], older: Sequence[Report], path: Path) -> None:
    """Print the figures of both for each number of fishes, and what else is not alike."""
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
        if others:
            print(f"not alike: {', '.join(others)}")
        print(f"{'ms':<14}{'then':>10}{'now':>10}{'times faster':>16}{'in most parts':>20}")
        for name, then, now, spread in _rows(report, old):
            ratio = f"{then / now:.2f}" if now > 0.0 else "-"
            part = f"{spread[0]:.2f} to {spread[1]:.2f}" if spread else "-"
            print(f"{name:<14}{then:>10.3f}{now:>10.3f}{ratio:>16}{part:>20}")


def _rows(
    report: dict[str, Any], old: Report
) -> Iterator[tuple[str, float, float, tuple[float, float] | None]]:
    """Name, medians then and now, and between which ratios most parts of the run lie."""
    then = {"frame": old.frame_ms["p50"], **old.stages_ms}
    now = {"frame": report["frame_ms"]["p50"], **report["stages_ms"]}
    for name in [name for name in now if name in then]:
        yield (
            name,
            then[name],
            now[name],
            spread(old.parts_ms.get(name, []), report["parts_ms"][name]),
        )


def spread(then: Sequence[float], now: Sequence[float]) -> tuple[float, float] | None:
    """The 10th and 90th percentile of the ratios of parts that lie at the same place of a tour.

    None unless there are as many of both, and more than one.
    """
    if len(then) != len(now) or len(now) < 2 or min(now) <= 0.0:
        return None
    low, high = np.percentile(np.array(then) / np.array(now), [10, 90])
    return float(low), float(high)
