"""The report of a GPU: what fits the time is measured, the rest is named, nothing is lost."""

import argparse
import json
import sys

from subsea.cli.main import parsers
from tools import gpu_report as tool

RESULT = {
    "renderer": "Some GPU", "machine": {"driver": "4.6", "cpu": "x", "cores": 8, "commit": "y"},
    "frame_ms": {"p50": 2.0, "p95": 3.0}, "fps": 500.0, "host_ms": 1.0,
    "cpu_ms": {"thread": 1.5}, "gpu_ms": {"all": 0.75, "water": 0.5, "fishes": 0.25},
    "triangles_mean": 1000.0, "draw_calls": 20,
}  # fmt: skip


def chosen(*only, shrink=1):
    return tool.cases(argparse.Namespace(frames=2, shrink=shrink, only=only or tool.GROUPS))


def python(group, name, program):
    """A case that is a program of its own."""
    return tool.Case(group, name, [sys.executable, "-c", program])


def test_everything_that_no_gpu_has_drawn_is_a_case():
    names = [f"{case.group}: {case.name}" for case in chosen()]
    for preset in ("low", "medium", "high", "ultra"):
        for size in ("1280x720", "1920x1080", "3840x2160"):
            assert f"presets: {preset}, {size}" in names
    assert [n for n in names if n.startswith("fishes")][-1] == "fishes: 100,000"
    assert {case.group for case in chosen()} == {*tool.GROUPS}
    small = [word for case in chosen("presets", shrink=10) for word in case.command]
    assert "128x72" in small
    assert "1280x720" not in small


def test_every_benchmark_has_options_that_exist():
    words = [case.command for case in chosen() if case.is_benchmark]
    read = [parsers()[0].parse_args(command[command.index("benchmark") :]) for command in words]
    assert len(read) > 20


def test_what_a_program_leaves_becomes_a_row(tmp_path):
    left = json.dumps(RESULT)
    case = python("presets", "low", f"import sys; open(sys.argv[2], 'w').write({left!r})")
    tool.run_case(case, 60.0)
    tool.write(tmp_path, [case])
    assert not case.fault
    assert json.loads((tmp_path / "report.json").read_text())[0]["result"] == RESULT
    page = (tmp_path / "report.md").read_text()
    assert "Some GPU; OpenGL 4.6; x, 8 cores; commit y" in page
    assert "| low | 2.00 | 3.00 | 500 | 1.00 | 1.50 | 1000 | 20 | all 0.750, water 0.500," in page


def test_faults_and_slow_cases_are_named():
    broken = python("paper", "broken", "print('some text'); raise SystemExit('no such GPU')")
    slow = python("paper", "slow", "import time; time.sleep(60)")
    sound = python("paper", "sound", "print('a table')")
    for case, left_s in ((broken, 60.0), (slow, 0.5), (sound, 60.0)):
        tool.run_case(case, left_s)
    page = tool.page([broken, slow, sound])
    assert "- broken: no such GPU" in page
    assert "- slow: no end in time" in page
    assert "a table" in page


def test_differences_of_pictures_are_a_table():
    (pictures,) = chosen("pictures")
    pictures.result = {
        "school": {"share": 0.0, "most": 0, "mean": 0.0},
        "dome": {"share": 0.25, "most": 9, "mean": 0.5},
    }
    page = tool.page([pictures])
    assert page.index("| dome | 25.00% | 0.50 | 9 |") < page.index("| school | 0.00% | 0.00 | 0 |")


def test_what_no_longer_fits_is_left_out(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["gpu_report", str(tmp_path), "--minutes", "0"])
    assert tool.main() == 0
    kept = json.loads((tmp_path / "report.json").read_text())
    assert {case["fault"] for case in kept} == {"no time left"}
    assert len(kept) == len(chosen())
