"""From photographs to a theatre file: the truth is known, because the rooms are rendered."""

import io
import shutil
from contextlib import redirect_stderr, redirect_stdout
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from subsea.base.errors import UserError
from subsea.cli.main import main as subsea
from subsea.stage.calibration.calibrate import check_camera
from subsea.stage.calibration.optics import FISHEYE, ORDINARY, ReferencePoint, SolvedCamera
from subsea.stage.calibration.surface import within
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.screens import points_on
from subsea.view.rig import sources_at
from tests.support.lit_room import errors_px, look, planned_room, write_points


def calibrated(path, folder):
    """Calibrate a theatre; returns the new one, its channels, and what was printed."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = subsea(["theatre", str(path), "--calibrate", str(folder)])
    assert code == 0, err.getvalue()
    theatre, path = load_theatre(str(path.with_name("room-calibrated.toml")))
    channels, faults = usable_channels(theatre, path)
    assert not faults
    return SimpleNamespace(
        path=path, theatre=theatre, channels=channels, out=out.getvalue(), err=err.getvalue()
    )


@pytest.fixture(scope="module")
def outcome(wall):
    """The calibrated wall."""
    return calibrated(wall.path, wall.folder)


def check(room, theatre, channels, most_px=1.0):
    """Each pixel shows its point of the screen, and the light of all projectors adds up to one."""
    spots = []
    for number, (channel, lamp) in enumerate(zip(channels, room.lamps, strict=True)):
        x, y = (np.linspace(0.01, 0.99, 41) * side for side in lamp.size)
        shown = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        places = np.column_stack([shown[:, 0] / lamp.size[0], 1 - shown[:, 1] / lamp.size[1]])
        factors = mask_at(channel, places)
        lit = factors[:, 0] > 0.02
        sources = sources_at(channel.warp, places[lit])
        points = points_on(channel.screen, sources)
        error = errors_px(room, number, points, shown[lit])
        assert np.isfinite(error).mean() > 0.95  # masks fade across the edge of the screen
        assert np.sqrt(np.nanmean(error**2)) < most_px
        true = room.truth(number, shown[lit])
        inner = np.zeros(len(true), bool)  # masks fade across the edge of the screen
        for surface in room.surfaces:
            inner |= within(surface.places(true), -0.03)
        spots.append(true[inner][::7])
    for points in spots:
        light = np.zeros(len(points))
        for lamp, channel in zip(room.lamps, channels, strict=True):
            shown = lamp.pixels(points)
            inside = ((shown > 0) & (shown < lamp.size)).all(axis=1)
            places = np.column_stack([shown[:, 0] / lamp.size[0], 1 - shown[:, 1] / lamp.size[1]])
            gamma = np.broadcast_to(channel.adjustment.gamma, 3)[0]
            share = mask_at(channel, places)[:, 0] ** gamma
            light += np.where(inside, share, 0.0)
        assert np.median(np.abs(light - np.median(light))) < 0.02
        assert np.quantile(np.abs(light - np.median(light)), 0.95) < 0.08


def mask_at(channel, places):
    """The mask (n, 4) of a channel at places (n, 2), as the shader mixes its values."""
    rows, columns, _ = channel.mask.shape
    x, y = np.nan_to_num(places).T
    at = [(1 - y) * rows - 0.5, x * columns - 0.5]
    layers = [map_coordinates(channel.mask[..., k], at, order=1, mode="nearest") for k in range(4)]
    return np.stack(layers, axis=1)


def test_a_wall_of_two_projectors_is_measured(wall, outcome):
    check(wall.room, outcome.theatre, outcome.channels, 0.8)
    assert "left: 100% seen" in outcome.out and "right: 100% seen" in outcome.out
    assert "an ordinary lens at" in outcome.err
    text = outcome.path.read_text()
    assert text.startswith(wall.path.read_text()[:200])  # its comments
    assert "blend" not in text
    for name in ("left", "right"):
        assert outcome.path.with_name(f"room-calibrated-{name}-residuals.png").is_file()
    gains = np.array([table.gain for table in outcome.theatre.channel])
    np.testing.assert_allclose(gains, [[0.7, 0.8, 0.75], [1.0, 1.0, 1.0]], atol=0.03)
    gammas = np.array([np.broadcast_to(table.gamma, 3) for table in outcome.theatre.channel])
    np.testing.assert_allclose(gammas, [[2.2] * 3, [2.4] * 3], atol=0.08)


def test_black_is_alike_on_the_whole_screen(wall, outcome, grid):
    before, after = [], []
    for number, lamp in enumerate(wall.room.lamps):
        points = wall.room.truth(number, grid(lamp.size, edge=0.08))
        light, raised = np.zeros(len(points)), np.zeros(len(points))
        for other, channel in zip(wall.room.lamps, outcome.channels, strict=True):
            shown = other.pixels(points)
            inside = ((shown > 0) & (shown < other.size)).all(axis=1)
            places = np.column_stack([shown[:, 0] / other.size[0], 1 - shown[:, 1] / other.size[1]])
            light += np.where(inside, other.black, 0.0)
            raised += np.where(inside, other.black + mask_at(channel, places)[:, 3], 0.0)
        before.append(light)
        after.append(raised)
    assert np.std(np.concatenate(after)) < 0.6 * np.std(np.concatenate(before))


def test_faults_are_one_line_and_nothing_is_written(wall, tmp_path, capsys):
    for file in wall.path.parent.glob("room*"):
        if "calibrated" not in file.name:
            shutil.copy(file, tmp_path)
    path, folder = tmp_path / "room.toml", tmp_path / "photographs"
    shutil.copytree(wall.folder, folder)

    def refused(*words):
        assert subsea(["theatre", str(path), "--calibrate", str(folder), *words]) == 2
        assert not list(tmp_path.glob("*calibrated*"))
        return capsys.readouterr().err.strip().splitlines()[-1]

    missing = wall.paths[30]
    taken = missing.read_bytes()
    (folder / missing.name).unlink()
    assert "expected 66: near" in (line := refused()) and "one is missing or too many" in line
    (folder / missing.name).write_bytes(wall.paths[29].read_bytes())
    assert "not its inverse; expected the photographs in the order of the patterns" in refused()
    (folder / missing.name).write_bytes(taken)
    shutil.copy(wall.paths[7], folder / "photo_7b.png")
    assert "photo_7b.png and photo_7.png show the same; remove one" in refused()
    (folder / "photo_7b.png").unlink()
    (folder / wall.paths[0].name).write_bytes(b"no picture")
    assert "photo_0.png: not a readable photograph" in refused()
    points = folder / "points.toml"
    text = points.read_text()
    points.write_text("[[point]]".join(text.split("[[point]]")[:4]))
    assert "3 points with a `pixel`, expected 4 or more" in refused()
    points.unlink()
    assert "points.toml: no such file; expected the reference points" in refused()
    points.write_text(text)
    for one in wall.paths:
        (folder / one.name).unlink()
    assert "no photographs" in refused()
    assert "expected a file in" in refused("--out", str(tmp_path / "away" / "new.toml"))


def test_a_point_of_another_room_is_named():
    camera = look((0, 0, 0), (0, 0, 300), (800, 600), ORDINARY, 500)
    points = [ReferencePoint(f"mark {k}", np.array([k, 0.0, 300.0]), (1.0, 2.0)) for k in range(4)]
    solved = SolvedCamera(camera, np.array([0.3, 0.5, 40.0, 1.0]), 0.3, {})
    with pytest.raises(UserError, match=r"here.toml: 'mark 2' is 40 pixels from where the other"):
        check_camera(solved, points, "here.toml")
    check_camera(solved._replace(point_px=np.full(4, 4.0)), points, "here.toml")


def test_patterns_are_written_with_points_to_fill_in(wall, tmp_path, capsys):
    folder = tmp_path / "patterns"
    assert subsea(["theatre", str(wall.path), "--patterns", str(folder)]) == 0
    assert "66 patterns and" in capsys.readouterr().out
    names = sorted(one.name for one in folder.glob("*.png"))
    assert names[0] == "0001-left-white.png" and names[-1] == "0066-right-rows-2-inverse.png"
    assert "at_cm" in (folder / "points.toml").read_text()
    assert subsea(["theatre", str(wall.path), "--patterns", str(folder)]) == 2
    assert "exists; choose another name, or give --force" in capsys.readouterr().err


@pytest.mark.nightly
def test_a_hidden_part_follows_the_lens(tmp_path):
    """A camera that sees half of the right projector's picture."""
    path, room = planned_room("wall", (320, 200), tmp_path, projectors=2, width=600, distance=400)
    camera = look((-220, 30, -60), (-150, 0, 400), (560, 420), ORDINARY, 430, (-0.1, 0.02))
    room.photograph(camera, tmp_path / "photographs")
    at = [(x, y, 400.0) for x in (-290, -150, 0, 100) for y in (-80, 85)]
    write_points(tmp_path / "photographs" / "points.toml", camera, at)
    found = calibrated(path, tmp_path / "photographs")
    assert "of it was seen; its lens gives the rest" in found.err
    check(room, found.theatre, found.channels, 2.5)


