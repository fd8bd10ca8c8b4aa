"""Theatre files: each fault is one line that names file and key."""

from itertools import combinations, pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.base.system import resource_names
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_file import FOLDER, parse_address
from subsea.view.rig import overlap

WINDOW = '[[window]]\nname = "a"\nsize = [640, 360]\n'
CHANNEL = '[[channel]]\nname = "c"\nwindow = "a"\n'
PLANE = "plane = { lower_left = [-1, -1, 1], lower_right = [1, -1, 1], upper_left = [-1, 1, 1] }\n"


def written(tmp_path, text):
    path = tmp_path / "theatre.toml"
    path.write_text(text)
    return str(path)


@pytest.mark.parametrize("name", resource_names(FOLDER, ".toml"))
def test_the_windows_of_a_shipped_theatre_do_not_cover_each_other(name):
    """On one computer with one monitor, which also shows the windows of all nodes."""
    windows = load_theatre(name)[0].window
    assert len(windows) == 1 or all(one.monitor is None for one in windows)
    rects = [(*one.position, *one.size) for one in windows if one.position is not None]
    assert len(rects) == len(windows) or len(windows) == 1
    for one, other in combinations(rects, 2):
        assert not overlap(one, other)


def test_a_screen_of_several_projectors_is_as_large_as_its_picture_is_seamless():
    """Three projectors of 1440 pixels that overlap by 160: 4000 over 5.5 m along the curve."""
    theatre, _ = load_theatre("three-projectors")
    edges = [(c.cylinder.left_deg, c.cylinder.right_deg) for c in theatre.channel]
    turn = edges[-1][1] - edges[0][0]
    radius = theatre.channel[0].cylinder.radius_cm
    assert 2 * 3.14159 * radius * turn / 360 == pytest.approx(550.0, abs=0.5)
    pixel = turn / 4000
    for (left, right), (following, _) in pairwise(edges):
        assert (right - left) / 1440 == pytest.approx(pixel, rel=1e-3)
        assert (right - following) / pixel == pytest.approx(160, abs=0.5)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (WINDOW, "shows nothing, expected at least one `channel`"),
        (WINDOW + CHANNEL, "expected one of plane, cylinder, .* got none, at `channel"),
        (WINDOW + CHANNEL + "dome = {}\npanorama = {}", "got `panorama` and `dome`"),
        (WINDOW + CHANNEL + "dome = { tilt = 3 }", "unknown key `tilt`.*did you mean 'tilt_deg'"),
        (WINDOW + WINDOW + CHANNEL + PLANE, "2 windows are called 'a', expected 1"),
        (WINDOW + 2 * (CHANNEL + PLANE), "2 channels are called 'c'"),
        (WINDOW + CHANNEL.replace('"a"', '"b"') + PLANE, "channel 'c': unknown window 'b'"),
        (WINDOW + CHANNEL + "viewport = [8, 0, 640, 360]\n" + PLANE, "reaches out of window 'a'"),
        (
            WINDOW
            + CHANNEL.replace('"c"', '"one"')
            + PLANE
            + CHANNEL.replace('"c"', '"two"')
            + PLANE,
            "'one' and 'two' lie on one another in window 'a'",
        ),
        (
            WINDOW + "monitor = 1\n" + WINDOW.replace('"a"', '"b"') + "monitor = 1\n" + CHANNEL
            + PLANE,
            "'a' and 'b' both fill monitor 1",
        ),
        (
            WINDOW + "position = [0, 0]\n" + WINDOW.replace('"a"', '"b"') + "position = [639, 9]\n"
            + CHANNEL + PLANE,
            "'a' and 'b' lie on one another; expected places side by side",
        ),
        (WINDOW + "position = [0, 0]\nmonitor = 1\n" + CHANNEL + PLANE, "expected one"),
        (WINDOW + 'node = "x"\n' + WINDOW.replace('"a"', '"b"') + CHANNEL + PLANE, "the `master`"),
        (WINDOW + CHANNEL + PLANE + '[cluster]\nmaster = "x"', "unknown node 'x'.* main"),
        (
            WINDOW + CHANNEL + PLANE + '[cluster]\nmaster = "main"\naddress = "stage:80"',
            "address 'stage:80': expected an IP address and a port",
        ),
        *(
            (WINDOW.replace('"a"', name) + CHANNEL + PLANE, "text that matches .* at `window")
            for name in ('"a\\n"', '"-a"', '"ä"', '""', f'"{65 * "a"}"')
        ),
        (WINDOW + CHANNEL + PLANE + "gamma = 9", "at `channel"),
        (WINDOW + CHANNEL + PLANE + 'warp = "//host/a.obj"', "at `channel"),
        (WINDOW + CHANNEL + PLANE + "mask = '\\\\host\\a.png'", "at `channel"),
        (WINDOW + CHANNEL + "dome = { distance_cm = 20 }", "at least 50, got 20"),
        (WINDOW + '[[mpcdi]]\nfile = "a.mpcdi"\nblend = true', "unknown key `blend`"),
        ("[[window]", "not valid TOML"),
    ],
)  # fmt: skip
def test_errors_of_the_whole_file_are_one_line(tmp_path, text, said):
    with pytest.raises(UserError, match=rf"^{tmp_path}/theatre.toml(:\d+)?: .*{said}"):
        load_theatre(written(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (WINDOW + "wide = 3\n" + CHANNEL + PLANE, 4),
        (WINDOW + WINDOW + CHANNEL + PLANE, 5),
        (WINDOW + CHANNEL.replace('"a"', '"b"') + PLANE, 6),
        (WINDOW + CHANNEL + PLANE + '[cluster]\nmaster = "x"\naddress = "127.0.0.1:80"', 9),
        (WINDOW + CHANNEL + "\nplane = {\n" + PLANE[9:], None),
        (WINDOW + "position = [0, 0]\n\nmonitor = 1\n" + CHANNEL + PLANE, 4),
        (WINDOW + '[[mpcdi]]\nfile = "a.mpcdi"\nwindows = { r = "b" }', 6),
    ],
)
def test_the_line_is_that_of_the_key(tmp_path, text, line):
    path = written(tmp_path, text)
    with pytest.raises(UserError, match=rf"^{path}:{line or '[0-9]+'}: "):
        load_theatre(path)


