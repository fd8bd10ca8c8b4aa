"""Measure on a GPU, with one command, everything that was only measured on a software rasteriser.

.venv/bin/python tools/gpu_report.py FOLDER [--minutes 8.5] [--only GROUP,…] [--shrink N]

Writes FOLDER/report.json and FOLDER/report.md: every preset at three sizes, 60 to 100,000 fishes,
the theatre of 4000x1000 pixels, stereo, a dome, the tables of the paper, and the stored pictures
with their differences. Each case runs in a process of its own, so that a fault of a driver ends
only this case. Both files are written after every case, so they hold what was measured before
Ctrl-C or the end of the time. --shrink divides the sizes of the pictures by N, for a trial on a
slow machine.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent.parent
BENCHMARK = [sys.executable, "-m", "subsea", "benchmark"]
SIZES = ("1280x720", "1920x1080", "3840x2160")
PRESETS = ("low", "medium", "high", "ultra")
FISH = (60, 1_000, 10_000, 30_000, 100_000)
MOST_S = 240.0  # a case is stopped after this time
LEAST_S = 4.0  # a case is not begun with less time left
LEAST_PX = 64  # a side of a picture
GROUPS = ("start", "presets", "fishes", "dive", "displays", "pictures", "paper")


@dataclass
class Case:
    """One measurement: a command, and what came of it."""

    group: str
    name: str
    command: list[str]  # without the option that names a file for the result
    fault: str = ""  # why there is no result
    result: Any = None  # the content of that file, else the text that was printed

    @property
    def is_benchmark(self) -> bool:
        """True if the command writes a report."""
        return self.group not in ("pictures", "paper")


def cases(options: argparse.Namespace) -> list[Case]:
    """List all cases of the chosen groups, in the order in which they run."""
    frames = ["--frames", str(options.frames)]

    def size(text: str) -> list[str]:
        width, height = (max(int(side) // options.shrink, LEAST_PX) for side in text.split("x"))
        return ["--size", f"{width}x{height}"]

    ocean, full_hd = ["--scenario", "open-ocean", "--fish"], size("1920x1080")
    drawn = {f"{preset}, 1920x1080": ["--quality", preset] for preset in PRESETS}
    drawn |= {f"{number:,}": [*ocean, str(number)] for number in FISH[2:]}
    theatre = ["--theatre", "three-projectors", "--shrink", str(options.shrink)]
    shown = {
        "three channels, 4000x1000": theatre,
        "side by side, 1920x1080": ["--display", "side-by-side", *full_hd],
        "anaglyph, 1920x1080": ["--display", "anaglyph", *full_hd],
        "dome, 2048x2048": ["--display", "dome", *size("2048x2048")],
    }
    benchmarks = {
        "start": {"the first start: kernels and caches": ["--frames", "1", "--size", "64x64"]},
        "presets": {
            f"{preset}, {pixels}": [*frames, *size(pixels), "--quality", preset]
            for pixels in SIZES
            for preset in PRESETS
        },
        "fishes": {f"{number:,}": [*frames, *ocean, str(number), *full_hd] for number in FISH},
        "dive": {
            name: [*frames, "--without", "sync", *full_hd, *words] for name, words in drawn.items()
        },
        "displays": {
            name: [*frames, *words, "--quality", "medium"] for name, words in shown.items()
        },
    }
    found = [
        Case(group, name, [*BENCHMARK, *words])
        for group, named in benchmarks.items()
        for name, words in named.items()
    ]
    tests = [sys.executable, "-m", "pytest", "tests/rendering", "-q", "-p", "no:cacheprovider"]
    found.append(Case("pictures", "stored pictures", tests))
    found.append(Case("paper", "tables 3 and 4 of the paper", [*BENCHMARK, "--paper"]))
    return [case for case in found if case.group in options.only]


def run_case(case: Case, left_s: float) -> None:
    """Run the command of a case, for at most `left_s`, and keep its result."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        option = {"pictures": ["--differences"], "paper": []}.get(case.group, ["--json"])
        command = case.command + [*option, *[str(report)] * len(option)]
        try:
            done = subprocess.run(
                command, cwd=HERE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                check=False, timeout=min(MOST_S, left_s),
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            case.fault = "no end in time"
            return
        if done.returncode:
            case.fault = (done.stdout.strip().splitlines() or ["failed"])[-1]
        if not option:
            case.result = done.stdout
        elif report.is_file():  # failing tests leave one too
            case.result = json.loads(report.read_text())


def write(folder: Path, found: list[Case]) -> None:
    """Write both files."""
    folder.mkdir(parents=True, exist_ok=True)
    listed = json.dumps([asdict(case) for case in found], indent=2)
    (folder / "report.json").write_text(listed + "\n", encoding="utf-8")
    (folder / "report.md").write_text(page(found), encoding="utf-8")


def page(found: list[Case]) -> str:
    """Format the report as a page of tables."""
    lines = ["# Report of a GPU", ""]
    reports = [case.result for case in found if case.is_benchmark and case.result]
    if reports:
        machine = reports[0]["machine"]
        lines += [f"{reports[0]['renderer']}; OpenGL {machine['driver']}; {machine['cpu']}, "
                  f"{machine['cores']} cores; commit {machine['commit']}", ""]  # fmt: skip
    for group in dict.fromkeys(case.group for case in found):
        own = [case for case in found if case.group == group]
        lines += [f"## {group.capitalize()}", ""]
        if own[0].is_benchmark:
            lines += [*_table(own), ""]
        elif group == "pictures":
            lines += [*_pictures(own[0].result or {}), ""]
        else:
            for case in own:
                lines += ["```text", case.result or "", "```", ""]
        lines += [f"- {case.name}: {case.fault}" for case in own if case.fault]
    return "\n".join(lines) + "\n"


def _table(own: list[Case]) -> list[str]:
    """Format rows of the figures of benchmarks, with the stages of the GPU in the last cell."""
    names = ("", "frame, p50", "p95", "frames/s", "host", "thread", "triangles", "calls", "GPU")
    lines = ["| " + " | ".join(names) + " |", "| --- " * len(names) + "|"]
    for case in own:
        if not case.result:
            continue
        r = case.result
        gpu = ", ".join(f"{name} {ms:.3f}" for name, ms in (r["gpu_ms"] or {}).items()) or "-"
        lines.append(
            f"| {case.name} | {r['frame_ms']['p50']:.2f} | {r['frame_ms']['p95']:.2f} "
            f"| {r['fps']:.0f} | {r['host_ms']:.2f} | {r['cpu_ms']['thread']:.2f} "
            f"| {r['triangles_mean']:.0f} | {r['draw_calls']} | {gpu} |"
        )
    return lines


def _pictures(differences: dict[str, dict[str, float]]) -> list[str]:
    """Format rows of the stored pictures and by how much they differ."""
    lines = ["| picture | pixels that differ | difference, levels: mean | largest |"]
    lines.append("| --- " * 4 + "|")
    for name, one in sorted(differences.items(), key=lambda item: -item[1]["share"]):
        lines.append(f"| {name} | {one['share']:.2%} | {one['mean']:.2f} | {one['most']} |")
    return lines


def main() -> int:
    """Measure, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--minutes", type=float, default=8.5)
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--shrink", type=int, default=1)
    parser.add_argument("--only", default=",".join(GROUPS), help=f"of {', '.join(GROUPS)}")
    options = parser.parse_args()
    options.only = options.only.split(",")
    if unknown := {*options.only} - {*GROUPS}:
        parser.error(f"--only: no group {', '.join(sorted(unknown))}; {', '.join(GROUPS)}")
    found, end = cases(options), time.monotonic() + 60.0 * options.minutes
    for number, case in enumerate(found, 1):
        left_s = end - time.monotonic()
        print(f"{number} of {len(found)}, {left_s:.0f} s left: {case.group}, {case.name}")
        if left_s < LEAST_S:
            case.fault = "no time left"
        else:
            run_case(case, left_s)
        write(options.folder, found)
    print(options.folder / "report.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
