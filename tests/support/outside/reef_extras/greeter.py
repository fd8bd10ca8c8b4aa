"""A part of a dive that says how it begins and ends."""

from argparse import ArgumentParser, Namespace
from typing import Any

from subsea.base.progress import say
from subsea.dive.options import DiveOptions
from subsea.dive.part import DivePart


class Greeter(DivePart):
    """Greets the diver by name."""

    def __init__(self, name: str) -> None:
        self._name, self._pictures = name, 0

    @staticmethod
    def add_options(parser: ArgumentParser) -> None:
        """Add the option with the name."""
        parser.add_argument("--greet", metavar="NAME", help="greet the diver")

    @classmethod
    def made(cls, options: Namespace, dive: DiveOptions) -> "Greeter | None":
        """Make the part for `--greet`."""
        return None if options.greet is None else cls(options.greet)

    def begin(self, dive: Any) -> None:
        """Greet."""
        say(f"welcome to {dive.source.stem}, {self._name}")

    def shown(self, dive: Any) -> None:
        """Count the pictures."""
        self._pictures += 1

    def end(self, dive: Any) -> None:
        """Say farewell."""
        say(f"farewell, {self._name}" if self._pictures else "no picture was shown")
