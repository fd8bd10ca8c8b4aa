"""A wheel is installed beside the running version, tried, switched to and rolled back."""

import importlib.util
import os
import subprocess
import sys
import venv
import zipfile
from importlib.metadata import requires
from pathlib import Path

import pytest

from subsea.base.errors import UserError
from subsea.stage.fleet import installing
from subsea.stage.fleet.installing import (
    MARK,
    LinkedEnvironment,
    install,
    missing_packages,
    remove_old,
    roll_back,
    running_installation,
    switch,
    version_before,
)
from subsea.stage.fleet.wheel import read_wheel

MAIN = 'import sys\n\ndef main():\n    print("subsea {version}")\n    return {code}\n'
ENTRY = "[console_scripts]\nsubsea = subsea:main\n"
TAGS = "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n"


def make_wheel(folder, version="2.0", needs=("helper>=1",), code=0, said=None):
    """A wheel of a program that says its version and ends with a code."""
    info = f"subsea-{version}.dist-info"
    about = f"Metadata-Version: 2.1\nName: subsea\nVersion: {version}\n"
    files = {
        "subsea/__init__.py": MAIN.format(version=said or version, code=code),
        f"{info}/METADATA": about + "".join(f"Requires-Dist: {one}\n" for one in needs),
        f"{info}/WHEEL": TAGS,
        f"{info}/entry_points.txt": ENTRY,
    }
    record = "".join(f"{name},,\n" for name in (*files, f"{info}/RECORD"))
    path = folder / f"subsea-{version}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in (*files.items(), (f"{info}/RECORD", record)):
            archive.writestr(name, text)
    return path


@pytest.fixture
def place(tmp_path):
    """An environment with a program, a package that it needs, and pip; a link leads to it."""
    old = tmp_path / "first"
    venv.EnvBuilder(symlinks=True).create(old)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    site = old / "lib" / version / "site-packages"
    pip = Path(importlib.util.find_spec("pip").origin).parent
    (site / "pip").symlink_to(pip)
    for name in ("helper", "subsea"):
        (site / f"{name}-1.0.dist-info").mkdir()
        about = f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n"
        (site / f"{name}-1.0.dist-info/METADATA").write_text(about)
    (site / "helper.py").write_text("")
    program = old / "bin/subsea"
    program.write_text("#!/bin/sh\necho subsea 1.0\n")
    program.chmod(0o755)
    (tmp_path / "current").symlink_to("first")
    return LinkedEnvironment(tmp_path / "current", site)


def said(place):
    clean = {name: text for name, text in os.environ.items() if not name.startswith("PYTHON")}
    program = [str(place.link / "bin/subsea"), "--version"]
    return subprocess.run(program, env=clean, capture_output=True, text=True).stdout.strip()


def test_a_wheel_is_installed_switched_to_and_rolled_back(place, tmp_path):
    wheel = read_wheel(make_wheel(tmp_path))
    folder = install(wheel, place)
    assert said(place) == "subsea 1.0"  # nothing has changed yet
    switch(place, folder)
    assert said(place) == "subsea 2.0"
    assert place.link.is_symlink()
    with pytest.raises(UserError, match="runs this very wheel already"):
        install(wheel, place)
    assert version_before(place) == "1.0"
    roll_back(place)
    assert said(place) == "subsea 1.0"
    assert version_before(place) == "2.0"
    with pytest.raises(UserError, match="the version before is this very wheel"):
        install(wheel, place)
    left = tmp_path / "subsea-1.5-00000000"
    left.mkdir()
    (left / MARK).touch()
    remove_old(place)
    assert not left.exists()
    assert folder.is_dir()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"code": 1}, "subsea --version: exit code 1: subsea 2.0"),
        pytest.param({"said": "1.9"}, "expected version 2.0", marks=pytest.mark.nightly),
        pytest.param({"needs": ["helper>=2"]}, "helper", marks=pytest.mark.nightly),
    ],
)
def test_a_wheel_that_does_not_work_leaves_nothing(place, tmp_path, changes, words):
    wheel = read_wheel(make_wheel(tmp_path, **changes))
    with pytest.raises(UserError, match=words):
        install(wheel, place)
    assert said(place) == "subsea 1.0"
    assert not list(tmp_path.glob("subsea-2.0-*/"))
    with pytest.raises(UserError, match="there is no version before"):
        version_before(place)


def test_other_packages_are_refused():
    have = requires("subsea")
    assert missing_packages(have) == ""
    needed = [*have, "magic>=3"]
    assert missing_packages(needed) == (
        "needs other packages than this version: magic>=3; install it by hand"
    )


def test_a_checkout_and_an_environment_without_a_link_are_refused(monkeypatch, tmp_path):
    with pytest.raises(UserError, match="runs from a checkout"):
        running_installation()
    monkeypatch.setattr(installing, "CHECKOUT", tmp_path / "none")
    with pytest.raises(UserError, match="was not started through a link to its environment"):
        running_installation()
    (tmp_path / "current").symlink_to(sys.prefix)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "current/bin/python"))
    assert running_installation().link == tmp_path / "current"


@pytest.mark.parametrize("name", ["other-2.0-py3-none-any.whl", "subsea-2.0.zip", "subsea.whl"])
def test_only_wheels_of_subsea_are_read(tmp_path, name):
    (tmp_path / name).write_bytes(b"PK")
    with pytest.raises(UserError, match="expected a wheel of subsea"):
        read_wheel(tmp_path / name)


def test_damaged_wheels_are_refused(tmp_path):
    path = make_wheel(tmp_path)
    assert read_wheel(path)[1:3] == ("2.0", path.stat().st_size)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(UserError, match="not a wheel, or a damaged one"):
        read_wheel(path)
    other = make_wheel(tmp_path, "3.0").rename(path)
    with pytest.raises(UserError, match=r"not a wheel|expected what its name says"):
        read_wheel(other)
