import re
import sys
from errno import ENOSPC
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import pytest

from capture.cli.main import main
from capture.learning import improve
from capture.learning import swim as learn_swim
from capture.learning.fitness import (
    GAIT_LIMITS,
    excess,
    measure_gait,
    missed,
    swim_faults,
    swim_loss,
)
from capture.learning.improve import write_plans
from capture.learning.learn import LearnedControllers, learn
from capture.learning.search import (
    METHODS,
    MIN_DISTANCE,
    Evaluation,
    distinct,
    one_by_one,
    search,
)
from capture.learning.swim import swim_at, swim_point
from capture.learning.turn import refit_holds, turn_at, turn_point, with_holds
from subsea.base.errors import UserError
from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import build_body
from subsea.biomechanics.controllers import S_MAX
from subsea.biomechanics.fins import contraction_step
from subsea.biomechanics.trial import beat_contraction, steady_beat
from subsea.fish.species import Species
from tests.support.commands import refusal

# A fish in Tu's water, whose speed is set by the amplitude of its beat.
SHIPPED = Path(__file__).parents[3] / "docs" / "tu_fusilier.toml"
NUMBERS = re.compile(
    rb"^(ticks_per_beat|contraction|lag|slow|medium|gradual|amplitude|\w+_ticks) = "
)


def detuned(path):
    """A fusilier that beats too weakly and nearly without a lag, with remarks of its owner."""
    text = SHIPPED.read_text(encoding="utf-8")
    assert text.count("contraction = [0.444, 0.527]") == 1
    text = text.replace("contraction = [0.444, 0.527]", "contraction = [0.36, 0.4]")
    text = re.sub(r"\nlag = [\d.]+ ", "\nlag = 0.9 ", text)
    text = text.replace("[turn]\n", "# Größe: mine\n[turn]   # turns\n\n")
    path.write_text(text, encoding="utf-8")
    return path


class Lesson(NamedTuple):
    before: bytes
    path: Path
    out: str
    code: int


@pytest.fixture(scope="module")
def lesson(tmp_path_factory):
    """Results of the command for a detuned fish, run once."""
    path = detuned(tmp_path_factory.mktemp("learn") / "mine.toml")
    before = path.read_bytes()
    with pytest.MonkeyPatch.context() as patch:
        lines: list[str] = []
        patch.setattr("builtins.print", lambda *words, **rest: lines.append(" ".join(words)))
        code = main(["learn", str(path), "--only", "swim", "--budget", "30", "--ticks", "14"])
    return Lesson(before, path, "\n".join(lines), code)


@pytest.mark.nightly
def test_a_detuned_fish_learns_to_swim_faster(lesson):
    assert lesson.code == 0
    old, new = load_detuned(lesson), load_toml(lesson.path, Species)
    before, after = (steady_gait(fish) for fish in (old, new))
    assert after.speed > 1.1 * before.speed
    assert not missed(after, GAIT_LIMITS)
    assert "fast swim, L/tu" in lesson.out
    assert "verified: 12 disturbed swims of 150 beats" in lesson.out
    assert f"{after.speed:.4f}" in lesson.out
    assert not swim_faults(build_body(new.body), new.swim, 99)


def steady_gait(fish):
    body = build_body(fish.body)
    steady = steady_beat(body, beat_contraction(fish.swim, 1.0)).state
    return measure_gait(body, fish.swim, 1.0, steady)


def load_detuned(lesson):
    path = lesson.path.with_name("old.toml")
    path.write_bytes(lesson.before)
    return load_toml(path, Species)


@pytest.mark.nightly
def test_only_the_numbers_of_the_controllers_change(lesson):
    old, new = (text.splitlines(True) for text in (lesson.before, lesson.path.read_bytes()))
    assert len(old) == len(new)
    changed = [(a, b) for a, b in zip(old, new, strict=True) if a != b]
    assert len(changed) > 5
    for a, b in changed:
        assert NUMBERS.match(a)
        assert a.partition(b" = ")[0] == b.partition(b" = ")[0]
        assert a.partition(b"#")[1:] == b.partition(b"#")[1:]


