"""Culling: visibility and projected size."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.system import resource_path
from subsea.fish.mesh import BODY, DETAILS, FIN, fish_mesh, species_vertices, surface_points
from subsea.fish.skinning import couple, place
from subsea.fish.species import load_species
from subsea.fish.surface import rest_control_points
from subsea.frame.packet import ENLARGED
from subsea.geometry.rotation import matrix
from subsea.repertoire import read_repertoire
from subsea.view.culling import OUT_OF_SIGHT, coverage, pixels_per_radian, view_arrays
from subsea.view.display_rigs import DISPLAYS, views_for
from subsea.view.rig import pose_from_angles

EYE = np.array([0.0, 0.0, -300.0])


def _views(heading=0.0, pitch=0.0, display="mono"):
    return views_for(display, (640, 360), pose_from_angles(EYE, heading, pitch))


def _pixels(centres, views, *, radius=15.0, **options):
    return _covered(centres, views, radius=radius, **options)[0]


def _covered(centres, views, *, radius=15.0, **options):
    centres = np.atleast_2d(np.asarray(centres, np.float32))
    n = len(centres)
    radii, lengths = np.full(n, radius, np.float32), np.full(n, 20.0, np.float32)
    return coverage(centres, radii, lengths, view_arrays(views), **options)


def _inside(points, view):
    """Mask of the points (..., 3) that are in a view."""
    matrix = view.projection.astype(float) @ view.view.astype(float)
    clip = np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1) @ matrix.T
    return (np.abs(clip[..., :3]) < clip[..., 3:]).all(axis=-1)


@given(
    seed=st.integers(0, 2**32 - 1), heading=st.floats(-3, 3), pitch=st.floats(-1, 1),
    display=st.sampled_from(DISPLAYS),
)  # fmt: skip
def test_whatever_could_show_is_kept(seed, heading, pitch, display):
    """A sphere with any point of its surface in a view is not culled from that view."""
    rng = np.random.default_rng(seed)
    views = _views(heading, pitch, display)
    centres = EYE + rng.normal(0, 200, (200, 3))
    pixels, distance = _covered(centres, views)
    spots = rng.normal(size=(60, 3))
    spots *= 15.0 / np.linalg.norm(spots, axis=1, keepdims=True)
    for view, away in zip(views, distance, strict=True):
        seen = _inside(centres[:, None] + spots, view).any(axis=1)
        assert (pixels[seen] > 0).all()
        np.testing.assert_allclose(
            away[seen], np.linalg.norm(centres[seen] - view.eye, axis=1), rtol=1e-5
        )
    np.testing.assert_array_equal(pixels > 0, np.isfinite(distance).any(axis=0))


@pytest.fixture(scope="module")
def drawn():
    """Vertices of several poses of several species, body lengths about the origin, and radii."""
    out = []
    mesh = fish_mesh(DETAILS[0])
    smooth = np.isin(mesh.vertices[:, 12], [BODY, FIN])
    for name in ("fusilier", "emperor_angelfish", "blacktip_reef_shark", "spotted_eagle_ray"):
        species = load_species(name)
        repertoire = read_repertoire(resource_path(f"repertoires/{name}.h5"))
        own = species_vertices(species.surface, mesh, DETAILS[0])
        shown = smooth & (own[:, 2] >= 0)
        radius = max(s.bounding_radius_bl for s in repertoire.segments.values())
        for segment in repertoire.segments.values():
            for points in _poses(species, repertoire, segment):
                at = surface_points(points, mesh.vertices[shown], own[shown, 2].astype(int))
                out.append((at / repertoire.body_length_cm, radius))
    return out


def _poses(species, repertoire, segment):
    """Control points (426, 3) of two moments of a segment."""
    moments = [0, len(segment.nodes) // 2]
    if segment.control_points is not None:
        return segment.control_points[moments]
    rest = rest_control_points(
        species.surface, repertoire.body_length_cm, repertoire.rest_nodes[0, 0]
    )
    return place(couple("sections", repertoire.rest_nodes, rest), segment.nodes[moments])


@given(
    which=st.integers(0, 10**6), turn=st.tuples(*[st.floats(-1, 1)] * 4),
    at=st.tuples(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2), st.floats(8, 900)),
    length=st.floats(8, 150), display=st.sampled_from(["mono", "side-by-side", "dome"]),
)  # fmt: skip
def test_no_fish_with_a_visible_vertex_is_culled(drawn, which, turn, at, length, display):
    """Nothing pops at the edges of a picture, for any species and pose."""
    places, radius = drawn[which % len(drawn)]
    quaternion = np.array(turn) + [1.5, 0, 0, 0]
    R = matrix(quaternion / np.linalg.norm(quaternion))
    views = _views(display=display)
    ahead, aside, up = at[2], at[0] * at[2], at[1] * at[2]  # many are about the edges
    centre = EYE + [ahead, aside, 0.6 * up]
    vertices = centre + length * places @ R.T
    radii, lengths = np.float32([[ENLARGED * radius * length], [length]])
    _, distance = coverage(centre[None].astype("f4"), radii, lengths, view_arrays(views))
    for view, (away,) in zip(views, distance, strict=True):
        if _inside(vertices, view).any():
            assert np.isfinite(away)


def test_most_invisible_things_are_culled():
    rng = np.random.default_rng(1)
    pixels = _pixels(EYE + rng.normal(0, 500, (5000, 3)), _views())
    assert (pixels == OUT_OF_SIGHT).mean() > 0.8  # the frustum is about a ninth of all directions


def test_things_hidden_by_fog_are_left_out():
    places = [EYE + [d, 0, 0] for d in (100, 980, 1020, 2000)]
    np.testing.assert_array_equal(_pixels(places, _views(), reach_cm=990.0) > 0, [1, 1, 0, 0])


def test_pixels_are_those_of_the_view_that_shows_most():
    views = _views(display="side-by-side")
    place = EYE + [200, 0, 0]
    expected = [20 * pixels_per_radian(v) / np.linalg.norm(place - v.eye) for v in views]
    assert _pixels(place, views)[0] == pytest.approx(max(expected), rel=1e-5)


def test_without_culling_all_is_in_sight():
    behind = EYE - [100, 0, 0]
    assert _pixels(behind, _views())[0] == OUT_OF_SIGHT
    assert _pixels(behind, _views(), culling=False, reach_cm=1.0)[0] > 0


@pytest.mark.parametrize("display", ["side-by-side", "top-bottom", "dome"])
def test_several_views_cull_each_as_if_it_was_alone(display):
    views = _views(display=display)
    rng = np.random.default_rng(2)
    centres = EYE + rng.normal(0, 150, (2000, 3))
    alone = [_covered(centres, (view,)) for view in views]
    pixels, distance = _covered(centres, views)
    np.testing.assert_array_equal(pixels, np.max([own for own, _ in alone], axis=0))
    np.testing.assert_array_equal(distance, np.concatenate([away for _, away in alone]))


def test_pixels_are_counted_by_the_surface_that_a_thing_covers():
    """Halves of a display that stretches them need less detail than the whole."""
    (mono,) = _views()
    for display in ("side-by-side", "top-bottom"):
        for view in _views(display=display):
            assert 2 * pixels_per_radian(view) ** 2 == pytest.approx(pixels_per_radian(mono) ** 2)
