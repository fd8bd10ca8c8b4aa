"""Overlays of a show: the one computer of a show, and the nodes that follow its master."""

import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.dive.presented import NOTHING, OverlayFile
from subsea.stage.cluster import messages
from subsea.stage.overlays import MasterOverlay, overlay_faults, read_overlay
from subsea.stage.show_file import load_show

SHOW = """
[[item]]
scenario = "peaceful"
overlay = { file = "title.png", tilt_deg = 20, angle_deg = 200 }
for_s = 5
[[item]]
overlay = { file = "gone.png" }
"""


def write(path, shade=200, size=(32, 32)):
    Image.new("RGBA", size, (shade, 0, 0, 128)).save(path)
    return path


def test_overlays_that_cannot_be_shown_are_named_with_their_items(tmp_path):
    path = tmp_path / "show.toml"
    path.write_text(SHOW)
    write(tmp_path / "title.png", size=(32, 31))
    wide, gone = map(str, overlay_faults(load_show(path), path))
    assert wide.endswith("title.png: 32×31 pixels, expected a square of 16 to 8192")
    assert "show.toml:4: item 1: " in wide
    assert "item 2: " in gone and gone.endswith("gone.png: no such file")


def test_a_node_shows_the_overlay_of_its_master_once_it_has_the_file(tmp_path):
    (tmp_path / "master").mkdir()
    write(tmp_path / "master/title.png")
    shown, named = read_overlay(tmp_path / "master", OverlayFile("title.png", 20.0, 200.0))
    assert shown.pixels.shape == (32, 32, 4) and named.digest
    told = []
    node = MasterOverlay(tmp_path, told.append)
    assert node.follow(None) is None and node.follow(named) is None
    assert node.follow(named) is None and len(told) == 1  # one line, not one for each picture
    assert told[0] == f"{tmp_path}/title.png: no such file; the sea is shown without it"
    node.follow(None)
    write(tmp_path / "title.png", shade=100)
    assert node.follow(named) is None
    assert "title.png: differs from the master's; copy it from there" in told[1]
    node.follow(None)
    write(tmp_path / "title.png")
    (got, tilt, angle), (wanted, *angles) = node.follow(named), shown
    np.testing.assert_array_equal(got, wanted)
    assert [tilt, angle] == angles and len(told) == 2
    assert node.follow(named) is node.follow(named)  # read once
    assert node.follow(None) is None


def test_a_picture_carries_the_name_of_the_overlay():
    presented = NOTHING.__class__(overlay=OverlayFile("a/title.png", 27.0, 180.0, "0f" * 8))
    picture = messages.picture_of(3, 4, 0.5, [], "", presented=presented)
    data = messages.encode(picture)
    assert messages.from_master(data).presented == presented and len(data) < 400
    bad = messages.encode(messages.picture_of(3, 4, 0.5, [], "", presented=NOTHING.__class__(
        overlay=OverlayFile("x" * 1001, 27.0, 180.0))))  # fmt: skip
    with pytest.raises(UserError, match="not one of subsea"):
        messages.from_master(bad)
