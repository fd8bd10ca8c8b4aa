"""Exit codes, one-line errors and help, shared by all command lines of the project."""

import argparse
import errno
import math
import os
import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from subsea.core.errors import UserError, unknown


def run_command(program: str, run: Callable[[], int]) -> int:
    """Run a command and return the exit code of the process.

    The code is the return value of ``run`` (0 done, 1 a negative finding), 2 for an error that the
    user can fix (one line on standard error), or 130 after Ctrl-C or SIGTERM.
    """
    signal.signal(signal.SIGTERM, _terminate)
    try:
        return run()
    except UserError as fault:
        print(f"{program}: {fault}", file=sys.stderr)
        return 2
    except ImportError as fault:
        if (fault.name or "").partition(".")[0] in ("subsea", "capture"):
            raise
        # A missing package, or a missing system library of a package.
        print(
            f"{program}: {fault}; `make run` in a checkout installs what is missing",
            file=sys.stderr,
        )
        return 2
    except KeyboardInterrupt as interrupt:
        print(": ".join([program, "interrupted", *interrupt.args]), file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output has closed it, as in `subsea … | head`.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as fault:
        # Results or compiled code fill the disk.
        if fault.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        place = f"{fault.filename}: " if fault.filename else ""
        print(f"{program}: {place}{fault.strerror}", file=sys.stderr)
        return 2


def _terminate(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Keep line breaks of descriptions and examples; a wide column for options."""

    def __init__(self, prog: str, **rest: Any) -> None:
        super().__init__(prog, max_help_position=28, **rest)
        self._action_max_length = 14  # argparse ignores the indentation of commands


class Parser(argparse.ArgumentParser):
    """A parser whose errors are UserErrors, without the usage."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=_Formatter, allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """Raise a UserError with the name of the command."""
        command = self.prog.partition(" ")[2]
        raise UserError(f"{command}: {message}" if command else message)


def make_parser(name: str, description: str) -> Parser:
    """Create the parser of a program, for `add_command`."""
    epilog = f"`{name} COMMAND --help` shows the options and examples of a command."
    return Parser(prog=name, description=description, epilog=epilog)


def add_command(
    commands: Any, name: str, summary: str, text: str, examples: list[str]
) -> argparse.ArgumentParser:
    """Add a command to ``commands`` (of ``add_subparsers``) and return its parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}.\n\n{text}",
        epilog="examples:\n" + "\n".join(f"  {example}" for example in examples),
    )
    return parser


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
        return f"{noun} from {self.low} to {self.high}"

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