def test_an_unknown_name_says_which_there_are():
    with pytest.raises(UserError, match=r"unknown theatre 'domes'; did you mean 'dome'\?"):
        load_theatre("domes")


SQUINT = "plane = { lower_left = [-1, -1, 1], lower_right = [1, -1, 1], upper_left = [0, 1, 1] }\n"
BEHIND = "plane = { lower_left = [1, -1, 1], lower_right = [-1, -1, 1], upper_left = [1, 1, 1] }\n"
POINT = "plane = { lower_left = [1, -1, 1], lower_right = [1, -1, 1], upper_left = [1, 1, 1] }\n"
ASLANT = (
    "plane = { lower_left = [0, -1, 99], lower_right = [0.2, -1, 1], upper_left = [0, 1, 99] }\n"
)
CYLINDER = (
    "cylinder = {{ radius_cm = {}, left_deg = {}, right_deg = {}, bottom_cm = -9, top_cm = 9{} }}\n"
)


@pytest.mark.parametrize(
    ("screen", "said"),
    [
        (SQUINT, "no right angle at `lower_left`"),
        (BEHIND, "the eye is behind the screen"),
        (POINT, "two corners are one point"),
        (ASLANT, "too much from the side|behind"),
        (CYLINDER.format(9, 30, -30, ""), "`left_deg` less than `right_deg`"),
        (CYLINDER.format(9, -100, 100, ""), "half a turn or more, expected several channels"),
        (CYLINDER.format(9, -10, 10, ", axis_cm = [0, 9.5]"), "the eye is outside of it"),
        (PLANE + 'warp = "nowhere.obj"\n', "nowhere.obj"),
        ('dome = {}\nwarp = "a.obj"\n', "a.obj"),
        ("dome = {}\nblend = true\n", "`blend` is of a `plane`"),
        (
            "angles = { left_deg = 5, right_deg = -5, down_deg = -5, up_deg = 5 }\n",
            "`left_deg` less than `right_deg`",
        ),
    ],
)
def test_a_channel_that_cannot_be_is_one_line_and_the_others_go_on(tmp_path, screen, said):
    path = written(tmp_path, WINDOW + CHANNEL + screen)
    with pytest.raises(UserError, match=f"^{path}:4: channel 'c': .*({said})"):
        usable_channels(*load_theatre(path))
    good = WINDOW.replace('"a"', '"b"') + '[[channel]]\nname = "good"\nwindow = "b"\n' + PLANE
    found, faults = usable_channels(
        *load_theatre(written(tmp_path, WINDOW + CHANNEL + screen + good))
    )
    assert [one.name for one in found] == ["good"]
    assert len(faults) == 1
    assert "channel 'c'" in str(faults[0])


