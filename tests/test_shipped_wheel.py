"""A wheel with compiled kernels and first results: from it a first start makes nothing."""

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path
from zipfile import ZipFile

import pytest

from subsea.base.system import resource_names
from tools.build_wheel import NOT_SHIPPED

ROOT = Path(__file__).parents[1]
COUNT = ROOT / "tests" / "support" / "count_compiled.py"

pytestmark = [pytest.mark.nightly, pytest.mark.timeout(1800)]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dist")
    tool = [sys.executable, str(ROOT / "tools" / "build_wheel.py"), "-d", str(folder)]
    subprocess.run(tool, check=True)
    [made] = folder.glob("*.whl")
    return made


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    """The interpreter of a new environment with the wheel, and the packages of this one."""
    folder = tmp_path_factory.mktemp("new")
    venv.create(folder, symlinks=True)
    libraries = Path(
        sysconfig.get_path("purelib", "venv", {"base": str(folder), "platbase": str(folder)})
    )
    ZipFile(wheel).extractall(libraries)
    (libraries / "others.pth").write_text(sysconfig.get_path("purelib"))
    return folder / "bin" / "python"


def _run(python, cache, *words, **settings):
    env = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    env.pop("PYTHONPATH", None)
    env |= {"XDG_CACHE_HOME": str(cache), "HOME": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [python, "-P", *words], env=env | settings, cwd=cache, capture_output=True, text=True
    )


def test_the_wheel_is_for_this_python_and_system(wheel):
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert f"-{tag}-{tag}-linux_x86_64" in wheel.name
    held = ZipFile(wheel).namelist()
    assert "subsea/_data/kernels/manifest.json" in held
    assert any(name.startswith("subsea/_data/kept/_grow-") for name in held)


@pytest.mark.parametrize("scenario", resource_names("assets/scenarios", ".toml"))
def test_a_first_film_compiles_and_computes_nothing(python, tmp_path, scenario):
    words = "film", "sea.mp4", "--scenario", scenario, "--seconds", "0.1", "--size", "64x64"
    run = _run(python, tmp_path, str(COUNT), *words)
    assert run.returncode == 0, run.stderr
    kept = sorted(path.name for path in (tmp_path / "subsea" / "kept").glob("*.data"))
    assert [name for name in kept if not name.startswith(NOT_SHIPPED)] == []
    assert not list(tmp_path.rglob("*.nb*"))


def test_a_first_dive_compiles_nothing(python, tmp_path, display):
    run = _run(python, tmp_path, str(COUNT), "dive", "--seconds", "1", "--quality", "low")
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize(
    ("settings", "compiles"),
    [({}, 0), ({"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": "+sse2"}, 1)],
)
def test_a_processor_without_the_features_compiles(python, tmp_path, settings, compiles):
    program = f"""
import sys
sys.path.insert(0, {str(COUNT.parent)!r})
from count_compiled import Compiled, event
from subsea.geometry.vector import dot
compiled = Compiled()
with event.install_listener("numba:compile", compiled):
    assert dot((1.0, 2.0, 3.0), (1.0, 2.0, 3.0)) == 14.0
print(len(compiled.names))
"""
    run = _run(python, tmp_path, "-c", program, **settings)
    assert run.returncode == 0, run.stderr
    assert int(run.stdout) == compiles
