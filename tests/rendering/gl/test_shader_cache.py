"""The driver's shader cache is off where its mapped file could end the process."""

import os
import shutil
from types import SimpleNamespace

import pytest

from subsea.dive.start import headless
from subsea.rendering.gl import context as shader_cache

OFF = "MESA_SHADER_CACHE_DISABLE"


@pytest.mark.parametrize(("free", "expected"), [(1 << 20, "true"), (1 << 30, None)])
def test_a_full_disk_turns_the_cache_off(monkeypatch, tmp_path, free, expected):
    asked = []

    def usage(place):
        asked.append(place)
        return SimpleNamespace(free=free)

    monkeypatch.setenv(OFF, "")
    monkeypatch.delenv(OFF)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "missing"))
    monkeypatch.delenv("MESA_SHADER_CACHE_DIR", raising=False)
    monkeypatch.setattr(shutil, "disk_usage", usage)
    shader_cache.avoid_full_disk()
    assert os.environ.get(OFF) == expected
    assert asked == [tmp_path]


def test_contexts_without_a_window_ask(monkeypatch):
    monkeypatch.setattr(shader_cache.shutil, "disk_usage", lambda place: SimpleNamespace(free=0))
    monkeypatch.setenv(OFF, "")
    monkeypatch.delenv(OFF)
    with headless():
        pass
    assert os.environ[OFF] == "true"
