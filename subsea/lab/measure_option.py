"""The option --measure of commands: measures of other packages."""

from argparse import ArgumentParser

from subsea.base.registry import MEASURES


def add_measures(parser: ArgumentParser) -> None:
    """Add --measure to a command."""
    parser.add_argument(
        "--measure",
        dest="measures",
        action="append",
        default=[],
        metavar="NAME",
        help="add a measure of another package, by the name of its entry point in "
        f"`{MEASURES}`; may be given several times",
    )
