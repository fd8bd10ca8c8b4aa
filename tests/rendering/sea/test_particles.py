"""Specks in the water, as the vertex shader places and lights them."""

import numpy as np
import pytest

from subsea.habitat.stone import SUN
from subsea.rendering.gl.shaders import set_uniforms, source
from subsea.rendering.output.uniforms import light_uniforms
from subsea.rendering.sea.particles import PLANKTON_LOOK, SNOW_BOX_CM, SNOW_LOOK
from subsea.scenario.schema import Water
from subsea.view.display_rigs import views_for
from subsea.view.rig import pose_from_angles

NUMBER = 3000
WATER = Water(fog=(0.01, 0.1, 0.2), visibility_cm=1300.0)


@pytest.fixture(scope="module")
def specks(context):
    """Eye, uniforms to change -> colour and strength (n, 4), streak (n, 2), place (n, 4)."""
    compiled = context.program(
        vertex_shader=source("particles.vert"), varyings=["v_colour", "v_streak", "gl_Position"]
    )
    places = np.random.default_rng(3).uniform(size=(NUMBER, 3)).astype("f4")
    given = context.buffer(places.tobytes())
    out = context.buffer(reserve=40 * NUMBER)
    array = context.vertex_array(compiled, [(given, "3f4", "a_position")])
    target = context.simple_framebuffer((4, 4))

    def specks(eye=(0.0, 0.0, -600.0), **changed):
        (view,) = views_for("mono", (320, 180), pose_from_angles(np.array(eye), 0.4, 0.2))
        values = {
            "u_eye": eye,
            **light_uniforms(WATER, eye),
            "u_time": 5.0,
            "u_unit": 1.0,
            "u_projection": view.projection.T.astype("f4").tobytes(),
            "u_view_projection": (view.projection @ view.view).T.astype("f4").tobytes(),
            "u_size": (320.0, 180.0),
            "u_box": SNOW_BOX_CM,
            "u_drift": (3.0, 0.0, -1.5),
            "u_passing": (3.0, 0.0, -1.5),
            **SNOW_LOOK,
        }
        set_uniforms(compiled, **(values | changed))
        target.use()
        array.transform(out, vertices=NUMBER)
        records = np.frombuffer(out.read(), np.float32).reshape(NUMBER, 10).astype(float)
        return records[:, :4], records[:, 4:6], records[:, 6:]

    yield specks
    for held in (array, out, given, target, compiled):
        held.release()


@pytest.mark.parametrize("defines", [{}, {"CLOSE_UP": 1}])
def test_no_speck_is_a_large_disc_and_in_close_ups_none_is_a_square(context, defines):
    """However near the eye, at any resolution; one of a few pixels has room for a round shape."""
    compiled = context.program(
        vertex_shader=source("particles.vert", **defines),
        varyings=["v_colour", "v_radius", "gl_PointSize"],
    )
    places = np.random.default_rng(3).uniform(-60.0, 60.0, size=(NUMBER, 3)).astype("f4")
    places[:, 2] -= 300.0
    given = context.buffer(places.tobytes())
    out = context.buffer(reserve=24 * NUMBER)
    array = context.vertex_array(compiled, [(given, "3f4", "a_position")])
    (view,) = views_for("mono", (3840, 2160), pose_from_angles(np.array([0, 0, -300.0]), 0.4, 0.2))
    values = {
        "u_eye": (0.0, 0.0, -300.0),
        **light_uniforms(WATER, (0.0, 0.0, -300.0)),
        "u_projection": view.projection.T.astype("f4").tobytes(),
        "u_view_projection": (view.projection @ view.view).T.astype("f4").tobytes(),
        "u_size": (3840.0, 2160.0),
        **PLANKTON_LOOK,
    }
    set_uniforms(compiled, **values)
    target = context.simple_framebuffer((4, 4))
    target.use()
    array.transform(out, vertices=NUMBER)
    records = np.frombuffer(out.read(), np.float32).reshape(NUMBER, 6).astype(float)
    away = np.linalg.norm(places - (0.0, 0.0, -300.0), axis=1)
    seen = records[:, 3] > 0.0
    size, wide = records[:, 5], records[:, 4] * records[:, 5]
    assert size[seen].max() <= 40.0
    assert wide[seen].max() <= 20.01
    assert wide[seen].min() >= (2.99 if defines else 1.99)
    assert not seen[away < 11.9].any()
    for held in (array, out, given, target, compiled):
        held.release()


def test_a_speck_has_faded_before_the_box_moves_it_to_its_other_side(specks):
    before, _, here = specks((0.0, 0.0, -600.0))
    after, _, there = specks((4.0, 3.0, -600.0))
    jumped = np.linalg.norm(here - there, axis=1) > 100.0
    assert jumped.sum() > 10
    assert before[jumped, 3].max() == after[jumped, 3].max() == 0.0
    assert (before[:, 3] > 0.0).mean() > 0.3
    assert np.abs(before[:, 3] - after[:, 3]).max() < 0.3


def test_specks_are_drawn_out_by_speed_and_by_nothing_else(specks):
    _, still, _ = specks()
    np.testing.assert_allclose(still, 0.0, atol=1e-6)
    _, slow, place = specks(u_passing=(23.0, 0.0, -1.5))
    _, fast, _ = specks(u_passing=(203.0, 0.0, -1.5))
    ahead = place[:, 3] > 20.0
    assert (np.linalg.norm(fast, axis=1) >= np.linalg.norm(slow, axis=1) - 1e-6)[ahead].all()
    assert np.linalg.norm(fast, axis=1)[ahead].max() <= 1.0
    assert np.linalg.norm(fast, axis=1)[ahead].mean() > 0.2


def test_what_is_drawn_out_is_fainter(specks):
    still, _, place = specks()
    fast, _, _ = specks(u_passing=(150.0, 0.0, 0.0))
    seen = (still[:, 3] > 0.01) & (place[:, 3] > 20.0)
    assert (fast[seen, 3] <= still[seen, 3] + 1e-6).all()
    assert fast[seen, 3].mean() < 0.8 * still[seen, 3].mean()


def test_specks_toward_the_sun_are_brighter_and_none_is_above_the_surface(specks):
    for eye in ((0.0, 0.0, -600.0), (0.0, 0.0, -60.0)):
        colour, _, _ = specks(eye, u_drift=(0.0, 0.0, 0.0), u_time=0.0)
        rng = np.random.default_rng(3)
        share = rng.uniform(size=(NUMBER, 3)) * SNOW_BOX_CM
        ray = np.mod(share - eye, SNOW_BOX_CM) - SNOW_BOX_CM / 2
        above = ray[:, 2] + eye[2] > 0.01
        assert not colour[above, 3].any()
        look = ray / np.linalg.norm(ray, axis=1, keepdims=True)
        toward, away = look @ SUN > 0.6, look @ SUN < -0.6
        near = (np.linalg.norm(ray, axis=1) < 150.0) & ~above
        light = colour[:, :3].sum(axis=1)
        assert light[toward & near].mean() > 1.2 * light[away & near].mean()
