"""Measures of a travelling wave in closed form, and the search of a real body."""

import json

import msgspec
import numpy as np
import pytest

from capture.cli.main import main
from capture.learning import batch, whole
from capture.learning.body_space import (
    BODY_SIZE,
    DENSITY,
    MARGIN,
    MASS,
    SWIM_SIZE,
    body_at,
    gait_at,
    outline_volume,
    species_point,
)
from capture.learning.journal import Journal, evaluations, read_journal
from capture.learning.lifelike import (
    STATIONS,
    TAIL,
    grade_waves,
    lateral,
    rear_bend,
    wavelength,
    with_amplitudes,
)
from capture.learning.whole import LearningTask, learn_whole
from subsea.base.system import resource_path
from subsea.biomechanics.body import build_body
from subsea.biomechanics.controllers import S_MAX
from subsea.biomechanics.fins import contraction_step
from subsea.biomechanics.solver import STEP, longest_step
from subsea.biomechanics.trial import beat_contraction
from subsea.fish.species import load_species

AT = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.85, 1.0])
TICKS, LENGTH, STRIDE = 16, 20.0, 12.0


def travelling_wave(half, waves):
    """Nodes (17, 23, 3) of a beat: sections (AT) sway by ``half`` L, ``waves`` on the body."""
    time = np.arange(TICKS + 1)[:, None] / TICKS
    x = -AT * LENGTH + STRIDE * time
    z = half * LENGTH * np.sin(2 * np.pi * (time - waves * AT))
    frames = np.zeros((TICKS + 1, 23, 3))
    for k, nodes in enumerate(STATIONS):
        frames[:, nodes, 0], frames[:, nodes, 2] = x[:, k, None], z[:, k, None]
    return frames


def test_a_wave_has_its_amplitude_length_and_bend():
    beat = travelling_wave(0.1, 1.25)
    across = lateral(beat) / LENGTH
    np.testing.assert_allclose(np.ptp(across, axis=0) / 2, 0.1, rtol=1e-2)
    assert wavelength(across, AT) == pytest.approx(0.8, rel=1e-6)
    assert wavelength(lateral(travelling_wave(0.1, -1.0)) / LENGTH, AT) == np.inf
    # Two sections that swing by ±a about their joint bend by the sum of their slopes.
    bent = travelling_wave(0.0, 1.0)
    bent[5, STATIONS[-1], 2] = 0.15 * LENGTH * np.tan(np.radians(17.0))
    assert rear_bend(bent, AT) == pytest.approx(17.0)


def test_every_point_of_the_box_is_a_body_that_the_step_bears():
    fish = load_species("fusilier")
    volume = outline_volume(fish.surface, fish.body.length)
    rng = np.random.default_rng(4)
    for point in (*rng.random((3, BODY_SIZE)), np.ones(BODY_SIZE)):
        plan = body_at(fish.body, point, volume)
        assert longest_step(build_body(plan))[0] >= MARGIN * STEP
        low, high = (share * DENSITY * volume for share in MASS)
        assert 0.98 * low <= plan.mass <= 1.02 * high
        swim = gait_at(plan, fish.swim, rng.random(SWIM_SIZE))
        for grade in swim.grades:
            gear = beat_contraction(swim.at(grade), swim.amplitude(grade))
            assert contraction_step(build_body(plan), gear) <= S_MAX
    middle = np.append(species_point(fish.body, fish.swim, volume)[SWIM_SIZE:-1], 0.5)
    again = body_at(msgspec.structs.replace(fish.body), middle, volume)
    assert again.half_widths == fish.body.half_widths


def test_grades_differ_by_frequency():
    fish = load_species("fusilier")
    body = build_body(fish.body)
    swim = msgspec.structs.replace(fish.swim, slow=0.8, medium=0.7)
    waves = grade_waves(body, with_amplitudes(body, swim))
    for grade in ("slow", "medium"):
        assert waves[grade].tail == pytest.approx(TAIL[grade] * waves["fast"].tail, rel=0.04)
    speeds = [wave.stride / swim.at(grade).ticks_per_beat for grade, wave in waves.items()]
    assert np.all(np.diff(speeds) > 0)


