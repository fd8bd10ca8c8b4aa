"""docs/pictures/panel-NAME.jpg: every panel over the bay, and the three cards as panel-cards.jpg.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_panel_pictures.py [NAME ...]
"""

import sys
from collections.abc import Callable
from contextlib import closing
from typing import Any

from imgui_bundle import imgui
from picture_files import FOLDER, save, window_image

from subsea.dive.options import DisplayOptions, DiveOptions
from subsea.ui.cards import CARDS
from subsea.ui.dive import Dive
from subsea.ui.panels import PANELS
from subsea.ui.panels.physics import simulate
from subsea.ui.panels.placement import PlacementState

SIZE, FISH, RIDDEN, WAIT_S = (1280, 780), 3, 9, 20.0
# Control tells how long a picture takes: it is shown in a sea so small that a computer without a
# GPU keeps up, beside the school.
MEASURED, SMALL = "Control", (860, 470)
BESIDE = ("submarine.position_cm=[-480, -160, -335]", "submarine.heading_deg=112")
PLACED, BESIDE_PX, SIMULATED = ("arch", 0), 330, 6
SEA_PX = 30, 8, 330, 24  # shown left, above, right and below of a panel
BELOW_EYES_PX = 20, 386  # of the panel Fish view
FADED_S = 8.0  # until the instruments have gone
FRAME_S = 0.15
VISITOR, CARDS_PX, CARDS_S = "Cards", (1120, 640), 3.0  # with pictures of the eyes that are drawn

Panel = Callable[[Any], None]
rect: list[float] = []


def noting(name: str, panel: Panel) -> Panel:
    """Wrap a panel to record where it is drawn."""

    def drawn(context: Any) -> None:
        panel(context)
        if name == "Fish view":
            imgui.set_window_pos(BELOW_EYES_PX)
        place, size = imgui.get_window_pos(), imgui.get_window_size()
        rect[:] = place.x, place.y, place.x + size.x, place.y + size.y

    return drawn


def show(names: list[str], sea: str, size: tuple[int, int], quality: str, *changes: str) -> None:
    """Save a picture of each panel in a dive."""
    with closing(
        Dive(DiveOptions(sea, changes, 1, display=DisplayOptions(size=size, quality=quality)))
    ) as dive:
        dive.overlay.hide_help()
        dive.inspector.toggle()
        wait(dive, 1.5)  # until the help has faded
        dive.inspector.chosen = FISH
        for name in names:
            arrange(dive, name)
            edges = [
                edge + sign * px
                for edge, sign, px in zip(rect, (-1, -1, 1, 1), SEA_PX, strict=True)
            ]
            edges = [min(max(round(edge), 0), size[k % 2]) for k, edge in enumerate(edges)]
            if name == "Fish view":  # with the fish, and what both its eyes see
                edges = [0, 0, *size]
            out = FOLDER / f"panel-{name.lower().replace(' ', '-')}.jpg"
            save(window_image(dive).crop(edges), out)
            if name == "Fish view":
                dive.ride_fish(None)
                dive.inspector.chosen = FISH


def show_cards() -> None:
    """Save a picture of the three cards of visitors."""
    display = DisplayOptions(size=CARDS_PX, quality="high")
    with closing(Dive(DiveOptions("peaceful", seed=1, display=display))) as dive:
        dive.overlay.hide_help()
        wait(dive, FADED_S)
        dive.inspector.toggle()
        dive.inspector.shown = set(CARDS)
        wait(dive, CARDS_S)
        save(window_image(dive), FOLDER / f"panel-{VISITOR.lower()}.jpg")


def arrange(dive: Dive, name: str) -> None:
    """Show a panel alone, with something in it."""
    dive.inspector.shown = {name}
    dive.picture.diagrams = {"scaffold", "indices"} if name == "Control" else set()
    dive.picture.colours = "identity"
    if name == "Fish view":
        dive.ride_fish(RIDDEN, behind=True)
        dive.inspector.chosen = RIDDEN
    # The charts of behavior grow meanwhile.
    wait(dive, {"Behavior": WAIT_S, "Fish view": FADED_S}.get(name, 1.2))
    if name == MEASURED:
        wait(dive, FADED_S, 0.05)
    if name == "Placement":
        dive.inspector.state(PlacementState).chosen = PLACED
        wait(dive, 2 * FRAME_S)
        rect[2] += BESIDE_PX
    if name == "Physics" and simulate(dive.inspector, SIMULATED):
        dive.world.physics = dive.world.physics._replace(fish=FISH)
        wait(dive, 30 * FRAME_S)


def wait(dive: Dive, seconds: float, frame_s: float = FRAME_S) -> None:
    """Advance the sea by this time."""
    for _ in range(round(seconds / frame_s)):
        dive.frame(frame_s)


def main() -> None:
    """Make all pictures or the named ones."""
    asked = sys.argv[1:] or [VISITOR, *PANELS]
    if VISITOR in asked:
        show_cards()
    for name in PANELS:
        PANELS[name] = noting(name, PANELS[name])
    others = [name for name in asked if name not in (MEASURED, VISITOR)]
    if others:
        show(others, "peaceful", SIZE, "high")
    if MEASURED in asked:
        show([MEASURED], "schooling", SMALL, "low", *BESIDE)


if __name__ == "__main__":
    main()
