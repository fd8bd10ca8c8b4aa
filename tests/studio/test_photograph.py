"""Photographs: reading within limits, and segmenting the fish."""

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.studio import photograph
from subsea.studio.photograph import WORK, grab_cut, largest_region, read_photograph
from tests.support import profiles


def ramp(width=160, height=120):
    """A picture whose left is dark and whose top is blue."""
    y, x = np.mgrid[:height, :width]
    return np.stack([x * 255 // width, 0 * x, 255 - y * 255 // height], 2).astype(np.uint8)


def fails(path, *words):
    with pytest.raises(UserError) as fault:
        read_photograph(path)
    text = str(fault.value)
    assert str(path) in text and "\n" not in text
    for word in words:
        assert word in text
    return text


@pytest.mark.parametrize("ending", ["png", "jpg", "webp", "bmp", "tif", "gif"])
def test_pictures_of_many_formats_are_read(tmp_path, ending):
    path = tmp_path / f"fish.{ending}"
    Image.fromarray(ramp()).save(path)
    got = read_photograph(path)
    assert got.colour.shape == (120, 160, 3) and got.colour.dtype == np.uint8
    assert got.opacity is None
    assert abs(got.colour.astype(int) - ramp()).mean() < 12


def test_nan_pixels_are_dark(tmp_path):
    grey = np.tile(np.linspace(0.0, 1.0, 200, dtype=np.float32), (100, 1))
    means = []
    for first in (0.0, np.nan):
        grey[0, 0] = first
        Image.fromarray(grey).save(tmp_path / "fish.tif")
        means.append(read_photograph(tmp_path / "fish.tif").colour.mean())
    assert means[0] == means[1] > 100


@pytest.mark.parametrize("width", [160, 6000])
@pytest.mark.parametrize("mode", ["CMYK", "L", "P", "1", "YCbCr", "LA", "I;16", "F", "PA"])
def test_pictures_of_any_mode_are_brought_to_colours(tmp_path, mode, width):
    path = tmp_path / "fish.tif"
    grey = np.asarray(Image.fromarray(ramp(width)).convert("L"))
    if mode == "I;16":
        image = Image.fromarray(grey.astype(np.uint16) * 257)
    elif mode == "F":
        image = Image.fromarray(grey.astype(np.float32) / 255)
    else:
        image = Image.fromarray(ramp(width)).convert("P" if mode == "PA" else mode)
    if mode == "PA":
        path = path.with_suffix(".png")
        image.info["transparency"] = 0
    image.save(path)
    got = read_photograph(path).colour
    # Its left is darker than its right, whatever it is kept as.
    assert got[:, :40].mean() + 20 < got[:, -40:].mean()


def test_opacity_is_kept_where_it_tells_something(tmp_path):
    path = tmp_path / "cut.png"
    pixels = np.dstack([ramp(), np.full((120, 160), 255, np.uint8)])
    Image.fromarray(pixels).save(path)
    assert read_photograph(path).opacity is None
    pixels[:, :50, 3] = 0
    Image.fromarray(pixels).save(path)
    opacity = read_photograph(path).opacity
    assert (opacity[:, :50] == 0).all() and (opacity[:, 50:] == 255).all()


def test_a_camera_held_on_its_side_is_turned_upright(tmp_path):
    path = tmp_path / "turned.jpg"
    image = Image.fromarray(ramp())
    exif = image.getexif()
    exif[0x0112] = 6  # the right side is up
    image.save(path, exif=exif, quality=95)
    got = read_photograph(path).colour
    assert got.shape[:2] == (160, 120)
    assert got[:20].mean() < got[-20:].mean()  # its dark left is its top now


COLOURS = np.array([(255, 0, 0), (200, 100, 40), (40, 90, 140), (119, 119, 119)], np.uint8)
INKED = np.array([(1, 0, 0, 0), (0, 1, 1, 0), (1, 0, 0, 1), (0, 0, 0, 0)], np.uint8)
GREYS = np.array([0, 50, 128, 255], np.uint8)
GREY_LIGHT = np.rint(255.0 * profiles.coded((GREYS / 255.0) ** 1.5)).astype(int)


@pytest.mark.parametrize(
    ("name", "values", "profile", "expected"),
    [
        ("a.jpg", COLOURS, profiles.rgb_profile(profiles.DISPLAY_P3),
         profiles.in_srgb(COLOURS, profiles.DISPLAY_P3)),
        ("a.tif", COLOURS, profiles.rgb_profile(profiles.ADOBE_RGB, 563 / 256),
         profiles.in_srgb(COLOURS, profiles.ADOBE_RGB, 563 / 256)),
        ("a.png", np.hstack([COLOURS, GREYS[:, None]]), profiles.rgb_profile(profiles.DISPLAY_P3),
         profiles.in_srgb(COLOURS, profiles.DISPLAY_P3)),
        ("a.jpg", 255 * INKED, profiles.ink_profile(), profiles.printed(INKED)),
        ("a.png", GREYS, profiles.grey_profile(1.5), GREY_LIGHT[:, None]),
        ("b.png", np.stack([GREYS, 255 - GREYS], 1), profiles.grey_profile(1.5),
         GREY_LIGHT[:, None]),
        ("c.png", GREYS.astype(np.uint16) * 257, profiles.grey_profile(1.5), GREY_LIGHT[:, None]),
        ("d.png", COLOURS, b"damaged", COLOURS),
        ("e.png", COLOURS, profiles.ink_profile(), COLOURS),
    ],
    ids=["p3", "adobe", "opacity", "cmyk", "grey", "grey-opacity", "grey-16", "damaged", "other"],
)  # fmt: skip
def test_colours_are_those_of_the_embedded_profile(name, values, profile, expected, tmp_path):
    pixels = np.repeat(np.repeat(values[None], 30, axis=0), 30, axis=1)
    mode = "CMYK" if values is not GREYS and pixels.shape[2:] == (4,) and name == "a.jpg" else None
    picture = Image.fromarray(pixels, mode) if mode else Image.fromarray(pixels)
    lossless = {"quality": 100, "subsampling": 0} if name == "a.jpg" else {}
    picture.save(tmp_path / name, icc_profile=profile, **lossless)
    got = read_photograph(tmp_path / name)
    assert np.abs(got.colour[15, 15::30].astype(int) - expected).max() <= 3
    clear = values[:, -1] if values.ndim == 2 and picture.mode in ("RGBA", "LA") else None
    assert (got.opacity is None) == (clear is None)
    assert clear is None or (got.opacity[15, 15::30] == clear).all()


def test_large_pictures_are_scaled_down(tmp_path):
    path = tmp_path / "large.jpg"
    Image.fromarray(ramp(2000, 1500)).save(path)
    assert read_photograph(path).colour.shape == (WORK * 3 // 4, WORK, 3)


def test_other_files_are_one_line_errors(tmp_path):
    fails(tmp_path / "none.png", "no such file")
    fails(tmp_path, "cannot read")
    text = tmp_path / "text.jpg"
    text.write_text("a fish")
    fails(text, "not a picture", "JPEG")
    empty = tmp_path / "empty.png"
    empty.write_bytes(b"")
    fails(empty, "not a picture")
    tiny = tmp_path / "tiny.png"
    Image.fromarray(ramp(40, 30)).save(tiny)
    fails(tiny, "40×30", "96")
    strip = tmp_path / "strip.png"
    Image.fromarray(ramp(2000, 3)).save(strip)
    fails(strip, "2000×3")


@pytest.mark.parametrize("ending", ["png", "jpg", "tif", "webp", "gif"])
def test_damaged_pictures_are_one_line_errors(tmp_path, ending):
    whole = tmp_path / f"whole.{ending}"
    rng = np.random.default_rng(0)
    Image.fromarray(rng.integers(0, 255, (200, 300, 3), np.uint8)).save(whole)
    data = whole.read_bytes()
    path = tmp_path / f"cut.{ending}"
    for share in (0.02, 0.3, 0.9):
        path.write_bytes(data[: int(len(data) * share)])
        fails(path)
    for seed in range(12):  # whatever is in it: a picture, or one line
        rng = np.random.default_rng(seed)
        broken = np.frombuffer(data, np.uint8).copy()
        broken[rng.integers(0, len(broken), 40)] = rng.integers(0, 256, 40)
        path.write_bytes(broken.tobytes())
        try:
            read_photograph(path)
        except UserError as fault:
            assert str(path) in str(fault)


def test_bombs_are_not_opened(tmp_path, monkeypatch):
    path = tmp_path / "bomb.png"
    head = b"IHDR" + struct.pack(">IIBBBBB", 60_000, 60_000, 8, 2, 0, 0, 0)
    body = zlib.compress(b"\0" * 1000)
    chunks = [
        struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part))
        for part in (head, b"IDAT" + body, b"IEND")
    ]
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    fails(path, "150 million")
    monkeypatch.setattr(photograph, "MOST_PIXELS", 10_000)
    large = tmp_path / "large.png"
    Image.fromarray(ramp()).save(large)
    fails(large, "160×120 pixels")
    monkeypatch.setattr(photograph, "MOST_BYTES", 100)
    fails(large, "MiB")


def test_the_largest_piece_is_kept_and_filled():
    mask = np.zeros((100, 200), bool)
    mask[20:80, 40:150] = True
    mask[40:60, 80:100] = False  # a hole
    mask[5:9, 170:174] = True  # something else
    mask[50, 150:190] = True  # a thread
    want = np.zeros_like(mask)
    want[20:80, 40:150] = True
    assert (largest_region(mask) != want).mean() < 0.002
    assert not largest_region(np.zeros((50, 60), bool)).any()


def test_a_fish_is_segmented_by_colour():
    rng = np.random.default_rng(1)
    picture = rng.normal((40, 90, 120), 8, (150, 200, 3))
    y, x = np.mgrid[:150, :200]
    fish = np.hypot((x - 100) / 60, (y - 75) / 30) < 1
    picture[fish] = rng.normal((210, 120, 40), 8, (fish.sum(), 3))
    picture = picture.clip(0, 255).astype(np.uint8)
    for guess in photograph.initial_masks(picture):
        assert (grab_cut(picture, guess) != fish).mean() < 0.01