@given(st.ip_addresses(), st.integers(1, 65535))
def test_an_address_is_read_as_it_is_written(ip, port):
    text = f"[{ip}]:{port}" if ip.version == 6 else f"{ip}:{port}"
    assert parse_address(text) == (ip, port)


@pytest.mark.parametrize(
    "text", ["", "1.2.3.4", "host:5560", "1.2.3.4:0", "1.2.3.4:٣", "1.2.3.4:99999"]
)
def test_any_other_address_is_refused(text):
    with pytest.raises(ValueError, match="expected an IP address and a port"):
        parse_address(text)


LIGHTS = '[lights]\nprotocol = "artnet"\n'
LAMP = '[[lamp]]\nname = "one"\nchannel = 510\n'


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (LAMP, 8, r"lamps need a table \[lights\]"),
        (LIGHTS + LAMP + "fine = true\n", 12, "lamp 'one' takes channels 510 to 515, of 512"),
        (LIGHTS + LAMP + LAMP.replace("one", "two"), 15, "lamps 'one' and 'two' both take channel"),
        (LIGHTS + LAMP + "universe = 40000\n", 13, "universe 40000, expected 0 to 32767"),
        (LIGHTS.replace("artnet", "sacn") + LAMP + "universe = 0\n", 13, "expected 1 to 63999"),
        (LIGHTS + 'address = "desk"\n', 10, "'desk': expected an IP address"),
        (LIGHTS + LAMP + 'colours = "cmy"\n', 13, "'rgb'"),
    ],
)
def test_lamps_that_cannot_shine_are_refused(tmp_path, text, line, message):
    path = written(tmp_path, WINDOW + CHANNEL + PLANE + text)
    with pytest.raises(UserError, match=message) as refused:
        load_theatre(path)
    assert refused.value.line == line


def test_lamps_side_by_side_are_taken(tmp_path):
    text = LIGHTS + LAMP + LAMP.replace("one", "two").replace("510", "506") + "universe = 1\n"
    theatre, _ = load_theatre(written(tmp_path, WINDOW + CHANNEL + PLANE + text))
    assert [lamp.channels[-1] for lamp in theatre.lamp] == [512, 508]


NODE = '[[node]]\nname = "main"\nmac = "00:1a:2b:3c:4d:5e"\n'
PROJECTOR = '[[projector]]\nname = "left"\naddress = "192.168.10.41"\n'


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (NODE.replace("main", "lft"), 9, "unknown node 'lft'; there are: main"),
        (NODE + NODE, 12, "2 nodes are called 'main', expected 1"),
        (NODE.replace(":5e", ""), 10, "mac '00:1a:2b:3c:4d': expected six pairs of digits such as"),
        (NODE + 'wake = "192.168.10.255"\n', 11, "`wake`: .* expected an IP address and a port"),
        (PROJECTOR + PROJECTOR, 12, "2 projectors are called 'left', expected 1"),
        (PROJECTOR.replace("192.168.10.41", "dome"), 10, "'dome': expected an IP address such as"),
        (PROJECTOR + "port = 0\n", 11, "of at least 1"),
        (PROJECTOR + 'password = "//other/file"\n', 11, "password"),
    ],
)
def test_nodes_and_projectors_that_cannot_be_reached_are_refused(tmp_path, text, line, message):
    path = written(tmp_path, WINDOW + CHANNEL + PLANE + text)
    with pytest.raises(UserError, match=message) as refused:
        load_theatre(path)
    assert refused.value.line == line


def test_nodes_and_projectors_have_the_usual_ports(tmp_path):
    theatre, _ = load_theatre(written(tmp_path, WINDOW + CHANNEL + PLANE + NODE + PROJECTOR))
    assert theatre.node[0].wake == "255.255.255.255:9"
    assert theatre.projector[0].port == 4352
