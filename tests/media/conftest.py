"""Films."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
# Blender is a gigabyte: `make blender` installs it and runs these.
READY = (ROOT / ".venv" / "blender" / "ready").exists()
collect_ignore = [] if READY else ["test_blender_passes.py"]
