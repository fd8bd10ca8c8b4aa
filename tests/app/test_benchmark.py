"""The report has the agreed keys, and its figures agree with each other."""

import json
import re

import pytest

from subsea.app import timing
from subsea.app.benchmark import STAGES
from subsea.app.cli import main

SMALL = ["benchmark", "--frames", "5", "--size", "160x120", "--fish", "20"]


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reports")
    options = {
        "with": [],
        "without": ["--without", "culling,lod"],
        "live": ["--motor", "dynamics"],
    }
    for name, more in options.items():
        assert main([*SMALL, "--json", str(folder / f"{name}.json"), *more]) == 0
    return {name: json.loads((folder / f"{name}.json").read_text()) for name in options}


def test_the_report_has_the_agreed_keys(reports):
    report = reports["with"]
    assert set(report) == {
        "renderer", "size", "display", "scenario", "fish", "visible_mean", "frames", "seed",
        "version", "without", "motor", "simulated_mean", "frame_ms", "fps", "stages_ms", "lod",
        "triangles_mean", "quality", "quality_drawn", "target_ms", "host_ms", "draw_calls",
        "theatre", "set",
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
        assert report["draw_calls"] >= 5
        assert (report["quality"], report["quality_drawn"]) == ("low", "low")
        assert report["target_ms"] is None


def test_without_culling_and_levels_all_fishes_are_drawn_in_full(reports):
    full = reports["without"]
    assert full["visible_mean"] == 20.0
    assert full["lod"]["tessellated"] == 20.0
    assert full["triangles_mean"] > reports["with"]["triangles_mean"]


def test_with_dynamics_every_fish_is_simulated(reports):
    assert (reports["with"]["motor"], reports["live"]["motor"]) == ("playback", "dynamics")
    assert reports["with"]["simulated_mean"] == 0.0
    assert reports["live"]["simulated_mean"] == 20.0
    assert reports["live"]["stages_ms"]["motor"] > 3 * reports["with"]["stages_ms"]["motor"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--motor", "steam"], "unknown motor 'steam'"),
        (["--motor", "dynamics", "--fish", "4001"], "at most 4000"),
    ],
)
def test_a_motor_that_cannot_be_is_a_fault_in_one_line(capsys, options, message):
    assert main(["benchmark", *options]) == 2
    fault = capsys.readouterr().err.splitlines()[-1]
    assert message in fault


def test_auto_climbs_down_to_hold_its_target(tmp_path):
    report = tmp_path / "auto.json"
    options = ["--quality", "auto", "--target-ms", "1", "--json", str(report)]
    assert main([*SMALL, "--frames", "30", *options]) == 0
    figures = json.loads(report.read_text())
    assert (figures["quality"], figures["target_ms"]) == ("auto", 1.0)
    assert re.fullmatch(r"low at [59]\d%", figures["quality_drawn"])


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["benchmark", "--quality", "medum"], "unknown quality 'medum'; did you mean 'medium'?"),
        (["dive", "--quality", "best"], "there are: auto, low, medium, high"),
        (["dive", "--target-ms", "0"], "'0': expected a number from 1.0 to 1000.0"),
        (["dive", "--quality", "low", "--target-ms", "20"], "what --quality auto holds"),
        (["benchmark", "--target-ms", "20"], "what --quality auto holds, and this is low"),
        (["film", "x.png", "--quality", "auto"], "--quality low, medium or high"),
    ],
)
def test_a_quality_that_cannot_be_is_a_fault_in_one_line(capsys, command, message):
    assert main(command) == 2
    fault = capsys.readouterr().err.splitlines()
    assert len(fault) == 1
    assert message in fault[0]


def test_the_summary_of_known_durations():
    figures = timing.summary([0.001 * k for k in range(1, 102)])
    expected = {"mean": 51.0, "p50": 51.0, "p95": 96.0, "p99": 100.0, "max": 101.0}
    assert figures == pytest.approx(expected)
