"""Packing repertoires into flat arrays."""

import dataclasses

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.fish.skinning import couple, place
from subsea.repertoire import BASIC_SEGMENTS, SEGMENTS
from subsea.repertoire.blending import TIGHTEST
from subsea.repertoire.library import pack

POINTS = np.random.default_rng(0).uniform([-15, -3, -1], [5, 3, 1], (426, 3))


@pytest.fixture(scope="module")
def library(known_repertoire):
    return pack([known_repertoire, known_repertoire], [surface(known_repertoire)] * 2)


def surface(repertoire, way="sections"):
    return couple(way, repertoire.rest_nodes, POINTS)


def test_every_frame_of_every_species_has_its_row(library, known_repertoire):
    for kind in range(2):
        for code, name in enumerate(BASIC_SEGMENTS):
            segment = known_repertoire.segments[name]
            rows = slice(library.first[kind, code], library.first[kind, code] + 12)
            np.testing.assert_allclose(library.nodes[rows], segment.nodes, atol=1e-5)
            np.testing.assert_allclose(
                library.rotation[rows], segment.increment_rotation, atol=1e-6
            )
    assert len(library.nodes) == 2 * (7 + 2 * TIGHTEST) * 12


def test_control_points_are_made_when_the_file_has_none(library, known_repertoire):
    """The first row of the slow swim is nearly straight, so its skin is nearly at rest."""
    np.testing.assert_allclose(library.control_points[0], POINTS, atol=0.8)
    assert library.control_points.shape == (2 * (7 + 2 * TIGHTEST) * 12, 426, 3)


@pytest.mark.parametrize("way", ["patches", "tetrahedra"])
def test_they_are_made_in_the_way_that_the_species_asks_for(known_repertoire, way):
    coupling = surface(known_repertoire, way)
    library = pack([known_repertoire], [coupling])
    segment = known_repertoire.segments["turn_left_sharp"]
    first = library.first[0, SEGMENTS.index("turn_left_sharp")]
    points = library.control_points[first : first + 12]
    np.testing.assert_allclose(points, place(coupling, segment.nodes), atol=1e-5)
    np.testing.assert_array_equal(library.coupling.face[0], coupling.face)


def test_recorded_control_points_are_taken_as_they_are(known_repertoire):
    own = {
        name: dataclasses.replace(s, control_points=np.full((12, 426, 3), 7.0))
        for name, s in known_repertoire.segments.items()
    }
    library = pack(
        [dataclasses.replace(known_repertoire, segments=own)], [surface(known_repertoire)]
    )
    assert (library.control_points == 7.0).all()


def test_a_missing_segment_is_named(known_repertoire):
    segments = dict(known_repertoire.segments)
    del segments["turn_left_sharp"]
    with pytest.raises(UserError, match="turn_left_sharp"):
        pack(
            [dataclasses.replace(known_repertoire, segments=segments)], [surface(known_repertoire)]
        )


def test_entries_stay_in_their_species_and_segment(library):
    for kind in range(2):
        rows = slice(84 * kind, 84 * (kind + 1))
        for code, name in enumerate(BASIC_SEGMENTS):
            entry = library.entry[rows, code] - library.first[kind, code]
            assert ((entry >= 0) & (entry < 12)).all()
            if name.endswith("sharp"):
                assert (entry == 0).all()
    assert library.glide.min() >= 1
