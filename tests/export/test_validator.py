"""The glTF validator itself: it passes what is sound, and tells what is not."""

from collections.abc import Callable
from pathlib import Path
from typing import Any


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
