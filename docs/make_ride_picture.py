"""docs/pictures/ride.png: a ride on a fish, with its eyes' identity maps in the corners.

Run from the root of a checkout, where there is a display (or by xvfb-run -a -s "-screen 0
1280x800x24"): python docs/make_ride_picture.py
"""

from contextlib import closing
from pathlib import Path

from PIL import Image

from subsea.app.dive import Dive

SIZE, FISH, WAIT_S, RIDE_S = (960, 540), 9, 5.0, 2.4

out = Path(__file__).parent / "pictures" / "ride.png"
with closing(Dive("peaceful", "mono", SIZE, seed=1, quality="high")) as dive:
    for _ in range(round(WAIT_S / 0.1)):
        dive.frame(0.1)
    dive.mount(FISH)
    dive.grant("look")
    for _ in range(round(RIDE_S / 0.1)):
        dive.frame(0.1)
    shown = dive.picture._context.screen.read(viewport=(0, 0, *dive.window.size), components=3)
    picture = Image.frombytes("RGB", dive.window.size, shown)
    picture.transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(out, optimize=True)
    print(out)
