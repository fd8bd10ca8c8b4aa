"""Air bubbles on their way to the surface."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.habitat.plankton import terminal_speed
from subsea.rendering.gl.shaders import set_uniforms, source
from subsea.rendering.output.quality import PRESETS
from subsea.rendering.sea.particles import STREAM_CM, in_sight, slots, stream
from subsea.view.display_rigs import views_for
from subsea.view.rig import pose_from_angles

FOOT = (10.0, -20.0, -500.0)
SIZE_CM = 1.5
LOW = replace(PRESETS["low"], snow=0)


@pytest.fixture(scope="module")
def places(context):
    """World time and current -> middles (n, 3) of a vent's bubbles, by the vertex shader."""
    compiled = context.program(vertex_shader=source("bubbles.vert"), varyings=["v_world"])
    records = slots(FOOT, 4.0, SIZE_CM, 0)
    given = context.buffer(records.tobytes())
    out = context.buffer(reserve=12 * len(records))
    array = context.vertex_array(compiled, [(given, "4f4 4f4 /v", "a_vent", "a_slot")])
    target = context.simple_framebuffer((4, 4))
    unit = np.eye(4, dtype="f4").tobytes()

    def places(time_s, current=(0.0, 0.0)):
        set_uniforms(
            compiled,
            u_time=time_s,
            u_current=current,
            u_eye=(0.0, 0.0, -300.0),
            u_view=unit,
            u_projection=unit,
            u_view_projection=unit,
            u_size=(320.0, 180.0),
        )
        target.use()
        array.transform(out, vertices=len(records))
        return np.frombuffer(out.read(), np.float32).reshape(-1, 3).copy()

    yield places
    for held in (array, out, given, target, compiled):
        held.release()


def test_bubbles_rise_without_a_stop_and_start_again_at_the_vent(places):
    times = np.arange(40.0, 70.0, 0.1)
    heights = np.array([places(t)[:, 2] for t in times])
    steps = np.diff(heights, axis=0)
    started_again = steps < -100.0
    assert (steps[~started_again] > 0.0).all()
    assert started_again.any(axis=0).all()
    # A bubble that starts again has reached the surface before, and is at the foot now.
    assert (heights[:-1][started_again] > 0.0).all()
    assert (heights[1:][started_again] < FOOT[2] + 10.0).all()


def test_they_gather_speed_up_to_that_of_their_size(places):
    times = np.arange(50.0, 54.0, 0.1)
    before, after = (np.array([places(t + s)[:, 2] for t in times]) for s in (0.0, 0.05))
    speed = (after - before) / 0.05
    young, old = (before > FOOT[2]) & (before < FOOT[2] + 0.3), before > FOOT[2] + 30.0
    speeds = terminal_speed(SIZE_CM * np.linspace(0.22, 1.0, 200))
    slowest, fastest = speeds.min(), speeds.max()
    rising = old & (after > before)
    assert (speed[rising] > 0.98 * slowest).all()
    assert (speed[rising] < 1.02 * fastest).all()
    assert young.sum() >= 3
    assert speed[young].max() < 0.7 * slowest


def test_the_current_carries_them(places):
    still, carried = places(50.0), places(50.0, (5.0, -2.0))
    moved = carried - still
    # They drift as far as the water since they left, whatever their speed.
    later = places(50.1)
    rose = later[:, 2] > still[:, 2]
    assert rose.sum() > 0.9 * len(rose)
    farther = places(50.1, (5.0, -2.0)) - later - moved
    np.testing.assert_allclose(farther[rose, 0], 0.5, atol=1e-3)
    np.testing.assert_allclose(moved[:, 1], -0.4 * moved[:, 0], atol=1e-3)
    assert moved[:, 0].max() > 30.0
    np.testing.assert_allclose(moved[:, 2], 0.0)


def test_speeds_are_those_that_were_measured():
    """Clift, Grace and Weber: 23 cm/s from 4 to 8 mm, 31 cm/s at 2 cm; a millimetre is slow."""
    np.testing.assert_allclose(terminal_speed(np.array([0.4, 0.6, 0.8])), 24.0, atol=1.5)
    assert float(terminal_speed(2.0)) == pytest.approx(32.5, abs=1.5)
    assert float(terminal_speed(0.05)) < 15.0


