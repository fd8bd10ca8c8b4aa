"""A mesh of one's own follows the scaffold, and nothing else of it changes."""

from pathlib import Path

import numpy as np
import pytest

from capture.cli.main import main
from subsea.base.system import resource_path
from subsea.biomechanics.body import TRIANGLES
from subsea.export.obj import bind_mesh, fit_to_fish, read_mesh, write_mesh
from subsea.repertoire import Repertoire, read_repertoire

HEAD = "# a fish\nmtllib fish.mtl\no fish\n"


@pytest.fixture
def recorded() -> Path:
    return resource_path("repertoires/fusilier.h5")


@pytest.fixture(scope="module", params=["emperor_angelfish", "fusilier"])
def repertoire(request: pytest.FixtureRequest) -> Repertoire:
    return read_repertoire(resource_path(f"repertoires/{request.param}.h5"))


def write_obj(path: Path, vertices: np.ndarray) -> Path:
    """The hull as a mesh with texture coordinates and normals."""
    faces = "".join(f"f {a + 1}/1/1 {b + 1}//1 {c + 1}/1\n" for a, b, c in TRIANGLES[:40].tolist())
    points = "".join(f"v {x} {y} {z} 0.5 0.5 0.5\n" for x, y, z in vertices)
    path.write_text(HEAD + points + "vt 0 0\nvn 0 0 1\nusemtl skin\n" + faces)
    return path


def test_vertices_follow_the_nodes_and_nothing_else_changes(
    repertoire: Repertoire, tmp_path: Path
) -> None:
    mesh = bind_mesh(repertoire, write_obj(tmp_path / "fish.obj", repertoire.rest_nodes), False)
    for nodes in repertoire.segments["turn_left_sharp"].nodes[::20]:
        write_mesh(tmp_path / "bent.obj", mesh, nodes)
        np.testing.assert_allclose(read_mesh(tmp_path / "bent.obj")[1], nodes, atol=1e-4)
    text = (tmp_path / "bent.obj").read_text()
    assert text.startswith(HEAD)
    a, b, c = TRIANGLES[0] + 1
    assert f"usemtl skin\nf {a}/1 {b} {c}/1\n" in text
    assert "vn" not in text
    assert text.count(" 0.5 0.5 0.5\n") == 23


def test_fitting_brings_any_size_to_the_fish(repertoire: Repertoire) -> None:
    found = fit_to_fish(7.0 * repertoire.rest_nodes + (30.0, -2.0, 5.0), repertoire)
    np.testing.assert_allclose(found, repertoire.rest_nodes, atol=1e-9)


def test_faulty_meshes_are_errors_of_one_line(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mesh = tmp_path / "mesh.obj"
    for text, message in (
        ("hello\n", "no vertices"),
        ("v 1 2\n", "line 1: expected `v x y z`"),
        ("v 1 2 three\n", "line 1: expected `v x y z`"),
        ("v 0 0 nan\n", "not finite"),
        ("v 900 0 0\nv 0 0 0\n", "--fit"),
    ):
        mesh.write_text(text)
        assert main(["mesh", str(recorded), str(mesh), "--out", str(tmp_path / "out")]) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1 and "mesh.obj" in error and message in error
        assert not (tmp_path / "out").exists()


def test_from_the_command_line(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], repertoire: Repertoire
) -> None:
    mesh = write_obj(tmp_path / "big.obj", 40.0 * repertoire.rest_nodes)
    out = tmp_path / "out"
    arguments = ["mesh", str(recorded), str(mesh), "--fit", "--out", str(out)]
    assert main(arguments) == 0
    frames = len(read_repertoire(recorded).segments["swim_fast"].nodes)
    assert len(list(out.glob("big_swim_fast_*.obj"))) == frames
    assert f"big_swim_fast_0000.obj and {frames - 1} more" in capsys.readouterr().out
    assert main([*arguments, "--segment", "swim_fats"]) == 2
    assert "swim_fast" in capsys.readouterr().err
