"""Learning and recording of an edited species as processes, a first dive with it, and the pane."""

import re
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO

from imgui_bundle import imgui

from subsea.fish.species import repertoire_file, species_file, species_names
from subsea.ui.gui import button, wrapped_text

PROGRESS = re.compile(r"(\d+)/(\d+)\D")
PATIENCE_S = 10.0  # until a process that should stop is killed


class CommandProcess:
    """A command whose output is read by threads."""

    def __init__(self, arguments: list[str], wake: Callable[[], object] = lambda: None) -> None:
        """Start ``python -m MODULE …``; `wake` is called, in a thread, on every news."""
        self.last = ""  # line
        self.doing, self.progress = "", 0.0  # the present stage, and its share done
        self.stopped = False  # on request
        self._wake = wake
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        assert self._process.stdout and self._process.stderr
        self._readers = [
            threading.Thread(target=self._read, args=(pipe,), daemon=True)
            for pipe in (self._process.stdout, self._process.stderr)
        ]
        for reader in self._readers:
            reader.start()

    @property
    def code(self) -> int | None:
        """The exit code, None while it runs."""
        if any(reader.is_alive() for reader in self._readers):
            return None
        return self._process.poll()

    def stop(self) -> None:
        """Ask it to stop; not by SIGINT, which it ignores if the builder runs in a background."""
        self.stopped = True
        if self._process.poll() is None:
            self._process.terminate()

    def close(self) -> None:
        """Stop it, and wait: it may be writing."""
        self.stop()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for reader in self._readers:
            reader.join()

    def _read(self, pipe: IO[bytes]) -> None:
        """Read lines and the updates of a progress bar."""
        with pipe:
            part = b""
            while piece := pipe.read1(4096):  # type: ignore[attr-defined]
                *whole, part = re.split(rb"[\r\n]", part + piece)
                for line in whole:
                    self.parse(line.decode("utf-8", "replace").strip())
            self.parse(part.decode("utf-8", "replace").strip())
        self._wake()

    def parse(self, line: str) -> None:
        """Take progress from a line of a progress bar, else keep the line if it is not empty."""
        found = PROGRESS.search(line)
        if found and "%|" in line:
            done, total = map(int, found.groups())
            best = re.search(r"best [\d.]+", line)
            self.doing = line.partition(":  ")[0].partition("%|")[0].rstrip("0123456789 :")
            self.doing += f" · {best[0]}" if best else ""
            self.progress = done / max(total, 1)
        else:
            self.last = line or self.last
        self._wake()


SEA, SHOAL = "peaceful", "fish.1"  # the shoal that a new species replaces in its first dive
TRIES = 300  # of a search for controllers, the default of the command
FEWEST, MOST = 20, 3000
USER_FAULT = 2  # exit code after a one-line error of the user
JOBS_HELP = (
    "Fit body sets rings, masses and gaits by the outline. Learn finds better muscle movements. "
    "Record takes down its motion, for scenarios."
)
DOING = {"fit": "fitting…", "learn": "learning…", "record": "recording…"}


