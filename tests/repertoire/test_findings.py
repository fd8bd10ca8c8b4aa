"""Findings about recorded motion: shipped species pass, fishes that writhe do not."""

from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from subsea.base.errors import UserError
from subsea.biomechanics.manoeuvres import sketched_turn
from subsea.fish.species import load_species, repertoire_file, shipped_species
from subsea.geometry.rotation import from_matrix, matrix
from subsea.repertoire import findings, read_repertoire
from subsea.repertoire.findings import (
    CALM,
    FishMotion,
    Severity,
    complaints,
    motion_findings,
    try_motion,
)
from subsea.repertoire.segments import make_segment, run_trial


@pytest.fixture(scope="module")
def fusilier():
    repertoire = read_repertoire(repertoire_file("fusilier"))
    return FishMotion(repertoire.segments, repertoire.body_length_cm)


def changed(motion, **segments):
    """The motion with other segments."""
    return motion._replace(segments={**motion.segments, **segments})


@pytest.mark.parametrize("name", shipped_species())
def test_shipped_species_swim_straight_and_turn_the_right_way(name):
    repertoire = read_repertoire(repertoire_file(name))
    assert complaints(FishMotion(repertoire.segments, repertoire.body_length_cm)) == []


def test_each_fault_of_recorded_motion_is_a_sentence(fusilier):
    of = fusilier.segments
    left, right = of["turn_left_gradual"], of["turn_right_gradual"]
    cases = {
        "The burst swim turns by +29.6° a beat": {"swim_burst": left},
        "A gradual turn to either side turns the wrong way, by 30° a beat": {
            "turn_left_gradual": right, "turn_right_gradual": left,
        },
        "A sharp turn to the left turns the wrong way, by 89°": {
            "turn_left_sharp": of["turn_right_sharp"],
        },
        "A gradual turn to the right turns the fish by 9° a beat; 10° are expected": {
            "turn_right_gradual": replace(right, turn_deg=-9.4),
        },
        "The medium swim is only 1.00 times as fast": {"swim_medium": of["swim_slow"]},
        "It swims slowly": {"swim_fast": replace(of["swim_fast"], speed_cm_s=5.0)},
    }  # fmt: skip
    for words, segments in cases.items():
        texts = complaints(changed(fusilier, **segments))
        assert any(text.startswith(words) for text in texts), (words, texts)
    failed = fusilier._replace(failures={"swim_fast": "the body does not swim steadily"})
    assert complaints(failed) == [f"The fast swim fails: the body does not swim steadily. {CALM}"]


def test_a_swim_that_rolls_is_reported(fusilier):
    swim = fusilier.segments["swim_medium"]
    ticks = len(swim.nodes)
    turns = matrix(swim.increment_rotation)

    def rolled(degrees):
        """The swim with further rolls (T,), in degrees a tick."""
        half, none = np.radians(degrees) / 2, np.zeros(ticks)
        more = matrix(np.stack([np.cos(half), np.sin(half), none, none], axis=1))
        return replace(swim, increment_rotation=from_matrix(turns @ more))

    over = changed(fusilier, swim_medium=rolled(np.full(ticks, 17.0 / ticks)))
    assert any("The medium swim rolls over by" in text for text in complaints(over))
    sway = 60.0 / ticks * np.sign(np.sin(2 * np.pi * (np.arange(ticks) + 0.5) / ticks))
    swaying = changed(fusilier, swim_medium=rolled(sway))
    assert any("to each side" in text for text in complaints(swaying))


def test_a_threshold_that_is_met_as_shown_is_not_a_warning(fusilier):
    fast = fusilier.segments["swim_fast"]
    speed = 0.3496 * fusilier.length_cm / (len(fast.nodes) * findings.TICK_S)
    slow = changed(fusilier, swim_fast=replace(fast, speed_cm_s=speed))
    assert not any("0.35 a beat are expected" in text for text in complaints(slow))
    gradual = replace(fusilier.segments["turn_left_gradual"], turn_deg=9.7)
    assert not complaints(changed(fusilier, turn_left_gradual=gradual))


def test_a_body_whose_medium_beat_turns_is_found_though_it_is_symmetric():
    """Fast swimming and gradual turns of this fish are good."""
    base = load_species("emperor_angelfish").muscles
    body = structs.replace(
        base.body,
        half_widths=(1.0620857382055249, 1.310994487708168, 1.3200669211689, 1.1175309241110496,
                     0.9841751416938692),
        half_heights=(1.4949628862797002, 3.4309302129243977, 3.5762580113145135,
                      3.310271042429268, 1.7945158008175213),
        cross_stiffness=89.80000783822719, muscle_stiffness=101.54954157406999,
        other_stiffness=224.08039339071644, viscosity=1.3388825993627076,
    )  # fmt: skip
    gait = (0.42259030761691696, 0.4059365023906345)
    swim = structs.replace(
        base.swim, contraction=gait, lag=1.311736365578999, medium=0.709, medium_ticks=29,
        medium_contraction=None, medium_lag=None,
    )  # fmt: skip
    trial = run_trial(base._replace(body=body, swim=swim), "swim_medium")
    segment = make_segment(trial.frames, body.length, "forward", "medium", True)
    motion = FishMotion({"swim_medium": segment}, body.length)
    (text,) = complaints(motion)
    assert text.startswith("The medium swim turns by +9.9° a beat.")


def test_a_motion_that_fails_is_tried_no_further(monkeypatch):
    """A sharp turn begins with the medium swim."""

    def unsteady(muscles, name):
        raise UserError("the body does not swim steadily after 1000 beats")

    monkeypatch.setattr(findings, "run_trial", unsteady)
    monkeypatch.setattr(findings, "sketched_turn", pytest.fail)
    motion = try_motion(load_species("fusilier").muscles)
    assert not motion.segments and "swim_medium" in motion.failures
    assert {one.severity for one in motion_findings(motion)} == {Severity.FAULT}
    assert "turn_left_sharp" not in motion.failures


def test_a_sketched_turn_goes_the_way_of_the_turn_that_is_searched():
    muscles = load_species("fusilier").muscles
    trial = sketched_turn(muscles, "turn_right_sharp")
    segment = make_segment(trial.frames, muscles.body.length, "right", "sharp", False)
    assert -90.0 < segment.turn_deg < -30.0
