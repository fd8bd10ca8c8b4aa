"""Pictures of scenarios for the menu."""

import os

import numpy as np
import pytest
from PIL import Image

from subsea.base.system import resource_names, resource_path
from subsea.scenario.storage import SIZE, read_thumbnail
from tests.support.profiles import DISPLAY_P3, in_srgb, rgb_profile

MOST_BYTES = 8000


@pytest.mark.parametrize("name", resource_names("assets/scenarios", ".toml"))
def test_every_shipped_scenario_has_a_small_picture(name):
    path = resource_path("assets/scenarios") / f"{name}.toml"
    pixels = read_thumbnail(path)
    assert pixels is not None and pixels.dtype == np.uint8
    height, width, planes = pixels.shape
    assert planes == 3 and width / height == pytest.approx(16 / 9, abs=0.01)
    assert pixels.std() > 10.0
    assert path.with_suffix(".jpg").stat().st_size < MOST_BYTES


def test_a_scenario_of_ones_own_may_have_a_picture(tmp_path):
    scenario = tmp_path / "mine.toml"
    assert read_thumbnail(scenario) is None
    Image.new("RGB", (2000, 1000), (200, 100, 50)).save(tmp_path / "mine.jpg")
    pixels = read_thumbnail(scenario)
    assert pixels.shape == (SIZE[0] // 2, SIZE[0], 3)
    assert np.abs(pixels - np.array((200, 100, 50))).max() < 4


def test_a_picture_of_a_camera_is_upright_and_has_the_colours_of_its_profile(tmp_path):
    picture = Image.new("RGB", (40, 20), (200, 100, 50))
    exif = picture.getexif()
    exif[0x0112] = 6
    picture.save(tmp_path / "mine.jpg", exif=exif, icc_profile=rgb_profile(DISPLAY_P3))
    pixels = read_thumbnail(tmp_path / "mine.toml")
    assert pixels.shape == (40, 20, 3)
    assert np.abs(pixels - in_srgb((200, 100, 50), DISPLAY_P3)).max() < 4


def test_what_is_no_picture_is_ignored(tmp_path):
    scenario, picture = tmp_path / "mine.toml", tmp_path / "mine.jpg"
    Image.effect_noise((64, 36), 90.0).save(tmp_path / "sound.jpg")
    sound = (tmp_path / "sound.jpg").read_bytes()
    Image.new("L", (9000, 9000)).save(tmp_path / "huge.jpg")
    Image.new("L", (64, 36)).save(tmp_path / "other.png")
    for data in (
        b"", b"no picture", sound[:-200], bytes(2 << 20),
        (tmp_path / "huge.jpg").read_bytes(), (tmp_path / "other.png").read_bytes(),
    ):  # fmt: skip
        picture.write_bytes(data)
        assert read_thumbnail(scenario) is None
    picture.unlink()
    os.mkfifo(picture)  # opening it would wait for ever
    assert read_thumbnail(scenario) is None
    picture.unlink()
    picture.mkdir()
    assert read_thumbnail(scenario) is None
