"""`subsea skin`: dress a species from a photograph."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.base.command_line import add_command, add_force
from subsea.base.errors import UserError
from subsea.base.system import require

GROUP = "make fishes"  # in the help


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "skin",
        "make a skin from a photograph",
        "Opens a window in which you fit meshes to the outline of the fish; --auto fits them\n"
        "without a window. The pixels under the meshes become a picture beside the species file,\n"
        "named by skin.sheet: docs/how-to/skin.md. Needs the extra `skin`.",
        [
            "subsea skin guppy.jpg",
            "subsea skin guppy.jpg --species my_guppy --mesh guppy.json",
            "subsea skin guppy.jpg --species my_guppy --auto",
            "subsea skin guppy.jpg --species my_guppy --auto --flip",
            "subsea skin guppy.jpg --species my_guppy --auto --mesh guppy.json",
            "subsea skin clown.png --species clownfish --auto --out sheet.png",
        ],
    )
    parser.add_argument(
        "photo", metavar="PHOTO", type=Path, help="side view of a fish: JPEG, PNG …"
    )
    parser.add_argument(
        "--species", metavar="NAME", help="species (in the window default clownfish)"
    )
    parser.add_argument("--auto", action="store_true", help="without a window")
    parser.add_argument(
        "--out", type=Path, metavar="FILE.png", help="write the picture there and change no species"
    )
    parser.add_argument("--flip", action="store_true", help="the fish heads the other way")
    parser.add_argument(
        "--mesh",
        type=Path,
        metavar="FILE.json",
        help="read the meshes, or write them if the file is missing",
    )
    add_force(parser)
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Open the window, or dress the species without one."""
    if options.auto and options.species is None:
        raise UserError("skin: --auto needs --species NAME")
    require("skin", "skin")
    given = options.photo, options.species, options.out, options.flip, options.mesh, options.force
    if options.auto:
        from subsea.studio.dress import dress

        return dress(*given)
    from subsea.studio.skin_editor.window import edit_skin

    return edit_skin(*given)
