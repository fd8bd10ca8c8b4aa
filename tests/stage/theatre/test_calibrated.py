"""Theatres with calibration data: each pixel of each projector shows the sea behind its point."""

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from subsea.stage.theatre.theatre_rig import theatre_rig
from subsea.view.rig import Projection, seen_by, sources_at
from subsea.view.surround import MARGIN_PX
from tests.support.daily import only

NAMES = ("left", "middle", "right")
WHOLE = (
    "cylinder = { radius_cm = 275, left_deg = -60, right_deg = 60, bottom_cm = -125, top_cm = 125 }"
)
FLAT = "angles = { left_deg = -40, right_deg = 40, down_deg = -30, up_deg = 30, distance_cm = 200 }"
FRUSTUM = """<frustum><yaw>{yaw}</yaw><pitch>-10</pitch><roll>5</roll><rightAngle>25</rightAngle>
<leftAngle>-26</leftAngle><upAngle>20</upAngle><downAngle>-21</downAngle></frustum>"""


@pytest.fixture
def theatre(tmp_path, making):
    """A function that writes a theatre of an archive, reads it, and gives channels and faults."""

    def theatre(files, screen=WHOLE, head=""):
        (tmp_path / "all.mpcdi").write_bytes(making.zipped(files))
        windows = [f'[[window]]\nname = "{name}"\nsize = [160, 120]\n' for name in NAMES]
        tail = f'[[mpcdi]]\nfile = "all.mpcdi"\n{screen}\n'
        (tmp_path / "theatre.toml").write_text("".join([head, *windows, tail]))
        read, path = load_theatre(str(tmp_path / "theatre.toml"))
        return read, *usable_channels(read, path)

    return theatre


def shown_at(rig, patch, places):
    """The directions (k, 3) in which the eye of a patch sees what is shown at places (k, 2)."""
    (eye,) = {id(eye): eye for eye in seen_by(rig, patch)}.values()
    pixels = patch.left[:2] + sources_at(patch.warp, places) * patch.left[2:]
    shares = (pixels - eye.viewport[:2]) / eye.viewport[2:]
    clip = np.column_stack([2 * shares - 1, np.ones((len(shares), 2))])
    rays = clip @ np.linalg.inv(eye.projection).T  # of a camera that looks along -z
    rays = (rays[:, :3] / rays[:, 3:]) * [1, 1, -1] @ eye.axes
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)


@pytest.mark.nightly
@pytest.mark.parametrize("buffer_wide", only([True], [False, True]))
def test_each_pixel_shows_the_sea_behind_its_point(theatre, projectors, making, buffer_wide):
    files = making.parts(projectors)
    if buffer_wide:  # shares of the whole picture in the warps
        files |= {f"{one.name}.pfm": making.pfm(one.shares) for one in projectors}
    read, found, faults = theatre(files)
    assert faults == ()
    assert [one.name for one in found] == list(NAMES)
    rig = theatre_rig(read, found, range(3))
    whole = found[0].screen._replace(left=np.radians(-60), right=np.radians(60))
    whole = whole._replace(bottom=-125.0, top=125.0)
    for patch, one in zip(rig.patches, projectors, strict=True):
        places = np.stack(making.grid_of(one.size), axis=-1).reshape(-1, 2)[::5]
        points = points_on(whole, one.shares.reshape(-1, 2)[::5])
        wanted = points / np.linalg.norm(points, axis=1, keepdims=True)
        away = np.degrees(np.linalg.norm(shown_at(rig, patch, places) - wanted, axis=1))
        pixel = 54 / 160  # degrees
        assert np.isfinite(away).mean() > 0.55
        assert np.nanmax(away) < (2.0 if buffer_wide else 0.4) * pixel
        assert patch.mask.shape == (120, 160, 4)


def test_an_identity_warp_on_a_curved_screen_changes_nothing(tmp_path):
    (tmp_path / "straight.obj").write_bytes(
        b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1 2 3 4\n"
    )
    rigs = []
    for line in ("", 'warp = "straight.obj"\n'):
        (tmp_path / "a.toml").write_text(
            f'[[window]]\nname = "a"\nsize = [900, 400]\n'
            f'[[channel]]\nname = "a"\nwindow = "a"\n{WHOLE}\n{line}'
        )
        read, path = load_theatre(str(tmp_path / "a.toml"))
        found, faults = usable_channels(read, path)
        assert faults == ()
        rigs.append(theatre_rig(read, found, [0]))
    places = np.random.default_rng(2).uniform(0.01, 0.99, (200, 2))
    plain, warped = (sources_at(rig.patches[0].warp, places) for rig in rigs)
    # Both meshes stand for a curve, by triangles that are not the same ones.
    assert np.abs((plain - warped) * rigs[0].canvas).max() < 1.0


def test_a_region_with_a_frustum_looks_along_it(theatre, projectors, making):
    for one in projectors:
        one.frustum = FRUSTUM.format(yaw=np.degrees(one.yaw))
    read, found, faults = theatre(making.parts(projectors, "3d"), FLAT)
    assert faults == ()
    rig = theatre_rig(read, found, range(3))
    for eye, one in zip(rig.eyes, projectors, strict=True):
        right, up, ahead = eye.axes
        expected = np.array([np.sin(one.yaw), 0, np.cos(one.yaw)]) * np.cos(np.radians(-10))
        np.testing.assert_allclose(ahead, expected + [0, np.sin(np.radians(-10)), 0], atol=1e-9)
        assert right[1] == pytest.approx(-np.sin(np.radians(5)) * np.cos(np.radians(10)))
        assert up[1] > 0.9
        width, height = eye.viewport[2:]  # with a margin
        edge = 1 - 2 * MARGIN_PX / width, 1 - 2 * MARGIN_PX / height
        upper_right = np.linalg.inv(eye.projection) @ [*edge, 1, 1]
        slopes = upper_right[:2] / -upper_right[2]
        np.testing.assert_allclose(np.degrees(np.arctan(slopes)), [25, 20], atol=1e-6)


