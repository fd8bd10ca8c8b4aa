"""A program that starts itself again, and the command by which it does so."""

import os
import subprocess
import sys
from pathlib import Path

from subsea.base import restarts
from subsea.base.command_line import TRANSIENT
from subsea.base.restarts import restart, restart_command

PROGRAM = """#!{python}
import os, sys
from pathlib import Path
mark = Path(sys.argv[1])
if mark.exists():
    print(os.getpid() == int(mark.read_text()), sys.argv[2:])
else:
    mark.write_text(str(os.getpid()))
    from subsea.base.restarts import restart
    sys.exit(restart())
"""


def started(command):
    clean = {name: text for name, text in os.environ.items() if name != restarts.SERVICE}
    root = str(Path(__file__).parents[2])
    return subprocess.run(
        command, env=clean | {"PYTHONPATH": root}, capture_output=True, text=True, check=True
    ).stdout.strip()


def test_a_program_replaces_its_process_by_the_same_command(tmp_path):
    program = tmp_path / "program"
    program.write_text(PROGRAM.format(python=sys.executable))
    words = ["--node", "two words"]
    program.chmod(0o755)
    assert started([str(program), str(tmp_path / "a"), *words]) == f"True {words}"
    program.chmod(0o644)
    by_python = [sys.executable, "-X", "utf8", str(program), str(tmp_path / "b"), *words]
    assert started(by_python) == f"True {words}"


def test_a_service_ends_so_that_its_manager_starts_it_again(monkeypatch):
    monkeypatch.setenv(restarts.SERVICE, "/run/user/1000/systemd/notify")
    monkeypatch.setattr(os, "execv", None)
    assert restart() == TRANSIENT


def test_a_restart_waits_for_what_it_must(monkeypatch):
    done = []
    monkeypatch.delenv(restarts.SERVICE, raising=False)
    monkeypatch.setattr(restarts, "_awaited", [])
    monkeypatch.setattr(os, "execv", lambda *command: done.append("exec"))
    restarts.wait_first(lambda: done.append("waited"))
    restart()
    assert done == ["waited", "exec"]


def test_a_program_that_has_gone_is_a_line(monkeypatch, capsys):
    monkeypatch.delenv(restarts.SERVICE, raising=False)
    monkeypatch.setattr(sys, "argv", ["gone"])
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    assert restart() == TRANSIENT
    assert capsys.readouterr().err == (
        "subsea: cannot start again: /nowhere/python (No such file or directory)\n"
    )


def test_a_program_is_started_by_its_own_path(tmp_path):
    program = tmp_path / "subsea"
    program.touch()
    given = [str(program), "dive"], ["python", "-P", str(program), "dive"], "/venv/bin/python"
    assert restart_command(*given) == ["/venv/bin/python", "-P", str(program), "dive"]
    program.chmod(0o755)
    assert restart_command(*given) == [str(program), "dive"]
