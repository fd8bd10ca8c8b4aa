"""A systemd of the user's own, in namespaces of its own: no other service manager is needed."""

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

# systemd runs as a user's only where a system's has booted, which this folder says, and in a
# version 2 hierarchy of control groups.
BEGIN = """
mount -t tmpfs tmpfs /run && mkdir -p /run/systemd/system &&
mount -t tmpfs tmpfs /sys/fs/cgroup && mount -t cgroup2 cgroup2 /sys/fs/cgroup &&
mkdir -p /sys/fs/cgroup/$1 && echo $$ > /sys/fs/cgroup/$1/cgroup.procs &&
exec "$2" --user --log-target=console
"""
PROGRAMS = "/lib/systemd/systemd", "/usr/lib/systemd/systemd"


class Systemd:
    """A running service manager; its units are files of the folder `units`."""

    def __init__(self, home: Path) -> None:
        self.units = home / ".config/systemd/user"
        self.environment = os.environ | {"HOME": str(home), "XDG_RUNTIME_DIR": str(home / "run")}
        for name in ("DBUS_SESSION_BUS_ADDRESS", "XDG_CONFIG_HOME", "XDG_STATE_HOME"):
            self.environment.pop(name, None)

    def control(self, *words: str, check: bool = True) -> str:
        """The output of systemctl."""
        done = subprocess.run(
            ["systemctl", "--user", "--no-pager", *words], env=self.environment, timeout=400,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert not check or done.returncode == 0, done.stderr
        return done.stdout

    def state(self, unit: str) -> dict[str, str]:
        """Properties of a unit."""
        names = "ActiveState,SubState,Result,NRestarts,MainPID,StatusText,ExecMainStatus"
        lines = self.control("show", unit, f"--property={names}").splitlines()
        return dict(line.split("=", 1) for line in lines)

    def until(self, unit: str, seconds: float = 400.0, **wanted: str) -> dict[str, str]:
        """The properties of a unit once some have these values."""
        end = time.monotonic() + seconds
        while not wanted.items() <= (now := self.state(unit)).items():
            assert time.monotonic() < end, now
            time.sleep(0.1)
        return now


@contextmanager
def user_systemd(home: Path) -> Iterator[Systemd]:
    """Run systemd with a home, and stop it with all that it started."""
    found = Systemd(home)
    program = next(path for path in PROGRAMS if Path(path).exists())
    found.units.mkdir(parents=True)
    (home / "run").mkdir(mode=0o700)
    group = f"subsea-test-{os.getpid()}"
    words = ["unshare", *([] if os.getuid() == 0 else ["--map-root-user"]), "--mount", "--cgroup"]
    with (home / "systemd.log").open("wb") as log:
        running = subprocess.Popen(
            [*words, "sh", "-c", BEGIN, "sh", group, program], env=found.environment,
            stdout=log, stderr=log, stdin=subprocess.DEVNULL,
        )  # fmt: skip
    try:
        end = time.monotonic() + 30.0
        while not (home / "run/systemd/private").exists():
            assert running.poll() is None and time.monotonic() < end, (
                home / "systemd.log"
            ).read_text()
            time.sleep(0.05)
        yield found
    finally:
        running.terminate()
        try:
            running.wait(60.0)
        except subprocess.TimeoutExpired:
            running.kill()
            running.wait()
        for base in Path("/sys/fs/cgroup").glob("unified"), [Path("/sys/fs/cgroup")]:
            for one in base:
                _remove_group(one / group)


def _remove_group(group: Path) -> None:
    if group.is_dir():
        for folder, _, _ in os.walk(group, topdown=False):
            with suppress(OSError):  # a process in it still ends
                Path(folder).rmdir()
