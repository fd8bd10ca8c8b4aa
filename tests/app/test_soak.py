"""A short soak is sound, comes again equally, and one that is spoilt is told."""

import json

import numpy as np
import pytest

from subsea import snapshot
from subsea.app import soak
from subsea.app.cli import main
from subsea.app.soak import Hands, act, faults_in, growth, hands
from subsea.behavior.reins import Reins
from subsea.ocean import create_world, step
from subsea.scenario import load_scenario
from subsea.submarine.helm import HANDS_OFF, Helm

SHORT = ["soak", "--scenario", "preying", "--minutes", "1.01"]
MINUTE = 360  # ticks: a shorter one


@pytest.fixture(scope="module", autouse=True)
def short_minutes():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(soak, "MINUTE", MINUTE)
        patch.setattr(soak, "REPLAY_EVERY", MINUTE)
        yield


@pytest.fixture
def world():
    return create_world(load_scenario("peaceful")[0], fish=20)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """What a drawn soak of little more than a minute wrote, and what it printed."""
    path = tmp_path_factory.mktemp("soak") / "soak.json"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(soak, "PICTURES", 1)  # so that there are two rounds of displays
        assert main([*SHORT, "--json", str(path)]) == 0
    return path


def test_a_soak_is_sound(report):
    seen = json.loads(report.read_text())
    assert seen["faults"] == []
    assert seen["ticks"] == round(1.01 * MINUTE)
    assert len(seen["checksums"]) == 2
    assert seen["replays"] == [MINUTE + 1]
    first, last = seen["objects"]
    assert first == last
    assert set(first) == {"Buffer", "Texture", "Renderbuffer", "Program"}


def test_the_same_soak_comes_again_without_pictures(report, capsys):
    assert main([*SHORT, "--no-draw", "--compare", str(report)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "sound"


def test_a_longer_soak_is_compared_by_the_minutes_that_both_have(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(soak, "MINUTE", 40)
    report = tmp_path / "soak.json"
    words = ["soak", "--fish", "3", "--no-draw"]
    assert main([*words, "--minutes", "1.5", "--json", str(report)]) == 0
    assert main([*words, "--minutes", "2.5", "--compare", str(report)]) == 0
    seen = json.loads(report.read_text())
    report.write_text(json.dumps(seen | {"checksums": ["other", "end"]}))
    assert main([*words, "--minutes", "2.5", "--compare", str(report)]) == 1
    told = capsys.readouterr()
    assert told.out.splitlines()[-1] == "1 fault"
    assert "minute 1: not the checksum of the older soak" in told.err


def test_another_dive_is_not_compared(report, capsys):
    assert main([*SHORT, "--no-draw", "--seed", "5", "--compare", str(report)]) == 2
    fault = capsys.readouterr().err.splitlines()[-1]
    assert f"{report}: a soak with seed" in fault
    assert fault.endswith("expected 5")


def test_an_interrupted_soak_is_told_and_written(tmp_path, monkeypatch, capsys):
    def interrupted(world, doing):
        if world.state.tick > 70:
            raise KeyboardInterrupt
        act(world, doing)

    monkeypatch.setattr(soak, "act", interrupted)
    report = tmp_path / "soak.json"
    assert main(["soak", "--fish", "3", "--no-draw", "--json", str(report)]) == 130
    assert json.loads(report.read_text())["ticks"] == 70
    assert "sound" in capsys.readouterr().out


def test_hands_do_all_that_hands_may(world):
    doing = hands(world, np.random.default_rng(3))
    seen = [next(doing) for _ in range(20_000)]
    orders = {type(one.order) for one in seen}
    assert orders == {Helm, Reins}
    assert any(one.order == HANDS_OFF for one in seen)
    assert {one.lights for one in seen} == {True, False}
    assert len({one.current_cm_s for one in seen}) > 5


def test_time_that_does_not_come_again_is_a_fault(monkeypatch, capsys):
    ran = iter(range(10**9))

    def drifting(world, doing):
        act(world, doing)
        world.state.submarine.position[2] -= 1e-4 * next(ran)

    monkeypatch.setattr(soak, "act", drifting)
    monkeypatch.setattr(soak, "REPLAY_EVERY", 150)
    assert main(["soak", "--minutes", "0.5", "--fish", "3", "--no-draw"]) == 1
    assert "the past did not come again" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("position", (0.0, 0.0, 40.0), "fish 4 is out of the sea, at 0, 0, 40"),
        ("position", (0.0, 0.0, -9000.0), "fish 4 is out of the sea"),
        ("position", (1e5, 0.0, -100.0), "fish 4 is out of the sea"),
        ("velocity", (np.nan, 0.0, 0.0), "fishes.velocity holds what is no number"),
        ("row_a", -3, "fishes.row_a[4] is -3, which no tick writes"),
    ],
)
def test_what_must_never_be_is_found(world, name, value, told):
    step(world, HANDS_OFF)
    assert faults_in(world) == []
    getattr(world.state.fishes, name)[4] = value
    found = faults_in(world)
    assert len(found) == 1
    assert told in found[0]


def test_a_submarine_out_of_the_sea_is_found(world):
    world.state.submarine.position[:] = 0.0, 0.0, 3.0
    assert faults_in(world) == ["the submarine is out of the sea, at 0, 0, 3"]


def test_hands_leave_the_world_that_a_snapshot_takes(world):
    doing = Hands(HANDS_OFF, True, (4.0, 5.0), 1.5)
    before = snapshot.checksum(world)
    act(world, doing)
    assert snapshot.checksum(world) != before
    assert world.state.submarine.lights[0]
    assert world.current_cm_s == (4.0, 5.0)
    assert world.nature.timidity == 1.5


def test_memory_that_grows_is_told():
    assert growth([]) == growth([5.0]) == 0.0
    assert growth([100.0] * 60) == 0.0
    assert growth([50.0] * 10 + [100.0] * 50) == 0.0  # while it warms up
    assert growth([100.0 + k for k in range(60)]) == pytest.approx(159 / 129 - 1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--minutes", "0"], "expected a number from 0.01"),
        (["--compare", "none.json"], "none.json: cannot read (No such file or directory)"),
        (["--compare", "bad.json"], "bad.json: expected what `subsea soak --json` writes"),
        (["--json", "."], "is a folder"),
    ],
)
def test_a_soak_that_cannot_be_is_a_fault_in_one_line(
    tmp_path, monkeypatch, capsys, options, message
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.json").write_text("[3]")
    assert main(["soak", *options]) == 2
    assert message in capsys.readouterr().err.splitlines()[-1]
