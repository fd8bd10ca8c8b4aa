"""Metadata of films for players, checked by ffmpeg's own readers."""

import struct
from fractions import Fraction

import av
import numpy as np
import pytest
from av.sidedata.sidedata import Type
from PIL import Image

from subsea.media.frame_writers import FilmFormat, metadata_for, open_writers

SIZE = (64, 48)


def film(out, display, frames=40):
    dice = np.random.default_rng(1)
    pictures = [dice.integers(0, 255, (6, 8, 3), np.uint8) for _ in range(frames)]
    with open_writers(out, {"": SIZE}, FilmFormat(Fraction(20), metadata_for(display))) as write:
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


# Patches of 16 by 16 pixels: primaries and their mixtures, greys, and colours of a reef.
PATCHES = np.array(
    [
        [(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)],
        [(255, 255, 0), (0, 255, 255), (255, 0, 255), (0, 0, 0)],
        [(24, 96, 128), (238, 120, 40), (119, 119, 119), (200, 180, 150)],
    ],
    np.uint8,
)
MIDDLES = slice(8, None, 16)


def bt709(colours):
    """Luma and chroma (..., 3) of 8 bits and limited range, from BT.709-6, items 3.2 to 3.4."""
    red, green, blue = np.moveaxis(colours / 255.0, -1, 0)
    luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    chroma = (blue - luma) / 1.8556, (red - luma) / 1.5748
    return np.stack([16.0 + 219.0 * luma, *(128.0 + 224.0 * part for part in chroma)], axis=-1)


@pytest.mark.parametrize("display", ["mono", "equirectangular", "side-by-side"])
def test_a_film_shows_the_colours_of_a_picture(display, tmp_path):
    picture = np.kron(PATCHES, np.ones((16, 16, 1), np.uint8))
    for name in ("a.mp4", "a.png"):
        out = {"": picture.shape[1::-1]}
        with open_writers(
            tmp_path / name, out, FilmFormat(Fraction(20), metadata_for(display))
        ) as write:
            write(0, {"": picture})
    with Image.open(tmp_path / "a.png") as image:
        still = np.asarray(image)
        assert image.info["srgb"] == 0
    with av.open(str(tmp_path / "a.mp4")) as container:
        frame = next(container.decode(video=0))
    shown = frame.to_ndarray(format="rgb24", src_colorspace="ITU709", dst_color_range="JPEG")
    wrong = np.abs(shown[MIDDLES, MIDDLES].astype(int) - still[MIDDLES, MIDDLES])
    assert wrong.max() <= 3
    coded = frame.to_ndarray()[:, : SIZE[0]]  # luma, then two planes of a quarter
    chroma = coded[SIZE[1] :].reshape(2, SIZE[1] // 2, SIZE[0] // 2)[:, 4::8, 4::8]
    planes = np.stack([coded[: SIZE[1]][MIDDLES, MIDDLES], *chroma], axis=-1)
    assert planes == pytest.approx(bt709(PATCHES), abs=1.5)


def test_a_film_says_how_its_colours_are_coded(tmp_path):
    film(tmp_path / "a.mp4", "mono", 2)
    with av.open(str(tmp_path / "a.mp4")) as container:
        frame = next(container.decode(video=0))
    # Numbers of ITU-T H.273: BT.709, limited, BT.709, sRGB.
    assert (frame.colorspace, frame.color_range) == (1, 1)
    assert (frame.color_primaries, frame.color_trc) == (1, 13)
    data = (tmp_path / "a.mp4").read_bytes()
    assert b"colrnclx" + struct.pack(">3HB", 1, 13, 1, 0) in data
