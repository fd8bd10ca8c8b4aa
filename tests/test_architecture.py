"""The house of docs/architecture.md: data travels down the folders, imports only go up."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_imports_only_go_up_the_list_of_folders():
    """Every contract of `[tool.importlinter]`; a new folder without a place is a fault too."""
    program = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [str(program), "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_simulation_loads_no_opengl_and_no_window():
    """`subsea simulate` runs on machines that have neither."""
    program = (
        "import sys, subsea.app.simulate; "
        "print([m for m in ('moderngl', 'glfw', 'imgui_bundle', 'av') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"
