"""docs/pictures/panel-NAME.jpg: every panel of the desk over the bay.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_panel_pictures.py [NAME ...]
"""

import sys
from contextlib import closing

from imgui_bundle import imgui
from plates import FOLDER, keep, window_of

from subsea.app.dive import Dive
from subsea.app.panels import PANELS
from subsea.app.panels.physics import simulate
from subsea.app.panels.placement import Placing

SIZE, FISH, RIDDEN, WAIT_S = (1280, 780), 3, 9, 20.0
PLACED, BESIDE_PX, SIMULATED = ("arch", 0), 330, 6
SEA_PX = 30, 8, 330, 24  # shown left, above, right and below of a panel
BELOW_EYES_PX = 20, 386  # of the panel Fish view
FADED_S = 8.0  # until the instruments have gone

rect = []


def noting(name, panel):
    """The panel, which notes where it is drawn."""

    def drawn(desk):
        panel(desk)
        if name == "Fish view":
            imgui.set_window_pos(BELOW_EYES_PX)
        place, size = imgui.get_window_pos(), imgui.get_window_size()
        rect[:] = place.x, place.y, place.x + size.x, place.y + size.y

    return drawn


with closing(Dive("peaceful", "mono", SIZE, seed=1, quality="high")) as dive:
    dive.grant("help")
    dive.desk.toggle()
    for _ in range(10):  # until the help has faded
        dive.frame(0.15)
    names = sys.argv[1:] or list(PANELS)
    for name in PANELS:
        PANELS[name] = noting(name, PANELS[name])
    dive.desk.chosen = FISH
    for name in names:
        dive.desk.shown = {name}
        dive.picture.diagrams = {"scaffold", "indices"} if name == "Control" else set()
        dive.picture.look = "identity"
        if name == "Fish view":
            dive.mount(RIDDEN, behind=True)
            dive.desk.chosen = RIDDEN
        # The charts of behavior grow meanwhile.
        wait_s = {"Behavior": WAIT_S, "Fish view": FADED_S}.get(name, 1.2)
        for _ in range(round(wait_s / 0.15)):
            dive.frame(0.15)
        if name == "Placement":
            dive.desk.of(Placing).chosen = PLACED
            dive.frame(0.15)
            dive.frame(0.15)
            rect[2] += BESIDE_PX
        if name == "Physics" and simulate(dive.desk, SIMULATED):
            dive.world.physics = dive.world.physics._replace(fish=FISH)
            for _ in range(30):
                dive.frame(0.15)
        edges = [
            edge + sign * px for edge, sign, px in zip(rect, (-1, -1, 1, 1), SEA_PX, strict=True)
        ]
        edges = [min(max(round(edge), 0), SIZE[k % 2]) for k, edge in enumerate(edges)]
        if name == "Fish view":  # with the fish, and what both its eyes see
            edges = [0, 0, *SIZE]
        out = FOLDER / f"panel-{name.lower().replace(' ', '-')}.jpg"
        keep(window_of(dive).crop(edges), out)
        if name == "Fish view":
            dive.mount(None)
            dive.desk.chosen = FISH
