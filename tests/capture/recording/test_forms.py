"""Repertoires of flatfishes, which lie, and of boxfishes, which are stiff."""

import numpy as np
import pytest
from msgspec import structs

from capture.recording import boxfish, flatfish
from capture.recording.fingerprint import fingerprint
from capture.recording.forms import assemble, record_segment, segments_of
from subsea.biomechanics.body import body_frame, build_body
from subsea.biomechanics.rowing import RowPlan
from subsea.biomechanics.trial import displacement, grade_contraction, steady_beat
from subsea.fish.forms import couple_surface, lay, lay_nodes
from subsea.fish.skinning import couple, place
from subsea.fish.species import load_species
from subsea.fish.surface import rest_control_points
from subsea.geometry.rotation import matrix
from subsea.repertoire.schema import BASIC_SEGMENTS


@pytest.fixture(scope="module")
def tang():
    return load_species("blue_tang")


@pytest.fixture(scope="module")
def flat(tang):
    return structs.replace(tang, form="flatfish", row=None)


@pytest.fixture(scope="module")
def box(tang):
    return structs.replace(tang, form="boxfish", row=RowPlan(ticks_per_stroke=12))


@pytest.fixture(scope="module")
def swim(flat):
    return record_segment(flat, "swim_medium").segment


def headings(segment):
    """Heading (T,) after each row, degrees, left positive; and the axes ahead (T, 3)."""
    axes, now = [], np.eye(3)
    for turn in matrix(segment.increment_rotation):
        now = now @ turn
        axes.append(now)
    ahead = np.array(axes)[:, :, 0]
    return np.degrees(np.unwrap(np.arctan2(-ahead[:, 2], ahead[:, 0]))), ahead


def test_a_lying_body_is_the_upright_one_on_its_side(tang):
    rest = build_body(tang.body).rest
    lying = lay_nodes(rest)
    origin, rotation = body_frame(lying)
    np.testing.assert_allclose(rotation, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(origin, 0.0, atol=1e-12)
    assert np.ptp(lying[:, 1]) == pytest.approx(np.ptp(rest[:, 2]))  # as high as it was wide
    # A rotation keeps the handedness; the right flank looks up.
    np.testing.assert_allclose(lay(np.eye(3)), [[1, 0, 0], [0, 0, -1], [0, 1, 0]])


def test_the_skin_of_a_lying_body_is_the_upright_one_on_its_side(tang):
    length, rest = tang.length_cm, build_body(tang.body).rest
    upright = couple("sections", rest, rest_control_points(tang.surface, length, rest[0, 0]))
    lying = couple_surface("flatfish", tang.surface, length, lay_nodes(rest))
    bent = rest + np.random.default_rng(1).normal(0.0, 0.2, rest.shape)
    np.testing.assert_allclose(place(lying, lay_nodes(bent)), lay(place(upright, bent)), atol=1e-9)


def test_a_flatfish_undulates_up_and_down_as_its_upright_body_does_aside(flat, tang, swim):
    upright = steady_beat(build_body(tang.body), grade_contraction(tang.swim, "medium")).frames
    speed = np.linalg.norm(displacement(upright)) / (len(upright) - 1) / 0.033
    assert swim.speed_cm_s == pytest.approx(speed, rel=1e-3)
    assert swim.loop_error_bl < 1e-6 and abs(swim.turn_deg) < 1e-6
    reach = np.ptp(swim.control_points, axis=0)
    assert reach[:, 1].max() > 0.1 * tang.length_cm  # up and down
    assert reach[:, 2].max() < 0.02 * tang.length_cm  # hardly aside
    # The frame does not pitch with the beat: each row carries it equally far.
    steps = swim.increment_translation
    np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-6)
    np.testing.assert_allclose(swim.increment_rotation[:, 0], 1.0, atol=1e-9)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_flatfish_turns_level_to_both_sides(flat, swim, side):
    sign = 1.0 if side == "left" else -1.0
    gradual = record_segment(flat, f"turn_{side}_gradual").segment
    assert gradual.turn_deg == pytest.approx(sign * flatfish.GRADUAL_DEG, abs=0.01)
    assert gradual.loop_error_bl < 1e-6 and len(gradual.nodes) == len(swim.nodes)
    sharp = record_segment(flat, f"turn_{side}_sharp").segment
    heading, ahead = headings(sharp)
    assert heading[-1] == pytest.approx(sign * flatfish.SHARP_DEG, abs=0.1)
    assert (sign * np.diff(heading) > -1e-6).all() and np.abs(ahead[:, 1]).max() < 1e-6
    # It begins and ends straight: as in the swim.
    for row in (0, -1):
        np.testing.assert_allclose(sharp.nodes[row, 5:9], swim.nodes[row, 5:9], atol=0.05)


def test_a_boxfish_is_stiff_and_faster_by_faster_strokes(box):
    speeds = []
    for grade in ("slow", "medium", "fast", "burst"):
        segment = record_segment(box, f"swim_{grade}").segment
        speeds.append(segment.speed_cm_s)
        rest = np.broadcast_to(build_body(box.body).rest, segment.nodes.shape)
        np.testing.assert_allclose(segment.nodes, rest, atol=1e-9)
    assert (np.diff(speeds) > 0).all()
    stop = record_segment(box, "swim_stop").segment
    ways = np.linalg.norm(stop.increment_translation, axis=1)
    assert (np.diff(ways) < 0).all() and ways[-1] < 0.2 * ways[0] and len(ways) < 100
    start = record_segment(box, "swim_start").segment
    last = np.linalg.norm(start.increment_translation, axis=1)[-6:]  # a quick stroke
    assert 0.9 < last.mean() / (0.033 * speeds[1]) < 1.3


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_boxfish_turns_to_both_sides(box, side):
    sign = 1.0 if side == "left" else -1.0
    for grade, degrees in (("gradual", boxfish.GRADUAL_DEG), ("sharp", boxfish.SHARP_DEG)):
        segment = record_segment(box, f"turn_{side}_{grade}").segment
        assert segment.turn_deg == pytest.approx(sign * degrees, abs=0.01)


def test_each_form_has_its_segments_and_its_fingerprint(tang, flat, box):
    for species in (flat, box):
        names = segments_of(species)
        assert set(BASIC_SEGMENTS) < set(names) and "cstart_left_wide" not in names
    assert "row_forward" in segments_of(box) and "row_forward" not in segments_of(flat)
    assert len({fingerprint(one) for one in (tang, flat, box)}) == 3
    swim = record_segment(box, "swim_medium")
    made = assemble("crate", box, {"swim_medium": swim})
    assert made.source == "boxfish" and made.segments == {"swim_medium": swim.segment}
    lying = assemble("sole", flat, {})
    assert lying.source == "flatfish"
    np.testing.assert_allclose(lying.rest_nodes, lay_nodes(build_body(tang.body).rest))