@pytest.mark.nightly
def test_nothing_better_is_one_line_and_code_1(tmp_path, capsys):
    path = tmp_path / "fish.toml"
    path.write_bytes(SHIPPED.read_bytes())
    inode = path.stat().st_ino
    # The only evaluation is that of the old controller itself.
    assert main(["learn", str(path), "--only", "swim", "--budget", "1"]) == 1
    out = capsys.readouterr().out
    assert out.count("\n") == 1 and "nothing better found in 1 tries" in out
    assert path.read_bytes() == SHIPPED.read_bytes() and path.stat().st_ino == inode


@pytest.mark.nightly
def test_rejected_winners_are_reported_in_one_line_and_change_nothing(
    monkeypatch, tmp_path, capsys
):
    path = detuned(tmp_path / "fish.toml")
    before = path.read_bytes()
    monkeypatch.setattr(learn_swim, "gait_faults", lambda *fish: ["it circles"])
    assert main(["learn", str(path), "--only", "swim", "--budget", "20", "--ticks", "14"]) == 1
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    assert re.search(r"in 20 tries, \d+ rejected, the best as it circles; ", out)
    assert path.read_bytes() == before


def test_a_gait_in_which_no_turn_can_begin_is_a_reason_not_a_crash(monkeypatch, tmp_path, capsys):
    path = tmp_path / "fish.toml"
    path.write_bytes(SHIPPED.read_bytes())

    def unsteady(body, beat):
        raise UserError("the body does not swim steadily after 1000 beats")

    monkeypatch.setattr("capture.learning.turn.steady_beat", unsteady)
    assert main(["learn", str(path), "--only", "turn", "--budget", "5"]) == 1
    out = capsys.readouterr().out
    assert "1 rejected, the best as the body does not swim steadily after 1000 beats; " in out
    notes = []
    muscles = load_toml(path, Species).muscles
    assert refit_holds(build_body(muscles.body), muscles.swim, muscles.turn, 1, notes) is None
    assert notes == ["turn: rejected: the body does not swim steadily after 1000 beats"]


def test_all_kinds_of_faults_of_candidates_are_told():
    notes = ["swim: the old controller is faulty: snout is 6", "swim: rejected: tail is 0.1"]
    notes += ["swim: rejected: tail is 0.12", *3 * ["turn: rejected: it circles"]]
    faults = improve.faults_of(notes)
    assert faults == ["tail is 0.1", "tail is 0.12", *3 * ["it circles"]]
    assert improve.other_faults(faults, faults[0]) == ", others as it circles (3)"
    assert improve.other_faults(faults[:2], faults[0]) == ""


def test_a_full_disk_leaves_the_old_file(monkeypatch, tmp_path, capsys):
    path = detuned(tmp_path / "fish.toml")
    before = path.read_bytes()
    fish = load_toml(path, Species)
    assert fish.swim
    new = msgspec.structs.replace(fish.swim, lag=1.0)
    monkeypatch.setattr(
        improve, "learn", lambda *given, **options: LearnedControllers(new, None, [])
    )

    def full(file, data):
        file.open("wb").close()
        raise OSError(ENOSPC, "No space left on device")

    monkeypatch.setattr(improve, "complaints", lambda motion: ["It swims slowly."])
    monkeypatch.setattr(improve, "try_motion", lambda muscles: None)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        patch.setattr(improve, "_values", lambda muscles: {})  # a dry run has them
        assert main(["learn", str(path)]) == 75
    assert "No space left" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
    # A dry run shows what it found and writes nothing.
    assert main(["learn", str(path), "--dry-run"]) == 0
    told = capsys.readouterr().out
    assert "lag 1" in told and "warning: It swims slowly." in told
    assert path.read_bytes() == before
    monkeypatch.setattr(improve, "_values", lambda muscles: {})
    # With room, and elsewhere, it is written.
    assert main(["learn", str(path), "--out", str(tmp_path / "new" / "fish.toml")]) == 0
    assert load_toml(tmp_path / "new" / "fish.toml", Species).swim == new
    assert path.read_bytes() == before


def test_the_same_numbers_give_the_same_bytes(species, name, tmp_path):
    source = resource_path(f"assets/species/{name}.toml")
    assert species.swim
    assert species.turn
    write_plans(source, tmp_path / "same.toml", swim=species.swim, turn=species.turn)
    assert (tmp_path / "same.toml").read_bytes() == source.read_bytes()


