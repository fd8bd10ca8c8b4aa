"""Command lines of the project: exit codes, one-line errors, help, output that may be closed."""

import argparse
import errno
import io
import math
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from subsea import __version__
from subsea.base.errors import TransientError, UserError, is_full_disk, nearest, printable, unknown
from subsea.base.interrupts import INTERRUPTED, raised_interrupts
from subsea.base.system import import_fault


class _TolerantFile(io.FileIO):
    """A file that accepts everything, and stores its first fault."""

    fault: OSError | None = None

    def write(self, data: Any) -> int:
        """Write data; after a fault, nothing."""
        if self.fault is None:
            try:
                return super().write(data)
            except OSError as fault:
                self.fault = fault
        return len(data)


@contextmanager
def tolerant_output() -> Iterator[Callable[[], None]]:
    """Let a command finish its work when its output cannot be written.

    Letters that the terminal's encoding lacks become escapes. Yields a function that raises a
    UserError if standard output has lost text to anything but a closed pipe, as in ``| head``.
    Streams that another program has replaced, such as a notebook's, stay as they are.
    """
    for number in range(3):
        _open_closed(number)
    before = sys.stdout, sys.stderr
    files: dict[str, _TolerantFile] = {}
    for number, name in ((1, "stdout"), (2, "stderr")):
        old = getattr(sys, name)
        if old is getattr(sys, f"__{name}__"):
            _flush(old)
            files[name] = _TolerantFile(number, "wb", closefd=False)
            setattr(sys, name, _text_stream(files[name], old))

    def check() -> None:
        _flush(sys.stdout)
        fault = files["stdout"].fault if "stdout" in files else None
        if fault and not isinstance(fault, BrokenPipeError):
            raise UserError(f"{fault.strerror}", file="standard output") from fault

    try:
        yield check
    finally:
        _flush(sys.stdout)
        _flush(sys.stderr)
        sys.stdout, sys.stderr = before


def _open_closed(number: int) -> None:
    """Open the null device in place of a closed stream, whose number a result would get."""
    try:
        os.fstat(number)
    except OSError:
        os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)


def _text_stream(file: _TolerantFile, old: Any) -> io.TextIOWrapper:
    """A stream to a file with the settings of an old one; it escapes unknown letters."""
    return io.TextIOWrapper(
        io.BufferedWriter(file),
        encoding=old.encoding if old else "utf-8",
        errors="backslashreplace",
        line_buffering=old.line_buffering if old else False,
        write_through=old.write_through if old else False,
    )


def _flush(stream: Any) -> None:
    """Flush a stream; None is a closed one."""
    if stream is not None:
        stream.flush()


TRANSIENT = 75  # exit code of an error that may pass by itself: EX_TEMPFAIL of sysexits.h
# Python, the loader of libraries and the system say so without an error of a kind of its own.
NO_MEMORY = "can't start new thread", "failed to map segment", os.strerror(errno.ENOMEM)
NAME_WIDTH = 12  # of the column of commands in the help


def run_command(program: str, run: Callable[[], int]) -> int:
    """Run a command and return the exit code of the process.

    The code is the return value of ``run`` (0 done, 1 a negative finding), 2 for an error that the
    user can fix, 75 for one that may also pass by itself (one line on standard error), or 130 after
    Ctrl-C or SIGTERM.
    """
    with tolerant_output() as check, warnings.catch_warnings():
        # An unreadable setting: otherwise numba warns in ten lines.
        warnings.filterwarnings("error", "Environment variable 'NUMBA_", RuntimeWarning)
        try:
            try:
                _check_cpu_features()
                with raised_interrupts(program):
                    code = run()
            except SystemExit:  # after --help or --version
                check()
                raise
            check()
            return code
        except UserError as fault:
            print(f"{program}: {fault}", file=sys.stderr)
            return TRANSIENT if isinstance(fault, TransientError) or is_full_disk(fault) else 2
        except KeyboardInterrupt as interrupt:
            print(": ".join([program, "interrupted", *interrupt.args]), file=sys.stderr)
            return INTERRUPTED
        except Exception as fault:
            if not (reason := _reason(fault)):
                raise
            print(f"{program}: {printable(reason)}", file=sys.stderr)
            return TRANSIENT if is_full_disk(fault) else 2


def _check_cpu_features() -> None:
    """Refuse a setting of numba at which its compiler aborts the process."""
    setting = os.environ.get("NUMBA_CPU_FEATURES", "")
    if not all(part.startswith(("+", "-")) for part in setting.split(",") if part):
        raise UserError(
            f"numba does not start with NUMBA_CPU_FEATURES={setting} (expected + or - before each "
            "feature, such as +avx2,-avx512f)"
        )


def _reason(fault: Exception) -> str | None:
    """The words for a fault of the environment; None for one of the program."""
    for package in ("numba", "tqdm"):
        prefix = f"{package}_".upper()
        settings = [
            f"{name}={value}" for name, value in os.environ.items() if name.startswith(prefix)
        ]
        begun = any(module.startswith(f"{package}.") for module in sys.modules)
        if settings and begun and package not in sys.modules:  # its import failed
            first = str(fault).partition("\n")[0].rstrip(".")
            return f"{package} does not start with {', '.join(settings)} ({first})"
    if any(map(_lacks_memory, _causes(fault))):
        return "not enough memory; close other programs, or raise the limit (`ulimit -v`)"
    if isinstance(fault, ImportError):
        if (fault.name or "").partition(".")[0] in ("subsea", "capture"):
            return None
        return import_fault(fault)
    if isinstance(fault, FileNotFoundError) and not _has_folder():
        return "the current folder was deleted; change to another one"
    if isinstance(fault, OSError) and is_full_disk(fault):  # of results or compiled code
        return f"{f'{fault.filename}: ' if fault.filename else ''}{fault.strerror}"
    return None


