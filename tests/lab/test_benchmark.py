"""The report has the agreed keys, and its figures agree with each other."""

import csv
import gc
import json
import os
import re
import time
from importlib.metadata import version

import numpy as np
import pytest
from PIL import Image

from subsea.base.arrays import summarize_ms
from subsea.cli.main import main
from subsea.lab import benchmark, benchmark_reports
from subsea.lab.benchmark_reports import STAGES, bound_by
from subsea.rendering.gl.context import GPU_STAGES
from subsea.rendering.renderer import Renderer
from subsea.world import step as ocean
from tests.support.scenes import BARE

pytestmark = pytest.mark.usefixtures("one_context")

SEA = ["--scenario", str(BARE), "--size", "160x120"]
SMALL = ["benchmark", *SEA, "--frames", "5", "--fish", "20"]


@pytest.fixture(scope="module", autouse=True)
def short_warm_up():
    """Measure soon: what is tested does not depend on figures that have settled."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(benchmark, "WARM_UP_FRAMES", 3)
        patch.setattr(benchmark, "LIVE_WARM_UP_TICKS", 150)
        yield


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports")
    options = {"with": [], "without": ["--without", "culling,lod"], "live": ["--motor", "dynamics"]}
    for name, more in options.items():
        assert main([*SMALL, "--json", str(folder / f"{name}.json"), *more]) == 0
    return {name: json.loads((folder / f"{name}.json").read_text()) for name in options}


def test_the_report_has_the_agreed_keys(reports):
    report = reports["with"]
    assert set(report) == {
        "renderer", "size", "display", "scenario", "fish", "visible_mean", "frames", "seed",
        "version", "without", "motor", "simulated_mean", "frame_ms", "fps", "stages_ms", "lod",
        "triangles_mean", "quality", "quality_drawn", "target_ms", "host_ms", "draw_calls",
        "theatre", "set", "tour", "parts_ms", "machine", "cpu_ms", "yardstick_ms",
        "rest_ms", "gpu_ms",
    }  # fmt: skip
    assert set(report["frame_ms"]) == {"mean", "p50", "p95", "p99", "max"}
    assert tuple(report["stages_ms"]) == STAGES
    assert report["size"] == [160, 120]
    assert (report["fish"], report["frames"]) == (20, 5)


def test_its_figures_agree(reports):
    for report in reports.values():
        frame = report["frame_ms"]
        assert frame["p50"] <= frame["p95"] <= frame["p99"] <= frame["max"]
        assert report["fps"] == pytest.approx(1000.0 / frame["mean"])
        assert sum(report["lod"].values()) == pytest.approx(report["visible_mean"])
        assert sum(report["stages_ms"].values()) < 1.5 * frame["max"]
        assert 0.0 < report["host_ms"] < frame["p50"]
        assert 0.0 < report["rest_ms"] < frame["p50"]
        assert report["draw_calls"] >= 5
        assert 0.0 < report["cpu_ms"]["thread"] <= 1.01 * report["cpu_ms"]["all"]
        assert report["cpu_ms"]["thread"] < 1.5 * frame["max"]
        assert (report["quality"], report["quality_drawn"]) == ("low", "low")
        assert report["target_ms"] is None


def test_on_a_gpu_its_stages_are_timed(tmp_path, monkeypatch, capsys, reports):
    assert reports["with"]["gpu_ms"] is None  # a software renderer
    monkeypatch.setattr(benchmark, "on_software", lambda renderer: False)
    assert main([*SMALL, "--json", str(tmp_path / "gpu.json")]) == 0
    report = json.loads((tmp_path / "gpu.json").read_text())
    assert tuple(report["gpu_ms"]) == ("all", *GPU_STAGES)
    assert report["gpu_ms"]["water"] > 0.0
    printed = capsys.readouterr().out
    assert f"bound by the {bound_by(report)}" in printed
    slow = report | {"gpu_ms": {"all": 9.0}, "cpu_ms": {"thread": 5.0}}
    assert bound_by(slow) == "GPU"
    assert bound_by(slow | {"cpu_ms": {"thread": 10.0}}) == "host"
    assert bound_by(slow | {"gpu_ms": None}) is None


def test_frames_as_in_a_dive_are_neither_awaited_nor_read_back(tmp_path, monkeypatch):
    monkeypatch.setattr(benchmark, "on_software", lambda renderer: False)
    read = []
    monkeypatch.setattr(Renderer, "read_pixels", lambda *given: read.append(given))
    assert main([*SMALL, "--without", "sync", "--json", str(tmp_path / "dive.json")]) == 0
    report = json.loads((tmp_path / "dive.json").read_text())
    assert read == []
    assert tuple(report["gpu_ms"]) == ("all", "picture")
    assert report["gpu_ms"]["picture"] > 0.0
    assert report["without"] == ["sync"]
    assert sum(report["stages_ms"].values()) < 1.5 * report["frame_ms"]["max"]


def test_the_report_describes_the_machine(reports, capsys):
    told = reports["with"]["machine"]
    assert set(told) == {
        "cpu", "cores", "load", "system", "driver", "python", "packages", "commit",
    }  # fmt: skip
    assert told["cores"] == len(os.sched_getaffinity(0))
    assert told["packages"]["numba"] == version("numba")
    line = benchmark_reports.machine_line(told)
    assert told["cpu"] in line
    assert told["driver"] in line
    assert "commit" not in benchmark_reports.machine_line(told | {"commit": None})


def test_without_culling_and_levels_all_fishes_are_drawn_in_full(reports):
    full = reports["without"]
    assert full["visible_mean"] == 20.0
    assert full["lod"]["tessellated"] == 20.0
    assert full["triangles_mean"] > reports["with"]["triangles_mean"]


def test_with_dynamics_fishes_that_swim_by_their_tails_are_simulated(reports):
    assert (reports["with"]["motor"], reports["live"]["motor"]) == ("playback", "dynamics")
    assert reports["with"]["simulated_mean"] == 0.0
    assert 1.0 <= reports["live"]["simulated_mean"] <= 20.0
    assert reports["live"]["stages_ms"]["motor"] > 1.2 * reports["with"]["stages_ms"]["motor"]


def test_automatic_quality_holds_its_target(tmp_path):
    report = tmp_path / "auto.json"
    options = ["--quality", "auto", "--target-ms", "1", "--json", str(report)]
    assert main([*SMALL, "--frames", "30", *options]) == 0
    figures = json.loads(report.read_text())
    assert (figures["quality"], figures["target_ms"]) == ("auto", 1.0)
    assert re.fullmatch(r"low at [59]\d%", figures["quality_drawn"])


@pytest.fixture(scope="module")
def ladder(tmp_path_factory):
    """A folder with the report, the table and the picture of two runs on a tour."""
    folder = tmp_path_factory.mktemp("ladder")
    options = [*SEA, "--frames", "12", "--fish", "5,20", "--tour", "glide"]
    files = ["--json", "old.json", "--csv", "frames.csv", "--plot", "stages.png"]
    files = [str(folder / word) if "." in word else word for word in files]
    assert main(["benchmark", *options, *files]) == 0
    return folder


def table(path):
    """The rows of a CSV file, each a dictionary."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_several_numbers_of_fishes_are_measured(ladder):
    runs = json.loads((ladder / "old.json").read_text())["ladder"]
    assert [run["fish"] for run in runs] == [5, 20]
    assert {run["tour"] for run in runs} == {"glide"}
    for run in runs:
        assert len(run["parts_ms"]["frame"]) == 10
        assert min(run["parts_ms"]["frame"]) <= run["frame_ms"]["p50"] <= run["frame_ms"]["max"]


