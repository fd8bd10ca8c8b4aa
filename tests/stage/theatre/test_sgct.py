"""SGCT configurations become the theatre that our own keys give, by closed forms."""

import json
import re

import numpy as np
import pytest
from PIL import Image

from subsea.base.errors import UserError
from subsea.stage.setup import describe
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.measured_mesh import dome_shares
from subsea.stage.theatre.screens import points_on, screen_of
from subsea.stage.theatre.theatre_file import Angles, Plane
from subsea.stage.theatre.theatre_rig import theatre_rig
from subsea.view.rig import sources_at
from subsea.view.surround import Surround, directions
from tests.support import theatre_samples as samples

CORNERS = np.array([[0, 0], [1, 0], [0, 1], [0.3, 0.8]])
xyz = samples.xyz


def loaded(folder, content, name="a.json"):
    path = folder / name
    path.write_text(json.dumps(content))
    return load_theatre(str(path))


def one_view(folder, projection, **more):
    """The channel of a window with this projection, and its theatre."""
    theatre, path = loaded(folder, samples.sgct([{"projection": projection, **more}]))
    (channel,), faults = usable_channels(theatre, path)
    assert faults == ()
    return channel, theatre


def planar(fov, **more):
    return {"type": "PlanarProjection", "fov": fov, **more}


def gl_frustum(fov, turn, user, distance, offset=(0, 0, 0)):
    """Rays (right, up, ahead) from a user to the corners of a planar view, as SGCT makes them."""
    yaw, pitch, roll = np.radians(turn)
    about = [
        np.array([[np.cos(yaw), 0, -np.sin(yaw)], [0, 1, 0], [np.sin(yaw), 0, np.cos(yaw)]]),
        np.array(
            [[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]]
        ),
        np.array([[np.cos(roll), np.sin(roll), 0], [-np.sin(roll), np.cos(roll), 0], [0, 0, 1]]),
    ]
    left, right, down, up = distance * np.tan(np.radians(fov))
    flat = [[left, down, -distance], [right, down, -distance], [left, up, -distance]]
    rays = np.array(flat) @ (about[0] @ about[1] @ about[2]).T + offset - user
    return rays * [1, 1, -1]


@pytest.mark.parametrize("user", [(0, 0, 0), (0.2, -0.1, 1.5)])
@pytest.mark.parametrize("turn", [(0, 0, 0), (35, 0, 0), (-50, 25, 40), (120, -30, -10)])
def test_a_planar_view_has_the_frustum_and_the_direction_of_sgct(turn, user, tmp_path):
    yaw, pitch, roll = turn
    fov = {"left": 30.0, "right": 40.0, "down": 15.0, "up": 25.0}
    orientation = {"yaw": yaw, "pitch": pitch, "roll": roll}
    view = planar(fov, orientation=orientation, distance=4.0)
    users = [{"eyeseparation": 0.065, "pos": xyz(*user)}]
    theatre, path = loaded(tmp_path, samples.sgct([{"projection": view}], users=users))
    (channel,), _ = usable_channels(theatre, path)
    seen = points_on(channel.screen, CORNERS[:3])
    expected = 100 * gl_frustum((-30, 40, -15, 25), turn, np.array(user), 4.0)
    np.testing.assert_allclose(seen, expected, atol=0.02)
    np.testing.assert_allclose(theatre.eye_cm, [100 * user[0], 100 * user[1], -100 * user[2]])


