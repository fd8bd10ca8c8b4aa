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
    GAIT_SIZE,
    MASS,
    MASS_FACTOR,
    TICKS,
    body_at,
    gait_at,
    gait_point,
    species_point,
)
from capture.learning.improve import write_plans
from capture.learning.journal import Journal, evaluations, read_journal
from capture.learning.lifelike import (
    STATIONS,
    grade_waves,
    lateral,
    rear_bend,
    wave_loss,
    wavelength,
)
from capture.learning.whole import LearningTask, learn_whole
from subsea.base.system import resource_path
from subsea.base.toml_files import load_toml
from subsea.biomechanics.body import build_body
from subsea.biomechanics.body_plan import NODES_AT_STATION
from subsea.biomechanics.controllers import S_MAX
from subsea.biomechanics.fins import contraction_step
from subsea.biomechanics.solver import STEP, longest_step
from subsea.biomechanics.trial import beat_contraction
from subsea.fish.scaffold import MARGIN, volumes_at
from subsea.fish.species import Species, load_species
from tests.support.commands import refusal

AT = np.array([0.0, 0.1, 0.3, 0.5, 0.7, 0.85, 1.0])
BEAT, LENGTH, STRIDE = 16, 20.0, 12.0


def travelling_wave(half, waves):
    """Nodes (17, 23, 3) of a beat: sections (AT) sway by ``half`` L, ``waves`` on the body."""
    time = np.arange(BEAT + 1)[:, None] / BEAT
    x = -AT * LENGTH + STRIDE * time
    z = half * LENGTH * np.sin(2 * np.pi * (time - waves * AT))
    frames = np.zeros((BEAT + 1, 23, 3))
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
    volumes = volumes_at(fish.surface, fish.body.stations)
    rng = np.random.default_rng(4)
    for point in (*rng.random((3, BODY_SIZE)), np.ones(BODY_SIZE)):
        plan = body_at(fish.body, point, volumes)
        body = build_body(plan)
        assert longest_step(body)[0] >= MARGIN * STEP
        low, high = (share * DENSITY * volumes.sum() for share in MASS)
        assert 0.98 * low <= plan.mass <= 1.02 * high
        # No station is far heavier or lighter than the fish around it.
        shares = np.array(plan.masses) * NODES_AT_STATION / plan.mass * volumes.sum() / volumes
        assert shares.max() / shares.min() <= 1.02 * MASS_FACTOR**2
        swim = fish.swim
        for grade in TICKS:
            swim = gait_at(body, swim, grade, rng.random(GAIT_SIZE))
        for grade in swim.grades:
            gear = beat_contraction(swim.at(grade), swim.amplitude(grade))
            assert contraction_step(body, gear) <= S_MAX


def test_a_body_and_its_gaits_are_points_of_their_box():
    fish = load_species("blue_tang")
    volumes, body = volumes_at(fish.surface, fish.body.stations), build_body(fish.body)
    for grade in fish.swim.grades:
        again = gait_at(body, fish.swim, grade, gait_point(body, fish.swim, grade))
        assert again.at(grade).ticks_per_beat == fish.swim.at(grade).ticks_per_beat
        assert again.at(grade).lag == pytest.approx(fish.swim.at(grade).lag, abs=1e-3)
        contraction = np.multiply(fish.swim.amplitude(grade), fish.swim.at(grade).contraction)
        np.testing.assert_allclose(again.at(grade).contraction, contraction, atol=2e-3)
    plan = body_at(fish.body, np.full(BODY_SIZE, 0.5), volumes)
    same = body_at(plan, species_point(plan, fish.swim, volumes)[GAIT_SIZE:], volumes)
    np.testing.assert_allclose(same.masses, plan.masses, rtol=0.02)
    assert same.half_widths == plan.half_widths and same.viscosity == plan.viscosity


