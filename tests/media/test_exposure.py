"""Motion blur and depth of field, against thin lenses and means of light."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from subsea.cli.main import main
from subsea.dive.directed_camera import tour_steering
from subsea.dive.start import ready_world
from subsea.fish.raster import from_srgb
from subsea.media.exposure import Exposure
from subsea.media.film import reach
from subsea.scenario.load import load_scenario
from subsea.view.camera import View, look
from subsea.view.display_rigs import display_rig
from subsea.view.follow import follow_fish
from subsea.view.retina import bodies_at
from subsea.view.rig import pose_from_angles, views
from tests.support.scenes import BARE

SIZE = 640, 480
FOCUS, APERTURE = 200.0, 4.0


def eyes() -> tuple[View, ...]:
    return views(display_rig("mono", SIZE), pose_from_angles(np.zeros(3), 0.0, 0.0))


def pixel(view, place):
    x, y, _, w = view.projection @ view.view @ np.array([*place, 1.0])
    return 0.5 * SIZE[0] * (1 + x / w), 0.5 * SIZE[1] * (1 + y / w)


@given(st.floats(-40, 40), st.floats(-40, 40), st.integers(0, 63))
def test_the_plane_in_focus_stays(left, up, sample):
    exposure = Exposure(64, aperture_cm=APERTURE, focus_cm=FOCUS)
    (seen,) = exposure.through_lens(eyes(), sample)
    place = FOCUS, left, up
    assert pixel(seen, place) == pytest.approx(pixel(eyes()[0], place), abs=0.01)


@pytest.mark.parametrize("distance", [60.0, 120.0, 400.0, 1e5])
def test_a_point_elsewhere_becomes_the_disk_of_a_thin_lens(distance):
    exposure = Exposure(256, aperture_cm=APERTURE, focus_cm=FOCUS)
    (pinhole,) = eyes()
    spots = np.array([
        pixel(exposure.through_lens(eyes(), k)[0], (distance, 0.0, 0.0)) for k in range(256)
    ])  # fmt: skip
    away = np.hypot(*(spots - pixel(pinhole, (distance, 0.0, 0.0))).T)
    per_rad = 0.5 * SIZE[0] * pinhole.projection[0, 0]
    radius = per_rad * 0.5 * APERTURE * abs(1 / distance - 1 / FOCUS)
    assert away.max() == pytest.approx(radius, rel=0.02)
    # As many in each ring of equal area, and about the middle.
    assert np.histogram(away**2, 4, (0, radius**2))[0] == pytest.approx(64, abs=3)
    assert np.abs(spots.mean(axis=0) - pixel(pinhole, (distance, 0.0, 0.0))).max() < 0.02 * radius


def test_eyes_move_by_no_more_than_the_lens():
    exposure = Exposure(9, aperture_cm=APERTURE)
    for k in range(9):
        for one, moved in zip(eyes(), exposure.through_lens(eyes(), k), strict=True):
            assert 0 < np.linalg.norm(moved.eye - one.eye) < 0.5 * APERTURE
            ahead, up = -moved.view[2, :3], moved.view[1, :3]
            np.testing.assert_allclose(moved.view, look(moved.eye, ahead, up), atol=1e-4)


def test_a_pinhole_moves_nothing():
    seen = eyes()
    assert Exposure(16).through_lens(seen, 5) is seen


def test_the_shutter_is_open_for_its_share():
    assert Exposure(4, shutter=0.5).instants(2.0, 0.1) == pytest.approx(
        [2.0, 2.0125, 2.025, 2.0375]
    )
    assert Exposure().instants(2.0, 0.1) == [2.0]


@pytest.mark.nightly
@pytest.mark.usefixtures("one_context")
def test_a_blurred_picture_is_as_bright_and_smoother(tmp_path):
    """Of the same moment: the sea is taken in the first thousandth of the frame."""
    words = ["--scenario", str(BARE), "--size", "160x120", "--seconds", "0.2", "--seed", "1"]
    blur = ["--samples", "12", "--shutter", "0.001", "--aperture", "30", "--focus", "10000"]
    pictures = []
    for name, more in (("sharp.png", []), ("soft.png", blur)):
        assert main(["film", str(tmp_path / name), *words, *more]) == 0
        pictures.append(from_srgb(np.asarray(Image.open(tmp_path / name)) / 255.0))
    sharp, soft = pictures
    assert soft.mean() == pytest.approx(sharp.mean(), rel=0.03)
    edges = [np.abs(np.diff(one, axis=1)).mean() for one in pictures]
    assert edges[1] < 0.8 * edges[0]


@pytest.mark.usefixtures("one_context")
def test_the_followed_fish_is_in_focus(tmp_path, monkeypatch):
    """With a lens so wide that nothing else is sharp, it lies where it does for a pinhole."""
    found = []
    through_lens = Exposure.through_lens

    def recorded(exposure, seen, sample):
        found.append(exposure.focus_cm)
        return through_lens(exposure, seen, sample)

    monkeypatch.setattr(Exposure, "through_lens", recorded)
    words = ["--scenario", str(BARE), "--size", "96x64", "--seconds", "0.3", "--follow", "0"]
    blur = ["--samples", "2", "--aperture", "3", "--focus", "fish"]
    assert main(["film", str(tmp_path / "near.png"), *words, *blur]) == 0
    away = []
    world = ready_world(load_scenario(str(BARE)), None)
    alpha = reach(world, 0.3, tour_steering(world, "auto"), lambda: None)
    _, pose = follow_fish(world, 0, alpha, None)
    away = (bodies_at(world, 0, alpha)[0] - pose.eye) @ pose.forward
    assert found[0] == pytest.approx(away, rel=0.02)
    assert Exposure(focus_cm=70.0).focused(20.0).focus_cm == 70.0
    assert Exposure(focus_cm=0.0).focused(2.0).focus_cm == 10.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--aperture", "2"], "film: --aperture needs --samples N, of 2 or more"),
        (["--samples", "1", "--focus", "90"], "film: --focus needs --samples N, of 2 or more"),
        (["--samples", "4", "--aperture", "2", "--display", "dome"],
         "film: --aperture is not for --display dome"),
        (["--samples", "4", "--focus", "fish"], "film: --focus fish needs --follow FISH"),
        (["--samples", "4", "--focus", "cod"], "argument --focus"),
        (["--samples", "0"], "argument --samples"),
        (["--samples", "4", "--eyes", "0"], "film: --samples cannot be combined with --eyes"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_refused_in_one_line(tmp_path, capsys, words, said):
    assert main(["film", str(tmp_path / "a.png"), "--scenario", str(BARE), *words]) != 0
    err = capsys.readouterr().err
    assert said in err and "Traceback" not in err
    assert not list(tmp_path.iterdir())