class CaptureJobs:
    """At most one command of the capture tool at a time, and dives beside it."""

    def __init__(self, wake: Callable[[], object]) -> None:
        """Start nothing; `wake` is called when a process has news."""
        self.message = ""  # how the last job ended
        self.tries = TRIES
        self._wake = wake
        self._process: tuple[str, str, CommandProcess] | None = None
        self._dives: list[subprocess.Popen[bytes]] = []

    @property
    def running(self) -> bool:
        """True if a job runs."""
        return self._process is not None

    @property
    def progress(self) -> float:
        """The share that is done, 0 to 1."""
        return self._process[2].progress if self._process else 0.0

    @property
    def doing(self) -> str:
        """The stage of the job."""
        if self._process is None:
            return ""
        kind, _, process = self._process
        return process.doing or DOING[kind]

    def fit(self, path: Path) -> None:
        """Fit scaffold, gaits and turns of a species file to its outline, and write them."""
        self._begin("fit", path.stem, [str(path), "--progress"])

    def learn(self, path: Path) -> None:
        """Search for better controllers of a species file, and write them into it."""
        self._begin("learn", path.stem, [str(path), "--budget", str(self.tries)])

    def record(self, key: str) -> None:
        """Record a species' motion."""
        self._begin("record", key, [key, "--progress"])

    def stop(self) -> None:
        """Stop the job; files stay whole."""
        if self._process:
            self._process[2].stop()

    def ended(self) -> tuple[str, int] | None:
        """Return kind and exit code of a job that has ended since the last call."""
        for dive in [dive for dive in self._dives if dive.poll() is not None]:
            self._dives.remove(dive)
            if dive.returncode == USER_FAULT:
                self.message = "The dive did not open: the terminal says why."
        if self._process is None or (code := self._process[2].code) is None:
            return None
        kind, key, process = self._process
        self._process = None
        self.message = _describe_end(kind, key, process, code)
        return kind, code

    def dive(self, key: str) -> None:
        """Open a dive in which the species swims, and follow one of its fishes."""
        words = ["dive", "--scenario", SEA, "--set", f"{SHOAL}.species={key}", "--follow", key]
        self._dives.append(
            subprocess.Popen(
                [sys.executable, "-P", "-m", "subsea", *words],
                stdin=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C in the terminal is for the builder
            )
        )
        self.message = "A dive opens in a window of its own, and follows your fish."

    def close(self) -> None:
        """Stop the job; dives go on."""
        if self._process:
            self._process[2].close()

    def _begin(self, kind: str, key: str, rest: list[str]) -> None:
        self.message = ""
        self._process = kind, key, CommandProcess(["capture", kind, *rest], self._wake)


def recorded(key: str) -> bool:
    """True if a species has a repertoire."""
    return key in species_names() and repertoire_file(key).is_file()


def _describe_end(kind: str, key: str, process: CommandProcess, code: int) -> str:
    """Describe in a sentence how a command ended."""
    if process.stopped:
        kept = {
            "fit": "the file is as it was, and Fit body goes on where it stopped",
            "learn": "the file is as it was",
            "record": "Record goes on where it stopped",
        }
        return f"Stopped; {kept[kind]}."
    if code == 0 and kind == "fit":
        return "Scaffold, gaits and turns fit the outline now. Record takes them up."
    if code == 1 and kind == "fit":
        return "No gait was found for this outline; the file is as it was."
    if code == 0 and kind == "learn":
        return "Better controllers were found and are in the file now. Record takes them up."
    if code == 0 and "warning: " in process.last:
        return f"{key} is recorded, with a warning. {process.last.partition('warning: ')[2]}"
    if code == 0:
        return f"{key} can swim: name it in a scenario, or dive with it now."
    if code == 1 and kind == "learn":
        return "Nothing better was found; the file is as it was. More tries may find something."
    return f"That failed: {process.last or f'exit code {code}'}"


def draw_jobs(
    jobs: CaptureJobs,
    key: str,
    can_dive: bool,
    starters: dict[str, Callable[[], None] | None],
    text_height: float,
) -> None:
    """Draw the buttons `starters` by name (None: disabled), the progress and the results.

    `key` names the species for a dive.
    """
    for name, start in starters.items():
        if button(name, not jobs.running and start is not None) and start is not None:
            start()
        imgui.same_line()
    if jobs.running:
        if imgui.button("Stop"):
            jobs.stop()
        imgui.same_line()
        imgui.progress_bar(jobs.progress, (-1.0, 0.0), jobs.doing)
    else:
        if button("Dive with it", can_dive):
            jobs.dive(key)
        imgui.same_line()
        imgui.set_next_item_width(-6.0 * text_height)
        changed, tries = imgui.drag_int("tries to learn", jobs.tries, 2.0, FEWEST, MOST)
        jobs.tries = tries if changed else jobs.tries
    wrapped_text(jobs.message or JOBS_HELP)


def is_known(path: Path | None) -> bool:
    """True if commands find this file by its name, not another species."""
    return (
        path is not None
        and path.stem in species_names()
        and species_file(path.stem).resolve() == path.resolve()
    )
