"""Theatres on the command line: working channels show, each fault is one line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.base.errors import UserError
from subsea.base.system import resource_names
from subsea.cli import main
from subsea.fish.species import repertoire_file
from subsea.scenario.load import load_scenario
from subsea.stage.cluster.keys import write_keys
from subsea.stage.cluster.link import cluster_faults, credentials
from subsea.stage.setup import (
    describe,
    set_up_theatre,
    shrink_theatre,
    theatre_digest,
)
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.theatre_file import FOLDER, Channel, Cluster, Dome, Theatre, Window
from subsea.view.display_rigs import chosen_rig
from subsea.view.display_rigs import theatre_digest as digest_of
from subsea.view.stereo import Stereo
from tests.support import theatre_samples

BAD = """
[[window]]
name = "a"
size = [64, 48]
position = [0, 0]

[[window]]
name = "b"
size = [64, 48]
position = [64, 0]

[[channel]]
name = "good"
window = "a"
dome = {}

[[channel]]
name = "behind"
window = "b"
plane = { lower_left = [1, 0, 1], lower_right = [0, 0, 1], upper_left = [1, 1, 1] }
"""

NEAR = """
plane = { lower_left = [-50, 0, 40], lower_right = [-50, 0, 140], upper_left = [-50, 9, 40] }
"""
OTHER = '[[channel]]\nname = "behind"\nwindow = "b"\n'


def line_of(path, text):
    """The number of the line of a file that equals this text."""
    return path.read_text().splitlines().index(text) + 1


@pytest.mark.parametrize("name", resource_names(FOLDER, ".toml"))
def test_the_command_describes_a_theatre(capsys, name):
    assert describe(name) == 0
    out = capsys.readouterr().out
    theatre, path = load_theatre(name)
    assert out.startswith(f"{path}: {theatre.title}\n")
    for window in theatre.window:
        assert f"window {window.name}: {window.size[0]}x{window.size[1]} pixels" in out
    for channel in theatre.channel:
        assert f"  channel {channel.name}: " in out


def test_a_faulty_channel_is_reported_and_left_out(tmp_path, capsys):
    path = tmp_path / "bad.toml"
    path.write_text(BAD)
    assert main.main(["theatre", str(path)]) == 1
    out, line = capsys.readouterr().out, line_of(path, 'name = "behind"') - 1
    assert f"does not work: {path}:{line}: channel 'behind': the eye is behind the screen" in out
    house = set_up_theatre(str(path))
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "channel 'behind': the eye is behind the screen" in said
    assert said.rstrip().endswith("left out")
    assert [window.name for window in house.windows] == ["a"]
    assert house.rig.outputs == ((64, 48),)


def test_a_screen_that_one_eye_cannot_see_is_left_out(tmp_path, capsys):
    path = tmp_path / "near.toml"
    path.write_text(BAD[: BAD.rindex("plane")] + NEAR)
    assert len(set_up_theatre(str(path), "anaglyph").windows) == 2
    assert capsys.readouterr().err == ""
    house = set_up_theatre(str(path), "anaglyph", Stereo(separation_cm=110.0))
    assert [window.name for window in house.windows] == ["a"]
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    line = line_of(path, 'name = "behind"') - 1
    assert f"{path}:{line}: channel 'behind': the eye is behind the screen" in said
    path.write_text("".join(path.read_text().partition("[[channel]]")[0]) + OTHER + NEAR)
    with pytest.raises(UserError, match=r"near\.toml:\d+: channel 'behind': the eye is behind"):
        set_up_theatre(str(path), "anaglyph", Stereo(separation_cm=110.0))


@pytest.mark.parametrize("change", ["theatre.toml", "left.obj", "all.mpcdi"])
def test_the_digest_depends_on_calibration_files(tmp_path, change):
    path = tmp_path / "theatre.toml"
    path.write_text(BAD + 'warp = "left.obj"\n[[mpcdi]]\nfile = "all.mpcdi"\n')
    (tmp_path / "left.obj").write_bytes(b"one")
    before = theatre_digest(str(path))
    assert before != theatre_digest("cave")
    (tmp_path / "all.mpcdi").write_bytes(b"two")
    both = theatre_digest(str(path))
    assert both not in (before, None)
    assert both == theatre_digest(str(path))
    with (tmp_path / change).open("ab") as file:
        file.write(b" ")
    assert theatre_digest(str(path)) != both
    assert digest_of(None) is None
    assert digest_of(str(path)) == theatre_digest(str(path))


@given(
    edge=st.integers(16, 284),
    size=st.tuples(st.integers(300, 700), st.integers(16, 900)),
    times=st.integers(1, 64),
)
def test_shrunk_viewports_stay_adjacent_and_inside_their_window(edge, size, times):
    sides = ((0, 0, edge, size[1]), (edge, 0, size[0] - edge, size[1]))
    theatre = Theatre(
        window=[Window(name="a", size=size)],
        channel=[
            Channel(name=str(k), window="a", viewport=side, dome=Dome())
            for k, side in enumerate(sides)
        ],
    )
    try:
        small = shrink_theatre(theatre, times)
    except UserError as fault:
        assert f"--shrink {times} leaves" in str(fault)
        assert min(edge, size[0] - edge, size[1]) < 17 * times
        return
    (x, y, wide, high), (right, _, rest, _) = (one.viewport for one in small.channel)
    assert (x, y) == (0, 0)
    assert right == wide
    assert right + rest <= small.window[0].size[0]
    assert high <= small.window[0].size[1]
    assert min(wide, high, rest) >= 16
    assert abs(wide - edge / times) < 1


def test_shrinking_too_much_is_refused(tmp_path, capsys):
    path = tmp_path / "a.toml"
    path.write_text(BAD.replace('"good"', '"good"\nviewport = [0, 0, 30, 48]'))
    for times, left in ((2, "15x24 pixels of channel 'good'"), (4, "16x12 pixels of window 'a'")):
        assert main.main(["film", "x.mp4", "--theatre", str(path), "--shrink", str(times)]) == 2
        err = capsys.readouterr().err
        assert f"--shrink {times} leaves {left}, expected 16 or more a side" in err
        assert err.count("\n") == 1
    assert set_up_theatre("three-projectors", shrink=62).rig.outputs[0] == (23, 16)
    with pytest.raises(UserError, match=r"--shrink 64 leaves 22x15 pixels of window 'left'"):
        set_up_theatre("three-projectors", shrink=64)


def test_shrinking_keeps_the_geometry():
    whole, small = (set_up_theatre("three-projectors", shrink=n) for n in (1, 4))
    assert small.rig.outputs == ((360, 250),) * 3
    assert [w.position for w in small.windows] == [(0, 0), (360, 0), (720, 0)]
    for one, other in zip(whole.rig.eyes, small.rig.eyes, strict=True):
        np.testing.assert_allclose(one.axes, other.axes)
    for one, other in zip(whole.rig.patches, small.rig.patches, strict=True):
        np.testing.assert_allclose(one.warp.vertices, other.warp.vertices)
    assert chosen_rig("mono", (64, 48))[0].outputs == ((64, 48),)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("theatre domes", "unknown theatre 'domes'; did you mean 'dome'?"),
        ("theatre no/such.toml", "no/such.toml: no such file"),
        ("benchmark --theatre cave --display dome", "--display dome: the displays of a theatre"),
        ("benchmark --shrink 2", "--shrink needs --theatre"),
        ("dive --shrink 2", "--shrink needs --theatre"),
        ("dive --theatre cave --fullscreen", "dive: --fullscreen is defined by the --theatre file"),
        ("dive --theatre cave --size 1280x720", "--size is defined by"),
        ("benchmark --theatre cave --size 640x360", "benchmark: --size is defined by"),
        ("film a.png --theatre cave --dome-tilt 0", "--dome-tilt is defined by the --theatre file"),
        ("film a.png --theatre cave --panorama-angle 90", "--panorama-angle is defined"),
        ("film a.png --theatre cave --screen-width 90", "--screen-width is defined"),
        ("dive --theatre cave --screen-distance 90", "--screen-distance is defined"),
        ("dive --theatre cave --node left", "cave.toml: has no [cluster]; drop"),
        ("dive --theatre cavern", "unknown theatre 'cavern'; did you mean 'cave'?"),
    ],
)
def test_wrong_options_are_one_line(capsys, command, said):
    assert main.main(command.split()) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1


def test_an_unknown_node_is_refused():
    with pytest.raises(UserError, match=r"unknown node 'rigth'; did you mean 'right'\?"):
        set_up_theatre("three-computers", node="rigth")
    assert set_up_theatre("three-computers", node="left").windows[0].name == "left"


CLUSTER = """
[cluster]
master = "main"
address = "192.0.2.7:5560"
"""


def test_faults_of_a_cluster_are_reported(tmp_path, capsys):
    def judged(more):
        path.write_text(BAD.partition('\n[[channel]]\nname = "behind"')[0] + CLUSTER + more)
        code = main.main(["theatre", str(path)])
        return code, capsys.readouterr().out.partition("does not work: ")[2].rstrip()

    path = tmp_path / "hall.toml"
    code, fault = judged("")
    assert (code, fault.count("\n")) == (1, 0)
    assert fault.startswith(
        f"{path}:{line_of(path, '[cluster]')}: [cluster]: address '192.0.2.7:5560': "
    )
    code, fault = judged('keys = "ours"')
    assert code == 1
    assert f": [cluster]: {tmp_path / 'ours' / 'main.key_secret'}: no such file" in fault
    write_keys(tmp_path / "ours", ["main"])
    assert judged('keys = "ours"') == (0, "")
    (tmp_path / "ours" / "main.key_secret").chmod(0o644)
    code, fault = judged('keys = "ours"')
    assert code == 1
    assert "others may read it" in fault


def test_only_keys_on_this_computer_are_checked(tmp_path):
    cluster = Cluster(master="middle", address="192.0.2.7:5560", keys="ours")
    nodes, path, ours = ("left", "middle", "right"), tmp_path / "hall.toml", tmp_path / "ours"
    write_keys(ours, nodes)
    assert cluster_faults(cluster, nodes, path) == ()
    for node in ("middle", "right"):
        (ours / f"{node}.key_secret").unlink()
    (ours / "right.key").unlink()
    assert cluster_faults(cluster, nodes, path) == ()  # left needs the master's and its own
    (ours / "middle.key").unlink()
    [fault] = cluster_faults(cluster, nodes, path)
    assert "middle.key: no such file" in str(fault)
    with pytest.raises(UserError, match=r"hall\.toml: \[cluster\]: .*middle\.key: no such file"):
        credentials(cluster, nodes, "left", path)


def test_each_computer_plays_its_own_loudspeakers(tmp_path):
    file = tmp_path / "theatre.toml"
    windows = """
