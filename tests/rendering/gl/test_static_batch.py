"""Static batches: items chosen once for all views, drawn in one call a view."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.system import resource_path
from subsea.rendering.gl.item_levels import (
    HYSTERESIS,
    LARGE_PX,
    OUT_OF_SIGHT,
    levels_in_sight,
)
from subsea.rendering.gl.shaders import set_uniforms
from subsea.rendering.gl.static_batch import (
    LazyMesh,
    StaticBatch,
    StaticMesh,
    bounding_spheres,
)
from subsea.view.culling import view_arrays
from subsea.view.display_rigs import views_for
from subsea.view.levels import FADE_S
from subsea.view.rig import pose_from_angles

SIZE = (64, 64)
THRESHOLDS = np.array([300.0, 90.0])
WIDE = (1280, 720)
AHEAD = views_for("mono", WIDE, pose_from_angles(np.zeros(3), 0.0, 0.0))
BACK = views_for("mono", WIDE, pose_from_angles(np.zeros(3), np.pi, 0.0))
VERTEX = """
uniform mat4 u_view_projection;
in vec3 a_position;
void main() { gl_Position = u_view_projection * vec4(a_position, 1.0); }
"""
FRAGMENT = """
out vec4 f_colour;
#include "fades.glsl"
void main() {
    if (faded(u_fade)) discard;
    f_colour = vec4(1.0);
}
"""


def levels(distances, before, views=AHEAD, detail=1.0, radius=10.0, reach=1e9):
    centres = np.array([[x, 0.0, 0.0] for x in distances])
    radii = np.full(len(centres), radius)
    return levels_in_sight((centres, radii), views, reach, detail, THRESHOLDS, np.array(before))[0]


def quad(x, size, pieces):
    """An upright square that faces the origin, of `pieces`² squares, as a mesh."""
    line = np.linspace(-size, size, pieces + 1)
    y, z = np.meshgrid(line, line)
    vertices = np.stack([np.full(y.size, x), y.ravel(), z.ravel()], axis=1).astype(np.float32)
    at = np.arange(y.size).reshape(y.shape)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]
    return StaticMesh(vertices, np.stack([a, b, c, c, b, d], axis=-1).reshape(-1, 3))


@given(st.lists(st.floats(15.0, 5e4), min_size=2, max_size=20), st.floats(0.3, 1.0))
def test_less_detail_coarsens_what_is_small_and_nothing_that_is_large(distances, detail):
    new = [OUT_OF_SIGHT] * len(distances)
    full, less = levels(distances, new), levels(distances, new, detail=detail)
    shown = less != OUT_OF_SIGHT
    assert (less >= full)[shown].all()
    away = np.array(distances) - 10.0
    (scale,) = view_arrays(AHEAD).scales
    large = 20.0 * scale / np.maximum(away, 1.0) >= 2.0 * LARGE_PX
    assert (less == full)[large].all()


@given(st.lists(st.floats(15.0, 5e4), min_size=2, max_size=20))
def test_farther_is_never_finer(distances):
    near_to_far = np.sort(distances)
    level = levels(near_to_far, [OUT_OF_SIGHT] * len(near_to_far))
    level[level == OUT_OF_SIGHT] = 9
    assert (np.diff(level) >= 0).all()


@given(st.floats(15.0, 4000.0), st.sampled_from([0, 1, 2]))
def test_a_level_is_kept_while_the_size_trembles(distance, before):
    """Levels change only beyond the margin, so that jitter within it changes nothing."""
    first = levels([distance], [before])[0]
    trembling = (distance - 10.0) * (1 + 0.9 * HYSTERESIS) + 10.0
    again = levels([trembling], [first])[0]
    assert levels([distance], [again])[0] == again


def test_items_outside_all_views_or_hidden_by_water_are_out_of_sight():
    assert levels([-500.0], [0])[0] == OUT_OF_SIGHT
    assert levels([500.0], [0], reach=300.0)[0] == OUT_OF_SIGHT
    assert levels([-500.0], [0], views=(*AHEAD, *BACK))[0] != OUT_OF_SIGHT
    assert levels([2e5], [2])[0] == OUT_OF_SIGHT


def test_detail_acts_as_nearness():
    assert levels([110.0], [OUT_OF_SIGHT], detail=4.0) < levels([110.0], [OUT_OF_SIGHT], detail=0.2)


def test_a_sphere_holds_all_places():
    places = np.random.default_rng(1).normal(size=(50, 3))
    mesh = StaticMesh(places, np.zeros((0, 3), np.int32))
    (sphere,) = bounding_spheres([[mesh]])
    assert (np.linalg.norm(places - sphere[:3], axis=1) <= sphere[3] + 1e-12).all()


class OneProgram:
    """Stands in for ProgramVariants with a given white program."""

    def __init__(self, context, program):
        self.context, self._program = context, program

    def array(self, content, indices):
        self._array = self.context.vertex_array(self._program, content, indices)
        return self._array

    def ready(self, array, as_ids, wants=(), **uniforms):
        set_uniforms(self._program, **uniforms)
        return array

    def release(self):
        pass


@pytest.fixture
def drawn(context):
    """Draw items in the first of some views; white pixels and the number of triangles."""
    fades = resource_path("shaders/fades.glsl").read_text(encoding="utf-8")
    program = context.program(
        vertex_shader="#version 330\n" + VERTEX,
        fragment_shader="#version 330\n" + FRAGMENT.replace('#include "fades.glsl"', fades),
    )
    target = context.simple_framebuffer(SIZE)

    def drawn(batch, views, **options):
        target.use()
        target.clear()
        batch.choose(views, **options)
        view = views[0]
        both = (view.projection @ view.view).T.astype("f4")
        triangles = batch.draw(0, {"u_view_projection": np.ascontiguousarray(both).tobytes()})
        pixels = np.frombuffer(target.read(components=1), np.uint8).reshape(SIZE)
        return int((pixels > 0).sum()), triangles

    def make(shapes, *spheres):
        programs = OneProgram(context, program)
        return StaticBatch(programs, "3f4", "a_position", shapes, 1e5, THRESHOLDS, *spheres)

    yield make, drawn
    target.release()
    program.release()


def test_one_call_draws_each_item_at_its_own_level(drawn):
    make, draw = drawn
    pieces = (8, 4, 1)
    batch = make([[quad(x, 10.0, n) for n in pieces] for x in (30.0, 120.0, 500.0, -50.0)])
    pixels, triangles = draw(batch, AHEAD)
    assert triangles == 2 * sum(n * n for n in pieces)
    assert pixels > 150
    # Turned round, only the one behind is drawn, and nothing of the others.
    assert draw(batch, BACK)[1] == 2 * 8 * 8
    assert draw(batch, AHEAD)[1] == triangles
    assert draw(batch, AHEAD, shown=np.array([True, False, False, True]))[1] == 2 * 64
    batch.release()


def test_lazy_meshes_are_made_when_first_drawn_and_look_the_same(drawn):
    make, draw = drawn
    made = []

    def later(shape):
        return LazyMesh(
            lambda: made.append(shape.number) or shape.vertices, shape.number, shape.triangles
        )

    items = [[quad(x, 10.0, n) for n in (8, 4, 1)] for x in (30.0, 120.0, -50.0)]
    expected = draw(make(items), AHEAD)
    batch = make([[later(shape) for shape in levels] for levels in items], bounding_spheres(items))
    assert made == []
    assert draw(batch, AHEAD) == expected
    first = sorted(made)
    assert first == sorted([9 * 9, 5 * 5])  # neither the item behind nor other levels
    draw(batch, BACK)
    assert len(made) == 3
    assert draw(batch, AHEAD) == expected
    assert len(made) == 3
    batch.release()


def test_each_view_draws_what_it_sees_at_the_level_that_is_common_to_all(drawn):
    make, draw = drawn
    pieces = (8, 4, 1)
    batch = make([[quad(x, 10.0, n) for n in pieces] for x in (30.0, 120.0, 500.0, -50.0)])
    pixels, triangles = draw(batch, AHEAD)
    coarse = views_for("mono", (128, 72), pose_from_angles(np.zeros(3), 0.0, 0.0))
    assert draw(batch, coarse)[1] < triangles
    for views in ((*AHEAD, *BACK), (*AHEAD, *BACK, *coarse)):
        assert draw(batch, views) == (pixels, triangles)
        assert batch.draw(1, {}) == 2 * 8 * 8
    assert batch.draw(2, {}) == triangles  # as fine as the other view needs it
    batch.release()


def test_a_choice_apart_knows_nothing_of_earlier_ones_and_leaves_nothing(drawn):
    make, draw = drawn
    batch, fresh = (make([[quad(100.0, 10.0, n) for n in (8, 4, 1)]]) for _ in range(2))
    nearer = views_for("mono", WIDE, pose_from_angles(np.array([40.0, 0.0, 0.0]), 0.0, 0.0))
    for detail in np.geomspace(0.2, 5.0, 60):  # some between the two thresholds
        draw(batch, nearer, detail=8.0)
        kept = draw(batch, AHEAD, detail=detail)
        before = batch.recall()
        apart = draw(batch, AHEAD, detail=detail)
        assert apart == draw(fresh, AHEAD, detail=detail)
        batch.recall(before)
        assert draw(batch, AHEAD, detail=detail) == kept
        if apart != kept:
            break
        fresh.recall()
    assert apart != kept
    batch.release()
    fresh.release()


def test_a_change_of_level_fades_and_every_pixel_is_drawn_once(drawn):
    """A quad that covers the same pixels at each level: both together draw each of them once."""
    make, draw = drawn
    batch = make([[quad(200.0, 10.0, n) for n in (8, 4, 1)]])
    pixels, fine = draw(batch, AHEAD, detail=1.0, time_s=1.0)
    shares = []
    for picture in range(12):
        time_s = 1.0 + 0.04 * (picture + 1)
        now, triangles = draw(batch, AHEAD, detail=0.3, time_s=time_s)
        assert now == pixels
        shares.append(triangles)
    assert set(shares) == {fine + 2, 2}
    assert shares[-1] == 2  # within FADE_S
    assert shares.count(fine + 2) == round(FADE_S / 0.04 + 0.5)
    # A jump in time, or one of two levels, needs no fade.
    assert draw(batch, AHEAD, detail=1.0, time_s=9.0) == (pixels, fine)
    assert draw(batch, AHEAD, detail=0.3, time_s=8.0) == (pixels, 2)
    batch.release()


def test_each_level_has_its_share_of_the_pixels_in_a_fade(drawn):
    make, draw = drawn
    nothing = StaticMesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    same = quad(200.0, 10.0, 8)
    batch = make([[same, same, nothing]])
    whole, _ = draw(batch, AHEAD, time_s=1.0)
    parts = [draw(batch, AHEAD, detail=0.3, time_s=1.0 + 0.03 * (k + 1))[0] for k in range(12)]
    assert (np.diff(parts) <= 0).all()
    assert parts[0] > 0.9 * whole
    assert parts[-1] == 0
    assert max(-np.diff(parts)) < 0.2 * whole
    batch.release()


def test_an_empty_batch_draws_nothing(drawn):
    make, draw = drawn
    batch = make([])
    assert draw(batch, AHEAD) == (0, 0)
    batch.release()
