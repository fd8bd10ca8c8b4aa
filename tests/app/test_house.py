"""Theatres on the command line: what works is shown, what does not is one line."""

import numpy as np
import pytest

from subsea.app import cli
from subsea.app.house import chosen_rig, describe, open_house
from subsea.errors import UserError
from subsea.resources import resource_names
from subsea.theatre.files import FOLDER, load_theatre

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


@pytest.mark.parametrize("name", resource_names(FOLDER, ".toml"))
def test_a_theatre_tells_what_it_has(capsys, name):
    assert describe(name) == 0
    told = capsys.readouterr().out
    theatre, path = load_theatre(name)
    assert told.startswith(f"{path}: {theatre.title}\n")
    for window in theatre.window:
        assert f"window {window.name}: {window.size[0]}x{window.size[1]} pixels" in told
    for channel in theatre.channel:
        assert f"  channel {channel.name}: " in told


def test_what_does_not_work_is_told_and_the_rest_goes_on(tmp_path, capsys):
    path = tmp_path / "bad.toml"
    path.write_text(BAD)
    assert cli.main(["theatre", str(path)]) == 1
    out = capsys.readouterr().out
    assert f"does not work: {path}: channel 'behind': the eye is behind the screen" in out
    house = open_house(str(path))
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "channel 'behind': the eye is behind the screen" in said
    assert said.rstrip().endswith("left out")
    assert [window.name for window in house.windows] == ["a"]
    assert house.rig.outputs == ((64, 48),)


def test_shrinking_keeps_the_geometry():
    whole, small = (open_house("three-projectors", shrink=n) for n in (1, 4))
    assert small.rig.outputs == ((360, 250),) * 3
    assert [w.position for w in small.windows] == [(0, 0), (360, 0), (720, 0)]
    for one, other in zip(whole.rig.eyes, small.rig.eyes, strict=True):
        np.testing.assert_allclose(one.axes, other.axes)
    for one, other in zip(whole.rig.patches, small.rig.patches, strict=True):
        np.testing.assert_allclose(one.warp.vertices, other.warp.vertices)
    assert chosen_rig("mono", (64, 48))[0].outputs == ((64, 48),)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["theatre", "domes"], "unknown theatre 'domes'; did you mean 'dome'?"),
        (["theatre", "no/such.toml"], "no/such.toml: cannot read"),
        (["benchmark", "--theatre", "cave", "--display", "dome"], "display for a theatre 'dome'"),
        (["benchmark", "--shrink", "2"], "--shrink is of a --theatre"),
        (["dive", "--shrink", "2"], "--shrink is of a --theatre"),
        (
            ["dive", "--theatre", "cave", "--fullscreen"],
            "dive: the --theatre file says itself what --fullscreen says",
        ),
        (["dive", "--theatre", "cave", "--size", "1280x720"], "what --size says"),
        (["benchmark", "--theatre", "cave", "--size", "640x360"], "benchmark: the --theatre file"),
        (["film", "a.png", "--theatre", "cave", "--dome-tilt", "0"], "what --dome-tilt says"),
        (["film", "a.png", "--theatre", "cave", "--panorama-angle", "90"], "--panorama-angle says"),
        (["film", "a.png", "--theatre", "cave", "--screen-width", "90"], "--screen-width says"),
        (["dive", "--theatre", "cave", "--screen-distance", "90"], "--screen-distance says"),
        (["dive", "--theatre", "cavern"], "unknown theatre 'cavern'; did you mean 'cave'?"),
    ],
)
def test_wrong_options_are_one_line(capsys, arguments, said):
    assert cli.main(arguments) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1


def test_a_node_that_is_not_there():
    with pytest.raises(UserError, match=r"unknown node 'rigth'; did you mean 'right'\?"):
        open_house("three-computers", node="rigth")
    assert open_house("three-computers", node="left").windows[0].name == "left"