@given(rate=st.floats(0.5, 60.0), size=st.floats(0.1, 5.0), depth=st.floats(100.0, 3000.0))
def test_a_slot_is_free_before_its_next_bubble(rate, size, depth):
    records = slots((0.0, 0.0, -depth), rate, size, 1)
    slowest = terminal_speed(size * np.linspace(0.22, 1.0, 99)).min()
    assert (records[:, 5] > depth / slowest + 0.25).all()
    assert len(records) == pytest.approx(rate * records[0, 5], rel=1e-4)
    assert np.all(np.diff(records[:, 4]) > 0.0)


def test_a_stream_is_drawn_where_some_of_it_may_be_seen(places):
    ends = stream(slots(FOOT, 4.0, SIZE_CM, 0), (3.0, 0.0))
    found = places(50.0, (3.0, 0.0))
    found = found[found[:, 2] < 0.0]
    way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    off = np.cross(found - ends[0], way)
    assert np.linalg.norm(off, axis=1).max() < STREAM_CM
    eye = np.array([-300.0, -20.0, -250.0])
    for heading, seen in ((0.0, True), (np.pi, False), (1.0, False)):
        (view,) = views_for("mono", (320, 180), pose_from_angles(eye, heading, 0.0))
        assert in_sight(ends[None], view.planes, eye, 900.0) == [seen]
    (view,) = views_for("mono", (320, 180), pose_from_angles(eye, 0.0, 0.0))
    assert not in_sight(ends[None], view.planes, eye, 200.0)


def test_only_vents_in_sight_are_drawn(counted, scene, make_packet):
    vents = np.array([(0.0, 150.0, 5.0, 2.0), (0.0, -150.0, 5.0, 2.0)])
    packet = make_packet([], size=(160, 90), time_s=60.0)
    pictures, triangles = zip(
        *(
            counted(packet, scene=replace(scene, vents=kept), quality=LOW)
            for kept in (vents[:0], vents[:1], vents[1:], vents)
        ),
        strict=True,
    )
    none, ahead, behind, both = pictures
    assert np.abs(ahead - none).max() > 20
    np.testing.assert_array_equal(behind, none)
    np.testing.assert_array_equal(both, ahead)
    assert triangles[1] == triangles[3] > triangles[0] == triangles[2]


def test_no_glint_burns_out_wherever_in_the_picture_its_bubble_is(drawn, scene, make_packet):
    """Small bubbles would be white blocks, as a glint fills all pixels that are blended with it."""
    kept = replace(scene, vents=np.array([(0.0, 90.0, 30.0, 3.0)]))
    for heading in (0.5, 0.25, 0.0, -0.25, -0.5):
        packet = make_packet([], heading=np.pi / 2 + heading, time_s=60.0)
        bare = drawn(packet, scene=replace(scene, vents=kept.vents[:0]), quality=LOW)
        picture = drawn(packet, scene=kept, quality=LOW)
        bubbles = np.abs(picture - bare).max(axis=2) > 12  # without bright sand
        assert bubbles.sum() > 20
        assert picture.min(axis=2)[bubbles].max() <= 235


def test_a_current_that_turns_while_diving_is_that_of_bubbles_and_snow(drawn, scene, make_packet):
    """The picture equals one of a scene that had it from the start."""
    vents = np.array([[0.0, 120.0, 40.0, 3.0]], np.float32)
    still = replace(scene, vents=vents)
    flowing = replace(still, water=msgspec.structs.replace(still.water, current_cm_s=(14.0, 0.0)))
    packet = make_packet([], size=(240, 135), time_s=50.0)
    before, wanted = drawn(packet, scene=still), drawn(packet, scene=flowing)
    found = drawn(replace(packet, current_cm_s=(14.0, 0.0)), scene=still)
    np.testing.assert_array_equal(found, wanted)
    assert np.abs(wanted - before).max() > 20
