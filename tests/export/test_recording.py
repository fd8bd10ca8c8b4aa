"""A scene holds what the dive plays back, frame by frame; `subsea export` from the command line."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from subsea.base import hdf5
from subsea.base.errors import UserError
from subsea.cli.main import main
from subsea.dive.directed_camera import tour_steering
from subsea.dive.start import ready_world
from subsea.export.clips import Surface
from subsea.export.conventions import continuous
from subsea.export.recording import SceneFilmOptions, record_scene
from subsea.export.scene import Scene
from subsea.fish.mesh import BODY, DETAILS, fish_mesh, species_vertices, surface_points
from subsea.fish.species import load_species
from subsea.frame.packet import ROW_A, ROW_B
from subsea.geometry.rotation import matrix
from subsea.lab.simulate import simulate
from subsea.media.record import read_record
from subsea.motor.pose import control_points_world, nodes_world
from subsea.scenario.load import load_scenario
from subsea.scenario.shoals import find_fish
from subsea.world.step import step
from tests.support.scenes import BARE

MOUTH_END, TAIL = 0.25, 0.7  # body lengths: between these neither jaws nor tail fin move the skin
FAST = ["--detail", "3", "--with", "none", "--seconds", "0.2"]


def test_bodies_are_where_playback_has_them(dive: Scene, short_dive: SceneFilmOptions) -> None:
    """In every frame of every fish: mixed rows, glides, gradual turns, and a simulated fish.

    Played back again by a world that nothing records, on another way: `control_points_world`.
    """
    world = ready_world(short_dive.loaded)
    steer = tour_steering(world, "auto")
    library, kinds, far = world.library, world.state.fishes.species, []
    live = dive.poses.rows[..., ROW_A] >= len(library.entry)
    [simulated] = np.flatnonzero(live.any(axis=0))
    assert live[:, simulated].all()
    mesh = fish_mesh(DETAILS[short_dive.detail])
    bodies = []  # of each fish: in all frames, some vertices, and their numbers in the mesh
    for column, fish in enumerate(dive.fishes):
        surface = world.species[kinds[fish.number]].surface
        own = species_vertices(surface, mesh, DETAILS[short_dive.detail])
        middle = (mesh.vertices[:, 12] == BODY) & (own[:, 0] > MOUTH_END) & (own[:, 0] < TAIL)
        points, _ = dive.points(column)
        bodies.append((points[:, middle[own[:, 2] >= 0]], np.flatnonzero(middle)))
    turning = gliding = 0
    for frame in range(1, dive.frames):
        while world.state.tick < frame:
            step(world, steer(world))
        fishes = world.state.fishes
        rows = fishes.row_a[fishes.row_a < len(library.level)]
        turning += int((library.level[rows] != 0).sum())
        gliding += int((np.abs(fishes.row_a - fishes.row_b) > 1).sum())
        for column, (fish, (points, middle)) in enumerate(zip(dive.fishes, bodies, strict=True)):
            control = control_points_world(fishes, library, fish.number)
            if column == simulated:  # its skin follows its nodes
                weights = library.coupling.weights[kinds[fish.number]]
                control = weights @ nodes_world(fishes, library, fish.number)
            there = surface_points(control, mesh.vertices[middle], mesh.base[middle])
            here = points[frame] @ matrix(dive.rotation[frame, column]).T
            here += dive.position[frame, column]
            far.append(np.abs(here - there).max() / fish.length_cm)
    assert max(far) < 1e-4
    assert turning > 100 and gliding > 100  # there is something to compare


def test_names_are_those_of_the_fish_finder(dive: Scene, short_dive: SceneFilmOptions) -> None:
    scenario = short_dive.loaded.scenario
    for fish in dive.fishes:
        species, _, number = fish.name.rpartition("_")
        assert find_fish(f"{species}:{int(number)}", scenario) == fish.number
        assert dive.models[fish.model].name == species
        size = fish.scale * dive.models[fish.model].length_cm
        assert size == pytest.approx(fish.length_cm, rel=1e-5)


def test_rotations_never_jump_to_the_other_sign(dive: Scene) -> None:
    for rotation in (dive.rotation, dive.camera.rotation):
        np.testing.assert_allclose(np.linalg.norm(rotation, axis=-1), 1.0, atol=1e-6)
        assert ((rotation[1:] * rotation[:-1]).sum(axis=-1) > 0.9).all()
    flipped = np.array([[1.0, 0, 0, 0], [-1.0, 0, 0, 0], [1.0, 0, 0, 0]])
    np.testing.assert_array_equal(continuous(flipped), np.tile(flipped[0], (3, 1)))


def test_tints_differ_between_fishes_about_their_species() -> None:
    surface = Surface(load_species("fusilier"), 20.0, detail=3)
    tints = surface.tints(np.linspace(0.0, 0.999, 400))
    np.testing.assert_allclose(tints.mean(axis=0), 1.0, atol=0.02)
    assert 0.005 < tints.std(axis=0).max() < 0.3


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
    simulated = scene.poses.rows[-1, :, ROW_B] >= len(scene.poses.table) - 2
    assert simulated.sum() == 1
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
