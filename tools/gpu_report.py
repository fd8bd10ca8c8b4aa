"""Measure on a GPU, with one command, everything that was only measured on a software rasteriser.

.venv/bin/python tools/gpu_report.py FOLDER [--minutes 8.5] [--only GROUP,…] [--shrink N]

Writes FOLDER/report.json and FOLDER/report.md: every preset at three sizes, 60 to 100,000 fishes,
the theatre of 4000x1000 pixels, stereo, a dome, the tables of the paper, and the stored pictures
with their differences. Each case runs in a process of its own, so that a fault of a driver ends
only this case. Both files are written after every case: Ctrl-C or the end of the time keeps what
is measured. Cases that no longer fit are listed as left out.

--shrink divides the sizes of the pictures by N, for a trial on a slow machine.
"""

import argparse
import json
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent.parent
SUBSEA = [sys.executable, "-m", "subsea"]
SIZES = ("1280x720", "1920x1080", "3840x2160")
PRESETS = ("low", "medium", "high", "ultra")
FISH = (60, 1_000, 10_000, 30_000, 100_000)
LEAST_S = 4.0  # a case is not begun with less time left
LEAST_PX = 64  # a side of a picture
GROUPS = ("start", "presets", "fishes", "dive", "displays", "pictures", "paper")


@dataclass
class Case:
    """One measurement: a command, and what came of it."""

    group: str
    name: str
    command: list[str]
    kind: str = "benchmark"  # also "text" and "pictures": what the command leaves
    most_s: float = 90.0  # it is stopped after this time
    state: str = "waiting"  # then done, failed, stopped or left out
    reason: str = ""
    seconds: float = 0.0
    result: Any = field(default=None)


def cases(options: argparse.Namespace) -> list[Case]:
    """All cases of the chosen groups, in the order in which they run."""
    frames, shrink = str(options.frames), options.shrink

    def benchmark(group: str, name: str, *words: str, most_s: float = 90.0) -> Case:
        command = [*SUBSEA, "benchmark", "--frames", frames, *words]
        return Case(group, name, command, most_s=most_s)

    first = benchmark("start", "the first start: kernels and caches", "--size", "64x64")
    first.command[first.command.index("--frames") + 1] = "1"
    first.most_s = 240.0
    found = [first]
    for size in SIZES:
        for preset in PRESETS:
            words = "--size", smaller(size, shrink), "--quality", preset
            found.append(benchmark("presets", f"{preset}, {size}", *words))
    ocean, full_hd = (
        ("--scenario", "open-ocean", "--fish"),
        ("--size", smaller("1920x1080", shrink)),
    )
    for number in FISH:
        words = *ocean, str(number), *full_hd
        found.append(benchmark("fishes", f"{number:,}", *words, most_s=120.0))
    together = "--without", "sync", *full_hd
    drawn = [(f"{preset}, 1920x1080", ("--quality", preset)) for preset in PRESETS]
    drawn += [(f"{number:,}", (*ocean, str(number))) for number in FISH[2:]]
    found += [benchmark("dive", name, *together, *words, most_s=120.0) for name, words in drawn]
    theatre = ["--theatre", "three-projectors", "--shrink", str(shrink), "--quality", "medium"]
    found.append(benchmark("displays", "three channels, 4000x1000", *theatre))
    for name, display, size in (
        ("side by side", "side-by-side", "1920x1080"),
        ("anaglyph", "anaglyph", "1920x1080"),
        ("dome", "dome", "2048x2048"),
    ):
        view = ["--display", display, "--size", smaller(size, shrink), "--quality", "medium"]
        found.append(benchmark("displays", f"{name}, {size}", *view))
    tests = [sys.executable, "-m", "pytest", "tests/rendering", "-q", "-p", "no:cacheprovider"]
    found.append(Case("pictures", "stored pictures", tests, "pictures", 150.0))
    paper = [*SUBSEA, "benchmark", "--paper"]
    found.append(Case("paper", "tables 3 and 4 of the paper", paper, "text", 120.0))
    return [case for case in found if case.group in options.only]


