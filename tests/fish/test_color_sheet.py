"""Sheets in files, and the species that use them."""

import shutil

import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.fish import paint, sheet_layout
from subsea.fish.color_sheet import assign_sheet, read, sheet_of, sheets, write
from subsea.fish.species import load_species, own_species, species_file, species_names
from subsea.stage.cluster.identity import _anywhere
from tests.support.profiles import DISPLAY_P3, in_srgb, rgb_profile


@pytest.fixture
def own():
    """A species of one's own, a copy of a shipped one."""
    path = own_species() / "guppy.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(species_file("moon_wrasse"), path)
    yield path
    path.unlink()
    path.with_suffix(".png").unlink(missing_ok=True)


def picture():
    rng = np.random.default_rng(5)
    return rng.integers(0, 256, (*sheet_layout.SIZE[::-1], 4), np.uint8)


def test_a_sheet_is_read_as_it_was_written_with_its_upper_row_first(tmp_path):
    sheet = picture()
    write(tmp_path / "sheet.png", sheet)
    np.testing.assert_array_equal(read(tmp_path / "sheet.png"), sheet)
    with Image.open(tmp_path / "sheet.png") as image:
        assert image.size == sheet_layout.SIZE and image.mode == "RGBA"
        np.testing.assert_array_equal(np.asarray(image)[0], sheet[-1])


def test_the_colours_of_a_sheet_are_those_of_its_profile(tmp_path):
    sheet = picture()
    drawn = Image.fromarray(np.ascontiguousarray(sheet[::-1]))
    drawn.save(tmp_path / "sheet.png", icc_profile=rgb_profile(DISPLAY_P3))
    shown = read(tmp_path / "sheet.png")
    expected = in_srgb(sheet[..., :3], DISPLAY_P3)
    assert np.abs(shown[..., :3].astype(int) - expected).max() <= 2
    np.testing.assert_array_equal(shown[..., 3], sheet[..., 3])


def test_a_sheet_is_assigned_and_the_rest_of_the_file_stays(own):
    before = own.read_text()
    sheet = picture()
    assert sheet_of(load_species("guppy")).tobytes() != sheet.tobytes()
    assert assign_sheet(own, sheet) == own.with_suffix(".png")
    after = own.read_text().splitlines()
    added = [line for line in after if line not in before.splitlines()]
    assert added == ['sheet = "guppy.png"']
    assert [line for line in after if line not in added] == before.splitlines()
    species = load_species("guppy")
    assert species.skin.sheet == str(own.with_suffix(".png"))
    np.testing.assert_array_equal(sheet_of(species), sheet)
    assign_sheet(own, sheet[::-1])  # once more
    assert own.read_text().splitlines() == after
    np.testing.assert_array_equal(sheet_of(load_species("guppy")), sheet[::-1])


@pytest.mark.nightly
def test_any_species_file_takes_the_key(tmp_path):
    sheet = picture()
    for name in species_names():
        path = tmp_path / f"{name}.toml"
        shutil.copy(species_file(name), path)
        assign_sheet(path, sheet)
        dressed = load_species(str(path))
        assert dressed.skin.sheet == str(tmp_path / f"{name}.png")
        assert dressed.surface == load_species(name).surface


def test_a_species_that_was_damaged_meanwhile_is_a_fault_in_one_line(own):
    whole = own.read_bytes()
    skinless = whole.replace(b"[skin", b"[hide")
    for content in (b"name = [", skinless, b"\xff\xfe", None):
        own.unlink() if content is None else own.write_bytes(content)
        with pytest.raises(UserError) as fault:
            assign_sheet(own, picture())
        assert str(fault.value).startswith(str(own)) and "\n" not in str(fault.value)
        assert not own.with_suffix(".png").exists()
    own.write_bytes(whole)


def test_sheets_of_files_lie_among_painted_ones(own):
    sheet = picture()
    assign_sheet(own, sheet)
    three = [load_species(name) for name in ("spotted_eagle_ray", "guppy", "clownfish")]
    first, second, third = sheets(three)
    np.testing.assert_array_equal(second, sheet)
    np.testing.assert_array_equal(first, paint.paint(three[0]))
    np.testing.assert_array_equal(third, paint.paint(three[2]))
    assign_sheet(own, sheet[::-1])  # no old one is kept
    np.testing.assert_array_equal(sheets(three)[1], sheet[::-1])


def test_faulty_sheets_get_one_line(own):
    assign_sheet(own, picture())
    path = own.with_suffix(".png")
    data = path.read_bytes()

    def fails(*words):
        with pytest.raises(UserError) as fault:
            sheets([load_species("guppy")])
        text = str(fault.value)
        assert "\n" not in text
        for word in (str(path), "1024×640", *words):
            assert word in text

    Image.new("RGB", sheet_layout.SIZE).save(path)
    fails("RGB", "RGBA")
    Image.new("RGBA", (512, 320)).save(path)
    fails("512×320")
    path.write_bytes(data[:5000])
    fails("damaged")
    path.write_text("no picture")
    fails()
    path.unlink()
    fails("no such file")


def test_the_key_names_a_png_beside_the_file(own):
    assign_sheet(own, picture())
    text = own.read_text()
    for name in ("../guppy.png", "/tmp/guppy.png", "guppy.jpg", ".png"):
        own.write_text(text.replace("guppy.png", name))
        with pytest.raises(UserError, match="sheet"):
            load_species("guppy")


def test_computers_may_have_sheets_in_other_folders(own):
    assign_sheet(own, picture())
    assert _anywhere(load_species("guppy")).skin.sheet == "guppy.png"
