"""Make line-up.jpg: the page of line-up, and a screen of three projectors before and after it.

Run from the root of a checkout, where there is Chromium: PYTHONPATH=. python
docs/make_line_up_picture.py
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import numpy as np
from picture_files import output_folder, save
from PIL import Image
from projector_pictures import projector_pictures

from subsea.base.arrays import Array, Bytes
from subsea.stage.setup import set_up_theatre
from subsea.stage.theatre.adjusting import ANTICLOCKWISE, UNIT
from subsea.stage.theatre.channels import ProjectorChannel
from subsea.stage.theatre.line_up import LineUp, LineUpChannel
from subsea.stage.theatre.screens import Curved, places_on
from subsea.stage.theatre.theatre_file import Adjustment, Corners
from subsea.stage.theatre.theatre_rig import readjusted
from subsea.view.adjustment import homography
from subsea.view.rig import CameraRig
from tests.stage.console.conftest import Console, local
from tests.support.browser import browser

GAMMA = 2.2
SHRINK = 2
PAGE, WIDE, GAP = (820, 930), 880, 6
# Where the corners of the pictures land, in shares of their part of the screen, in the order of
# `UNIT`: the first and the last projector were pushed by a ladder.
PUSHED = {
    0: np.array([[0.015, -0.02], [1.02, 0.02], [0.985, 1.03], [-0.01, 0.985]]),
    2: np.array([[-0.02, 0.025], [0.98, -0.015], [1.015, 0.97], [0.01, 1.02]]),
}


def main() -> None:
    """Draw page and screens, and put them side by side."""
    house = set_up_theatre("three-projectors", shrink=SHRINK)
    lined = [
        replace(one, adjustment=_cure(one.size, PUSHED.get(number, UNIT)))
        for number, one in enumerate(house.channels)
    ]
    before = _screen(house.channels, house.rig)
    after = _screen(lined, readjusted(house.rig, lined))
    screens = [Image.fromarray(one).reduce(2) for one in (before, after)]
    page = _page([(one.name, PUSHED.get(number, UNIT)) for number, one in enumerate(lined)])
    high = sum(one.height for one in screens) + GAP
    page = page.resize((round(page.width * high / page.height), high), Image.Resampling.LANCZOS)
    sheet = Image.new("RGB", (page.width + GAP + WIDE // 2, high), "white")
    sheet.paste(page, (0, 0))
    for number, one in enumerate(screens):
        sheet.paste(one, (page.width + GAP, number * (screens[0].height + GAP)))
    save(sheet, output_folder() / "line-up.jpg")


def _cure(size: tuple[int, int], landed: Array) -> Adjustment:
    """The corners with which a picture of `size` pixels lands where it should."""
    inverse = np.linalg.inv(homography(landed))
    lit = np.column_stack([UNIT, np.ones(4)]) @ inverse.T
    shifts = (lit[:, :2] / lit[:, 2:] - UNIT) * size * [1.0, -1.0]
    moved = dict(zip(ANTICLOCKWISE, np.round(shifts, 1).tolist(), strict=True))
    return Adjustment(corners_px=msgspec.convert(moved, Corners))


def _screen(channels: Sequence[ProjectorChannel], rig: CameraRig) -> Bytes:
    """The unrolled screen (h, w, 3) with the light of all projectors, where they really point."""
    first, last = channels[0].screen, channels[-1].screen
    assert isinstance(first, Curved)
    assert isinstance(last, Curved)
    high = round(WIDE * (first.top - first.bottom) / first.radius / (last.right - first.left))
    turn, y = np.meshgrid(
        np.linspace(first.left, last.right, WIDE), np.linspace(first.top, first.bottom, high)
    )
    ways = np.stack([first.radius * np.sin(turn), y, first.radius * np.cos(turn)], axis=-1)
    light = np.zeros((high * WIDE, 3))
    for number, (one, shown) in enumerate(zip(channels, projector_pictures(rig), strict=True)):
        assert one.screen is not None
        landed = places_on(one.screen, ways.reshape(-1, 3))
        inverse = np.linalg.inv(homography(PUSHED.get(number, UNIT)))
        sent = np.column_stack([landed, np.ones(len(landed))]) @ inverse.T
        sent = sent[:, :2] / sent[:, 2:]
        with np.errstate(invalid="ignore"):
            lit = ((sent >= 0.0) & (sent < 1.0)).all(axis=1)
        column, row = (sent[lit] * one.size).astype(int).T
        light[lit] += (shown[::-1][row, column] / 255.0) ** GAMMA
    picture = 255 * np.clip(light.reshape(high, WIDE, 3), 0, 1) ** (1 / GAMMA)
    return np.asarray(picture.astype(np.uint8))


def _page(pushed: Sequence[tuple[str, Array]]) -> Image.Image:
    """The page in a browser, with the last projector chosen."""
    size = 1920, 1200
    line_up = LineUp([LineUpChannel(name, size, blends=True) for name, _ in pushed])
    line_up.begin()
    for name, landed in pushed:
        line_up.choose(name, "lower_left")
        line_up.set("corners_px", _cure(size, landed).corners_px)
    line_up.choose(point="2,3")
    line_up.move(6.0, -4.0)
    console = Console(local())
    try:
        console.dive.line_up = line_up
        console.dive.state["projectors"] = line_up.describe()
        with browser() as page, TemporaryDirectory() as folder:
            page.size(*PAGE)
            page.open(f"http://{console.host}/line-up")
            page.until("document.querySelectorAll('#pad .point').length > 10")
            page.screenshot(Path(folder) / "page.png")
            with Image.open(Path(folder) / "page.png") as picture:
                return picture.convert("RGB")
    finally:
        console.close()


if __name__ == "__main__":
    main()