def smaller(size: str, shrink: int) -> str:
    """A size divided by `shrink`."""
    width, height = (max(int(side) // shrink, LEAST_PX) for side in size.split("x"))
    return f"{width}x{height}"


def run_case(case: Case, left_s: float) -> None:
    """Run the command of a case, for at most `left_s`, and keep what it leaves."""
    with tempfile.TemporaryDirectory() as folder:
        leaves = {"benchmark": "--json", "pictures": "--differences"}.get(case.kind)
        result = Path(folder) / "result.json"
        command = case.command if leaves is None else [*case.command, leaves, str(result)]
        start = time.monotonic()
        with (Path(folder) / "output").open("w+") as output:
            try:
                code = subprocess.run(
                    command, cwd=HERE, stdout=output, stderr=subprocess.STDOUT, check=False,
                    timeout=min(case.most_s, left_s),
                ).returncode  # fmt: skip
            except subprocess.TimeoutExpired:
                code = None
            finally:
                case.seconds = time.monotonic() - start
            output.seek(0)
            text = output.read()
        case.state = "stopped" if code is None else "failed" if code else "done"
        if code is None:
            case.reason = f"no end after {case.seconds:.0f} s"
        elif code:
            case.reason = next((line for line in reversed(text.splitlines()) if line.strip()), "")
        if case.kind == "text":
            case.result = text
        elif result.is_file():  # failing tests leave one too
            case.result = json.loads(result.read_text())


def measure(
    found: list[Case], minutes: float, keep: Callable[[], None], tell: Callable[[str], None] = print
) -> bool:
    """Run the cases until the time is over; `keep` is called after each. False if interrupted."""
    begin = time.monotonic()
    for number, case in enumerate(found):
        left_s = 60.0 * minutes - (time.monotonic() - begin)
        if left_s < LEAST_S:
            case.state, case.reason = "left out", "no time left"
            continue
        tell(f"{number + 1} of {len(found)}, {left_s:.0f} s left: {case.group}, {case.name}")
        try:
            run_case(case, left_s)
        except KeyboardInterrupt:
            case.state, case.reason = "stopped", "interrupted"
            for later in found[number + 1 :]:
                later.state, later.reason = "left out", "interrupted"
            keep()
            return False
        keep()
    keep()
    return True


def write(folder: Path, found: list[Case], minutes: float) -> None:
    """Write both files."""
    folder.mkdir(parents=True, exist_ok=True)
    content = {"minutes": minutes, "python": platform.python_version()}
    listed = [asdict(case) for case in found]
    for name, text in (
        ("report.json", json.dumps(content | {"cases": listed}, indent=2) + "\n"),
        ("report.md", page(found)),
    ):
        temporary = folder / f"{name}.part"
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(folder / name)


def page(found: list[Case]) -> str:
    """The report as a page of tables."""
    lines = ["# Report of a GPU", ""]
    reports = [case.result for case in found if case.kind == "benchmark" and case.result]
    if reports:
        machine = reports[0]["machine"]
        lines += [f"{reports[0]['renderer']}; OpenGL {machine['driver']}; {machine['cpu']}, "
                  f"{machine['cores']} cores; commit {machine['commit']}", ""]  # fmt: skip
    for group in GROUPS:
        own = [case for case in found if case.group == group]
        if not own:
            continue
        lines += [f"## {group.capitalize()}", ""]
        if any(case.kind == "benchmark" for case in own):
            lines += [*_table(own), ""]
        for case in own:
            if case.kind == "text" and case.result:
                lines += ["```text", case.result.rstrip(), "```", ""]
            elif case.kind == "pictures" and case.result:
                lines += [*_pictures(case.result), ""]
        lines += [f"- {case.name}: {case.state}, {case.reason}" for case in own if case.reason]
        lines += [""] if any(case.reason for case in own) else []
    return "\n".join(lines)


def _table(own: list[Case]) -> list[str]:
    """Rows of the figures of benchmarks, and of the stages of the GPU."""
    done = [case for case in own if case.result]
    names = ("", "frame, p50", "p95", "frames/s", "host", "thread", "GPU", "triangles", "calls")
    lines = ["| " + " | ".join(names) + " |", "| --- " * len(names) + "|"]
    for case in done:
        r = case.result
        gpu = f"{r['gpu_ms']['all']:.2f}" if r["gpu_ms"] else "-"
        lines.append(
            f"| {case.name} | {r['frame_ms']['p50']:.2f} | {r['frame_ms']['p95']:.2f} "
            f"| {r['fps']:.0f} | {r['host_ms']:.2f} | {r['cpu_ms']['thread']:.2f} | {gpu} "
            f"| {r['triangles_mean']:.0f} | {r['draw_calls']} |"
        )
    timed = [case for case in done if case.result["gpu_ms"]]
    if timed:
        stages = [name for name in timed[0].result["gpu_ms"] if name != "all"]
        lines += [
            "",
            "| GPU, ms | " + " | ".join(stages) + " |",
            "| --- " * (1 + len(stages)) + "|",
        ]
        for case in timed:
            values = (f"{case.result['gpu_ms'][name]:.3f}" for name in stages)
            lines.append(f"| {case.name} | " + " | ".join(values) + " |")
    return lines


def _pictures(differences: dict[str, dict[str, float]]) -> list[str]:
    """Rows of the stored pictures and by how much they differ."""
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
    found = cases(options)
    whole = measure(found, options.minutes, lambda: write(options.folder, found, options.minutes))
    done = sum(case.state == "done" for case in found)
    print(f"{done} of {len(found)} cases measured: {options.folder / 'report.md'}")
    return 0 if whole else 130


if __name__ == "__main__":
    sys.exit(main())