def test_a_view_by_angles_is_the_same_as_a_plane_through_its_corners(tmp_path):
    fov = {"hfov": 80.0, "vfov": 50.0}
    turned, _ = one_view(tmp_path, planar(fov, orientation={"yaw": 20, "pitch": 5, "roll": 0}))
    assert np.linalg.norm(np.cross(turned.screen.along, turned.screen.up)) > 0
    corners = points_on(turned.screen, CORNERS[:3])
    plane = Plane(lower_left=(*corners[0],), lower_right=(*corners[1],), upper_left=(*corners[2],))
    ours = screen_of(plane, np.zeros(3), 1.0)
    np.testing.assert_allclose(points_on(ours, CORNERS), points_on(turned.screen, CORNERS))
    by_angle = screen_of(
        Angles(left_deg=-40, right_deg=40, down_deg=-25, up_deg=25, heading_deg=20, pitch_deg=5,
               distance_cm=1000), np.zeros(3), 1.0,
    )  # fmt: skip
    np.testing.assert_allclose(points_on(by_angle, CORNERS), points_on(turned.screen, CORNERS))


def test_a_quaternion_turns_as_three_angles_do(tmp_path):
    fov = {"hfov": 60.0, "vfov": 40.0}
    half = np.radians(-30.0) / 2  # to the right is negative about y
    quaternion = {"x": 0.0, "y": np.sin(half), "z": 0.0, "w": np.cos(half)}
    one, _ = one_view(tmp_path, planar(fov, orientation=quaternion))
    other, _ = one_view(tmp_path, planar(fov, orientation={"yaw": 30, "pitch": 0, "roll": 0}))
    seen = points_on(one.screen, CORNERS), points_on(other.screen, CORNERS)
    np.testing.assert_allclose(*seen, atol=1e-2)
    assert seen[0][:, 0].mean() > 0  # to the right


def test_a_projection_plane_is_in_metres_with_y_up_and_z_astern(tmp_path):
    plane = {"type": "ProjectionPlane", "lowerleft": xyz(-1.5, -1, -0.5),
             "upperleft": xyz(-1.5, 1, -0.5), "upperright": xyz(1.5, 1, -0.5)}  # fmt: skip
    users = [{"pos": xyz(0.5, 0.25, 4.0)}, {"name": "guest", "pos": xyz(0.5, 0.25, 3.0)}]
    views = [{"projection": plane, "size": {"x": 0.5, "y": 1}},
             {"projection": plane, "user": "guest", "pos": {"x": 0.5, "y": 0},
              "size": {"x": 0.5, "y": 1}}]  # fmt: skip
    theatre, path = loaded(tmp_path, samples.sgct(views, users=users))
    (first, guest), _ = usable_channels(theatre, path)
    own = points_on(first.screen, CORNERS[:3])
    np.testing.assert_allclose(own[0], [-200, -125, 450])
    np.testing.assert_allclose(own[1], [100, -125, 450])
    np.testing.assert_allclose(points_on(guest.screen, CORNERS[:3])[0], [-200, -125, 350])


@pytest.mark.parametrize(("tilt", "fov"), [(0, 180), (90, 180), (30, 220), (20, 120)])
def test_a_fisheye_maps_directions_as_sgct_does(tilt, fov, tmp_path):
    channel, _ = one_view(tmp_path, {"type": "FisheyeProjection", "fov": fov, "tilt": tilt})
    size = (640, 360)
    pixels = np.array([[320, 180], [320 + 100, 180], [320, 180 - 90], [320 - 40, 180 + 60]])
    found = directions("dome", size, channel.surround, pixels)
    # SGCT: the angle from the middle grows evenly with the radius, the front is below.
    s, t = ((pixels - [320, 180]) / 180).T
    away = np.hypot(s, t) * np.radians(fov / 2)
    around = np.arctan2(s, t)
    middle = np.radians(90 - tilt)
    x, up = np.sin(away) * np.sin(around), np.sin(away) * np.cos(around)
    expected = np.stack(
        [x, np.cos(away) * np.sin(middle) + up * np.cos(middle),
         np.cos(away) * np.cos(middle) - up * np.sin(middle)], axis=1,
    )  # fmt: skip
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_a_cropped_fisheye_fills_the_pixels_of_its_part(tmp_path):
    crop = {"left": 0.0, "right": 0.0, "bottom": 0.25, "top": 0.25}
    channel, _ = one_view(tmp_path, {"type": "FisheyeProjection", "fov": 180, "crop": crop})
    assert channel.place == (0, 20, 640, 320)  # twice as wide as high
    shown = sources_at(channel.warp, np.array([[0.0, 0.0], [1.0, 1.0], [0.5, 0.5]]))
    np.testing.assert_allclose(shown, [[0, 0.25], [1, 0.75], [0.5, 0.5]], atol=1e-6)


