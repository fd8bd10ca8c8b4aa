"""What must hold for every species that has a file and for each segment of its repertoire.

A new species is covered as soon as its file and its repertoire are there.
"""

from functools import cache

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from capture.inspection.simulated import replay
from capture.recording.record import (
    motion_from_provenance,
    record_segment,
    side_of,
    steady_contraction,
)
from capture.recording.resume import is_up_to_date
from capture.recording.segment import heading_change
from capture.recording.trial import Trial, sharp_turn, steady_beat
from subsea.biomechanics.body import UNITS, build_body
from subsea.biomechanics.body_frame import body_frame, to_body
from subsea.biomechanics.simulation import BodyState, simulate
from subsea.biomechanics.solver import STRAIN_LIMITS, TICK_S
from subsea.core.resources import resource_names, resource_path
from subsea.fish.species import load_species, species_names
from subsea.geometry.rotation import matrix
from subsea.repertoire import SEGMENTS, Repertoire, Segment, read_repertoire

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
def test_a_repertoire_is_whole_and_that_of_its_species(species):
    repertoire, plan = repertoire_of(species), load_species(species)
    assert set(repertoire.segments) == set(SEGMENTS)
    assert repertoire.species == species
    assert repertoire.tick_s == TICK_S
    assert repertoire.source == ("biomechanics" if plan.muscles else "spine")
    assert repertoire.body_length_cm == plan.length_cm
    assert np.ptp(repertoire.rest_nodes[:, 0]) == pytest.approx(plan.length_cm)
    for name, segment in repertoire.segments.items():
        assert name.removeprefix("turn_").startswith(("swim", segment.pattern))
        assert name.endswith(segment.grade)
        assert segment.cyclic == (segment.grade != "sharp")
        # SMC §4.1 spends memory on schools; what a spine moves may have no other skin.
        if plan.muscles or plan.schooling:
            assert (segment.control_points is not None) == plan.schooling


