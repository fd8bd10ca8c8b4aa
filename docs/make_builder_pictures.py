"""docs/pictures/builder-*.jpg: the fish builder at work, for docs/how-to/builder.md.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_builder_pictures.py [FOLDER]
"""

import time
from collections.abc import Callable
from contextlib import closing
from functools import partial

from picture_files import FOLDER, output_folder, save
from PIL import Image

from subsea.studio.builder.window import builder_for
from subsea.studio.draft import SpeciesDraft, with_value
from subsea.studio.handles import drag_handle
from subsea.studio.outline import with_mass
from subsea.studio.questions import NameDialog
from subsea.studio.tool_window import ToolWindow

SIZE = 1280, 800
RING = ("body", "ring", 1)
FLANK = 810, 8, 1190, 209  # of a blue tang on the plate of species
WAIT_S = 60.0  # for checks, at most

folder = output_folder()


def take(window: ToolWindow, name: str, pause_s: float = 2.0) -> None:
    """Save the window when the fish swims and the checks are done."""
    for _ in range(round(pause_s / 0.05)):
        window.frame(0.05)
    end = time.monotonic() + WAIT_S
    while window.busy and time.monotonic() < end:
        window.frame(0.02)
    window.frame(0.02)
    save(Image.fromarray(window.window_set.picture()), folder / f"builder-{name}.jpg")


def edited(window: ToolWindow, *edits: Callable[[SpeciesDraft], SpeciesDraft]) -> None:
    """Make some edits by mouse and keys."""
    for edit in edits:
        assert window.tool.editing.do(edit), window.tool.editing.refused


def main() -> None:
    """Save all pictures."""
    with closing(ToolWindow("subsea build", builder_for("clownfish"), SIZE)) as window:
        builder = window.tool
        take(window, "start", 6.0)
        builder.naming = naming = NameDialog("clownfish")
        naming.name, naming.key = "Moor clownfish", "moor_clownfish"
        take(window, "new", 0.5)
        builder.naming = None

    with closing(ToolWindow("subsea build", builder_for("clownfish"), SIZE)) as window:
        builder = window.tool
        high = [1, 2, 3, 4, 5, 6, 7, 8]
        for k in high:  # a higher back
            x, y = builder.editing.present.species.surface.back[k]
            at = (x, y + 0.045 * min(k, 9 - k) / 4)
            edited(window, partial(drag_handle, view="side", path=("surface", "back", k), to=at))
        builder.editing.selected = ("surface", "back", 5)
        take(window, "shape", 3.0)
        edited(
            window,
            partial(drag_handle, view="top", path=RING, to=(0.40, 0.085)),
            partial(drag_handle, view="side", path=RING, to=(0.40, 0.16)),
            partial(with_mass, grams=230.0),
        )
        builder.editing.selected = RING
        builder.panels.show = "Body"
        take(window, "body", 3.0)
        builder.panels.show = "Checks"
        edited(window, partial(with_value, path=("swim", "contraction"), value=[0.2, 0.18]))
        take(window, "checks", 3.0)

    # A photograph to draw over: the left flank of a tang, from the plate of species.
    plate = Image.open(FOLDER / "species.jpg").convert("RGB")
    photo = folder / "photograph.png"
    plate.crop(FLANK).resize((3 * (FLANK[2] - FLANK[0]), 3 * (FLANK[3] - FLANK[1]))).save(photo)
    try:
        with closing(
            ToolWindow("subsea build", builder_for("clownfish", over=photo), SIZE)
        ) as window:
            overlay = window.tool.overlay
            overlay.left, overlay.middle, overlay.wide = -0.066, 0.0286, 1.144
            window.tool.views.soft = True
            take(window, "photograph", 3.0)
    finally:
        photo.unlink()


if __name__ == "__main__":
    main()