def test_cylinders_cover_a_whole_turn_from_135_degrees_to_the_right(tmp_path):
    view = {"type": "CylindricalProjection", "radius": 3.0, "heightoffset": -0.5}
    theatre, path = loaded(tmp_path, samples.sgct([{"projection": view}]))
    channels, faults = usable_channels(theatre, path)
    assert faults == ()
    assert [one.place[:2] for one in channels] == [(0, 0), (160, 0), (320, 0), (480, 0)]
    bearings = []
    for one in channels:
        point = points_on(one.screen, np.array([[0.0, 0.0]]))[0]
        bearings.append(np.degrees(np.arctan2(point[0], point[2])) % 360)
        assert point[1] == pytest.approx(-150)
        assert one.screen.top == pytest.approx(150)
        assert np.hypot(point[0], point[2]) == pytest.approx(300)
    np.testing.assert_allclose(bearings, [135, 225, 315, 45])


def test_the_faces_of_a_cubemap_look_where_sgct_looks(tmp_path):
    view = {"type": "CubemapProjection", "channels": {"top": False}}
    theatre, path = loaded(tmp_path, samples.sgct([{"projection": view}]))
    channels, _ = usable_channels(theatre, path)
    middles = {
        one.name.rpartition("-")[2]: points_on(one.screen, np.array([[0.5, 0.5], [0.5, 1.0]]))
        for one in channels
    }
    looks = {"zright": (0, 0, -1), "left": (0, 0, 1), "zleft": (-1, 0, 0), "right": (1, 0, 0),
             "bottom": (0, -1, 0)}  # fmt: skip
    assert middles.keys() == looks.keys()
    for name, (middle, upper) in middles.items():
        np.testing.assert_allclose(middle / 300, looks[name], atol=1e-6)
        raised = (0, 0, 1) if name == "bottom" else (0, 1, 0)
        np.testing.assert_allclose((upper - middle) / 300, raised, atol=1e-6)
    places = {one.name.rpartition("-")[2]: one.place for one in channels}
    assert places["zright"][:2] == (0, 0) and places["zleft"][:2] == (0, 180)


def square_obj(left, bottom, right, top):
    """A mesh that shows a whole face within these shares of the projector."""
    lines = []
    shares = np.linspace(0, 1, 41)
    for t in shares:
        for s in shares:
            x, y = left + s * (right - left), bottom + t * (top - bottom)
            lines += [f"v {(2 * x - 1) * 16 / 9:.6f} {2 * y - 1:.6f} 0", f"vt {s:.6f} {t:.6f}"]
    for k in range(40):
        for j in range(40):
            a = 41 * k + j + 1
            lines.append(f"f {a} {a + 1} {a + 42} {a + 41}")
    return "\n".join(lines) + "\n"


