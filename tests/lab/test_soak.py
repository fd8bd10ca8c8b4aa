"""A short soak is faultless and repeatable, and every spoilt one is reported."""

import json
from contextlib import nullcontext

import numpy as np
import pytest

from subsea.base.system import resource_names
from subsea.behavior.teleop import TeleopCommand
from subsea.cli.main import main
from subsea.lab import soak
from subsea.lab.soak import Observations, RandomInput, act, growth, judge, random_input
from subsea.scenario.load import load_scenario
from subsea.stage.theatre.theatre_file import FOLDER
from subsea.submarine.vessel import NEUTRAL, Helm
from subsea.view.display_rigs import DISPLAYS, chosen_rig, display_rig
from subsea.world import snapshot
from subsea.world.build import create_world
from tests.support.scenes import BARE

SHARK = '[[fish]]\nspecies = "blacktip_reef_shark"\nnumber = 1\n'
MINUTE = 360  # ticks: a shorter one
SIZE = 96, 54


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
def short(tmp_path_factory):
    """The command of a short soak of a bare sea with a hunter."""
    path = tmp_path_factory.mktemp("sea") / "hunted.toml"
    path.write_text(BARE.read_text() + SHARK)
    return ["soak", "--scenario", str(path), "--fish", "14", "--minutes", "1.01"]


@pytest.fixture(scope="module")
def report(short, tmp_path_factory):
    """The report and output of a drawn soak of little more than a minute."""
    path = tmp_path_factory.mktemp("soak") / "soak.json"
    with pytest.MonkeyPatch.context() as patch:
        cave = chosen_rig("mono", SIZE, theatre="cave", shrink=4 * soak.SHRINK)[0]
        patch.setattr(soak, "rigs", lambda: [display_rig("mono", SIZE), cave])
        patch.setattr(soak, "PICTURES", (1, 1))  # so that there are three rounds
        patch.setattr(soak, "SECOND", 2 * soak.SECOND)  # from picture to picture
        assert main([*short, "--json", str(path)]) == 0
    return path


@pytest.mark.nightly
def test_a_soak_is_sound(report):
    seen = json.loads(report.read_text())
    assert seen["faults"] == []
    assert seen["ticks"] == round(1.01 * MINUTE)
    assert len(seen["checksums"]) == 2
    assert seen["replays"] == [MINUTE + 1]
    assert [len(seen[name]) for name in ("things", "alive", "starving", "memory_mb")] == [2] * 4
    assert seen["alive"][-1] > 10
    first, *_, last = seen["objects"]
    assert first == last
    assert set(first) == {"Buffer", "Texture", "Renderbuffer", "Program"}