@each_species
def test_rows_are_finite_unit_and_in_body_axes(species):
    for name, segment in repertoire_of(species).segments.items():
        turns = segment.increment_rotation
        for values in (turns, segment.increment_translation, segment.nodes):
            assert np.isfinite(values).all(), name
            assert len(values) == len(segment.nodes), name
        lengths = np.linalg.norm(turns, axis=1)
        np.testing.assert_allclose(lengths, 1, atol=1e-9, err_msg=name)
        origin, rotation = body_frame(segment.nodes)
        still = np.broadcast_to(np.eye(3), rotation.shape)
        np.testing.assert_allclose(origin, 0, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(rotation, still, atol=1e-9, err_msg=name)


@each_species
def test_no_unit_is_strained_beyond_its_limits(species):
    """Units of muscle-driven fishes; a spine has none, but keeps the body's length."""
    repertoire = repertoire_of(species)
    rest, (i, j) = repertoire.rest_nodes, UNITS.T
    at_rest = np.linalg.norm(rest[j] - rest[i], axis=1)
    low, high = STRAIN_LIMITS if repertoire.source == "biomechanics" else (0.5, 1.8)
    for name, segment in repertoire.segments.items():
        nodes = segment.nodes
        strain = np.linalg.norm(nodes[:, j] - nodes[:, i], axis=2) / at_rest
        assert low <= strain.min(), name
        assert strain.max() <= high, name
        assert np.ptp(strain) > 0.001, name  # it does move


@each_species
def test_all_stays_near_and_no_node_leaps(species):
    length = repertoire_of(species).body_length_cm
    for name, segment in repertoire_of(species).segments.items():
        radius = np.linalg.norm(segment.nodes, axis=2).max() / length
        assert radius <= segment.bounding_radius_bl * (1 + 1e-9), name
        assert segment.bounding_radius_bl < 1, name
        steps = np.diff(world(segment, 2 if segment.cyclic else 1), axis=0)
        assert np.linalg.norm(steps, axis=2).max() < 0.12 * length, name


@each_species
def test_a_cycle_is_closed_and_a_sharp_turn_begins_and_ends_in_swimming(species):
    repertoire = repertoire_of(species)
    swim = repertoire.segments["swim_medium"].nodes
    for name, segment in repertoire.segments.items():
        nodes = segment.nodes
        if segment.cyclic:
            assert segment.loop_error_bl <= 1e-3, name
            # From the last row to the first is a step like any other.
            inside = np.linalg.norm(np.diff(nodes, n=2, axis=0), axis=2).max()
            across = np.concatenate([nodes[-2:], nodes[:2]])
            jump = np.linalg.norm(np.diff(across, n=2, axis=0), axis=2).max()
            assert jump <= 1.5 * inside, name
            continue
        for row in (nodes[0], nodes[-1]):
            gap = np.linalg.norm(swim - row, axis=2).max(axis=1).min()
            assert gap < 0.1 * repertoire.body_length_cm, name


@each_species
def test_attributes_agree_with_the_rows(species):
    for name, segment in repertoire_of(species).segments.items():
        origin, rotation = np.zeros((1, 3)), np.eye(3)
        turns = matrix(segment.increment_rotation)
        for turn, step in zip(turns, segment.increment_translation, strict=True):
            origin = np.concatenate([origin, [origin[-1] + rotation @ step]])
            rotation = rotation @ turn
        way = origin[[0, -1]] if segment.cyclic else origin
        distance = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
        speed = distance / (len(segment.nodes) * TICK_S)
        turned = heading_change(np.eye(3), rotation)
        assert segment.speed_cm_s == pytest.approx(speed), name
        assert segment.turn_deg == pytest.approx(turned, abs=1e-6), name


@each_species
def test_a_faster_grade_is_faster(species):
    repertoire = repertoire_of(species)
    slow, medium, fast = (repertoire.segments[name].speed_cm_s for name in SWIMS)
    ratio = 1.4 if repertoire.source == "biomechanics" else 1.1
    assert slow > 0
    assert medium >= ratio * slow
    assert fast >= ratio * medium


@each_species
def test_swims_are_straight_and_turns_turn_to_their_side(species):
    turn = {name: segment.turn_deg for name, segment in repertoire_of(species).segments.items()}
    assert max(abs(turn[name]) for name in SWIMS) < 0.05
    for side, sign in (("left", 1), ("right", -1)):
        gradual, sharp = sign * turn[f"turn_{side}_gradual"], sign * turn[f"turn_{side}_sharp"]
        assert 2 < gradual < 25
        assert 25 < sharp < 100
        assert gradual < sharp


@each_species
def test_left_is_the_mirror_of_right(species):
    repertoire = repertoire_of(species)
    segments, length = repertoire.segments, repertoire.body_length_cm
    for grade in ("gradual", "sharp"):
        left, right = (world(segments[f"turn_{side}_{grade}"]) for side in ("left", "right"))
        mirrored = right[:, MIRROR] * (1, 1, -1)
        # Frame B leans on nodes 5, 6 and 7: compare both in the frame that each begins with.
        seen = [
            to_body(path, *(part[None] for part in body_frame(path[0])))
            for path in (left, mirrored)
        ]
        assert np.ptp(seen[0][:, 0], axis=0).max() > 0.1 * length, grade
        np.testing.assert_allclose(seen[1], seen[0], atol=1e-5 * length, err_msg=grade)


@each_species
def test_the_provenance_is_the_species_file_and_records_the_same_rows(species):
    """A body, gait or outline that was edited must be recorded again."""
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
        fresh, beats = record_segment(rebuilt, name)
        tolerances = dict.fromkeys(("increment_translation", "nodes", "increment_rotation"), 1e-6)
        if shipped.control_points is not None:
            tolerances["control_points"] = 1e-5
        for key, share in tolerances.items():
            np.testing.assert_allclose(
                getattr(shipped, key), getattr(fresh, key), atol=share * length, err_msg=name
            )
        if plan.muscles:
            assert repertoire.provenance["warm_up_beats"][name] == beats


@cache
def start_of(species: str, name: str) -> Trial:
    """Steady swimming at the moment at which the segment begins."""
    motion = motion_from_provenance(repertoire_of(species).provenance)
    return steady_beat(build_body(motion.body), steady_contraction(motion, name))


@given(
    species=st.sampled_from([name for name in SPECIES if load_species(name).muscles]),
    name=st.sampled_from(SEGMENTS),
    pose=st.tuples(*[st.floats(-1, 1)] * 4),
    place=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
)
def test_a_segment_replayed_from_any_pose_is_the_simulation_from_there(species, name, pose, place):
    """The fish that swims on, turned and moved, against the rows of the file."""
    assume(np.linalg.norm(pose) > 0.1)
    repertoire = repertoire_of(species)
    motion = motion_from_provenance(repertoire.provenance)
    body, steady = build_body(motion.body), start_of(species, name).state
    turned = matrix(np.array(pose) / np.linalg.norm(pose))
    state = BodyState(steady.x @ turned.T + place, steady.v @ turned.T, steady.watch.copy())
    played = replay(repertoire.segments[name], *body_frame(state.x), 1)
    if name.endswith("sharp"):
        turn = motion.turn
        frames = sharp_turn(body, motion.swim, turn, turn.sharp, side_of(name), state).frames
        swum = frames[1:]
    else:
        swum = simulate(body, state, steady_contraction(motion, name))
    np.testing.assert_allclose(played, swum, atol=1e-6 * repertoire.body_length_cm)


@pytest.mark.parametrize("name", species_names())
def test_what_is_shipped_is_what_this_program_records(name: str) -> None:
    """After a change of what swims and records: `subsea-capture record --all`."""
    assert is_up_to_date(resource_path("repertoires"), name, load_species(name))
