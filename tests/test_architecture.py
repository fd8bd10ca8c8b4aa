"""The structure of docs/developers/architecture.md: imports, sizes and names."""

import ast
import re
import subprocess
import sys
from collections import defaultdict
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest

from subsea.base.syntax import parse_source

ROOT = Path(__file__).parents[1]


def test_imports_keep_the_contracts():
    """Every contract of `[tool.importlinter]`."""
    program = Path(sys.executable).with_name("lint-imports")
    done = subprocess.run(
        [str(program), "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_pytest_skips_no_folder_of_tests(pytestconfig):
    folders = {
        name
        for path in ROOT.glob("tests/**/test_*.py")
        for name in path.relative_to(ROOT).parts[:-1]
    }
    skipped = pytestconfig.getini("norecursedirs")
    assert not [name for name in folders for pattern in skipped if fnmatch(name, pattern)]


MOST_PARAMETERS = 8
MOST_LINES = 600
LONG = "# Over 600 lines: "  # begins the line that gives the reason for a longer module
MODULES = [*ROOT.glob("subsea/**/*.py"), *ROOT.glob("capture/**/*.py")]


@cache
def definitions():
    """Names of classes, and parameters of functions, by their positions."""
    classes, functions = {}, {}
    for path in MODULES:
        for node in ast.walk(parse_source(path.read_text("utf-8"))):
            if isinstance(node, ast.ClassDef):
                classes[f"{path.relative_to(ROOT)}:{node.lineno}"] = node.name
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                given = node.args
                names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
                functions[f"{path.relative_to(ROOT)}:{node.lineno} {node.name}"] = names
    return classes, functions


def test_a_function_takes_at_most_eight_parameters():
    _, functions = definitions()
    crowded = {
        where
        for where, names in functions.items()
        if len({*names} - {"self", "cls"}) > MOST_PARAMETERS
    }
    assert len(functions) > 4000 and not crowded


def test_a_module_has_at_most_600_lines_or_says_why():
    texts = {path: path.read_text(encoding="utf-8").splitlines() for path in MODULES}
    long = [path for path, lines in texts.items() if len(lines) > MOST_LINES]
    assert not [path for path in long if not any(line.startswith(LONG) for line in texts[path])]


def test_processes_of_python_run_no_code_of_the_current_folder():
    for path in MODULES:
        for option in re.findall(r"sys\.executable,\s*(\S+)", path.read_text(encoding="utf-8")):
            assert option == '"-P",', path


def test_class_names_are_unique():
    places = defaultdict(list)
    for where, name in definitions()[0].items():
        places[name].append(where)
    # `subsea.World` is the world of all other rooms with a lock on its arrays.
    assert [name for name, where in places.items() if len(where) > 1] == ["World"]


@pytest.mark.parametrize(
    ("module", "others"),
    [
        # `subsea simulate` runs on machines that have neither OpenGL nor windows.
        ("subsea.lab.simulate", ("moderngl", "glfw", "imgui_bundle", "av")),
        # A dive begins without what few dives need.
        ("subsea.ui.dive", ("h5py", "PIL", "zmq", "tqdm", "av", "scipy.linalg")),
    ],
)
def test_a_command_imports_only_what_it_needs(module, others):
    program = f"import sys, {module}; print([m for m in {others} if m in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "page", [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")], ids=lambda p: p.name
)
def test_every_link_of_the_documentation_exists(page):
    links = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
    missing = [k for k in links if "://" not in k and not (page.parent / k).exists()]
    assert not missing
