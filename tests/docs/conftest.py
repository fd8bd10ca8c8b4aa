"""PyTorch is large: `make train` installs it and runs these tests."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
READY = (ROOT / ".venv" / "train" / "ready").exists()
collect_ignore = [] if READY else ["test_train_detector.py"]