[[window]]
name = "a"
size = [64, 48]

[[window]]
name = "b"
size = [64, 48]
node = "side"

[[channel]]
name = "left"
window = "a"
dome = {}

[[channel]]
name = "right"
window = "b"
dome = {}

[cluster]
master = "main"
"""
    file.write_text(windows)
    assert set_up_theatre(str(file), node="main").loudspeakers is None
    file.write_text(
        windows + "[[loudspeaker]]\nazimuth_deg = -90\n[[loudspeaker]]\nazimuth_deg = 0\n"
        "elevation_deg = 90\n"
    )
    layout = set_up_theatre(str(file), node="main").loudspeakers
    assert layout.directions == pytest.approx(np.array([[-1, 0, 0], [0, 0, 1]]), abs=1e-9)
    assert set_up_theatre(str(file), node="side").loudspeakers.channels == 0
    file.write_text(windows + '[[loudspeaker]]\nazimuth_deg = 0\nnode = "sied"\n')
    with pytest.raises(UserError, match="unknown node 'sied'"):
        set_up_theatre(str(file))


def imported(folder):
    """An SGCT configuration of every projection, with its meshes."""
    square = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1 2 3 4\n"
    for face in ("bottom", "left", "right", "top"):
        (folder / f"{face}.obj").write_text(square)
    (folder / "mesh.sgc").write_bytes(theatre_samples.sgc())
    x, y = np.meshgrid(np.linspace(0, 1, 8), np.linspace(1, 0, 6))
    numbers = np.dstack([x, y, 0 * x]).astype("<f4")
    (folder / "mesh.pfm").write_bytes(b"PF\n8 6\n-1.0\n" + numbers.tobytes())
    content = theatre_samples.sgct(theatre_samples.viewports())
    content["nodes"][0]["windows"][0] |= {"size": {"x": 1800, "y": 200}, "msaa": 4}
    (folder / "dome.json").write_bytes(theatre_samples.text(content))
    return str(folder / "dome.json")


def test_the_command_describes_and_writes_a_theatre_of_another_program(tmp_path, capsys):
    name, out = imported(tmp_path), tmp_path / "out" / "dome.toml"
    assert main.main(["theatre", name, "--write", str(out)]) == 0
    said = capsys.readouterr().out
    assert f"wrote {out}" in said
    assert "left out: keys with no counterpart here: `msaa`" in said
    assert main.main(["theatre", str(out)]) == 0
    again = capsys.readouterr().out
    channels = [line for line in said.splitlines() if line.startswith("  channel")]
    assert len(channels) > 12  # a cube has faces, a cylinder quarters
    ours = [line for line in again.splitlines() if line.startswith("  channel")]
    assert [line.partition(" warped")[0] for line in channels] == [
        line.partition(" warped")[0] for line in ours
    ]
    assert main.main(["theatre", name, "--write", str(out)]) == 2
    assert "--force" in capsys.readouterr().err


def test_a_theatre_of_another_program_has_a_rig_and_says_what_it_lacks(tmp_path, capsys):
    house = set_up_theatre(imported(tmp_path), shrink=2)
    assert house.rig.outputs == ((900, 100),)
    assert "left out: keys with no counterpart" in capsys.readouterr().err


def test_the_digest_of_a_theatre_covers_composed_meshes(tmp_path):
    name = imported(tmp_path)
    before = theatre_digest(name)
    assert before == theatre_digest(name)
    top = tmp_path / "top.obj"
    top.write_text(top.read_text().replace("vt 1 1", "vt 0.9 1"))
    assert theatre_digest(name) != before


def test_a_file_that_exists_is_not_called_unknown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.xml").write_text("<a/>")
    for name in ("room.xml", str(tmp_path / "room.xml")):
        with pytest.raises(UserError, match=r"expected a theatre file that ends in \.toml, \.json"):
            load_theatre(name)
    with pytest.raises(UserError, match=r"room.xml: expected a scenario file that ends in \.toml"):
        load_scenario("room.xml")
    with pytest.raises(UserError, match=r"room.xml: expected a species file that ends in \.h5"):
        repertoire_file("room.xml")
    with pytest.raises(UserError, match=r"unknown theatre 'room\.obi'"):
        load_theatre("room.obi")
