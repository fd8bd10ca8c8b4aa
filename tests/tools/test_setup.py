"""The set-up script, with stand-ins for the programs that it calls."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "setup.sh"
REAL = "sh cat dirname env grep mkdir touch"
LOCKED = "E: Could not get lock /var/lib/dpkg/lock-frontend. It is held by process 7"


class Machine:
    """A checkout, and a PATH with only a few programs."""

    def __init__(self, root: Path) -> None:
        self.root, self.bin = root, root / "bin"
        for folder in ("tools/gltf-validator", ".venv/bin", "bin"):
            (root / folder).mkdir(parents=True)
        shutil.copy(SCRIPT, root / "tools")
        for name in REAL.split():
            (self.bin / name).symlink_to(shutil.which(name) or "")
        self.program("id", "echo 0")
        self.program("sleep", "echo $1 >>slept")
        self.program("uname", "echo Linux")
        self.program("../.venv/bin/uv", "echo uv 0.13.8")
        self.program("../.venv/bin/python", "exit 0")

    def program(self, name: str, *lines: str) -> None:
        path = self.bin / name
        path.write_text("\n".join(("#!/bin/sh", *lines, "")))
        path.chmod(0o755)

    def set_up(self, purpose: str) -> tuple[int, str]:
        """Exit status and messages."""
        done = subprocess.run(
            ["/bin/sh", "tools/setup.sh", purpose], cwd=self.root,
            env={"PATH": str(self.bin)}, capture_output=True, text=True,
        )  # fmt: skip
        return done.returncode, done.stderr

    def ready(self, purpose: str) -> bool:
        return (self.root / f".venv/ready-{purpose}").exists()


@pytest.fixture
def machine(tmp_path):
    """A Debian machine without the packages, whose apt-get works."""
    one = Machine(tmp_path)
    one.program("dpkg-query", "exit 1")
    one.program("apt-get", "echo $@ >>installed")
    return one


def test_packages_are_installed_and_the_set_up_is_marked(machine):
    for purpose in ("run", "bench", "test"):
        code, said = machine.set_up(purpose)
        assert code == 0 and "installing system packages: libegl1" in said
        assert machine.ready(purpose)
    installed = (machine.root / "installed").read_text()
    assert "-qq update" in installed and "install -y --no-install-recommends libegl1" in installed
    assert "xvfb" in installed


def test_it_waits_for_another_package_manager(machine):
    machine.program(
        "apt-get",
        "if [ ! -e third ]; then",
        "  [ -e second ] && touch third; touch second",
        f'  echo "{LOCKED}" >&2; exit 100',
        "fi",
    )
    code, said = machine.set_up("test")
    assert code == 0 and machine.ready("test")
    assert said.count("another package manager is at work") == 1 and LOCKED not in said
    assert (machine.root / "slept").read_text().split() == ["5", "5"]


def test_it_does_not_wait_for_ever(machine):
    machine.program("apt-get", f'echo "{LOCKED}" >&2; exit 100')
    code, said = machine.set_up("test")
    assert code == 1 and LOCKED in said and "sudo apt-get install" in said
    assert len((machine.root / "slept").read_text().split()) == 120


@pytest.mark.parametrize(("purpose", "expected"), [("run", 0), ("bench", 0), ("test", 1)])
def test_a_set_up_without_its_packages_is_not_marked(machine, purpose, expected):
    """A dive may have a picture all the same; the tests need all of them."""
    machine.program("apt-get", "echo no network >&2; exit 100")
    code, said = machine.set_up(purpose)
    assert code == expected and "no network" in said and "sudo apt-get install" in said
    assert not machine.ready(purpose)
    assert ("tries again" in said) == (purpose != "test")


def test_a_set_up_without_the_validator_is_not_marked(machine):
    machine.program("../.venv/bin/python", "exit 1")
    code, said = machine.set_up("test")
    assert code == 0 and "npm could not install" in said and not machine.ready("test")
    machine.program("../.venv/bin/python", "exit 0")
    assert machine.set_up("test")[0] == 0 and machine.ready("test")


def test_without_debian_packages_it_names_the_missing_libraries(tmp_path):
    machine = Machine(tmp_path)
    script = machine.root / "tools/setup.sh"
    script.write_text(script.read_text().replace('"libEGL.so.1 ', '"libnowhere.so.1 libc.so.6 '))
    machine.program("../.venv/bin/python", f'exec {sys.executable} "$@"')
    code, said = machine.set_up("run")
    assert code == 0 and not machine.ready("run")
    [line] = [line for line in said.splitlines() if "missing:" in line]
    assert "libnowhere.so.1" in line and "libc" not in line
    assert "sudo dnf install" in said and "sudo pacman" in said
    code, said = machine.set_up("test")
    assert code == 1 and "Xvfb" in said
