"""Passes of a film: what a compositor does with them gives the picture, and other facts agree."""

import json
from itertools import pairwise

import numpy as np
import OpenEXR
import pytest

from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.media.cryptomatte import hashed
from subsea.media.passes import FAR_CM, PASSES, beside, pixel_place, read_passes
from subsea.view.display_rigs import display_rig
from subsea.view.rig import pose_from_angles, views
from tests.support.scenes import BARE

pytestmark = pytest.mark.usefixtures("one_context")

SIZE = 160, 120
SHOT = ["--scenario", str(BARE), "--size", "160x120", "--fps", "20", "--seed", "1"]
SHOT += ["--follow", "clownfish", "--quality", "medium"]
HALF = 2.0**-11


def read(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: one.pixels for name, one in file.channels().items()}
        return channels, dict(file.header())


def rgb(channels, layer=""):
    return np.stack([channels[f"{layer}{name}"] for name in "RGB"], axis=-1).astype(np.float32)


@pytest.fixture(scope="module")
def shot(tmp_path_factory, one_context):
    """Three frames with all passes: channels and header of each."""
    out = tmp_path_factory.mktemp("film") / "shot"
    assert main(["film", str(out), *SHOT, "--seconds", "0.15", "--passes", "all"]) == 0
    names = [f"frame_0000{k}.exr" for k in range(3)]
    assert sorted(path.name for path in out.glob("*.exr")) == names
    return [read(out / name) for name in names]


def recomposed(channels):
    """Put the parts together as a compositor does."""
    names = "subject.", "transmittance.", "veil."
    subject, share, veil = (rgb(channels, name) for name in names)
    return subject * share + veil


def test_the_picture_is_subject_times_transmittance_plus_veil(shot):
    for channels, _ in shot:
        picture = rgb(channels)
        assert picture.std() > 0.02
        # All are rounded to half floats, the picture each time that something is blended over.
        np.testing.assert_allclose(recomposed(channels), picture, rtol=8 * HALF, atol=1e-4)
        assert (channels["A"] == 1.0).all()


def test_mattes_add_up_and_are_of_their_species(shot):
    channels, header = shot[0]
    cover = {}
    for layer in ("CryptoFish", "CryptoSpecies", "CryptoThing"):
        shares = [channels[f"{layer}0{k}.{name}"] for k in range(3) for name in "GA"]
        assert all((a >= b).all() for a, b in pairwise(shares))
        cover[layer] = sum(shares)
    np.testing.assert_allclose(cover["CryptoFish"], cover["CryptoSpecies"], atol=1e-6)
    whole = cover["CryptoFish"] + cover["CryptoThing"]
    assert whole.max() <= 1.0 + 1e-6
    water = channels["Z"] == np.float32(FAR_CM)
    assert whole[water].mean() < 0.05
    assert whole[~water].mean() > 0.95
    manifests = {
        header[key.replace("/manifest", "/name")]: json.loads(text)
        for key, text in header.items() if key.endswith("/manifest")
    }  # fmt: skip
    assert manifests["CryptoFish"]["clownfish:0"] == f"{hashed('clownfish:0'):08x}"
    mine = channels["CryptoFish00.R"].view(np.uint32) == hashed("clownfish:0")
    assert mine[40:80, 50:110].any()  # it is followed, so it is near the middle
    species = channels["CryptoSpecies00.R"].view(np.uint32)
    assert (species[mine] == hashed("clownfish")).mean() > 0.95
    soft = channels["CryptoFish00.G"][mine]
    assert ((soft > 0.0) & (soft < 1.0)).any()  # its outline is smooth


def test_depth_normals_and_camera_agree(shot):
    """Normals are those of the surface that depth and camera make."""
    channels, header = shot[0]
    depth = channels["Z"].astype(np.float64)
    solid = depth < FAR_CM
    height, width = depth.shape
    y, x = np.mgrid[:height, :width] + 0.5
    matrix = header["worldToNDC"].astype(np.float64)
    back = np.linalg.inv(matrix)
    camera = header["worldToCamera"].astype(np.float64)

    def world(share):
        point = (
            np.stack([x / width, y / height, np.full_like(x, share), np.ones_like(x)], axis=-1)
            @ back
        )
        return point[..., :3] / point[..., 3:]

    near, far = world(-1.0), world(0.5)
    along = -(near @ camera[:3, 2] + camera[3, 2]), -(far @ camera[:3, 2] + camera[3, 2])
    share = (depth - along[0]) / (along[1] - along[0])
    places = near + share[..., None] * (far - near)
    across, down = places[1:-1, 2:] - places[1:-1, :-2], places[2:, 1:-1] - places[:-2, 1:-1]
    found = np.cross(down, across)
    found /= np.linalg.norm(found, axis=-1, keepdims=True)
    stored = np.stack([channels[f"N.{name}"] for name in "XYZ"], axis=-1).astype(np.float64)
    assert np.linalg.norm(stored[solid], axis=-1) == pytest.approx(1.0, abs=2e-3)
    assert (stored[~solid] == 0.0).all()
    inside = (
        solid[1:-1, 1:-1] & solid[:-2, 1:-1] & solid[2:, 1:-1] & solid[1:-1, :-2] & solid[1:-1, 2:]
    )
    cosine = (found * stored[1:-1, 1:-1]).sum(axis=-1)[inside]
    assert np.quantile(cosine, 0.2) > 0.9