def test_the_four_meshes_of_a_spherical_mirror_become_one_of_a_dome(tmp_path):
    faces = {"bottom": (0.4, 0.0, 0.6, 0.3), "left": (0.0, 0.0, 0.35, 0.9),
             "right": (0.65, 0.0, 1.0, 0.9), "top": (0.4, 0.4, 0.6, 1.0)}  # fmt: skip
    for name, place in faces.items():
        (tmp_path / f"{name}.obj").write_text(square_obj(*place))
    geometry = {name: f"{name}.obj" for name in faces}
    view = {"type": "SphericalMirrorProjection", "geometry": geometry}
    channel, theatre = one_view(tmp_path, view)
    assert list(theatre.meshes) == ["window1.obj"]
    places = np.array([[0.5, 0.15], [0.5, 0.7], [0.175, 0.6], [0.825, 0.6]])
    # Middles of the front face, 45 degrees up, of that behind it, and points of the sides.
    up = np.sqrt(0.5)
    expected = np.array([[0, up, up], [0, up, -up]])
    shown = sources_at(channel.warp, places)
    np.testing.assert_allclose(shown[:2], dome_shares(expected, 0.0), atol=2e-3)
    found = directions("dome", (1, 1), Surround(tilt_deg=0.0), shown)
    assert found[2, 0] < -0.8 < 0.8 < found[3, 0]
    np.testing.assert_allclose(found[2] * [-1, 1, 1], found[3], atol=1e-3)


def test_dome_shares_undo_the_directions_of_a_dome():
    pixels = np.random.default_rng(3).uniform(0.2, 0.8, (40, 2))
    rays = directions("dome", (1, 1), Surround(tilt_deg=25.0), pixels)
    np.testing.assert_allclose(dome_shares(rays, 25.0), pixels, atol=1e-9)


def pfm(numbers):
    """A map whose first row is the first of the file."""
    rows, columns, _ = numbers.shape
    return f"PF\n{columns} {rows}\n-1.0\n".encode() + numbers.astype("<f4").tobytes()


def test_a_texture_mapped_view_reads_its_float_map_from_the_top(tmp_path):
    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(1, 0, 7))
    u, v = samples.bend(x, y)
    (tmp_path / "a.pfm").write_bytes(pfm(np.dstack([u, v, 0 * u])))
    view = planar({"hfov": 60, "vfov": 40}) | {"type": "TextureMappedProjection"}
    channel, _ = one_view(tmp_path, view, mesh="a.pfm")
    points = np.random.default_rng(1).uniform(0.1, 0.9, (20, 2))
    expected = np.column_stack(samples.bend(*points.T))
    np.testing.assert_allclose(sources_at(channel.warp, points), expected, atol=1e-5)


def test_another_float_map_holds_the_places_of_its_picture_for_two_eyes(tmp_path):
    u, v = np.meshgrid((np.arange(8) + 0.5) / 8, 1 - (np.arange(6) + 0.5) / 6)
    half = np.dstack([0.2 + 0.5 * u, 0.1 + 0.7 * v, 0 * u])
    (tmp_path / "a.pfm").write_bytes(pfm(np.hstack([half, half])))
    channel, _ = one_view(tmp_path, planar({"hfov": 60, "vfov": 40}), mesh="a.pfm")
    shown = sources_at(channel.warp, np.array([[0.2 + 0.5 * 0.4, 0.1 + 0.7 * 0.6]]))
    np.testing.assert_allclose(shown, [[0.4, 0.6]], atol=1e-5)


def test_the_view_of_a_mesh_replaces_that_of_its_viewport(tmp_path):
    (tmp_path / "a.sgc").write_bytes(samples.sgc())
    channel, theatre = one_view(tmp_path, planar({"hfov": 60, "vfov": 40}), mesh="a.sgc")
    table = theatre.channel[0].angles
    assert (table.heading_deg, table.pitch_deg) == pytest.approx((20, 10), abs=1e-4)
    assert (table.left_deg, table.up_deg) == pytest.approx((-30, 25))
    assert channel.warp is not None


def test_viewports_are_shares_from_the_lower_left(tmp_path):
    view = planar({"hfov": 60, "vfov": 40})
    places = ((0.0, 0.33333), (0.33333, 0.66667))
    views = [
        {"projection": view, "pos": {"x": x, "y": 0.5}, "size": {"x": wide, "y": 0.5}}
        for x, wide in places
    ]
    theatre, _ = loaded(tmp_path, samples.sgct(views))
    assert [one.viewport for one in theatre.channel] == [(0, 0, 213, 180), (213, 0, 427, 180)]


