"""Look at a scenario from five viewpoints: `python tools/viewpoints.py OUT [SCENARIO…]`.

Five views: the start of the pilot, a near reef, the largest school, the surface from below, and the
place from above. A picture of each, a sheet for each scenario, and one contact sheet with a row for
each scenario and preset.

`--around CM` looks outward in eight directions instead, that far from the start, and prints the
share of pixels with structure: those whose neighbourhood has contrast, and those that show a thing
other than water, surface and sand.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from subsea.base.files import check_folder
from subsea.base.system import resource_names
from subsea.dive.start import headless, picture_maker, start_world
from subsea.frame.packet import pack
from subsea.geometry.solids import height_at
from subsea.rendering.gl.id_buffer import SEABED, SURFACE, WATER
from subsea.rendering.output.quality import PRESETS
from subsea.submarine.vessel import NEUTRAL
from subsea.view.display_rigs import display_rig, views_for
from subsea.view.rig import CameraPose, pose_from_angles
from subsea.world.step import step
from subsea.world.world import TICK_S, World

Array = NDArray[np.float64]

CLEAR_CM = 45.0  # of the eye above the seabed
ABOVE = 0.55  # farthest distance of the view from above, as a share of the visibility
THUMB = 400  # width of a picture in the contact sheet, pixels
DIRECTIONS = {
    "E": 0.0,
    "NE": 45.0,
    "N": 90.0,
    "NW": 135.0,
    "W": 180.0,
    "SW": 225.0,
    "S": 270.0,
    "SE": 315.0,
}
EYE_CM = 190.0  # greatest height of the eye above the seabed, when it looks around
INWARD = 0.93  # of the radius of the sea: no eye is farther out
AROUND_PX, CONTRAST = 4, 4.0  # half a neighbourhood, pixels; deviation of brightness, of 255


def viewpoints(world: World) -> Iterator[tuple[str, CameraPose]]:
    """Names of the viewpoints and the poses of the eye."""
    sub, sea = world.state.submarine, world.state.sea
    start = np.asarray(sub.position, np.float64)
    yield "start", pose_from_angles(start, float(sub.angles[0]), 0.0)
    fishes = world.state.fishes
    centre = np.asarray(np.median(fishes.position, axis=0), np.float64)
    centre[2] = height_at(sea.heights, sea.half_width, centre[0], centre[1])
    aside = 60.0  # cm, so that no viewpoint lies in the rock
    if len(sea.rocks):
        near = np.linalg.norm(sea.rocks[:, :2] - start[:2], axis=1)
        centre = np.asarray(sea.rocks[near.argmin(), :3], np.float64)
        aside = max(aside, float(sea.rocks[near.argmin(), 3:6].max()))
    eye = centre + (-110.0 - 1.4 * aside, -30.0 - 1.4 * aside, 60.0)
    yield "reef", _looking_at(world, eye, centre + (0.0, 0.0, 25.0))
    numbers = np.bincount(fishes.species[fishes.alive])
    places = fishes.position[fishes.alive & (fishes.species == numbers.argmax())]
    middle = places[np.linalg.norm(places - np.median(places, axis=0), axis=1).argmin()]
    middle = np.asarray(middle, np.float64)
    yield "school", _looking_at(world, middle + (-150.0, -120.0, -10.0), middle)
    below = centre + (-200.0 - aside, 60.0, 0.0)
    yield "up", _looking_at(world, below, below + (200.0, 60.0, 160.0))
    if not len(sea.rocks) or np.linalg.norm(centre - start) > world.scenario.water.visibility_cm:
        centre = middle  # nothing stands near: the school is the place
    far = min(12.0 * aside, ABOVE * world.scenario.water.visibility_cm)
    yield "above", _looking_at(world, centre + far * np.array([-0.68, -0.45, 0.58]), centre)


def around(world: World, away_cm: float) -> Iterator[tuple[str, CameraPose]]:
    """Yield eight poses `away_cm` from the start, each looks outward and a little down."""
    sub, sea = world.state.submarine, world.state.sea
    x, y, z = np.asarray(sub.position, np.float64)
    for name, degrees in DIRECTIONS.items():
        turn = np.radians(degrees)
        eye = np.array([x + away_cm * np.cos(turn), y + away_cm * np.sin(turn), z])
        eye[:2] *= min(1.0, INWARD * sea.radius / max(float(np.hypot(*eye[:2])), 1.0))
        ground = height_at(sea.heights, sea.half_width, float(eye[0]), float(eye[1]))
        eye[2] = np.clip(eye[2], ground + CLEAR_CM, max(ground + EYE_CM, z))
        yield name, pose_from_angles(eye, turn, np.radians(-8.0))


def structure(picture: NDArray[np.uint8], kind: NDArray[Any]) -> tuple[float, float]:
    """Measure the shares of pixels with local contrast, and of those that show a thing."""
    grey = picture.astype(np.float64).mean(axis=2)
    side = 2 * AROUND_PX + 1
    windows = np.lib.stride_tricks.sliding_window_view(grey, (side, side))
    thing = ~np.isin(kind, (WATER, SURFACE, SEABED))
    return float((windows.std(axis=(2, 3)) > CONTRAST).mean()), float(thing.mean())


def _looking_at(world: World, eye: Array, target: Array) -> CameraPose:
    sea = world.state.sea
    ground = height_at(sea.heights, sea.half_width, float(eye[0]), float(eye[1]))
    eye = np.array([eye[0], eye[1], np.clip(eye[2], ground + CLEAR_CM, -40.0)])
    x, y, z = target - eye
    return pose_from_angles(eye, float(np.arctan2(y, x)), float(np.arctan2(z, np.hypot(x, y))))


def main() -> None:
    """Render what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path, help="a folder for the pictures")
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="default: all")
    parser.add_argument("--seconds", type=float, default=8.0, help="of the world before them")
    parser.add_argument("--size", default="960x540", help="of each picture, in pixels")
    parser.add_argument("--quality", choices=sorted(PRESETS), nargs="+", default=["high"])
    parser.add_argument("--only", help="name of one viewpoint")
    parser.add_argument("--around", type=float, metavar="CM", help="look outward from there")
    arguments = parser.parse_args()
    wide, high = (int(side) for side in arguments.size.split("x"))
    size = wide, high
    check_folder(arguments.out)
    arguments.out.mkdir(parents=True, exist_ok=True)
    names = arguments.scenarios or resource_names("assets/scenarios", ".toml")
    rows: list[list[Image.Image]] = []
    with headless() as context:
        for name in names:
            world = start_world(name)
            for _ in range(round(arguments.seconds / TICK_S)):
                step(world, NEUTRAL)
            for preset in arguments.quality:
                outward = arguments.around is not None
                eyes = around(world, arguments.around) if outward else viewpoints(world)
                pictures, shares = draw(context, world, size, preset, eyes, arguments.only)
                if outward:
                    contrast, things = np.mean(shares, axis=0)
                    print(f"{name}: contrast {contrast:.1%}, things {things:.1%} of pixels")
                stem = name if len(arguments.quality) == 1 else f"{name}-{preset}"
                for title, picture in pictures.items():
                    picture.save(arguments.out / f"{stem}-{title}.png")
                rows.append([*pictures.values()])
                sheet_of([rows[-1][k : k + 2] for k in range(0, len(rows[-1]), 2)], size[0]).save(
                    arguments.out / f"{stem}.png"
                )
                print(arguments.out / f"{stem}.png")
    sheet_of(rows, THUMB).save(arguments.out / "contact.png")
    print(arguments.out / "contact.png")


