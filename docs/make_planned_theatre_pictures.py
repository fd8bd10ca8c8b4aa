"""Make first-projectors.jpg and dome-of-six.jpg: room, projectors and screen of new theatres.

python docs/make_planned_theatre_pictures.py
"""

import os
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from picture_files import output_folder, save
from PIL import Image
from projector_pictures import projector_pictures

from subsea.base.arrays import Array, Bytes
from subsea.cli.main import main as subsea
from subsea.stage.setup import TheatreSetup, set_up_theatre
from subsea.stage.theatre.channels import (
    Projector,
    ProjectorChannel,
    light_shares,
    usable_channels,
)
from subsea.stage.theatre.room_picture import room_picture
from subsea.stage.theatre.screens import Curved, places_on
from subsea.view.surround import Surround, directions
from subsea.view.test_pattern import pattern

GAMMA = 2.2
SHRINK = 4
WIDE, GAP = 1200, 8
DOME = 760  # pixels of its side
PICTURES = {
    "first-projectors.jpg": ("curved", "--projectors", "3"),
    "dome-of-six.jpg": ("dome", "--projectors", "6"),
}


def main() -> None:
    """Plan each theatre in a folder that is removed, and draw it."""
    folder = output_folder()
    for name, words in PICTURES.items():
        with TemporaryDirectory() as scratch:
            path = Path(scratch) / "room.toml"
            with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere):
                assert subsea(["theatre", "--new", *words, "--out", str(path)]) == 0
            house = set_up_theatre(str(path), shrink=SHRINK)
            channels = usable_channels(house.theatre, house.path)[0]
            rows = [Image.fromarray(room_picture(house.theatre, channels)), *_projectors(house)]
            rows.append(Image.fromarray(_screen(channels)))
        rows = [_fitted(row) for row in rows]
        sheet = Image.new("RGB", (WIDE, sum(row.height + GAP for row in rows) - GAP), "white")
        top = 0
        for row in rows:
            sheet.paste(row, ((WIDE - row.width) // 2, top))
            top += row.height + GAP
        save(sheet, folder / name)


def _fitted(row: Image.Image) -> Image.Image:
    """A picture that is not wider than the sheet."""
    size = WIDE, round(row.height * WIDE / row.width)
    return row.resize(size, Image.Resampling.LANCZOS) if row.width > WIDE else row


def _projectors(house: TheatreSetup) -> list[Image.Image]:
    """Rows of three pictures that the projectors get: the test pattern."""
    found = [Image.fromarray(picture) for picture in projector_pictures(house.rig)]
    rows = []
    for begin in range(0, len(found), 3):
        row = Image.new("RGB", (3 * (found[0].width + GAP) - GAP, found[0].height), "white")
        for k, one in enumerate(found[begin : begin + 3]):
            row.paste(one, (k * (one.width + GAP), 0))
        rows.append(row)
    return rows


def _screen(channels: Sequence[ProjectorChannel]) -> Bytes:
    """The screen with the light of all projectors: unrolled, or a dome as a fisheye."""
    screens = [one.screen for one in channels if one.screen is not None]
    first, last = screens[0], screens[-1]
    if isinstance(first, Curved) and isinstance(last, Curved):
        across = WIDE
        high = round(across * (first.top - first.bottom) / first.radius / (last.right - first.left))
        turn, y = np.meshgrid(
            np.linspace(first.left, last.right, across), np.linspace(first.top, first.bottom, high)
        )
        ways = np.stack([first.radius * np.sin(turn), y, first.radius * np.cos(turn)], axis=-1)
    else:
        x, y = np.meshgrid(np.arange(DOME) + 0.5, DOME - np.arange(DOME) - 0.5)
        pixels = np.stack([x.ravel(), y.ravel()], axis=1)
        ways = directions("dome", (DOME, DOME), Surround(tilt_deg=0.0), pixels)
        ways = ways.reshape(DOME, DOME, 3)
    light = np.zeros(ways.shape)
    for number in range(len(channels)):
        light += _light(channels, number, ways.reshape(-1, 3)).reshape(ways.shape)
    return np.asarray((255 * np.clip(light, 0, 1) ** (1 / GAMMA)).astype(np.uint8))


def _light(channels: Sequence[ProjectorChannel], number: int, ways: Array) -> Array:
    """The light (n, 3) of a projector's pattern in directions (n, 3)."""
    one = channels[number]
    assert one.screen is not None
    width, height = one.place[2:]
    shown = (pattern((width, height), number + 1) / 255.0) ** GAMMA
    places = places_on(one.screen, ways)
    with np.errstate(invalid="ignore"):
        lit = ((places >= 0) & (places <= 1)).all(axis=1)
    x = np.minimum(places[lit, 0] * width, width - 1).astype(int)
    y = np.minimum((1 - places[lit, 1]) * height, height - 1).astype(int)
    lamps = [Projector(other.screen, GAMMA, 0.0) for other in channels if other.screen]
    found = np.zeros((len(ways), 3))
    found[lit] = shown[y, x] * light_shares(lamps, number, places[lit])[:, None]
    return found


if __name__ == "__main__":
    main()