def test_every_frame_is_a_row_of_the_table(ladder):
    rows = table(ladder / "frames.csv")
    assert [(row["fish"], row["frame"]) for row in rows] == [
        (str(fish), str(k)) for fish in (5, 20) for k in range(12)
    ]
    runs = json.loads((ladder / "old.json").read_text())["ladder"]
    for run, mine in zip(runs, (rows[:12], rows[12:]), strict=True):
        times = [float(row["frame_ms"]) for row in mine]
        assert max(times) == pytest.approx(run["frame_ms"]["max"], abs=1e-3)
        assert float(np.mean([int(row["visible"]) for row in mine])) == run["visible_mean"]
        assert max(int(row["draw_calls"]) for row in mine) == run["draw_calls"]
        for row in mine:
            stages = sum(float(row[f"{name}_ms"]) for name in STAGES)
            assert float(row["rest_ms"]) >= 0.0
            assert stages + float(row["rest_ms"]) == pytest.approx(float(row["frame_ms"]), abs=1e-3)


def test_the_picture_shows_a_chart_for_each_run(ladder):
    with Image.open(ladder / "stages.png") as picture:
        assert picture.format == "PNG"
        assert picture.size == (900, 580)
        assert len(np.unique(np.asarray(picture.convert("L")))) > 10