def _causes(fault: BaseException | None) -> Iterator[BaseException]:
    """A fault, and those that led to it."""
    while fault:
        yield fault
        fault = fault.__cause__ or fault.__context__


def _lacks_memory(fault: BaseException) -> bool:
    return isinstance(fault, MemoryError) or any(words in str(fault) for words in NO_MEMORY)


def _has_folder() -> bool:
    """False if the current folder was deleted."""
    try:
        Path.cwd()
    except FileNotFoundError:
        return False
    return True


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Keep line breaks of descriptions and examples; a wide column for options."""

    def __init__(self, prog: str, **rest: Any) -> None:
        super().__init__(prog, max_help_position=28, **rest)
        self._action_max_length = 14  # argparse ignores the indentation of commands


class Parser(argparse.ArgumentParser):
    """A parser whose errors are UserErrors, without the usage."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=_Formatter, allow_abbrev=False, **options)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        choices = list(action.choices or ())
        if choices and value not in choices:
            name = "/".join(action.option_strings) or str(action.metavar or action.dest)
            hint = nearest(str(value), choices) or f"; there are: {', '.join(choices)}"
            raise argparse.ArgumentError(None, f"{name} {value!r}: unknown choice{hint}")

    def error(self, message: str) -> NoReturn:
        """Raise a UserError with the name of the command."""
        command = self.prog.partition(" ")[2]
        raise UserError(f"{command}: {message}" if command else message)


def make_parser(name: str, description: str) -> Parser:
    """Create the parser of a program, for `add_command`."""
    parser = Parser(prog=name, usage=f"{name} COMMAND [OPTION]...", description=description)
    parser.add_argument(
        "--version", action="version", version=f"subsea {__version__}", help="show the version"
    )
    return parser


def add_groups(parser: Parser, titles: Sequence[str], modules: Mapping[str, Any]) -> Any:
    """Add the commands of modules, which have a function `add` and a GROUP.

    The help lists them by group: the `titles` in their order, then those of other packages.
    Returns what argparse's ``add_subparsers`` returns, with the parsers of all commands.
    """
    commands = parser.add_subparsers(
        dest="command", metavar="COMMAND", prog=parser.prog, help=argparse.SUPPRESS
    )
    groups: dict[str, list[str]] = {title: [] for title in titles}
    for _, module in sorted(modules.items()):
        module.add(commands)
        name, command = list(commands.choices.items())[-1]
        line = f"  {name:<{NAME_WIDTH}}{command.get_default('summary')}"
        groups.setdefault(module.GROUP, []).append(line)
    for title, lines in groups.items():
        if lines:
            parser.epilog = "\n".join([*filter(None, [parser.epilog]), f"{title}:", *lines, ""])
    about = f"`{parser.prog} COMMAND --help` shows the options and examples of a command."
    parser.epilog = f"{parser.epilog}\n{about}"
    return commands


def add_command(
    commands: Any, name: str, summary: str, text: str, examples: list[str]
) -> argparse.ArgumentParser:
    """Add a command to ``commands`` (of ``add_subparsers``) and return its parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        description=f"{summary[0].upper()}{summary[1:]}.\n\n{text}",
        epilog="examples:\n" + "\n".join(f"  {example}" for example in examples),
    )
    parser.set_defaults(summary=summary)
    return parser


def add_force(parser: argparse.ArgumentParser) -> None:
    """Add --force, for `subsea.base.file_kinds.check_result`."""
    parser.add_argument("--force", action="store_true", help="replace existing files of any kind")


def parse_arguments(
    parser: argparse.ArgumentParser, commands: Any, arguments: Sequence[str]
) -> argparse.Namespace:
    """Parse options; a UserError for an unknown command or option names the nearest one."""
    first = arguments[0]
    if first.startswith("-") and first not in ("-h", "--help", "--version"):
        raise UserError(
            f"unknown option {first!r}: options follow a command, see `{parser.prog} --help`"
        )
    if not first.startswith("-") and first not in commands.choices:
        raise unknown("command", first, list(commands.choices))
    options, extra = parser.parse_known_args(arguments)
    if extra:
        chosen = commands.choices[options.command]
        known = sorted(name for action in chosen._actions for name in action.option_strings)
        stray = extra[0].split("=")[0]
        if stray.startswith("-"):
            raise unknown(f"option of `{chosen.prog}`:", stray, known)
        raise UserError(f"{chosen.prog}: unexpected argument {stray!r}")
    return options


@dataclass(frozen=True)
class NumberReader:
    """An argparse type for numbers in [low, high]."""

    kind: type[int] | type[float]
    low: float
    high: float

    @property
    def expected(self) -> str:
        """The expected input, for messages."""
        noun = "a whole number" if self.kind is int else "a number"
        low, high = (str(bound).removesuffix(".0") for bound in (self.low, self.high))
        return f"{noun} from {low} to {high}"

    def __call__(self, text: str) -> float:
        """Convert a text to a number in the range."""
        try:
            value: float = self.kind(text)
        except ValueError:
            value = math.nan
        if not self.low <= value <= self.high:
            raise argparse.ArgumentTypeError(f"{text!r}: expected {self.expected}")
        return value


def number_reader(kind: type[int] | type[float], low: float, high: float) -> NumberReader:
    """Create an argparse type for numbers in [low, high]."""
    return NumberReader(kind, low, high)