@pytest.mark.nightly
def test_a_curved_screen_of_three_projectors(tmp_path):
    path, room = planned_room(
        "curved", (320, 240), tmp_path, projectors=3, radius=300, angle=130, height=180
    )
    camera = look((30, 20, -250), (0, 0, 300), (940, 540), ORDINARY, 480, (-0.15, 0.04), (4, -3))
    room.photograph(camera, tmp_path / "photographs")
    turns = np.radians([-60, -30, 0, 30, 60])
    at = [(300 * np.sin(turn), y, 300 * np.cos(turn)) for turn in turns for y in (-60, 90)]
    write_points(tmp_path / "photographs" / "points.toml", camera, at)
    found = calibrated(path, tmp_path / "photographs")
    check(room, found.theatre, found.channels)


@pytest.mark.nightly
@pytest.mark.parametrize("cameras", [1, 2])
def test_a_dome_of_six_projectors(tmp_path, cameras):
    """One fisheye lens that sees all, or two that see a half each."""
    path, room = planned_room("dome", (240, 180), tmp_path, projectors=6, radius=400)
    room.bounce = 0.15
    turns = np.radians(np.arange(0, 360, 45))
    at = [
        (400 * np.sin(turn) * np.cos(rise), 400 * np.sin(rise), 400 * np.cos(turn) * np.cos(rise))
        for turn in turns for rise in np.radians([8, 45])
    ] + [(0.0, 400.0, 0.0)]  # fmt: skip
    seers = [look((25, -20, -30), (0, 400, 0.1), (900, 900), FISHEYE, 275, (-0.02, 0.002), (3, -5))]
    if cameras == 2:
        seers = [
            look((20, -60, side), (0, 250, -3 * side), (800, 800), FISHEYE, 320, (-0.02, 0.0))
            for side in (100, -100)
        ]
    for number, camera in enumerate(seers):
        folder = tmp_path / "photographs" / f"camera-{number}"
        room.photograph(camera, folder)
        pixels = camera.seen(np.array(at))
        inside = ((pixels > 0) & (pixels < camera.size)).all(axis=1)
        write_points(folder / "points.toml", camera, np.array(at)[inside])
    found = calibrated(path, tmp_path / "photographs")
    check(room, found.theatre, found.channels)
