"""The report of a GPU: what fits the time is measured, the rest is named, nothing is lost."""

import argparse
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from subsea.cli.main import parsers
from tools import gpu_report as tool

PICTURES = {
    "school": {"share": 0.0, "most": 0, "mean": 0.0},
    "dome": {"share": 0.25, "most": 9, "mean": 0.5},
}
RESULT = {
    "renderer": "Some GPU", "machine": {"driver": "4.6", "cpu": "x", "cores": 8, "commit": "y"},
    "frame_ms": {"p50": 2.0, "p95": 3.0}, "fps": 500.0, "host_ms": 1.0,
    "cpu_ms": {"thread": 1.5}, "gpu_ms": {"all": 0.75, "water": 0.5, "fishes": 0.25},
    "triangles_mean": 1000.0, "draw_calls": 20,
}  # fmt: skip
LEFT = json.dumps(RESULT)


def chosen(*only, shrink=1):
    return tool.cases(argparse.Namespace(frames=2, shrink=shrink, only=only or tool.GROUPS))


def python(name, program, **settings):
    """A case that is a program of its own."""
    return tool.Case("paper", name, [sys.executable, "-c", program], "text", **settings)


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
    words = [case.command for case in chosen() if case.kind == "benchmark"]
    read = [parsers()[0].parse_args(command[command.index("benchmark") :]) for command in words]
    assert len(read) > 20


def test_what_a_program_leaves_becomes_a_row(tmp_path):
    case = chosen("presets")[0]
    case.command = [sys.executable, "-c", f"import sys; open(sys.argv[2], 'w').write({LEFT!r})"]
    assert tool.measure([case], 1.0, lambda: tool.write(tmp_path, [case], 1.0), lambda text: None)
    assert (case.state, case.reason) == ("done", "")
    assert json.loads((tmp_path / "report.json").read_text())["cases"][0]["result"] == RESULT
    assert "| low, 1280x720 | 2.00 |" in (tmp_path / "report.md").read_text()


@pytest.mark.nightly
def test_a_benchmark_becomes_a_row(tmp_path):
    case = chosen("presets", shrink=10)[0]
    case.command += ["--scenario", "tests/support/bare_sea.toml"]
    case.most_s = 300.0
    assert tool.measure([case], 6.0, lambda: tool.write(tmp_path, [case], 6.0), lambda text: None)
    assert (case.state, case.reason) == ("done", "")
    kept = json.loads((tmp_path / "report.json").read_text())["cases"][0]
    assert kept["result"]["size"] == [128, 72]
    row = f"| low, 1280x720 | {kept['result']['frame_ms']['p50']:.2f} |"
    assert row in (tmp_path / "report.md").read_text()


def test_faults_and_slow_cases_are_named_and_the_others_go_on():
    found = [
        python("broken", "print('some text'); raise SystemExit('no such GPU')"),
        python("slow", "import time; print('begun', flush=True); time.sleep(60)", most_s=1.0),
        python("sound", "print('a table')"),
    ]
    assert tool.measure(found, 1.0, lambda: None, lambda text: None)
    assert [case.state for case in found] == ["failed", "stopped", "done"]
    assert found[0].reason == "no such GPU"
    page = tool.page(found)
    assert "- broken: failed, no such GPU" in page
    assert "- slow: stopped, no end after" in page
    assert "a table" in page


def test_what_no_longer_fits_is_left_out():
    found = [python("first", "pass")]
    assert tool.measure(found, 0.5 * tool.LEAST_S / 60.0, lambda: None, lambda text: None)
    assert (found[0].state, found[0].reason) == ("left out", "no time left")


def test_stages_of_the_gpu_and_pictures_are_tables():
    (case, *_) = chosen("presets")
    case.result = RESULT
    (pictures,) = chosen("pictures")
    pictures.result = PICTURES
    page = tool.page([case, pictures])
    assert "Some GPU; OpenGL 4.6; x, 8 cores; commit y" in page
    assert "| GPU, ms | water | fishes |" in page
    assert "| low, 1280x720 | 0.500 | 0.250 |" in page
    assert page.index("| dome | 25.00% | 0.50 | 9 |") < page.index("| school | 0.00% | 0.00 | 0 |")


def test_ctrl_c_keeps_what_is_measured(tmp_path):
    program = """
import sys
import pytest

from subsea.cli.main import parsers
from tools import gpu_report as tool
def own(program): return tool.Case("paper", program, [sys.executable, "-c", program], "text")
tool.cases = lambda options: [own("print(7)"), own("import time; time.sleep(60)"), own("print(9)")]
sys.exit(tool.main())
"""
    folder = tmp_path / "report"
    command = [sys.executable, "-c", program, str(folder)]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True)
    for line in running.stdout:
        if line.startswith(b"2 of 3"):
            break
    time.sleep(0.5)
    os.killpg(running.pid, signal.SIGINT)  # as a terminal does
    assert running.wait(30) == 130
    running.stdout.close()
    kept = json.loads((folder / "report.json").read_text())["cases"]
    assert [case["state"] for case in kept] == ["done", "stopped", "left out"]
    assert kept[0]["result"] == "7\n"
    assert {case["reason"] for case in kept[1:]} == {"interrupted"}


@pytest.mark.nightly
def test_the_differences_of_stored_pictures_are_listed(tmp_path):
    (case,) = chosen("pictures")
    case.command += ["-k", "test_a_school_over_the_sand"]
    tool.run_case(case, 300.0)
    assert case.state == "done", case.reason
    assert [*case.result] == ["school"]
    assert 0.0 <= case.result["school"]["share"] <= 0.005
