"""Look at this computer: its system, temperature and free disk."""

import platform
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread

from subsea.base.errors import printable

LOOK_S = 2.0  # between two looks
PLAUSIBLE_C = 1.0, 150.0  # sensors that are not connected read 0, or far too much
MOST_LETTERS = 100


def system_name(release: Path = Path("/etc/os-release")) -> str:
    """The name of the operating system, such as ``Debian GNU/Linux 13 (trixie), Linux 6.12``."""
    name = ""
    with suppress(OSError, UnicodeDecodeError):
        for line in release.read_text("utf-8").splitlines():
            key, _, value = line.partition("=")
            name = value.strip("\"'") if key == "PRETTY_NAME" else name
    kernel = f"{platform.system()} {platform.release()}"
    return printable(f"{name}, {kernel}" if name else kernel)[:MOST_LETTERS]


def temperature_c(system: Path = Path("/sys")) -> float | None:
    """The highest temperature of all sensors, °C; None: there are none that can be read."""
    found = [value for value in _sensors(system) if PLAUSIBLE_C[0] <= value <= PLAUSIBLE_C[1]]
    return max(found, default=None)


def _sensors(system: Path) -> Iterator[float]:
    folders = ("class/thermal", "thermal_zone*/temp"), ("class/hwmon", "hwmon*/temp*_input")
    for folder, pattern in folders:
        for file in (system / folder).glob(pattern):
            with suppress(OSError, ValueError):  # a sensor may be asleep
                yield int(file.read_text("ascii")) / 1000.0


def free_disk_gb(folder: Path) -> float | None:
    """Free space of the disk with a folder, or with the nearest one above it, 10⁹ bytes."""
    for place in (folder, *folder.parents):
        with suppress(OSError):
            return shutil.disk_usage(place).free / 1e9
    return None


class ComputerWatch:
    """Looks at sensors and disk in a thread, as some sensors take milliseconds to answer."""

    def __init__(self, folder: Path, sensor: Callable[[], float | None] = temperature_c) -> None:
        """`folder` is on the disk that counts."""
        self.temperature_c: float | None = None
        self.free_disk_gb: float | None = None
        self._folder, self._sensor, self._ends = folder, sensor, Event()
        self._thread = Thread(target=self._run, name="computer", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop looking."""
        self._ends.set()
        self._thread.join(2.0)

    def _run(self) -> None:
        while True:
            self.temperature_c = self._sensor()
            self.free_disk_gb = free_disk_gb(self._folder)
            if self._ends.wait(LOOK_S):
                return
