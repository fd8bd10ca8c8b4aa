"""The container of glTF; rounded and compressed arrays come back as what they stood for."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from subsea.base.errors import UserError
from subsea.export import COMPRESSIONS, MESHOPT, PLAIN, QUANTISED
from subsea.export.glb import INDICES, VERTICES, GlbBuffer, asset, glb, packing_of
from tests.support.gltf_reader import Reader

RNG = np.random.default_rng(5)
POINTS = RNG.normal(size=(70, 3)) * (0.3, 0.1, 0.05) + (3.0, 0.0, -1.0)
NORMALS = POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)
TURNS = NORMALS[:, [0, 1, 2, 2]] / np.linalg.norm(NORMALS[:, [0, 1, 2, 2]], axis=1, keepdims=True)
WEIGHTS = RNG.dirichlet(np.full(4, 0.3), size=70)
FACES = RNG.integers(0, 70, size=300).astype(np.uint16)
SHARES = np.eye(9).ravel()
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], np.float32)


def _written(folder: Path) -> tuple[Path, GlbBuffer, int]:
    """A triangle behind a view of odd length, so that padding matters; and the view's number."""
    buffer = GlbBuffer()
    note = buffer.view(b"five!")
    faces = buffer.add(np.array([0, 1, 2], np.uint16), INDICES)
    points = buffer.add(CORNERS, VERTICES)
    primitive = {"attributes": {"POSITION": points}, "indices": faces}
    content = {
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
    }
    file = folder / "one.glb"
    file.write_bytes(glb(content, buffer))
    return file, buffer, note


def test_the_validator_has_no_objection(
    khronos: Callable[[Path], dict[str, Any]], tmp_path: Path
) -> None:
    report = khronos(_written(tmp_path)[0])
    assert report["issues"]["numErrors"] == report["issues"]["numWarnings"] == 0


def test_views_are_padded(tmp_path: Path) -> None:
    import trimesh

    file, buffer, note = _written(tmp_path)
    mesh = trimesh.load(file, force="mesh", process=False)
    np.testing.assert_array_equal(mesh.vertices, CORNERS)
    assert buffer.views[note]["byteLength"] == 5
    shift = np.eye(4, dtype=np.float32)
    shift[:3, 3] = 5, 6, 7
    last = buffer.views[buffer.accessors[buffer.add(shift[None])]["bufferView"]]
    kept = np.frombuffer(buffer.data, np.float32, 16, last["byteOffset"])
    np.testing.assert_array_equal(kept[12:15], (5, 6, 7))  # glTF keeps columns


@pytest.mark.parametrize("kind", COMPRESSIONS)
def test_arrays_come_back(kind: str, opened: Callable[[Path], Reader], tmp_path: Path) -> None:
    """Within half a step of their integers; floats to the last bit, or their stated precision."""
    pack = packing_of(kind)
    buffer, grid = GlbBuffer(pack), pack.grid(POINTS)
    stored = {
        "points": (pack.positions(POINTS, grid), VERTICES),
        "normals": (pack.normals(NORMALS), VERTICES),
        "places": (pack.coordinates(np.abs(NORMALS[:, :2])), VERTICES),
        "weights": (pack.weights(WEIGHTS), VERTICES),
        "faces": (FACES, INDICES),
        "turns": (pack.rotations(TURNS), None),
        "ways": (pack.lengths(POINTS, 1e-6), None),
        "shares": (pack.shares(SHARES), None),
    }
    numbers = {name: buffer.add(values, target) for name, (values, target) in stored.items()}
    file = tmp_path / "arrays.glb"
    file.write_bytes(glb({"asset": asset([], {})}, buffer))
    read = {name: opened(file).array(number) for name, number in numbers.items()}
    points = np.pad(read["points"], ((0, 0), (0, 1)), constant_values=1.0) @ grid.matrix.T
    whole = kind != PLAIN
    step = np.ptp(POINTS, axis=0).max() / 2 / 32767
    assert np.abs(points[:, :3] - POINTS).max() <= (0.51 * step if whole else 1e-6)
    assert np.abs(read["normals"] - NORMALS).max() <= (0.51 / 127 if whole else 1e-7)
    assert np.abs(read["places"] - np.abs(NORMALS[:, :2])).max() <= (1e-5 if whole else 1e-7)
    assert np.abs(read["weights"] - WEIGHTS).max() <= (2.0 / 255 if whole else 1e-7)
    np.testing.assert_allclose(read["weights"].sum(axis=1), 1.0, atol=1e-6)
    if kind == MESHOPT:  # triangles may begin at another corner
        found, faces = read["faces"].reshape(-1, 3), FACES.reshape(-1, 3)
        turned = [np.roll(faces, k, axis=1) for k in range(3)]
        assert (np.array(turned) == found).all(axis=2).any(axis=0).all()
    else:
        np.testing.assert_array_equal(read["faces"], FACES)
    assert np.abs(read["turns"] - TURNS).max() <= (0.51 / 32767 if whole else 1e-7)
    assert np.abs(read["ways"] - POINTS).max() <= 1e-6
    np.testing.assert_array_equal(read["shares"], SHARES)
    if kind == MESHOPT:
        assert "EXT_meshopt_compression" in opened(file).content["extensionsRequired"]


@pytest.mark.parametrize("moved", [0, 3, 70])
def test_morph_targets_keep_what_moves(moved: int, tmp_path: Path) -> None:
    """Sparse if that is shorter; a target that moves nothing is sound, too."""
    points = np.repeat(POINTS, 20, axis=0)
    ways = np.zeros_like(points)
    ways[: moved * 20] = 0.05
    pack = packing_of(QUANTISED)
    buffer, grid = GlbBuffer(pack), pack.grid(points)
    number = buffer.changes(pack.offsets(ways, grid))
    file = tmp_path / "target.glb"
    file.write_bytes(glb({"asset": asset([], {})}, buffer))
    reader = Reader(file)
    assert ("sparse" in reader.content["accessors"][number]) == (moved < 70)
    assert np.abs(grid.half * reader.array(number) - ways).max() < 1e-5


def test_a_wide_offset_widens_the_grid() -> None:
    """As that of a fish that swims away with its path in the points."""
    pack = packing_of(QUANTISED)
    assert pack.grid(POINTS, 4.0).half == 4.0
    assert packing_of(PLAIN).grid(POINTS, 4.0).half == 0.0


def test_normals_that_turn_round_stay_floats() -> None:
    pack = packing_of(QUANTISED)
    assert pack.turned_normals(np.full((4, 3), 0.9)).values.dtype == np.int8
    assert pack.turned_normals(np.full((4, 3), 1.9)).values.dtype == np.float32


def test_an_unknown_compression_or_a_missing_package_is_one_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(UserError, match="unknown compression 'zip', expected none, quantised"):
        packing_of("zip")
    monkeypatch.setattr("subsea.base.system.find_spec", lambda name: None)
    with pytest.raises(UserError, match="compressed glTF needs meshopt: run"):
        packing_of(MESHOPT)


def test_the_validator_detects_damage(
    khronos: Callable[[Path], dict[str, Any]], tmp_path: Path
) -> None:
    import trimesh

    file = tmp_path / "box.glb"
    trimesh.creation.box().export(file)
    report = khronos(file)
    assert report["issues"]["numErrors"] == 0
    assert report["info"]["totalTriangleCount"] == 12

    data = file.read_bytes()
    assert b"VEC3" in data
    file.write_bytes(data.replace(b"VEC3", b"VEC2"))
    assert khronos(file)["issues"]["numErrors"] > 0
