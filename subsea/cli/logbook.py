"""`subsea logbook`: write the logbook of a visitor as a page."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command

GROUP = "dive and film"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "logbook",
        "print what you met under water, or write it as a page",
        "Dives enter species and behaviors that you see. Nothing is sent anywhere.",
        ["subsea logbook", "subsea logbook --out logbook.html"],
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="write a page with all pictures")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Print or write the logbook."""
    from subsea.base.files import check_file, replacing
    from subsea.base.progress import print_line, say
    from subsea.dive.logbook import Logbook, logbook_folder, page_of, subjects, title_of

    if options.out is not None:
        check_file(options.out)
    book = Logbook(logbook_folder())
    if fault := book.read():
        say(fault)
    if options.out is not None:
        with replacing(options.out) as part:
            part.write_text(page_of(book), encoding="utf-8")
        print_line(f"page: {options.out}")
        return 0
    for names in subjects(book.entries):
        for name in names:
            entry = book.entries.get(name)
            seen = f"{entry.day}  {entry.place}" if entry else "not yet"
            print_line(f"{title_of(name):<26}  {seen}")
    return 0