def test_masks_and_eyes(tmp_path):
    grey = np.full((36, 64), 128, np.uint8)
    Image.fromarray(grey).save(tmp_path / "blend.png")
    view = planar({"hfov": 60, "vfov": 40})
    channel, theatre = one_view(tmp_path, view, blendmask="blend.png", eye="right")
    np.testing.assert_allclose(channel.mask[..., :3], 128 / 255, atol=1e-6)
    rig = theatre_rig(theatre, [channel], [0])
    np.testing.assert_allclose([eye.offset for eye in rig.eyes], [[3.25, 0, 0]])
    stereo = theatre_rig(theatre, [channel], [0], "anaglyph")
    assert [eye.offset[0] for eye in stereo.eyes] == pytest.approx([3.25, 3.25])


def test_nodes_windows_and_monitors(tmp_path):
    content = samples.sgct(masteraddress="10.0.0.2")
    node = content["nodes"][0]
    node["address"] = "10.0.0.1"
    second = json.loads(json.dumps(node)) | {"address": "10.0.0.2"}
    second["windows"][0] |= {"fullscreen": True, "monitor": 1, "name": "West <wall>"}
    content["nodes"].append(second)
    theatre, _ = loaded(tmp_path, content)
    assert theatre.cluster.master == "node2" and theatre.cluster.address == "10.0.0.2:5560"
    west = theatre.window[1]
    assert (west.name, west.node, west.monitor, west.position) == ("West-wall", "node2", 2, None)
    assert theatre.window[0].position == (10, 20)
    assert any("subsea keys" in line for line in theatre.left_out)


LEFT_OUT = {
    "draw3d": ({"draw3d": False}, {}, "no 3-D picture"),
    "stereo": ({"stereo": "side_by_side"}, {}, "--display side-by-side"),
    "mirrored": ({"mirrorx": True}, {}, "`mirrorx` of window"),
    "overlay": ({}, {"overlay": "a.png"}, "`overlay`"),
    "key": ({"msaa": 4}, {}, "keys with no counterpart here: `msaa`"),
    "unknown": ({}, {"mesh": "a.xyz"}, "no known format"),
    "elsewhere": ({}, {"mesh": r"\\host\a.obj"}, "is on another computer"),
    "user": ({}, {"user": "nobody"}, "user 'nobody' is not there"),
    "beyond": ({}, {"pos": {"x": 0.5, "y": 0}}, "its part beyond its window is cut off"),
    "outside": ({}, {"pos": {"x": 1.5, "y": 0}}, "fewer than 16 pixels of it lie in its window"),
    "thin": ({}, {"size": {"x": -0.5, "y": 1}}, "expected shares"),
    "foreign": (
        {},
        {"projection": planar({"hfov": 60, "vfov": 50}, tilt=20.0, radius=3.0)},
        "`radius`, `tilt` of viewport 'window1': not of a PlanarProjection",
    ),
    "kind": ({}, {"projection": {"type": "HyperProjection"}}, "'HyperProjection' is unknown"),
    "no field": ({}, {"projection": {"type": "PlanarProjection"}}, "no `fov`"),
    "wide": ({}, {"projection": planar({"hfov": 179, "vfov": 50})}, "less than 89"),
    "far": ({}, {"projection": {"type": "FisheyeProjection", "fov": 20}}, "angle_deg"),
}


@pytest.mark.parametrize("case", LEFT_OUT)
def test_nothing_is_left_out_silently(case, tmp_path):
    window, viewport, words = LEFT_OUT[case]
    content = samples.sgct()
    content["nodes"][0]["windows"].append(json.loads(json.dumps(content["nodes"][0]["windows"][0])))
    content["nodes"][0]["windows"][0] |= window
    content["nodes"][0]["windows"][0]["viewports"][0] |= viewport
    theatre, _ = loaded(tmp_path, content)
    lines = (*theatre.refused, *theatre.left_out)
    assert len([line for line in lines if words in line]) == 1, lines


