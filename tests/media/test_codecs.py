"""Films of 10 bits, opacity, and sound from all around, read back by ffmpeg."""

import struct
from fractions import Fraction

import av
import numpy as np
import pytest
from PIL import Image

from subsea.cli.main import main
from subsea.media.frame_writers import FilmFormat, metadata_for, open_writers
from subsea.sound.space import AMBISONIC, LAYOUTS, RATE
from tests.support.scenes import BARE

SIZE = 96, 64
# A slope over half of the levels of 16 bits, by far finer than 8 bits.
SLOPE = np.repeat(np.linspace(20_000, 52_000, SIZE[0]).astype(np.uint16)[None], SIZE[1], 0)
PICTURE = np.stack([SLOPE, SLOPE[:, ::-1], np.full_like(SLOPE, 30_000)], axis=-1)


def write(path, picture, **options):
    with open_writers(path, {"": SIZE}, FilmFormat(Fraction(24), **options)) as film:
        for number in range(3):
            film(number, {"": picture})


def first(path):
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        return next(container.decode(stream)), stream.codec_context


def shown(frame, form="rgb48le"):
    return frame.reformat(
        format=form, src_colorspace="ITU709", src_color_range="MPEG", dst_color_range="JPEG"
    ).to_ndarray()


@pytest.mark.parametrize(
    ("name", "codec", "known", "pixels", "tag"),
    [("a.mov", "prores", "prores", "yuv444p12le", "ap4h"),
     ("a.mp4", "hevc", "hevc", "yuv420p10le", "hvc1")],
)  # fmt: skip
def test_a_film_of_ten_bits(name, codec, known, pixels, tag, tmp_path):
    write(tmp_path / name, PICTURE, codec=codec)
    frame, coder = first(tmp_path / name)
    assert (coder.name, coder.pix_fmt, coder.codec_tag) == (known, pixels, tag)
    # Numbers of ITU-T H.273: BT.709, limited range, BT.709.
    assert (frame.colorspace, frame.color_range, frame.color_primaries) == (1, 1, 1)
    data = (tmp_path / name).read_bytes()
    colours = b"nclc" if name.endswith("mov") else b"nclx"
    assert b"colr" + colours + struct.pack(">3H", 1, 13, 1) in data
    assert data.index(b"moov") < data.index(b"mdat")
    wrong = np.abs(shown(frame).astype(int) - PICTURE)[8:-8, 8:-8]
    assert wrong.mean() < 250  # a level of 8 bits is 257
    luma = np.frombuffer(frame.planes[0], np.uint16).reshape(SIZE[1], -1)[:, : SIZE[0]]
    assert len(np.unique(luma)) > 60  # 8 bits would hold a quarter of them


def test_prores_holds_opacity(tmp_path):
    opacity = np.linspace(0, 65535, SIZE[1]).astype(np.uint16)[:, None] * np.ones(
        SIZE[0], np.uint16
    )
    write(tmp_path / "a.mov", np.dstack([PICTURE, opacity]), codec="prores", alpha=True)
    frame, coder = first(tmp_path / "a.mov")
    assert coder.pix_fmt == "yuva444p12le"  # ffmpeg decodes to 12 bits what it coded as 10
    found = shown(frame, "rgba64le")
    assert np.abs(found[..., 3].astype(int) - opacity).max() < 100
    assert np.abs(found[8:-8, 8:-8, :3].astype(int) - PICTURE[8:-8, 8:-8]).mean() < 250


class Heard:
    """A noise that comes from one direction."""

    def __init__(self, way):
        self.layout = LAYOUTS[AMBISONIC]
        right, ahead, up = way
        noise = 0.1 * np.random.default_rng(3).normal(size=RATE)
        noise = np.convolve(noise, np.ones(8) / 8, "same")
        self.samples = noise[:, None] * np.array([1.0, -right, up, ahead])

    def reader(self):
        taken = 0

        def read(until_s):
            nonlocal taken
            end = max(round(until_s * RATE), taken)
            part, taken = self.samples[taken:end], end
            return part

        return read


@pytest.mark.parametrize(("name", "codec"), [("a.mp4", "h264"), ("a.mov", "prores")])
@pytest.mark.parametrize("way", [(0.6, 0.0, 0.8), (-0.48, -0.8, -0.36)])
def test_a_direction_survives_in_a_film(name, codec, way, tmp_path):
    path = tmp_path / name
    picture = PICTURE if codec == "prores" else (PICTURE >> 8).astype(np.uint8)
    film = FilmFormat(Fraction(24), metadata_for("equirectangular"), Heard(way), codec)
    with open_writers(path, {"": SIZE}, film) as write_frame:
        for number in range(12):
            write_frame(number, {"": picture})
    data = path.read_bytes()
    about = struct.pack(">BBIBBI4I", 0, 0, 1, 0, 0, 4, 0, 1, 2, 3)
    assert struct.pack(">I", 36) + b"SA3D" + about in data
    assert b"sv3d" in data
    with av.open(str(path)) as container:
        assert container.streams.audio[0].codec_context.channels == 4
        packed = av.AudioResampler(format="flt")
        frames = [part for whole in container.decode(audio=0) for part in packed.resample(whole)]
        assert sum(1 for _ in av.open(str(path)).decode(video=0)) == 12  # the index is whole
    words = np.concatenate([frame.to_ndarray()[0] for frame in frames]).reshape(-1, 4)
    around, left, up, ahead = words.T
    found = np.array([-(around * left).mean(), (around * ahead).mean(), (around * up).mean()])
    found /= (around**2).mean()
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=0.1)  # AAC leaves out faint tones
    degrees = np.degrees(np.arccos(found @ way / np.linalg.norm(found)))
    assert degrees < 2.0


@pytest.mark.nightly
@pytest.mark.usefixtures("one_context")
def test_a_film_has_opacity_where_things_are(tmp_path):
    out = tmp_path / "fish.png"
    shot = ["--scenario", str(BARE), "--size", "160x120", "--seconds", "0.5", "--seed", "1"]
    shot += ["--follow", "clownfish", "--quality", "low"]
    assert main(["film", str(out), *shot, "--alpha"]) == 0
    assert main(["film", str(tmp_path / "plain.png"), *shot]) == 0
    picture, plain = np.asarray(Image.open(out)), np.asarray(Image.open(tmp_path / "plain.png"))
    assert picture.shape == (120, 160, 4)
    np.testing.assert_array_equal(picture[..., :3], plain)
    assert (picture[..., 3] == 0).mean() > 0.05
    assert (picture[..., 3] == 255).mean() > 0.05