def test_a_soak_repeats_equally_without_pictures(short, report, capsys):
    assert main([*short, "--no-draw", "--compare", str(report)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "sound"


@pytest.mark.nightly
def test_soaks_of_different_length_are_compared_by_common_minutes(tmp_path, capsys, monkeypatch):
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
    assert "minute 1: checksum differs from the older soak" in told.err


def test_another_dive_is_not_compared(short, report, capsys):
    assert main([*short, "--no-draw", "--seed", "5", "--compare", str(report)]) == 2
    fault = capsys.readouterr().err.splitlines()[-1]
    assert f"{report}: a soak with seed" in fault
    assert fault.endswith("expected 5")


def test_an_interrupted_soak_is_reported(tmp_path, monkeypatch, capsys):
    def interrupted(world, given):
        if world.state.tick > 70:
            raise KeyboardInterrupt
        act(world, given)

    monkeypatch.setattr(soak, "act", interrupted)
    report = tmp_path / "soak.json"
    assert main(["soak", "--fish", "3", "--no-draw", "--json", str(report)]) == 130
    assert json.loads(report.read_text())["ticks"] == 70
    assert "sound" in capsys.readouterr().out


def test_random_input_covers_all_that_a_visitor_may_do(world):
    given = random_input(world, np.random.default_rng(3))
    seen = [next(given) for _ in range(20_000)]
    orders = {type(one.order) for one in seen}
    assert orders == {Helm, TeleopCommand}
    assert any(one.order == NEUTRAL for one in seen)
    assert {one.lights for one in seen} == {True, False}
    assert len({one.current_cm_s for one in seen}) > 5


def drifting(world, given):
    act(world, given)
    drifting.ticks += 1
    world.state.submarine.position[2] -= 1e-4 * drifting.ticks


def holding(world, given):
    there = world.state.fishes.position[1].copy()
    act(world, given)
    world.state.fishes.position[1] = there


def spoiling(world, given):
    act(world, given)
    world.state.sea.heights[0, 0] = world.state.tick


@pytest.mark.parametrize(
    ("faulty", "changes", "minutes", "told"),
    [
        (drifting, {"REPLAY_EVERY": 150}, "0.5", "a rewound past repeated differently"),
        (holding, {"STILL": 120}, "0.5", "tick 121: fish 1 is stuck"),
        (spoiling, {}, "0.2", "tick 73: a constant of the world has changed"),
    ],
)
def test_broken_worlds_are_faults(monkeypatch, capsys, faulty, changes, minutes, told):
    drifting.ticks = 0
    for name, value in ({"act": faulty} | changes).items():
        monkeypatch.setattr(soak, name, value)
    assert main(["soak", "--minutes", minutes, "--fish", "3", "--no-draw"]) == 1
    assert told in capsys.readouterr().err


def test_an_empty_picture_is_a_fault(monkeypatch, capsys):
    class Blank:
        def draw(self, packet):
            pass

        def read_pixels(self, output):
            return np.full((18, 32, 3), 7, np.uint8)

    monkeypatch.setattr(soak, "headless", lambda: nullcontext())
    monkeypatch.setattr(soak, "picture_maker", lambda *made: nullcontext(Blank()))
    monkeypatch.setattr(soak, "rigs", lambda: [display_rig("mono", soak.SIZE)])
    assert main(["soak", "--minutes", "0.1", "--fish", "3"]) == 1
    assert "tick 31: an empty picture" in capsys.readouterr().err


def test_every_display_and_theatre_is_drawn():
    shown = soak.rigs()
    assert len(shown) == len(DISPLAYS) - 1 + len(resource_names(FOLDER, ".toml"))
    assert {len(rig.outputs) for rig in shown} == {1, 3}
    assert all(max(max(size) for size in rig.outputs) < 800 for rig in shown)


def test_input_changes_the_state_that_a_snapshot_takes(world):
    given = RandomInput(NEUTRAL, True, (4.0, 5.0), 1.5)
    before = snapshot.checksum(world)
    act(world, given)
    assert snapshot.checksum(world) != before
    assert world.state.submarine.lights[0]
    assert world.current_cm_s == (4.0, 5.0)
    assert world.nature.timidity == 1.5


def test_growth_compares_quarters_after_the_warm_up():
    assert growth([]) == growth([5.0]) == 0.0
    assert growth([100.0] * 60) == 0.0
    assert growth([50.0] * 10 + [100.0] * 50) == 0.0  # during the warm-up
    assert growth([100.0 + k for k in range(60)]) == pytest.approx(152 / 122 - 1)


@pytest.mark.parametrize("drawn", [False, True])
def test_growth_is_a_fault(drawn):
    steady = [500] * 60
    watch = Observations(*([] for _ in Observations._fields))
    watch.memory_mb.extend(steady)
    watch.things.extend(steady)
    watch.objects.extend([{"Buffer": 2}, {"Buffer": 2}])
    judge(watch, drawn)
    assert watch.faults == []
    watch.memory_mb[-9:] = watch.things[-9:] = [600] * 9
    watch.objects.append({"Buffer": 3})
    judge(watch, drawn)
    assert watch.faults == [
        "memory grew by 20.0%",
        "Python objects grew by 20.0%",
        "OpenGL objects not released: Buffer, [2, 2, 3]",
    ]


def test_memory_is_judged_after_the_warm_up_of_drawing():
    def faults(memory_mb, drawn):
        watch = Observations(*([] for _ in Observations._fields))._replace(memory_mb=memory_mb)
        judge(watch, drawn)
        return watch.faults

    warms_up = [float(min(400 + 25 * k, 1000)) for k in range(50)]
    assert faults(warms_up, True) == []
    assert faults(warms_up, False) == ["memory grew by 19.4%"]
    assert faults([*warms_up[:46], *[1100.0] * 4], True) == ["memory grew by 10.0%"]
    assert faults(warms_up[:20], True) == []  # too short to tell


BAD_OPTIONS = [
    (["--minutes", "0"], "expected a number from 0.01"),
    (["--compare", "none.json"], "none.json: no such file"),
    (["--compare", "bad.json"], "bad.json: expected a report of `subsea soak` ("),
    (["--json", "."], "is a folder"),
]


def test_invalid_soaks_are_one_line(tmp_path, monkeypatch, capsys):
    for options, message in BAD_OPTIONS:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "bad.json").write_text("[3]")
        assert main(["soak", *options]) == 2
        assert message in capsys.readouterr().err.splitlines()[-1]
