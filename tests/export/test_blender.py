"""A scene in Blender, from USD and from glTF: `make blender` installs it and runs this."""

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import cKDTree

from subsea.export import gltf_scene, usd_scene
from subsea.export.conventions import METRES
from subsea.export.options import SceneOptions
from subsea.export.scene import Scene
from subsea.geometry.rotation import matrix

ROOT = Path(__file__).parents[2]
BLENDER = ROOT / ".venv" / "blender" / "bin" / "python"
FPS, FRAMES = 30, (0, 17)
OFF = {"usdc": (1e-4, 1e-4), "glb": (5e-3, 3e-2)}  # rms and most, shares of the length of a fish


@pytest.mark.timeout(900)
@pytest.mark.parametrize("kind", OFF)
def test_vertices_are_where_the_dive_has_them(kind: str, dive: Scene, tmp_path: Path) -> None:
    writer = {"usdc": usd_scene, "glb": gltf_scene}[kind].WRITER
    out = tmp_path / f"scene.{kind}"
    scene = replace(dive, fps=float(FPS))  # Blender has whole frames
    writer.write(scene, out, SceneOptions())
    for frame in FRAMES:
        points, picture = tmp_path / f"{frame}.npz", tmp_path / f"{frame}.png"
        tool = ROOT / "tools" / "blender_scene.py"
        command = [BLENDER, tool, out, FPS, frame, points, *([picture] if frame else [])]
        subprocess.run(list(map(str, command)), check=True, capture_output=True, timeout=400)
        _compare(np.load(points), scene, frame, OFF[kind])
    pixels = np.asarray(Image.open(picture).convert("RGB"), float)
    assert np.ptp(pixels, axis=(0, 1)).max() > 50  # sand, stone and fishes before plain water


def _compare(found: np.lib.npyio.NpzFile, scene: Scene, frame: int, off: tuple[float, float]):
    """Blender's world axes are those of the dive, in metres."""
    for k, fish in enumerate(scene.fishes):
        shown = [found[name] for name in found.files if fish.name in name]
        assert shown, (fish.name, found.files)
        tree = cKDTree(np.concatenate(shown))
        points = scene.points(k, frame, frame)[0][0]
        turn = matrix(scene.rotation[frame, k])
        wanted = METRES * (scene.position[frame, k] + points @ turn.T)
        apart = tree.query(wanted)[0] / (METRES * fish.length_cm)
        assert np.sqrt((apart**2).mean()) < off[0] and apart.max() < off[1], fish.name
