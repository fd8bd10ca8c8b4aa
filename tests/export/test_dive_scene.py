"""`subsea export` from the command line, and records that it replays."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from subsea.base import hdf5
from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.export.dive_scene import record_scene
from subsea.export.recording import SceneFilmOptions
from subsea.export.scene import Scene
from subsea.lab.simulate import simulate
from subsea.media.record import read_record
from subsea.scenario.load import load_scenario
from tests.support.scenes import BARE

FAST = ["--detail", "3", "--with", "none", "--seconds", "0.2"]


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("record") / "run.h5"
    simulate(30, out, str(BARE), 5, 3, ["simulated=1"])
    return out


def of_record(record: Path, **options: object) -> SceneFilmOptions:
    return SceneFilmOptions(
        out=Path("unused.usdc"), loaded=load_scenario(str(BARE)), record=record, groups=(),
        detail=3,
        **options,  # type: ignore[arg-type]
    )  # fmt: skip


def test_a_record_is_replayed(record: Path) -> None:
    """With its seed, its number of fishes and its changes; to its end."""
    scene = record_scene(of_record(record, fps=1.0 / 0.033))
    read = read_record(record)
    assert len(scene.fishes) == 5 and scene.frames == 29
    assert len(scene.poses.live) == 1
    for frame in range(1, 29):  # frame k is the end of tick k
        np.testing.assert_allclose(scene.position[frame], read.position[frame - 1], atol=1e-3)
    assert np.ptp(scene.camera.position, axis=0).max() < 1e-9


def test_a_record_of_another_dive_is_refused(record: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    other.write_text(BARE.read_text() + "\n")
    options = of_record(record)
    with pytest.raises(UserError, match="recorded from another scenario"):
        record_scene(SceneFilmOptions(**vars(options) | {"loaded": load_scenario(str(other))}))
    with pytest.raises(UserError, match=r"ends after 1\.0 s, before the scene does"):
        record_scene(of_record(record, seconds=3.0))
    moved = tmp_path / "moved.h5"
    moved.write_bytes(record.read_bytes())
    with hdf5.h5py.File(moved, "r+") as file:
        file["fish/position"][20, 2, 0] += 0.01
    with pytest.raises(UserError, match=r"the replay departs from it at 0\.69 s"):
        record_scene(of_record(moved))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "fbx"], "unknown target 'fbx'; there are: usd, gltf"),
        (["--to", "usd", "--with", "sand,rocks"], "unknown group 'rocks'"),
        (["--to", "usd", "--tour", "glid"], "unknown tour 'glid'"),
        (["--to", "usd", "--follow", "shark"], "unknown fish 'shark'"),
        (
            ["--to", "usd", "--set", "fish.0.number=0", "--set", "fish.1.number=0"],
            "has no fishes, nothing to export",
        ),
        (["--to", "usd", "--set", "fish.0.species=fusilia"], "fusilia"),
        (["--to", "usd", "--fish", "10000", "--seconds", "10"], "--force"),
        (["--to", "usd", "--record", "run.h5", "--seed", "3"], "--seed cannot be combined"),
        (["--to", "usd", "--record", "none.h5"], "none.h5: no such file"),
    ],
)
def test_faults_are_one_line(
    arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.usdc"
    assert main(["export", str(BARE), "--out", str(out), *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_an_estimate_comes_first_and_the_file_last(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.usdc"
    arguments = ["--to", "usd", "--out", str(out), "--tour", "glide", "--start", "1", *FAST]
    assert main(["export", str(BARE), *arguments]) == 0
    told = capsys.readouterr()
    assert "6 fishes in 6 frames take about" in told.err
    assert f"{out}: " in told.out and "6 frames of 6 fishes at 30 fps" in told.out
    stage = Usd.Stage.Open(str(out))
    assert stage.GetRootLayer().customLayerData["start_s"] == 1.0
    assert len(stage.GetPrimAtPath("/bare_sea/fishes").GetChildren()) == 6


def test_a_scene_is_that_part_of_a_longer_one(dive: Scene, short_dive: SceneFilmOptions) -> None:
    """Any seconds of a dive, to the rounding of their times."""
    late = SceneFilmOptions(**vars(short_dive) | {"start": 33 * 0.033, "seconds": 10 * 0.033})
    part = record_scene(SceneFilmOptions(**vars(late) | {"groups": ()}))
    assert part.frames == 10
    np.testing.assert_allclose(part.position[1:], dive.position[34:43], atol=1e-4)
    for column in range(6):  # a pose at the end of one mix of rows is that at the start of the next
        here, there = part.points(column, 1, 9)[0], dive.points(column, 34, 42)[0]
        np.testing.assert_allclose(here, there, atol=1e-5)
    np.testing.assert_allclose(part.camera.position[1:], dive.camera.position[34:43], atol=1e-6)


def test_the_camera_can_follow_a_fish(short_dive: SceneFilmOptions) -> None:
    changes = {"follow": "clownfish:1", "groups": (), "seconds": 0.3}
    scene = record_scene(SceneFilmOptions(**vars(short_dive) | changes))
    column = [fish.name for fish in scene.fishes].index("clownfish_001")
    away = np.linalg.norm(scene.camera.position - scene.position[:, column], axis=1)
    assert away.max() < 60.0
