"""A scene in Godot 3, without a window: the importer of its editor, and its animation player."""

import json
import shutil
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from subsea.export.gltf_scene import WRITER
from subsea.export.options import SceneOptions
from subsea.export.scene import Scene
from tests.support.gltf_reader import Reader

FOLDER = Path(__file__).parents[2] / "tools" / "godot"
IMPORT_S = 120.0
FPS = 30
SECONDS = 0.7  # of a frame
CLOSE_M = 1e-4


@pytest.fixture(scope="module")
def project(dive: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with the fishes of a dive, imported."""
    if not (program := shutil.which("godot3-server")):
        pytest.skip("Godot is missing: `apt install godot3-server`")
    folder = tmp_path_factory.mktemp("godot")
    for name in ("project.godot", "play.gd"):
        shutil.copy2(FOLDER / name, folder)
    WRITER.write(replace(dive, statics=(), fps=float(FPS)), folder / "scene.glb", SceneOptions())
    _import(program, folder)
    # As it comes, the importer takes 15 frames a second and drops those that are nearly between
    # others: joints are up to 3 mm off.
    settings = folder / "scene.glb.import"
    text = settings.read_text().replace("animation/fps=15", f"animation/fps={FPS}")
    settings.write_text(text.replace("optimizer/enabled=true", "optimizer/enabled=false"))
    shutil.rmtree(folder / ".import")
    _import(program, folder)
    return folder


def _import(program: str, folder: Path) -> None:
    """Start the editor, which imports what is new; without a window it does not end by itself."""
    with (folder / "log").open("w") as log:
        command = [program, "--path", str(folder), "--editor", "--quit"]
        editor = subprocess.Popen(command, stdout=log, stderr=log)
        try:
            end = time.monotonic() + IMPORT_S
            while not list(folder.glob(".import/scene.glb-*.md5")):
                assert editor.poll() is None and time.monotonic() < end, "not imported"
                time.sleep(0.1)
        finally:
            editor.kill()
            editor.wait()


@pytest.mark.nightly
def test_the_joints_are_where_the_file_has_them(project: Path) -> None:
    said = subprocess.run(
        ["godot3-server", "--path", str(project), "-s", "play.gd", str(SECONDS)],
        capture_output=True, text=True, timeout=IMPORT_S,
    ).stdout  # fmt: skip
    [line] = [one for one in said.splitlines() if one.startswith("PLACES ")]
    found = np.array(list(json.loads(line.removeprefix("PLACES ")).values()))
    file = Reader(project / "scene.glb")
    [name] = file.animations
    moment = file.worlds(name, np.array([SECONDS]))
    joints = sorted({joint for skin in file.content["skins"] for joint in skin["joints"]})
    wanted = np.array([moment.world[joint].reshape(4, 4)[:3, 3] for joint in joints])
    assert len(found) == len(wanted) > 100
    assert cKDTree(found).query(wanted)[0].max() < CLOSE_M
    assert cKDTree(wanted).query(found)[0].max() < CLOSE_M
