"""Segments recorded from a spine."""

import dataclasses
from functools import cache

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from capture.cli.main import main
from capture.inspection.simulated import replay
from capture.recording.record import record_segment, record_species
from capture.recording.spine_motion import spine_motion
from capture.recording.spine_water import stride_of
from subsea.biomechanics.body import to_world
from subsea.fish.species import load_species, species_names
from subsea.fish.spine import SpinePlan, Turn
from subsea.geometry.rotation import matrix
from subsea.repertoire import BASIC_SEGMENTS, write_repertoire
from tests.support.spines import by_rules

OTHER_TURN = {"gradual": 30.0, "sharp": 30.0, "sharp_beats": 6}
OLD_GAITS = {
    "slow": {"ticks_per_beat": 38, "amplitude": 0.82, "slip": 0.48},
    "medium": {"ticks_per_beat": 28, "amplitude": 0.92, "slip": 0.55},
    "fast": {"ticks_per_beat": 20, "amplitude": 1.0, "slip": 0.62},
    "burst": None,
}
NAMES = [name for name in species_names() if load_species(name).spine]


@pytest.fixture(scope="module", params=NAMES)
def species(request):
    return by_rules(request.param)


def test_recorded_motion_is_that_of_the_plan_and_symmetric(species):
    recorded = {name: record_segment(species, name)[0] for name in BASIC_SEGMENTS}
    plan, mirror = species.spine, np.array([1.0, 1.0, -1.0])
    for segment in recorded.values():
        if segment.cyclic:
            assert segment.loop_error_bl < 1e-9
        assert segment.control_points.shape == (len(segment.nodes), 426, 3)
        assert np.isfinite(segment.control_points).all()
        far = np.linalg.norm(segment.control_points, axis=2).max() / species.length_cm
        assert far <= segment.bounding_radius_bl + 1e-9 < 1.2
    for grade in ("gradual", "sharp"):
        left, right = (recorded[f"turn_{side}_{grade}"] for side in ("left", "right"))
        assert left.turn_deg == pytest.approx(getattr(plan.turn, grade), abs=1e-6)
        assert right.turn_deg == pytest.approx(-left.turn_deg, abs=1e-9)
        np.testing.assert_allclose(
            right.increment_translation, left.increment_translation * mirror, atol=1e-9
        )
        # The halves of the surface, and the fins in the plane of symmetry.
        a, b = left.control_points, right.control_points * mirror
        swapped = np.concatenate([b[:, 189:378], b[:, :189], b[:, 378:]], axis=1)
        np.testing.assert_allclose(a, swapped, atol=1e-5)
    for grade in ("slow", "medium", "fast"):
        gait, segment = getattr(plan, grade), recorded[f"swim_{grade}"]
        way = segment.increment_translation.sum(axis=0)
        assert len(segment.nodes) == gait.ticks_per_beat
        np.testing.assert_allclose(
            way, [stride_of(plan, species.surface, gait) * plan.length, 0, 0], atol=1e-9
        )


@cache
def recorded_and_planned(name):
    species = by_rules(NAMES[0])
    nodes = spine_motion(species.spine, species.surface, name).nodes
    return record_segment(species, name)[0], nodes


@given(st.integers(0, 2**32 - 1), st.sampled_from(BASIC_SEGMENTS))
def test_replay_from_any_pose_equals_the_recorded_motion(seed, name):
    segment, nodes = recorded_and_planned(name)
    rng = np.random.default_rng(seed)
    q = rng.normal(size=4)
    rotation = matrix(q / np.linalg.norm(q))
    origin = rng.uniform(-500, 500, 3)
    start = 0.5 * (nodes[0, 5] + nodes[0, 7])
    expected = to_world(nodes[1:] - start, origin, rotation)
    np.testing.assert_allclose(replay(segment, origin, rotation, 1), expected, atol=1e-6)


def test_linear_swing_moves_differently_from_sinusoidal(species):
    plan = species.spine
    linear = msgspec.structs.replace(
        plan, swing=msgspec.structs.replace(plan.swing, function="linear")
    )
    a, b = (spine_motion(one, species.surface, "swim_fast").points for one in (plan, linear))
    assert 0.001 * plan.length < np.abs(a - b).max() < 0.1 * plan.length


def test_inspect_compares_with_the_plan_of_an_old_species(tmp_path, capsys):
    """One with slips, which has neither water nor manoeuvres."""
    name = NAMES[0]
    path = tmp_path / f"{name}.h5"
    eel = by_rules(name)
    old = msgspec.convert(msgspec.to_builtins(eel.spine) | OLD_GAITS, SpinePlan)
    repertoire = record_species(name, msgspec.structs.replace(eel, spine=old))
    assert set(repertoire.segments) == set(BASIC_SEGMENTS)
    write_repertoire(path, repertoire)
    assert main(["inspect", str(path)]) == 0
    told = capsys.readouterr().out
    assert "from spine" in told
    assert "replayed against the plan" in told
    other = msgspec.structs.replace(old, turn=msgspec.convert(OTHER_TURN, Turn))
    foreign = repertoire.provenance | {"spine": msgspec.to_builtins(other)}
    write_repertoire(path, dataclasses.replace(repertoire, provenance=foreign))
    assert main(["inspect", str(path)]) == 1
    write_repertoire(path, dataclasses.replace(repertoire, provenance={}))
    assert main(["inspect", str(path)]) == 2
    assert "holds no plans" in capsys.readouterr().err


def test_absurd_spines_are_refused_in_one_line():
    plan = msgspec.to_builtins(by_rules("ribbon_eel").spine) | OLD_GAITS
    gait = {"ticks_per_beat": 20, "amplitude": 1.0, "slip": 0.9}
    muscles = msgspec.to_builtins(load_species("ribbon_eel").spine.muscles)
    for changes, words in (
        ({"length": 1.0}, "length"),
        ({"centre": 1.0}, "centre"),
        ({"slow": gait}, "faster than the one"),
        ({"slow": gait | {"ticks_per_beat": 4, "slip": 0.1}}, "ticks_per_beat"),
        ({"fast": gait | {"slip": 1.0}}, "slip"),
        ({"medium": {"ticks_per_beat": 30, "amplitude": 1.0}}, "a slip or none"),
        ({"turn": OTHER_TURN | {"sharp_beats": 1}}, "sharp_beats"),
        ({"turn": OTHER_TURN | {"sharp": 0.0}}, "sharp"),
        ({"wing": {}}, "wing"),
        ({"muscles": muscles}, "without slip"),
        ({"muscles": muscles | {"rings": 4}}, "rings"),
    ):
        with pytest.raises(msgspec.ValidationError, match=words) as caught:
            msgspec.convert(plan | changes, SpinePlan)
        assert "\n" not in str(caught.value)
