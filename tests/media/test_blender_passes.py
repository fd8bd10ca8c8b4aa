"""Passes of a film in Blender's compositor: `make blender` installs it and runs this."""

import subprocess
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from subsea.cli.main import main
from subsea.media.cryptomatte import hashed
from tests.support.scenes import BARE

ROOT = Path(__file__).parents[2]
BLENDER = ROOT / ".venv" / "blender" / "bin" / "python"
SIZE = 160, 120


def pixels(path: Path) -> dict[str, np.ndarray]:
    return {name: one.pixels for name, one in OpenEXR.File(str(path)).channels().items()}


@pytest.mark.timeout(300)
@pytest.mark.usefixtures("one_context")
def test_blender_puts_the_picture_together_and_finds_the_matte(tmp_path: Path) -> None:
    frame, out = tmp_path / "frame.exr", tmp_path / "composed.exr"
    shot = ["--scenario", str(BARE), "--size", "160x120", "--seed", "1", "--seconds", "0.1"]
    assert main(["film", str(frame), *shot, "--follow", "clownfish", "--passes", "all"]) == 0
    command = [BLENDER, ROOT / "tools/blender_passes.py", frame, *SIZE, "clownfish", out]
    subprocess.run(list(map(str, command)), check=True, capture_output=True, timeout=200)
    ours, theirs = pixels(frame), pixels(out)["RGBA"]
    np.testing.assert_allclose(theirs[..., :3], ours["RGBA"][..., :3], rtol=8 * 2.0**-11, atol=1e-4)
    matte = np.zeros(SIZE[::-1], np.float32)
    for layer in (f"CryptoSpecies0{k}" for k in range(3)):
        for name, share in ((0, 1), (2, 3)):
            found = ours[layer][..., name].view(np.uint32) == hashed("clownfish")
            matte += np.where(found, ours[layer][..., share], 0.0)
    assert matte.sum() > 100.0
    np.testing.assert_allclose(theirs[..., 3], matte, atol=1e-6)
