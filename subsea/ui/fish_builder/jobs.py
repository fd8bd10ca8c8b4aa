"""What makes a drawn fish swim: learning and recording, processes of their own; a first dive."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from subsea.fish.species import repertoire_file, species_names
from subsea.ui.fish_builder.processes import Run

SEA, SHOAL = "peaceful", "fish.1"  # whose place a new species takes in its first dive
TRIES = 300  # of a search for controllers, as many as the command takes
FEWEST, MOST = 20, 3000
USER_FAULT = 2  # exit code of a command that told in a line what can be mended
LINES = 5.2  # height of its pane, in heights of letters


class Making:
    """At most one command of the capture tool at a time, and dives beside it."""

    height = LINES

    def __init__(self, wake: Callable[[], object]) -> None:
        """Nothing runs; `wake` is called when something that runs has news."""
        self.told = ""  # how the last one ended
        self.tries = TRIES
        self._wake = wake
        self._run: tuple[str, str, Run] | None = None
        self._dives: list[subprocess.Popen[bytes]] = []

    @property
    def runs(self) -> bool:
        """Whether something is learned or recorded."""
        return self._run is not None

    @property
    def share(self) -> float:
        """How far it is, 0 to 1."""
        return self._run[2].share if self._run else 0.0

    @property
    def doing(self) -> str:
        """What it is at."""
        if self._run is None:
            return ""
        kind, _, run = self._run
        return run.doing or {"learn": "learning…", "record": "recording…"}[kind]

    def learn(self, path: Path) -> None:
        """Search for the controllers of a species file, and write what is better into it."""
        self._begin("learn", path.stem, [str(path), "--budget", str(self.tries)])

    def record(self, key: str) -> None:
        """Record a species' motion."""
        self._begin("record", key, [key, "--progress"])

    def stop(self) -> None:
        """Stop what runs; nothing half-written is left."""
        if self._run:
            self._run[2].stop()

    def ended(self) -> tuple[str, int] | None:
        """What was learned or recorded since this was last asked, with the exit code."""
        for dive in [one for one in self._dives if one.poll() is not None]:
            self._dives.remove(dive)
            if dive.returncode == USER_FAULT:
                self.told = "The dive did not open: the terminal says why."
        if self._run is None or (code := self._run[2].code) is None:
            return None
        kind, key, run = self._run
        self._run = None
        self.told = _told(kind, key, run, code)
        return kind, code

    def dive(self, key: str) -> None:
        """Open a dive in which the species swims."""
        words = ["dive", "--scenario", SEA, "--set", f"{SHOAL}.species={key}"]
        self._dives.append(
            subprocess.Popen(
                [sys.executable, "-m", "subsea", *words],
                stdin=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in the terminal is for the builder
            )
        )
        self.told = "A dive opens in a window of its own: look for your fish."

    def close(self) -> None:
        """Stop what is learned or recorded; a dive is left to whoever is in it."""
        if self._run:
            self._run[2].close()

    def _begin(self, kind: str, key: str, rest: list[str]) -> None:
        self.told = ""
        self._run = kind, key, Run(["capture", kind, *rest], self._wake)


def recorded(key: str) -> bool:
    """Whether a species has a repertoire."""
    return key in species_names() and repertoire_file(key).is_file()


def _told(kind: str, key: str, run: Run, code: int) -> str:
    """How a command ended, in a sentence."""
    if run.stopped:
        kept = {"learn": "the file is as it was", "record": "Record goes on where it stopped"}
        return f"Stopped; {kept[kind]}."
    if code == 0 and kind == "learn":
        return "Better controllers were found and are in the file now. Record takes them up."
    if code == 0:
        return f"{key} can swim: name it in a scenario, or dive with it now."
    if code == 1 and kind == "learn":
        return "Nothing better was found; the file is as it was. More tries may find something."
    return f"That failed: {run.last or f'exit code {code}'}"
