"""The house of docs/architecture.md: data travels down the folders, imports only go up."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def test_imports_only_go_up_the_list_of_folders():
    """Every contract of `[tool.importlinter]`; a new folder without a place is a fault too."""
    program = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [str(program), "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("module", "others"),
    [
        # `subsea simulate` runs on machines that have neither OpenGL nor windows.
        ("subsea.study.simulate", ("moderngl", "glfw", "imgui_bundle", "av")),
        # A dive begins without what few dives need.
        ("subsea.ui.dive", ("h5py", "PIL", "zmq", "tqdm", "av", "scipy.linalg")),
    ],
)
def test_a_command_does_without_what_others_need(module, others):
    program = f"import sys, {module}; print([m for m in {others} if m in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "page", [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")], ids=lambda p: p.name
)
def test_every_link_of_the_documentation_leads_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    missing = [k for k in links if "://" not in k and not (page.parent / k).exists()]
    assert not missing
