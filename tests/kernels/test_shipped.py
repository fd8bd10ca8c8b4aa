"""Compiled code that is part of the package is used where it fits, and nowhere else."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import event

from subsea.base.source_stamp import ROOT
from subsea.geometry.vector import dot
from subsea.kernels import cache, kernel
from tools.build_wheel import collect_kernels, target_settings

ROW = (1.0, 2.0, 3.0)
COMPILE = f"""
from subsea.geometry.vector import dot
from subsea.kernels.cache import processor
dot({ROW}, {ROW})
print(processor().cpu)
"""


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    """A folder of one kernel, made as a wheel's is."""
    folder = tmp_path_factory.mktemp("shipped")
    env = os.environ | target_settings() | {"NUMBA_CACHE_DIR": str(folder / "made")}
    run = subprocess.run(
        [sys.executable, "-P", "-c", COMPILE], env=env, cwd=ROOT, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == [target_settings()["NUMBA_CPU_NAME"]]
    collect_kernels(folder / "made", folder / "kernels")
    return folder / "kernels"


@pytest.fixture
def package(shipped, tmp_path, monkeypatch):
    """A copy of that folder in the place of the package's, beside an empty cache of the user."""
    folder = tmp_path / "kernels"
    shutil.copytree(shipped, folder)
    monkeypatch.setattr(cache, "SHIPPED", folder)
    monkeypatch.setattr(cache.caching.config, "CACHE_DIR", str(tmp_path / "own"))
    cache._manifest.cache_clear()
    yield folder
    cache._manifest.cache_clear()


class _Compiled(event.Listener):
    """Counts what numba compiles."""

    def __init__(self):
        self.number = 0

    def on_start(self, event):
        self.number += 1

    def on_end(self, event):
        pass


def _compiled() -> int:
    """Count the compilations of a call of the kernel, as in a new process."""
    listener = _Compiled()
    with event.install_listener("numba:compile", listener):
        assert kernel(dot.py_func)(ROW, ROW) == 14.0
    return listener.number


def _edit(folder: Path, **changes: object) -> None:
    path = folder / cache.MANIFEST
    path.write_text(json.dumps(json.loads(path.read_bytes()) | changes))


def test_shipped_code_is_loaded_and_nothing_is_compiled_or_written(package, tmp_path):
    assert _compiled() == 0
    assert not list((tmp_path / "own").rglob("*.nb*"))


def test_without_shipped_code_a_call_compiles(package):
    shutil.rmtree(package)
    assert _compiled() == 1


def test_the_users_own_cache_comes_first(package, tmp_path):
    manifest = package / cache.MANIFEST
    manifest.rename(tmp_path / "away")
    assert _compiled() == 1
    (tmp_path / "away").rename(manifest)
    cache._manifest.cache_clear()
    for path in package.rglob("*.nb*"):
        path.unlink()
    assert _compiled() == 0


@pytest.mark.parametrize("name", ["python", "numba", "llvmlite", "numpy"])
def test_code_of_another_version_is_not_used(package, name):
    _edit(package, versions=cache.versions() | {name: "0.1"})
    assert cache.shipped_target() is None
    assert _compiled() == 1


def test_a_processor_without_a_feature_compiles(package, monkeypatch):
    has = cache.processor()
    lacking = has.features.replace("+sse2,", "-sse2,")
    monkeypatch.setattr(cache, "processor", lambda: has._replace(features=lacking))
    assert lacking != has.features
    assert cache.shipped_target() is None
    assert _compiled() == 1


def test_a_target_runs_code_for_fewer_features_on_the_same_system():
    code = cache.Target("x86_64-apple-darwin20.0", "x86-64-v3", "+avx,+avx2")
    rich = cache.Target("x86_64-apple-darwin25.1.0", "znver3", "+avx,+avx2,+sha,-avx512f")
    assert rich.runs(code)
    assert not code.runs(rich)
    assert not rich._replace(features="+avx,-avx2,+sha").runs(code)
    assert not rich._replace(triple="x86_64-unknown-linux-gnu").runs(code)


@pytest.mark.parametrize("kept", [b"", b"cut", None])
@pytest.mark.parametrize("pattern", ["*.nbi", "*.nbc"])
def test_damaged_code_compiles_again(package, pattern, kept):
    [path] = package.rglob(pattern)
    path.write_bytes(path.read_bytes()[:-9] if kept is None else kept)
    assert _compiled() == 1


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"target": 3}', '{"target": [1, 2, 3]}'])
def test_a_damaged_manifest_means_that_nothing_is_shipped(package, text):
    (package / cache.MANIFEST).write_text(text)
    assert cache.shipped_target() is None


def test_it_works_where_nothing_may_be_written(package, monkeypatch, capsys):
    """Neither in the package nor in a folder of the user."""
    monkeypatch.setattr(cache.caching.config, "CACHE_DIR", "")

    def refused(path: str) -> None:
        raise PermissionError(path)

    monkeypatch.setattr(cache, "_make_folder", refused)
    cache.report.cache_clear()
    assert _compiled() == 0
    assert not capsys.readouterr().err
    shutil.rmtree(package)
    assert _compiled() == 1
    assert "no folder for it is yours alone" in capsys.readouterr().err
    cache.report.cache_clear()
