"""docs/pictures/builder-*.jpg: the fish builder at work, for docs/builder.md.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_builder_pictures.py [FOLDER]
"""

import time
from collections.abc import Callable
from contextlib import closing
from functools import partial

from picture_files import FOLDER, output_folder, save
from PIL import Image

from subsea.fish.editing import draft as drafts
from subsea.fish.editing.draft import Draft
from subsea.ui.fish_builder.new_species import Naming
from subsea.ui.fish_builder.window import begun
from subsea.ui.tool_window import Bench

SIZE = 1280, 800
RING = ("body", "ring", 1)
FLANK = 810, 8, 1190, 209  # of a blue tang on the plate of species
WAIT_S = 60.0  # for checks, at most

folder = output_folder()


def take(bench: Bench, name: str, pause_s: float = 2.0) -> None:
    """Save the window when the fish swims and the checks are done."""
    for _ in range(round(pause_s / 0.05)):
        bench.frame(0.05)
    end = time.monotonic() + WAIT_S
    while bench.busy and time.monotonic() < end:
        bench.frame(0.02)
    bench.frame(0.02)
    save(Image.fromarray(bench.picture()), folder / f"builder-{name}.jpg")


def edited(bench: Bench, *edits: Callable[[Draft], Draft]) -> None:
    """Make some edits by mouse and keys."""
    for edit in edits:
        assert bench.craft.editing.do(edit), bench.craft.editing.refused


def main() -> None:
    """Save all pictures."""
    with closing(Bench("subsea build", begun("clownfish"), SIZE)) as bench:
        craft = bench.craft
        take(bench, "start", 6.0)
        craft.naming = naming = Naming("clownfish")
        naming.name, naming.key = "Moor clownfish", "moor_clownfish"
        take(bench, "new", 0.5)
        craft.naming = None

    with closing(Bench("subsea build", begun("clownfish"), SIZE)) as bench:
        craft = bench.craft
        high = [1, 2, 3, 4, 5, 6, 7, 8]
        for k in high:  # a higher back
            x, y = craft.editing.present.species.surface.back[k]
            at = (x, y + 0.045 * min(k, 9 - k) / 4)
            edited(bench, partial(drafts.moved, view="side", path=("surface", "back", k), to=at))
        craft.editing.chosen = ("surface", "back", 5)
        take(bench, "shape", 3.0)
        edited(
            bench,
            partial(drafts.moved, view="top", path=RING, to=(0.40, 0.085)),
            partial(drafts.moved, view="side", path=RING, to=(0.40, 0.16)),
            partial(drafts.as_heavy, grams=230.0),
        )
        craft.editing.chosen = RING
        craft.panels.show = "Body"
        take(bench, "body", 3.0)
        craft.panels.show = "Checks"
        edited(bench, partial(drafts.changed, path=("swim", "contraction"), value=[0.2, 0.18]))
        take(bench, "checks", 3.0)

    # A photograph to draw over: the left flank of a tang, from the plate of species.
    plate = Image.open(FOLDER / "species.jpg").convert("RGB")
    photo = folder / "photograph.png"
    plate.crop(FLANK).resize((3 * (FLANK[2] - FLANK[0]), 3 * (FLANK[3] - FLANK[1]))).save(photo)
    try:
        with closing(Bench("subsea build", begun("clownfish", over=photo), SIZE)) as bench:
            tracing = bench.craft.tracing
            tracing.left, tracing.middle, tracing.wide = -0.066, 0.0286, 1.144
            bench.craft.views.soft = True
            take(bench, "photograph", 3.0)
    finally:
        photo.unlink()


if __name__ == "__main__":
    main()
