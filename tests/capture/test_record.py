import numpy as np
import pytest

from capture.record import motion_from_provenance, motion_of, run_trial
from subsea.repertoire import SEGMENTS, Repertoire, read_repertoire
from subsea.resources import resource_path
from subsea.species import Species

MIRROR = np.array([0, *(1 + 4 * ring + k for ring in range(5) for k in (1, 0, 3, 2)), 21, 22])


def test_a_repertoire_is_complete(repertoire: Repertoire, species: Species) -> None:
    assert tuple(repertoire.segments) == SEGMENTS
    assert repertoire.source == "biomechanics"
    assert repertoire.body_length_cm == species.body.length
    assert repertoire.tick_s == 0.033


def test_each_grade_is_clearly_faster_than_the_one_below(repertoire: Repertoire) -> None:
    slow, medium, fast = (
        repertoire.segments[f"swim_{grade}"].speed_cm_s for grade in ("slow", "medium", "fast")
    )
    assert medium >= 1.4 * slow
    assert fast >= 1.4 * medium


def test_turns_turn_to_their_side_by_what_they_promise(repertoire: Repertoire) -> None:
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


def test_only_a_schooling_species_carries_control_points(
    repertoire: Repertoire, species: Species
) -> None:
    for segment in repertoire.segments.values():
        assert (segment.control_points is not None) == species.schooling
        if segment.control_points is not None:
            assert segment.control_points.shape == (len(segment.nodes), 426, 3)


def test_the_provenance_is_enough_to_record_again(repertoire: Repertoire, species: Species) -> None:
    motion = motion_from_provenance(repertoire.provenance)
    assert motion == motion_of(species)
    trial = run_trial(motion, "swim_fast")
    assert repertoire.provenance["warm_up_beats"]["swim_fast"] == trial.warm_up_beats


def test_the_shipped_repertoire_is_that_of_the_species_file(
    name: str, repertoire: Repertoire
) -> None:
    """Whoever edits a body, a gait or an outline has to record again."""
    shipped = read_repertoire(resource_path(f"repertoires/{name}.h5"))
    for segment, fresh in repertoire.segments.items():
        recorded = shipped.segments[segment]
        np.testing.assert_allclose(recorded.nodes, fresh.nodes, atol=1e-5)
        if fresh.control_points is not None:
            assert recorded.control_points is not None
            np.testing.assert_allclose(recorded.control_points, fresh.control_points, atol=1e-4)