@pytest.fixture(scope="module")
def again(ladder):
    """The rows of a repeat of the ladder's second run, with all times in processor time.

    Other programs may add any wall time to a single frame, in a stage or between two.
    """
    path = ladder / "again.csv"
    options = [*SEA, "--frames", "12", "--fish", "20", "--tour", "glide"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time, "perf_counter", time.process_time)
        gc.disable()  # objects of all earlier tests
        try:
            assert main(["benchmark", *options, "--csv", str(path)]) == 0
        finally:
            gc.enable()
    return table(path)


def test_on_a_tour_every_run_sees_the_same(ladder, again):
    rows = table(ladder / "frames.csv")
    shown = [[(row["visible"], row["triangles"]) for row in run] for run in (rows[12:], again)]
    assert shown[0] == shown[1]


def test_stages_cover_most_of_a_frame(again):
    for row in again:
        assert 0.0 <= float(row["rest_ms"]) < 0.3 * float(row["frame_ms"])


def test_a_report_is_compared_with_an_older_one(ladder, tmp_path, capsys):
    old = json.loads((ladder / "old.json").read_text())["ladder"][1]
    for table in (old["frame_ms"], old["stages_ms"]):
        for name in table:
            table[name] *= 1000.0
    for name in ("frame", *STAGES):
        old["parts_ms"][name] = [1000.0 * value for value in old["parts_ms"][name]]
    slow = tmp_path / "slow.json"
    slow.write_text(json.dumps(old))
    options = [*SEA, "--frames", "12", "--fish", "20"]
    assert main(["benchmark", *options, "--compare", str(slow)]) == 0
    told = capsys.readouterr().out
    assert "different: tour\n" in told
    name, then, now, ratio, low, to, high, told = re.search(r"^frame .*", told, re.M)[0].split()
    assert (name, to, told) == ("frame", "to", "faster")
    assert float(then) == pytest.approx(old["frame_ms"]["p50"], abs=1e-3)
    assert float(ratio) == pytest.approx(float(then) / float(now), rel=0.01)
    assert 100.0 < float(low) < float(high)


def compared(reports, older, path, capsys):
    """The verdict of each row of a comparison: its last word."""
    path.write_text(json.dumps(older))
    benchmark_reports.compare(reports, benchmark_reports.read_reports(path), path)
    rows = capsys.readouterr().out.partition("in most parts\n")[2].splitlines()
    return {row.split()[0]: row.split()[-1] for row in rows}


def test_the_yardstick_removes_the_effect_of_a_busy_machine(reports, tmp_path, capsys):
    now, path = reports["with"], tmp_path / "old.json"
    same = compared([now], now, path, capsys)
    assert {same[name] for name in ("frame", "cpu", *STAGES)} == {"difference"}
    slow = json.loads(json.dumps(now))
    for name in ("frame", "motor", "cpu"):
        slow["parts_ms"][name] = [2.0 * value for value in slow["parts_ms"][name]]
    told = compared([now], slow, path, capsys)
    assert (told["frame"], told["motor"], told["pose"]) == ("faster", "faster", "difference")
    assert compared([slow], now, path, capsys)["motor"] == "slower"
    slow["parts_ms"]["yardstick"] = [2.1 * value for value in slow["parts_ms"]["yardstick"]]
    told = compared([now], slow, path, capsys)
    assert (told["frame"], told["motor"]) == ("difference", "difference")
    assert told["cpu"] == "faster"  # processor time needs no yardstick


