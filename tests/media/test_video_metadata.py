"""Metadata of films for players, checked by ffmpeg's own readers."""

import struct
from fractions import Fraction

import av
import numpy as np
import pytest
from av.sidedata.sidedata import Type

from subsea.media.frame_writers import metadata_for, open_writers

SIZE = (64, 48)


def film(out, display, frames=40):
    dice = np.random.default_rng(1)
    pictures = [dice.integers(0, 255, (6, 8, 3), np.uint8) for _ in range(frames)]
    with open_writers(out, {"": SIZE}, Fraction(20), metadata_for(display)) as write:
        for k, picture in enumerate(pictures):
            write(k, {"": np.kron(picture, np.ones((8, 8, 1), np.uint8))})


def told(path):
    """First numbers of the side data that a reader finds at the first picture, by kind."""
    with av.open(str(path)) as container:
        first = next(container.decode(video=0))
        return {data.type: struct.unpack("<I", bytes(data)[:4])[0] for data in first.side_data}


def decoded(path):
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


# The numbers of ffmpeg's enumerations AVStereo3DType and AVSphericalProjection.
STEREO = {"side-by-side": 1, "top-bottom": 2, "checkerboard": 4, "interlaced": 6}


@pytest.mark.parametrize("display", STEREO)
def test_frame_packing_marks_stereo_films(tmp_path, display):
    film(tmp_path / "a.mp4", display, 2)
    assert told(tmp_path / "a.mp4")[Type.STEREO3D] == STEREO[display]


@pytest.mark.parametrize("display", ["mono", "anaglyph", "dome", "panorama"])
def test_a_plain_film_has_no_metadata(tmp_path, display):
    film(tmp_path / "a.mp4", display, 2)
    assert not {Type.STEREO3D, Type.SPHERICAL} & set(told(tmp_path / "a.mp4"))


def test_boxes_mark_films_of_all_directions(tmp_path):
    film(tmp_path / "a.mp4", "equirectangular", 2)
    assert told(tmp_path / "a.mp4")[Type.SPHERICAL] == 0


@pytest.mark.parametrize("display", ["equirectangular", "side-by-side"])
def test_the_film_is_the_same_with_and_without_boxes(tmp_path, display):
    plain, tagged = tmp_path / "plain.mp4", tmp_path / "tagged.mp4"
    film(plain, "mono")
    film(tagged, display)
    np.testing.assert_array_equal(decoded(plain), decoded(tagged))
    data = tagged.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plain.mp4", "tagged.mp4"]