def test_an_interrupted_search_ends_as_an_uninterrupted_one(tmp_path, monkeypatch):
    def task(name):
        return LearningTask("fusilier", load_species("fusilier"), True, 5, 2, tmp_path / name)

    monkeypatch.setattr(whole, "MAX_VERIFIED", 0)
    learn_whole(task("whole"))
    losses = read_journal(tmp_path / "whole")["searches"][0]
    assert len(losses) == 5 and len(set(losses)) > 3
    journal = Journal(tmp_path / "cut", whole.key_of(task("cut")))
    loss = journal.remembered(losses.__getitem__)
    assert [loss(k) for k in range(3)] == losses[:3]
    journal.save()
    tried, real = [], whole.wave_loss
    monkeypatch.setattr(whole, "wave_loss", lambda *given: tried.append(given) or real(*given))
    learn_whole(task("cut"))
    assert len(tried) == 2
    assert read_journal(tmp_path / "cut") == read_journal(tmp_path / "whole")


def test_a_journal_of_another_search_or_a_damaged_one_is_not_used(tmp_path):
    path = tmp_path / "journal"
    for text in ("", "[]", '{"searches": 3}', '{"searches": [["a"]], "key": "k"}', "\x00"):
        path.write_text(text, encoding="utf-8")
        assert evaluations(path) == 0
        assert Journal(path, "k").remembered(lambda given: 2.0)(0) == 2.0
    path.write_text(json.dumps({"key": "other", "searches": [[1.0]]}), encoding="utf-8")
    assert Journal(path, "k").remembered(lambda given: 2.0)(0) == 2.0
    assert Journal(path, "other").remembered(lambda given: 2.0)(0) == 1.0


def test_the_command_writes_finished_species_once(tmp_path, monkeypatch, capsys):
    fish = load_species("fusilier")
    assert fish.muscles
    swim = msgspec.structs.replace(fish.swim, slow=0.7, slow_ticks=30, medium_ticks=20, burst=1.05)
    new = fish.muscles._replace(
        body=msgspec.structs.replace(fish.body, muscle_stiffness=29.0), swim=swim
    )
    asked: list[str] = []

    def learned(task):
        asked.append(task.name)
        Journal(task.journal, whole.key_of(task)).save()
        fails = task.name == "clownfish" and asked.count("clownfish") == 1
        return whole.Learned(None if fails else new, ["gait: rejected: it circles"])

    monkeypatch.setattr(batch, "learn_whole", learned)
    from subsea.jobs.workers import serial

    monkeypatch.setattr(batch, "process_pool", lambda number: serial)
    command = ["learn", "--body", "--gait", "fusilier", "clownfish", "--out", str(tmp_path)]
    assert main(command) == 1
    out = capsys.readouterr().out
    assert "clownfish: nothing was found, the last candidate as gait: rejected: it circles" in out
    assert "slow" in out and "fast misses: " in out
    written = (tmp_path / "fusilier.toml").read_text(encoding="utf-8")
    assert "slow_ticks = 30" in written and "muscle_stiffness = 29.0\n" in written
    assert "# cm behind the nose tip" in written and "cross_drag" not in written
    # The same command learns only what was not found; then nothing of its state is left.
    assert main(command) == 0
    assert asked == ["fusilier", "clownfish", "clownfish"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clownfish.toml", "fusilier.toml"]


def test_options_that_contradict_each_other_are_reported(capsys):
    for arguments, words in (
        (["fusilier", "clownfish"], "give --body or --gait too"),
        (["--gait"], "name species or give --all"),
        (["--gait", "--all", "fusilier"], "one of the two"),
        (["--gait", "fusilier", "--ticks", "12"], "--ticks and --body or --gait"),
        (["--body", "ribbon_eel"], "driven by its spine"),
        (["--body", "fusilier", "--out", str(resource_path("pyproject.toml"))], "pyproject.toml"),
    ):
        assert main(["learn", *arguments]) == 2
        out, err = capsys.readouterr()
        assert not out and err.count("\n") == 1 and words in err
