"""A line-up in its theatre file: comments stay, the old file is kept, nothing is half-written."""

import msgspec
import pytest

from subsea.base.errors import UserError
from subsea.base.files import file_hash
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.line_up_file import AdjustedChannel, file_adjustment, save_line_up
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_file import Adjustment, Corners

THEATRE = """\
# The foyer, measured on Tuesday.
title = "Foyer"

[[window]]
name = "both"
size = [800, 200]   # two projectors on one card

# The left one hangs askew.
[[channel]]
name = "left"
window = "both"
viewport = [0, 0, 400, 200]
angles = { left_deg = -32, right_deg = 4, down_deg = -11, up_deg = 11 }
gamma = 2.2  # of its data sheet
blend = true

# The right one is new.
[[channel]]
name = "right"
window = "both"
viewport = [400, 0, 400, 200]
blend = true
[channel.plane]
lower_left = [-20, -60, 300]
lower_right = [188, -60, 300]
upper_left = [-20, 57, 300]

# Nobody sits here.
[room]
floor_cm = -120
"""
MOVED = Adjustment(
    corners_px=Corners(upper_left=(3.5, -2.0)),
    points_px=[[(0.0, 0.0)] * 4, [(0.0, 0.0), (1.25, 0.0), (0.0, 0.0), (0.0, 0.0)]],
    gamma=2.4,
    rotate=180,
)


@pytest.fixture
def foyer(tmp_path):
    path = tmp_path / "foyer.toml"
    path.write_text(THEATRE)
    return path


def channels(path):
    found, faults = usable_channels(*load_theatre(str(path)))
    assert not faults
    return found


def save(path, number=0, adjustment=MOVED, digest=None):
    adjusted = [AdjustedChannel(channels(path)[number], adjustment)]
    return save_line_up(path, digest or file_hash(path), adjusted)


def kept(text):
    """The lines that a save of `MOVED` leaves alone."""
    own = "corners_px", "points_px", "rotate", "gamma", "    [[", "upper_left = [3.5"
    lines = (line for line in text.splitlines() if not any(word in line for word in own))
    return [line for line in lines if line not in ("", "]")]


@pytest.mark.parametrize("number", [0, 1])
def test_only_the_keys_of_that_channel_change(foyer, number):
    digest = save(foyer, number)
    text = foyer.read_text()
    assert kept(text) == kept(THEATRE)
    assert "of its data sheet" in text
    theatre = load_theatre(str(foyer))[0]
    assert file_adjustment(theatre, channels(foyer)[number]) == MOVED
    assert file_adjustment(theatre, channels(foyer)[1 - number]) == Adjustment()
    assert digest == file_hash(foyer)
    assert max(map(len, text.splitlines())) < 120


def test_the_comment_of_the_next_table_stays_with_it(foyer):
    save(foyer)
    lines = foyer.read_text().splitlines()
    at = lines.index("# The right one is new.")
    assert lines[at + 1] == "[[channel]]" and lines[at - 1] == ""


def test_every_save_keeps_the_file_before(foyer):
    save(foyer)
    first = foyer.read_text()
    save(foyer, adjustment=msgspec.structs.replace(MOVED, gamma=2.0))
    assert foyer.with_name("foyer.toml.bak").read_text() == THEATRE
    assert foyer.with_name("foyer.toml.bak2").read_text() == first


def test_the_same_again_writes_nothing(foyer):
    save(foyer)
    before = foyer.read_bytes()
    save(foyer, digest="of another file")
    assert foyer.read_bytes() == before
    assert not foyer.with_name("foyer.toml.bak2").exists()


def test_defaults_go_but_keys_of_the_file_stay(foyer):
    save(foyer)
    save(foyer, adjustment=Adjustment())
    text = foyer.read_text()
    assert text.replace("rotate = 0\n", "") == THEATRE


def test_lines_end_as_before(foyer):
    foyer.write_bytes(THEATRE.replace("\n", "\r\n").encode())
    save(foyer)
    data = foyer.read_bytes()
    assert data.count(b"\r\n") == data.count(b"\n") > 30


@pytest.mark.parametrize("now", [THEATRE.replace("Tuesday", "Wednesday"), "[[channel", "", "x=1"])
def test_a_file_that_changed_meanwhile_is_one_line(foyer, now):
    digest, found = file_hash(foyer), channels(foyer)
    foyer.write_text(now)
    with pytest.raises(UserError) as told:
        save_line_up(foyer, digest, [AdjustedChannel(found[0], MOVED)])
    line = str(told.value)
    assert line.startswith(f"{foyer}: ") and "has changed on disk" in line and "\n" not in line
    assert foyer.read_text() == now
    assert [path.name for path in foyer.parent.iterdir()] == ["foyer.toml"]


def test_theatres_of_subsea_and_of_other_programs_are_left_alone(tmp_path):
    theatre, path = load_theatre("three-projectors")
    found = usable_channels(theatre, path)[0]
    before = path.read_bytes()
    with pytest.raises(
        UserError, match=r"belongs to subsea; .* three-projectors --write mine\.toml"
    ):
        save_line_up(path, file_hash(path), [AdjustedChannel(found[0], MOVED)])
    assert path.read_bytes() == before
    other = tmp_path / "dome.json"
    other.write_text("{}")
    with pytest.raises(UserError, match="another program's file"):
        save_line_up(other, file_hash(other), [])


@pytest.mark.parametrize("table", ["channel", "mpcdi"])
def test_inline_tables_and_regions_are_written_too(tmp_path, making, table):
    path = tmp_path / "hall.toml"
    window = '[[window]]\nname = "left"\nsize = [160, 120]\n'
    window += '[[window]]\nname = "right"\nsize = [160, 120]\n'
    if table == "channel":
        channel = 'name = "left", window = "left", angles = '
        channel += "{ left_deg = -30, right_deg = 30, down_deg = -20, up_deg = 20 }"
        path.write_text(f"channel = [ {{ {channel} }} ] # all\n{window}")
    else:
        (tmp_path / "foyer.mpcdi").write_bytes(making.zipped(making.parts(making.cylinder())))
        cylinder = "radius_cm = 275, left_deg = -57, right_deg = 57, bottom_cm = -125, top_cm = 125"
        path.write_text(
            f"# Calibrated.\n{window}"
            f'[[mpcdi]]\nfile = "foyer.mpcdi"\ncylinder = {{ {cylinder} }}\n'
            'windows = { left = "left", right = "right" } # the other one is off\n'
        )
    found = usable_channels(*load_theatre(str(path)))[0]
    save_line_up(path, file_hash(path), [AdjustedChannel(one, MOVED) for one in found])
    theatre = load_theatre(str(path))[0]
    assert [file_adjustment(theatre, one) for one in found] == [MOVED] * len(found)
    assert [one.adjustment for one in usable_channels(theatre, path)[0]] == [MOVED] * len(found)
    text = path.read_text()
    assert ("# all" in text) if table == "channel" else ("# the other one is off" in text)