@pytest.mark.nightly
@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_finds_the_same(method):
    fish = load_toml(SHIPPED, Species)
    runs: list[list[Any]] = []
    for _ in range(2):
        told: list[Any] = []
        found = learn(
            fish.muscles,
            method=method,
            budget=4,
            only="turn",
            progress=lambda *step, told=told: told.append(step),
        )
        runs.append([*told, found])
    assert len(runs[0]) == 5
    assert runs[0] == runs[1]
    assert runs[0][-1].swim is None


@pytest.mark.parametrize("method", METHODS)
def test_both_methods_approach_the_least_of_a_bowl(method):
    aim = np.array([0.3, 0.7, 0.5])
    told: list[object] = []
    tried = search(
        one_by_one(lambda point: float(((point - aim) ** 2).sum())),
        np.full(3, 0.95),
        method,
        150,
        5,
        told.append,
    )
    assert len(tried) == len(told) == 150
    assert tried == sorted(tried)
    assert tried[0].loss < 0.01
    assert np.all((np.array([one.point for one in tried]) >= 0) & (np.array(tried[0].point) <= 1))


def test_similar_candidates_are_skipped():
    near, far = (0.5, 0.5 + MIN_DISTANCE / 2), (0.5, 0.5 + 2 * MIN_DISTANCE)
    tried = [Evaluation(3.0, far), Evaluation(2.0, near), Evaluation(1.0, (0.5, 0.5))]
    assert [one.loss for one in distinct(tried)] == [1.0, 3.0]


def test_a_search_leaves_the_random_numbers_of_others_alone():
    np.random.seed(3)  # noqa: NPY002
    expected = np.random.random(4)  # noqa: NPY002
    np.random.seed(3)  # noqa: NPY002
    search(one_by_one(lambda point: float(point.sum())), np.full(2, 0.5), "cma", 20, 1)
    np.testing.assert_array_equal(np.random.random(4), expected)  # noqa: NPY002


@pytest.mark.nightly
def test_a_winner_that_fails_verification_gives_way_to_the_next(monkeypatch, tmp_path):
    fish = load_toml(detuned(tmp_path / "fish.toml"), Species)
    verified, turned = [], []

    def faults(body, swim, seed):
        verified.append(swim)
        return ["it circles"] if len(verified) <= 3 else []

    def refitted(body, swim, turn, *rest):
        turned.append(swim)
        return turn if len(turned) == 2 else None

    monkeypatch.setattr(learn_swim, "gait_faults", lambda body, swim: [])
    monkeypatch.setattr(learn_swim, "swim_faults", faults)
    monkeypatch.setattr("capture.learning.learn.refit_holds", refitted)
    found = learn(fish.muscles, only="swim", budget=12, ticks=14)
    # The old controller, two winners that circle, one that cannot turn, and the next.
    assert len(verified) == 5
    assert turned == verified[-2:]
    assert (found.swim, found.turn) == (verified[-1], fish.turn)
    assert sum("rejected: it circles" in note for note in found.notes) == 2
    assert sum("rejected: it cannot turn" in note for note in found.notes) == 1


def test_interrupted_learning_reports_the_best_and_leaves_the_file(monkeypatch, tmp_path, capsys):
    path = detuned(tmp_path / "fish.toml")
    before = path.read_bytes()
    calls = []

    def loss(*arguments):
        calls.append(arguments)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return 1.0 / len(calls)

    monkeypatch.setattr(learn_swim, "swim_loss", loss)
    assert main(["learn", str(path), "--budget", "20"]) == 130
    assert len(calls) == 4
    err = capsys.readouterr().err.splitlines()[-1]
    assert "best swim so far, not verified: SwimPlan(" in err
    assert "is unchanged" in err
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_errors_are_reported_before_the_search(monkeypatch, capsys):
    monkeypatch.setattr(improve, "learn", lambda *a, **b: pytest.fail("searched before"))

    def fails(arguments, expected):
        assert expected in refusal(main, ["learn", *arguments], capsys)

    fails([], "SPECIES")
    fails(["fusiler"], "did you mean 'fusilier'?")
    fails(["no/such.toml"], "no/such.toml: no such file")
    fails(["ribbon_eel"], "ribbon_eel.toml: driven by its spine")
    fails(["fusilier", "--method", "guessing"], "guessing")
    fails(["fusilier", "--budget", "0"], "whole number from 1")
    fails(["fusilier", "--only", "glide"], "glide")
    fails(["fusilier", "--out", "/etc/passwd/new.toml"], "/etc/passwd")
    fails(["fusilier", "--out", "/"], "is a folder")
    fails(["fusilier", "--sead", "3"], "did you mean '--seed'?")
    monkeypatch.setitem(sys.modules, "cma", None)
    fails(["fusilier"], "learning needs cma: run `make bench`\n")


