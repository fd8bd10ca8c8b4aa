"""Start every command with odd values, files, streams and surroundings, and check how it ends.

    python tools/fuzz_commands.py [KIND…] [--rounds N] [--seed S]

A command may succeed, or end with exit code 1, 2, 75 or 130 and one line. Anything else is a
finding: a traceback, another code, a line that is not a message, more than SECONDS. A command that
shows its progress is ended after PATIENCE_S and counted apart. Commands that open windows get no
display; those of the kinds `session` and `signal` get a virtual one (Xvfb), the latter also Ctrl-C
or SIGTERM within LASTS_S, sometimes twice. Prints how often each exit code came; exit code 1 if
there is any finding. Needs Linux.
"""

import argparse
import atexit
import os
import random
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import msgspec

from capture.cli.main import parsers as capture_parsers
from subsea.cli.main import parsers
from subsea.lab.simulate import simulate
from subsea.scenario.load import load_scenario, scenario_names
from subsea.scenario.schema import Scenario
from tools import fuzzing
from tools.fuzzing import CODES
from tools.monkey import virtual_display

ROOT = Path(__file__).parents[1]
SECONDS = 150
PATIENCE_S = 25  # with a command that shows its progress
LASTS_S = 10  # about the time that the commands of LASTING take
ODD_VALUES = [
    *("--", "-", "", " ", "nan", "-1", "1e400", "9" * 5000, "²", "a" * 255, "a" * 300, "é"),
    *("\udcff\udcfe", "x\ny", "/dev/null", "a=b", "a.b=1", "0x10", "%s", "{}", "~"),
    *("a." * 20 + "a=1", "a." * 2000 + "a=1", "title=\udcff", "[", "1,2", "1x1", "peaceful"),
]
VARIABLES = [
    *("NUMBA_NUM_THREADS", "NUMBA_COLOR_SCHEME", "NUMBA_THREADING_LAYER"),
    *("PYOPENGL_PLATFORM", "LIBGL_DRIVERS_PATH", "GALLIUM_DRIVER", "MESA_GL_VERSION_OVERRIDE"),
    *("MESA_SHADER_CACHE_DIR", "EGL_PLATFORM", "DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR"),
    *("HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "TMPDIR", "PATH", "TZ"),
    *("LANG", "TERM", "COLUMNS", "LINES", "TQDM_MININTERVAL", "MPLBACKEND", "MPLCONFIGDIR"),
    *("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "HDF5_USE_FILE_LOCKING", "HDF5_PLUGIN_PATH"),
]
JUNK = ["", "junk", "0", "-1", "1.0", "9" * 30, "/nowhere", "/proc/x", "/dev/null", "/dev/zero"]
JUNK += ["é", "\udcff", "a" * 300]
# Other values of these let every start compile, which takes minutes, or print.
COMPILER = [{"NUMBA_CACHE_DIR": "/proc/x"}, {"NUMBA_OPT": "junk"}, {"NUMBA_CPU_FEATURES": "junk"}]
COMPILER += [{"NUMBA_DEBUG": "junk"}]
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
SPECIAL_FILES = ["pipe", "loop", "folder", "socket", "loop/x", "/dev/zero", "/dev/null"]
SPECIAL_FILES += ["/dev/kmsg", "/proc/kmsg", "/proc/self/mem"]
SUFFIXES = "", ".h5", ".toml", ".json", ".obj", ".png", ".mp4", ".csv", ".key"

# Arguments with which each command does little; folders of results are new.
COMMANDS = {
    "subsea": {
        "simulate": ["--ticks=1", "--fish=1", "--out=out.h5"],
        "film": ["out.png", "--fish=1", "--size=64x64", "--seconds=0.05", "--quality=low"],
        "export": ["peaceful", "--to=usd", "--fish=1", "--with=none", "--seconds=0.05"]
        + ["--detail=3", "--out=scene.usdc"],
        "study": ["run.h5"],
        "sweep": ["peaceful", "--seeds=1", "--ticks=1", "--fish=1", "--jobs=1", "--out=sweep"],
        "benchmark": ["--frames=1", "--fish=1", "--size=64x64"],
        "soak": ["--minutes=0.01", "--fish=1", "--no-draw"],
        "list": ["scenarios"],
        "theatre": ["dome"],
        "show": ["show.toml"],
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
        "validate": ["clownfish"],
        "flat": ["--quick", "--only=body"],
    },
}
# Commands that work for a while, to be interrupted.
LASTING = [
    "subsea film out.mp4 --seconds 0.5 --size 96x64",
    "subsea film out --eyes 0 --seconds 0.5 --size 64x64",
    "subsea simulate --seconds 4 --out out.h5",
    "subsea study run.h5 --out out --json out.json",
    "capture inspect fusilier",
    "capture export fusilier --to gltf --out out",
    "subsea export peaceful --to usd --out out.usdc --seconds 0.5 --with sand --fish 8",
    "subsea dive --seconds 3 --quality low --size 96x64",
    "subsea benchmark --frames 20 --size 96x64 --json out.json",
    "subsea doctor",
    "subsea list scenarios",
    "subsea settings --write --force",
]
OPENING = [text for text in LASTING if "dive" in text or "doctor" in text]  # windows
# Commands that start processes of Python.
WITH_CHILDREN = [
    "subsea sweep peaceful --seeds 1:2 --ticks 1 --fish 1 --jobs 2 --csv --out sweep",
    "subsea doctor",
    "capture record clownfish --jobs 2 --out record",
]
SWITCHES = [
    *({"PYTHONOPTIMIZE": "1"}, {"PYTHONOPTIMIZE": "2"}, {"PYTHONSAFEPATH": "1"}),
    *({"PYTHONDONTWRITEBYTECODE": "1"}, {"PYTHONHASHSEED": "0"}, {"PYTHONUTF8": "1"}),
    *({"PYTHONUNBUFFERED": "1"}, {"PYTHONMALLOC": "debug"}, {"NUMBA_DISABLE_JIT": "1"}),
]
NO_LOCKS = """
#include <errno.h>
int flock(int file, int what) { errno = ENOLCK; return -1; }
int lockf(int file, int what, long size) { errno = ENOLCK; return -1; }
"""
TRAP = "executed"
SLOW = {"record", "plot", "learn", "export", "sweep", "flat"}  # started with odd arguments only
WITH_SETTINGS = "simulate", "simulate", "film", "benchmark", "soak"  # commands with --set
OFTEN = {"simulate", "film", "study", "benchmark"}  # started three times as often
UP = "\x1b[A "  # written between bars of progress
# Lines of this program, and of Mesa about a faulty variable or its value.
MESSAGE = re.compile(
    "subsea|libGL|error: invalid value for MESA_|Failed to create .* for shader cache"
)
LETTERS = [(0x20, 0x7E), (0x01, 0x1F), (0xA0, 0x24F), (0x600, 0x6FF), (0x1F300, 0x1FAFF)]
LETTERS += [(0xDC80, 0xDCFF)]  # bytes that are not UTF-8
UNITS = "", "", "", " ", "cm", "s", "%", "e", "x", "j", "°"


class Case(NamedTuple):
    """One start of a command."""

    words: list[str]  # of the program, without Python
    redirection: str = ""
    environment: Mapping[str, str] = MappingProxyType({})
    deleted: bool = False  # the working directory
    signals: tuple[tuple[float, signal.Signals], ...] = ()  # each after a pause, s
    mask: str = ""  # umask
    trapped: bool = False  # modules in the working directory that nothing may execute


class End(NamedTuple):
    """The end of a command."""

    code: int | None  # None: it did not
    lines: list[str]  # of standard error


@cache
def options_of(program: str, command: str) -> list[argparse.Action]:
    """List the options of a command."""
    commands = (parsers() if program == "subsea" else capture_parsers())[1]
    return [action for action in commands.choices[command]._actions if action.option_strings]


@cache
def scenario_keys() -> list[str]:
    """All keys of scenario files, such as ``fish.0.number``."""
    return [key.lstrip(".") for key in _keys(msgspec.inspect.type_info(Scenario), "")]


def _keys(kind: Any, key: str) -> Iterator[str]:
    yield key
    for field in getattr(kind, "fields", ()):
        yield from _keys(field.type, f"{key}.{field.encode_name}")
    for one in getattr(kind, "types", ()):  # of a union
        yield from _keys(one, key)
    for number, one in enumerate(getattr(kind, "item_types", ())):  # of a tuple
        yield from _keys(one, f"{key}.{number}")
    if hasattr(kind, "item_type"):
        yield from _keys(kind.item_type, f"{key}.0")


@cache
def scenario_numbers(name: str) -> list[tuple[str, float]]:
    """The numbers of a scenario, with their keys."""
    values = msgspec.to_builtins(load_scenario(name)[0])
    return [(key.lstrip("."), number) for key, number in _numbers(values, "")]


def _numbers(value: Any, key: str) -> Iterator[tuple[str, float]]:
    if isinstance(value, (int, float)):
        yield key, value
    for name, one in value.items() if isinstance(value, dict) else ():
        yield from _numbers(one, f"{key}.{name}")
    for number, one in enumerate(value) if isinstance(value, (list, tuple)) else ():
        yield from _numbers(one, f"{key}.{number}")


def odd_number(rng: random.Random) -> str:
    """A small, large or tiny number, sometimes with a unit."""
    number = rng.choice(
        [rng.uniform(-10, 10), rng.randint(-3, 100), 10.0 ** rng.randint(-320, 308),
         rng.uniform(-1, 1) * 10 ** rng.uniform(-3, 6), rng.getrandbits(rng.choice([31, 64, 200]))]
    )  # fmt: skip
    return rng.choice(["{}", "{}", "{:+}", "{:_}", "{:.3g}"]).format(number) + rng.choice(UNITS)


def odd_list(rng: random.Random) -> str:
    """A list of any length."""
    items = [odd_number(rng) for _ in range(rng.randrange(7))]
    return rng.choice(["{}", "[{}]", "{}]"]).format(rng.choice(",x; =").join(items))


def odd_text(rng: random.Random) -> str:
    """Random letters, but no path outside the working directory."""
    ranges = rng.choices(LETTERS, (8, 1, 3, 1, 1, 1), k=rng.randint(1, 30))
    return "".join(chr(rng.randint(*one)) for one in ranges).lstrip("/")


def odd_setting(rng: random.Random) -> str:
    """A value for a key of a scenario."""
    parts = rng.choice(scenario_keys()).split(".")
    if rng.random() < 0.1:
        parts[rng.randrange(len(parts))] = rng.choice(["1", "99", "-1", "x", "", "0.0"])
    values = ["true", '"peaceful"', "{}", "{ a = 1 }", "[[1]]", "inf", "nan", "2020-01-01", ""]
    value = rng.choice([odd_number, odd_list, odd_text, lambda rng: rng.choice(values)])(rng)
    return f"{'.'.join(parts)}={value}"


def changed_number(rng: random.Random, scenario: str) -> str:
    """Another value for a number of a scenario."""
    key, number = rng.choice(scenario_numbers(scenario))
    factor = rng.choice([0, -1, 0.1, rng.random(), 1.0 + rng.random(), 3, 30])
    return f"{key}={int(number * factor) if isinstance(number, int) else number * factor}"


def any_value(rng: random.Random) -> str:
    """A value of one of these kinds."""
    kinds = [lambda rng: rng.choice(ODD_VALUES), odd_number, odd_number, odd_list, odd_text]
    return rng.choice(kinds)(rng)


def chosen_command(rng: random.Random, quick: bool = False) -> list[str]:
    """Words of a random command that does little."""
    found = [
        [program, name, *words]
        for program, commands in COMMANDS.items()
        for name, words in commands.items()
        if not (quick and name in SLOW)
        for _ in range(3 if name in OFTEN else 1)
    ]
    return rng.choice(found)


def odd_value(rng: random.Random, value: Callable[[random.Random], str] = any_value) -> Case:
    """A command with odd values of one to three options or in place of an argument."""
    words = chosen_command(rng)
    options = options_of(*words[:2])
    places = [k for k, word in enumerate(words) if k > 1 and not word.startswith("--")]
    if places and rng.random() < 0.4:
        words[rng.choice(places)] = value(rng)
        return Case(words)
    for action in rng.sample(options, min(len(options), rng.choice([1, 1, 2, 3]))):
        option = action.option_strings[-1]
        words = [word for word in words if not word.startswith(f"{option}=")]
        if action.nargs == 0 and rng.random() < 0.9:
            words.append(option)
        elif action.choices and rng.random() < 0.5:
            words.append(f"{option}={rng.choice([*action.choices])}")
        else:
            setting = option == "--set" and value is any_value
            words.append(f"{option}={(odd_setting if setting else value)(rng)}")
    return Case(words)


def odd_scenario(rng: random.Random) -> Case:
    """A scenario with odd values of keys."""
    name, scenario = rng.choice(WITH_SETTINGS), rng.choice(scenario_names())
    words = ["subsea", name, *COMMANDS["subsea"][name], f"--scenario={scenario}"]
    for _ in range(rng.choice([1, 1, 2, 3])):
        setting = changed_number(rng, scenario) if rng.random() < 0.7 else odd_setting(rng)
        words.append(f"--set={setting}")
    return Case(words)


def special_file(rng: random.Random) -> Case:
    """A command with a pipe, device, folder or loop in place of a file."""
    kind, suffix = rng.choice(SPECIAL_FILES), rng.choice(SUFFIXES)
    names = [kind, f"./{kind}{suffix}"] if kind[0] != "/" else [kind]
    return odd_value(rng, lambda rng: rng.choice(names))


def odd_stream(rng: random.Random) -> Case:
    """A command whose output is closed, full or cut off."""
    return Case(chosen_command(rng, quick=True), rng.choice(STREAMS))


def odd_locale(rng: random.Random) -> Case:
    """A command in an old locale, with names that are not ASCII."""
    names = ["é", "\udcff", "é.toml", "\udcff.h5", "title=é", "\udcff.png", "out/é"]
    case = odd_value(rng, lambda rng: rng.choice(names))
    words = case.words if rng.random() < 0.6 else chosen_command(rng, quick=True)
    return Case(words, environment=rng.choice(LOCALES))


def odd_environment(rng: random.Random) -> Case:
    """A command with junk in variables."""
    names = rng.sample(VARIABLES, rng.choice([1, 1, 2]))
    environment = {name: rng.choice(JUNK) for name in names}
    if rng.random() < 0.1:
        environment |= rng.choice(COMPILER)
    return Case(chosen_command(rng, quick=True), environment=environment)


def odd_session(rng: random.Random) -> Case:
    """A command that opens windows, in a desktop session of any type, or in none."""
    environment = {
        "XDG_SESSION_TYPE": rng.choice(["x11", "wayland", "tty", "junk"]),
        "WAYLAND_DISPLAY": rng.choice(["", "wayland-0", "/nowhere"]),
        "DISPLAY": rng.choice(["", ":4711", "junk", display()]),
    }
    return Case(rng.choice(OPENING).split(), environment=environment)


def odd_folder(rng: random.Random) -> Case:
    """A command in a folder that was deleted."""
    return Case(odd_value(rng).words, deleted=True)


def odd_python(rng: random.Random) -> Case:
    """A command under Python's own switches, or without numba's compiler."""
    return Case(chosen_command(rng, quick=True), environment=rng.choice(SWITCHES))


def without_locks(rng: random.Random) -> Case:
    """A command on a file system without locks."""
    environment = {"LD_PRELOAD": no_locks(), "HDF5_USE_FILE_LOCKING": rng.choice(["TRUE", "1", ""])}
    return Case(chosen_command(rng, quick=True), environment=environment)


def odd_umask(rng: random.Random) -> Case:
    """A command that shares all its files, or with a group, or not even with itself."""
    return Case(chosen_command(rng, quick=True), mask=rng.choice(["000", "002", "077", "277"]))


def trapped(rng: random.Random) -> Case:
    """A command in a folder full of modules with the names of others."""
    return Case(rng.choice(WITH_CHILDREN).split(), trapped=True)


@cache
def no_locks() -> str:
    """Compile a library that refuses all locks; its path. Needs a C compiler."""
    library = Path(tempfile.gettempdir()) / f"no-locks-{os.getpid()}.so"
    atexit.register(library.unlink)
    compiler = ["cc", "-shared", "-fPIC", "-x", "c", "-", "-o", str(library)]
    subprocess.run(compiler, input=NO_LOCKS, text=True, check=True)
    return str(library)


def interrupted(rng: random.Random) -> Case:
    """A command that is interrupted."""
    pauses = [rng.uniform(0.0, LASTS_S), rng.choice((0.0, 0.05, 0.5))][: rng.choice((1, 1, 2))]
    kinds = signal.SIGINT, signal.SIGTERM
    return Case(
        rng.choice(LASTING).split(),
        environment={"DISPLAY": display()},
        signals=tuple((pause, rng.choice(kinds)) for pause in pauses),
    )


@cache
def display() -> str:
    """Start a virtual display for the rest of this process."""
    shown = virtual_display()
    atexit.register(shown.__exit__, None, None, None)
    return shown.__enter__()


KINDS: dict[str, Callable[[random.Random], Case]] = {
    "value": odd_value,
    "scenario": odd_scenario,
    "file": special_file,
    "stream": odd_stream,
    "locale": odd_locale,
    "environment": odd_environment,
    "session": odd_session,
    "folder": odd_folder,
    "signal": interrupted,
    "python": odd_python,
    "locks": without_locks,
    "umask": odd_umask,
    "traps": trapped,
}


def set_traps(folder: Path) -> None:
    """Fill a working directory with modules that leave a file when they are executed."""
    code = f"open({str(folder / TRAP)!r}, 'a').write(__name__)\n"
    for name in ("socket", "tempfile", "re", "json", "numpy", "sitecustomize", "msgspec"):
        (folder / f"{name}.py").write_text(code)
    for name in ("subsea", "capture"):
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text(code)


def make_folder(folder: Path, record: Path) -> None:
    """Fill a working directory with special files and a sound record."""
    (folder / "folder").mkdir()
    (folder / "run.h5").symlink_to(record)
    for suffix in SUFFIXES:
        os.mkfifo(folder / f"pipe{suffix}")
        (folder / f"loop{suffix}").symlink_to(f"loop{suffix}")
    os.mknod(folder / "socket", 0o140600)


def end_of(case: Case, folder: Path) -> End:
    """Run a command and wait for its end."""
    errors = folder / "errors"
    leave = "mkdir gone; cd gone; rmdir ../gone; " if case.deleted else ""
    start = shlex.join([sys.executable, "-m", *case.words])
    if case.trapped:  # as users type it: Python itself looks into the folder for `-m`
        set_traps(folder)
        program = "subsea" if case.words[0] == "subsea" else "subsea-capture"
        start = shlex.join([str(Path(sys.executable).with_name(program)), *case.words[1:]])
    if case.mask:
        leave += f"umask {case.mask}; "
    if case.signals:  # are for Python, not for a shell
        start = f"exec {start}"
    # The code is that of the command, not of the last program in a pipe.
    shell = f"{leave}{start} {case.redirection}; exit ${{PIPESTATUS[0]}}"
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    environment |= {f"XDG_{name}_HOME": f"{folder}/{name}" for name in ("DATA", "CONFIG")}
    environment |= {"PYTHONPATH": str(ROOT)} | dict(case.environment)
    with errors.open("wb") as file:
        process = subprocess.Popen(
            [b"/bin/bash", b"-c", os.fsencode(shell)], cwd=folder, env=environment,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=file,
            start_new_session=True,
        )  # fmt: skip
    for pause, number in case.signals:
        _wait_for_handlers(process)
        time.sleep(pause)
        process.send_signal(number)
    code = _code_within(process, PATIENCE_S)
    if code is None and case.words[1] not in SLOW and not _bars(_lines(errors)):
        code = _code_within(process, SECONDS - PATIENCE_S)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    executed = [f"executed {folder / TRAP}"] if (folder / TRAP).exists() else []
    return End(code, _lines(errors) + executed)


def _wait_for_handlers(process: "subprocess.Popen[bytes]") -> None:
    """Wait for the first line of the program; before, a signal ends the interpreter."""
    while process.poll() is None:
        status = Path(f"/proc/{process.pid}/status").read_text()
        caught = int(status.partition("SigCgt:")[2].split()[0], 16)
        if caught & 1 << (signal.SIGTERM - 1) and not status.startswith("Name:\tbash"):
            return
        time.sleep(0.001)


def _code_within(process: "subprocess.Popen[bytes]", seconds: float) -> int | None:
    with suppress(subprocess.TimeoutExpired):
        return process.wait(seconds)
    return None


def _lines(errors: Path) -> list[str]:
    return errors.read_text("utf-8", "replace").splitlines()


def _bars(lines: list[str]) -> list[str]:
    """Lines of progress."""
    return [one for one in lines if "%|" in one or one.endswith(" left") or not one.strip(UP)]


def finding(case: Case, end: End) -> str | None:
    """The finding about how a command ended; None if correct."""
    code, lines = end
    if any("Traceback" in line or "Exception ignored" in line for line in lines):
        return lines[-1]
    bars = _bars(lines)
    if code is None:
        return None if bars or case.words[1] in SLOW else f"not done after {SECONDS} s"
    if code not in CODES:
        return f"exit code {code}: {' '.join(lines[-2:])}"
    if code == 2 and not lines and "2>" not in case.redirection:
        return "exit code 2 without a line"
    if other := [one for one in lines if not MESSAGE.match(one) and one not in bars]:
        return f"not a message: {' | '.join(other)[:300]}"
    return None


def fuzz(name: str, rounds: int, seed: int, record: Path) -> int:
    """Start `rounds` commands of a kind; print and count the findings."""
    findings, ends = 0, Counter[str]()
    for number in range(rounds):
        case = KINDS[name](fuzzing.random_of(name, seed, number))
        with tempfile.TemporaryDirectory() as folder:
            make_folder(Path(folder), record)
            end = end_of(case, Path(folder))
        ends["still working" if end.code is None else str(end.code)] += 1
        if what := finding(case, end):
            findings += 1
            words = ascii([word[:80] for word in case.words])
            around = f"{case.redirection} {case.environment or ''}{' deleted' * case.deleted}"
            around += f" {case.mask}{' trapped' * case.trapped}"
            print(f"{name}, round {number}: {what!a}\n    {words} {around}", flush=True)
    print(
        f"{name}: {rounds} commands, {findings} findings, ends {dict(sorted(ends.items()))}",
        flush=True,
    )
    return findings


def main() -> int:
    """Run from the command line; returns the exit code."""
    # A shell's background job ignores Ctrl-C, and so would its child processes.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "run.h5"
        simulate(2, record, "peaceful", 2, 1)
        return fuzzing.main(
            __doc__, KINDS, 50, lambda name, given: fuzz(name, given.rounds, given.seed, record)
        )


if __name__ == "__main__":
    sys.exit(main())
