"""Conformance of all shipped species and each segment of their repertoires."""

from functools import cache

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from capture.inspection.simulated import replay
from capture.recording.batch import is_up_to_date
from capture.recording.record import motion_from_provenance, record_segment
from subsea.base.system import resource_names, resource_path
from subsea.biomechanics.body import UNITS, body_frame, build_body, to_body
from subsea.biomechanics.manoeuvres import ROUNDS, TURNS
from subsea.biomechanics.simulation import BodyState, simulate
from subsea.biomechanics.solver import STRAIN_LIMITS, TICK_S
from subsea.biomechanics.trial import Trial, deformation
from subsea.fish.species import load_species, species_names
from subsea.fish.surface import rest_control_points
from subsea.geometry.rotation import matrix
from subsea.repertoire import BASIC_SEGMENTS, SEGMENTS, Repertoire, Segment, read_repertoire
from subsea.repertoire.schema import ACYCLIC
from subsea.repertoire.segments import heading_change, run_trial, steady_contraction
from tests.support.daily import only
from tests.support.recording import search

pytestmark = pytest.mark.usefixtures("known_turns")

SPECIES = species_names()
SWIMS = ("swim_slow", "swim_medium", "swim_fast")
MIRROR = np.array([0, *(1 + 4 * ring + k for ring in range(5) for k in (1, 0, 3, 2)), 21, 22])
each_species = pytest.mark.parametrize("species", SPECIES)


@cache
def repertoire_of(species: str) -> Repertoire:
    """The repertoire that is shipped."""
    return read_repertoire(resource_path(f"repertoires/{species}.h5"))


def world(segment: Segment, cycles: int = 1):
    """World nodes (t, 23, 3) of a segment that is replayed from the axes of the world."""
    return replay(segment, np.zeros(3), np.eye(3), cycles)


def test_every_repertoire_belongs_to_a_species():
    assert resource_names("repertoires", ".h5") == SPECIES
    assert len(SPECIES) >= 2


@each_species
def test_a_repertoire_is_complete_and_belongs_to_its_species(species):
    repertoire, plan = repertoire_of(species), load_species(species)
    assert set(repertoire.segments) >= set(BASIC_SEGMENTS)
    assert repertoire.species == species
    assert repertoire.tick_s == TICK_S
    assert repertoire.source == ("biomechanics" if plan.muscles else "spine")
    assert repertoire.body_length_cm == plan.length_cm
    assert np.ptp(repertoire.rest_nodes[:, 0]) == pytest.approx(plan.length_cm)
    rest = rest_control_points(plan.surface, plan.length_cm, repertoire.rest_nodes[0, 0])
    reach = 1.35 * np.linalg.norm(rest, axis=1).max()
    for name, segment in repertoire.segments.items():
        side = name.split("_")[1] if name.startswith(("turn", "cstart")) else "forward"
        assert segment.pattern == side
        assert name.endswith(segment.grade)
        assert segment.cyclic == (segment.grade not in ACYCLIC)
        # SMC §4.1 stores control points of schools only; spine-driven fishes need them too.
        if plan.muscles or plan.schooling:
            assert (segment.control_points is not None) == plan.schooling
        if segment.control_points is not None:
            assert np.linalg.norm(segment.control_points, axis=2).max() < reach


