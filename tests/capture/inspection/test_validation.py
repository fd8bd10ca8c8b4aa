"""A repertoire beside measured fishes."""

import dataclasses

import numpy as np
import pytest

from capture.inspection.top_view import lateral_offset
from capture.inspection.validation import FULL_TEMPO, ROW_TEMPO, bainbridge, validate
from subsea.base.findings import MISSING
from subsea.fish.measured import load_measured
from subsea.fish.species import load_species, repertoire_file
from subsea.motor import controller, playback
from subsea.repertoire import read_repertoire


def found_in(repertoire):
    species = load_species(repertoire.species)
    return {one.quantity: one for one in validate(repertoire, species, load_measured()).findings}


def test_an_adult_beats_by_froude_similarity(repertoire):
    found = found_in(repertoire)
    species = load_species(repertoire.species)
    adult = 0.5 * sum(species.size_cm)
    rate = species.pace * (repertoire.body_length_cm / adult) ** 0.5
    segment = repertoire.segments["swim_fast"]
    speed = rate * segment.speed_cm_s / repertoire.body_length_cm
    beat = rate / (len(segment.nodes) * repertoire.tick_s)
    assert found["speed, fastest cruise"].value == pytest.approx(speed)
    assert found["beat, fastest cruise"].value == pytest.approx(beat)
    assert found["stride, fast"].value == pytest.approx(speed / beat)
    strouhal = found["Strouhal number, fast"].value
    assert strouhal == pytest.approx(found["tail amplitude, fast"].value * beat / speed)
    burst = repertoire.segments.get("swim_burst", segment)
    speed = rate * burst.speed_cm_s / repertoire.body_length_cm
    beat = rate / (len(burst.nodes) * repertoire.tick_s)
    assert found["burst over Bainbridge's speed at its beat"].value == pytest.approx(
        FULL_TEMPO * speed / bainbridge(FULL_TEMPO * beat)
    )


def test_segments_that_a_file_lacks_are_not_recorded(repertoire):
    segments = {
        name: segment for name, segment in repertoire.segments.items() if "cstart" not in name
    }
    found = found_in(dataclasses.replace(repertoire, segments=segments))
    assert found["cstart_left_wide: net angle"].verdict == MISSING
    segments["cstart_left_wide"] = segments["turn_left_sharp"]
    found = found_in(dataclasses.replace(repertoire, segments=segments))
    turned = segments["turn_left_sharp"].turn_deg
    assert found["cstart_left_wide: net angle"].value == pytest.approx(turned, abs=25)


def test_every_grade_and_every_turn_is_compared(repertoire):
    """Segments, measured here from the nodes of the file, beside what the table says."""
    found = found_in(repertoire)
    for name, segment in repertoire.segments.items():
        kind, _, grade = name.rpartition("_")
        if kind == "swim" and segment.cyclic and grade != "coast":
            aside = lateral_offset(segment)
            snout, tail = np.ptp(aside[:, [0, -1]], axis=0)
            assert found[f"snout over tail, {grade}"].value == pytest.approx(snout / tail, abs=0.02)
            assert f"body wavelength, {grade}" in found and f"roll, {grade}" in found
        if kind in ("turn_left", "turn_right"):
            assert found[f"{name}: acceleration"].value > 0.0
            if not segment.cyclic:
                assert found[f"{name}: net angle"].value == pytest.approx(
                    abs(segment.turn_deg), abs=25
                )
    assert found["beat over speed: slope"].value > 0.0


def test_eels_and_rays_have_measures_of_their_own():
    eel, ray = (
        found_in(read_repertoire(repertoire_file(name)))
        for name in ("ribbon_eel", "spotted_eagle_ray")
    )
    assert eel["envelope off the published one, fast"].source == "anguilliform wave"
    assert eel["drag coefficient of a glide"].verdict == "pass"
    assert ray["drag coefficient of a glide"].verdict == "pass"
    assert "wavelength, fast" not in ray
    assert all(np.isfinite(one.value) for one in ray.values())


def test_bainbridges_line():
    assert [bainbridge(f) for f in (5.0, 10.0, 20.0)] == [2.75, 6.5, 14.0]


def test_tempos_are_those_of_playback():
    assert playback.TEMPO[1] == controller.CSTART_TEMPO == FULL_TEMPO
    assert controller.ROW_TEMPO == ROW_TEMPO
