"""Try every theatre file of other programs in a folder, and print a table in Markdown.

    python tools/try_theatres.py FOLDER

A row says what was read and what was left out; files that differ in the number of a channel share
the row of the first. docs/developers/theatre-formats.md says where real files are.
"""

import argparse
import re
from collections import Counter
from pathlib import Path

from subsea.base.errors import UserError
from subsea.stage.setup import left_out
from subsea.stage.theatre.channels import ProjectorChannel, usable_channels
from subsea.stage.theatre.load import READERS, load_theatre
from subsea.stage.theatre.mesh_formats import frustum_file
from subsea.stage.theatre.theatre_rig import visible_channels
from subsea.stage.theatre.warp import describe_warp


def main() -> None:
    """Print the table and draw the sheet."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    rows: dict[str, list[tuple[str, str]]] = {}
    for path in sorted(options.folder.rglob("*")):
        if path.suffix.lower() not in READERS or path == frustum_file(path):
            continue
        if path.stem.endswith("_frustum"):
            continue
        read, missing = tried(path)
        cell = "; ".join(missing).replace("|", "\\|")
        name = str(path.relative_to(options.folder))
        numbered = re.sub(r"channel\d", "channel…", name)
        rows.setdefault(f"{numbered} {read[:7]}", []).append((name, f"{read} | {cell}"))
    print("| file | read | left out |\n| --- | --- | --- |")
    for alike in rows.values():
        name, found = alike[0]
        others = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
        print(f"| `{name}`{others} | {found} |")


def tried(path: Path) -> tuple[str, list[str]]:
    """Read a file; returns words on what was read, and lines on what was left out."""
    try:
        theatre, source = load_theatre(str(path))
        found, faults = usable_channels(theatre, source)
        found, unseen = visible_channels(theatre, found)
    except UserError as fault:
        return "nothing", [fault.message]
    lines = [*left_out(theatre), *(fault.message for fault in (*faults, *unseen))]
    shapes = Counter(screen_of(one) for one in found)
    words = ", ".join(f"{count} × {kind}" for kind, count in shapes.items())
    windows = len({one.window for one in found})
    read = f"{windows} window{'s' * (windows != 1)}: {words}"
    warps = [one.warp for one in found if one.warp is not None]
    if warps:
        read += f", {describe_warp(warps[0])}"
    return read, grouped(lines)


def screen_of(one: ProjectorChannel) -> str:
    """Name the kind of a channel's screen."""
    return one.shape.name.lower() if one.screen is None else type(one.screen).__name__.lower()


def grouped(lines: list[str]) -> list[str]:
    """Give lines that differ only in names once, with their number."""
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for line in lines:
        key = re.sub(r"'[^']*'", "'…'", line)
        first.setdefault(key, line)
        counts[key] += 1
    return [
        first[key] if count == 1 else f"{count} × {first[key]}" for key, count in counts.items()
    ]


if __name__ == "__main__":
    main()
