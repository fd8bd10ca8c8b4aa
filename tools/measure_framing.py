"""Measure how tours frame: `python tools/measure_framing.py [SCENARIO…]`.

Prints for each tour of a scenario, the autopilot first, the share of frames with a subject, and the
fastest turn of the view. A subject is a fish, or a group of fishes close together in the picture,
whose box covers a twentieth of the picture or more and does not touch its border. Boxes come from
the maps of identity. Cuts do not count as turns.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from subsea.base.arrays import Array
from subsea.base.system import resource_names
from subsea.dive.directed_camera import endless_tour, is_directed
from subsea.dive.start import headless, picture_maker, start_world
from subsea.frame.packet import pack
from subsea.rendering.gl.id_buffer import FISH, IdMaps
from subsea.rendering.output.quality import PRESETS
from subsea.scenario.schema import AUTOPILOT, DIRECTED, Scenario
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.world.step import step
from subsea.world.world import TICK_S

SIZE = 256, 144
LEAST = 1.0 / 20.0  # share of the picture of a subject's box
BESIDE = 1.5  # of the size of the smaller of two fishes: the gap within which they are a group
FIRST_S = 6.0  # before it the submarine is on its way to its first subject
LEAST_PX = 8  # smaller fishes are specks
ACROSS = 6  # pictures in a row of a sheet


def tours_of(scenario: Scenario) -> list[str]:
    """Names of all tours of a scenario, the autopilot first."""
    directed = [DIRECTED] if is_directed(scenario) else []
    return [AUTOPILOT, *directed, *(tour.name for tour in scenario.tour)]


def boxes_of(maps: IdMaps) -> Array:
    """The boxes (n, 4) of all fishes larger than a speck: left, top, right, bottom."""
    fish = maps.kind == FISH
    boxes = []
    for number in np.unique(maps.number[fish]):
        rows, columns = np.nonzero(fish & (maps.number == number))
        if len(rows) >= LEAST_PX:
            boxes.append((columns.min(), rows.min(), columns.max() + 1, rows.max() + 1))
    return np.array(boxes, np.float64).reshape(-1, 4)


def groups_of(boxes: Array) -> Array:
    """The boxes of groups of fishes: neighbours are joined until all groups are apart."""
    sizes = np.maximum(boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1])
    group = np.arange(len(boxes))
    for i, one in enumerate(boxes):
        for j, other in enumerate(boxes[:i]):
            gap = max(*(np.maximum(one[:2], other[:2]) - np.minimum(one[2:], other[2:])))
            if gap < BESIDE * min(sizes[i], sizes[j]):
                group[group == group[i]] = group[j]
    each = [boxes[group == k] for k in np.unique(group)]
    whole = [(*own[:, :2].min(axis=0), *own[:, 2:].max(axis=0)) for own in each]
    return np.array(whole, np.float64).reshape(-1, 4)


def subject_of(maps: IdMaps) -> Array | None:
    """The largest box (4,) of an uncut fish or group of at least `LEAST` of the picture, if any."""
    high, wide = maps.kind.shape
    alone = boxes_of(maps)
    boxes = np.concatenate([alone, groups_of(alone)])
    share = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1]) / (wide * high)
    whole = (boxes[:, :2] > 0).all(axis=1) & (boxes[:, 2] < wide) & (boxes[:, 3] < high)
    share = np.where(whole, share, 0.0)
    return boxes[share.argmax()] if share.max(initial=0.0) >= LEAST else None


def measured(
    scenario: str, tour: str, seed: int | None, seconds: float, every_s: float,
    pictures: list[Image.Image],
) -> tuple[list[bool], float]:  # fmt: skip
    """Play a tour; return whether each frame has a subject, and the fastest turn, rad/s.

    Adds each frame to `pictures`, with a frame about its subject.
    """
    quality = PRESETS["low"]
    framed: list[bool] = []
    fastest = 0.0
    world = start_world(scenario, seed)
    with headless() as context:
        steer = endless_tour(world, tour)
        with picture_maker(context, world, display_rig("mono", SIZE), quality) as renderer:
            for tick in range(round(seconds / TICK_S)):
                step(world, steer(world))
                fastest = max(fastest, float(np.hypot(*world.state.submarine.rates)))
                if tick % round(every_s / TICK_S) == 0 and tick * TICK_S >= FIRST_S:
                    eye = cockpit(world.state.submarine, 1.0)
                    packet = pack(world, views_for("mono", SIZE, eye), 1.0, quality.packing)
                    renderer.draw(packet)
                    pictures.append(Image.fromarray(renderer.read_pixels()))
                    subject = subject_of(renderer.id_maps(packet))
                    framed.append(subject is not None)
                    if subject is not None:
                        box = tuple(subject.astype(int).tolist())
                        ImageDraw.Draw(pictures[-1]).rectangle(box, outline=(255, 255, 0))
    return framed, fastest


def sheet_of(pictures: list[Image.Image]) -> Image.Image:
    """All pictures in rows."""
    wide, high = pictures[0].size
    sheet = Image.new("RGB", (ACROSS * wide, -(-len(pictures) // ACROSS) * high))
    for k, picture in enumerate(pictures):
        sheet.paste(picture, (k % ACROSS * wide, k // ACROSS * high))
    return sheet


def chosen(names: list[str], tour: str | None) -> Iterator[tuple[str, str]]:
    """Yield each scenario with each of its tours, or with the given one."""
    from subsea.scenario.load import load_scenario

    for name in names or resource_names("assets/scenarios", ".toml"):
        for each in tours_of(load_scenario(name).scenario):
            if tour in (None, each):
                yield name, each


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="default: all")
    parser.add_argument("--tour", help=f"measure this tour alone, such as {AUTOPILOT}")
    parser.add_argument("--seeds", type=int, nargs="+", help="of the world; default: its own")
    parser.add_argument("--seconds", type=float, default=60.0, help="of each tour")
    parser.add_argument("--every", type=float, default=2.0, help="seconds between frames")
    parser.add_argument("--sheets", type=Path, help="folder for a sheet of frames of each tour")
    arguments = parser.parse_args()
    tours = list(chosen(arguments.scenarios, arguments.tour))
    if not tours:
        parser.error(f"no such tour: {arguments.tour}")
    for name, tour in tours:
        for seed in arguments.seeds or [None]:
            pictures: list[Image.Image] = []
            framed, fastest = measured(
                name, tour, seed, arguments.seconds, arguments.every, pictures
            )
            title = f"{name} {tour}" if seed is None else f"{name} {tour} {seed}"
            share = f"{np.mean(framed):.0%} of {len(framed)} frames"
            print(f"{title}: {share}, turns at most {np.degrees(fastest):.1f}°/s", flush=True)
            if arguments.sheets:
                arguments.sheets.mkdir(parents=True, exist_ok=True)
                sheet_of(pictures).save(arguments.sheets / f"{title.replace(' ', '-')}.png")


if __name__ == "__main__":
    main()
