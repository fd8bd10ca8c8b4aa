"""nDisplay configurations: screens of a left-handed scene in centimetres, nodes and eyes."""

import json

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from tests.support import theatre_samples as samples

CORNERS = np.array([[0, 0], [1, 0], [0, 1]])


def loaded(folder, content):
    (folder / "a.ndisplay").write_text(json.dumps(content))
    return load_theatre(str(folder / "a.ndisplay"))


@pytest.fixture
def content():
    return samples.ndisplay()


def test_screens_hang_where_their_parents_put_them(tmp_path, content):
    theatre, path = loaded(tmp_path, content)
    channels, faults = usable_channels(theatre, path)
    assert faults == ()
    front, right = (points_on(one.screen, CORNERS) for one in channels)
    # As seen from the eye, 100 cm up: 1.5 m ahead, 3 m wide, 2 m high.
    np.testing.assert_allclose(front, [[-150, -100, 150], [150, -100, 150], [-150, 100, 150]])
    np.testing.assert_allclose(right, [[150, -100, 150], [150, -100, -150], [150, 100, 150]])
    assert theatre.eye_cm == (0, 100, 0)
    assert theatre.eye_distance_cm == 6.4
    assert [one.eye for one in channels] == [None, "left"]


def test_pitch_turns_a_screen_up_and_roll_clockwise(tmp_path, content):
    screen = content["nDisplay"]["scene"]["screens"]["front"]
    screen["location"] = samples.xyz(0, 0, 90)
    screen["parentId"] = "tilted"
    content["nDisplay"]["scene"]["xforms"]["tilted"] = {
        "parentId": "origin", "location": samples.xyz(0, 0, 90),
        "rotation": {"pitch": 90, "yaw": 0, "roll": 0},
    }  # fmt: skip
    screen["location"] = samples.xyz(120, 0, 0)
    theatre, path = loaded(tmp_path, content)
    (front, _), _ = usable_channels(theatre, path)
    ceiling = points_on(front.screen, CORNERS)
    np.testing.assert_allclose(ceiling[:, 1], 120)
    # Its upper edge is behind.
    np.testing.assert_allclose(ceiling[2] - ceiling[0], [0, 0, -200], atol=1e-3)
    screen["rotation"] = {"pitch": 0, "yaw": 0, "roll": 90}
    theatre, path = loaded(tmp_path, content)
    (front, _), _ = usable_channels(theatre, path)
    rolled = points_on(front.screen, CORNERS)
    np.testing.assert_allclose(rolled[2] - rolled[0], [200, 0, 0], atol=1e-3)


def test_nodes_are_computers_and_the_primary_is_the_master(tmp_path, content):
    theatre, _ = loaded(tmp_path, content)
    assert theatre.nodes == ("node_front", "node_right")
    assert theatre.cluster.master == "node_front"
    assert theatre.window[1].position == (600, 0)
    content["nDisplay"]["cluster"]["masterNode"] = {"id": "node_right"}
    del content["nDisplay"]["cluster"]["primaryNode"]
    theatre, _ = loaded(tmp_path, content)
    assert theatre.cluster.master == "node_right"


def test_a_full_screen_without_a_size_is_as_large_as_its_regions(tmp_path, content):
    node = content["nDisplay"]["cluster"]["nodes"]["node_front"]
    node |= {"fullScreen": True, "window": {"x": 0, "y": 0, "w": 0, "h": 0}}
    theatre, _ = loaded(tmp_path, content)
    assert theatre.window[0].size == (600, 400) and theatre.window[0].monitor == 1


def test_two_eyes_at_one_place_are_one_channel_for_both(tmp_path, content):
    scene = content["nDisplay"]["scene"]
    scene["cameras"]["right"] = scene["cameras"]["left"] | {"stereoOffset": "right"}
    node = content["nDisplay"]["cluster"]["nodes"]["node_right"]
    other = json.loads(json.dumps(node["viewports"]["vp_right"])) | {"camera": "right"}
    node["viewports"]["vp_right_RE"] = other
    theatre, _ = loaded(tmp_path, content)
    assert [one.name for one in theatre.channel] == ["vp_front", "vp_right"]
    assert theatre.channel[1].eye is None
    assert any("'vp_right_RE'" in line and "for both" in line for line in theatre.left_out)


def test_the_eye_is_at_the_camera_that_sees_most_screens(tmp_path, content):
    """A tracked camera often lies on the floor of the file, where its tracker begins."""
    scene = content["nDisplay"]["scene"]
    for name in ("head", "left"):
        scene["cameras"][name]["location"] = samples.xyz(400, 400, 0)
    scene["cameras"]["seat"] = scene["cameras"]["head"] | {"location": samples.xyz(0, 0, 50)}
    theatre, _ = loaded(tmp_path, content)
    assert theatre.eye_cm == (0, 60, 0)
    assert any("camera 'seat'" in line for line in theatre.left_out)


@pytest.mark.parametrize("kind", ["vioso", "Camera", "nonsense"])
def test_other_policies_are_left_out_with_a_line(kind, tmp_path, content):
    viewport = content["nDisplay"]["cluster"]["nodes"]["node_right"]["viewports"]["vp_right"]
    viewport["projectionPolicy"]["type"] = kind
    theatre, _ = loaded(tmp_path, content)
    assert [one.name for one in theatre.channel] == ["vp_front"]
    assert any(kind.lower() in line.lower() for line in theatre.refused)


def test_circles_and_unknown_parents_are_left_out_with_a_line(tmp_path, content):
    scene = content["nDisplay"]["scene"]
    scene["xforms"]["side"]["parentId"] = "side"
    theatre, _ = loaded(tmp_path, content)
    assert any("a circle of them" in line for line in theatre.refused)
    scene["xforms"]["side"]["parentId"] = "nowhere"
    theatre, _ = loaded(tmp_path, content)
    assert any("parent 'nowhere'" in line for line in theatre.refused)


def test_keys_that_are_not_read_are_listed(tmp_path, content):
    node = content["nDisplay"]["cluster"]["nodes"]["node_front"]
    node["outputRemap"] = {"bEnable": True}
    node["viewports"]["vp_front"]["overscan"] = {"left": 5}
    theatre, _ = loaded(tmp_path, content)
    assert "keys with no counterpart here: `outputRemap`, `overscan`" in theatre.left_out


def test_faulty_files_are_refused_in_a_line(tmp_path, content):
    content["nDisplay"]["scene"]["screens"]["front"]["size"]["width"] = "wide"
    with pytest.raises(UserError, match="width"):
        loaded(tmp_path, content)
    with pytest.raises(UserError, match="missing key"):
        loaded(tmp_path, {"nDisplay": {}})
