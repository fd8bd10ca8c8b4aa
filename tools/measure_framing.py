"""Measure how the autopilot frames: `python tools/measure_framing.py [SCENARIO…]`.

Prints, for each scenario, the share of frames with a subject: a fish, or fishes close together on
the picture, whose box covers 3% to 30% of the picture and does not touch its border. By the maps of
identity, every two seconds.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

from subsea.base.system import resource_names
from subsea.dive.start import headless, picture_maker, start_world
from subsea.dive.tour import Tour
from subsea.frame.packet import pack
from subsea.rendering.gl.id_buffer import FISH, IdMaps
from subsea.rendering.output.quality import PRESETS
from subsea.view.display_rigs import cockpit, display_rig, views_for
from subsea.world.step import step
from subsea.world.world import TICK_S

SIZE = 320, 180
SUBJECT = 0.03, 0.30  # share of the picture
BESIDE = 0.6  # of the size of two fishes: how near they belong together
EVERY_S = 2.0
LEAST_PX = 12  # smaller fishes are specks

Boxes = NDArray[np.float64]  # (n, 4): left, top, right, bottom


def boxes_of(maps: IdMaps) -> Boxes:
    """The box of each fish that is larger than a speck."""
    fish = maps.kind == FISH
    boxes = []
    for number in np.unique(maps.number[fish]):
        rows, columns = np.nonzero(fish & (maps.number == number))
        if len(rows) >= LEAST_PX:
            boxes.append((columns.min(), rows.min(), columns.max() + 1, rows.max() + 1))
    return np.array(boxes, np.float64).reshape(-1, 4)


def groups_of(boxes: Boxes) -> Boxes:
    """The boxes of fishes close together, joined until all are apart."""
    joined = [*boxes]
    sizes = [max(box[2] - box[0], box[3] - box[1]) for box in joined]
    group = np.arange(len(joined))
    for i, one in enumerate(joined):
        for j, other in enumerate(joined[:i]):
            gap = max(*(np.maximum(one[:2], other[:2]) - np.minimum(one[2:], other[2:])))
            if gap < BESIDE * (sizes[i] + sizes[j]) / 2:
                group[group == group[i]] = group[j]
    each = [boxes[group == k] for k in np.unique(group)]
    whole = [(*own[:, :2].min(axis=0), *own[:, 2:].max(axis=0)) for own in each]
    return np.array(whole, np.float64).reshape(-1, 4)


def has_subject(maps: IdMaps) -> bool:
    """True if a fish or a group of fishes is framed whole, neither tiny nor too near."""
    high, wide = maps.kind.shape
    alone = boxes_of(maps)
    boxes = np.concatenate([alone, groups_of(alone)])
    share = (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1]) / (wide * high)
    whole = (boxes[:, :2] > 0).all(axis=1) & (boxes[:, 2] < wide) & (boxes[:, 3] < high)
    return bool((whole & (share >= SUBJECT[0]) & (share <= SUBJECT[1])).any())


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenarios", nargs="*", metavar="SCENARIO", help="default: all")
    parser.add_argument("--seconds", type=float, default=60.0, help="of the dive")
    arguments = parser.parse_args()
    quality = PRESETS["low"]
    with headless() as context:
        for name in arguments.scenarios or resource_names("assets/scenarios", ".toml"):
            world, tour, framed = start_world(name), Tour(), []
            with picture_maker(context, world, display_rig("mono", SIZE), quality) as renderer:
                for tick in range(round(arguments.seconds / TICK_S)):
                    step(world, tour.helm(world))
                    if tick % round(EVERY_S / TICK_S) == 0 and tick * TICK_S >= 6.0:
                        eye = cockpit(world.state.submarine, 1.0)
                        packet = pack(world, views_for("mono", SIZE, eye), 1.0, quality.packing)
                        renderer.draw(packet)
                        framed.append(has_subject(renderer.id_maps(packet)))
            print(f"{name}: {np.mean(framed):.0%} of {len(framed)} frames")


if __name__ == "__main__":
    main()