def draw(
    context: Any, world: World, size: tuple[int, int], preset: str,
    eyes: Iterator[tuple[str, CameraPose]], only: str | None,
) -> tuple[dict[str, Image.Image], list[tuple[float, float]]]:  # fmt: skip
    """Pictures of the viewpoints, or of the only one, by their names; and their structure."""
    quality, pictures = PRESETS[preset], {}
    shares = []
    with picture_maker(context, world, display_rig("mono", size), quality) as renderer:
        for title, eye in eyes:
            if only in (None, title):
                packet = pack(world, views_for("mono", size, eye), 1.0, quality.packing)
                renderer.draw(packet)
                picture = renderer.read_pixels()
                shares.append(structure(picture, renderer.id_maps(packet).kind))
                pictures[title] = Image.fromarray(picture)
    return pictures, shares


def sheet_of(rows: list[list[Image.Image]], wide: int) -> Image.Image:
    """All pictures in rows, each `wide` pixels wide."""
    first = rows[0][0]
    high = round(wide * first.height / first.width)
    sheet = Image.new("RGB", (wide * max(map(len, rows)), high * len(rows)))
    for i, row in enumerate(rows):
        for j, picture in enumerate(row):
            sheet.paste(picture.resize((wide, high)), (j * wide, i * high))
    return sheet


if __name__ == "__main__":
    main()
