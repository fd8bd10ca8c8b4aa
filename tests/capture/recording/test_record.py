import numpy as np
import pytest

from capture.recording.record import motion_from_provenance, motion_of, run_trial
from subsea.fish.species import Species
from subsea.repertoire import Repertoire

MIRROR = np.array([0, *(1 + 4 * ring + k for ring in range(5) for k in (1, 0, 3, 2)), 21, 22])


def test_turns_have_their_side_and_angle(repertoire: Repertoire) -> None:
    segments = repertoire.segments
    assert 4 < segments["turn_left_gradual"].turn_deg < 18
    assert 40 < segments["turn_left_sharp"].turn_deg < 65
    for grade in ("gradual", "sharp"):
        left, right = segments[f"turn_left_{grade}"], segments[f"turn_right_{grade}"]
        # The frame B leans on nodes 5, 6 and 7 and is itself no mirror image, hence the margin.
        assert abs(left.turn_deg + right.turn_deg) < 0.01
        np.testing.assert_allclose(right.speed_cm_s, left.speed_cm_s, rtol=1e-4)


@pytest.mark.parametrize("grade", ["gradual", "sharp"])
def test_a_right_turn_is_the_mirror_of_a_left_one(species: Species, grade: str) -> None:
    left, right = (
        run_trial(motion_of(species), f"turn_{side}_{grade}").frames for side in ("left", "right")
    )
    start = left[0, 0], right[0, 0]
    mirrored = (right - start[1])[:, MIRROR] * (1, 1, -1)
    np.testing.assert_allclose(mirrored, left - start[0], atol=1e-6)


def test_a_sharp_turn_begins_and_ends_near_steady_swimming(repertoire: Repertoire) -> None:
    segment = repertoire.segments["turn_left_sharp"]
    swim = repertoire.segments["swim_medium"]
    gap = np.linalg.norm(segment.nodes[-1] - swim.nodes[-1], axis=1).max()
    assert gap < 0.07 * repertoire.body_length_cm
    ends = np.linalg.norm(segment.increment_translation[[0, -1]], axis=1)
    steady = np.linalg.norm(swim.increment_translation, axis=1)
    assert (ends > 0.7 * steady.min()).all()
    assert (ends < 1.3 * steady.max()).all()


def test_the_provenance_is_enough_to_record_again(repertoire: Repertoire, species: Species) -> None:
    motion = motion_from_provenance(repertoire.provenance)
    assert motion == motion_of(species)
    trial = run_trial(motion, "swim_fast")
    assert repertoire.provenance["warm_up_beats"]["swim_fast"] == trial.warm_up_beats
