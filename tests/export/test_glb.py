from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from subsea.export.axes import Y_UP, Z_UP, rotate_quaternions, to_metres
from subsea.export.glb import INDICES, VERTICES, GlbBuffer, glb
from subsea.geometry.rotation import matrix, normalised


def test_the_axes_are_right_handed_and_rotations_agree() -> None:
    """A fish heads along +z of glTF and along -y of Blender, back up, left along +x."""
    ahead, up, right = np.eye(3) * 100.0
    np.testing.assert_allclose(to_metres(ahead, Y_UP), (0, 0, 1))
    np.testing.assert_allclose(to_metres(ahead, Z_UP), (0, -1, 0))
    np.testing.assert_allclose(to_metres(up, Y_UP), (0, 1, 0))
    np.testing.assert_allclose(to_metres(up, Z_UP), (0, 0, 1))
    np.testing.assert_allclose(to_metres(-right, Y_UP), (1, 0, 0))
    np.testing.assert_allclose(to_metres(-right, Z_UP), (1, 0, 0))
    rotation = np.array(normalised(np.array([0.3, -0.5, 0.2, 0.7])))
    for axes in (Y_UP, Z_UP):
        assert np.linalg.det(axes) > 0.0
        point = to_metres(matrix(rotation) @ ahead, axes)
        np.testing.assert_allclose(
            matrix(rotate_quaternions(rotation, axes)) @ to_metres(ahead, axes), point
        )


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


def test_arrays_come_back(tmp_path: Path) -> None:
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