def test_a_refusal_leads_the_message_and_ends_with_1(tmp_path, capsys):
    content = samples.sgct(users=[{"eyeseparation": 0.5}], scene={"scale": 2.0})
    window = content["nodes"][0]["windows"][0]
    window["viewports"].append({"projection": {"type": "HyperProjection"}})
    loaded(tmp_path, content)
    assert describe(str(tmp_path / "a.json")) == 1
    assert "does not work: viewport 'window1-2': projection 'Hyper" in capsys.readouterr().out
    del window["viewports"][0]
    with pytest.raises(UserError, match="can be shown; left out: viewport 'window1': projection"):
        loaded(tmp_path, content)


def test_keys_of_older_files_are_read_in_any_case(tmp_path):
    plain = samples.sgct([{"projection": planar({"hfov": 60.0, "vfov": 40.0})}])
    theatre, _ = loaded(tmp_path, plain)
    turn = {"heading": 0.0, "pitch": 0.0, "roll": 0.0}
    older = planar({"hFov": 60.0, "vFov": 40.0}, orientation=turn)
    content = samples.sgct([{"projection": older}])
    content["masterAddress"] = content.pop("masteraddress")
    content["users"] = [{"eyeSeparation": 0.065, "pos": xyz(0.0, 0.0, 0.0)}]
    content["nodes"][0]["windows"][0]["fullScreen"] = False
    other, _ = loaded(tmp_path, content)
    assert (other.channel, other.eye_distance_cm) == (theatre.channel, theatre.eye_distance_cm)
    assert other.left_out == theatre.left_out


def test_meshes_may_lie_below_the_root_of_all_configurations(tmp_path):
    """OpenSpace has them in `config/mesh`, its configurations in `config/Multi Window`."""
    folder = tmp_path / "Multi Window"
    folder.mkdir()
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "a.csv").write_bytes(samples.csv())
    Image.new("L", (16, 9)).save(tmp_path / "mesh" / "a.png")
    view = planar({"hfov": 60, "vfov": 40})
    channel, theatre = one_view(folder, view, mesh="mesh/a.csv", blendmask="mesh/a.png")
    assert theatre.channel[0].warp == "../mesh/a.csv" and channel.warp is not None
    assert channel.mask is not None


PLACED = np.array([[0.1, 0.2], [0.5, 0.5], [0.9, 0.7]])  # shares of what is left


@pytest.mark.parametrize("more", [{}, {"mesh": "a.csv", "blendmask": "a.png"}])
@pytest.mark.parametrize(
    "view",
    [planar({"hfov": 60, "vfov": 40}), {"type": "FisheyeProjection", "fov": 180, "tilt": 30}],
)
def test_a_viewport_that_overhangs_is_cut(view, more, tmp_path):
    """The pixels that are left show the same as before."""
    (tmp_path / "a.csv").write_bytes(samples.csv())
    grey = np.linspace(0, 255, 64 * 36).astype(np.uint8).reshape(36, 64)
    Image.fromarray(grey).save(tmp_path / "a.png")
    whole, _ = one_view(tmp_path, view, **more)
    place = {"pos": {"x": -0.5, "y": 0.25}, "size": {"x": 1.0, "y": 1.0}}
    cut, _ = one_view(tmp_path, view, **more, **place)
    assert cut.place == (0, 90, 320, 270)  # the right half, without its upper quarter
    before = PLACED * [0.5, 0.75] + [0.5, 0.0]
    if whole.screen is not None and whole.warp is None:
        seen = points_on(whole.screen, before), points_on(cut.screen, PLACED)
        np.testing.assert_allclose(*seen, atol=1e-4)
    elif whole.warp is not None:
        seen = sources_at(whole.warp, before), sources_at(cut.warp, PLACED)
        np.testing.assert_allclose(*seen, atol=1e-4)
        assert cut.mask.shape[:2] == (270, 320)
        np.testing.assert_allclose(cut.mask[-1, -1], [1, 1, 1, 0], atol=0.02)
    else:  # a disc of 360 pixels in 640
        square = (before * [640, 360] - [140, 0]) / 360
        np.testing.assert_allclose(sources_at(cut.warp, PLACED), square, atol=1e-4)


