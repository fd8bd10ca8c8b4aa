"""`subsea soak --kiosk`: a real kiosk whose power is cut again and again."""

import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean

import msgspec

from subsea.base.command_line import TRANSIENT
from subsea.base.errors import UserError
from subsea.base.interrupts import INTERRUPTED
from subsea.base.progress import count_noun, say
from subsea.stage.service import SOCKET
from subsea.stage.show_file import load_show
from subsea.stage.show_player import MOST_BYTES, SavedShow

FIRST_S, START_S = 900.0, 180.0  # until a start must show the sea; the first one compiles
STILL_S = 60.0  # a kiosk that shows no picture for this long hangs
RUNS_S = 30.0  # longest time between the first picture and the cut: a state is saved meanwhile
EARLY, FULL = 4, 3  # each such start is cut while it loads, or has a full disk
END_S = 60.0  # to end when it is asked to
MOST_FAULTS = 5

PLAYLIST = """title = "soak"
fade_s = 0.5
[[item]]
scenario = {scenario!r}
tour = "auto"
for_s = 20
[[item]]
scenario = {scenario!r}
caption = "the second item"
for_s = 20
"""


class _Kiosk:
    """A process of `subsea dive --kiosk`, and what it tells a service manager."""

    def __init__(self, command: list[str], folder: Path, full: bool) -> None:
        self.path = folder / "notify"
        with suppress(FileNotFoundError):
            self.path.unlink()
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(self.path))
        self.log = folder / "log"
        environment = os.environ | {
            SOCKET: str(self.path), "XDG_STATE_HOME": str(folder / "state"),
        }  # fmt: skip
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                command, env=environment, stdout=log, stderr=log, stdin=subprocess.DEVNULL,
                start_new_session=True, preexec_fn=_fill_disk if full else None,
            )  # fmt: skip

    def heard(self, word: str, seconds: float) -> bool:
        """True once a message has a line; False if it ended, or after that time."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            self._socket.settimeout(min(left, 0.2))
            with suppress(TimeoutError):
                if word in self._socket.recv(4096).decode(errors="replace").split("\n"):
                    return True
            if self.process.poll() is not None:
                return False
        return False

    def cut(self) -> None:
        """End it with all its processes at once, as a cut of the power does."""
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self._socket.close()

    def last_line(self) -> str:
        """Its last words."""
        return (self.log.read_text(errors="replace").splitlines() or ["nothing"])[-1]


@dataclass
class KioskReport:
    """The observations of a soak."""

    starts_s: list[float] = field(default_factory=list)  # until the first picture of the sea
    full: int = 0  # starts with a full disk
    early: int = 0  # cuts while it still loaded
    resumed: int = 0  # starts that found a saved state
    faults: list[str] = field(default_factory=list)


def soak_kiosk(scenario: str, minutes: float, seed: int | None, playlist: Path | None) -> int:
    """Start a kiosk, cut its power at a random moment, and so on; 1 if anything was found.

    Each start must show the sea and go on showing pictures, also while no file can grow, and find
    whole files. `playlist` is a show; None: one of two items in the scenario. Needs a display.
    """
    if not hasattr(os, "killpg"):
        raise UserError("soak: --kiosk needs Linux or macOS")
    rng = random.Random(seed or 0)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if playlist is None:
            playlist = folder / "show.toml"
            named = str(Path(scenario).absolute()) if scenario.endswith(".toml") else scenario
            playlist.write_text(PLAYLIST.format(scenario=named), encoding="utf-8")
        load_show(playlist)
        command = [
            sys.executable, "-P", "-m", "subsea", "dive", "--kiosk", "--playlist", str(playlist),
            "--quality", "low",
        ]  # fmt: skip
        report = _rounds(command, folder, 60.0 * minutes, rng)
        leftovers = list(folder.rglob(".*.part*"))
    return _print(report, len(leftovers))


def _rounds(command: list[str], folder: Path, seconds: float, rng: random.Random) -> KioskReport:
    report = KioskReport()
    end, limit_s = time.monotonic() + seconds, FIRST_S
    while len(report.faults) < MOST_FAULTS:
        last = bool(report.starts_s) and time.monotonic() > end
        number = len(report.starts_s) + report.early  # of starts so far
        full = not last and number % FULL == 1
        early = not last and number % EARLY == EARLY - 1
        report.full, report.early = report.full + full, report.early + early
        report.resumed += (folder / "state/subsea/show.state").exists()
        begun = time.monotonic()
        kiosk = _Kiosk(command, folder, full)
        try:
            if early:
                time.sleep(rng.uniform(0.0, mean(report.starts_s)))
            elif not kiosk.heard("READY=1", limit_s):
                code = kiosk.process.poll()
                what = "showed no sea in time" if code is None else f"ended with {code}"
                report.faults.append(f"a start {what}: {kiosk.last_line()}")
                if code == TRANSIENT:  # no display: no other start would differ
                    break
            else:
                report.starts_s.append(time.monotonic() - begun)
                limit_s = START_S
                report.faults.extend(_watch(kiosk, 5.0 if last else rng.uniform(0.0, RUNS_S)))
                if last:
                    report.faults.extend(_end(kiosk))
        finally:
            kiosk.cut()
        report.faults.extend(_faults_of_files(folder / "state/subsea"))
        if last:
            break
    return report


def _watch(kiosk: _Kiosk, seconds: float) -> list[str]:
    """Wait, and see that pictures are shown."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        heard = kiosk.heard("WATCHDOG=1", min(left, STILL_S))
        if kiosk.process.poll() is not None:
            return [f"it ended with {kiosk.process.returncode}: {kiosk.last_line()}"]
        if not heard and left > STILL_S:
            return [f"no picture for {STILL_S:.0f} s"]
    return []


def _end(kiosk: _Kiosk) -> list[str]:
    """End a kiosk as `systemctl stop` does."""
    kiosk.process.terminate()
    try:
        code = kiosk.process.wait(END_S)
    except subprocess.TimeoutExpired:
        return [f"it does not end within {END_S:.0f} s"]
    return [] if code == INTERRUPTED else [f"it ended with {code}, expected {INTERRUPTED}"]


def _faults_of_files(state: Path) -> list[str]:
    """Files that are not whole after a cut."""
    path = state / "show.state"
    if not path.exists():
        return []
    try:
        with path.open("rb") as file:
            msgspec.msgpack.decode(file.read(MOST_BYTES), type=SavedShow)
    except (OSError, msgspec.DecodeError) as fault:
        return [f"{path.name} is not whole: {fault}"]
    return []


def _fill_disk() -> None:
    """Let no file of this process grow, as on a full disk."""
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def _print(report: KioskReport, leftovers: int) -> int:
    starts, faults = report.starts_s, report.faults
    if leftovers > 1:  # the last cut may have left one
        faults.append(f"{leftovers} partial files are left")
    print(
        f"{count_noun(len(starts) + report.early, 'start', 'starts')}, {report.full} with a full "
        f"disk, {report.resumed} with a saved show, {report.early} cut while loading"
    )
    if starts:
        print(f"the sea was there after {mean(starts):.1f} s on average, at most {max(starts):.1f}")
    for fault in faults:
        say(fault)
    print(count_noun(len(faults), "fault", "faults") if faults else "sound")
    return 1 if faults else 0