@pytest.mark.parametrize(
    ("screen", "scale", "far"),
    [
        (FLAT.replace("left_deg = -40", "left_deg = 10"), 1.0, 200.0),
        (WHOLE, 1.0, 275.0),
        (WHOLE, 2.0, 550.0),
        ("dome = { distance_cm = 400 }", 1.0, 400.0),
        ("", 1.0, 300.0),
    ],
)
def test_a_region_with_a_frustum_has_the_distance_of_the_archive(
    theatre, projectors, making, screen, scale, far
):
    for one in projectors:
        one.frustum = FRUSTUM.format(yaw=np.degrees(one.yaw))
    _, found, faults = theatre(making.parts(projectors, "3d"), screen, f"scale = {scale}\n")
    assert faults == ()
    assert [one.distance_cm for one in found] == pytest.approx([far] * 3)
    for one in found:
        corners = points_on(one.screen, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
        away = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        assert corners @ away / np.linalg.norm(away) == pytest.approx([far] * 3)


def test_two_regions_never_fill_one_window(theatre, projectors, making):
    shown = f'{WHOLE}\nwindows = {{ left = "left", middle = "left", right = "right" }}'
    _, found, faults = theatre(making.parts(projectors), shown)
    assert [one.name for one in found] == ["left", "right"]
    assert len(faults) == 1
    assert "region 'middle': lies on 'left' in its window; expected places" in str(faults[0])


def test_a_channel_and_a_region_never_share_a_window(theatre, projectors, making):
    more = f'{WHOLE}\n[[channel]]\nname = "own"\nwindow = "middle"\n{WHOLE}'
    _, found, faults = theatre(making.parts(projectors), more)
    assert [one.name for one in found] == ["own", "left", "right"]
    assert len(faults) == 1
    assert "region 'middle': lies on 'own' in its window" in str(faults[0])


def test_the_projectors_that_work_go_on_without_the_one_that_does_not(theatre, projectors, making):
    files = making.parts(projectors)
    files["middle.pfm"] = files["middle.pfm"][:-1]
    read, found, faults = theatre(files)
    assert [one.name for one in found] == ["left", "right"]
    assert len(faults) == 1
    assert "'middle.pfm': 160×120 points in 230399 bytes of numbers, expected" in str(faults[0])
    rig = theatre_rig(read, found, range(3))
    assert {patch.output for patch in rig.patches} == {0, 2}


def test_calibrated_projectors_of_a_dome_show_their_parts_of_its_picture(
    theatre, projectors, making
):
    read, found, faults = theatre(making.parts(projectors), "dome = {}")
    assert faults == ()
    rig = theatre_rig(read, found, range(3))
    for patch, one in zip(rig.patches, projectors, strict=True):
        assert patch.shape == Projection.DOME
        places = np.stack(making.grid_of(one.size), axis=-1).reshape(-1, 2)[::5]
        away = sources_at(patch.warp, places) - one.shares.reshape(-1, 2)[::5]
        assert np.isfinite(away).mean() > 0.55
        assert np.nanmax(np.abs(away * one.size)) < 0.25


def test_a_region_without_a_warp_shows_its_part_of_a_dome(theatre, projectors, making):
    files = making.parts(projectors)
    files["mpcdi.xml"] = files["mpcdi.xml"].split(b"<files>")[0] + b"</MPCDI>"
    read, found, _ = theatre(files, "dome = {}")
    patch = theatre_rig(read, found, range(3)).patches[1]
    x, y, width, height = projectors[1].place
    corners = np.array([[0.0, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose(
        sources_at(patch.warp, corners), [[x, y], [x + width, y + height]], atol=1e-6
    )


def test_regions_on_an_uncalibrated_panorama_are_refused(theatre, projectors, making):
    with pytest.raises(UserError, match="`panorama` is for uncalibrated screens"):
        theatre(making.parts(projectors), "panorama = {}")


def test_a_mirror_lights_a_dome(tmp_path):
    nodes = [
        f"{4 / 3 * (2 * u - 1)} {2 * v - 1} {u} {v} {0.5 + 0.5 * v}"
        for v in (0.0, 0.5, 1.0)
        for u in (0.0, 0.5, 1.0)
    ]
    (tmp_path / "mirror.data").write_text("\n".join(["2", "3 3", *nodes]))
    (tmp_path / "a.toml").write_text(
        '[[window]]\nname = "a"\nsize = [400, 300]\n'
        '[[channel]]\nname = "a"\nwindow = "a"\ndome = {}\nwarp = "mirror.data"\n'
    )
    read, path = load_theatre(str(tmp_path / "a.toml"))
    found, faults = usable_channels(read, path)
    assert faults == ()
    for display, count in (("mono", 1), ("side-by-side", 2)):
        patches = theatre_rig(read, found, [0], display).patches
        assert len(patches) == count
        for patch in patches:
            assert patch.shape == Projection.DOME
            np.testing.assert_allclose(sources_at(patch.warp, [[0.3, 0.6]]), [[0.3, 0.6]])
            assert patch.mask[0, 0, 0] > 0.99 > 0.51 > patch.mask[-1, 0, 0]
