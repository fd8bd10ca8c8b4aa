"""OpenEXR files: attributes by the standard's definitions, and disks that are full."""

import resource
import subprocess
import sys
from fractions import Fraction

import av
import numpy as np
import OpenEXR
import pytest

from subsea.base.errors import UserError
from subsea.media.exr import camera_header, picture_header, write_exr
from subsea.view.display_rigs import display_rig
from subsea.view.rig import pose_from_angles, views

SIZE = 64, 48


def test_a_matrix_carries_rows_to_the_picture():
    (view,) = views(display_rig("mono", SIZE), pose_from_angles(np.array([5.0, 3, -90]), 0.4, 0.1))
    header = camera_header(view)
    place = np.array([view.eye + 80.0 * -view.view[2, :3] + 20.0 * view.view[0, :3]])[0]
    x, y, z, _ = np.array([*place, 1.0]) @ header["worldToCamera"]
    assert (x, y, z) == pytest.approx((20.0, 0.0, -80.0), abs=1e-4)
    x, y, _, w = np.array([*place, 1.0]) @ header["worldToNDC"]
    assert y / w == pytest.approx(0.5, abs=1e-6)  # level with the middle
    assert 0.5 < x / w < 1.0  # to the right of it
    x, y, _, w = np.array([*(place + 10.0 * view.view[1, :3]), 1.0]) @ header["worldToNDC"]
    assert y / w < 0.5  # down the picture


@pytest.mark.parametrize(
    ("rate", "frame", "code"),
    [(24, 24 * 61 + 5, (0, 1, 1, 5)), (Fraction(30000, 1001), 30, (0, 0, 1, 0))],
)  # fmt: skip
def test_a_time_code_counts_frames(rate, frame, code):
    found = picture_header(Fraction(rate), frame)["timeCode"]
    assert (found.hours, found.minutes, found.seconds, found.frame) == code


def test_rates_that_no_time_code_counts_have_none():
    assert "timeCode" not in picture_header(Fraction(120), 7)


def test_channels_and_attributes_come_back(tmp_path):
    path = tmp_path / "a.exr"
    values = np.linspace(0.0, 1e10, 12, dtype=np.float32).reshape(3, 4)
    header = picture_header(Fraction(24000, 1001), 3)
    write_exr(path, {"Z": values, "R": np.zeros((3, 4), np.float16)}, header)
    with OpenEXR.File(str(path), separate_channels=True) as file:
        np.testing.assert_array_equal(file.channels()["Z"].pixels, values)
        assert file.channels()["R"].pixels.dtype == np.float16
        found = dict(file.header())
    assert found["framesPerSecond"] == Fraction(24000, 1001)
    assert found["chromaticities"] == pytest.approx(header["chromaticities"])
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr"]


@pytest.mark.parametrize("layer", ["", "veil", "subject", "CryptoFish00"])
def test_ffmpeg_reads_every_layer_of_a_sequence(tmp_path, layer):
    """PyAV holds the decoders of ffmpeg: a sequence has its rate, and each value its bits."""
    rng, prefix = np.random.default_rng(1), f"{layer}." if layer else ""
    exact = np.float32 if layer.startswith("Crypto") else np.float16
    names = [f"{one}{colour}" for one in ("", "veil.", "subject.", "CryptoFish00.")
             for colour in "RGBA" if f"{one}{colour}" != "veil.A"]  # fmt: skip
    frames = []
    for k in range(2):
        kinds = [np.float32 if name.startswith("Crypto") else np.float16 for name in names]
        values = [rng.random((6, 32)).astype(kind) for kind in kinds]
        channels = dict(zip(names, values, strict=True)) | {"Z": np.ones((6, 32), np.float32)}
        write_exr(tmp_path / f"frame_{k:05}.exr", channels, picture_header(Fraction(24), k))
        frames.append(channels)
    options = {"framerate": "24"}
    with av.open(str(tmp_path / "frame_%05d.exr"), format="image2", options=options) as film:
        stream = film.streams.video[0]
        stream.codec_context.options = {"layer": layer} if layer else {}
        shown = list(film.decode(stream))
    assert stream.average_rate == 24 and len(shown) == 2
    for picture, channels in zip(shown, frames, strict=True):
        for plane, colour in zip(picture.planes, "GBRA", strict=False):
            rows = np.frombuffer(plane, exact).reshape(6, -1)[:, :32]
            np.testing.assert_array_equal(rows, channels[prefix + colour])


LIMITED = """
import resource, sys
import numpy as np
from pathlib import Path
from subsea.base.errors import UserError
from subsea.media.exr import write_exr
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
noise = np.random.default_rng(1).random((64, 64)).astype(np.float32)
try:
    write_exr(Path(sys.argv[1]), {"R": noise}, {})
except UserError as fault:
    print(fault)
"""


@pytest.mark.parametrize("limit", [100, 9000])
def test_a_full_disk_leaves_nothing(tmp_path, limit):
    path = tmp_path / "new" / "a.exr"
    run = subprocess.run(
        [sys.executable, "-c", LIMITED, str(path), str(limit)], capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    assert run.stdout.strip() == f"{path}: cannot write (File too large)"
    assert not any(tmp_path.iterdir())
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY


def test_a_folder_that_is_gone_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match="cannot write"):
        write_exr(tmp_path / "file" / "a.exr", {"R": np.zeros((2, 2), np.float32)}, {})