def test_reports_without_a_yardstick_are_compared(reports, tmp_path, capsys):
    old = json.loads(json.dumps(reports["with"]))
    for name in ("machine", "cpu_ms", "yardstick_ms", "parts_ms"):
        del old[name]
    rows = compared([reports["with"]], old, tmp_path / "old.json", capsys)
    assert {"frame", *STAGES} == set(rows)
    assert set(rows.values()) == {"-"}


def test_the_spread_of_ratios():
    assert benchmark_reports.spread([4.0] * 10, [2.0] * 10) == (2.0, 2.0)
    low, high = benchmark_reports.spread([1.0, 2.0, 3.0], [1.0, 1.0, 1.0])
    assert 1.0 < low < 2.0 < high < 3.0
    assert benchmark_reports.spread([1.0] * 9, [1.0] * 10) is None
    assert benchmark_reports.spread([1.0], [1.0]) is None
    assert benchmark_reports.spread([1.0, 1.0], [0.0, 1.0]) is None


def test_an_interrupted_benchmark_writes_nothing(tmp_path, monkeypatch, capsys):
    steps = []

    def step(*arguments):
        steps.append(arguments)
        if len(steps) > benchmark.WARM_UP_FRAMES + 3:
            raise KeyboardInterrupt
        ocean.step(*arguments)

    monkeypatch.setattr(benchmark, "step", step)
    files = ["--json", str(tmp_path / "a.json"), "--csv", str(tmp_path / "a.csv")]
    assert main([*SMALL, *files]) == 130
    assert capsys.readouterr().err.splitlines()[-1] == "subsea: interrupted"
    assert not list(tmp_path.iterdir())


def test_an_invalid_report_is_one_line(tmp_path, capsys):
    path = tmp_path / "old.json"
    for content in ("", "{", "[]", "{}", '{"ladder": 3}', '{"ladder": []}', '{"fish": "many"}',
                    "\x00\xff"):  # fmt: skip
        path.write_text(content)
        assert main([*SMALL, "--compare", str(path)]) == 2
        (fault,) = capsys.readouterr().err.splitlines()
        assert "old.json: expected a report of `subsea benchmark` (" in fault


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("benchmark --motor steam", "--motor 'steam': unknown choice"),
        ("benchmark --motor dynamics --fish 4001", "at most 4000"),
        ("benchmark --quality medum", "unknown quality 'medum'; did you mean 'medium'?"),
        ("benchmark --target-ms 20", "needs --quality auto, not low"),
        ("benchmark --compare none.json", "none.json: no such file"),
        ("benchmark --tour reaf", "unknown tour 'reaf'; did you mean 'reef'?"),
        ("benchmark --fish 5,5", "'5,5': expected every number once"),
        ("benchmark --fish 5,0", "'0': expected a whole number from 1 to 100000"),
        ("benchmark --csv .", "is a folder"),
        ("benchmark --plot .", "is a folder"),
        ("benchmark --json a --csv ./a", "a: two results cannot go into one file"),
        ("dive --quality best", "there are: auto, low, medium, high, ultra"),
        ("dive --target-ms 0", "'0': expected a number from 1 to 1000"),
        ("dive --quality low --target-ms 20", "--target-ms needs --quality auto, not low"),
        ("film x.png --quality auto", "--quality low, medium, high or ultra"),
    ],
)
def test_invalid_options_are_one_line(tmp_path, monkeypatch, capsys, command, message):
    monkeypatch.chdir(tmp_path)
    assert main(command.split()) == 2
    assert message in capsys.readouterr().err.splitlines()[-1]
    assert not list(tmp_path.iterdir())


def test_the_summary_of_known_durations():
    figures = summarize_ms([0.001 * k for k in range(1, 102)])
    expected = {"mean": 51.0, "p50": 51.0, "p95": 96.0, "p99": 100.0, "max": 101.0}
    assert figures == pytest.approx(expected)
