"""Packing repertoires into flat arrays."""

import dataclasses

import numpy as np
import pytest

from subsea.errors import UserError
from subsea.repertoire import SEGMENTS
from subsea.repertoire.library import pack

POINTS = np.random.default_rng(0).uniform([-15, -3, -1], [5, 3, 1], (426, 3))


@pytest.fixture(scope="module")
def library(known_repertoire):
    return pack([known_repertoire, known_repertoire], [POINTS, POINTS])


def test_every_frame_of_every_species_has_its_row(library, known_repertoire):
    for kind in range(2):
        for code, name in enumerate(SEGMENTS):
            segment = known_repertoire.segments[name]
            rows = slice(library.first[kind, code], library.first[kind, code] + 12)
            np.testing.assert_allclose(library.nodes[rows], segment.nodes, atol=1e-5)
            np.testing.assert_allclose(
                library.rotation[rows], segment.increment_rotation, atol=1e-6
            )
    assert len(library.nodes) == 2 * 7 * 12


def test_control_points_are_made_when_the_file_has_none(library, known_repertoire):
    """The first row of the slow swim is nearly straight, so its skin is nearly at rest."""
    np.testing.assert_allclose(library.control_points[0], POINTS, atol=0.8)
    assert library.control_points.shape == (168, 426, 3)


def test_recorded_control_points_are_taken_as_they_are(known_repertoire):
    own = {
        name: dataclasses.replace(s, control_points=np.full((12, 426, 3), 7.0))
        for name, s in known_repertoire.segments.items()
    }
    library = pack([dataclasses.replace(known_repertoire, segments=own)], [POINTS])
    assert (library.control_points == 7.0).all()


def test_a_missing_segment_is_named(known_repertoire):
    segments = dict(known_repertoire.segments)
    del segments["turn_left_sharp"]
    with pytest.raises(UserError, match="turn_left_sharp"):
        pack([dataclasses.replace(known_repertoire, segments=segments)], [POINTS])


def test_entries_keep_the_beat_and_stay_in_their_species(library):
    """From row k of one swim, another swim of the same wave is entered at its row k + 1."""
    slow, fast, sharp = (SEGMENTS.index(n) for n in ("swim_slow", "swim_fast", "turn_left_sharp"))
    for kind in range(2):
        rows = library.first[kind, slow] + np.arange(12)
        expected = library.first[kind, fast] + (np.arange(12) + 1) % 12
        gap = (library.entry[rows, fast] - expected + 6) % 12 - 6
        assert np.abs(gap).max() <= 2  # another amplitude shifts the nearest row a little
        assert (library.entry[rows, sharp] == library.first[kind, sharp]).all()
    low, high = library.first[1, 0], len(library.nodes)
    assert library.entry[:low].max() < low
    assert library.entry[low:].min() >= low
    assert library.entry.max() < high