def test_motion_leads_to_the_same_thing_in_the_next_frame(shot):
    (one, _), (two, _) = shot[0], shot[1]
    row, column = np.nonzero(one["CryptoFish00.R"] != 0.0)
    x = column + one["forward.u"][row, column]
    y = row - one["forward.v"][row, column]  # v leads up
    inside = (x > 0.5) & (x < SIZE[0] - 1.5) & (y > 0.5) & (y < SIZE[1] - 1.5)
    row, column, x, y = (part[inside] for part in (row, column, x, y))
    there = np.rint(y).astype(int), np.rint(x).astype(int)
    same = one["CryptoFish00.R"][row, column] == two["CryptoFish00.R"][there]
    assert same.mean() > 0.85
    # And the way back from there leads to where it came from.
    back_x = there[1] + two["backward.u"][there] - (x - np.rint(x)) * -1.0
    back_y = there[0] - two["backward.v"][there] + (y - np.rint(y))
    off = np.hypot(back_x - column, back_y - row)[same]
    assert np.median(off) < 0.5
    still = [np.abs(one[f"backward.{name}"]).max() for name in "uv"]
    assert max(still) < 0.01  # nothing was before
    moving = np.hypot(one["forward.u"], one["forward.v"])
    assert moving.max() > 0.5


def test_blur_of_motion_and_lens_keeps_the_sum(tmp_path):
    out = tmp_path / "blurred.exr"
    blur = ["--samples", "4", "--aperture", "6", "--focus", "fish"]
    assert (
        main(["film", str(out), *SHOT, "--seconds", "0.5", *blur, "--passes", "water,depth"]) == 0
    )
    channels, _ = read(out)
    np.testing.assert_allclose(recomposed(channels), rgb(channels), rtol=8 * HALF, atol=1e-4)
    sharp = channels["Z"]
    assert len(np.unique(sharp)) > 100
    assert "CryptoFish00.R" not in channels


def test_a_picture_has_light_alone_unless_more_is_wanted(tmp_path):
    out = tmp_path / "plain.exr"
    assert main(["film", str(out), *SHOT, "--seconds", "0.1"]) == 0
    channels, header = read(out)
    assert sorted(channels) == ["A", "B", "G", "R"]
    assert header["pixelAspectRatio"] == 1.0
    assert header["dataWindow"][1].tolist() == [159, 119]


def test_an_interrupted_shot_is_completed(tmp_path, capsys):
    out = tmp_path / "shot"
    film = ["film", str(out), *SHOT, "--seconds", "0.15", "--passes", "depth,motion"]
    assert main(film) == 0
    whole = [(out / f"frame_0000{k}.exr").read_bytes() for k in range(3)]
    (out / "frame_00001.exr").unlink()
    assert main(film) == 0
    assert [(out / f"frame_0000{k}.exr").read_bytes() for k in range(3)] == whole
    assert main([*film[:-1], "depth"]) == 2
    assert "holds another film: `passes` is" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["a.exr", "--passes", "depht"], "unknown pass 'depht'; did you mean 'depth'?"),
        (["a.mp4", "--passes", "depth"], "a.mp4: --passes needs FILE.exr or a folder"),
        (["a.exr", "--display", "dome"], "film: OpenEXR is not for --display dome"),
        (["a.exr", "--show", "school"], "OpenEXR holds the light of the sea, not --show"),
        (["a.exr", "--alpha"], "--alpha is not for OpenEXR"),
        (["a.mp4", "--alpha"], "--alpha needs FILE.mov of ProRes, FILE.png or a folder"),
        (["a.mp4", "--codec", "prores"], "a.mp4: cannot hold prores, expected FILE.mov"),
        (["a.mp4", "--codec", "h265"], "unknown codec 'h265'"),
        (["a.png", "--codec", "hevc"], "a.png: --codec needs FILE.mp4 or FILE.mov"),
        (["seen", "--eyes", "0", "--passes", "all"], "--passes cannot be combined with --eyes"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(more, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["film", *more, *SHOT[:2]]) == 2
    told = capsys.readouterr().err.strip().splitlines()
    assert words in told[-1]
    assert not any(tmp_path.iterdir())


def test_names_of_passes():
    assert read_passes("all") == PASSES
    assert read_passes("motion, depth") == ("beauty", "depth", "motion")
    with pytest.raises(UserError, match="did you mean 'cryptomatte'"):
        read_passes("depth,cryptomat")


def test_places_of_a_pixel_are_spread_and_shift_all_depths_alike():
    places = np.array([pixel_place(k) for k in range(16)])
    assert (np.abs(places) < 0.5).all()
    assert np.abs(places.mean(axis=0)).max() < 0.05
    quarter = np.floor(2.0 * places).astype(int)
    assert (np.unique(quarter, axis=0, return_counts=True)[1] == 4).sum() >= 2
    (view,) = views(display_rig("mono", SIZE), pose_from_angles(np.zeros(3), 0.0, 0.0))
    for depth in (10.0, 3000.0):
        point = np.array([depth, 0.1 * depth, -0.2 * depth, 1.0])
        pixels = []
        for seen in (view, beside(view, 0.25, -0.4)):
            x, y, _, w = seen.world_to_clip @ point
            pixels.append((0.5 * SIZE[0] * x / w, 0.5 * SIZE[1] * y / w))
        moved = np.subtract(*pixels)
        assert moved == pytest.approx((0.25, -0.4), abs=1e-4)
