"""docs/train_detector.py with PyTorch: `make train` installs it and runs this."""

import re
import subprocess
from pathlib import Path

import pytest
from PIL import Image

from subsea.lab.dataset.make import make_dataset
from subsea.lab.dataset.ranges import read_ranges
from subsea.lab.dataset.scenes import DatasetPlan
from tests.support.scenes import BARE

ROOT = Path(__file__).parents[2]
PYTHON = ROOT / ".venv" / "train" / "bin" / "python"
PLAN = DatasetPlan(
    str(BARE), seed=4, size=(160, 96), ranges=read_ranges(["camera.distance=2:4"]), per_scene=4,
    settle_s=(0.5, 1.0), quality="low", val=0.0,
)  # fmt: skip


@pytest.mark.timeout(900)
def test_a_detector_learns_the_pictures_that_it_sees(tmp_path):
    make_dataset(PLAN, 12, tmp_path / "few", shard=4)
    command = [
        PYTHON, ROOT / "docs" / "train_detector.py", "--train", tmp_path / "few", "--test",
        tmp_path / "few", "--seen", "4000", "--batch", "8", "--sheets", tmp_path / "sheets",
    ]  # fmt: skip
    done = subprocess.run(
        [str(one) for one in command], check=True, capture_output=True, text=True, timeout=800
    )
    losses = [float(one) for one in re.findall(r"loss ([\d.]+)", done.stdout)]
    assert len(losses) == 10
    assert losses[-1] < 0.3 * losses[0]
    boxes, poses = (float(one) for one in re.findall(r"AP50 ([\d.]+)", done.stdout))
    assert boxes > 0.8 and poses > 0.3, done.stdout
    with Image.open(tmp_path / "sheets" / "few-few.png") as page:
        assert page.size == (3 * 160, 4 * 96)
