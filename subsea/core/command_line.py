"""What the command lines of the project share: exit codes, faults in one line, help."""

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


def answer(program: str, run: Callable[[], int]) -> int:
    """Run a command and return the exit code of the process.

    What ``run`` returns (0 done, 1 a negative finding), 2 for something the user can mend (one
    line on standard error), 130 interrupted. A polite kill ends as Ctrl-C does.
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
        # A package that is not installed, or a system library that a package asks for.
        print(
            f"{program}: {fault}; `make run` in a checkout installs what is missing",
            file=sys.stderr,
        )
        return 2
    except KeyboardInterrupt as interrupt:
        print(": ".join([program, "interrupted", *interrupt.args]), file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output (`subsea … | head`) has seen enough.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as fault:
        # Not only results need room: compiled code is kept on the disk too.
        if fault.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        place = f"{fault.filename}: " if fault.filename else ""
        print(f"{program}: {place}{fault.strerror}", file=sys.stderr)
        return 2


def _terminate(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Keeps the line breaks of descriptions and examples, and the columns of options wide."""

    def __init__(self, prog: str, **rest: Any) -> None:
        super().__init__(prog, max_help_position=28, **rest)
        self._action_max_length = 14  # argparse forgets the indentation of commands


class Parser(argparse.ArgumentParser):
    """Faults are UserErrors: one line, without the usage before it."""

    def __init__(self, **options: Any) -> None:
        super().__init__(formatter_class=_Formatter, allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """Say the fault after the command's name."""
        command = self.prog.partition(" ")[2]
        raise UserError(f"{command}: {message}" if command else message)


def program(name: str, description: str) -> Parser:
    """The parser of a program; its commands are added with :func:`command`."""
    epilog = f"`{name} COMMAND --help` shows the options and examples of a command."
    return Parser(prog=name, description=description, epilog=epilog)


def command(
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


def parse(
    parser: argparse.ArgumentParser, commands: Any, arguments: Sequence[str]
) -> argparse.Namespace:
    """The options given; an unknown command or option is a UserError with the nearest one."""
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
class Number:
    """A reader of numbers in [low, high] for argparse; anything else is a fault in one line."""

    kind: type[int] | type[float]
    low: float
    high: float

    @property
    def expected(self) -> str:
        """What it reads, in words."""
        noun = "a whole number" if self.kind is int else "a number"
        return f"{noun} from {self.low} to {self.high}"

    def __call__(self, text: str) -> float:
        """The number that is written there."""
        try:
            value: float = self.kind(text)
        except ValueError:
            value = math.nan
        if not self.low <= value <= self.high:
            raise argparse.ArgumentTypeError(f"{text!r}: expected {self.expected}")
        return value


def number(kind: type[int] | type[float], low: float, high: float) -> Number:
    """The reader of such numbers."""
    return Number(kind, low, high)