@each_species
def test_rows_are_poses_of_a_sound_body_and_agree_with_the_attributes(species):
    """A spine has no units of limited strain, but keeps the length of the body."""
    repertoire = repertoire_of(species)
    length = repertoire.body_length_cm
    rest, (i, j) = repertoire.rest_nodes, UNITS.T
    at_rest = np.linalg.norm(rest[j] - rest[i], axis=1)
    low, high = STRAIN_LIMITS if repertoire.source == "biomechanics" else (0.4, 2.2)
    for name, segment in repertoire.segments.items():
        nodes, turns = segment.nodes, segment.increment_rotation
        for values in (turns, segment.increment_translation, nodes):
            assert np.isfinite(values).all(), name
            assert len(values) == len(nodes), name
        np.testing.assert_allclose(np.linalg.norm(turns, axis=1), 1, atol=1e-9, err_msg=name)
        origin, rotation = body_frame(nodes)
        still = np.broadcast_to(np.eye(3), rotation.shape)
        np.testing.assert_allclose(origin, 0, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(rotation, still, atol=1e-9, err_msg=name)
        strain = np.linalg.norm(nodes[:, j] - nodes[:, i], axis=2) / at_rest
        assert low <= strain.min() and strain.max() <= high, name
        # A fish that rows or coasts holds its body; in all other segments the body does move.
        held = segment.grade in ("forward", "coast")
        assert (np.ptp(strain, axis=0).max() > 0.001) != held, name
        radius = np.linalg.norm(nodes, axis=2).max() / length
        assert radius <= segment.bounding_radius_bl * (1 + 1e-9) and radius < 1, name
        steps = np.diff(world(segment, 2 if segment.cyclic else 1), axis=0)
        assert np.linalg.norm(steps, axis=2).max() < 0.16 * length, name
        place, heading = np.zeros((1, 3)), np.eye(3)
        for turn, step in zip(matrix(turns), segment.increment_translation, strict=True):
            place = np.concatenate([place, [place[-1] + heading @ step]])
            heading = heading @ turn
        way = place[[0, -1]] if segment.cyclic else place
        distance = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
        assert segment.speed_cm_s == pytest.approx(distance / (len(nodes) * TICK_S)), name
        turned = heading_change(np.eye(3), heading)
        assert segment.turn_deg == pytest.approx(turned, abs=1e-6), name


@each_species
def test_cycles_close_and_sharp_turns_begin_and_end_in_swimming(species):
    repertoire = repertoire_of(species)
    swim = repertoire.segments["swim_medium"]
    usual = np.linalg.norm(swim.increment_translation, axis=1)
    for name, segment in repertoire.segments.items():
        nodes = segment.nodes
        if segment.cyclic:
            assert segment.loop_error_bl <= 1e-3, name
            # From the last row to the first is a step like any other.
            inside = np.linalg.norm(np.diff(nodes, n=2, axis=0), axis=2).max()
            across = np.concatenate([nodes[-2:], nodes[:2]])
            jump = np.linalg.norm(np.diff(across, n=2, axis=0), axis=2).max()
            # A body that rows or coasts is held.
            assert jump <= 1.5 * inside + 1e-4 * repertoire.body_length_cm, name
        if segment.grade != "sharp":
            continue
        for row in (nodes[0], nodes[-1]):
            gap = np.linalg.norm(swim.nodes - row, axis=2).max(axis=1).min()
            assert gap < 0.07 * repertoire.body_length_cm, name
        ends = np.linalg.norm(segment.increment_translation[[0, -1]], axis=1)
        assert (0.7 * usual.min() < ends).all() and (ends < 1.4 * usual.max()).all(), name


@each_species
def test_grades_turns_and_sides_are_as_named(species):
    """Faster grades are faster, swims straight, turns to their side, left the mirror of right."""
    repertoire = repertoire_of(species)
    segments, length = repertoire.segments, repertoire.body_length_cm
    slow, medium, fast = (segments[name].speed_cm_s for name in SWIMS)
    assert slow > 0 and medium >= 1.1 * slow and fast >= 1.1 * medium
    assert max(abs(segments[name].turn_deg) for name in SWIMS) < 0.05
    plan = load_species(species)
    turn = plan.spine.turn if plan.spine else plan.turn
    assert 10 < segments["turn_left_gradual"].turn_deg < 35
    assert segments["turn_left_sharp"].turn_deg == pytest.approx(turn.sharp, abs=10.0)
    for name in segments:
        if "left" not in name:
            continue
        left, right = segments[name], segments[name.replace("left", "right")]
        assert right.turn_deg == pytest.approx(-left.turn_deg, rel=0.02, abs=0.01)
        assert right.speed_cm_s == pytest.approx(left.speed_cm_s, rel=1e-4)
        path, mirrored = world(left), world(right)[:, MIRROR] * (1, 1, -1)
        # Compare both in the frame in which each begins.
        seen = [
            to_body(one, *(part[None] for part in body_frame(one[0]))) for one in (path, mirrored)
        ]
        least = {"coast": 0.03, "row": 0.05}.get(segments[name].grade, 0.1)  # few rows, or slow
        assert np.ptp(seen[0][:, 0], axis=0).max() > least * length, name
        np.testing.assert_allclose(seen[1], seen[0], atol=1e-5 * length, err_msg=name)


@each_species
def test_a_repertoire_is_up_to_date(species):
    """After a change of plans or recorder: `subsea-capture record --all`."""
    assert is_up_to_date(resource_path("repertoires"), species, load_species(species))


@pytest.mark.parametrize("species", only(("clownfish",), SPECIES))
def test_the_provenance_is_the_species_file_and_records_the_same_rows(species, pytestconfig):
    """By day those to the left: `test_grades_turns_and_sides_are_as_named` has their mirrors."""
    repertoire, plan = repertoire_of(species), load_species(species)
    tables = {
        key: msgspec.convert(value, type(getattr(plan, key)))
        for key, value in repertoire.provenance.items()
        if isinstance(getattr(plan, key, None), msgspec.Struct)
    }
    assert set(tables) >= ({"body", "swim", "turn"} if plan.muscles else {"spine"})
    rebuilt = msgspec.structs.replace(plan, **tables)
    assert rebuilt == plan
    length = repertoire.body_length_cm
    for name, shipped in repertoire.segments.items():
        if "right" in name and not pytestconfig.getoption("--nightly"):
            continue
        fresh, beats, _ = record_segment(rebuilt, name)
        tolerances = dict.fromkeys(("increment_translation", "nodes", "increment_rotation"), 1e-6)
        if shipped.control_points is not None:
            tolerances["control_points"] = 1e-5
        for key, share in tolerances.items():
            np.testing.assert_allclose(
                getattr(shipped, key), getattr(fresh, key), atol=share * length, err_msg=name
            )
        if plan.muscles:
            assert repertoire.provenance["warm_up_beats"][name] == beats


@pytest.mark.nightly
@pytest.mark.parametrize("turn", only(("cstart_left_wide",), TURNS))
def test_the_search_for_a_turn_finds_that_of_the_file(turn):
    """Of one fish that is quickly searched; the code that searches is part of every file."""
    repertoire = repertoire_of("hardyhead_silverside")
    found = search(motion_from_provenance(repertoire.provenance), turn, ROUNDS)
    assert found.bend == pytest.approx(repertoire.provenance["bends"][turn], abs=1e-6)
    seen, length = deformation(found.frames)[1:], repertoire.body_length_cm
    np.testing.assert_allclose(repertoire.segments[turn].nodes, seen, atol=1e-6 * length)


@cache
def trial_of(species: str, name: str) -> Trial:
    """The simulation that a segment was recorded from."""
    return run_trial(motion_from_provenance(repertoire_of(species).provenance), name)


@pytest.mark.nightly
@given(
    species=st.sampled_from([name for name in SPECIES if load_species(name).muscles]),
    number=st.integers(0, len(SEGMENTS) - 1),
    pose=st.tuples(*[st.floats(-1, 1)] * 4),
    place=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
)
def test_a_segment_replayed_from_any_pose_is_the_simulation_from_there(
    species, number, pose, place
):
    """The fish that swims on, or the manoeuvre, turned and moved, against the rows of the file."""
    assume(np.linalg.norm(pose) > 0.1)
    repertoire = repertoire_of(species)
    names = repertoire.recorded_names()
    name = names[number % len(names)]
    # Fins or a tow drive these: tests/biomechanics/test_rowing.py and test_coasting.py.
    assume(repertoire.segments[name].grade not in ("forward", "row", "coast"))
    motion = motion_from_provenance(repertoire.provenance)
    trial, turned = trial_of(species, name), matrix(np.array(pose) / np.linalg.norm(pose))
    frames = trial.frames @ turned.T + place
    if repertoire.segments[name].cyclic:
        steady = trial.state
        state = BodyState(steady.x @ turned.T + place, steady.v @ turned.T, steady.watch.copy())
        beat = steady_contraction(motion, name)
        frames = np.concatenate(
            [state.x[None].copy(), simulate(build_body(motion.body), state, beat)]
        )
    played = replay(repertoire.segments[name], *body_frame(frames[0]), 1)
    np.testing.assert_allclose(played, frames[1:], atol=1e-6 * repertoire.body_length_cm)
