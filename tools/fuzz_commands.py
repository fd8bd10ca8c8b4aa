"""Start every command with odd values, files, streams and surroundings, and check how it ends.

    python tools/fuzz_commands.py [KIND…] [--rounds N] [--seed S]

A command may succeed, or end with exit code 1, 2 or 130 and one line. Anything else is a finding: a
traceback, another code, a line that is not a message, more than SECONDS. Commands that open windows
get no display. Exit code 1 if there is any finding.
"""

import argparse
import os
import random
import shlex
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from capture.cli.main import parsers as capture_parsers
from subsea.cli.main import parsers
from subsea.study.simulate import simulate

SECONDS = 60
CODES = 0, 1, 2, 130
ODD_VALUES = [
    *("--", "-", "", " ", "nan", "-1", "1e400", "9" * 5000, "²", "a" * 255, "a" * 300, "é"),
    *("\udcff\udcfe", "x\ny", "/dev/null", "a=b", "a.b=1", "0x10", "%s", "{}", "~"),
    *("a." * 20 + "a=1", "a." * 2000 + "a=1", "title=\udcff", "[", "1,2", "1x1", "peaceful"),
]
ENVIRONMENT = [
    *("NUMBA_NUM_THREADS=0", "NUMBA_NUM_THREADS=junk", "NUMBA_OPT=junk", "NUMBA_DEBUG=junk"),
    *("NUMBA_COLOR_SCHEME=junk", "NUMBA_CACHE_DIR=/proc/x", "PYOPENGL_PLATFORM=junk"),
    *("LIBGL_DRIVERS_PATH=/nowhere", "GALLIUM_DRIVER=junk", "MESA_GL_VERSION_OVERRIDE=1.0"),
    *("HOME=/proc/x", "XDG_DATA_HOME=/dev/null", "XDG_CONFIG_HOME=/dev/zero", "TMPDIR=/nowhere"),
    *("XDG_CACHE_HOME=/proc/x", "LANG=junk", "TERM=junk", "COLUMNS=0", "COLUMNS=junk", "PATH="),
]
LOCALES = [
    {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    {"LC_ALL": "POSIX"},
    {"PYTHONIOENCODING": "latin-1"},
    {"PYTHONIOENCODING": "ascii:strict"},
]
STREAMS = [
    *(">/dev/full", "2>/dev/full", ">/dev/full 2>/dev/full", ">&-", "2>&-", ">&- 2>&- <&-"),
    *("| head -1", "| true", "2>&1 | true", "</dev/zero"),
]
SPECIAL_FILES = "pipe", "loop", "folder", "socket", "/dev/zero", "/dev/null", "/dev/kmsg", "loop/x"
SUFFIXES = "", ".h5", ".toml", ".json", ".obj", ".png", ".mp4", ".csv", ".key"

# Arguments with which each command does little; folders of results are new.
COMMANDS = {
    "subsea": {
        "simulate": ["--ticks=1", "--fish=1", "--out=out.h5"],
        "film": ["out.png", "--fish=1", "--size=64x64", "--seconds=0.05", "--quality=low"],
        "study": ["run.h5"],
        "sweep": ["peaceful", "--seeds=1", "--ticks=1", "--fish=1", "--jobs=1", "--out=sweep"],
        "benchmark": ["--frames=1", "--fish=1", "--size=64x64"],
        "soak": ["--minutes=0.01", "--fish=1", "--no-draw"],
        "list": ["scenarios"],
        "theatre": ["dome"],
        "keys": ["keys", "left"],
        "settings": [],
        "doctor": [],
        "dive": ["--seconds=0.1"],
        "build": [],
        "skin": ["fish.jpg", "--auto", "--species=clownfish", "--out=out.png"],
    },
    "capture": {
        "record": ["clownfish", "--out=record"],
        "inspect": ["nobody.h5"],
        "plot": ["clownfish", "--out=plots"],
        "learn": ["clownfish", "--budget=1", "--dry-run"],
        "export": ["clownfish", "--to=gltf", "--out=export"],
        "mesh": ["clownfish", "mesh.obj", "--out=mesh"],
    },
}
SLOW = {"record", "plot", "learn", "export", "sweep"}  # started with faulty arguments only


class Case(NamedTuple):
    """One start of a command."""

    words: list[str]  # of the program, without Python
    redirection: str = ""
    environment: Mapping[str, str] = MappingProxyType({})
    deleted: bool = False  # the working directory


def options_of(program: str, command: str) -> list[str]:
    """The options of a command that take a value."""
    commands = (parsers() if program == "subsea" else capture_parsers())[1]
    actions = commands.choices[command]._actions
    return [one.option_strings[-1] for one in actions if one.option_strings and one.nargs != 0]


def chosen_command(rng: random.Random, quick: bool = False) -> list[str]:
    """Words of a random command that does little."""
    program = rng.choice([*COMMANDS])
    names = [name for name in COMMANDS[program] if not (quick and name in SLOW)]
    name = rng.choice(names or [*COMMANDS["subsea"]])
    return [program, name, *COMMANDS[program][name]]


def odd_value(rng: random.Random, values: list[str] | None = None) -> Case:
    """A command with an odd value of an option or in place of an argument."""
    words = chosen_command(rng)
    value = rng.choice(values or ODD_VALUES)
    options = options_of(*words[:2])
    places = [k for k, word in enumerate(words) if k > 1 and not word.startswith("--")]
    if places and (not options or rng.random() < 0.4):
        words[rng.choice(places)] = value
    elif options:
        option = rng.choice(options)
        words = [word for word in words if not word.startswith(f"{option}=")]
        words.append(f"{option}={value}")
    return Case(words)


def special_file(rng: random.Random) -> Case:
    """A command with a pipe, device, folder or loop in place of a file."""
    kind, suffix = rng.choice(SPECIAL_FILES), rng.choice(SUFFIXES)
    return odd_value(rng, [kind, f"./{kind}{suffix}"] if kind[0] != "/" else [kind])


def odd_stream(rng: random.Random) -> Case:
    """A command whose output is closed, full or cut off."""
    return Case(chosen_command(rng, quick=True), rng.choice(STREAMS))


def odd_locale(rng: random.Random) -> Case:
    """A command in an old locale, with names that are not ASCII."""
    case = odd_value(rng, ["é", "\udcff", "é.toml", "\udcff.h5", "title=é", "\udcff.png", "out/é"])
    words = case.words if rng.random() < 0.6 else chosen_command(rng, quick=True)
    return Case(words, environment=rng.choice(LOCALES))


def odd_environment(rng: random.Random) -> Case:
    """A command with junk in variables."""
    chosen = rng.sample(ENVIRONMENT, rng.choice([1, 1, 2]))
    environment = {name: value for name, _, value in (one.partition("=") for one in chosen)}
    return Case(chosen_command(rng, quick=True), environment=environment)


def odd_folder(rng: random.Random) -> Case:
    """A command in a folder that was deleted."""
    return Case(chosen_command(rng, quick=True), deleted=True)


KINDS: dict[str, Callable[[random.Random], Case]] = {
    "value": odd_value,
    "file": special_file,
    "stream": odd_stream,
    "locale": odd_locale,
    "environment": odd_environment,
    "folder": odd_folder,
}


def make_folder(folder: Path, record: Path) -> None:
    """Fill a working directory with special files and a sound record."""
    (folder / "folder").mkdir()
    (folder / "run.h5").symlink_to(record)
    for suffix in SUFFIXES:
        os.mkfifo(folder / f"pipe{suffix}")
        (folder / f"loop{suffix}").symlink_to(f"loop{suffix}")
    os.mknod(folder / "socket", 0o140600)


def finding(case: Case, folder: Path) -> str | None:
    """The finding about how a command ends; None if correct."""
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    environment |= {"PYTHONPATH": str(Path(__file__).parents[1]), "XDG_DATA_HOME": f"{folder}/data"}
    environment |= case.environment
    start = shlex.join([sys.executable, "-m", *case.words])
    before = f"cd {shlex.quote(str(folder))}; "
    if case.deleted:
        before += "mkdir gone; cd gone; rmdir ../gone; "
    # The code is that of the command, not of the last program in a pipe.
    shell = f"{before}{start} {case.redirection or '>/dev/null'}; exit ${{PIPESTATUS[0]}}"
    with subprocess.Popen(
        [b"/bin/bash", b"-c", os.fsencode(shell)], env=environment, stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True,
    ) as command:  # fmt: skip
        try:
            lines = command.communicate(timeout=SECONDS)[1].decode("utf-8", "replace").splitlines()
        except subprocess.TimeoutExpired:
            return f"not done after {SECONDS} s"
        finally:
            with suppress(ProcessLookupError):
                os.killpg(command.pid, signal.SIGKILL)
    if any("Traceback" in line or "Exception ignored" in line for line in lines):
        return lines[-1]
    if command.returncode not in CODES:
        return f"exit code {command.returncode}: {' '.join(lines[-2:])}"
    if command.returncode == 2 and not lines and "2>" not in case.redirection:
        return "exit code 2 without a line"
    bars = [line for line in lines if "%|" in line or not line.strip("\x1b[A ")]  # of progress
    if other := [
        one for one in lines if not one.startswith(("subsea", "libGL")) and one not in bars
    ]:
        return f"not a message: {' | '.join(other)[:300]}"
    return None


def fuzz(name: str, rounds: int, seed: int, record: Path) -> int:
    """Start `rounds` commands of a kind; print and count the findings."""
    findings = 0
    for number in range(rounds):
        rng = random.Random(f"{name} {seed} {number}")
        case = KINDS[name](rng)
        with tempfile.TemporaryDirectory() as folder:
            make_folder(Path(folder), record)
            what = finding(case, Path(folder))
        if what:
            findings += 1
            short = ascii([word[:80] for word in case.words])
            rest = f"{case.redirection} {case.environment or ''}{' deleted' * case.deleted}"
            print(f"{name}, round {number}: {what!a}\n    {short} {rest}", flush=True)
    print(f"{name}: {rounds} commands, {findings} findings", flush=True)
    return findings


def main() -> int:
    """Run from the command line; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("kinds", metavar="KIND", nargs="*", help=f"of {', '.join(KINDS)} (all)")
    parser.add_argument("--rounds", type=int, default=50, help="commands of each kind (50)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    if wrong := set(options.kinds) - KINDS.keys():
        parser.error(f"unknown kind {min(wrong)!r}; there are: {', '.join(KINDS)}")
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "run.h5"
        simulate(2, record, "peaceful", 2, 1)
        given = options.rounds, options.seed, record
        findings = [fuzz(name, *given) for name in options.kinds or KINDS]
    return 1 if any(findings) else 0


if __name__ == "__main__":
    sys.exit(main())
