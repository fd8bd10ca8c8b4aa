"""Write a new theatre: its file, its meshes and a picture of the room."""

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from subsea.base.errors import UserError
from subsea.base.file_kinds import PICTURE, check_result
from subsea.base.files import replacing
from subsea.base.pictures import write_png
from subsea.base.progress import print_line
from subsea.stage.setup import describe
from subsea.stage.theatre.channels import usable_channels
from subsea.stage.theatre.layouts import layout
from subsea.stage.theatre.lenses import nodes_text
from subsea.stage.theatre.load import load_theatre
from subsea.stage.theatre.measures import KINDS, MEASURES, ask, chosen
from subsea.stage.theatre.theatre_writer import check_free, compose_layout, line_up, mesh_name


@dataclass(frozen=True)
class NewTheatre:
    """Options of a new theatre."""

    kind: str  # "": ask
    given: Mapping[str, float | None]  # measures by name, None: the default, or ask
    out: Path
    picture: Path | None = None  # None: beside the file
    computers: bool = False
    force: bool = False


def write_theatre(
    wanted: NewTheatre,
    read: Callable[[str], str] = input,
    asks: Callable[[], bool] = sys.stdin.isatty,
) -> int:
    """Write a new theatre, its meshes and its picture; print them and the steps to line it up.

    Nothing is written if a measure is impossible or a file exists, except with `force`. Questions
    need a terminal (`asks`). Returns 0, or 1 if the file does not work.
    """
    out = wanted.out if wanted.out.suffix == ".toml" else Path(f"{wanted.out}.toml")
    picture = wanted.picture or out.with_suffix(".png")
    check_free(out, wanted.force)
    check_result(picture, PICTURE, wanted.force)
    kind = wanted.kind
    if kind:
        measures = chosen(kind, wanted.given)
    elif asks():
        kind, measures = ask(wanted.given, read, print)
    else:
        raise UserError(f"--new: expected a kind of theatre: {', '.join(KINDS)}")
    plan = layout(kind, measures)
    if wanted.computers and len(plan.channels) < 2:
        raise UserError("--computers needs two projectors or more")
    meshes = {
        out.with_name(mesh_name(out.stem, one.name)): one.nodes
        for one in plan.channels
        if one.nodes is not None
    }
    for path in meshes:
        check_free(path, wanted.force)
    options = " ".join(
        f"--{one.name} {measures[one.name]:g}" for one in MEASURES if one.name in measures
    )
    command = f"subsea theatre --new {kind} {options}{' --computers' * wanted.computers}"
    size = int(measures["across"]), int(measures["down"])
    text = compose_layout(plan, out.stem, size, wanted.computers, command)
    for path, nodes in meshes.items():
        with replacing(path) as part:
            part.write_text(nodes_text(nodes), encoding="utf-8")
    with replacing(out) as part:
        part.write_text(text, encoding="utf-8")
    code = describe(str(out))
    draw_room(str(out), picture, force=True)
    for note in plan.notes:
        print_line(note)
    print("\nTo line it up:")
    for number, step in enumerate(line_up(plan, wanted.computers), 1):
        print_line(f"{number}. {step}")
    return code


def draw_room(name: str, picture: Path, force: bool = False) -> None:
    """Write the picture of the room of a theatre, and print its name."""
    from subsea.stage.theatre.room_picture import room_picture

    check_result(picture, PICTURE, force)
    theatre, path = load_theatre(name)
    pixels = room_picture(theatre, usable_channels(theatre, path)[0])
    write_png(picture, pixels)
    print_line(f"the room: {picture}")
