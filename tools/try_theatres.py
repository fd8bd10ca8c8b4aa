"""Try every theatre file of other programs in a folder, and print a table in Markdown.

    python tools/try_theatres.py FOLDER [--sheet PICTURE]

A row says what was read and what was left out; files that differ in the number of a channel share
the row of the first. With --sheet the test pattern of the first file of
each kind is drawn as well. docs/developers/theatre-formats.md says where real files are.
"""

import argparse
import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from subsea.base.errors import UserError
from subsea.dive.start import headless
from subsea.rendering.output.target import ResolvePass
from subsea.stage.setup import left_out, shrink_theatre
from subsea.stage.theatre.channels import ProjectorChannel, usable_channels
from subsea.stage.theatre.load import READERS, load_theatre
from subsea.stage.theatre.mesh_formats import frustum_file
from subsea.stage.theatre.test_pattern import lineup
from subsea.stage.theatre.theatre_rig import theatre_rig, visible_channels
from subsea.stage.theatre.warp import describe_warp

SIDE = 300  # pixels of a picture on the sheet, and of its row
COLUMNS = 3
LABEL = 16
MOST_WINDOWS = 9  # of a theatre on the sheet


def main() -> None:
    """Print the table and draw the sheet."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--sheet", type=Path)
    options = parser.parse_args()
    kinds: dict[str, Path] = {}
    rows: dict[str, list[tuple[str, str]]] = {}
    for path in sorted(options.folder.rglob("*")):
        if path.suffix.lower() not in READERS or path == frustum_file(path):
            continue
        if path.stem.endswith("_frustum"):
            continue
        kind, read, missing = tried(path)
        cell = "; ".join(missing).replace("|", "\\|")
        name = str(path.relative_to(options.folder))
        numbered = re.sub(r"channel\d", "channel…", name)
        rows.setdefault(f"{numbered} {read[:7]}", []).append((name, f"{read} | {cell}"))
        if kind:
            kinds.setdefault(kind, path)
    print("| file | read | left out |\n| --- | --- | --- |")
    for alike in rows.values():
        name, found = alike[0]
        others = f" and {len(alike) - 1} more" if len(alike) > 1 else ""
        print(f"| `{name}`{others} | {found} |")
    if options.sheet:
        pictures = [(kind, pattern(path)) for kind, path in kinds.items()]
        sheet(pictures).save(options.sheet, quality=82, optimize=True)


def tried(path: Path) -> tuple[str, str, list[str]]:
    """The kind of a file ("" if it cannot be shown), what was read, and what was left out."""
    try:
        theatre, source = load_theatre(str(path))
        found, faults = usable_channels(theatre, source)
        found, unseen = visible_channels(theatre, found)
    except UserError as fault:
        return "", "nothing", [fault.message]
    lines = [*left_out(theatre), *(fault.message for fault in (*faults, *unseen))]
    shapes = Counter(screen_of(one) for one in found)
    words = ", ".join(f"{count} × {kind}" for kind, count in shapes.items())
    windows = len({one.window for one in found})
    read = f"{windows} window{'s' * (windows != 1)}: {words}"
    warps = [one.warp for one in found if one.warp is not None]
    if warps:
        read += f", {describe_warp(warps[0])}"
    several = "several " if len(found) > windows else ""
    kind = f"{path.suffix.lower()}: {several}{' '.join(sorted(shapes))}"
    made = getattr(theatre, "meshes", {})
    word = ", a composed mesh" if made else ", a mesh" if warps else ""
    return kind + word, read, grouped(lines)


def screen_of(one: ProjectorChannel) -> str:
    """The kind of a channel's screen."""
    return one.shape.name.lower() if one.screen is None else type(one.screen).__name__.lower()


def grouped(lines: list[str]) -> list[str]:
    """Lines that differ only in names, once with their number."""
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for line in lines:
        key = re.sub(r"'[^']*'", "'…'", line)
        first.setdefault(key, line)
        counts[key] += 1
    return [
        first[key] if count == 1 else f"{count} × {first[key]}" for key, count in counts.items()
    ]


def pattern(path: Path) -> Image.Image:
    """The test pattern of a theatre on its windows."""
    theatre, source = load_theatre(str(path))
    most = max(max(window.size) for window in theatre.window)
    least = min(min(window.size) for window in theatre.window)
    theatre = shrink_theatre(theatre, max(min(most // SIDE, least // 100), 1))
    found, _ = visible_channels(theatre, usable_channels(theatre, source)[0])
    numbers = sorted({one.window for one in found})[:MOST_WINDOWS]
    rig = theatre_rig(theatre, found, numbers)
    with headless() as context:
        shown = [Image.fromarray(one) for one in resolved(context, rig)]
    across = min(len(shown), COLUMNS)
    wide, high = max(one.width for one in shown), max(one.height for one in shown)
    whole = Image.new("RGB", (across * wide, -(-len(shown) // across) * high), "white")
    for k, one in enumerate(shown):
        whole.paste(one, (k % across * wide, k // across * high))
    return whole


def resolved(context: Any, rig: Any) -> list[np.ndarray]:
    """The outputs (h, w, 3) of a rig that shows its test pattern."""
    canvas = np.ascontiguousarray(lineup(rig)[::-1])
    texture = context.texture(rig.canvas, 3, canvas.tobytes(), alignment=1)
    resolve, found = ResolvePass(context, rig.patches), []
    for output, size in enumerate(rig.outputs):
        target = context.simple_framebuffer(size)
        target.clear()
        for number, patch in enumerate(rig.patches):
            if patch.output == output:
                resolve.draw(texture, target, size, number, linear=False)
        data = np.frombuffer(target.read(alignment=1), np.uint8)
        found.append(data.reshape(size[1], size[0], 3)[::-1])
        context.detect_framebuffer(0).use()
        target.release()
    resolve.release()
    texture.release()
    return found


def sheet(pictures: list[tuple[str, Image.Image]]) -> Image.Image:
    """Pictures with their labels in rows."""
    cells = []
    for label, picture in pictures:
        picture.thumbnail((SIDE, SIDE * 3 // 4))
        cell = Image.new("RGB", (SIDE, SIDE * 3 // 4 + LABEL), "white")
        cell.paste(picture, ((SIDE - picture.width) // 2, LABEL))
        ImageDraw.Draw(cell).text((4, 2), label, "black")
        cells.append(cell)
    rows = -(-len(cells) // COLUMNS)
    whole = Image.new("RGB", (COLUMNS * SIDE, max(rows, 1) * (SIDE * 3 // 4 + LABEL)), "white")
    for k, cell in enumerate(cells):
        whole.paste(cell, (k % COLUMNS * SIDE, k // COLUMNS * cell.height))
    return whole


if __name__ == "__main__":
    main()