def test_an_installed_package_is_not_written_into(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(
        improve,
        "resource_path",
        lambda name: tmp_path / name if name == "pyproject.toml" else resource_path(name),
    )
    assert main(["learn", "fusilier"]) == 2
    assert "--out" in capsys.readouterr().err


def test_points_of_the_box_are_controllers(species):
    body = build_body(species.body)
    again = swim_at(body, species.swim, swim_point(body, species.swim))
    assert again.ticks_per_beat == species.swim.ticks_per_beat
    assert np.abs(np.subtract(again.contraction, species.swim.contraction)).max() <= 0.0011
    assert again.lag == pytest.approx(species.swim.lag, abs=1e-3)
    turned = turn_at(species.turn, turn_point(species.turn))
    assert turned.steering[-1] == species.turn.steering[-1]
    assert turned.amplitude == species.turn.amplitude


def test_no_point_of_the_box_contracts_faster_than_a_muscle_can():
    fish = load_toml(SHIPPED, Species)
    body = build_body(fish.body)
    for ticks in (8, 14, 24):
        swim = swim_at(body, fish.swim, (1.0, 1.0, 0.5), ticks)
        step = contraction_step(body, beat_contraction(swim, 1.0))
        assert step <= S_MAX
        # ... and the box reaches nearly as far as that, or as the species file allows.
        assert max(swim.contraction) > 0.59 or step > 0.98 * S_MAX


def test_hold_times_of_the_shipped_bends_are_found_again():
    """They agree with those of the file, which were found by bisection on the same gait."""
    species = load_toml(SHIPPED, Species)
    body = build_body(species.body)
    steady = steady_beat(body, beat_contraction(species.swim, species.swim.medium)).state
    found = with_holds(body, species.swim, species.turn, steady)
    for new, old in zip(found.steering, species.turn.steering, strict=True):
        assert new.hold_ticks == pytest.approx(old.hold_ticks, abs=0.4)


def test_losing_the_shape_is_the_greatest_loss():
    fish = load_toml(SHIPPED, Species)
    body = build_body(fish.body)
    sound = swim_loss(body, fish.swim, 1)
    lame = swim_loss(body, swim_at(body, fish.swim, (0.05, 0.05, 0.0), 14), 1)
    torn = swim_loss(body._replace(stiffness=body.stiffness * 0.2), fish.swim, 1)
    assert sound < lame < 100 <= torn


def test_economy_weighs_the_logarithm_of_the_cost(species):
    body = build_body(species.body)
    loss = [swim_loss(body, species.swim, 1, weight) for weight in (0.0, 1.0)]
    assert np.exp(loss[1] - loss[0]) == pytest.approx(steady_gait(species).cost, rel=1e-3)


def test_a_fish_that_does_not_swim_can_still_learn():
    fish = load_toml(SHIPPED, Species)
    assert fish.muscles
    lame = msgspec.structs.replace(fish.swim, contraction=(0.0, 0.0), ticks_per_beat=40)
    assert swim_faults(build_body(fish.body), lame, 1)
    found = learn(fish.muscles._replace(swim=lame), only="swim", budget=3)
    assert found.swim is None
    assert "old controller is faulty" in found.notes[0]


def test_missing_a_limit_counts_relative_to_it():
    tail = GAIT_LIMITS["tail"]
    assert excess(0.2, tail) == 0
    assert excess(0.3, tail) == pytest.approx(0.2)
    assert excess(0.12, tail) == pytest.approx(0.2)
    assert excess(float("nan"), tail) == excess(9.0, tail) == 2