def test_viewports_under_others_are_cut(tmp_path):
    """The later one is drawn over the earlier one."""
    view = {"projection": planar({"hfov": 60, "vfov": 40})}
    over = view | {"pos": {"x": 0.25, "y": 0.0}, "size": {"x": 0.5, "y": 0.5}}
    theatre, path = loaded(tmp_path, samples.sgct([view, over]))
    (whole,), _ = usable_channels(*loaded(tmp_path, samples.sgct([view])))
    channels, faults = usable_channels(theatre, path)
    assert not faults and len(channels) == 4
    assert sum(one.place[2] * one.place[3] for one in channels) == 640 * 360
    for one in channels:
        x, y, width, height = one.place
        if one.name == "window1-2":
            continue
        middle = np.array([[(x + width / 2) / 640, (y + height / 2) / 360]])
        shown = points_on(one.screen, np.array([[0.5, 0.5]]))
        np.testing.assert_allclose(shown, points_on(whole.screen, middle), atol=1e-4)
    assert "its part under 'window1-2' is cut off" in "\n".join(theatre.left_out)
    theatre, _ = loaded(tmp_path, samples.sgct([over, view]))
    assert [one.viewport for one in theatre.channel] == [None]
    assert theatre.refused == ("viewport 'window1-1': it lies under 'window1-2'",)


def test_windows_that_lie_on_one_another_are_placed_by_the_desktop(tmp_path):
    content = samples.sgct()
    content["nodes"][0]["windows"] *= 2
    theatre, _ = loaded(tmp_path, content)
    assert [one.position for one in theatre.window] == [(10, 20), None]
    assert any("desktop chooses another" in line for line in theatre.left_out)


def test_tracked_users_stay_where_they_are(tmp_path):
    users = [{"pos": xyz(0, 0, 1), "tracking": {"tracker": "a", "device": "b"}}]
    theatre, _ = loaded(tmp_path, samples.sgct(users=users))
    assert theatre.eye_cm == (0, 0, -100)
    assert any("tracking of the default user" in line for line in theatre.left_out)


def test_two_hundred_viewports_are_bounded(tmp_path):
    view = planar({"hfov": 60, "vfov": 40})
    views = [{"projection": view, "pos": {"x": 0.005 * k, "y": 0.0}, "size": {"x": 0.005, "y": 1}}
             for k in range(200)]  # fmt: skip
    content = samples.sgct(views)
    content["nodes"][0]["windows"][0]["size"] = {"x": 6400, "y": 100}
    theatre, _ = loaded(tmp_path, content)
    assert len(theatre.channel) == 64
    assert "viewports beyond the first 64" in theatre.refused


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not valid JSON"),
        ('{"version": NaN}', "not valid JSON"),
        ("[" * 100_000, "not valid JSON"),
        ("[]", "expected a table"),
        ('{"version": 2, "masteraddress": "a", "nodes": []}', "`version` 2, expected 1"),
        ('{"version": 1, "masteraddress": "a", "nodes": []}', "no viewport"),
        ('{"version": 1, "masteraddress": "a", "nodes": [{"address": 3}]}', "nodes[0].address"),
        ('{"version": 1, "masteraddress": "a", "nodes": [], "x": 1e999}', "not valid JSON"),
    ],
)
def test_faulty_configurations_are_refused_in_a_line(text, words, tmp_path):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(UserError, match=re.escape(words)):
        load_theatre(str(tmp_path / "a.json"))
