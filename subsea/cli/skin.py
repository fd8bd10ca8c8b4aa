"""`subsea skin`: dress a species from a photograph."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from subsea.core.command_line import add_command
from subsea.core.errors import UserError


def add(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "skin",
        "dress a species from a photograph",
        "Opens a window in which you drag meshes over the fish until they match its outline;\n"
        "--auto does it without one. The pixels under the meshes become the skin of the species:\n"
        "a picture beside its file, named by skin.sheet. docs/skin.md explains how, and what\n"
        "makes a good photograph. Needs the extra `skin`.",
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
        "photo", metavar="PHOTO", type=Path, help="a fish from its side: JPEG, PNG …"
    )
    parser.add_argument(
        "--species", metavar="NAME", help="species to dress (in the window default clownfish)"
    )
    parser.add_argument("--auto", action="store_true", help="without a window")
    parser.add_argument(
        "--out", type=Path, metavar="FILE.png", help="write the sheet there and change no species"
    )
    parser.add_argument(
        "--flip", action="store_true", help="the fish heads the other way than detected"
    )
    parser.add_argument(
        "--mesh",
        type=Path,
        metavar="FILE.json",
        help="meshes to use instead of detecting the fish; a missing file is written, in the "
        "window by Save",
    )
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Open the window, or dress the species without one."""
    if options.auto and options.species is None:
        raise UserError("skin: --auto needs --species NAME")
    try:
        import cv2  # noqa: F401
    except ImportError as fault:
        raise UserError("skin needs OpenCV: install subsea[skin]") from fault
    given = options.photo, options.species, options.out, options.flip, options.mesh
    if options.auto:
        from subsea.fish.photo.dress import dress

        return dress(*given)
    from subsea.ui.skin_editor.window import edit_skin

    return edit_skin(*given)