def test_the_loss_finds_a_wag_at_every_grade():
    """One contraction and one lag for all grades let the snout swing as far as the tail."""
    fish = load_species("fusilier")
    body = build_body(fish.body)
    waves = grade_waves(body, fish.swim)
    fast = waves["fast"].stride / fish.swim.ticks_per_beat
    wags = msgspec.structs.replace(fish.swim, slow_contraction=(0.1, 0.14), slow_lag=1.4)
    assert grade_waves(body, wags)["slow"].snout_over_tail > 0.5
    good, bad = (wave_loss(body, swim, "slow", 1, fast) for swim in (fish.swim, wags))
    assert good + 5.0 < bad


def test_an_interrupted_search_ends_as_an_uninterrupted_one(tmp_path, monkeypatch):
    def task(name):
        return LearningTask("fusilier", load_species("fusilier"), True, 5, 2, tmp_path / name)

    monkeypatch.setattr(whole, "MAX_TRIED", 0)
    learn_whole(task("whole"))
    losses = read_journal(tmp_path / "whole")["searches"][0]
    assert len(losses) == 5 and len(set(losses)) > 2
    journal = Journal(tmp_path / "cut", whole.key_of(task("cut")))
    remembered = journal.remembered(lambda places: [losses[k] for k in places])
    assert remembered([0]) + remembered([1, 2]) == losses[:3]
    journal.save()
    tried, real = [], whole.wave_course
    monkeypatch.setattr(whole, "wave_course", lambda *given: tried.append(given) or real(*given))
    learn_whole(task("cut"))
    assert len(tried) == 2
    assert read_journal(tmp_path / "cut") == read_journal(tmp_path / "whole")


def test_a_journal_of_another_search_or_a_damaged_one_is_not_used(tmp_path):
    path = tmp_path / "journal"
    for text in ("", "[]", '{"searches": 3}', '{"searches": [["a"]], "key": "k"}', "\x00"):
        path.write_text(text, encoding="utf-8")
        assert evaluations(path) == 0
        assert Journal(path, "k").remembered(lambda given: [2.0])([0]) == [2.0]
    path.write_text(json.dumps({"key": "other", "searches": [[1.0]]}), encoding="utf-8")
    assert Journal(path, "k").remembered(lambda given: [2.0])([0]) == [2.0]
    assert Journal(path, "other").remembered(lambda given: [2.0])([0]) == [1.0]


@pytest.mark.nightly
def test_the_command_writes_finished_species_once(tmp_path, monkeypatch, capsys):
    fish = load_species("fusilier")
    assert fish.muscles
    swim = msgspec.structs.replace(fish.swim, slow=0.7, slow_ticks=30, medium_ticks=20, burst=1.0)
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


def test_a_burst_that_was_not_found_leaves_the_file(tmp_path):
    fish, target = load_species("fusilier"), tmp_path / "fish.toml"
    source = resource_path("assets") / "species" / "fusilier.toml"
    burst = msgspec.structs.replace(fish.swim, burst=1.0, burst_ticks=12)
    write_plans(source, target, swim=burst)
    calm = msgspec.structs.replace(
        burst, burst=None, burst_ticks=None, burst_contraction=None, burst_lag=None
    )
    write_plans(target, target, swim=calm)
    text = target.read_text(encoding="utf-8")
    assert load_toml(target, Species).swim == calm and "burst" not in text.split("[turn]")[0]


def test_options_that_contradict_each_other_are_reported(capsys):
    for arguments, words in (
        (["fusilier", "clownfish"], "give --body or --gait too"),
        (["--gait"], "name species or give --all"),
        (["--gait", "--all", "fusilier"], "one of the two"),
        (["--gait", "fusilier", "--ticks", "12"], "--ticks and --body or --gait"),
        (["--body", "ribbon_eel"], "driven by its spine"),
        (["--body", "fusilier", "--out", str(resource_path("pyproject.toml"))], "pyproject.toml"),
    ):
        assert words in refusal(main, ["learn", *arguments], capsys)
